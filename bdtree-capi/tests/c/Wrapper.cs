// Calls every function of the C# files and compares it with a known answer or another way to ask: Wrapper GOLDEN_FOLDER
// BEAM.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Runtime.CompilerServices;
using System.Runtime.InteropServices;
using Bdtree;

static class Wrapper
{
    static void Require(bool holds, [CallerLineNumber] int line = 0)
    {
        if (!holds)
            throw new InvalidOperationException("Wrapper.cs:" + line);
    }

    static Status StatusOf(Action call)
    {
        try
        {
            call();
        }
        catch (BdtreeException error)
        {
            return error.Status;
        }
        return Status.Ok;
    }

    static bool Near(double a, double b) { return Math.Abs(a - b) <= 1e-9 * (1.0 + Math.Abs(b)); }

    static bool Near(Vec3 a, Vec3 b) { return Near(a.X, b.X) && Near(a.Y, b.Y) && Near(a.Z, b.Z); }

    static Transform At(double x, double y = 0.0, double z = 0.0)
    {
        return new Transform { Rotation = Quat.Identity, Translation = new Vec3(x, y, z), Scale = 1.0 };
    }

    static Ray Down(double x, double z) { return new Ray(new Vec3(x, 5.0, z), new Vec3(0.0, -1.0, 0.0)); }

    [DllImport("bdtree")] static extern int bdt_checks_handles();

    static void OfTheLibrary()
    {
        Require(Library.LastError == "");
        Require(Library.VersionText.StartsWith(Library.Version / 1000000 + "." + Library.Version / 1000 % 1000 + "."));
        Require(Library.StatusText(Status.Ok) != Library.StatusText(Status.ErrorBusy));
        // A text that is longer than the first try.
        string path = new string('x', 9000);
        Require(StatusOf(() => Model.Load(path)) == Status.ErrorIo && Library.LastError.Contains(path));
        Require(Library.ChecksHandles == (bdt_checks_handles() == 1));

        Shape ball = Shape.Ball(new Vec3(1.0, 2.0, 3.0), 4.0);
        Require(ball.Kind == 1 && ball.A.Z == 3.0 && ball.Size == 4.0);
        Require(Shape.Capsule(new Vec3(), new Vec3(0.0, 1.0, 0.0), 0.5).B.Y == 1.0);
        Require(Shape.Cuboid(new Vec3(), Quat.Identity, new Vec3(1.0, 2.0, 3.0)).B.Z == 3.0);
        Require(Shape.HalfSpace(new Vec3(0.0, 2.0, 0.0), 1.5).Size == 1.5);
        Transform twice = At(1.0);
        twice.Scale = 2.0;
        Require(Near(twice.After(At(0.0, 3.0)).Translation, new Vec3(1.0, 6.0, 0.0)));
        Require(StatusOf(() => new Transform().After(twice)) == Status.ErrorPose);
        Matrix joint = new Matrix { M00 = 1.0, M03 = 5.0, M11 = 1.0, M13 = 6.0, M22 = 1.0, M23 = 7.0 };
        Require(Near(At(1.0).JointInModel(joint).M03, 4.0));
    }

    static void Models(string golden)
    {
        byte[] bytes = File.ReadAllBytes(golden + "/sphere.bdt");
        using (Model sphere = Model.Load(golden + "/sphere.bdt"), copy = Model.FromMemory(bytes))
        {
            uint[] triangles = sphere.Triangles();
            Require(triangles.Length == 576 && copy.Triangles().SequenceEqual(triangles));
            Require(sphere.Triangles(2, 1).SequenceEqual(triangles.Skip(6).Take(3)));
            Require(StatusOf(() => sphere.Triangles(190, 3)) == Status.ErrorIndex);
            sphere.Verify();
            sphere.VerifyChecksums();
            Require(sphere.Mode(1).QLimit == 1024.0f && sphere.ModeName(1) == "field 1");
            Require(Math.Abs(sphere.Mass().MassKg - 3890.71) < 0.01);
            Require(sphere.Group(0).Kind == GroupKind.Object && sphere.GroupName(0) != "");
        }
        using (Model animated = Model.Read(golden + "/animated.bdt"))
        {
            float[] last = new float[2], sampled = new float[2];
            animated.Frame(0, last);
            animated.Frame(3, last, out double timeS);
            animated.Sample(timeS, sampled);
            Require(timeS == animated.Info.DurationS && sampled.SequenceEqual(last));
            Require(StatusOf(() => animated.Frame(0, new float[1])) == Status.ErrorLength);
            Require(StatusOf(() => new SkeletonPose(animated)) == Status.ErrorNoSkin);
        }
    }

    static void Characters(string golden)
    {
        using (Model model = Model.Read(golden + "/skinned.bdt"))
        using (SkeletonPose pose = new SkeletonPose(model))
        using (Instance one = new Instance(model), other = new Instance(model, 0, 0))
        {
            Require(model.ModeName(0) == "bulge" && model.ModeIndex("bulge") == 0);
            Require(model.ClipName(1) == "slide" && model.ClipIndex("slide") == 1 && model.ClipDuration(0) == 1.5);
            Require(StatusOf(() => model.ClipIndex("none")) == Status.ErrorIndex);
            int[] joints = Enumerable.Range(0, (int)model.Info.JointCount).ToArray();
            Require(joints.All(joint => model.JointIndex(model.JointName(joint)) == joint));
            Require(joints.Count(joint => model.JointParent(joint) == Library.None) == 1);
            Require(model.JointOf(new Hit { Barycentric = new Vec3(1.0, 0.0, 0.0) }) < joints.Length);

            Require(pose.Q().SequenceEqual(new[] { 0.25f }));
            Require(pose.Nodes().Length == model.Info.SkeletonNodeCount);
            Matrix[] rest = pose.Joints();
            pose.Blend(0, 0.7, 1.0);
            double blended = pose.Joints()[3].M03;
            pose.Rest();
            Require(pose.Joints().SequenceEqual(rest));
            pose.Play(0, 0.7);
            Require(Near(pose.Joints()[3].M03, blended) && !pose.Joints().SequenceEqual(rest));
            pose.SetLocal(0, pose.GetLocal(0));
            pose.Update();
            one.SetPose(pose);
            other.SetPose(pose.Q(), pose.Joints(), Transform.Identity);
            Vec3[] first = new Vec3[model.Info.VertexCount], second = new Vec3[model.Info.VertexCount];
            one.Vertices(0, first);
            other.Vertices(0, second);
            Require(first.SequenceEqual(second));
            other.SetJoints(rest);
            Require(!other.ExactAabb.Equals(one.ExactAabb));
            Matrix identity = new Matrix { M00 = 1.0, M11 = 1.0, M22 = 1.0 };
            one.SetSkinningMatrices(Enumerable.Repeat(identity, (int)model.Info.BoneCount).ToArray());
            Require(Near(one.ExactAabb.Max.X, 8.0)); // of the bind box
            Require(StatusOf(() => one.SetJoints(new Matrix[0])) == Status.ErrorLength);
        }
    }

    static void Instances(Model sphere)
    {
        using (Instance body = new Instance(sphere))
        {
            body.SetQ(new[] { 0.25f, 0.0f, 0.125f });
            Require(body.Q().SequenceEqual(new[] { 0.25f, 0.0f, 0.125f }));
            body.SetRefining(true);
            body.Placement = At(3.0);
            Require(body.Placement.Translation.X == 3.0 && body.Tags.CollisionMask == uint.MaxValue);
            body.Tags = new Tags { UserData = 7, CollisionGroup = 1, CollisionMask = 2 };
            Require(body.Tags.UserData == 7 && body.Tags.CollisionMask == 2);
            Require(body.Aabb.Min.X <= body.ExactAabb.Min.X && body.BoundingSphere.Radius >= 1.0);
            // A cache of nodes keeps what the first of two queries has computed.
            foreach (int nodes in new[] { 0, 64 })
                using (Workspace workspace = new Workspace())
                using (Instance cached = new Instance(sphere, nodes, 64 - nodes))
                {
                    workspace.CastRay(cached, Down(0.1, 0.2));
                    workspace.CastRay(cached, Down(0.1, 0.2));
                    Require((workspace.Stats.NodesUpdated == 0) == (nodes == 64));
                }
            Require(StatusOf(() => new Instance(sphere, 1 << 25, 0)) == Status.ErrorArgument);
            Vec3 third = new Vec3(1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0), force = new Vec3(1.0, 2.0, 3.0);
            double[] forces = new double[3];
            body.AddGeneralizedForce(5, third, force, forces);
            double once = forces[0];
            body.AddGeneralizedForce(5, third, force, forces);
            Require(once != 0.0 && Near(forces[0], 2.0 * once));
            Require(StatusOf(() => body.AddGeneralizedForce(192, third, force, forces)) == Status.ErrorIndex);
        }
    }

    static void CallbacksOf(Workspace workspace, Instance body, Instance other)
    {
        Shape shape = Shape.Ball(new Vec3(1.0, 0.0, 0.0), 1.0);
        List<Contact> taken = new List<Contact>();
        Require(workspace.ContactsEach(body, shape, contact =>
        {
            taken.Add(contact);
            GC.Collect(); // what C holds stays where it is
            return true;
        }));
        Require(taken.Count > 1 && taken.SequenceEqual(workspace.Contacts(body, shape)));
        int count = 0;
        Require(!workspace.ContactsEach(body, shape, contact => ++count < 2) && count == 2);
        count = 0;
        try
        {
            workspace.ContactsEach(body, shape, contact =>
            {
                count++;
                throw new ArithmeticException("out of the callback");
            });
            Require(false);
        }
        catch (ArithmeticException error)
        {
            Require(error.Message == "out of the callback" && count == 1);
        }
        // An exception of a call that is not allowed there comes out as well, and the workspace goes on.
        Require(StatusOf(() => workspace.ContactsEach(body, shape, c => workspace.Intersects(body, shape))) ==
            Status.ErrorBusy);
        Require(StatusOf(() => workspace.ContactsEach(body, Shape.Ball(new Vec3(), -1.0), c => true)) ==
            Status.ErrorArgument);

        List<Hit> hits = new List<Hit>();
        Require(workspace.CastRayAllEach(body, Down(0.1, 0.2), hit => { hits.Add(hit); return true; }));
        Require(hits.Count == 2 && hits.SequenceEqual(workspace.CastRayAll(body, Down(0.1, 0.2))));
        Require(!workspace.CastRayAllEach(body, Down(0.1, 0.2), hit => false));
        using (Front front = new Front())
        {
            count = 0;
            Require(workspace.PairContactsEach(body, other, pair => { count++; return true; }, 0.0, front));
            Require(count > 2 && count == workspace.PairContacts(body, other, 0.0, front).Length);
        }
        Require(!workspace.PairContactsEach(body, other, pair => false));
    }

    static void Queries(Workspace workspace, Instance body, Instance far)
    {
        // As many hits as one by one: more than the first try has room for.
        Ray[] rays = Enumerable.Range(0, 100).Select(i => Down(-1.2 + 0.024 * i, 0.013)).ToArray();
        Hit[] first = new Hit[100], nearest = new Hit[100], grid = new Hit[200], all = workspace.CastRaysAll(body, rays);
        byte[] isMet = new byte[100];
        Instance[] both = { far, body };
        workspace.CastRays(body, rays, first);
        workspace.IntersectsRays(body, rays, isMet);
        workspace.CastRaysAtInstances(both, rays, grid);
        workspace.CastRaysNearest(both, rays, nearest);
        List<uint> single = new List<uint>();
        for (int k = 0; k < rays.Length; k++)
        {
            Hit hit = workspace.CastRay(body, rays[k]);
            Require(hit.IsHit == (isMet[k] == 1) && workspace.IntersectsRay(body, rays[k]) == hit.IsHit);
            Require(first[k].Triangle == hit.Triangle && nearest[k].Triangle == hit.Triangle);
            Require(!grid[k].IsHit && grid[100 + k].Triangle == hit.Triangle && (!hit.IsHit || nearest[k].Index == 1));
            single.AddRange(workspace.CastRayAll(body, rays[k]).Select(met => met.Triangle));
        }
        Require(all.Length > 100 && all.Select(hit => hit.Triangle).SequenceEqual(single));
        try
        {
            workspace.CastRaysAtInstances(both, rays, first);
            Require(false);
        }
        catch (ArgumentException)
        {
        }

        Shape shape = Shape.Capsule(new Vec3(0.0, 1.0, 0.0), new Vec3(0.0, 2.0, 0.0), 0.25);
        Require(workspace.Intersects(body, shape) && !workspace.Intersects(far, shape));
        Require(!workspace.ProjectPoint(body, new Vec3(0.0, 5.0, 0.0), 1.0).IsHit);
        Plane[] above = { new Plane { Normal = new Vec3(0.0, 1.0, 0.0), D = 50.0 } };
        Require(workspace.FrustumState(body, above) == Region.Inside);
        above[0].D = -50.0;
        Require(workspace.FrustumState(body, above) == Region.Outside);

        Shape allOfIt = Shape.Cuboid(new Vec3(), Quat.Identity, new Vec3(9.0, 9.0, 9.0));
        Require(workspace.LevelSpheres(body, 0, allOfIt).Length == 7); // as many as level 0 has
        Require(workspace.LevelSpheres(body, 1, allOfIt).Length >= 55);
        workspace.SetMaxLevels(0);
        Require(workspace.Contacts(body, allOfIt).Length == 0 && workspace.Proxies().Length == 7);
        workspace.SetMaxLevels(-1);
        workspace.SetMaxVisits(1);
        workspace.ProjectPoint(body, new Vec3(0.0, 5.0, 0.0));
        Require(workspace.Bound.IsComplete == 0 && workspace.Bound.AtLeast < 5.0 && workspace.Stats.NodesVisited == 1);
        workspace.SetMaxVisits(0);
        workspace.SetShared(true);
        Require(workspace.Contacts(body, allOfIt).Length == 192);
        workspace.SetShared(false);
    }

    static void Pairs(Workspace workspace, Model model, Instance body, Instance other, Instance far)
    {
        PairContact[] contacts = workspace.PairContacts(body, other);
        Require(workspace.PairIntersects(body, other) && !workspace.PairIntersects(body, far));
        Require(workspace.PairTriangles(body, other).Length == contacts.Length);
        Manifold[] regions = workspace.PairManifolds(body, other);
        Require(regions.Length > 0 && workspace.PairCondense(body, other, contacts).SequenceEqual(regions));
        contacts[0].Triangle1 = 1000;
        Require(StatusOf(() => workspace.PairCondense(body, other, contacts)) == Status.ErrorArgument);
        Require(StatusOf(() => workspace.PairContacts(body, body)) == Status.ErrorBusy);
        Instance disposed = new Instance(model);
        disposed.Dispose();
        try
        {
            workspace.InstancePairs(new[] { body, disposed });
            Require(false);
        }
        catch (ObjectDisposedException)
        {
        }

        Require(workspace.PairDistance(body, other) == 0.0);
        Require(workspace.PairDistance(body, far) == workspace.PairClosestPoints(body, far).Distance);
        Require(workspace.PairDistance(body, far, 1.0) == null && !workspace.PairClosestPoints(body, far, 1.0).IsHit);
        // The root is node 0.
        LanePair[] lanes = workspace.PairLevelSpheres(body, other, 0, 1, 0.1);
        Require(lanes.Length > 32 && lanes.All(pair => pair.First.Node == 0 && pair.Second.Node != 0));
        Require(workspace.PairLevelSpheres(body, far, 0, 1).Length == 0);
        LaneTriangle[] triangles = workspace.PairLevelTriangles(body, other, 1, 0.1);
        Require(triangles.Length > 32 && triangles.All(pair => pair.Lane.Node != 0 && pair.Triangle < 192));
        Require(workspace.PairLevelTriangles(body, far, 0).Length == 0);
        Require(workspace.PairLevelTriangles(body, far, 0, 200.0).Length == 7 * 192);

        Sphere[] spheres = new[] { 0.0, 5.0, 1.5 }.Select(x => new Sphere { Center = new Vec3(x, 0.0, 0.0), Radius = 1.0 })
            .ToArray();
        IndexPair[] near = workspace.SpherePairs(spheres);
        Require(near.Length == 1 && near[0].First == 0 && near[0].Second == 2);
        Require(workspace.SpherePairs(spheres, 10.0).Length == 3);
        Instance[] all = { far, body, other };
        near = workspace.InstancePairs(all);
        Require(near.Length == 1 && near[0].First == 1 && near[0].Second == 2);
        other.Tags = new Tags { CollisionGroup = 1, CollisionMask = 1 };
        body.Tags = new Tags { CollisionGroup = 2, CollisionMask = 2 };
        Require(workspace.InstancePairs(all).Length == 0);
    }

    static void Worlds(Model beam)
    {
        WorldOptions options = WorldOptions.Usual;
        options.SleepSpeed = 0.0;
        using (World world = new World(options))
        {
            world.AddPlane(new Plane { Normal = new Vec3(0.0, 1.0, 0.0) });
            uint kind = world.AddModel(beam);
            uint body = world.AddBody(kind, At(0.0, 3.0)), driven = world.AddBody(kind, At(50.0, 9.0), BodyFrame.Driven);
            double[] zero = new double[3];
            Require(world.ModeCount(body) == 3);
            Require(StatusOf(() => world.AddBody(kind + 1, Transform.Identity)) == Status.ErrorIndex);

            world.SetModes(body, new[] { 0.01, 0.0, 0.0 }, new[] { 0.0, 0.5, 0.0 });
            Require(Near(world.Q(body)[0], 0.01) && Near(world.Rate(body)[1], 0.5));
            Require(StatusOf(() => world.SetModes(body, zero, new double[1])) == Status.ErrorLength);
            world.AddModalImpulse(body, new[] { 0.0, 0.0, 1.0 });
            Require(world.Rate(body)[2] != 0.0);
            world.SetModes(body, zero, zero);
            Require(world.Energy.Modal == 0.0);
            world.SetVelocity(body, new Vec3(0.0, -1.0, 0.0), new Vec3());
            Require(Near(world.Momenta.Linear, new Vec3(0.0, -beam.Mass().MassKg, 0.0)));

            // Without and with forces, from the same state.
            byte[] before = world.Save();
            world.Step();
            BodyState without = world.State(body);
            world.Restore(before);
            world.AddForce(body, new Vec3(100.0, 0.0, 0.0), new Vec3());
            world.AddModalForce(body, new[] { 10.0, 0.0, 0.0 });
            world.Drive(driven, zero, At(50.0, 9.5));
            world.Step();
            Require(world.State(body).Velocity.X > 0.0 && Near(without.Velocity.X, 0.0));
            Require(world.Q(body)[0] > 0.0 && Near(world.Placement(driven).Translation.Y, 9.5));
            Require(StatusOf(() => world.Restore(new byte[3])) == Status.ErrorState);

            bool hasLanded = false;
            for (int step = 0; step < 300 && !hasLanded; step++)
            {
                world.Step();
                hasLanded = world.Events().Any(e => e.Phase == Phase.Began && e.Body1 == body && e.Body2 == Library.None);
            }
            Require(hasLanded && world.Contacts()[0].Body1 == body);
            Require(world.Counts.Bodies == 2 && world.Counts.Asleep == 0 && world.Counts.Steps > 10);
            Require(world.TouchedBy(Shape.Ball(new Vec3(50.0, 9.5, 0.0), 50.0))[0].Body <= 1);
            Vec3 center = world.State(body).Position;
            Hit hit = world.CastRay(new Ray(new Vec3(center.X, 20.0, center.Z), new Vec3(0.0, -1.0, 0.0)));
            Require(hit.IsHit && hit.Index == body);
        }
    }

    static int Main(string[] args)
    {
        OfTheLibrary();
        Models(args[0]);
        Characters(args[0]);
        using (Model sphere = Model.Load(args[0] + "/sphere.bdt"), beam = Model.Load(args[1]))
        using (Workspace workspace = new Workspace())
        using (Instance body = new Instance(sphere), other = new Instance(sphere), far = new Instance(sphere))
        {
            Instances(sphere);
            other.SetPlacement(At(1.1, 0.2));
            far.SetPose(new float[3], At(0.0, 0.0, 100.0));
            CallbacksOf(workspace, body, other);
            Queries(workspace, body, far);
            Pairs(workspace, sphere, body, other, far);
            Worlds(beam);
        }
        Console.WriteLine("the C# files do what bdtree.h does");
        return 0;
    }
}
