// bdtree for C# (.NET Standard 2.0, C# 7.3, so Unity and mono): P/Invoke of bdtree.h, owners of its handles, arrays, and
// exceptions in place of statuses. Methods call the function of bdtree.h of the same name, whose comment says units,
// frames, errors and which threads may call it. Put the file into the project and libbdtree.so beside it.
using System;
using System.Runtime.InteropServices;
using System.Text;

namespace Bdtree
{
    /// <summary>What a function of bdtree.h returned, and what it says.</summary>
    public sealed class BdtreeException : Exception
    {
        public readonly Status Status;

        internal BdtreeException(Status status, string text) : base(text) { Status = status; }
    }

    public enum Status
    {
        Ok = 0, Truncated = 1, Stopped = 2, ErrorNull = -1, ErrorHandle = -2, ErrorBusy = -3, ErrorArgument = -4,
        ErrorLength = -5, ErrorIndex = -6, ErrorIo = -7, ErrorFormat = -8, ErrorPose = -9, ErrorNoSkin = -10,
        ErrorNoAnimation = -11, ErrorDynamics = -12, ErrorStep = -13, ErrorState = -14, ErrorPanic = -15,
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Vec3
    {
        public double X, Y, Z;

        public Vec3(double x, double y, double z) { X = x; Y = y; Z = z; }
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Quat
    {
        public double X, Y, Z, W;

        public Quat(double x, double y, double z, double w) { X = x; Y = y; Z = z; W = w; }

        public static readonly Quat Identity = new Quat(0.0, 0.0, 0.0, 1.0);
    }

    /// <summary>world = rotation · (scale · mesh) + translation.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Transform
    {
        public Quat Rotation;
        public Vec3 Translation;
        public double Scale;

        public static readonly Transform Identity = new Transform { Rotation = Quat.Identity, Scale = 1.0 };

        /// <summary>What does what `first` does and then what this does.</summary>
        public Transform After(Transform first)
        {
            Native.Check(Native.bdt_transform_after(this, first, out Transform both));
            return both;
        }
    }

    /// <summary>Rows of an affine map: row r is (R0, R1, R2, R3) · (x, y, z, 1).</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Matrix
    {
        public double M00, M01, M02, M03, M10, M11, M12, M13, M20, M21, M22, M23;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Ray
    {
        public Vec3 Origin, Direction;
        public double MaxDistance;

        public Ray(Vec3 origin, Vec3 direction, double maxDistance = double.PositiveInfinity)
        {
            Origin = origin;
            Direction = direction;
            MaxDistance = maxDistance;
        }
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Shape
    {
        public uint Kind, Reserved;
        public Vec3 A, B;
        public Quat Rotation;
        public double Size;

        public static Shape Ball(Vec3 center, double radius) { return Native.bdt_ball(center, radius); }
        public static Shape Capsule(Vec3 a, Vec3 b, double radius) { return Native.bdt_capsule(a, b, radius); }
        public static Shape Cuboid(Vec3 center, Quat rotation, Vec3 halfExtents)
        {
            return Native.bdt_cuboid(center, rotation, halfExtents);
        }
        public static Shape HalfSpace(Vec3 normal, double offset) { return Native.bdt_half_space(normal, offset); }
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Plane
    {
        public Vec3 Normal;
        public double D;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Aabb
    {
        public Vec3 Min, Max;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Contact
    {
        public uint Triangle, Body;
        public Vec3 Point, Normal;
        public double Distance;
        public Vec3 Barycentric;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Hit
    {
        public uint Triangle, Index;
        public Vec3 Point, Normal;
        public double Distance;
        public Vec3 Barycentric;

        /// <summary>Whether anything was found.</summary>
        public bool IsHit { get { return Triangle != uint.MaxValue; } }
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct PairContact
    {
        public uint Triangle1, Triangle2;
        public Vec3 Point1, Point2, Normal1, Normal2;
        public double Distance;
        public Vec3 Barycentric1, Barycentric2;

        public bool IsHit { get { return Triangle1 != uint.MaxValue; } }
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct ManifoldPoint
    {
        public Vec3 Point1, Point2;
        public double Distance, Area;
        public Vec3 Barycentric1, Barycentric2;
        public uint Triangle1, Triangle2;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Manifold
    {
        public Vec3 Normal1, Normal2;
        public double Area, Depth;
        public uint Triangle1, Triangle2, PointCount, Reserved;
        public ManifoldPoint Point0, Point1, Point2, Point3;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct ModelInfo
    {
        public uint VertexCount, TriangleCount, ModeCount, NodeCount, Depth, JointCount, BoneCount, SkeletonNodeCount,
            ClipCount, FrameCount, GroupCount, HasMass;
        public double DurationS, Unit;
        public Vec3 Origin;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Mode
    {
        public float QLimit, QRange;
        public double OmegaRadS, ModalMassKg, DefaultQ;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Local
    {
        public uint IsMatrix, Reserved;
        public Vec3 Translation;
        public Quat Rotation;
        public Vec3 Scale;
        public Matrix Matrix;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Mass
    {
        public double MassKg;
        public Vec3 Center;
        public double Xx, Yy, Zz, Xy, Xz, Yz;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct WorldOptions
    {
        public double StepS;
        public Vec3 Gravity;
        public double Stiffness, DampingRatio, Friction, Accuracy, SleepSpeed;
        public uint Sweeps, Threads;

        public static WorldOptions Usual
        {
            get { Native.Check(Native.bdt_world_defaults(out WorldOptions options)); return options; }
        }
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct BodyOptions
    {
        public double Scale;
        public Mass Mass;
        public double ThinnestWall, DampingRatio, MassPerS, StiffnessS, StrainLimit;
        public uint HasMass, Level, Contact, IsDeformable;

        public static BodyOptions Usual
        {
            get { Native.Check(Native.bdt_body_defaults(out BodyOptions options)); return options; }
        }
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct BodyState
    {
        public Vec3 Position;
        public Quat Orientation;
        public Vec3 Velocity, AngularMomentum, AngularVelocity;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct StepReport
    {
        public ulong Contacts, Late, Pairs, Candidates, NodesVisited, NodesUpdated, Sweeps, Parts;
        public double Penetration, PenetrationRel, ContactEnergy, TimeS;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Event
    {
        public uint Body1, Body2, Phase, Reserved;
        public Vec3 Impulse;
    }

    /// <summary>A handle that is freed with its owner.</summary>
    public abstract class Owned : SafeHandle
    {
        protected Owned() : base(IntPtr.Zero, true) { }

        public override bool IsInvalid { get { return handle == IntPtr.Zero; } }

        internal delegate Status AskFor<T>(T[] items, UIntPtr capacity, out UIntPtr count);

        /// <summary>All items of an answer.</summary>
        internal static T[] All<T>(AskFor<T> ask)
        {
            T[] items = new T[32];
            UIntPtr count;
            while (Native.Check(ask(items, (UIntPtr)items.Length, out count)) == Status.Truncated)
                items = new T[(int)count];
            Array.Resize(ref items, (int)count);
            return items;
        }

        internal static string Text(AskFor<byte> ask)
        {
            byte[] bytes = new byte[64];
            UIntPtr length;
            while (Native.Check(ask(bytes, (UIntPtr)bytes.Length, out length)) == Status.Truncated)
                bytes = new byte[(int)length + 1];
            return Encoding.UTF8.GetString(bytes, 0, (int)length);
        }

        internal static UIntPtr Length(Array array) { return (UIntPtr)array.Length; }
    }

    public sealed class Model : Owned
    {
        public readonly ModelInfo Info;

        private Model(IntPtr pointer)
        {
            SetHandle(pointer);
            Native.Check(Native.bdt_model_info(this, out Info));
        }

        public static Model Load(string path)
        {
            Native.Check(Native.bdt_model_load(Native.Utf8(path), out IntPtr pointer));
            return new Model(pointer);
        }

        public static Model FromMemory(byte[] bytes)
        {
            Native.Check(Native.bdt_model_from_memory(bytes, Length(bytes), out IntPtr pointer));
            return new Model(pointer);
        }

        public Mode Mode(int index)
        {
            Native.Check(Native.bdt_model_mode(this, (UIntPtr)index, out Mode mode));
            return mode;
        }

        public string ModeName(int index)
        {
            return Text((byte[] buffer, UIntPtr capacity, out UIntPtr length) =>
                Native.bdt_model_mode_name(this, (UIntPtr)index, buffer, capacity, out length));
        }

        public string ClipName(int index)
        {
            return Text((byte[] buffer, UIntPtr capacity, out UIntPtr length) =>
                Native.bdt_model_clip_name(this, (UIntPtr)index, buffer, capacity, out length));
        }

        public string JointName(int index)
        {
            return Text((byte[] buffer, UIntPtr capacity, out UIntPtr length) =>
                Native.bdt_model_joint_name(this, (UIntPtr)index, buffer, capacity, out length));
        }

        public double ClipDuration(int index)
        {
            Native.Check(Native.bdt_model_clip_duration(this, (UIntPtr)index, out double seconds));
            return seconds;
        }

        public Transform Frame(int index, float[] q)
        {
            Native.Check(Native.bdt_model_frame(this, (UIntPtr)index, q, Length(q), out Transform at, IntPtr.Zero));
            return at;
        }

        public Transform Sample(double timeS, float[] q)
        {
            Native.Check(Native.bdt_model_sample(this, timeS, q, Length(q), out Transform at));
            return at;
        }

        public uint JointOf(Hit hit)
        {
            Native.Check(Native.bdt_model_joint_of(this, hit.Triangle, hit.Barycentric, out uint joint));
            return joint;
        }

        public void Verify() { Native.Check(Native.bdt_model_verify(this)); }

        protected override bool ReleaseHandle() { return Native.bdt_model_free(handle) == Status.Ok; }
    }

    public sealed class SkeletonPose : Owned
    {
        private readonly ModelInfo info;

        public SkeletonPose(Model model)
        {
            info = model.Info;
            Native.Check(Native.bdt_skeleton_pose_new(model, out IntPtr pointer));
            SetHandle(pointer);
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

        protected override bool ReleaseHandle() { return Native.bdt_skeleton_pose_free(handle) == Status.Ok; }
    }

    public sealed class Instance : Owned
    {
        public Instance(Model model)
        {
            Native.Check(Native.bdt_instance_new(model, out IntPtr pointer));
            SetHandle(pointer);
        }

        public void SetQ(float[] q) { Native.Check(Native.bdt_instance_set_q(this, q, Length(q))); }
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
        public void SetJoints(Matrix[] joints) { Native.Check(Native.bdt_instance_set_joints(this, joints, Length(joints))); }

        public Aabb Aabb
        {
            get { Native.Check(Native.bdt_instance_aabb(this, out Aabb aabb)); return aabb; }
        }

        /// <summary>Where vertices are in the world.</summary>
        public void Vertices(int first, Vec3[] vertices)
        {
            Native.Check(Native.bdt_instance_vertices(this, (uint)first, Length(vertices), vertices));
        }

        protected override bool ReleaseHandle() { return Native.bdt_instance_free(handle) == Status.Ok; }
    }

    /// <summary>What a pair of instances keeps from step to step.</summary>
    public sealed class Front : Owned
    {
        public Front()
        {
            Native.Check(Native.bdt_front_new(out IntPtr pointer));
            SetHandle(pointer);
        }

        internal IntPtr Pointer { get { return handle; } }

        protected override bool ReleaseHandle() { return Native.bdt_front_free(handle) == Status.Ok; }
    }

    /// <summary>The memory of queries, and the queries: one per thread.</summary>
    public sealed class Workspace : Owned
    {
        public Workspace()
        {
            Native.Check(Native.bdt_workspace_new(out IntPtr pointer));
            SetHandle(pointer);
        }

        public void SetShared(bool isShared) { Native.Check(Native.bdt_workspace_set_shared(this, isShared ? 1 : 0)); }

        public Contact[] Contacts(Instance of, Shape shape)
        {
            return All((Contact[] items, UIntPtr capacity, out UIntPtr count) =>
                Native.bdt_contacts(this, of, ref shape, items, capacity, out count));
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

        public void CastRays(Instance of, Ray[] rays, Hit[] hits)
        {
            if (hits.Length < rays.Length)
                throw new ArgumentException("fewer hits than rays");
            Native.Check(Native.bdt_cast_rays(this, of, rays, Length(rays), hits));
        }

        public PairContact[] PairContacts(Instance first, Instance second, double prediction = 0.0, Front front = null)
        {
            IntPtr of = front == null ? IntPtr.Zero : front.Pointer;
            PairContact[] found = All((PairContact[] items, UIntPtr capacity, out UIntPtr count) =>
                Native.bdt_pair_contacts(this, first, second, of, prediction, items, capacity, out count));
            GC.KeepAlive(front);
            return found;
        }

        public Manifold[] PairManifolds(Instance first, Instance second, double prediction = 0.0, Front front = null)
        {
            IntPtr of = front == null ? IntPtr.Zero : front.Pointer;
            Manifold[] found = All((Manifold[] items, UIntPtr capacity, out UIntPtr count) =>
                Native.bdt_pair_manifolds(this, first, second, of, prediction, items, capacity, out count));
            GC.KeepAlive(front);
            return found;
        }

        public PairContact PairClosestPoints(Instance first, Instance second, double maxDistance = double.PositiveInfinity)
        {
            Native.Check(Native.bdt_pair_closest_points(this, first, second, maxDistance, out PairContact found));
            return found;
        }

        protected override bool ReleaseHandle() { return Native.bdt_workspace_free(handle) == Status.Ok; }
    }

    /// <summary>Bodies that fall, touch and vibrate.</summary>
    public sealed class World : Owned
    {
        public World() : this(WorldOptions.Usual) { }

        public World(WorldOptions options)
        {
            Native.Check(Native.bdt_world_new(ref options, out IntPtr pointer));
            SetHandle(pointer);
        }

        public uint AddModel(Model model, BodyOptions options)
        {
            Native.Check(Native.bdt_world_add_model(this, model, ref options, out uint id));
            return id;
        }

        public void AddPlane(Plane plane) { Native.Check(Native.bdt_world_add_plane(this, ref plane)); }

        /// <summary>frame: 0 free, 1 held, 2 driven.</summary>
        public uint AddBody(uint model, Transform at, uint frame = 0)
        {
            Native.Check(Native.bdt_world_add_body(this, model, frame, ref at, out uint id));
            return id;
        }

        public StepReport Step()
        {
            Native.Check(Native.bdt_world_step(this, out StepReport report));
            return report;
        }

        public BodyState State(uint body)
        {
            Native.Check(Native.bdt_body_state(this, body, out BodyState state));
            return state;
        }

        public Transform Placement(uint body)
        {
            Native.Check(Native.bdt_body_placement(this, body, out Transform at));
            return at;
        }

        public double[] Q(uint body)
        {
            Native.Check(Native.bdt_body_mode_count(this, body, out UIntPtr count));
            double[] q = new double[(int)count];
            Native.Check(Native.bdt_body_q(this, body, q, IntPtr.Zero, count));
            return q;
        }

        public Event[] Events()
        {
            return All((Event[] items, UIntPtr capacity, out UIntPtr count) =>
                Native.bdt_world_events(this, items, capacity, out count));
        }

        public Hit CastRay(Ray ray)
        {
            Native.Check(Native.bdt_world_cast_ray(this, ref ray, out Hit hit));
            return hit;
        }

        public byte[] Save()
        {
            return All((byte[] items, UIntPtr capacity, out UIntPtr count) =>
                Native.bdt_world_save(this, items, capacity, out count));
        }

        public void Restore(byte[] bytes) { Native.Check(Native.bdt_world_restore(this, bytes, Length(bytes))); }

        protected override bool ReleaseHandle() { return Native.bdt_world_free(handle) == Status.Ok; }
    }

    internal static class Native
    {
        private const string Library = "bdtree";

        /// <summary>Throws for statuses below 0; returns the others.</summary>
        internal static Status Check(Status status)
        {
            if (status >= Status.Ok)
                return status;
            byte[] buffer = new byte[512];
            bdt_last_error(buffer, (UIntPtr)buffer.Length, out UIntPtr length);
            throw new BdtreeException(status, Encoding.UTF8.GetString(buffer, 0, Math.Min((int)length, 511)));
        }

        /// <summary>A text closed by 0.</summary>
        internal static byte[] Utf8(string text) { return Encoding.UTF8.GetBytes(text + "\0"); }

        [DllImport(Library)] internal static extern uint bdt_version();
        [DllImport(Library)] internal static extern Status bdt_last_error([Out] byte[] buffer, UIntPtr capacity,
            out UIntPtr length);
        [DllImport(Library)] internal static extern Shape bdt_ball(Vec3 center, double radius);
        [DllImport(Library)] internal static extern Shape bdt_capsule(Vec3 a, Vec3 b, double radius);
        [DllImport(Library)] internal static extern Shape bdt_cuboid(Vec3 center, Quat rotation, Vec3 halfExtents);
        [DllImport(Library)] internal static extern Shape bdt_half_space(Vec3 normal, double offset);
        [DllImport(Library)] internal static extern Status bdt_transform_after(Transform then, Transform first,
            out Transform both);
        [DllImport(Library)] internal static extern Status bdt_model_load(byte[] path, out IntPtr model);
        [DllImport(Library)] internal static extern Status bdt_model_from_memory(byte[] bytes, UIntPtr length,
            out IntPtr model);
        [DllImport(Library)] internal static extern Status bdt_model_free(IntPtr model);
        [DllImport(Library)] internal static extern Status bdt_model_info(Model model, out ModelInfo info);
        [DllImport(Library)] internal static extern Status bdt_model_mode(Model model, UIntPtr index, out Mode mode);
        [DllImport(Library)] internal static extern Status bdt_model_mode_name(Model model, UIntPtr index,
            [Out] byte[] buffer, UIntPtr capacity, out UIntPtr length);
        [DllImport(Library)] internal static extern Status bdt_model_clip_name(Model model, UIntPtr index,
            [Out] byte[] buffer, UIntPtr capacity, out UIntPtr length);
        [DllImport(Library)] internal static extern Status bdt_model_joint_name(Model model, UIntPtr index,
            [Out] byte[] buffer, UIntPtr capacity, out UIntPtr length);
        [DllImport(Library)] internal static extern Status bdt_model_clip_duration(Model model, UIntPtr index,
            out double seconds);
        [DllImport(Library)] internal static extern Status bdt_model_frame(Model model, UIntPtr index,
            [Out] float[] q, UIntPtr count, out Transform at, IntPtr time);
        [DllImport(Library)] internal static extern Status bdt_model_sample(Model model, double time,
            [Out] float[] q, UIntPtr count, out Transform at);
        [DllImport(Library)] internal static extern Status bdt_model_joint_of(Model model, uint triangle,
            Vec3 barycentric, out uint joint);
        [DllImport(Library)] internal static extern Status bdt_model_verify(Model model);
        [DllImport(Library)] internal static extern Status bdt_skeleton_pose_new(Model model, out IntPtr pose);
        [DllImport(Library)] internal static extern Status bdt_skeleton_pose_free(IntPtr pose);
        [DllImport(Library)] internal static extern Status bdt_skeleton_pose_rest(SkeletonPose pose);
        [DllImport(Library)] internal static extern Status bdt_skeleton_pose_play(SkeletonPose pose, UIntPtr clip,
            double time);
        [DllImport(Library)] internal static extern Status bdt_skeleton_pose_blend(SkeletonPose pose, UIntPtr clip,
            double time, double weight);
        [DllImport(Library)] internal static extern Status bdt_skeleton_pose_update(SkeletonPose pose);
        [DllImport(Library)] internal static extern Status bdt_skeleton_pose_local(SkeletonPose pose, UIntPtr node,
            out Local local);
        [DllImport(Library)] internal static extern Status bdt_skeleton_pose_set_local(SkeletonPose pose,
            UIntPtr node, ref Local local);
        [DllImport(Library)] internal static extern Status bdt_skeleton_pose_joints(SkeletonPose pose,
            [Out] Matrix[] joints, UIntPtr count);
        [DllImport(Library)] internal static extern Status bdt_instance_new(Model model, out IntPtr instance);
        [DllImport(Library)] internal static extern Status bdt_instance_free(IntPtr instance);
        [DllImport(Library)] internal static extern Status bdt_instance_set_q(Instance instance, float[] q,
            UIntPtr count);
        [DllImport(Library)] internal static extern Status bdt_instance_set_placement(Instance instance,
            ref Transform at);
        [DllImport(Library)] internal static extern Status bdt_instance_set_pose(Instance instance, float[] q,
            UIntPtr count, ref Transform at);
        [DllImport(Library)] internal static extern Status bdt_instance_set_pose_with_joints(Instance instance,
            float[] q, UIntPtr count, Matrix[] joints, UIntPtr jointCount, ref Transform at);
        [DllImport(Library)] internal static extern Status bdt_instance_set_skeleton_pose(Instance instance,
            SkeletonPose pose);
        [DllImport(Library)] internal static extern Status bdt_instance_set_joints(Instance instance,
            Matrix[] joints, UIntPtr count);
        [DllImport(Library)] internal static extern Status bdt_instance_aabb(Instance instance, out Aabb aabb);
        [DllImport(Library)] internal static extern Status bdt_instance_vertices(Instance instance, uint first,
            UIntPtr count, [Out] Vec3[] vertices);
        [DllImport(Library)] internal static extern Status bdt_front_new(out IntPtr front);
        [DllImport(Library)] internal static extern Status bdt_front_free(IntPtr front);
        [DllImport(Library)] internal static extern Status bdt_workspace_new(out IntPtr workspace);
        [DllImport(Library)] internal static extern Status bdt_workspace_free(IntPtr workspace);
        [DllImport(Library)] internal static extern Status bdt_workspace_set_shared(Workspace workspace, int isShared);
        [DllImport(Library)] internal static extern Status bdt_contacts(Workspace workspace, Instance instance,
            ref Shape shape, [Out] Contact[] items, UIntPtr capacity, out UIntPtr count);
        [DllImport(Library)] internal static extern Status bdt_intersects(Workspace workspace, Instance instance,
            ref Shape shape, out int isTouched);
        [DllImport(Library)] internal static extern Status bdt_project_point(Workspace workspace, Instance instance,
            Vec3 point, double maxDistance, out Hit hit);
        [DllImport(Library)] internal static extern Status bdt_cast_ray(Workspace workspace, Instance instance,
            ref Ray ray, out Hit hit);
        [DllImport(Library)] internal static extern Status bdt_cast_rays(Workspace workspace, Instance instance,
            Ray[] rays, UIntPtr count, [Out] Hit[] hits);
        [DllImport(Library)] internal static extern Status bdt_pair_contacts(Workspace workspace, Instance first,
            Instance second, IntPtr front, double prediction, [Out] PairContact[] items, UIntPtr capacity, out UIntPtr count);
        [DllImport(Library)] internal static extern Status bdt_pair_manifolds(Workspace workspace, Instance first,
            Instance second, IntPtr front, double prediction, [Out] Manifold[] items, UIntPtr capacity, out UIntPtr count);
        [DllImport(Library)] internal static extern Status bdt_pair_closest_points(Workspace workspace,
            Instance first, Instance second, double maxDistance, out PairContact found);
        [DllImport(Library)] internal static extern Status bdt_world_defaults(out WorldOptions options);
        [DllImport(Library)] internal static extern Status bdt_body_defaults(out BodyOptions options);
        [DllImport(Library)] internal static extern Status bdt_world_new(ref WorldOptions options, out IntPtr world);
        [DllImport(Library)] internal static extern Status bdt_world_free(IntPtr world);
        [DllImport(Library)] internal static extern Status bdt_world_add_model(World world, Model model,
            ref BodyOptions options, out uint id);
        [DllImport(Library)] internal static extern Status bdt_world_add_plane(World world, ref Plane plane);
        [DllImport(Library)] internal static extern Status bdt_world_add_body(World world, uint model, uint frame,
            ref Transform at, out uint id);
        [DllImport(Library)] internal static extern Status bdt_world_step(World world, out StepReport report);
        [DllImport(Library)] internal static extern Status bdt_body_state(World world, uint body, out BodyState state);
        [DllImport(Library)] internal static extern Status bdt_body_placement(World world, uint body, out Transform at);
        [DllImport(Library)] internal static extern Status bdt_body_mode_count(World world, uint body,
            out UIntPtr count);
        [DllImport(Library)] internal static extern Status bdt_body_q(World world, uint body, [Out] double[] q,
            IntPtr rate, UIntPtr count);
        [DllImport(Library)] internal static extern Status bdt_world_events(World world, [Out] Event[] items,
            UIntPtr capacity, out UIntPtr count);
        [DllImport(Library)] internal static extern Status bdt_world_cast_ray(World world, ref Ray ray, out Hit hit);
        [DllImport(Library)] internal static extern Status bdt_world_save(World world, [Out] byte[] items,
            UIntPtr capacity, out UIntPtr count);
        [DllImport(Library)] internal static extern Status bdt_world_restore(World world, byte[] bytes, UIntPtr length);
    }
}
