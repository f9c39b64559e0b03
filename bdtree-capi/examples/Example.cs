// Bake: bdtree-build chair.obj --modes 10 -o chair.bdt. Then: mcs Example.cs ../csharp/*.cs && mono Example.exe chair.bdt
using System;
using Bdtree;

static class Example
{
    static int Main(string[] args)
    {
        try
        {
            using (Model model = Model.Load(args[0]))
            using (Instance chair = new Instance(model))
            using (Workspace workspace = new Workspace())
            {
                float[] q = new float[model.Info.ModeCount];
                q[0] = 0.01f;
                chair.SetQ(q);
                Hit hit = workspace.CastRay(chair, new Ray(new Vec3(0.1, 5, 0.2), new Vec3(0, -1, 0)));
                Console.WriteLine("triangle {0} at distance {1:G6}", hit.Triangle, hit.Distance);
                return 0;
            }
        }
        catch (BdtreeException error)
        {
            Console.WriteLine(error.Message);
            return 1;
        }
    }
}
