// Instances of models: q, bones, placement and what follows from them.
using System;

namespace Bdtree
{
    public sealed class Instance : Owned
    {
        private readonly uint modeCount;

        public Instance(Model model)
        {
            modeCount = model.Info.ModeCount;
            Own(Native.bdt_instance_new(model, out IntPtr made), made);
        }

        /// <summary>With a step cache of so many nodes and leaves.</summary>
        public Instance(Model model, int nodes, int leaves)
        {
            modeCount = model.Info.ModeCount;
            Own(Native.bdt_instance_new_with_cache(model, (UIntPtr)nodes, (UIntPtr)leaves, out IntPtr made), made);
        }

        public void SetQ(float[] q) { Native.Check(Native.bdt_instance_set_q(this, q, Length(q))); }
        /// <summary>Whether queries refine the pose by themselves where a step asks so much that it pays.</summary>
        public void SetRefining(bool on) { Native.Check(Native.bdt_instance_set_refining(this, on ? 1 : 0)); }
        public void SetPlacement(Transform at) { Native.Check(Native.bdt_instance_set_placement(this, ref at)); }
        public void SetPose(float[] q, Transform at)
        {
            Native.Check(Native.bdt_instance_set_pose(this, q, Length(q), ref at));
        }
        public void SetPose(float[] q, Matrix[] joints, Transform at)
        {
            Native.Check(Native.bdt_instance_set_pose_with_joints(this, q, Length(q), joints, Length(joints), ref at));
        }
        public void SetPose(SkeletonPose pose) { Native.Check(Native.bdt_instance_set_skeleton_pose(this, pose)); }
        public void SetJoints(Matrix[] joints)
        {
            Native.Check(Native.bdt_instance_set_joints(this, joints, Length(joints)));
        }
        public void SetSkinningMatrices(Matrix[] bones)
        {
            Native.Check(Native.bdt_instance_set_skinning_matrices(this, bones, Length(bones)));
        }

        public float[] Q()
        {
            float[] q = new float[modeCount];
            Native.Check(Native.bdt_instance_q(this, q, Length(q)));
            return q;
        }

        public Transform Placement
        {
            get { Native.Check(Native.bdt_instance_placement(this, out Transform at)); return at; }
            set { SetPlacement(value); }
        }

        public Tags Tags
        {
            get { Native.Check(Native.bdt_instance_tags(this, out Tags tags)); return tags; }
            set { Native.Check(Native.bdt_instance_set_tags(this, ref value)); }
        }

        public Aabb Aabb
        {
            get { Native.Check(Native.bdt_instance_aabb(this, out Aabb aabb)); return aabb; }
        }

        public Aabb ExactAabb
        {
            get { Native.Check(Native.bdt_instance_exact_aabb(this, out Aabb aabb)); return aabb; }
        }

        public Sphere BoundingSphere
        {
            get { Native.Check(Native.bdt_instance_bounding_sphere(this, out Sphere sphere)); return sphere; }
        }

        /// <summary>Where vertices are in the world.</summary>
        public void Vertices(int first, Vec3[] vertices)
        {
            Native.Check(Native.bdt_instance_vertices(this, (uint)first, Length(vertices), vertices));
        }

        /// <summary>Adds what a force at a point of a triangle does to each mode to `forces`, one number per mode.</summary>
        public void AddGeneralizedForce(uint triangle, Vec3 barycentric, Vec3 force, double[] forces)
        {
            Native.Check(Native.bdt_instance_add_generalized_force(this, triangle, barycentric, force, forces,
                Length(forces)));
        }

        /// <summary>Calls with the handles of instances, which live until it returns.</summary>
        internal static T With<T>(Instance[] of, Func<IntPtr[], T> ask)
        {
            IntPtr[] handles = new IntPtr[of.Length];
            int held = 0;
            try
            {
                while (held < of.Length)
                {
                    bool isHeld = false;
                    of[held].DangerousAddRef(ref isHeld);
                    handles[held] = of[held].handle;
                    held++;
                }
                return ask(handles);
            }
            finally
            {
                while (held > 0)
                    of[--held].DangerousRelease();
            }
        }

        protected override bool ReleaseHandle() { return Native.bdt_instance_free(handle) == Status.Ok; }
    }
}
