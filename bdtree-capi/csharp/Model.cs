// Models and poses of their skeletons.
using System;

namespace Bdtree
{
    public sealed class Model : Owned
    {
        public readonly ModelInfo Info;

        private Model(Status status, IntPtr made)
        {
            Own(status, made);
            Native.Check(Native.bdt_model_info(this, out Info));
        }

        /// <summary>Maps the file, which must not change while the model or an instance of it lives.</summary>
        public static Model Load(string path)
        {
            return new Model(Native.bdt_model_load(Native.Utf8(path), out IntPtr made), made);
        }

        /// <summary>Reads the file, which may change afterwards.</summary>
        public static Model Read(string path)
        {
            return new Model(Native.bdt_model_read(Native.Utf8(path), out IntPtr made), made);
        }

        public static Model FromMemory(byte[] bytes)
        {
            return new Model(Native.bdt_model_from_memory(bytes, Length(bytes), out IntPtr made), made);
        }

        public Mode Mode(int index)
        {
            Native.Check(Native.bdt_model_mode(this, (UIntPtr)index, out Mode mode));
            return mode;
        }

        public Mass Mass()
        {
            Native.Check(Native.bdt_model_mass(this, out Mass mass));
            return mass;
        }

        public Group Group(int index)
        {
            Native.Check(Native.bdt_model_group(this, (UIntPtr)index, out Group group));
            return group;
        }

        public string ModeName(int index) { return Name(Native.bdt_model_mode_name, index); }
        public string JointName(int index) { return Name(Native.bdt_model_joint_name, index); }
        public string ClipName(int index) { return Name(Native.bdt_model_clip_name, index); }
        public string GroupName(int index) { return Name(Native.bdt_model_group_name, index); }
        public int ModeIndex(string name) { return Index(Native.bdt_model_mode_index, name); }
        public int JointIndex(string name) { return Index(Native.bdt_model_joint_index, name); }
        public int ClipIndex(string name) { return Index(Native.bdt_model_clip_index, name); }

        /// <summary>Library.None for a root.</summary>
        public uint JointParent(int index)
        {
            Native.Check(Native.bdt_model_joint_parent(this, (UIntPtr)index, out uint parent));
            return parent;
        }

        public uint JointOf(Hit hit)
        {
            Native.Check(Native.bdt_model_joint_of(this, hit.Triangle, hit.Barycentric, out uint joint));
            return joint;
        }

        public double ClipDuration(int index)
        {
            Native.Check(Native.bdt_model_clip_duration(this, (UIntPtr)index, out double seconds));
            return seconds;
        }

        /// <summary>Three vertices of each of `count` triangles.</summary>
        public uint[] Triangles(int first, int count)
        {
            uint[] corners = new uint[3 * count];
            Native.Check(Native.bdt_model_triangles(this, (uint)first, (UIntPtr)count, corners));
            return corners;
        }

        /// <summary>Three vertices of each triangle.</summary>
        public uint[] Triangles() { return Triangles(0, (int)Info.TriangleCount); }

        public Transform Frame(int index, float[] q) { return Frame(index, q, out double _); }

        /// <summary>`timeS`: when the frame is shown, seconds.</summary>
        public Transform Frame(int index, float[] q, out double timeS)
        {
            Native.Check(Native.bdt_model_frame(this, (UIntPtr)index, q, Length(q), out Transform at, out timeS));
            return at;
        }

        public Transform Sample(double timeS, float[] q)
        {
            Native.Check(Native.bdt_model_sample(this, timeS, q, Length(q), out Transform at));
            return at;
        }

        public void Verify() { Native.Check(Native.bdt_model_verify(this)); }
        public void VerifyChecksums() { Native.Check(Native.bdt_model_verify_checksums(this)); }

        private delegate Status AskName(Model model, UIntPtr index, byte[] text, UIntPtr capacity, out UIntPtr length);

        private string Name(AskName ask, int index)
        {
            return Text((byte[] text, UIntPtr capacity, out UIntPtr length) =>
                ask(this, (UIntPtr)index, text, capacity, out length));
        }

        private delegate Status AskIndex(Model model, byte[] name, out UIntPtr index);

        private int Index(AskIndex ask, string name)
        {
            Native.Check(ask(this, Native.Utf8(name), out UIntPtr index));
            return (int)index;
        }

        protected override bool ReleaseHandle() { return Native.bdt_model_free(handle) == Status.Ok; }
    }

    public sealed class SkeletonPose : Owned
    {
        private readonly ModelInfo info;

        public SkeletonPose(Model model)
        {
            info = model.Info;
            Own(Native.bdt_skeleton_pose_new(model, out IntPtr made), made);
        }

        public void Rest() { Native.Check(Native.bdt_skeleton_pose_rest(this)); }
        public void Play(int clip, double timeS)
        {
            Native.Check(Native.bdt_skeleton_pose_play(this, (UIntPtr)clip, timeS));
        }
        public void Blend(int clip, double timeS, double weight)
        {
            Native.Check(Native.bdt_skeleton_pose_blend(this, (UIntPtr)clip, timeS, weight));
        }
        public void Update() { Native.Check(Native.bdt_skeleton_pose_update(this)); }

        public Local GetLocal(int node)
        {
            Native.Check(Native.bdt_skeleton_pose_local(this, (UIntPtr)node, out Local local));
            return local;
        }

        public void SetLocal(int node, Local local)
        {
            Native.Check(Native.bdt_skeleton_pose_set_local(this, (UIntPtr)node, ref local));
        }

        public Matrix[] Joints()
        {
            Matrix[] joints = new Matrix[info.JointCount];
            Native.Check(Native.bdt_skeleton_pose_joints(this, joints, Length(joints)));
            return joints;
        }

        public Matrix[] Nodes()
        {
            Matrix[] nodes = new Matrix[info.SkeletonNodeCount];
            Native.Check(Native.bdt_skeleton_pose_nodes(this, nodes, Length(nodes)));
            return nodes;
        }

        public float[] Q()
        {
            float[] q = new float[info.ModeCount];
            Native.Check(Native.bdt_skeleton_pose_q(this, q, Length(q)));
            return q;
        }

        protected override bool ReleaseHandle() { return Native.bdt_skeleton_pose_free(handle) == Status.Ok; }
    }
}
