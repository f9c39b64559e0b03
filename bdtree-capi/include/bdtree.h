/*
 * bdtree: collision and proximity queries on deforming meshes p' = p + U q, and worlds of deforming bodies.
 * Made by ci/header from the sources of bdtree-capi. Do not edit: change the comments there.
 *
 * Units and frames. Mesh units are those of the source mesh. World is where an instance's placement puts the mesh:
 * world = rotation * (scale * mesh) + translation. Queries take and return world coordinates and lengths, in double.
 * q is what deforms a mesh: one float per mode. Coordinates are finite and at most 2^100; rotations are quaternions
 * (x, y, z, w) within 1e-3 of unit length.
 *
 * Answers are exact: what brute force over all deformed triangles answers. Meshes are surfaces, not solids; triangles
 * are closed and two-sided; limits are inclusive.
 *
 * Ownership. Handles (BdtModel, BdtInstance, BdtWorkspace, BdtSkeletonPose, BdtFront, BdtWorld) are made by *_new,
 * bdt_model_load, _read and _from_memory, and freed by *_free, in any order. All other memory is yours: functions write
 * to it or read it within the call and keep no pointer to it. An out-pointer must not overlap any other argument.
 *
 * Errors. Functions return a BdtStatus: BDT_OK (0), above 0 when the answer is not whole, below 0 on errors, and then
 * nothing was written, except that counts may be 0, new handles NULL, and batches part of their answers.
 * bdt_last_error has the details. No panic, exception or signal leaves the library, except a bus error where a mapped
 * file is truncated by others (bdt_model_load).
 *
 * What is checked. All builds: NULL; alignment; a word in each handle that tells its kind, and whether it was freed as
 * far as its memory still shows it; handles that a call under way uses (BDT_ERROR_BUSY). Builds with debug assertions
 * (bdt_checks_handles() is 1) know every handle: one that was freed, is of another kind or was never made returns
 * BDT_ERROR_HANDLE and is not read; the few bytes of a freed handle are kept. No build can check that arrays are as
 * long as their counts, or that two threads do not use a handle at once.
 *
 * Threads. Each function says how it may be called; where it says "one thread at a time per X", calls with other Xs may
 * run at once. No function takes a lock, except for the list of handles in builds with debug assertions.
 *
 * Arrays of answers: `out` has room for `capacity` items and may be NULL with 0; `*count` becomes the number of items
 * that there are. If that is more than `capacity`, the first `capacity` are written and BDT_TRUNCATED is returned.
 */
#ifndef BDTREE_H
#define BDTREE_H

#include <stddef.h>
#include <stdint.h>

/** Major version of the interface that the header describes. */
#define BDT_VERSION_MAJOR 0

/** Minor version: while the major one is 0, another minor version may change functions and structs. */
#define BDT_VERSION_MINOR 1

/** Patch version: changes neither functions nor structs. */
#define BDT_VERSION_PATCH 0

/** In place of a number where there is none. */
#define BDT_NONE UINT32_MAX

/** `BdtShape::kind`: all points within `size` of `a`. */
#define BDT_BALL 1

/** `BdtShape::kind`: all points within `size` of the segment from `a` to `b`. */
#define BDT_CAPSULE 2

/** `BdtShape::kind`: the box about `a`, turned by `rotation`, with the half edges `b`. */
#define BDT_CUBOID 3

/** `BdtShape::kind`: all points x with a · x <= size, the normal a being scaled to unit length first. */
#define BDT_HALF_SPACE 4

/** `BdtGroup::kind`: an object of the source. */
#define BDT_GROUP_OBJECT 1

/** `BdtGroup::kind`: a group of the source. */
#define BDT_GROUP_GROUP 2

/** `BdtGroup::kind`: a material of the source. */
#define BDT_GROUP_MATERIAL 3

/** All of the mesh is in the region. */
#define BDT_INSIDE 0

/** Part of the mesh is in the region, or perhaps. */
#define BDT_ACROSS 1

/** None of the mesh is in the region. */
#define BDT_OUTSIDE 2

/** `BdtBodyOptions::contact`: the spheres of a level of its tree touch others. */
#define BDT_CONTACT_SPHERES 0

/** `BdtBodyOptions::contact`: its triangles touch others, from both sides: for thin parts. */
#define BDT_CONTACT_TRIANGLES 1

/** `BdtBodyOptions::contact`: its triangles are the skin of a solid, whose regions of contact push. */
#define BDT_CONTACT_REGIONS 2

/** `BdtEvent::phase`: the two push each other, which they did not in the step before. */
#define BDT_BEGAN 0

/** `BdtEvent::phase`: the two push each other, as in the step before. */
#define BDT_TOUCHING 1

/** `BdtEvent::phase`: the two do not push each other any more. */
#define BDT_ENDED 2

/** How a body's frame moves: by forces. */
#define BDT_FREE 0

/** How a body's frame moves: not; its modes do. */
#define BDT_HELD 1

/** How a body's frame and q move: as `bdt_body_drive` says. */
#define BDT_DRIVEN 2

/**
 * What a function returns: 0 when all went well, above 0 when the answer is not whole, below 0 when there is none.
 */
enum BdtStatus
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /** All went well. */
    BDT_OK = 0,
    /** The array is too short: it holds as many items as fit, and the count says how many there are. */
    BDT_TRUNCATED = 1,
    /** A callback has ended the query. */
    BDT_STOPPED = 2,
    /** A pointer is NULL that must not be. */
    BDT_ERROR_NULL = -1,
    /** A handle of another kind, one that was freed, or an address that is none. */
    BDT_ERROR_HANDLE = -2,
    /**
     * The handle is used by a call under way: the function was called from a callback, by two threads at a time, or
     * with the same handle twice.
     */
    BDT_ERROR_BUSY = -3,
    /**
     * An argument is NaN, infinite, too large, negative where it must not be, not aligned, not UTF-8, or unknown.
     */
    BDT_ERROR_ARGUMENT = -4,
    /** Another number of values than the model, body or clip has. */
    BDT_ERROR_LENGTH = -5,
    /** There is no such triangle, vertex, mode, bone, clip, frame, name, body or model. */
    BDT_ERROR_INDEX = -6,
    /** A file cannot be opened or read. */
    BDT_ERROR_IO = -7,
    /** Bytes that break a rule of the format: no .bdt file, or a damaged one. */
    BDT_ERROR_FORMAT = -8,
    /** A q that is not finite or beyond the limit, a placement or matrix that is not allowed. */
    BDT_ERROR_POSE = -9,
    /** The model has no skin, so neither bones nor clips. */
    BDT_ERROR_NO_SKIN = -10,
    /** The model has no animation, or one without times. */
    BDT_ERROR_NO_ANIMATION = -11,
    /** A world, model or body cannot be made or moved like this. */
    BDT_ERROR_DYNAMICS = -12,
    /** The step is too long for the speed of bodies: the world is not to be stepped on. */
    BDT_ERROR_STEP = -13,
    /** Bytes that are not a saved state of this world. */
    BDT_ERROR_STATE = -14,
    /**
     * A mistake of the library's own, which ended the call. Please report it. Free the handles of the call.
     */
    BDT_ERROR_PANIC = -15,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum BdtStatus BdtStatus;
#else
typedef int32_t BdtStatus;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What a pair of instances keeps from step to step: `bdt_pair_contacts`, `bdt_pair_triangles`, `bdt_pair_intersects` and
 * `bdt_pair_manifolds` give the same answers with it, and visit no node until the two have moved by a margin. Keep the
 * order of the pair. One thread at a time may use it.
 */
typedef struct BdtFront BdtFront;

/**
 * One deforming body: a model, q, bones, a placement, and what queries of a step keep. One thread at a time may use it;
 * where a function says so, several may read it at once.
 */
typedef struct BdtInstance BdtInstance;

/**
 * A `.bdt` file, opened and checked once; shared by any number of instances, which keep what they need of it: it may be
 * freed before them. Any number of threads may read it at once.
 */
typedef struct BdtModel BdtModel;

/** A pose of a model's skeleton with the memory that it takes. One thread at a time may use it. */
typedef struct BdtSkeletonPose BdtSkeletonPose;

/**
 * The memory that queries work in, how they look, and what the last one did. One serves any number of models and
 * instances; one thread at a time may use it: keep one per thread.
 */
typedef struct BdtWorkspace BdtWorkspace;

/**
 * Bodies that fall, touch and vibrate, step by step; the same to the bit for any number of threads. One thread at a time
 * may use it.
 */
typedef struct BdtWorld BdtWorld;

/** A point or vector. */
typedef struct BdtVec3 {
    /** Along the first axis. */
    double x;
    /** Along the second axis. */
    double y;
    /** Along the third axis. */
    double z;
} BdtVec3;

/** A rotation: a quaternion within 1e-3 of unit length. The identity is (0, 0, 0, 1). */
typedef struct BdtQuat {
    /** First imaginary part. */
    double x;
    /** Second imaginary part. */
    double y;
    /** Third imaginary part. */
    double z;
    /** Real part. */
    double w;
} BdtQuat;

/**
 * A closed shape, made by `bdt_ball`, `bdt_capsule`, `bdt_cuboid` or `bdt_half_space`. Coordinates and lengths are
 * finite and at most 2^100; radii and half edges are not negative.
 */
typedef struct BdtShape {
    /** `BDT_BALL`, `BDT_CAPSULE`, `BDT_CUBOID` or `BDT_HALF_SPACE`. */
    uint32_t kind;
    /** 0. */
    uint32_t reserved;
    /** Center, one end, or normal. */
    struct BdtVec3 a;
    /** The other end, or half edges. */
    struct BdtVec3 b;
    /** Of a box. */
    struct BdtQuat rotation;
    /** Radius, or height of the plane along the unit normal. */
    double size;
} BdtShape;

/** What a model has. Lengths are mesh units, those of the source. */
typedef struct BdtModelInfo {
    /** Vertices. */
    uint32_t vertex_count;
    /** Triangles. */
    uint32_t triangle_count;
    /** Modes: how many numbers q has. */
    uint32_t mode_count;
    /** Nodes of the tree. */
    uint32_t node_count;
    /** Levels of the tree. */
    uint32_t depth;
    /** Joints of the skin; 0 without one. */
    uint32_t joint_count;
    /** Bones: joints that move vertices, with an inverse bind matrix each; 0 without a skin. */
    uint32_t bone_count;
    /** Nodes of the skeleton; 0 without a skin. */
    uint32_t skeleton_node_count;
    /** Clips of the skeleton. */
    uint32_t clip_count;
    /** Frames of the animation of q. */
    uint32_t frame_count;
    /** Runs of triangles with names. */
    uint32_t group_count;
    /** 1 if the file says mass, center of mass and inertia. */
    uint32_t has_mass;
    /** Length of the animation of q, seconds; negative without one or without times. */
    double duration_s;
    /** Mesh units per stored unit. */
    double unit;
    /** Where stored coordinates begin, mesh units. */
    struct BdtVec3 origin;
} BdtModelInfo;

/** A mode: one displacement field, moved by one number of q. */
typedef struct BdtMode {
    /** Beyond this |q| is refused. */
    float q_limit;
    /** Typical largest |q|. */
    float q_range;
    /** Angular frequency, rad/s; -1 if unknown. */
    double omega_rad_s;
    /** Modal mass, kg; -1 if unknown. */
    double modal_mass_kg;
    /** The weight of a morph target while nothing moves it; NaN for modes that have none. */
    double default_q;
} BdtMode;

/** Mass properties of a body at rest. */
typedef struct BdtMass {
    /** kg. */
    double mass_kg;
    /** Center of mass, mesh units. */
    struct BdtVec3 center;
    /**
     * About the center of mass, kg · mesh unit²: xx, yy, zz, xy, xz, yz of the tensor (xy is minus the integral of
     * x y dm).
     */
    double inertia[6];
} BdtMass;

/** A run of triangles that the source put under one name (`bdt_model_group_name`). */
typedef struct BdtGroup {
    /** `BDT_GROUP_OBJECT`, `BDT_GROUP_GROUP` or `BDT_GROUP_MATERIAL`; 0 for kinds of later versions. */
    uint32_t kind;
    /** Its first triangle. */
    uint32_t first_triangle;
    /** How many triangles it has. */
    uint32_t triangle_count;
} BdtGroup;

/** Where a mesh stands: world = rotation · (scale · mesh) + translation. */
typedef struct BdtTransform {
    /** From the mesh's axes to the world's. */
    struct BdtQuat rotation;
    /** World units; at most 2^80. */
    struct BdtVec3 translation;
    /** World units per mesh unit: 2^-60 to 2^60. */
    double scale;
} BdtTransform;

/**
 * An affine map of points: row r of the result is `rows[r]` · (x, y, z, 1). Of a joint: from its space to the model's
 * (mesh units).
 */
typedef struct BdtMatrix {
    /** Three rows of four numbers. */
    double rows[3][4];
} BdtMatrix;

/** A box along the axes of the world that holds something. */
typedef struct BdtAabb {
    /** Least coordinates. */
    struct BdtVec3 min;
    /** Largest coordinates. */
    struct BdtVec3 max;
} BdtAabb;

/** A sphere that holds something. World coordinates. */
typedef struct BdtSphere {
    /** Its center. */
    struct BdtVec3 center;
    /** Its radius. */
    double radius;
} BdtSphere;

/** What a program keeps with an instance. */
typedef struct BdtTags {
    /** Any number of the program's own; default 0. */
    uint64_t user_data;
    /** Bits of the groups it is in; default all. */
    uint32_t collision_group;
    /**
     * Bits of the groups it collides with; default all. `bdt_instance_pairs` leaves out pairs of which one's group is
     * not in the other's mask.
     */
    uint32_t collision_mask;
} BdtTags;

/** From a node's space to its parent's. */
typedef struct BdtLocal {
    /** 0: the three parts, which clips animate; 1: `matrix`, which nothing animates. */
    uint32_t is_matrix;
    /** 0. */
    uint32_t reserved;
    /** In units of the parent's space. */
    struct BdtVec3 translation;
    /** Normalised where it is used. */
    struct BdtQuat rotation;
    /** Of each axis; negative numbers mirror. */
    struct BdtVec3 scale;
    /** Any affine map. */
    struct BdtMatrix matrix;
} BdtLocal;

/** A lane of a node of the tree: one of its eight children. */
typedef struct BdtLane {
    /** The node. */
    uint32_t node;
    /** Below 8. */
    uint32_t lane;
} BdtLane;

/** A sphere of a query that ends at a level: it holds the deformed triangles below a lane. */
typedef struct BdtProxy {
    /** The lane. */
    struct BdtLane lane;
    /** Its center. */
    struct BdtVec3 center;
    /** Its radius. */
    double radius;
} BdtProxy;

/** What a query within a number of visits may have missed. */
typedef struct BdtBound {
    /** 1 if nothing was left out: the answer is the one without a limit. */
    uint32_t is_complete;
    /** 0. */
    uint32_t reserved;
    /**
     * Certified: without a limit the distance is not below this; of contacts that were left out, no distance is.
     */
    double at_least;
    /** Of contacts: at most so many triangles were neither tested nor ruled out. */
    uint64_t unseen_triangles;
} BdtBound;

/** What the last query of a workspace looked at; of a batch the sum. */
typedef struct BdtStats {
    /** Nodes whose spheres were tested. */
    uint64_t nodes_visited;
    /** Of them, those whose spheres were evaluated: all but what a step cache kept. */
    uint64_t nodes_updated;
    /** Pairs of spheres that the broad phase compared. */
    uint64_t sphere_tests;
} BdtStats;

/** A shape touches a triangle. */
typedef struct BdtContact {
    /** The triangle: its number among the source's. */
    uint32_t triangle;
    /** Of a world's answer the body, else 0. */
    uint32_t body;
    /** The triangle's point. */
    struct BdtVec3 point;
    /** Unit, from the triangle towards the shape. */
    struct BdtVec3 normal;
    /** Negative is penetration depth. To separate the two at `point`, move the mesh by distance · normal. */
    double distance;
    /** Weights of the triangle's corners that give `point`; their sum is 1. */
    struct BdtVec3 barycentric;
} BdtContact;

/**
 * Takes a contact, which is gone when it returns. Returns 0 to go on, anything else to end the query. It must neither
 * throw nor jump away; calls with the same workspace or instance return `BDT_ERROR_BUSY`.
 */
typedef int32_t (*BdtOnContact)(const struct BdtContact *contact, void *context);

/** The point of a mesh that a ray meets, or that is nearest to a point. */
typedef struct BdtHit {
    /**
     * The triangle, the lowest number of those at the same distance; `BDT_NONE` when nothing was found, and then all
     * other numbers are 0.
     */
    uint32_t triangle;
    /**
     * Where several rays, instances or bodies are asked at once: the one that it is of, as the function says. Else 0.
     */
    uint32_t index;
    /** The point. */
    struct BdtVec3 point;
    /**
     * Unit. Of a ray: the triangle's, on the side that the ray comes from. Of a nearest point: from it towards the given
     * point, or the triangle's own where the two coincide.
     */
    struct BdtVec3 normal;
    /** From the ray's origin or the given point. */
    double distance;
    /** Weights of the triangle's corners that give `point`; their sum is 1. */
    struct BdtVec3 barycentric;
} BdtHit;

/** A ray from `origin` along `direction`. */
typedef struct BdtRay {
    /** Finite, at most 2^100. */
    struct BdtVec3 origin;
    /** Finite, not zero, of any length. */
    struct BdtVec3 direction;
    /** Not negative; INFINITY (or anything above 2^100) for a ray without end. */
    double max_distance;
} BdtRay;

/** Takes a hit, as `BdtOnContact` a contact. */
typedef int32_t (*BdtOnHit)(const struct BdtHit *hit, void *context);

/** A plane (n, d) of a region: the points x with n · x + d >= 0. The normal may have any length but 0. */
typedef struct BdtPlane {
    /** Into the region. */
    struct BdtVec3 normal;
    /** Minus the height of the plane along the normal, times the normal's length. */
    double d;
} BdtPlane;

/** Two triangles touch, or are near each other. */
typedef struct BdtPairContact {
    /** The first mesh's triangle; `BDT_NONE` when nothing was found, and then all other numbers are 0. */
    uint32_t triangle1;
    /** The second mesh's triangle. */
    uint32_t triangle2;
    /** The first triangle's point. */
    struct BdtVec3 point1;
    /** The second triangle's point; equal to `point1` when they touch. */
    struct BdtVec3 point2;
    /** Unit, at `point1`: towards `point2`; where the triangles touch, the first triangle's own normal. */
    struct BdtVec3 normal1;
    /** Unit, at `point2`: towards `point1`; where the triangles touch, the second triangle's own normal. */
    struct BdtVec3 normal2;
    /** 0 when they touch. */
    double distance;
    /** Weights of the first triangle's corners that give `point1`. */
    struct BdtVec3 barycentric1;
    /** Weights of the second triangle's corners that give `point2`. */
    struct BdtVec3 barycentric2;
} BdtPairContact;

/** Takes a contact of two instances, as `BdtOnContact` a contact. */
typedef int32_t (*BdtOnPairContact)(const struct BdtPairContact *contact, void *context);

/** Two numbers that belong together: triangles of two meshes, or two instances or spheres of a list. */
typedef struct BdtIndexPair {
    /** Of the first. */
    uint32_t first;
    /** Of the second. */
    uint32_t second;
} BdtIndexPair;

/** A point of a region of contact. */
typedef struct BdtManifoldPoint {
    /** On the first mesh: where a line along the region's `normal1` leaves it. */
    struct BdtVec3 point1;
    /** On the second mesh: where the same line, followed backwards, leaves it. */
    struct BdtVec3 point2;
    /** (point2 - point1) · normal1: negative is penetration depth, positive a gap. */
    double distance;
    /** The part of the region's area that it stands for. */
    double area;
    /** Weights of the corners of `triangle1` that give `point1`. */
    struct BdtVec3 barycentric1;
    /** Weights of the corners of `triangle2` that give `point2`. */
    struct BdtVec3 barycentric2;
    /** The first mesh's triangle. */
    uint32_t triangle1;
    /** The second mesh's triangle. */
    uint32_t triangle2;
} BdtManifoldPoint;

/** A connected region of contact, condensed to one point or four. */
typedef struct BdtManifold {
    /** Unit, from the first mesh to the second. */
    struct BdtVec3 normal1;
    /** Unit, from the second mesh to the first. */
    struct BdtVec3 normal2;
    /** Of the region's projection along the normal (world units²). */
    double area;
    /** How far the two overlap along the normal; 0 where they do not. */
    double depth;
    /** The first mesh's triangle of the region's lowest pair. */
    uint32_t triangle1;
    /** The second mesh's triangle of the region's lowest pair. */
    uint32_t triangle2;
    /** How many of `points` there are: 1 or 4. */
    uint32_t point_count;
    /** 0. */
    uint32_t reserved;
    /** Its points; those behind `point_count` are 0, their triangles `BDT_NONE`. */
    struct BdtManifoldPoint points[4];
} BdtManifold;

/** Lanes of two trees whose spheres are near each other. */
typedef struct BdtLanePair {
    /** Of the first mesh. */
    struct BdtLane first;
    /** Of the second mesh. */
    struct BdtLane second;
} BdtLanePair;

/** A lane of the first tree and a triangle of the second mesh that is near its sphere. */
typedef struct BdtLaneTriangle {
    /** Of the first mesh. */
    struct BdtLane lane;
    /** Of the second mesh. */
    uint32_t triangle;
} BdtLaneTriangle;

/** What holds for all bodies of a world; `bdt_world_defaults` writes the usual values. */
typedef struct BdtWorldOptions {
    /** Length of a step, seconds; default 1/150. */
    double step_s;
    /** World units per s²; default 9.81 downwards along y. */
    struct BdtVec3 gravity;
    /**
     * Stiffness k of a contact over m / h², with the effective mass m of what meets and the step h: 0 to 1000; default 1.
     */
    double stiffness;
    /** Of a contact: 0 to 10; default 0.2. */
    double damping_ratio;
    /** Coulomb's coefficient: 0 to 10; default 0.4. */
    double friction;
    /** Sweeps over the contacts end when one changes forces by less than this share: 0 to 1; default 1e-3. */
    double accuracy;
    /**
     * World units per second: bodies that have been slower for half a second fall asleep; 0: never. Default 0.01.
     */
    double sleep_speed;
    /** Most sweeps over the contacts in a step; default 50. */
    uint32_t sweeps;
    /** Threads that step, 1 to 256; default 1. The answers are the same for any number. */
    uint32_t threads;
} BdtWorldOptions;

/** How bodies of a model are made; `bdt_body_defaults` writes the usual values. */
typedef struct BdtBodyOptions {
    /** World units per mesh unit; default 1. */
    double scale;
    /** Mass properties, if `has_mass` is not 0; else those of the model. */
    struct BdtMass mass;
    /**
     * Thickness of the thinnest wall of a body with `BDT_CONTACT_REGIONS`, world units; 0 or less (the default): found by
     * rays.
     */
    double thinnest_wall;
    /** Damping ratio of all modes, if `mass_per_s` and `stiffness_s` are 0; default 0.05. */
    double damping_ratio;
    /** Rayleigh damping: share of the mass matrix, 1/s; default 0. */
    double mass_per_s;
    /** Rayleigh damping: share of the stiffness matrix, s; default 0. */
    double stiffness_s;
    /** In multiples of each mode's `q_range`; INFINITY for `q_limit`. Default 1. */
    double strain_limit;
    /** Whether `mass` is used; default 0. */
    uint32_t has_mass;
    /** Level of the contact spheres; `BDT_NONE` (the default): the one that has about a thousand. */
    uint32_t level;
    /** `BDT_CONTACT_SPHERES` (the default), `BDT_CONTACT_TRIANGLES` or `BDT_CONTACT_REGIONS`. */
    uint32_t contact;
    /** Whether the modes move; default 1. */
    uint32_t is_deformable;
} BdtBodyOptions;

/** What a step did. */
typedef struct BdtStepReport {
    /** Pairs of contact spheres, triangles or regions in contact. */
    uint64_t contacts;
    /** Of them, those that were found when they overlapped already. */
    uint64_t late;
    /** Pairs of bodies, planes included, that are near each other. */
    uint64_t pairs;
    /** Pairs of contact spheres that the trees found. */
    uint64_t candidates;
    /** Nodes of the trees that were looked at. */
    uint64_t nodes_visited;
    /** Nodes whose bounds were computed. */
    uint64_t nodes_updated;
    /** Sweeps over the contacts. */
    uint64_t sweeps;
    /** Parts that the step was divided into. */
    uint64_t parts;
    /** Largest overlap at the beginning of the step, world units. */
    double penetration;
    /** The same as a share of the larger radius. */
    double penetration_rel;
    /** Energy in the contacts at the beginning of the step, J. */
    double contact_energy;
    /** How long the step took, seconds by the clock. */
    double time_s;
} BdtStepReport;

/** Two bodies, or a body and a plane, in a step. */
typedef struct BdtEvent {
    /** The first body. */
    uint32_t body1;
    /** The second body; `BDT_NONE` for a plane. */
    uint32_t body2;
    /** `BDT_BEGAN`, `BDT_TOUCHING` or `BDT_ENDED`. */
    uint32_t phase;
    /** 0. */
    uint32_t reserved;
    /** What the step's contact forces have added to the first body's momentum, N s. */
    struct BdtVec3 impulse;
} BdtEvent;

/** A contact of the last step. */
typedef struct BdtWorldContact {
    /** The first body. */
    uint32_t body1;
    /** The second body; `BDT_NONE` for a plane. */
    uint32_t body2;
    /** The first body's contact sphere or triangle. */
    uint32_t part1;
    /** The second body's contact sphere or triangle; 0 of a plane. */
    uint32_t part2;
    /** Where forces act. */
    struct BdtVec3 point;
    /** Unit, from the second body to the first. */
    struct BdtVec3 normal;
    /** Overlap at the beginning of the step, world units; negative is a gap. */
    double depth;
    /** On the first body, N. */
    struct BdtVec3 force;
} BdtWorldContact;

/** Energies of a world, J where world units are meters. */
typedef struct BdtEnergy {
    /** Of the frames' motion. */
    double kinetic;
    /** Of the modes: motion and deformation. */
    double modal;
    /** In the field of gravity, above the world's origin. */
    double potential;
} BdtEnergy;

/** Position, orientation and speeds of a body. World axes. */
typedef struct BdtBodyState {
    /** Center of mass (without mass properties the mesh's origin), world units. */
    struct BdtVec3 position;
    /** From the principal axes of inertia (or the mesh's axes) to the world's. */
    struct BdtQuat orientation;
    /** World units per second. */
    struct BdtVec3 velocity;
    /** About the center of mass, kg · world unit² / s. */
    struct BdtVec3 angular_momentum;
    /** rad/s. */
    struct BdtVec3 angular_velocity;
} BdtBodyState;

/** All of them. */
#define BdtStatus_ALL { BdtStatus_Ok, BdtStatus_Truncated, BdtStatus_Stopped, BdtStatus_ErrorNull, BdtStatus_ErrorHandle, BdtStatus_ErrorBusy, BdtStatus_ErrorArgument, BdtStatus_ErrorLength, BdtStatus_ErrorIndex, BdtStatus_ErrorIo, BdtStatus_ErrorFormat, BdtStatus_ErrorPose, BdtStatus_ErrorNoSkin, BdtStatus_ErrorNoAnimation, BdtStatus_ErrorDynamics, BdtStatus_ErrorStep, BdtStatus_ErrorState, BdtStatus_ErrorPanic, }

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Returns the version of the library: major · 10^6 + minor · 10^3 + patch. Compare it with the header's
 * `BDT_VERSION_MAJOR` and `BDT_VERSION_MINOR`, which must be the same. Thread-safety: any thread, any time.
 */
uint32_t bdt_version(void);

/**
 * Returns the version of the library as text, for example "0.1.0": static, never NULL. Thread-safety: any thread, any
 * time.
 */
const char *bdt_version_text(void);

/**
 * Returns 1 if the library knows which handles live, so that freed and foreign ones return `BDT_ERROR_HANDLE`
 * instead of being read: builds with debug assertions. Else 0. Thread-safety: any thread, any time.
 */
int32_t bdt_checks_handles(void);

/**
 * Returns what a status means, in a few words: a static text, never NULL, also for numbers that are no status.
 * Thread-safety: any thread, any time.
 */
const char *bdt_status_text(int32_t status);

/**
 * Writes what went wrong in this thread's last call that returned an error: one line of UTF-8 that names the argument,
 * or file, rule and place. `buffer` gets at most `capacity` bytes, the closing 0 included; `length` (may be NULL) the
 * bytes of the whole text without the 0. The text is empty before the first error; calls that succeed leave it.
 * Ownership: `buffer` is yours. Errors: `BDT_TRUNCATED` (the text was cut), `BDT_ERROR_NULL`.
 * Thread-safety: any thread; each has its own text.
 */
BdtStatus bdt_last_error(char *buffer, size_t capacity, size_t *length);

/** Makes a ball from its center and radius (world). Checked by the call that takes it. Thread-safety: any. */
struct BdtShape bdt_ball(struct BdtVec3 center, double radius);

/**
 * Makes a capsule from the ends of its segment and its radius (world). Checked by the call that takes it.
 * Thread-safety: any.
 */
struct BdtShape bdt_capsule(struct BdtVec3 a, struct BdtVec3 b, double radius);

/**
 * Makes a box from its center, the rotation from its axes to the world's, and half its edges along its own axes (world
 * units). Checked by the call that takes it. Thread-safety: any.
 */
struct BdtShape bdt_cuboid(struct BdtVec3 center, struct BdtQuat rotation, struct BdtVec3 half_extents);

/**
 * Makes the half-space below the plane at height `offset` along the normal (world), which may have any length but 0.
 * Checked by the call that takes it. Thread-safety: any.
 */
struct BdtShape bdt_half_space(struct BdtVec3 normal, double offset);

/**
 * Opens a file by mapping it: pages are read when queries touch them. Header and tables are checked;
 * `bdt_model_verify` checks the rest.
 * `path`: UTF-8, closed by 0. The file must not be changed or truncated while the model or an instance of it lives;
 * replacing it by renaming another over it is safe. Use `bdt_model_read` where others may change it.
 * Ownership: `*out` is yours, to be freed by `bdt_model_free`; NULL on errors.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_ARGUMENT` (a path that is not UTF-8), `BDT_ERROR_IO`, `BDT_ERROR_FORMAT`.
 * Thread-safety: any thread.
 */
BdtStatus bdt_model_load(const char *path, struct BdtModel **out);

/** Opens a file by reading all of it into memory, which nobody else can change. Else as `bdt_model_load`. */
BdtStatus bdt_model_read(const char *path, struct BdtModel **out);

/**
 * Opens the bytes of a file, at any address: they are copied, and `bytes` may be freed at once.
 * Ownership: `*out` is yours, to be freed by `bdt_model_free`; NULL on errors.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_FORMAT`. Thread-safety: any thread.
 */
BdtStatus bdt_model_from_memory(const uint8_t *bytes, size_t length, struct BdtModel **out);

/**
 * Frees a model; instances of it live on. NULL is nothing.
 * Errors: `BDT_ERROR_HANDLE`. Thread-safety: no other thread may use the handle meanwhile or afterwards.
 */
BdtStatus bdt_model_free(struct BdtModel *model);

/**
 * Writes what a model has.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`. Thread-safety: any number of threads at once.
 */
BdtStatus bdt_model_info(struct BdtModel *model, struct BdtModelInfo *out);

/**
 * Writes what is known of a mode.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_INDEX`. Thread-safety: any number of threads at once.
 */
BdtStatus bdt_model_mode(struct BdtModel *model, size_t index, struct BdtMode *out);

/**
 * Writes mass, center of mass and inertia of the undeformed mesh, where the file says them (`BdtModelInfo::has_mass`).
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_INDEX` (the file says none). Thread-safety: any number of threads at
 * once.
 */
BdtStatus bdt_model_mass(struct BdtModel *model, struct BdtMass *out);

/**
 * Writes a group.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_INDEX`. Thread-safety: any number of threads at once.
 */
BdtStatus bdt_model_group(struct BdtModel *model, size_t index, struct BdtGroup *out);

/**
 * Writes the three vertices of each of `count` triangles from `first` on, three numbers each, to `corners`.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_INDEX` (triangles that the model does not have), `BDT_ERROR_FORMAT` (a damaged
 * file). Thread-safety: any number of threads at once.
 */
BdtStatus bdt_model_triangles(struct BdtModel *model, uint32_t first, size_t count, uint32_t *corners);

/**
 * Checks everything that opening does not read: checksums, indices, numbers, and that every stored bound holds. It reads
 * the whole file several times: for tools, and once for files of unknown origin.
 * Errors: `BDT_ERROR_FORMAT`; `bdt_last_error` says the first rule that is broken, and where. `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`.
 * Thread-safety: any number of threads at once.
 */
BdtStatus bdt_model_verify(struct BdtModel *model);

/**
 * Checks the checksums of all sections, which finds damage by accident: what to do with a file before it is trusted.
 * Errors: as `bdt_model_verify`. Thread-safety: any number of threads at once.
 */
BdtStatus bdt_model_verify_checksums(struct BdtModel *model);

/**
 * Writes the q of a frame of the animation, its placement (mesh units to mesh units: the rigid motion that the bake took
 * out) and when it is shown.
 * `q`: `count` numbers, as many as the model has modes. `at` and `time_s` (seconds; -1 without times) may be NULL.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_INDEX`, `BDT_ERROR_LENGTH`. Thread-safety: any number of threads at once.
 */
BdtStatus bdt_model_frame(struct BdtModel *model,
                          size_t index,
                          float *q,
                          size_t count,
                          struct BdtTransform *at,
                          double *time_s);

/**
 * Writes the pose of the animation at a time (seconds), between its frames by interpolation: q, and the placement that
 * goes with it. A loop is `fmod(time, duration)`.
 * `q`: `count` numbers, as many as the model has modes. `at` may be NULL.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_NO_ANIMATION`, `BDT_ERROR_ARGUMENT` (a time that is not finite), `BDT_ERROR_LENGTH`.
 * Thread-safety: any number of threads at once.
 */
BdtStatus bdt_model_sample(struct BdtModel *model, double time_s, float *q, size_t count, struct BdtTransform *at);

/**
 * Writes the joint that carries most of a point of a triangle (of a contact or hit: its `triangle` and `barycentric`):
 * which part of a character was hit. `BDT_NONE` without a skin, or where no bone moves the point.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_INDEX`, `BDT_ERROR_FORMAT` (a damaged file). Thread-safety: any number of threads
 * at once.
 */
BdtStatus bdt_model_joint_of(struct BdtModel *model,
                             uint32_t triangle,
                             struct BdtVec3 barycentric,
                             uint32_t *joint);

/**
 * Writes the name of a mode, as the source called the morph target or field; empty if it has none.
 * `buffer` gets at most `capacity` bytes of UTF-8, the closing 0 included; `length` (may be NULL) the bytes of the whole
 * name without the 0.
 * Errors: `BDT_TRUNCATED` (the name was cut), `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_INDEX`.
 * Thread-safety: any number of threads at once.
 */
BdtStatus bdt_model_mode_name(struct BdtModel *model,
                              size_t index,
                              char *buffer,
                              size_t capacity,
                              size_t *length);

/**
 * Writes the mode of a name (UTF-8, closed by 0), the first of several: its place in q.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_ARGUMENT` (not UTF-8), `BDT_ERROR_INDEX` (no such name).
 * Thread-safety: any number of threads at once.
 */
BdtStatus bdt_model_mode_index(struct BdtModel *model, const char *name, size_t *index);

/**
 * Writes the name of a joint, as `bdt_model_mode_name` does.
 * Errors: its errors; `BDT_ERROR_NO_SKIN`. Thread-safety: any number of threads at once.
 */
BdtStatus bdt_model_joint_name(struct BdtModel *model,
                               size_t index,
                               char *buffer,
                               size_t capacity,
                               size_t *length);

/**
 * Writes the joint of a name, the first of several.
 * Errors: those of `bdt_model_mode_index`; `BDT_ERROR_NO_SKIN`. Thread-safety: any number of threads at once.
 */
BdtStatus bdt_model_joint_index(struct BdtModel *model, const char *name, size_t *index);

/**
 * Writes the joint that moves another one; `BDT_NONE` for a root.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_NO_SKIN`, `BDT_ERROR_INDEX`. Thread-safety: any number of threads at once.
 */
BdtStatus bdt_model_joint_parent(struct BdtModel *model, size_t index, uint32_t *parent);

/**
 * Writes the name of a clip, as `bdt_model_mode_name` does.
 * Errors: its errors; `BDT_ERROR_NO_SKIN`. Thread-safety: any number of threads at once.
 */
BdtStatus bdt_model_clip_name(struct BdtModel *model,
                              size_t index,
                              char *buffer,
                              size_t capacity,
                              size_t *length);

/**
 * Writes the clip of a name, the first of several.
 * Errors: those of `bdt_model_mode_index`; `BDT_ERROR_NO_SKIN`. Thread-safety: any number of threads at once.
 */
BdtStatus bdt_model_clip_index(struct BdtModel *model, const char *name, size_t *index);

/**
 * Writes how long a clip lasts: seconds from time 0 to its last key.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_NO_SKIN`, `BDT_ERROR_INDEX`. Thread-safety: any number of threads at once.
 */
BdtStatus bdt_model_clip_duration(struct BdtModel *model, size_t index, double *duration_s);

/**
 * Writes the name of a group, as `bdt_model_mode_name` does.
 * Errors: its errors. Thread-safety: any number of threads at once.
 */
BdtStatus bdt_model_group_name(struct BdtModel *model,
                               size_t index,
                               char *buffer,
                               size_t capacity,
                               size_t *length);

/**
 * Makes an instance at q = 0, at rest, placed where the mesh is, with a step cache of 64 nodes and 32 leaves (14 KB).
 * Ownership: `*out` is yours, to be freed by `bdt_instance_free`; NULL on errors. The model may be freed before it.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`. Thread-safety: any number of threads at once.
 */
BdtStatus bdt_instance_new(struct BdtModel *model, struct BdtInstance **out);

/**
 * The same with a step cache of another size, which keeps what queries of one pose compute: 0 and 0 for bodies that are
 * queried once per step. A node takes 160 bytes, a leaf 128.
 * Ownership, errors, thread-safety: as `bdt_instance_new`; `BDT_ERROR_ARGUMENT` beyond 2^24 of either.
 */
BdtStatus bdt_instance_new_with_cache(struct BdtModel *model, size_t nodes, size_t leaves, struct BdtInstance **out);

/**
 * Frees an instance. NULL is nothing.
 * Errors: `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY` (from a callback of a call that uses it). Thread-safety: no other thread
 * may use the handle meanwhile or afterwards.
 */
BdtStatus bdt_instance_free(struct BdtInstance *instance);

/**
 * Sets q: `count` numbers, as many as the model has modes. Placement and bones stay. On errors nothing changes.
 * Of a vibration mode 1 moves the farthest vertex by one mesh unit; of a morph target 1 is the whole target.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_LENGTH`, `BDT_ERROR_POSE` (not finite, or beyond `BdtMode::q_limit`).
 * Thread-safety: one thread at a time per instance.
 */
BdtStatus bdt_instance_set_q(struct BdtInstance *instance, const float *q, size_t count);

/**
 * Writes q as queries use it: `count` numbers, as many as the model has modes.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_LENGTH`. Thread-safety: several threads may read an instance at
 * once.
 */
BdtStatus bdt_instance_q(struct BdtInstance *instance,
                         float *q,
                         size_t count);

/**
 * Sets the placement. q and bones stay. On errors nothing changes.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_POSE`. Thread-safety: one thread at a time per instance.
 */
BdtStatus bdt_instance_set_placement(struct BdtInstance *instance, const struct BdtTransform *at);

/**
 * Lets queries refine the pose by themselves where a step asks so much that it pays (some 500 rays for 36000 triangles), or
 * not any more: 0 for no. It takes some 65 bytes per triangle then. Answers stay the same. Queries of workspaces whose
 * instances are shared do without.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`. Thread-safety: one thread at a time per instance.
 */
BdtStatus bdt_instance_set_refining(struct BdtInstance *instance,
                                    int32_t on);

/**
 * Writes the placement, as it was given.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`. Thread-safety: several threads may read an instance at once.
 */
BdtStatus bdt_instance_placement(struct BdtInstance *instance, struct BdtTransform *out);

/**
 * Sets q and the placement, faster than one after the other. Bones stay. On errors nothing changes.
 * Errors and thread-safety: as `bdt_instance_set_q` and `bdt_instance_set_placement`.
 */
BdtStatus bdt_instance_set_pose(struct BdtInstance *instance, const float *q, size_t count, const struct BdtTransform *at);

/**
 * Moves the bones: `count` matrices, one per joint of the model, each from the joint's space to the model's (mesh
 * units), without inverse bind matrices (`bdt_joint_in_model` makes them from matrices of world space). q and placement
 * stay. On errors nothing changes.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_NO_SKIN`, `BDT_ERROR_LENGTH`, `BDT_ERROR_POSE` (a matrix that is not finite).
 * Thread-safety: one thread at a time per instance.
 */
BdtStatus bdt_instance_set_joints(struct BdtInstance *instance, const struct BdtMatrix *joints, size_t count);

/**
 * Moves the bones: `count` matrices, one per bone of the model, joint matrix times inverse bind matrix, as skinning
 * shaders take them. Else as `bdt_instance_set_joints`.
 */
BdtStatus bdt_instance_set_skinning_matrices(struct BdtInstance *instance, const struct BdtMatrix *bones, size_t count);

/**
 * Sets q, moves the bones by one matrix per joint and places the instance, faster than one after the other. On errors
 * nothing changes. `joints` may be NULL with `joint_count` 0: bones at rest.
 * Errors and thread-safety: as `bdt_instance_set_q`, `bdt_instance_set_joints` and `bdt_instance_set_placement`.
 */
BdtStatus bdt_instance_set_pose_with_joints(struct BdtInstance *instance,
                                            const float *q,
                                            size_t count,
                                            const struct BdtMatrix *joints,
                                            size_t joint_count,
                                            const struct BdtTransform *at);

/**
 * Writes a box that holds the deformed mesh in the world, conservatively: it follows q, bones and placement, and costs
 * one node.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_FORMAT` (a damaged file). Thread-safety: several threads may
 * read an instance at once.
 */
BdtStatus bdt_instance_aabb(struct BdtInstance *instance, struct BdtAabb *out);

/**
 * Writes the smallest box around the deformed mesh in the world: it computes every triangle. For tools.
 * Errors and thread-safety: as `bdt_instance_aabb`.
 */
BdtStatus bdt_instance_exact_aabb(struct BdtInstance *instance, struct BdtAabb *out);

/**
 * Writes a sphere that holds the deformed mesh in the world, conservatively.
 * Errors and thread-safety: as `bdt_instance_aabb`.
 */
BdtStatus bdt_instance_bounding_sphere(struct BdtInstance *instance, struct BdtSphere *out);

/**
 * Writes where `count` vertices from `first` on are in the world, as queries compute them.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_INDEX` (vertices that the model does not have), `BDT_ERROR_FORMAT` (a
 * damaged file). Thread-safety: several threads may read an instance at once.
 */
BdtStatus bdt_instance_vertices(struct BdtInstance *instance, uint32_t first, size_t count, struct BdtVec3 *out);

/**
 * Adds the generalised force of a world force that acts on a point of a triangle to `forces`: Uᵀ f, one number per mode
 * (world units · force per unit of q). `forces` holds `count` numbers, as many as the model has modes, which are read
 * and changed. Weights and force are not checked.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_INDEX`, `BDT_ERROR_LENGTH`, `BDT_ERROR_FORMAT` (a damaged file). Thread-safety:
 * several threads may read an instance at once.
 */
BdtStatus bdt_instance_add_generalized_force(struct BdtInstance *instance,
                                             uint32_t triangle,
                                             struct BdtVec3 barycentric,
                                             struct BdtVec3 force,
                                             double *forces,
                                             size_t count);

/**
 * Sets user data and collision groups.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`. Thread-safety: one thread at a time per instance.
 */
BdtStatus bdt_instance_set_tags(struct BdtInstance *instance, const struct BdtTags *tags);

/**
 * Writes user data and collision groups.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`. Thread-safety: several threads may read an instance at once.
 */
BdtStatus bdt_instance_tags(struct BdtInstance *instance, struct BdtTags *out);

/**
 * Writes the placement that does what `first` does and then what `then` does. `out` may be one of them.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_POSE`. Thread-safety: any thread.
 */
BdtStatus bdt_transform_after(struct BdtTransform then, struct BdtTransform first, struct BdtTransform *out);

/**
 * Writes the matrix of a joint from its space to the model's (mesh units), of one from its space to the world's, and of
 * the instance's placement `at`, which is not checked: what `bdt_instance_set_joints` takes.
 * Errors: `BDT_ERROR_NULL`. Thread-safety: any thread.
 */
BdtStatus bdt_joint_in_model(struct BdtTransform at, struct BdtMatrix in_world, struct BdtMatrix *out);

/**
 * Makes a pose at rest.
 * Ownership: `*out` is yours, to be freed by `bdt_skeleton_pose_free`; NULL on errors. The model may be freed before it.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_NO_SKIN`, `BDT_ERROR_FORMAT` (a damaged file). Thread-safety: any number of
 * threads at once.
 */
BdtStatus bdt_skeleton_pose_new(struct BdtModel *model,
                                struct BdtSkeletonPose **out);

/**
 * Frees a pose. NULL is nothing.
 * Errors: `BDT_ERROR_HANDLE`. Thread-safety: no other thread may use the handle meanwhile or afterwards.
 */
BdtStatus bdt_skeleton_pose_free(struct BdtSkeletonPose *pose);

/**
 * Goes to the pose at rest; q holds the default weights of morph targets.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_FORMAT` (a damaged file). Thread-safety: one thread at a time
 * per pose.
 */
BdtStatus bdt_skeleton_pose_rest(struct BdtSkeletonPose *pose);

/**
 * Goes to the pose of a clip at a time (seconds). A loop is `fmod(time, duration)`.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_INDEX` (no such clip), `BDT_ERROR_ARGUMENT` (a time that is not finite),
 * `BDT_ERROR_FORMAT` (a damaged file). Thread-safety: one thread at a time per pose.
 */
BdtStatus bdt_skeleton_pose_play(struct BdtSkeletonPose *pose,
                                 size_t clip,
                                 double time_s);

/**
 * Goes from the present pose towards that of a clip at a time, by `weight`: 0 stays, 1 is `bdt_skeleton_pose_play`.
 * Errors: those of `bdt_skeleton_pose_play`; `BDT_ERROR_ARGUMENT` (a weight that is not finite). Thread-safety: one thread at a
 * time per pose.
 */
BdtStatus bdt_skeleton_pose_blend(struct BdtSkeletonPose *pose, size_t clip, double time_s, double weight);

/**
 * Writes the transform of a node of the skeleton to its parent.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_INDEX`. Thread-safety: several threads may read a pose at once.
 */
BdtStatus bdt_skeleton_pose_local(struct BdtSkeletonPose *pose,
                                  size_t node,
                                  struct BdtLocal *out);

/**
 * Sets the transform of a node of the skeleton to its parent: a head that looks somewhere. Call
 * `bdt_skeleton_pose_update` after the last one.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_INDEX`. Thread-safety: one thread at a time per pose.
 */
BdtStatus bdt_skeleton_pose_set_local(struct BdtSkeletonPose *pose, size_t node, const struct BdtLocal *local);

/**
 * Computes the matrices of nodes and joints from the transforms of nodes.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_FORMAT` (a damaged file). Thread-safety: one thread at a time
 * per pose.
 */
BdtStatus bdt_skeleton_pose_update(struct BdtSkeletonPose *pose);

/**
 * Writes one matrix per joint of the model, from its space to the model's (mesh units): what `bdt_instance_set_joints`
 * takes.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_LENGTH`. Thread-safety: several threads may read a pose at
 * once.
 */
BdtStatus bdt_skeleton_pose_joints(struct BdtSkeletonPose *pose, struct BdtMatrix *joints, size_t count);

/**
 * Writes one matrix per node of the skeleton, from its space to the model's (mesh units): where to hang a sword.
 * Errors and thread-safety: as `bdt_skeleton_pose_joints`.
 */
BdtStatus bdt_skeleton_pose_nodes(struct BdtSkeletonPose *pose, struct BdtMatrix *nodes, size_t count);

/**
 * Writes q of the pose, one number per mode.
 * Errors and thread-safety: as `bdt_skeleton_pose_joints`.
 */
BdtStatus bdt_skeleton_pose_q(struct BdtSkeletonPose *pose, float *q, size_t count);

/**
 * Gives an instance of the model q and joints of the pose; its placement stays. On errors it stays as it was.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_NO_SKIN`, `BDT_ERROR_LENGTH` (of another model), `BDT_ERROR_POSE`. Thread-safety:
 * one thread at a time per instance; several threads may read a pose at once.
 */
BdtStatus bdt_instance_set_skeleton_pose(struct BdtInstance *instance,
                                         struct BdtSkeletonPose *pose);

/**
 * Makes a workspace. It grows to what the largest query so far has needed.
 * Ownership: `*out` is yours, to be freed by `bdt_workspace_free`; NULL on errors.
 * Errors: `BDT_ERROR_NULL`. Thread-safety: any thread.
 */
BdtStatus bdt_workspace_new(struct BdtWorkspace **out);

/**
 * Frees a workspace. NULL is nothing.
 * Errors: `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY` (from a callback of a call that uses it). Thread-safety: no other thread
 * may use the handle meanwhile or afterwards.
 */
BdtStatus bdt_workspace_free(struct BdtWorkspace *workspace);

/**
 * Says whether queries with this workspace only read instances (`is_shared` not 0), so that several threads, each with a
 * workspace of its own, may ask the same instance at once; nobody may set it meanwhile. Without (the default) a query
 * uses the instance's step cache and has the instance for itself. Answers are the same.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`. Thread-safety: one thread at a time per workspace.
 */
BdtStatus bdt_workspace_set_shared(struct BdtWorkspace *workspace,
                                   int32_t is_shared);

/**
 * Ends the queries of this workspace at a level of the tree (0 is the root's) of the first and of the second mesh; below
 * 0: without a limit (the default). Of every subtree below that a query cannot rule out it then reports a sphere:
 * `bdt_workspace_proxies`. So every triangle of the full answer is reported or lies in such a sphere.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`. Thread-safety: one thread at a time per workspace.
 */
BdtStatus bdt_workspace_set_max_levels(struct BdtWorkspace *workspace,
                                       int32_t first,
                                       int32_t second);

/**
 * Limits the node visits of `bdt_cast_ray`, `bdt_project_point`, `bdt_contacts` with a ball and
 * `bdt_pair_closest_points`, the most promising first; 0: without a limit (the default). `bdt_workspace_bound` says what
 * an answer may have missed. Other queries return `BDT_ERROR_ARGUMENT` while there is a limit.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`. Thread-safety: one thread at a time per workspace.
 */
BdtStatus bdt_workspace_set_max_visits(struct BdtWorkspace *workspace,
                                       uint64_t max_visits);

/**
 * Writes the spheres at which the last query ended, of the first mesh (`side` 0) or the second (1). In queries of two
 * meshes sphere k of one and sphere k of the other belong together.
 * `out`: room for `capacity` spheres; `count`: how many there are.
 * Errors: `BDT_TRUNCATED`, `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_INDEX`. Thread-safety: one thread at a
 * time per workspace.
 */
BdtStatus bdt_workspace_proxies(struct BdtWorkspace *workspace,
                                size_t side,
                                struct BdtProxy *out,
                                size_t capacity,
                                size_t *count);

/**
 * Writes what the last query may have missed because of `bdt_workspace_set_max_visits`.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`. Thread-safety: one thread at a time per workspace.
 */
BdtStatus bdt_workspace_bound(struct BdtWorkspace *workspace, struct BdtBound *out);

/**
 * Writes how many nodes the last query looked at, of several rays together.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`. Thread-safety: one thread at a time per workspace.
 */
BdtStatus bdt_workspace_stats(struct BdtWorkspace *workspace, struct BdtStats *out);

/**
 * Writes every triangle that the shape touches, in no order that means anything. Meshes are surfaces, not solids: a ball
 * wholly inside a closed mesh touches nothing.
 * `shape`: world. `out`: room for `capacity` contacts (may be NULL with 0); `count`: how many there are, written even
 * when they do not fit.
 * Errors: `BDT_TRUNCATED`, `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_ARGUMENT`, `BDT_ERROR_FORMAT` (a damaged file).
 * Thread-safety: one thread at a time per workspace and per instance (`bdt_workspace_set_shared`).
 */
BdtStatus bdt_contacts(struct BdtWorkspace *workspace,
                       struct BdtInstance *instance,
                       const struct BdtShape *shape,
                       struct BdtContact *out,
                       size_t capacity,
                       size_t *count);

/**
 * Hands every triangle that the shape touches to a callback, with `context`.
 * Errors: `BDT_STOPPED`; those of `bdt_contacts`. Thread-safety: as `bdt_contacts`; the callback is called by
 * this thread.
 */
BdtStatus bdt_contacts_each(struct BdtWorkspace *workspace,
                            struct BdtInstance *instance,
                            const struct BdtShape *shape,
                            BdtOnContact callback,
                            void *context);

/**
 * Writes 1 if the shape touches any triangle, else 0; ends with the first one that is found.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_ARGUMENT`, `BDT_ERROR_FORMAT` (a damaged file). Thread-safety: as
 * `bdt_contacts`.
 */
BdtStatus bdt_intersects(struct BdtWorkspace *workspace,
                         struct BdtInstance *instance,
                         const struct BdtShape *shape,
                         int32_t *is_touched);

/**
 * Writes the point of the mesh nearest to `point` (world), if it is within `max_distance` (which may be INFINITY); else
 * `BdtHit::triangle` is `BDT_NONE`.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_ARGUMENT`, `BDT_ERROR_FORMAT` (a damaged file). Thread-safety: as
 * `bdt_contacts`.
 */
BdtStatus bdt_project_point(struct BdtWorkspace *workspace,
                            struct BdtInstance *instance,
                            struct BdtVec3 point,
                            double max_distance,
                            struct BdtHit *out);

/**
 * Writes where the ray (world) first meets the mesh; if it does not, `BdtHit::triangle` is `BDT_NONE`. Triangles are
 * two-sided; those without area are missed.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_ARGUMENT`, `BDT_ERROR_FORMAT` (a damaged file). Thread-safety: as
 * `bdt_contacts`.
 */
BdtStatus bdt_cast_ray(struct BdtWorkspace *workspace, struct BdtInstance *instance, const struct BdtRay *ray, struct BdtHit *out);

/**
 * Writes 1 if the ray (world) meets the mesh at all, else 0, in less time than `bdt_cast_ray`.
 * Errors and thread-safety: as `bdt_cast_ray`.
 */
BdtStatus bdt_intersects_ray(struct BdtWorkspace *workspace, struct BdtInstance *instance, const struct BdtRay *ray, int32_t *is_met);

/**
 * Writes every triangle that the ray (world) meets, unsorted, as `bdt_contacts` does.
 * Errors and thread-safety: as `bdt_contacts`.
 */
BdtStatus bdt_cast_ray_all(struct BdtWorkspace *workspace,
                           struct BdtInstance *instance,
                           const struct BdtRay *ray,
                           struct BdtHit *out,
                           size_t capacity,
                           size_t *count);

/**
 * Hands every triangle that the ray (world) meets to a callback, with `context`, unsorted.
 * Errors and thread-safety: as `bdt_contacts_each`.
 */
BdtStatus bdt_cast_ray_all_each(struct BdtWorkspace *workspace,
                                struct BdtInstance *instance,
                                const struct BdtRay *ray,
                                BdtOnHit callback,
                                void *context);

/**
 * Writes whether the mesh is in the region of 1 to 64 planes (world), for example a view frustum: `BDT_INSIDE`,
 * `BDT_ACROSS` or `BDT_OUTSIDE`. A visible mesh is never called outside.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_ARGUMENT`, `BDT_ERROR_FORMAT` (a damaged file). Thread-safety: as
 * `bdt_contacts`.
 */
BdtStatus bdt_frustum_state(struct BdtWorkspace *workspace,
                            struct BdtInstance *instance,
                            const struct BdtPlane *planes,
                            size_t plane_count,
                            uint32_t *state);

/**
 * Writes the lanes of a level of the tree (0 is the root's), and leaf lanes above it, whose spheres the shape touches;
 * no triangles are looked at. Arrays as in `bdt_contacts`.
 * Errors and thread-safety: as `bdt_contacts`.
 */
BdtStatus bdt_level_spheres(struct BdtWorkspace *workspace,
                            struct BdtInstance *instance,
                            uint32_t level,
                            const struct BdtShape *shape,
                            struct BdtLane *out,
                            size_t capacity,
                            size_t *count);

/**
 * Casts `count` rays (world): `hits[i]` becomes that of ray i, as `bdt_cast_ray` writes it, with the ray's number as
 * `index`. Rays after one that is not allowed are not cast.
 * `hits`: room for `count` hits.
 * Errors: those of `bdt_cast_ray`. Thread-safety: as `bdt_contacts`.
 */
BdtStatus bdt_cast_rays(struct BdtWorkspace *workspace,
                        struct BdtInstance *instance,
                        const struct BdtRay *rays,
                        size_t count,
                        struct BdtHit *hits);

/**
 * Casts `count` rays (world): `is_met[i]` becomes 1 if ray i meets the mesh, else 0.
 * `is_met`: room for `count` bytes.
 * Errors: those of `bdt_cast_ray`. Thread-safety: as `bdt_contacts`.
 */
BdtStatus bdt_intersects_rays(struct BdtWorkspace *workspace,
                              struct BdtInstance *instance,
                              const struct BdtRay *rays,
                              size_t count,
                              uint8_t *is_met);

/**
 * Writes every triangle that each of `ray_count` rays (world) meets, ray after ray, with the ray's number as
 * `BdtHit::index`. Arrays as in `bdt_contacts`.
 * Errors and thread-safety: as `bdt_contacts`.
 */
BdtStatus bdt_cast_rays_all(struct BdtWorkspace *workspace,
                            struct BdtInstance *instance,
                            const struct BdtRay *rays,
                            size_t ray_count,
                            struct BdtHit *out,
                            size_t capacity,
                            size_t *count);

/**
 * Casts each of `ray_count` rays (world) at each of `instance_count` instances: `hits[i * ray_count + k]` becomes that of
 * ray k with instance i, as `bdt_cast_ray` writes it, with the instance's number as `BdtHit::index`. Instances whose box
 * a ray misses cost little.
 * `hits`: room for instance_count · ray_count hits.
 * Errors: those of `bdt_cast_ray`; what was written before stays. Thread-safety: as `bdt_contacts`, for each instance.
 */
BdtStatus bdt_cast_rays_at_instances(struct BdtWorkspace *workspace,
                                     struct BdtInstance *const *instances,
                                     size_t instance_count,
                                     const struct BdtRay *rays,
                                     size_t ray_count,
                                     struct BdtHit *hits);

/**
 * Casts each of `ray_count` rays (world) at all of `instance_count` instances: `hits[k]` becomes what ray k meets first,
 * with the instance's number as `BdtHit::index`, the lowest of those at the same distance.
 * `hits`: room for `ray_count` hits.
 * Errors and thread-safety: as `bdt_cast_rays_at_instances`.
 */
BdtStatus bdt_cast_rays_nearest(struct BdtWorkspace *workspace,
                                struct BdtInstance *const *instances,
                                size_t instance_count,
                                const struct BdtRay *rays,
                                size_t ray_count,
                                struct BdtHit *hits);

/**
 * Makes a front.
 * Ownership: `*out` is yours, to be freed by `bdt_front_free`; NULL on errors.
 * Errors: `BDT_ERROR_NULL`. Thread-safety: any thread.
 */
BdtStatus bdt_front_new(struct BdtFront **out);

/**
 * Frees a front. NULL is nothing.
 * Errors: `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY` (from a callback of a call that uses it). Thread-safety: no other thread
 * may use the handle meanwhile or afterwards.
 */
BdtStatus bdt_front_free(struct BdtFront *front);

/**
 * Writes every pair of triangles, one of each instance, whose distance is at most `prediction` (world), with points and
 * normals; at 0 those that share a point. Arrays as in `bdt_contacts`.
 * `front`: of this pair of instances, or NULL.
 * Errors: `BDT_TRUNCATED`, `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY` (also if both instances are the same one),
 * `BDT_ERROR_ARGUMENT`, `BDT_ERROR_FORMAT` (a damaged file). Thread-safety: one thread at a time per workspace, front and instance
 * (`bdt_workspace_set_shared`).
 */
BdtStatus bdt_pair_contacts(struct BdtWorkspace *workspace,
                            struct BdtInstance *first,
                            struct BdtInstance *second,
                            struct BdtFront *front,
                            double prediction,
                            struct BdtPairContact *out,
                            size_t capacity,
                            size_t *count);

/**
 * Hands every pair of triangles that `bdt_pair_contacts` would write to a callback, with `context`.
 * Errors: `BDT_STOPPED`; those of `bdt_pair_contacts`. Thread-safety: as `bdt_pair_contacts`; the callback is
 * called by this thread.
 */
BdtStatus bdt_pair_contacts_each(struct BdtWorkspace *workspace,
                                 struct BdtInstance *first,
                                 struct BdtInstance *second,
                                 struct BdtFront *front,
                                 double prediction,
                                 BdtOnPairContact callback,
                                 void *context);

/**
 * Writes which pairs of triangles `bdt_pair_contacts` would write, without their points: several times faster where many
 * touch.
 * Errors and thread-safety: as `bdt_pair_contacts`.
 */
BdtStatus bdt_pair_triangles(struct BdtWorkspace *workspace,
                             struct BdtInstance *first,
                             struct BdtInstance *second,
                             struct BdtFront *front,
                             double prediction,
                             struct BdtIndexPair *out,
                             size_t capacity,
                             size_t *count);

/**
 * Writes 1 if any two triangles share a point, else 0; ends with the first pair that is found.
 * Errors and thread-safety: as `bdt_pair_contacts`.
 */
BdtStatus bdt_pair_intersects(struct BdtWorkspace *workspace,
                              struct BdtInstance *first,
                              struct BdtInstance *second,
                              struct BdtFront *front,
                              int32_t *is_touching);

/**
 * Writes the nearest two triangles, one of each instance, and where they are nearest, if that is within `max_distance`
 * (world; may be INFINITY); else `BdtPairContact::triangle1` is `BDT_NONE`.
 * Errors: those of `bdt_pair_contacts`; `BDT_ERROR_ARGUMENT` with a limit of levels. Thread-safety: as `bdt_pair_contacts`.
 */
BdtStatus bdt_pair_closest_points(struct BdtWorkspace *workspace,
                                  struct BdtInstance *first,
                                  struct BdtInstance *second,
                                  double max_distance,
                                  struct BdtPairContact *out);

/**
 * Writes the distance of the two meshes (world) if it is within `max_distance` (which may be INFINITY), else -1.
 * Errors and thread-safety: as `bdt_pair_closest_points`.
 */
BdtStatus bdt_pair_distance(struct BdtWorkspace *workspace,
                            struct BdtInstance *first,
                            struct BdtInstance *second,
                            double max_distance,
                            double *distance);

/**
 * Writes one manifold per connected region of contact: `bdt_pair_contacts`, condensed to one point or four with normal,
 * area and depth. Both surfaces must list their corners counterclockwise as seen from outside, or both clockwise.
 * `prediction` 0: only triangles that touch form regions. Arrays as in `bdt_contacts`. `front`: of this pair, or NULL.
 * Errors: those of `bdt_pair_contacts`; `BDT_ERROR_ARGUMENT` with a limit of levels. Thread-safety: as `bdt_pair_contacts`.
 */
BdtStatus bdt_pair_manifolds(struct BdtWorkspace *workspace,
                             struct BdtInstance *first,
                             struct BdtInstance *second,
                             struct BdtFront *front,
                             double prediction,
                             struct BdtManifold *out,
                             size_t capacity,
                             size_t *count);

/**
 * Writes the manifolds of `pair_count` contacts that `bdt_pair_contacts` has written: all of them, in any order. They are
 * only read.
 * Errors: those of `bdt_pair_contacts`; `BDT_ERROR_ARGUMENT` for triangles that the models do not have. Thread-safety: as
 * `bdt_pair_contacts`.
 */
BdtStatus bdt_pair_condense(struct BdtWorkspace *workspace,
                            struct BdtInstance *first,
                            struct BdtInstance *second,
                            const struct BdtPairContact *pairs,
                            size_t pair_count,
                            struct BdtManifold *out,
                            size_t capacity,
                            size_t *count);

/**
 * Writes the pairs of lanes, one of each tree, whose spheres are at most `prediction` apart (world), of `level1` and
 * `level2` (0 is the root's) and leaf lanes above them; no triangles are looked at. `reach`: what a sphere of the one and
 * a sphere of the other together stick out of those above them; with 0 some pairs may be missing, but all triangles
 * within `prediction` lie in a reported pair. Arrays as in `bdt_contacts`.
 * Errors: those of `bdt_pair_contacts`; `BDT_ERROR_ARGUMENT` with a limit of levels. Thread-safety: as `bdt_pair_contacts`.
 */
BdtStatus bdt_pair_level_spheres(struct BdtWorkspace *workspace,
                                 struct BdtInstance *first,
                                 struct BdtInstance *second,
                                 uint32_t level1,
                                 uint32_t level2,
                                 double prediction,
                                 double reach,
                                 struct BdtLanePair *out,
                                 size_t capacity,
                                 size_t *count);

/**
 * Writes pairs of a lane of the first tree, of `level` or a leaf lane above it, and a triangle of the second mesh that is
 * at most `prediction` (world) from the lane's sphere. `reach`: as in `bdt_pair_level_spheres`, of the first mesh alone.
 * Arrays as in `bdt_contacts`.
 * Errors and thread-safety: as `bdt_pair_level_spheres`.
 */
BdtStatus bdt_pair_level_triangles(struct BdtWorkspace *workspace,
                                   struct BdtInstance *first,
                                   struct BdtInstance *second,
                                   uint32_t level,
                                   double prediction,
                                   double reach,
                                   struct BdtLaneTriangle *out,
                                   size_t capacity,
                                   size_t *count);

/**
 * Writes every pair of `sphere_count` spheres (world) that are at most `prediction` apart, as two ascending numbers,
 * once. Arrays as in `bdt_contacts`.
 * Errors: `BDT_TRUNCATED`, `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_ARGUMENT`. Thread-safety: one thread at
 * a time per workspace.
 */
BdtStatus bdt_sphere_pairs(struct BdtWorkspace *workspace,
                           const struct BdtSphere *spheres,
                           size_t sphere_count,
                           double prediction,
                           struct BdtIndexPair *out,
                           size_t capacity,
                           size_t *count);

/**
 * Writes every pair of `instance_count` instances whose bounding spheres are at most `prediction` apart (world) and whose
 * groups meet (`BdtTags`), as two ascending numbers, once: what to ask by `bdt_pair_contacts`. Arrays as in
 * `bdt_contacts`.
 * Errors: `BDT_TRUNCATED`, `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_ARGUMENT`, `BDT_ERROR_FORMAT` (a damaged file).
 * Thread-safety: one thread at a time per workspace; several threads may read an instance at once.
 */
BdtStatus bdt_instance_pairs(struct BdtWorkspace *workspace,
                             struct BdtInstance *const *instances,
                             size_t instance_count,
                             double prediction,
                             struct BdtIndexPair *out,
                             size_t capacity,
                             size_t *count);

/**
 * Writes the usual options of a world.
 * Errors: `BDT_ERROR_NULL`. Thread-safety: any thread.
 */
BdtStatus bdt_world_defaults(struct BdtWorldOptions *out);

/**
 * Writes the usual options of a body's model.
 * Errors: `BDT_ERROR_NULL`. Thread-safety: any thread.
 */
BdtStatus bdt_body_defaults(struct BdtBodyOptions *out);

/**
 * Makes a world without bodies. `options`: NULL for the usual ones.
 * Ownership: `*out` is yours, to be freed by `bdt_world_free`; NULL on errors.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_DYNAMICS` (options beyond their limits). Thread-safety: any thread.
 */
BdtStatus bdt_world_new(const struct BdtWorldOptions *options, struct BdtWorld **out);

/**
 * Frees a world. NULL is nothing.
 * Errors: `BDT_ERROR_HANDLE`. Thread-safety: no other thread may use the handle meanwhile or afterwards.
 */
BdtStatus bdt_world_free(struct BdtWorld *world);

/**
 * Adds what bodies of a model have in common; `*id` is its number. `options`: NULL for the usual ones. The model may be
 * freed before the world.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_ARGUMENT`, `BDT_ERROR_DYNAMICS` (options beyond their limits, a skin, no
 * frequencies), `BDT_ERROR_FORMAT` (a damaged file). Thread-safety: one thread at a time per world.
 */
BdtStatus bdt_world_add_model(struct BdtWorld *world,
                              struct BdtModel *model,
                              const struct BdtBodyOptions *options,
                              uint32_t *id);

/**
 * Adds the ground or a wall: nothing goes where normal · x + d < 0 (world); the normal has unit length.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_DYNAMICS`. Thread-safety: one thread at a time per world.
 */
BdtStatus bdt_world_add_plane(struct BdtWorld *world, const struct BdtPlane *plane);

/**
 * Adds a body at rest: undeformed, its mesh placed at `at`, without speed; `*id` is its number. `model`: a number from
 * `bdt_world_add_model`. `frame`: `BDT_FREE`, `BDT_HELD` or `BDT_DRIVEN`.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_ARGUMENT`, `BDT_ERROR_INDEX` (no such model), `BDT_ERROR_POSE` (a placement that
 * is not allowed), `BDT_ERROR_DYNAMICS` (no mass, another scale than the model's). Thread-safety: one thread at a time per world.
 */
BdtStatus bdt_world_add_body(struct BdtWorld *world,
                             uint32_t model,
                             uint32_t frame,
                             const struct BdtTransform *at,
                             uint32_t *id);

/**
 * Takes one step. `report`: what it did; may be NULL.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_STEP` (bodies too fast for the step: the world is not to be
 * stepped on), `BDT_ERROR_DYNAMICS`, `BDT_ERROR_FORMAT` (a damaged file). Thread-safety: one thread at a time per world.
 */
BdtStatus bdt_world_step(struct BdtWorld *world, struct BdtStepReport *report);

/**
 * Writes how many bodies there are, how many of them sleep, and how many steps were taken; each may be NULL.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`. Thread-safety: several threads may read a world at once.
 */
BdtStatus bdt_world_counts(struct BdtWorld *world, uint32_t *bodies, uint32_t *asleep, uint64_t *steps);

/**
 * Writes which bodies began to touch, touch, or have parted in the last step, sorted by bodies; planes come last. Pairs
 * that sleep are not among them. Arrays as in `bdt_contacts`.
 * Errors: `BDT_TRUNCATED`, `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`. Thread-safety: several threads may read a
 * world at once.
 */
BdtStatus bdt_world_events(struct BdtWorld *world,
                           struct BdtEvent *out,
                           size_t capacity,
                           size_t *count);

/**
 * Writes the contacts of the last step. Arrays as in `bdt_contacts`.
 * Errors and thread-safety: as `bdt_world_events`.
 */
BdtStatus bdt_world_contacts(struct BdtWorld *world, struct BdtWorldContact *out, size_t capacity, size_t *count);

/**
 * Writes the energies of all bodies as they are now.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`. Thread-safety: several threads may read a world at once.
 */
BdtStatus bdt_world_energy(struct BdtWorld *world, struct BdtEnergy *out);

/**
 * Writes momentum (N s) and angular momentum about the world's origin (kg · world unit² / s) of all free bodies; each may
 * be NULL.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`. Thread-safety: several threads may read a world at once.
 */
BdtStatus bdt_world_momenta(struct BdtWorld *world,
                            struct BdtVec3 *linear,
                            struct BdtVec3 *angular);

/**
 * Writes what a ray (world) meets first, with the body as `BdtHit::index`; if nothing, `BdtHit::triangle` is `BDT_NONE`.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_ARGUMENT`, `BDT_ERROR_FORMAT` (a damaged file). Thread-safety: one thread
 * at a time per world.
 */
BdtStatus bdt_world_cast_ray(struct BdtWorld *world,
                             const struct BdtRay *ray,
                             struct BdtHit *out);

/**
 * Writes every triangle of every body that the shape (world) touches, with the body as `BdtContact::body`. Arrays as in
 * `bdt_contacts`.
 * Errors: `BDT_TRUNCATED`; those of `bdt_world_cast_ray`. Thread-safety: one thread at a time per world.
 */
BdtStatus bdt_world_touched_by(struct BdtWorld *world,
                               const struct BdtShape *shape,
                               struct BdtContact *out,
                               size_t capacity,
                               size_t *count);

/**
 * Writes the whole state of the world: what goes on from it after `bdt_world_restore` is the same to the bit. Models,
 * planes and options are not in it. `out`: room for `capacity` bytes; `count`: how many there are.
 * Errors: `BDT_TRUNCATED` (the bytes are of no use), `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`. Thread-safety:
 * several threads may read a world at once.
 */
BdtStatus bdt_world_save(struct BdtWorld *world, uint8_t *out, size_t capacity, size_t *count);

/**
 * Goes back to a state that `bdt_world_save` has written, of this world or of one with the same models, planes, bodies
 * and options. On errors nothing changes.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_STATE`. Thread-safety: one thread at a time per world.
 */
BdtStatus bdt_world_restore(struct BdtWorld *world, const uint8_t *bytes, size_t length);

/**
 * Writes position, orientation and speeds of a body.
 * Errors: `BDT_ERROR_NULL`, `BDT_ERROR_HANDLE`, `BDT_ERROR_BUSY`, `BDT_ERROR_INDEX` (no such body). Thread-safety: several threads may read a
 * world at once.
 */
BdtStatus bdt_body_state(struct BdtWorld *world,
                         uint32_t body,
                         struct BdtBodyState *out);

/**
 * Writes where a body's mesh is: what a renderer needs besides q.
 * Errors and thread-safety: as `bdt_body_state`.
 */
BdtStatus bdt_body_placement(struct BdtWorld *world, uint32_t body, struct BdtTransform *out);

/**
 * Writes how many modes of a body move: as many as its model has, or 0 if it is not deformable.
 * Errors and thread-safety: as `bdt_body_state`.
 */
BdtStatus bdt_body_mode_count(struct BdtWorld *world, uint32_t body, size_t *count);

/**
 * Writes q of a body and how fast it changes (per second), `count` numbers each, as many as `bdt_body_mode_count` says;
 * each may be NULL.
 * Errors: those of `bdt_body_state`; `BDT_ERROR_LENGTH`. Thread-safety: several threads may read a world at once.
 */
BdtStatus bdt_body_q(struct BdtWorld *world, uint32_t body, double *q, double *rate, size_t count);

/**
 * Sets q of a body and how fast it changes (per second): `count` numbers each, as many as `bdt_body_mode_count` says.
 * Errors: those of `bdt_body_state`; `BDT_ERROR_LENGTH`, `BDT_ERROR_DYNAMICS` (not finite, or beyond the strain limit). Thread-safety: one
 * thread at a time per world.
 */
BdtStatus bdt_body_set_modes(struct BdtWorld *world,
                             uint32_t body,
                             const double *q,
                             const double *rate,
                             size_t count);

/**
 * Sets velocity (world units per second) and angular velocity (rad/s, world axes) of a free body.
 * Errors: those of `bdt_body_state`; `BDT_ERROR_DYNAMICS` (not finite). Thread-safety: one thread at a time per world.
 */
BdtStatus bdt_body_set_velocity(struct BdtWorld *world,
                                uint32_t body,
                                struct BdtVec3 velocity,
                                struct BdtVec3 angular_velocity);

/**
 * Adds a force (N) at the center of mass and a torque (N · world unit), world axes, for the next step.
 * Errors: those of `bdt_body_state`; `BDT_ERROR_DYNAMICS` (not finite). Thread-safety: one thread at a time per world.
 */
BdtStatus bdt_body_add_force(struct BdtWorld *world, uint32_t body, struct BdtVec3 force, struct BdtVec3 torque);

/**
 * Adds generalised forces on q for the next step, one per mode: what `bdt_instance_add_generalized_force` makes.
 * Errors: those of `bdt_body_set_modes`. Thread-safety: one thread at a time per world.
 */
BdtStatus bdt_body_add_modal_force(struct BdtWorld *world, uint32_t body, const double *force, size_t count);

/**
 * Adds impulses on q, one per mode: its rates change at once.
 * Errors: those of `bdt_body_set_modes`. Thread-safety: one thread at a time per world.
 */
BdtStatus bdt_body_add_modal_impulse(struct BdtWorld *world, uint32_t body, const double *impulse, size_t count);

/**
 * Says where the mesh of a driven body is at the end of the next step, and its q: `count` numbers, as many as
 * `bdt_body_mode_count` says.
 * Errors: those of `bdt_body_set_modes`; `BDT_ERROR_INDEX` also for bodies that are not driven. Thread-safety: one thread at a
 * time per world.
 */
BdtStatus bdt_body_drive(struct BdtWorld *world, uint32_t body, const double *q, size_t count, const struct BdtTransform *at);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* BDTREE_H */
