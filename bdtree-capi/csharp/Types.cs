// The structs of bdtree.h, whose comments say units and frames.
using System.Runtime.InteropServices;

namespace Bdtree
{
    /// <summary>Whether a mesh is in a region: all of it, part of it or perhaps, none of it.</summary>
    public enum Region : uint { Inside = 0, Across = 1, Outside = 2 }

    public enum GroupKind : uint { Unknown = 0, Object = 1, Group = 2, Material = 3 }

    /// <summary>How a body's frame moves: by forces, not, or as World.Drive says.</summary>
    public enum BodyFrame : uint { Free = 0, Held = 1, Driven = 2 }

    /// <summary>What of a body touches others: spheres of its tree, its triangles, or the skin of a solid.</summary>
    public enum BodyContact : uint { Spheres = 0, Triangles = 1, Regions = 2 }

    /// <summary>Two bodies have begun to push each other, go on, or do not any more.</summary>
    public enum Phase : uint { Began = 0, Touching = 1, Ended = 2 }

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

        /// <summary>
        /// A joint's matrix to the model's space, of the one to the world's, if this places the instance: for
        /// Instance.SetJoints.
        /// </summary>
        public Matrix JointInModel(Matrix inWorld)
        {
            Native.Check(Native.bdt_joint_in_model(this, inWorld, out Matrix inModel));
            return inModel;
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
    public struct Sphere
    {
        public Vec3 Center;
        public double Radius;
    }

    /// <summary>What a program keeps with an instance.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Tags
    {
        public ulong UserData;
        public uint CollisionGroup, CollisionMask;
    }

    /// <summary>A child of a node of the tree.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Lane
    {
        public uint Node, Index;
    }

    /// <summary>A sphere of a query that ends at a level.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Proxy
    {
        public Lane Lane;
        public Vec3 Center;
        public double Radius;
    }

    /// <summary>What a query within a number of visits may have missed.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Bound
    {
        public uint IsComplete, Reserved;
        public double AtLeast;
        public ulong UnseenTriangles;
    }

    /// <summary>What the last query looked at.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Stats
    {
        public ulong NodesVisited, NodesUpdated, SphereTests;
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

    /// <summary>Triangles of two meshes, or two instances or spheres of a list.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct IndexPair
    {
        public uint First, Second;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct LanePair
    {
        public Lane First, Second;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct LaneTriangle
    {
        public Lane Lane;
        public uint Triangle;
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

    /// <summary>A run of triangles that the source put under one name.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Group
    {
        public GroupKind Kind;
        public uint FirstTriangle, TriangleCount;
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
        public uint HasMass, Level;
        public BodyContact Contact;
        public uint IsDeformable;

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
        public uint Body1, Body2;
        public Phase Phase;
        public uint Reserved;
        public Vec3 Impulse;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct WorldContact
    {
        public uint Body1, Body2, Part1, Part2;
        public Vec3 Point, Normal;
        public double Depth;
        public Vec3 Force;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Energy
    {
        public double Kinetic, Modal, Potential;
    }

    /// <summary>How many bodies a world has, how many of them sleep, and how many steps were taken.</summary>
    public struct Counts
    {
        public uint Bodies, Asleep;
        public ulong Steps;
    }

    /// <summary>Momentum, and angular momentum about the world's origin, of all free bodies.</summary>
    public struct Momenta
    {
        public Vec3 Linear, Angular;
    }
}
