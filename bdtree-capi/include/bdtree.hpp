/*
 * bdtree for C++17: owners of the handles of bdtree.h, vectors in place of arrays, exceptions in place of statuses.
 * Header only; link libbdtree. Each function calls the one of bdtree.h of the same name, whose comment says units,
 * frames, errors and which threads may call it. Structs are those of bdtree.h.
 */
#ifndef BDTREE_HPP
#define BDTREE_HPP

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
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

/** Throws an Error for statuses below 0; returns the others. */
inline BdtStatus check(BdtStatus status)
{
    if (status >= 0) {
        return status;
    }
    char text[512];
    text[0] = '\0';
    bdt_last_error(text, sizeof text, nullptr);
    throw Error(status, text[0] != '\0' ? text : bdt_status_text(status));
}

constexpr double infinity = std::numeric_limits<double>::infinity();

/** World and mesh coordinates are the same. */
constexpr BdtTransform identity{{0.0, 0.0, 0.0, 1.0}, {0.0, 0.0, 0.0}, 1.0};

namespace detail {

template <class T, BdtStatus (*Free)(T *)>
struct Deleter {
    void operator()(T *handle) const noexcept { Free(handle); }
};

template <class T, BdtStatus (*Free)(T *)>
using Owner = std::unique_ptr<T, Deleter<T, Free>>;

/** All items of an answer: `ask` gets array, capacity and count. */
template <class T, class Ask>
std::vector<T> all(Ask ask, std::size_t room = 32)
{
    std::vector<T> items(room);
    std::size_t count = 0;
    while (check(ask(items.data(), items.size(), &count)) == BDT_TRUNCATED) {
        items.resize(count);
    }
    items.resize(count);
    return items;
}

template <class Ask>
std::string text(Ask ask)
{
    std::string out(64, '\0');
    std::size_t length = 0;
    while (check(ask(out.data(), out.size(), &length)) == BDT_TRUNCATED) {
        out.resize(length + 1);
    }
    out.resize(length);
    return out;
}

inline std::optional<BdtHit> found(const BdtHit &hit)
{
    return hit.triangle == BDT_NONE ? std::nullopt : std::optional<BdtHit>(hit);
}

} // namespace detail

class Model {
public:
    static Model load(const std::string &path) { return made(bdt_model_load, path.c_str()); }
    static Model read(const std::string &path) { return made(bdt_model_read, path.c_str()); }
    static Model from_memory(const void *bytes, std::size_t length)
    {
        return made(bdt_model_from_memory, static_cast<const std::uint8_t *>(bytes), length);
    }

    BdtModel *get() const noexcept { return handle_.get(); }

    BdtModelInfo info() const { return one<BdtModelInfo>(bdt_model_info); }
    BdtMode mode(std::size_t index) const { return one<BdtMode>(bdt_model_mode, index); }
    BdtMass mass() const { return one<BdtMass>(bdt_model_mass); }
    BdtGroup group(std::size_t index) const { return one<BdtGroup>(bdt_model_group, index); }
    std::string mode_name(std::size_t index) const { return name(bdt_model_mode_name, index); }
    std::string joint_name(std::size_t index) const { return name(bdt_model_joint_name, index); }
    std::string clip_name(std::size_t index) const { return name(bdt_model_clip_name, index); }
    std::string group_name(std::size_t index) const { return name(bdt_model_group_name, index); }
    std::size_t mode_index(const std::string &name) const { return index(bdt_model_mode_index, name); }
    std::size_t joint_index(const std::string &name) const { return index(bdt_model_joint_index, name); }
    std::size_t clip_index(const std::string &name) const { return index(bdt_model_clip_index, name); }

    std::uint32_t joint_parent(std::size_t index) const
    {
        std::uint32_t parent = BDT_NONE;
        check(bdt_model_joint_parent(get(), index, &parent));
        return parent;
    }

    std::uint32_t joint_of(std::uint32_t triangle, BdtVec3 barycentric) const
    {
        std::uint32_t joint = BDT_NONE;
        check(bdt_model_joint_of(get(), triangle, barycentric, &joint));
        return joint;
    }

    double clip_duration(std::size_t index) const
    {
        double seconds = 0.0;
        check(bdt_model_clip_duration(get(), index, &seconds));
        return seconds;
    }

    /** Three vertices of each triangle. */
    std::vector<std::uint32_t> triangles() const
    {
        std::vector<std::uint32_t> corners(std::size_t{3} * info().triangle_count);
        check(bdt_model_triangles(get(), 0, corners.size() / 3, corners.data()));
        return corners;
    }

    /** q and placement of a frame of the animation. */
    std::pair<std::vector<float>, BdtTransform> frame(std::size_t index) const
    {
        std::pair<std::vector<float>, BdtTransform> out{std::vector<float>(info().mode_count), identity};
        check(bdt_model_frame(get(), index, out.first.data(), out.first.size(), &out.second, nullptr));
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
    explicit Model(BdtModel *handle) : handle_(handle) {}

    template <class Make, class... Args>
    static Model made(Make make, Args... args)
    {
        BdtModel *handle = nullptr;
        check(make(args..., &handle));
        return Model(handle);
    }

    template <class T, class Read, class... Args>
    T one(Read read, Args... args) const
    {
        T out{};
        check(read(get(), args..., &out));
        return out;
    }

    template <class Read>
    std::string name(Read read, std::size_t index) const
    {
        return detail::text([&](char *out, std::size_t capacity, std::size_t *length) {
            return read(get(), index, out, capacity, length);
        });
    }

    template <class Find>
    std::size_t index(Find find, const std::string &name) const
    {
        std::size_t out = 0;
        check(find(get(), name.c_str(), &out));
        return out;
    }

    detail::Owner<BdtModel, bdt_model_free> handle_;
};

class SkeletonPose {
public:
    explicit SkeletonPose(const Model &model)
    {
        BdtSkeletonPose *handle = nullptr;
        check(bdt_skeleton_pose_new(model.get(), &handle));
        handle_.reset(handle);
        info_ = model.info();
    }

    BdtSkeletonPose *get() const noexcept { return handle_.get(); }

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

    BdtLocal local(std::size_t node) const
    {
        BdtLocal out{};
        check(bdt_skeleton_pose_local(get(), node, &out));
        return out;
    }

    std::vector<BdtMatrix> joints() const
    {
        std::vector<BdtMatrix> out(info_.joint_count);
        check(bdt_skeleton_pose_joints(get(), out.data(), out.size()));
        return out;
    }

    std::vector<BdtMatrix> nodes() const
    {
        std::vector<BdtMatrix> out(info_.skeleton_node_count);
        check(bdt_skeleton_pose_nodes(get(), out.data(), out.size()));
        return out;
    }

    std::vector<float> q() const
    {
        std::vector<float> out(info_.mode_count);
        check(bdt_skeleton_pose_q(get(), out.data(), out.size()));
        return out;
    }

private:
    detail::Owner<BdtSkeletonPose, bdt_skeleton_pose_free> handle_;
    BdtModelInfo info_{};
};

class Instance {
public:
    explicit Instance(const Model &model)
    {
        BdtInstance *handle = nullptr;
        check(bdt_instance_new(model.get(), &handle));
        handle_.reset(handle);
        mode_count_ = model.info().mode_count;
    }

    BdtInstance *get() const noexcept { return handle_.get(); }

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
    void set_tags(const BdtTags &tags) { check(bdt_instance_set_tags(get(), &tags)); }

    std::vector<float> q() const
    {
        std::vector<float> out(mode_count_);
        check(bdt_instance_q(get(), out.data(), out.size()));
        return out;
    }

    BdtTransform placement() const { return one<BdtTransform>(bdt_instance_placement); }
    BdtTags tags() const { return one<BdtTags>(bdt_instance_tags); }
    BdtAabb aabb() const { return one<BdtAabb>(bdt_instance_aabb); }
    BdtAabb exact_aabb() const { return one<BdtAabb>(bdt_instance_exact_aabb); }
    BdtSphere bounding_sphere() const { return one<BdtSphere>(bdt_instance_bounding_sphere); }

    std::vector<BdtVec3> vertices(std::uint32_t first, std::size_t count) const
    {
        std::vector<BdtVec3> out(count);
        check(bdt_instance_vertices(get(), first, count, out.data()));
        return out;
    }

private:
    template <class T, class Read>
    T one(Read read) const
    {
        T out{};
        check(read(get(), &out));
        return out;
    }

    detail::Owner<BdtInstance, bdt_instance_free> handle_;
    std::size_t mode_count_ = 0;
};

/** What a pair of instances keeps from step to step. */
class Front {
public:
    Front()
    {
        BdtFront *handle = nullptr;
        check(bdt_front_new(&handle));
        handle_.reset(handle);
    }

    BdtFront *get() const noexcept { return handle_.get(); }

private:
    detail::Owner<BdtFront, bdt_front_free> handle_;
};

/** The memory of queries, and the queries. */
class Workspace {
public:
    Workspace()
    {
        BdtWorkspace *handle = nullptr;
        check(bdt_workspace_new(&handle));
        handle_.reset(handle);
    }

    BdtWorkspace *get() const noexcept { return handle_.get(); }

    void set_shared(bool is_shared) { check(bdt_workspace_set_shared(get(), is_shared ? 1 : 0)); }
    void set_max_levels(std::int32_t first, std::int32_t second = -1)
    {
        check(bdt_workspace_set_max_levels(get(), first, second));
    }
    void set_max_visits(std::uint64_t visits) { check(bdt_workspace_set_max_visits(get(), visits)); }

    std::vector<BdtProxy> proxies(std::size_t side = 0) const
    {
        return detail::all<BdtProxy>([&](BdtProxy *out, std::size_t capacity, std::size_t *count) {
            return bdt_workspace_proxies(get(), side, out, capacity, count);
        });
    }

    BdtBound bound() const
    {
        BdtBound out{};
        check(bdt_workspace_bound(get(), &out));
        return out;
    }

    BdtStats stats() const
    {
        BdtStats out{};
        check(bdt_workspace_stats(get(), &out));
        return out;
    }

    std::vector<BdtContact> contacts(const Instance &of, const BdtShape &shape)
    {
        return detail::all<BdtContact>([&](BdtContact *out, std::size_t capacity, std::size_t *count) {
            return bdt_contacts(get(), of.get(), &shape, out, capacity, count);
        });
    }

    bool intersects(const Instance &of, const BdtShape &shape)
    {
        std::int32_t is_touched = 0;
        check(bdt_intersects(get(), of.get(), &shape, &is_touched));
        return is_touched != 0;
    }

    std::optional<BdtHit> project_point(const Instance &of, BdtVec3 point, double max_distance = infinity)
    {
        BdtHit hit{};
        check(bdt_project_point(get(), of.get(), point, max_distance, &hit));
        return detail::found(hit);
    }

    std::optional<BdtHit> cast_ray(const Instance &of, const BdtRay &ray)
    {
        BdtHit hit{};
        check(bdt_cast_ray(get(), of.get(), &ray, &hit));
        return detail::found(hit);
    }

    bool intersects_ray(const Instance &of, const BdtRay &ray)
    {
        std::int32_t is_met = 0;
        check(bdt_intersects_ray(get(), of.get(), &ray, &is_met));
        return is_met != 0;
    }

    std::vector<BdtHit> cast_ray_all(const Instance &of, const BdtRay &ray)
    {
        return detail::all<BdtHit>([&](BdtHit *out, std::size_t capacity, std::size_t *count) {
            return bdt_cast_ray_all(get(), of.get(), &ray, out, capacity, count);
        });
    }

    /** One hit per ray; `triangle` is BDT_NONE where it misses. */
    std::vector<BdtHit> cast_rays(const Instance &of, const std::vector<BdtRay> &rays)
    {
        std::vector<BdtHit> hits(rays.size());
        check(bdt_cast_rays(get(), of.get(), rays.data(), rays.size(), hits.data()));
        return hits;
    }

    /** What each ray meets first of several instances. */
    std::vector<BdtHit> cast_rays_nearest(const std::vector<const Instance *> &of, const std::vector<BdtRay> &rays)
    {
        std::vector<BdtInstance *> handles;
        for (const Instance *instance : of) {
            handles.push_back(instance->get());
        }
        std::vector<BdtHit> hits(rays.size());
        check(bdt_cast_rays_nearest(get(), handles.data(), handles.size(), rays.data(), rays.size(), hits.data()));
        return hits;
    }

    /** BDT_INSIDE, BDT_ACROSS or BDT_OUTSIDE. */
    std::uint32_t frustum_state(const Instance &of, const std::vector<BdtPlane> &planes)
    {
        std::uint32_t state = BDT_ACROSS;
        check(bdt_frustum_state(get(), of.get(), planes.data(), planes.size(), &state));
        return state;
    }

    std::vector<BdtPairContact> pair_contacts(const Instance &first, const Instance &second, double prediction = 0.0,
                                              const Front *front = nullptr)
    {
        return detail::all<BdtPairContact>([&](BdtPairContact *out, std::size_t capacity, std::size_t *count) {
            return bdt_pair_contacts(get(), first.get(), second.get(), front_of(front), prediction, out, capacity,
                                     count);
        });
    }

    std::vector<BdtIndexPair> pair_triangles(const Instance &first, const Instance &second, double prediction = 0.0,
                                             const Front *front = nullptr)
    {
        return detail::all<BdtIndexPair>([&](BdtIndexPair *out, std::size_t capacity, std::size_t *count) {
            return bdt_pair_triangles(get(), first.get(), second.get(), front_of(front), prediction, out, capacity,
                                      count);
        });
    }

    bool pair_intersects(const Instance &first, const Instance &second, const Front *front = nullptr)
    {
        std::int32_t is_touching = 0;
        check(bdt_pair_intersects(get(), first.get(), second.get(), front_of(front), &is_touching));
        return is_touching != 0;
    }

    std::optional<BdtPairContact> pair_closest_points(const Instance &first, const Instance &second,
                                                      double max_distance = infinity)
    {
        BdtPairContact out{};
        check(bdt_pair_closest_points(get(), first.get(), second.get(), max_distance, &out));
        return out.triangle1 == BDT_NONE ? std::nullopt : std::optional<BdtPairContact>(out);
    }

    std::vector<BdtManifold> pair_manifolds(const Instance &first, const Instance &second, double prediction = 0.0,
                                            const Front *front = nullptr)
    {
        return detail::all<BdtManifold>(
            [&](BdtManifold *out, std::size_t capacity, std::size_t *count) {
                return bdt_pair_manifolds(get(), first.get(), second.get(), front_of(front), prediction, out, capacity,
                                          count);
            },
            4);
    }

private:
    static BdtFront *front_of(const Front *front) noexcept { return front == nullptr ? nullptr : front->get(); }

    detail::Owner<BdtWorkspace, bdt_workspace_free> handle_;
};

/** Bodies that fall, touch and vibrate. */
class World {
public:
    World() : World(nullptr) {}
    explicit World(const BdtWorldOptions &options) : World(&options) {}

    static BdtWorldOptions defaults()
    {
        BdtWorldOptions out{};
        check(bdt_world_defaults(&out));
        return out;
    }

    static BdtBodyOptions body_defaults()
    {
        BdtBodyOptions out{};
        check(bdt_body_defaults(&out));
        return out;
    }

    BdtWorld *get() const noexcept { return handle_.get(); }

    std::uint32_t add_model(const Model &model, const BdtBodyOptions &options = body_defaults())
    {
        std::uint32_t id = BDT_NONE;
        check(bdt_world_add_model(get(), model.get(), &options, &id));
        return id;
    }

    void add_plane(const BdtPlane &plane) { check(bdt_world_add_plane(get(), &plane)); }

    std::uint32_t add_body(std::uint32_t model, const BdtTransform &at, std::uint32_t frame = BDT_FREE)
    {
        std::uint32_t id = BDT_NONE;
        check(bdt_world_add_body(get(), model, frame, &at, &id));
        return id;
    }

    BdtStepReport step()
    {
        BdtStepReport report{};
        check(bdt_world_step(get(), &report));
        return report;
    }

    BdtBodyState state(std::uint32_t body) const
    {
        BdtBodyState out{};
        check(bdt_body_state(get(), body, &out));
        return out;
    }

    BdtTransform placement(std::uint32_t body) const
    {
        BdtTransform out{};
        check(bdt_body_placement(get(), body, &out));
        return out;
    }

    std::vector<double> q(std::uint32_t body) const
    {
        std::size_t count = 0;
        check(bdt_body_mode_count(get(), body, &count));
        std::vector<double> out(count);
        check(bdt_body_q(get(), body, out.data(), nullptr, count));
        return out;
    }

    void set_velocity(std::uint32_t body, BdtVec3 velocity, BdtVec3 angular_velocity)
    {
        check(bdt_body_set_velocity(get(), body, velocity, angular_velocity));
    }

    void add_force(std::uint32_t body, BdtVec3 force, BdtVec3 torque)
    {
        check(bdt_body_add_force(get(), body, force, torque));
    }

    void drive(std::uint32_t body, const std::vector<double> &q, const BdtTransform &at)
    {
        check(bdt_body_drive(get(), body, q.data(), q.size(), &at));
    }

    std::vector<BdtEvent> events() const
    {
        return detail::all<BdtEvent>([&](BdtEvent *out, std::size_t capacity, std::size_t *count) {
            return bdt_world_events(get(), out, capacity, count);
        });
    }

    std::vector<BdtWorldContact> contacts() const
    {
        return detail::all<BdtWorldContact>([&](BdtWorldContact *out, std::size_t capacity, std::size_t *count) {
            return bdt_world_contacts(get(), out, capacity, count);
        });
    }

    BdtEnergy energy() const
    {
        BdtEnergy out{};
        check(bdt_world_energy(get(), &out));
        return out;
    }

    std::optional<BdtHit> cast_ray(const BdtRay &ray)
    {
        BdtHit hit{};
        check(bdt_world_cast_ray(get(), &ray, &hit));
        return detail::found(hit);
    }

    std::vector<std::uint8_t> save() const
    {
        return detail::all<std::uint8_t>([&](std::uint8_t *out, std::size_t capacity, std::size_t *count) {
            return bdt_world_save(get(), out, capacity, count);
        });
    }

    void restore(const std::vector<std::uint8_t> &bytes)
    {
        check(bdt_world_restore(get(), bytes.data(), bytes.size()));
    }

private:
    explicit World(const BdtWorldOptions *options)
    {
        BdtWorld *handle = nullptr;
        check(bdt_world_new(options, &handle));
        handle_.reset(handle);
    }

    detail::Owner<BdtWorld, bdt_world_free> handle_;
};

} // namespace bdtree

#endif /* BDTREE_HPP */
