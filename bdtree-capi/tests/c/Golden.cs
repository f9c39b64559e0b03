// Asks the questions of the golden files through Bdtree.cs and prints the answers as fixtures/golden has them.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Runtime.InteropServices;
using System.Text;
using Bdtree;

static class Golden
{
    static readonly Quat[] Turns =
    {
        Quat.Identity, new Quat(0.6, 0.0, 0.8, 0.0), new Quat(0.5, 0.5, 0.5, 0.5),
    };

    static readonly Quat[] JointTurns =
    {
        Quat.Identity, new Quat(0.0, 0.0, 0.28, 0.96), new Quat(0.36, 0.48, 0.0, 0.8),
    };

    // Numbers as libc writes and reads them: mono 6.8 rounds twice, and is off by one bit at times.
    [DllImport("libc.so.6")] static extern IntPtr gcvt(double x, int digits, StringBuilder text);
    [DllImport("libc.so.6")] static extern double strtod(StringBuilder text, IntPtr end);

    // The shortest decimals that read back equal, written as JSON writers of Rust do.
    static string Number(double x)
    {
        StringBuilder text = new StringBuilder(40);
        int precision = 1;
        do
            gcvt(Math.Abs(x), precision, text);
        while (strtod(text, IntPtr.Zero) != Math.Abs(x) && ++precision <= 17);
        string[] parts = text.ToString().Split('e');
        string[] halves = (parts[0] + ".").Split('.');
        string all = halves[0] + halves[1], digits = all.TrimStart('0');
        int point = halves[0].Length - (all.Length - digits.Length) + (parts.Length > 1 ? int.Parse(parts[1]) : 0);
        digits = digits.TrimEnd('0');
        string sign = BitConverter.DoubleToInt64Bits(x) < 0 ? "-" : "";
        if (x == 0.0)
            return sign + "0.0";
        if (digits.Length <= point && point <= 16)
            return sign + digits + new string('0', point - digits.Length) + ".0";
        if (point > 0 && point <= 16)
            return sign + digits.Insert(point, ".");
        if (point > -5 && point <= 0)
            return sign + "0." + new string('0', -point) + digits;
        return sign + (digits.Length > 1 ? digits.Insert(1, ".") : digits) + "e" + (point - 1);
    }

    static string List(IEnumerable<string> items) { return "[" + string.Join(",", items) + "]"; }

    static string Vector(Vec3 v) { return List(new[] { Number(v.X), Number(v.Y), Number(v.Z) }); }

    static string Contacts(Contact[] found)
    {
        return List(found.OrderBy(c => c.Triangle).Select(c => List(new[]
        {
            c.Triangle.ToString(), Vector(c.Point), Vector(c.Normal), Number(c.Distance), Vector(c.Barycentric),
        })));
    }

    static string Found(Hit hit)
    {
        return hit.IsHit
            ? List(new[] { hit.Triangle.ToString(), Vector(hit.Point), Number(hit.Distance), Vector(hit.Barycentric) })
            : "null";
    }

    static string Pairs(PairContact[] found)
    {
        IEnumerable<string> ids = found.OrderBy(p => p.Triangle1).ThenBy(p => p.Triangle2).Take(40)
            .Select(p => "[" + p.Triangle1 + "," + p.Triangle2 + "]");
        return "[" + found.Length + "," + List(ids) + "]";
    }

    static Matrix[] Turned(SkeletonPose pose, uint nodes, int step)
    {
        pose.Rest();
        for (int node = 0; node < nodes; node++)
        {
            Local local = pose.GetLocal(node);
            local.Rotation = JointTurns[step % 3];
            pose.SetLocal(node, local);
        }
        pose.Update();
        return pose.Joints();
    }

    static Transform Place(int step)
    {
        return new Transform
        {
            Rotation = Turns[step], Translation = new Vec3(step, 0.0, -0.5), Scale = 1.0 + 0.5 * step,
        };
    }

    static void Answers(string path, TextWriter to)
    {
        using (Model model = Model.Load(path))
        using (Instance body = new Instance(model), other = new Instance(model))
        using (Workspace workspace = new Workspace())
        using (SkeletonPose skeleton = model.Info.JointCount > 0 ? new SkeletonPose(model) : null)
        {
            for (int step = 0; step < 3 + 2 * (int)model.Info.FrameCount; step++)
            {
                float[] q = new float[model.Info.ModeCount];
                Transform at;
                if (step < 3)
                {
                    at = Place(step);
                    for (int j = 0; j < q.Length; j++)
                        q[j] = step * (j % 2 == 0 ? 0.25f : -0.125f);
                }
                else
                {
                    at = model.Frame((step - 3) / 2, q);
                    if ((step - 3) % 2 == 1)
                        at = Place(1).After(at);
                }
                Matrix[] joints =
                    skeleton == null ? new Matrix[0] : Turned(skeleton, model.Info.SkeletonNodeCount, step);
                body.SetPose(q, joints, at);
                Vec3 point = new Vec3(0.75, 0.5, 0.25);
                Ray ray = new Ray(new Vec3(3.0, 1.5, 0.5), new Vec3(-1.0, -0.5, -0.25), 100.0);
                Shape plane = Shape.HalfSpace(new Vec3(0.0, 3.0, 4.0), -0.75);
                Action<string, string> line = (answer, kind) =>
                    to.Write("{\"answer\":" + answer + ",\"kind\":\"" + kind + "\",\"step\":" + step + "}\n");
                line(Contacts(workspace.Contacts(body, Shape.Ball(point, 0.5))), "ball");
                line(Contacts(workspace.Contacts(body, plane)), "plane");
                line(Found(workspace.ProjectPoint(body, point)), "closest");
                line(Found(workspace.CastRay(body, ray)), "ray");
                line(Pairs(workspace.PairContacts(body, other)), "pair");
            }
        }
    }

    static int Main(string[] args)
    {
        try
        {
            Model.Load("no such file");
            return 1;
        }
        catch (BdtreeException error)
        {
            if (error.Status != Status.ErrorIo)
                return 1;
        }
        using (Stream stream = Console.OpenStandardOutput())
        using (StreamWriter to = new StreamWriter(stream, new UTF8Encoding(false)))
            Answers(args[0], to);
        return 0;
    }
}
