// Queries.
using System;

namespace Bdtree
{
    /// <summary>What a pair of instances keeps from step to step.</summary>
    public sealed class Front : Owned
    {
        /// <summary>NULL, in place of a front that was not given.</summary>
        internal static readonly Front None = new Front(IntPtr.Zero);

        public Front()
        {
            Own(Native.bdt_front_new(out IntPtr made), made);
        }

        private Front(IntPtr made) { SetHandle(made); }

        protected override bool ReleaseHandle() { return Native.bdt_front_free(handle) == Status.Ok; }
    }

    /// <summary>The memory of queries, and the queries: one per thread.</summary>
    public sealed class Workspace : Owned
    {
        public Workspace()
        {
            Own(Native.bdt_workspace_new(out IntPtr made), made);
        }

        public void SetShared(bool isShared) { Native.Check(Native.bdt_workspace_set_shared(this, isShared ? 1 : 0)); }
        public void SetMaxLevels(int first, int second = -1)
        {
            Native.Check(Native.bdt_workspace_set_max_levels(this, first, second));
        }
        public void SetMaxVisits(ulong visits) { Native.Check(Native.bdt_workspace_set_max_visits(this, visits)); }

        public Proxy[] Proxies(int side = 0)
        {
            return All((Proxy[] items, UIntPtr capacity, out UIntPtr count) =>
                Native.bdt_workspace_proxies(this, (UIntPtr)side, items, capacity, out count));
        }

        public Bound Bound
        {
            get { Native.Check(Native.bdt_workspace_bound(this, out Bound bound)); return bound; }
        }

        public Stats Stats
        {
            get { Native.Check(Native.bdt_workspace_stats(this, out Stats stats)); return stats; }
        }

        public Contact[] Contacts(Instance of, Shape shape)
        {
            return All((Contact[] items, UIntPtr capacity, out UIntPtr count) =>
                Native.bdt_contacts(this, of, ref shape, items, capacity, out count));
        }

        /// <summary>
        /// Hands contacts to `take`, which returns true to go on; false ends the query, and then this returns false. What
        /// `take` throws ends the query, and is thrown on from here. `take` must not use this workspace nor the instance.
        /// </summary>
        public bool ContactsEach(Instance of, Shape shape, Func<Contact, bool> take)
        {
            return Taker<Contact>.Each(take, context =>
                Native.bdt_contacts_each(this, of, ref shape, Callbacks.Contact, context));
        }

        public bool Intersects(Instance of, Shape shape)
        {
            Native.Check(Native.bdt_intersects(this, of, ref shape, out int isTouched));
            return isTouched != 0;
        }

        public Hit ProjectPoint(Instance of, Vec3 point, double maxDistance = double.PositiveInfinity)
        {
            Native.Check(Native.bdt_project_point(this, of, point, maxDistance, out Hit hit));
            return hit;
        }

        public Hit CastRay(Instance of, Ray ray)
        {
            Native.Check(Native.bdt_cast_ray(this, of, ref ray, out Hit hit));
            return hit;
        }

        public bool IntersectsRay(Instance of, Ray ray)
        {
            Native.Check(Native.bdt_intersects_ray(this, of, ref ray, out int isMet));
            return isMet != 0;
        }

        public Hit[] CastRayAll(Instance of, Ray ray)
        {
            return All((Hit[] items, UIntPtr capacity, out UIntPtr count) =>
                Native.bdt_cast_ray_all(this, of, ref ray, items, capacity, out count));
        }

        /// <summary>Hands hits to `take`, as ContactsEach contacts.</summary>
        public bool CastRayAllEach(Instance of, Ray ray, Func<Hit, bool> take)
        {
            return Taker<Hit>.Each(take, context =>
                Native.bdt_cast_ray_all_each(this, of, ref ray, Callbacks.Hit, context));
        }

        /// <summary>hits[k] becomes that of ray k.</summary>
        public void CastRays(Instance of, Ray[] rays, Hit[] hits)
        {
            NeedRoom(hits, rays.Length);
            Native.Check(Native.bdt_cast_rays(this, of, rays, Length(rays), hits));
        }

        /// <summary>isMet[k] becomes 1 if ray k meets the mesh, else 0.</summary>
        public void IntersectsRays(Instance of, Ray[] rays, byte[] isMet)
        {
            NeedRoom(isMet, rays.Length);
            Native.Check(Native.bdt_intersects_rays(this, of, rays, Length(rays), isMet));
        }

        /// <summary>Every triangle that each ray meets, ray after ray: Index is the ray.</summary>
        public Hit[] CastRaysAll(Instance of, Ray[] rays)
        {
            return All((Hit[] items, UIntPtr capacity, out UIntPtr count) =>
                Native.bdt_cast_rays_all(this, of, rays, Length(rays), items, capacity, out count));
        }

        /// <summary>hits[i * rays.Length + k] becomes that of ray k with instance i.</summary>
        public void CastRaysAtInstances(Instance[] of, Ray[] rays, Hit[] hits)
        {
            NeedRoom(hits, (long)of.Length * rays.Length);
            Native.Check(Instance.With(of, instances =>
                Native.bdt_cast_rays_at_instances(this, instances, Length(instances), rays, Length(rays), hits)));
        }

        /// <summary>hits[k] becomes what ray k meets first of all instances: Index is the instance.</summary>
        public void CastRaysNearest(Instance[] of, Ray[] rays, Hit[] hits)
        {
            NeedRoom(hits, rays.Length);
            Native.Check(Instance.With(of, instances =>
                Native.bdt_cast_rays_nearest(this, instances, Length(instances), rays, Length(rays), hits)));
        }

        public Region FrustumState(Instance of, Plane[] planes)
        {
            Native.Check(Native.bdt_frustum_state(this, of, planes, Length(planes), out Region state));
            return state;
        }

        /// <summary>Lanes of a level whose spheres the shape touches.</summary>
        public Lane[] LevelSpheres(Instance of, uint level, Shape shape)
        {
            return All((Lane[] items, UIntPtr capacity, out UIntPtr count) =>
                Native.bdt_level_spheres(this, of, level, ref shape, items, capacity, out count));
        }

        public PairContact[] PairContacts(Instance first, Instance second, double prediction = 0.0, Front front = null)
        {
            return All((PairContact[] items, UIntPtr capacity, out UIntPtr count) => Native.bdt_pair_contacts(this, first,
                second, front ?? Front.None, prediction, items, capacity, out count));
        }

        /// <summary>Hands contacts to `take`, as ContactsEach; it must not use the front either.</summary>
        public bool PairContactsEach(Instance first, Instance second, Func<PairContact, bool> take,
            double prediction = 0.0, Front front = null)
        {
            return Taker<PairContact>.Each(take, context => Native.bdt_pair_contacts_each(this, first, second,
                front ?? Front.None, prediction, Callbacks.PairContact, context));
        }

        public IndexPair[] PairTriangles(Instance first, Instance second, double prediction = 0.0, Front front = null)
        {
            return All((IndexPair[] items, UIntPtr capacity, out UIntPtr count) => Native.bdt_pair_triangles(this, first,
                second, front ?? Front.None, prediction, items, capacity, out count));
        }

        public bool PairIntersects(Instance first, Instance second, Front front = null)
        {
            Native.Check(Native.bdt_pair_intersects(this, first, second, front ?? Front.None, out int isTouching));
            return isTouching != 0;
        }

        public PairContact PairClosestPoints(Instance first, Instance second, double maxDistance = double.PositiveInfinity)
        {
            Native.Check(Native.bdt_pair_closest_points(this, first, second, maxDistance, out PairContact found));
            return found;
        }

        /// <summary>Null beyond `maxDistance`.</summary>
        public double? PairDistance(Instance first, Instance second, double maxDistance = double.PositiveInfinity)
        {
            Native.Check(Native.bdt_pair_distance(this, first, second, maxDistance, out double distance));
            return distance < 0.0 ? (double?)null : distance;
        }

        public Manifold[] PairManifolds(Instance first, Instance second, double prediction = 0.0, Front front = null)
        {
            return All((Manifold[] items, UIntPtr capacity, out UIntPtr count) => Native.bdt_pair_manifolds(this, first,
                second, front ?? Front.None, prediction, items, capacity, out count));
        }

        /// <summary>The manifolds of all contacts that PairContacts has answered.</summary>
        public Manifold[] PairCondense(Instance first, Instance second, PairContact[] pairs)
        {
            return All((Manifold[] items, UIntPtr capacity, out UIntPtr count) =>
                Native.bdt_pair_condense(this, first, second, pairs, Length(pairs), items, capacity, out count));
        }

        /// <summary>Lanes of both trees, of these levels, whose spheres are near each other.</summary>
        public LanePair[] PairLevelSpheres(Instance first, Instance second, uint level1, uint level2,
            double prediction = 0.0, double reach = 0.0)
        {
            return All((LanePair[] items, UIntPtr capacity, out UIntPtr count) => Native.bdt_pair_level_spheres(this, first,
                second, level1, level2, prediction, reach, items, capacity, out count));
        }

        /// <summary>Lanes of the first tree, of this level, and triangles of the second mesh near their spheres.</summary>
        public LaneTriangle[] PairLevelTriangles(Instance first, Instance second, uint level, double prediction = 0.0,
            double reach = 0.0)
        {
            return All((LaneTriangle[] items, UIntPtr capacity, out UIntPtr count) => Native.bdt_pair_level_triangles(this,
                first, second, level, prediction, reach, items, capacity, out count));
        }

        /// <summary>Pairs of spheres at most `prediction` apart.</summary>
        public IndexPair[] SpherePairs(Sphere[] spheres, double prediction = 0.0)
        {
            return All((IndexPair[] items, UIntPtr capacity, out UIntPtr count) =>
                Native.bdt_sphere_pairs(this, spheres, Length(spheres), prediction, items, capacity, out count));
        }

        /// <summary>Pairs of instances whose spheres are at most `prediction` apart and whose groups meet.</summary>
        public IndexPair[] InstancePairs(Instance[] of, double prediction = 0.0)
        {
            return Instance.With(of, instances => All((IndexPair[] items, UIntPtr capacity, out UIntPtr count) =>
                Native.bdt_instance_pairs(this, instances, Length(instances), prediction, items, capacity, out count)));
        }

        private static void NeedRoom(Array answers, long count)
        {
            if (answers.Length < count)
                throw new ArgumentException("room for " + answers.Length + " of " + count + " answers");
        }

        protected override bool ReleaseHandle() { return Native.bdt_workspace_free(handle) == Status.Ok; }
    }
}
