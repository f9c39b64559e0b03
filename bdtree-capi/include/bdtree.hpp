/*
 * bdtree for C++17: owners of the handles of bdtree.h, vectors in place of arrays, exceptions in place of statuses.
 * Header only; link libbdtree. Each function calls the one of bdtree.h of the same name (without the name of what it is a
 * member of), whose comment says units, frames, errors and which threads may call it. Structs are those of bdtree.h.
 *
 * All functions of bdtree.h are here. The language has its own form of these:
 * - *_new, *_free: constructors and destructors; bdt_instance_new_with_cache is a constructor with two sizes more.
 * - *_each: any callable takes the items: see Workspace::contacts_each.
 * - bdt_instance_set_pose_with_joints, bdt_instance_set_skeleton_pose: overloads of Instance::set_pose.
 * - BDT_TRUNCATED is not seen: vectors and strings grow. BDT_STOPPED is the answer false of *_each.
 * - BDT_NONE in place of a hit is an empty std::optional; in arrays of hits it stays.
 */
#ifndef BDTREE_HPP
#define BDTREE_HPP

#include <cstddef>
#include <cstdint>
#include <exception>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "bdtree.h"

namespace bdtree {

/** What a function of bdtree.h returned, and what it says. */
class Error : public std::runtime_error {
public:
    Error(BdtStatus status, const std::string &text) : std::runtime_error(text), status_(status) {}

    BdtStatus status() const noexcept { return status_; }

private:
    BdtStatus status_;
};

/** What went wrong in this thread's last call that returned an error; empty before the first one. */
inline std::string last_error();

/** What a status means, in a few words. */
inline std::string status_text(std::int32_t status) { return bdt_status_text(status); }

/** Throws an Error for statuses below 0; returns the others. */
inline BdtStatus check(BdtStatus status)
{
    if (status >= 0) {
        return status;
    }
    const std::string text = last_error();
    throw Error(status, text.empty() ? status_text(status) : text);
}

namespace detail {

template <class T, BdtStatus (*Free)(T *)>
struct Deleter {
    void operator()(T *handle) const noexcept { Free(handle); }
};

/** What a function writes to its last argument: a struct, a number or a new handle. */
template <class T, class Ask, class... Args>
T one(Ask ask, Args... args)
{
    T out{};
    check(ask(args..., &out));
    return out;
}

/** All items that a function writes to its last arguments: array, capacity and count. The first try has room for 4 KB. */
template <class T, class Items = std::vector<T>, class Ask, class... Args>
Items all(Ask ask, Args... args)
{
    // Texts are closed by a 0 that is not counted.
    constexpr std::size_t closing = std::is_same_v<Items, std::string> ? 1 : 0;
    Items items(4096 / sizeof(T), T{});
    std::size_t count = 0;
    while (check(ask(args..., items.data(), items.size(), &count)) == BDT_TRUNCATED) {
        items.resize(count + closing);
    }
    items.resize(count);
    return items;
}

template <class Ask, class... Args>
std::string text(Ask ask, Args... args)
{
    return all<char, std::string>(ask, args...);
}

inline std::optional<BdtHit> found(const BdtHit &hit)
{
    return hit.triangle == BDT_NONE ? std::nullopt : std::optional<BdtHit>(hit);
}

template <class Owner>
auto handle_of(const Owner *owner) noexcept
{
    return owner == nullptr ? nullptr : owner->get();
}

/** Hands items of a query to a callable, whose exceptions wait until the query has ended. */
template <class T, class Call>
struct Taker {
    Call &call;
    std::exception_ptr thrown;

    static std::int32_t take(const T *item, void *context) noexcept
    {
        Taker &taker = *static_cast<Taker *>(context);
        using Answer = decltype(taker.call(*item));
        static_assert(std::is_void_v<Answer> || std::is_same_v<Answer, bool>,
                      "it returns nothing, or a bool: false ends the query");
        try {
            if constexpr (std::is_void_v<Answer>) {
                taker.call(*item);
                return 0;
            } else {
                return taker.call(*item) ? 0 : 1;
            }
        } catch (...) {
            taker.thrown = std::current_exception();
            return 1;
        }
    }
};

/** Calls a function whose last arguments are callback and context; false if `call` has ended the query. */
template <class T, class Call, class Ask, class... Args>
bool each(Call &call, Ask ask, Args... args)
{
    Taker<T, Call> taker{call, nullptr};
    const BdtStatus status = ask(args..., Taker<T, Call>::take, static_cast<void *>(&taker));
    if (taker.thrown) {
        std::rethrow_exception(taker.thrown);
    }
    return check(status) != BDT_STOPPED;
}

/** The owner of a handle, which is the first argument of what it asks. */
template <class T, BdtStatus (*Free)(T *)>
class Owner {
public:
    /** The handle, which stays with its owner. */
    T *get() const noexcept { return handle_.get(); }

protected:
    explicit Owner(T *handle) noexcept : handle_(handle) {}

    template <class Item, class Ask, class... Args>
    Item one(Ask ask, Args... args) const
    {
        return detail::one<Item>(ask, get(), args...);
    }

    template <class Item, class Ask, class... Args>
    std::vector<Item> all(Ask ask, Args... args) const
    {
        return detail::all<Item>(ask, get(), args...);
    }

private:
    std::unique_ptr<T, Deleter<T, Free>> handle_;
};

} // namespace detail

inline std::string last_error() { return detail::text(bdt_last_error); }

/** Of the library: major · 10^6 + minor · 10^3 + patch. */
inline std::uint32_t version() noexcept { return bdt_version(); }
inline std::string version_text() { return bdt_version_text(); }
/** Whether the library knows which handles live. */
inline bool checks_handles() noexcept { return bdt_checks_handles() != 0; }

constexpr double infinity = std::numeric_limits<double>::infinity();

/** World and mesh coordinates are the same. */
constexpr BdtTransform identity{{0.0, 0.0, 0.0, 1.0}, {0.0, 0.0, 0.0}, 1.0};

inline BdtShape ball(BdtVec3 center, double radius) { return bdt_ball(center, radius); }
inline BdtShape capsule(BdtVec3 a, BdtVec3 b, double radius) { return bdt_capsule(a, b, radius); }
inline BdtShape cuboid(BdtVec3 center, BdtQuat rotation, BdtVec3 half_extents)
{
    return bdt_cuboid(center, rotation, half_extents);
}
inline BdtShape half_space(BdtVec3 normal, double offset) { return bdt_half_space(normal, offset); }

/** The placement that does what `first` does and then what `then` does. */
inline BdtTransform transform_after(const BdtTransform &then, const BdtTransform &first)
{
    return detail::one<BdtTransform>(bdt_transform_after, then, first);
}

/** A joint's matrix to the model's space, of the one to the world's and the placement: for Instance::set_joints. */
inline BdtMatrix joint_in_model(const BdtTransform &at, const BdtMatrix &in_world)
{
    return detail::one<BdtMatrix>(bdt_joint_in_model, at, in_world);
}

class Model : public detail::Owner<BdtModel, bdt_model_free> {
public:
    static Model load(const std::string &path) { return made(bdt_model_load, path.c_str()); }
    static Model read(const std::string &path) { return made(bdt_model_read, path.c_str()); }
    static Model from_memory(const void *bytes, std::size_t length)
    {
        return made(bdt_model_from_memory, static_cast<const std::uint8_t *>(bytes), length);
    }

    BdtModelInfo info() const { return one<BdtModelInfo>(bdt_model_info); }
    BdtMode mode(std::size_t index) const { return one<BdtMode>(bdt_model_mode, index); }
    BdtMass mass() const { return one<BdtMass>(bdt_model_mass); }
    BdtGroup group(std::size_t index) const { return one<BdtGroup>(bdt_model_group, index); }
    std::string mode_name(std::size_t index) const { return detail::text(bdt_model_mode_name, get(), index); }
    std::string joint_name(std::size_t index) const { return detail::text(bdt_model_joint_name, get(), index); }
    std::string clip_name(std::size_t index) const { return detail::text(bdt_model_clip_name, get(), index); }
    std::string group_name(std::size_t index) const { return detail::text(bdt_model_group_name, get(), index); }
    std::size_t mode_index(const std::string &name) const
    {
        return one<std::size_t>(bdt_model_mode_index, name.c_str());
    }
    std::size_t joint_index(const std::string &name) const
    {
        return one<std::size_t>(bdt_model_joint_index, name.c_str());
    }
    std::size_t clip_index(const std::string &name) const
    {
        return one<std::size_t>(bdt_model_clip_index, name.c_str());
    }
    std::uint32_t joint_parent(std::size_t index) const { return one<std::uint32_t>(bdt_model_joint_parent, index); }
    std::uint32_t joint_of(std::uint32_t triangle, BdtVec3 barycentric) const
    {
        return one<std::uint32_t>(bdt_model_joint_of, triangle, barycentric);
    }
    double clip_duration(std::size_t index) const { return one<double>(bdt_model_clip_duration, index); }

    /** Three vertices of each of `count` triangles. */
    std::vector<std::uint32_t> triangles(std::uint32_t first, std::size_t count) const
    {
        std::vector<std::uint32_t> corners(std::size_t{3} * count);
        check(bdt_model_triangles(get(), first, count, corners.data()));
        return corners;
    }

    /** Three vertices of each triangle. */
    std::vector<std::uint32_t> triangles() const { return triangles(0, info().triangle_count); }

    /** q and placement of a frame of the animation; `time_s`, if not null, becomes when it is shown. */
    std::pair<std::vector<float>, BdtTransform> frame(std::size_t index, double *time_s = nullptr) const
    {
        std::pair<std::vector<float>, BdtTransform> out{std::vector<float>(info().mode_count), identity};
        check(bdt_model_frame(get(), index, out.first.data(), out.first.size(), &out.second, time_s));
        return out;
    }

    /** q and placement of the animation at a time. */
    std::pair<std::vector<float>, BdtTransform> sample(double time_s) const
    {
        std::pair<std::vector<float>, BdtTransform> out{std::vector<float>(info().mode_count), identity};
        check(bdt_model_sample(get(), time_s, out.first.data(), out.first.size(), &out.second));
        return out;
    }

    void verify() const { check(bdt_model_verify(get())); }
    void verify_checksums() const { check(bdt_model_verify_checksums(get())); }

private:
    explicit Model(BdtModel *handle) : Owner(handle) {}

    template <class Make, class... Args>
    static Model made(Make make, Args... args)
    {
        return Model(detail::one<BdtModel *>(make, args...));
    }
};

class SkeletonPose : public detail::Owner<BdtSkeletonPose, bdt_skeleton_pose_free> {
public:
    explicit SkeletonPose(const Model &model)
        : Owner(detail::one<BdtSkeletonPose *>(bdt_skeleton_pose_new, model.get())), info_(model.info())
    {
    }

    void rest() { check(bdt_skeleton_pose_rest(get())); }
    void play(std::size_t clip, double time_s) { check(bdt_skeleton_pose_play(get(), clip, time_s)); }
    void blend(std::size_t clip, double time_s, double weight)
    {
        check(bdt_skeleton_pose_blend(get(), clip, time_s, weight));
    }
    void update() { check(bdt_skeleton_pose_update(get())); }
    void set_local(std::size_t node, const BdtLocal &local)
    {
        check(bdt_skeleton_pose_set_local(get(), node, &local));
    }
    BdtLocal local(std::size_t node) const { return detail::one<BdtLocal>(bdt_skeleton_pose_local, get(), node); }

    std::vector<BdtMatrix> joints() const { return filled<BdtMatrix>(bdt_skeleton_pose_joints, info_.joint_count); }
    std::vector<BdtMatrix> nodes() const
    {
        return filled<BdtMatrix>(bdt_skeleton_pose_nodes, info_.skeleton_node_count);
    }
    std::vector<float> q() const { return filled<float>(bdt_skeleton_pose_q, info_.mode_count); }

private:
    template <class T, class Ask>
    std::vector<T> filled(Ask ask, std::size_t count) const
    {
        std::vector<T> out(count);
        check(ask(get(), out.data(), count));
        return out;
    }

    BdtModelInfo info_;
};

class Instance : public detail::Owner<BdtInstance, bdt_instance_free> {
public:
    explicit Instance(const Model &model) : Instance(detail::one<BdtInstance *>(bdt_instance_new, model.get()), model)
    {
    }

    /** With a step cache of so many nodes and leaves. */
    Instance(const Model &model, std::size_t nodes, std::size_t leaves)
        : Instance(detail::one<BdtInstance *>(bdt_instance_new_with_cache, model.get(), nodes, leaves), model)
    {
    }

    void set_q(const std::vector<float> &q) { check(bdt_instance_set_q(get(), q.data(), q.size())); }
    void set_placement(const BdtTransform &at) { check(bdt_instance_set_placement(get(), &at)); }
    void set_pose(const std::vector<float> &q, const BdtTransform &at)
    {
        check(bdt_instance_set_pose(get(), q.data(), q.size(), &at));
    }
    void set_joints(const std::vector<BdtMatrix> &joints)
    {
        check(bdt_instance_set_joints(get(), joints.data(), joints.size()));
    }
    void set_skinning_matrices(const std::vector<BdtMatrix> &bones)
    {
        check(bdt_instance_set_skinning_matrices(get(), bones.data(), bones.size()));
    }
    void set_pose(const std::vector<float> &q, const std::vector<BdtMatrix> &joints, const BdtTransform &at)
    {
        check(bdt_instance_set_pose_with_joints(get(), q.data(), q.size(), joints.data(), joints.size(), &at));
    }
    void set_pose(const SkeletonPose &pose) { check(bdt_instance_set_skeleton_pose(get(), pose.get())); }
    /// Whether queries refine the pose by themselves where a step asks so much that it pays.
    void set_refining(bool on) { check(bdt_instance_set_refining(get(), on ? 1 : 0)); }
    void set_tags(const BdtTags &tags) { check(bdt_instance_set_tags(get(), &tags)); }

    std::vector<float> q() const
    {
        std::vector<float> out(mode_count_);
        check(bdt_instance_q(get(), out.data(), out.size()));
        return out;
    }

    BdtTransform placement() const { return detail::one<BdtTransform>(bdt_instance_placement, get()); }
    BdtTags tags() const { return detail::one<BdtTags>(bdt_instance_tags, get()); }
    BdtAabb aabb() const { return detail::one<BdtAabb>(bdt_instance_aabb, get()); }
    BdtAabb exact_aabb() const { return detail::one<BdtAabb>(bdt_instance_exact_aabb, get()); }
    BdtSphere bounding_sphere() const { return detail::one<BdtSphere>(bdt_instance_bounding_sphere, get()); }

    std::vector<BdtVec3> vertices(std::uint32_t first, std::size_t count) const
    {
        std::vector<BdtVec3> out(count);
        check(bdt_instance_vertices(get(), first, count, out.data()));
        return out;
    }

    /** Adds what a force at a point of a triangle does to each mode to `forces`, one number per mode. */
    void add_generalized_force(std::uint32_t triangle, BdtVec3 barycentric, BdtVec3 force,
                               std::vector<double> &forces) const
    {
        check(bdt_instance_add_generalized_force(get(), triangle, barycentric, force, forces.data(), forces.size()));
    }

private:
    Instance(BdtInstance *handle, const Model &model) : Owner(handle), mode_count_(model.info().mode_count) {}

    std::size_t mode_count_;
};

/** Instances that are asked together. */
using Instances = std::vector<const Instance *>;

/** What a pair of instances keeps from step to step. */
class Front : public detail::Owner<BdtFront, bdt_front_free> {
public:
    Front() : Owner(detail::one<BdtFront *>(bdt_front_new)) {}
};

/** The memory of queries, and the queries. */
class Workspace : public detail::Owner<BdtWorkspace, bdt_workspace_free> {
public:
    Workspace() : Owner(detail::one<BdtWorkspace *>(bdt_workspace_new)) {}

    void set_shared(bool is_shared) { check(bdt_workspace_set_shared(get(), is_shared ? 1 : 0)); }
    void set_max_levels(std::int32_t first, std::int32_t second = -1)
    {
        check(bdt_workspace_set_max_levels(get(), first, second));
    }
    void set_max_visits(std::uint64_t visits) { check(bdt_workspace_set_max_visits(get(), visits)); }

    std::vector<BdtProxy> proxies(std::size_t side = 0) const { return all<BdtProxy>(bdt_workspace_proxies, side); }
    BdtBound bound() const { return one<BdtBound>(bdt_workspace_bound); }
    BdtStats stats() const { return one<BdtStats>(bdt_workspace_stats); }

    std::vector<BdtContact> contacts(const Instance &of, const BdtShape &shape)
    {
        return all<BdtContact>(bdt_contacts, of.get(), &shape);
    }

    /**
     * Hands contacts to `call(const BdtContact &)`, which returns nothing, or a bool of which false ends the query; then
     * this returns false. What `call` throws ends the query, and is thrown on from here. `call` must not use this
     * workspace nor the instance.
     */
    template <class Call>
    bool contacts_each(const Instance &of, const BdtShape &shape, Call &&call)
    {
        return detail::each<BdtContact>(call, bdt_contacts_each, get(), of.get(), &shape);
    }

    bool intersects(const Instance &of, const BdtShape &shape) { return is(bdt_intersects, of.get(), &shape); }

    std::optional<BdtHit> project_point(const Instance &of, BdtVec3 point, double max_distance = infinity)
    {
        return detail::found(one<BdtHit>(bdt_project_point, of.get(), point, max_distance));
    }

    std::optional<BdtHit> cast_ray(const Instance &of, const BdtRay &ray)
    {
        return detail::found(one<BdtHit>(bdt_cast_ray, of.get(), &ray));
    }

    bool intersects_ray(const Instance &of, const BdtRay &ray) { return is(bdt_intersects_ray, of.get(), &ray); }

    std::vector<BdtHit> cast_ray_all(const Instance &of, const BdtRay &ray)
    {
        return all<BdtHit>(bdt_cast_ray_all, of.get(), &ray);
    }

    /** Hands hits to `call(const BdtHit &)`, as contacts_each contacts. */
    template <class Call>
    bool cast_ray_all_each(const Instance &of, const BdtRay &ray, Call &&call)
    {
        return detail::each<BdtHit>(call, bdt_cast_ray_all_each, get(), of.get(), &ray);
    }

    /** One hit per ray; `triangle` is BDT_NONE where it misses. */
    std::vector<BdtHit> cast_rays(const Instance &of, const std::vector<BdtRay> &rays)
    {
        std::vector<BdtHit> hits(rays.size());
        check(bdt_cast_rays(get(), of.get(), rays.data(), rays.size(), hits.data()));
        return hits;
    }

    /** For each ray 1 if it meets the mesh, else 0. */
    std::vector<std::uint8_t> intersects_rays(const Instance &of, const std::vector<BdtRay> &rays)
    {
        std::vector<std::uint8_t> is_met(rays.size());
        check(bdt_intersects_rays(get(), of.get(), rays.data(), rays.size(), is_met.data()));
        return is_met;
    }

    /** Every triangle that each ray meets, ray after ray: `index` is the ray. */
    std::vector<BdtHit> cast_rays_all(const Instance &of, const std::vector<BdtRay> &rays)
    {
        return all<BdtHit>(bdt_cast_rays_all, of.get(), rays.data(), rays.size());
    }

    /** The hit of ray k with instance i at [i * rays.size() + k]. */
    std::vector<BdtHit> cast_rays_at_instances(const Instances &of, const std::vector<BdtRay> &rays)
    {
        const auto handles = handles_of(of);
        std::vector<BdtHit> hits(handles.size() * rays.size());
        check(bdt_cast_rays_at_instances(get(), handles.data(), handles.size(), rays.data(), rays.size(), hits.data()));
        return hits;
    }

    /** What each ray meets first of several instances. */
    std::vector<BdtHit> cast_rays_nearest(const Instances &of, const std::vector<BdtRay> &rays)
    {
        const auto handles = handles_of(of);
        std::vector<BdtHit> hits(rays.size());
        check(bdt_cast_rays_nearest(get(), handles.data(), handles.size(), rays.data(), rays.size(), hits.data()));
        return hits;
    }

    /** BDT_INSIDE, BDT_ACROSS or BDT_OUTSIDE. */
    std::uint32_t frustum_state(const Instance &of, const std::vector<BdtPlane> &planes)
    {
        return one<std::uint32_t>(bdt_frustum_state, of.get(), planes.data(), planes.size());
    }

    /** Lanes of a level whose spheres the shape touches. */
    std::vector<BdtLane> level_spheres(const Instance &of, std::uint32_t level, const BdtShape &shape)
    {
        return all<BdtLane>(bdt_level_spheres, of.get(), level, &shape);
    }

    std::vector<BdtPairContact> pair_contacts(const Instance &first, const Instance &second, double prediction = 0.0,
                                              const Front *front = nullptr)
    {
        return all<BdtPairContact>(bdt_pair_contacts, first.get(), second.get(), detail::handle_of(front), prediction);
    }

    /** Hands contacts to `call(const BdtPairContact &)`, as contacts_each; it must not use the front either. */
    template <class Call>
    bool pair_contacts_each(const Instance &first, const Instance &second, Call &&call, double prediction = 0.0,
                            const Front *front = nullptr)
    {
        return detail::each<BdtPairContact>(call, bdt_pair_contacts_each, get(), first.get(), second.get(),
                                            detail::handle_of(front), prediction);
    }

    std::vector<BdtIndexPair> pair_triangles(const Instance &first, const Instance &second, double prediction = 0.0,
                                             const Front *front = nullptr)
    {
        return all<BdtIndexPair>(bdt_pair_triangles, first.get(), second.get(), detail::handle_of(front), prediction);
    }

    bool pair_intersects(const Instance &first, const Instance &second, const Front *front = nullptr)
    {
        return is(bdt_pair_intersects, first.get(), second.get(), detail::handle_of(front));
    }

    std::optional<BdtPairContact> pair_closest_points(const Instance &first, const Instance &second,
                                                      double max_distance = infinity)
    {
        const auto out = one<BdtPairContact>(bdt_pair_closest_points, first.get(), second.get(), max_distance);
        return out.triangle1 == BDT_NONE ? std::nullopt : std::optional<BdtPairContact>(out);
    }

    /** Empty beyond `max_distance`. */
    std::optional<double> pair_distance(const Instance &first, const Instance &second, double max_distance = infinity)
    {
        const double distance = one<double>(bdt_pair_distance, first.get(), second.get(), max_distance);
        return distance < 0.0 ? std::nullopt : std::optional<double>(distance);
    }

    std::vector<BdtManifold> pair_manifolds(const Instance &first, const Instance &second, double prediction = 0.0,
                                            const Front *front = nullptr)
    {
        return all<BdtManifold>(bdt_pair_manifolds, first.get(), second.get(), detail::handle_of(front), prediction);
    }

    /** The manifolds of all contacts that pair_contacts has answered. */
    std::vector<BdtManifold> pair_condense(const Instance &first, const Instance &second,
                                           const std::vector<BdtPairContact> &pairs)
    {
        return all<BdtManifold>(bdt_pair_condense, first.get(), second.get(), pairs.data(), pairs.size());
    }

    /** Lanes of both trees, of these levels, whose spheres are near each other. */
    std::vector<BdtLanePair> pair_level_spheres(const Instance &first, const Instance &second, std::uint32_t level1,
                                                std::uint32_t level2, double prediction = 0.0, double reach = 0.0)
    {
        return all<BdtLanePair>(bdt_pair_level_spheres, first.get(), second.get(), level1, level2, prediction, reach);
    }

    /** Lanes of the first tree, of this level, and triangles of the second mesh near their spheres. */
    std::vector<BdtLaneTriangle> pair_level_triangles(const Instance &first, const Instance &second,
                                                      std::uint32_t level, double prediction = 0.0, double reach = 0.0)
    {
        return all<BdtLaneTriangle>(bdt_pair_level_triangles, first.get(), second.get(), level, prediction, reach);
    }

    /** Pairs of spheres at most `prediction` apart. */
    std::vector<BdtIndexPair> sphere_pairs(const std::vector<BdtSphere> &spheres, double prediction = 0.0)
    {
        return all<BdtIndexPair>(bdt_sphere_pairs, spheres.data(), spheres.size(), prediction);
    }

    /** Pairs of instances whose spheres are at most `prediction` apart and whose groups meet. */
    std::vector<BdtIndexPair> instance_pairs(const Instances &of, double prediction = 0.0)
    {
        const auto handles = handles_of(of);
        return all<BdtIndexPair>(bdt_instance_pairs, handles.data(), handles.size(), prediction);
    }

private:
    static std::vector<BdtInstance *> handles_of(const Instances &of)
    {
        std::vector<BdtInstance *> handles;
        for (const Instance *instance : of) {
            handles.push_back(detail::handle_of(instance));
        }
        return handles;
    }

    template <class Ask, class... Args>
    bool is(Ask ask, Args... args) const
    {
        return one<std::int32_t>(ask, args...) != 0;
    }
};

/** How many bodies a world has, how many of them sleep, and how many steps were taken. */
struct Counts {
    std::uint32_t bodies, asleep;
    std::uint64_t steps;
};

/** Momentum, and angular momentum about the world's origin, of all free bodies. */
struct Momenta {
    BdtVec3 linear, angular;
};

/** Bodies that fall, touch and vibrate. */
class World : public detail::Owner<BdtWorld, bdt_world_free> {
public:
    World() : World(nullptr) {}
    explicit World(const BdtWorldOptions &options) : World(&options) {}

    static BdtWorldOptions defaults() { return detail::one<BdtWorldOptions>(bdt_world_defaults); }
    static BdtBodyOptions body_defaults() { return detail::one<BdtBodyOptions>(bdt_body_defaults); }

    std::uint32_t add_model(const Model &model, const BdtBodyOptions &options = body_defaults())
    {
        return one<std::uint32_t>(bdt_world_add_model, model.get(), &options);
    }

    void add_plane(const BdtPlane &plane) { check(bdt_world_add_plane(get(), &plane)); }

    std::uint32_t add_body(std::uint32_t model, const BdtTransform &at, std::uint32_t frame = BDT_FREE)
    {
        return one<std::uint32_t>(bdt_world_add_body, model, frame, &at);
    }

    BdtStepReport step() { return one<BdtStepReport>(bdt_world_step); }

    Counts counts() const
    {
        Counts out{};
        check(bdt_world_counts(get(), &out.bodies, &out.asleep, &out.steps));
        return out;
    }

    BdtBodyState state(std::uint32_t body) const { return one<BdtBodyState>(bdt_body_state, body); }
    BdtTransform placement(std::uint32_t body) const { return one<BdtTransform>(bdt_body_placement, body); }
    std::size_t mode_count(std::uint32_t body) const { return one<std::size_t>(bdt_body_mode_count, body); }

    std::vector<double> q(std::uint32_t body) const
    {
        std::vector<double> out(mode_count(body));
        check(bdt_body_q(get(), body, out.data(), nullptr, out.size()));
        return out;
    }

    /** How fast q changes (per second). */
    std::vector<double> rate(std::uint32_t body) const
    {
        std::vector<double> out(mode_count(body));
        check(bdt_body_q(get(), body, nullptr, out.data(), out.size()));
        return out;
    }

    /** Throws BDT_ERROR_LENGTH if `q` and `rate` have not as many numbers as the body has modes. */
    void set_modes(std::uint32_t body, const std::vector<double> &q, const std::vector<double> &rate)
    {
        if (rate.size() != q.size()) {
            throw Error(BDT_ERROR_LENGTH, "rate has another length than q");
        }
        check(bdt_body_set_modes(get(), body, q.data(), rate.data(), q.size()));
    }

    void set_velocity(std::uint32_t body, BdtVec3 velocity, BdtVec3 angular_velocity)
    {
        check(bdt_body_set_velocity(get(), body, velocity, angular_velocity));
    }

    void add_force(std::uint32_t body, BdtVec3 force, BdtVec3 torque)
    {
        check(bdt_body_add_force(get(), body, force, torque));
    }

    void add_modal_force(std::uint32_t body, const std::vector<double> &force)
    {
        check(bdt_body_add_modal_force(get(), body, force.data(), force.size()));
    }

    void add_modal_impulse(std::uint32_t body, const std::vector<double> &impulse)
    {
        check(bdt_body_add_modal_impulse(get(), body, impulse.data(), impulse.size()));
    }

    void drive(std::uint32_t body, const std::vector<double> &q, const BdtTransform &at)
    {
        check(bdt_body_drive(get(), body, q.data(), q.size(), &at));
    }

    std::vector<BdtEvent> events() const { return all<BdtEvent>(bdt_world_events); }
    std::vector<BdtWorldContact> contacts() const { return all<BdtWorldContact>(bdt_world_contacts); }
    BdtEnergy energy() const { return one<BdtEnergy>(bdt_world_energy); }

    Momenta momenta() const
    {
        Momenta out{};
        check(bdt_world_momenta(get(), &out.linear, &out.angular));
        return out;
    }

    std::optional<BdtHit> cast_ray(const BdtRay &ray)
    {
        return detail::found(one<BdtHit>(bdt_world_cast_ray, &ray));
    }

    /** Every triangle of every body that the shape touches; `body` is the body. */
    std::vector<BdtContact> touched_by(const BdtShape &shape) { return all<BdtContact>(bdt_world_touched_by, &shape); }

    std::vector<std::uint8_t> save() const { return all<std::uint8_t>(bdt_world_save); }

    void restore(const std::vector<std::uint8_t> &bytes)
    {
        check(bdt_world_restore(get(), bytes.data(), bytes.size()));
    }

private:
    explicit World(const BdtWorldOptions *options) : Owner(detail::one<BdtWorld *>(bdt_world_new, options)) {}
};

} // namespace bdtree

#endif /* BDTREE_HPP */
