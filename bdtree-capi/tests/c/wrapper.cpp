// Calls every function of bdtree.hpp and compares it with bdtree.h or a known answer: wrapper GOLDEN_FOLDER BEAM.
#include <bdtree.hpp>

#include <cmath>
#include <cstring>
#include <fstream>
#include <iostream>
#include <iterator>
#include <numeric>
#include <stdexcept>
#include <string>

namespace {

#define REQUIRE(holds) require(holds, __LINE__, #holds)

void require(bool holds, int line, const char *what)
{
    if (!holds) {
        throw std::logic_error("line " + std::to_string(line) + ": " + what);
    }
}

template <class Call>
BdtStatus status_of(Call call)
{
    try {
        call();
    } catch (const bdtree::Error &error) {
        return error.status();
    }
    return BDT_OK;
}

bool near(double a, double b) { return std::fabs(a - b) <= 1e-9 * (1.0 + std::fabs(b)); }
bool near(const BdtVec3 &a, const BdtVec3 &b) { return near(a.x, b.x) && near(a.y, b.y) && near(a.z, b.z); }

bool near(const std::vector<BdtMatrix> &a, const std::vector<BdtMatrix> &b)
{
    bool is_near = a.size() == b.size();
    for (std::size_t i = 0; is_near && i < a.size(); i++) {
        for (std::size_t k = 0; k < 12; k++) {
            is_near &= near(a[i].rows[k / 4][k % 4], b[i].rows[k / 4][k % 4]);
        }
    }
    return is_near;
}

/** Structs without padding. */
template <class T>
bool same(const T &a, const T &b)
{
    return std::memcmp(&a, &b, sizeof a) == 0;
}

template <class T>
bool same(const std::vector<T> &a, const std::vector<T> &b)
{
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

BdtTransform at(double x, double y = 0.0, double z = 0.0) { return {{0.0, 0.0, 0.0, 1.0}, {x, y, z}, 1.0}; }

BdtRay down(double x, double z) { return {{x, 5.0, z}, {0.0, -1.0, 0.0}, bdtree::infinity}; }

void library()
{
    REQUIRE(bdtree::last_error().empty());
    REQUIRE(bdtree::version() / 1000 == BDT_VERSION_MAJOR * 1000 + BDT_VERSION_MINOR);
    REQUIRE(bdtree::version_text() == bdt_version_text() && !bdtree::version_text().empty());
    REQUIRE(bdtree::checks_handles() == (bdt_checks_handles() == 1));
    REQUIRE(bdtree::status_text(BDT_ERROR_BUSY) == bdt_status_text(BDT_ERROR_BUSY));
    // A text that is longer than the first try.
    const std::string path(9000, 'x');
    REQUIRE(status_of([&] { bdtree::Model::load(path); }) == BDT_ERROR_IO);
    REQUIRE(bdtree::last_error().find(path) != std::string::npos);
    // After a move the handle is NULL.
    bdtree::Workspace from;
    const bdtree::Workspace to = std::move(from);
    REQUIRE(status_of([&] { from.set_shared(true); }) == BDT_ERROR_NULL);

    REQUIRE(same(bdtree::ball({1.0, 2.0, 3.0}, 4.0), bdt_ball({1.0, 2.0, 3.0}, 4.0)));
    REQUIRE(bdtree::capsule({}, {0.0, 1.0, 0.0}, 0.5).kind == BDT_CAPSULE);
    REQUIRE(bdtree::cuboid({}, bdtree::identity.rotation, {1.0, 2.0, 3.0}).b.z == 3.0);
    REQUIRE(bdtree::half_space({0.0, 2.0, 0.0}, 1.5).size == 1.5);
    const BdtTransform both = bdtree::transform_after({bdtree::identity.rotation, {1.0, 0.0, 0.0}, 2.0}, at(0.0, 3.0));
    REQUIRE(near(both.translation, {1.0, 6.0, 0.0}) && near(both.scale, 2.0));
    REQUIRE(status_of([] { bdtree::transform_after({}, bdtree::identity); }) == BDT_ERROR_POSE);
    const BdtMatrix joint = bdtree::joint_in_model(at(1.0), {{{1, 0, 0, 5}, {0, 1, 0, 6}, {0, 0, 1, 7}}});
    REQUIRE(near(joint.rows[0][3], 4.0) && near(joint.rows[1][3], 6.0));
}

void models(const std::string &golden)
{
    const auto sphere = bdtree::Model::load(golden + "/sphere.bdt");
    const BdtModelInfo info = sphere.info();
    REQUIRE(info.triangle_count == 192 && info.mode_count == 3 && info.group_count == 4);
    std::ifstream file(golden + "/sphere.bdt", std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    const auto copy = bdtree::Model::from_memory(bytes.data(), bytes.size());
    REQUIRE(copy.triangles() == sphere.triangles() && sphere.triangles().size() == 576);
    const auto all = sphere.triangles();
    REQUIRE(sphere.triangles(2, 1) == std::vector<std::uint32_t>(all.begin() + 6, all.begin() + 9));
    REQUIRE(status_of([&] { sphere.triangles(190, 3); }) == BDT_ERROR_INDEX);
    sphere.verify();
    sphere.verify_checksums();
    REQUIRE(sphere.mode(1).omega_rad_s > 0.0 && sphere.mode(1).q_limit == 1024.0f);
    REQUIRE(std::fabs(sphere.mass().mass_kg - 3890.71) < 0.01);
    REQUIRE(sphere.group(0).triangle_count <= 192 && !sphere.group_name(0).empty());
    REQUIRE(sphere.mode_name(1) == "field 1");

    const auto animated = bdtree::Model::read(golden + "/animated.bdt");
    double first_s = -1.0, last_s = -1.0;
    animated.frame(0, &first_s);
    const auto last = animated.frame(3, &last_s);
    REQUIRE(first_s == 0.0 && last_s == animated.info().duration_s);
    REQUIRE(animated.sample(last_s).first == last.first);
    REQUIRE(status_of([&] { animated.frame(4); }) == BDT_ERROR_INDEX);
    REQUIRE(status_of([&] { bdtree::SkeletonPose pose(animated); }) == BDT_ERROR_NO_SKIN);
}

void characters(const std::string &golden)
{
    const auto model = bdtree::Model::read(golden + "/skinned.bdt");
    const BdtModelInfo info = model.info();
    REQUIRE(model.mode_name(0) == "bulge" && model.mode_index("bulge") == 0);
    REQUIRE(model.clip_name(1) == "slide" && model.clip_index("slide") == 1);
    REQUIRE(model.clip_duration(0) == 1.5);
    REQUIRE(status_of([&] { model.clip_index("none"); }) == BDT_ERROR_INDEX);
    std::size_t roots = 0;
    for (std::size_t joint = 0; joint < info.joint_count; joint++) {
        REQUIRE(model.joint_index(model.joint_name(joint)) == joint);
        roots += model.joint_parent(joint) == BDT_NONE;
    }
    REQUIRE(roots == 1);
    REQUIRE(model.joint_of(0, {1.0, 0.0, 0.0}) < info.joint_count);

    bdtree::SkeletonPose pose(model);
    REQUIRE(pose.q() == std::vector<float>{0.25f}); // the target's weight at rest
    REQUIRE(pose.nodes().size() == info.skeleton_node_count);
    const auto rest = pose.joints();
    pose.play(0, 0.7);
    const auto played = pose.joints();
    REQUIRE(played.size() == info.joint_count && !same(played, rest));
    pose.rest();
    REQUIRE(same(pose.joints(), rest));
    pose.blend(0, 0.7, 1.0);
    REQUIRE(near(pose.joints(), played));
    const BdtLocal local = pose.local(0);
    pose.set_local(0, local);
    pose.update();

    // The same pose three ways, and the bones at rest by the identity of skinning.
    bdtree::Instance one(model), other(model, 0, 0);
    one.set_pose(pose);
    other.set_pose(pose.q(), pose.joints(), bdtree::identity);
    REQUIRE(same(one.vertices(0, info.vertex_count), other.vertices(0, info.vertex_count)));
    other.set_joints(rest);
    REQUIRE(!same(one.exact_aabb(), other.exact_aabb()));
    one.set_pose(pose.q(), bdtree::identity);
    one.set_skinning_matrices(std::vector<BdtMatrix>(info.bone_count, {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}));
    const BdtAabb box = one.exact_aabb();
    REQUIRE(near(box.min.x, 0.0) && near(box.max.x, 8.0)); // the bind box
    REQUIRE(status_of([&] { one.set_joints({}); }) == BDT_ERROR_LENGTH);
}

void instances(const bdtree::Model &sphere)
{
    bdtree::Instance body(sphere);
    body.set_q({0.25f, 0.0f, 0.125f});
    REQUIRE(body.q() == (std::vector<float>{0.25f, 0.0f, 0.125f}));
    REQUIRE(status_of([&] { body.set_q({0.0f}); }) == BDT_ERROR_LENGTH);
    body.set_refining(true);
    body.set_refining(false);
    body.set_placement(at(3.0));
    REQUIRE(body.placement().translation.x == 3.0);
    REQUIRE(body.tags().collision_mask == UINT32_MAX);
    body.set_tags({7, 1, 2});
    REQUIRE(body.tags().user_data == 7 && body.tags().collision_group == 1);
    const BdtAabb box = body.aabb(), exact = body.exact_aabb();
    REQUIRE(box.min.x <= exact.min.x && exact.max.x <= box.max.x);
    REQUIRE(body.bounding_sphere().radius >= (exact.max.x - exact.min.x) / 2.0);

    // A cache of nodes keeps what the first of two queries has computed.
    bdtree::Workspace workspace;
    for (const std::size_t nodes : {0, 64}) {
        const bdtree::Instance cached(sphere, nodes, 64 - nodes);
        workspace.cast_ray(cached, down(0.1, 0.2));
        workspace.cast_ray(cached, down(0.1, 0.2));
        REQUIRE((workspace.stats().nodes_updated == 0) == (nodes == 64));
    }
    REQUIRE(status_of([&] { bdtree::Instance(sphere, 1 << 25, 0); }) == BDT_ERROR_ARGUMENT);

    // What the force adds is linear; the C function says the same.
    std::vector<double> once(3), twice(3), plain(3);
    const BdtVec3 third{1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0}, force{1.0, 2.0, 3.0};
    body.add_generalized_force(5, third, force, once);
    body.add_generalized_force(5, third, force, twice);
    body.add_generalized_force(5, third, force, twice);
    REQUIRE(bdt_instance_add_generalized_force(body.get(), 5, third, force, plain.data(), 3) == BDT_OK);
    REQUIRE(once == plain && once != std::vector<double>(3) && near(twice[0], 2.0 * once[0]));
    REQUIRE(status_of([&] { body.add_generalized_force(192, third, force, once); }) == BDT_ERROR_INDEX);
}

void callbacks(bdtree::Workspace &workspace, const bdtree::Instance &body, const bdtree::Instance &other)
{
    const BdtShape shape = bdtree::ball({1.0, 0.0, 0.0}, 1.0);
    std::vector<BdtContact> taken;
    REQUIRE(workspace.contacts_each(body, shape, [&](const BdtContact &contact) { taken.push_back(contact); }));
    REQUIRE(taken.size() > 1 && same(taken, workspace.contacts(body, shape)));
    std::size_t count = 0;
    const auto until_two = [&](const auto &) { return ++count < 2; };
    REQUIRE(!workspace.contacts_each(body, shape, until_two) && count == 2);
    count = 0;
    try {
        workspace.contacts_each(body, shape, [&](const BdtContact &) {
            count++;
            throw std::runtime_error("out of the callback");
        });
        REQUIRE(false);
    } catch (const std::runtime_error &error) {
        REQUIRE(error.what() == std::string("out of the callback") && count == 1);
    }
    // An Error of a call that is not allowed there comes out as well, and the workspace goes on.
    REQUIRE(status_of([&] {
                workspace.contacts_each(body, shape, [&](const BdtContact &) { workspace.intersects(body, shape); });
            }) == BDT_ERROR_BUSY);
    REQUIRE(status_of([&] { workspace.contacts_each(body, bdtree::ball({}, -1.0), until_two); }) ==
            BDT_ERROR_ARGUMENT);

    std::vector<BdtHit> hits;
    REQUIRE(workspace.cast_ray_all_each(body, down(0.1, 0.2), [&](const BdtHit &hit) { hits.push_back(hit); }));
    REQUIRE(hits.size() == 2 && same(hits, workspace.cast_ray_all(body, down(0.1, 0.2))));
    count = 1;
    REQUIRE(!workspace.cast_ray_all_each(body, down(0.1, 0.2), until_two));

    std::vector<BdtPairContact> pairs;
    bdtree::Front front;
    REQUIRE(workspace.pair_contacts_each(
        body, other, [&](const BdtPairContact &pair) { pairs.push_back(pair); }, 0.0, &front));
    REQUIRE(pairs.size() > 2 && pairs.size() == workspace.pair_contacts(body, other).size());
    count = 0;
    REQUIRE(!workspace.pair_contacts_each(body, other, until_two) && count == 2);
}

void queries(bdtree::Workspace &workspace, const bdtree::Instance &body, const bdtree::Instance &far)
{
    // As many hits as one by one: more than the first try has room for.
    std::vector<BdtRay> rays;
    for (int i = 0; i < 100; i++) {
        rays.push_back(down(-1.2 + 0.024 * i, 0.013));
    }
    const auto all = workspace.cast_rays_all(body, rays);
    const auto first = workspace.cast_rays(body, rays);
    const auto is_met = workspace.intersects_rays(body, rays);
    std::size_t count = 0;
    for (std::size_t i = 0; i < rays.size(); i++) {
        const auto one = workspace.cast_ray(body, rays[i]);
        REQUIRE(one.has_value() == (is_met[i] == 1) && workspace.intersects_ray(body, rays[i]) == one.has_value());
        REQUIRE(one ? first[i].triangle == one->triangle : first[i].triangle == BDT_NONE);
        for (const BdtHit &hit : workspace.cast_ray_all(body, rays[i])) {
            REQUIRE(all.at(count).triangle == hit.triangle && all[count].index == i);
            count++;
        }
    }
    REQUIRE(count == all.size() && count > 4096 / sizeof(BdtHit));
    const auto met = std::accumulate(is_met.begin(), is_met.end(), std::size_t{0});
    REQUIRE(met > 50 && met < 100);

    const auto grid = workspace.cast_rays_at_instances({&far, &body}, rays);
    const auto nearest = workspace.cast_rays_nearest({&far, &body}, rays);
    REQUIRE(grid.size() == 200 && nearest.size() == 100);
    for (std::size_t k = 0; k < rays.size(); k++) {
        REQUIRE(grid[k].triangle == BDT_NONE && grid[100 + k].triangle == first[k].triangle);
        REQUIRE(nearest[k].triangle == first[k].triangle && (is_met[k] == 0 || nearest[k].index == 1));
    }
    REQUIRE(status_of([&] { workspace.cast_rays_nearest({nullptr}, rays); }) == BDT_ERROR_NULL);

    const BdtShape shape = bdtree::capsule({0.0, 1.0, 0.0}, {0.0, 2.0, 0.0}, 0.25);
    REQUIRE(workspace.intersects(body, shape) && !workspace.intersects(far, shape));
    const auto nearest_point = workspace.project_point(body, {0.0, 5.0, 0.0});
    REQUIRE(nearest_point && nearest_point->distance > 3.0 && nearest_point->distance < 5.0);
    REQUIRE(!workspace.project_point(body, {0.0, 5.0, 0.0}, 1.0));
    REQUIRE(workspace.frustum_state(body, {{{0.0, 1.0, 0.0}, 50.0}}) == BDT_INSIDE);
    REQUIRE(workspace.frustum_state(body, {{{0.0, 1.0, 0.0}, -50.0}}) == BDT_OUTSIDE);

    const BdtShape all_of_it = bdtree::cuboid({}, bdtree::identity.rotation, {9.0, 9.0, 9.0});
    REQUIRE(workspace.level_spheres(body, 0, all_of_it).size() == 7); // as many as level 0 has
    REQUIRE(workspace.level_spheres(body, 1, all_of_it).size() >= 55);
    workspace.set_max_levels(0);
    REQUIRE(workspace.contacts(body, all_of_it).empty() && workspace.proxies().size() == 7);
    workspace.set_max_levels(-1);
    workspace.set_max_visits(1);
    workspace.project_point(body, {0.0, 5.0, 0.0});
    REQUIRE(workspace.bound().is_complete == 0 && workspace.bound().at_least < 5.0);
    REQUIRE(workspace.stats().nodes_visited == 1);
    workspace.set_max_visits(0);
    workspace.set_shared(true);
    REQUIRE(workspace.contacts(body, all_of_it).size() == 192);
    workspace.set_shared(false);
    REQUIRE(workspace.contacts(body, bdtree::half_space({0.0, 1.0, 0.0}, -9.0)).empty());
}

void pairs(bdtree::Workspace &workspace, bdtree::Instance &body, bdtree::Instance &other, const bdtree::Instance &far)
{
    bdtree::Front front;
    REQUIRE(workspace.pair_intersects(body, other, &front) && !workspace.pair_intersects(body, far));
    const auto contacts = workspace.pair_contacts(body, other, 0.0, &front);
    REQUIRE(workspace.pair_triangles(body, other).size() == contacts.size());
    const auto regions = workspace.pair_manifolds(body, other);
    REQUIRE(!regions.empty() && same(workspace.pair_condense(body, other, contacts), regions));
    auto wrong = contacts;
    wrong[0].triangle1 = 1000;
    REQUIRE(status_of([&] { workspace.pair_condense(body, other, wrong); }) == BDT_ERROR_ARGUMENT);

    REQUIRE(workspace.pair_distance(body, other) == 0.0);
    const auto distance = workspace.pair_distance(body, far);
    REQUIRE(distance && workspace.pair_closest_points(body, far)->distance == *distance && *distance > 1.0);
    REQUIRE(!workspace.pair_distance(body, far, 1.0) && !workspace.pair_closest_points(body, far, 1.0));

    std::vector<BdtLanePair> lanes(4096);
    std::size_t count = 0;
    REQUIRE(bdt_pair_level_spheres(workspace.get(), body.get(), other.get(), 0, 1, 0.1, 0.0, lanes.data(), lanes.size(),
                                   &count) == BDT_OK);
    lanes.resize(count);
    REQUIRE(count > 32 && same(workspace.pair_level_spheres(body, other, 0, 1, 0.1), lanes));
    std::vector<BdtLaneTriangle> near_lanes(8192);
    REQUIRE(bdt_pair_level_triangles(workspace.get(), body.get(), other.get(), 1, 0.1, 0.0, near_lanes.data(),
                                     near_lanes.size(), &count) == BDT_OK);
    near_lanes.resize(count);
    REQUIRE(count > 0 && same(workspace.pair_level_triangles(body, other, 1, 0.1), near_lanes));

    const std::vector<BdtSphere> spheres{{{}, 1.0}, {{5.0, 0.0, 0.0}, 1.0}, {{1.5, 0.0, 0.0}, 1.0}};
    REQUIRE(same(workspace.sphere_pairs(spheres), {{0, 2}}));
    REQUIRE(workspace.sphere_pairs(spheres, 10.0).size() == 3);
    REQUIRE(same(workspace.instance_pairs({&far, &body, &other}), {{1, 2}}));
    other.set_tags({0, 1, 1});
    body.set_tags({0, 2, 2});
    REQUIRE(workspace.instance_pairs({&far, &body, &other}).empty());
}

void worlds(const bdtree::Model &beam)
{
    BdtWorldOptions options = bdtree::World::defaults();
    options.sleep_speed = 0.0;
    bdtree::World world(options);
    world.add_plane({{0.0, 1.0, 0.0}, 0.0});
    const auto kind = world.add_model(beam);
    const auto body = world.add_body(kind, at(0.0, 3.0)), driven = world.add_body(kind, at(50.0, 9.0), BDT_DRIVEN);
    REQUIRE(world.mode_count(body) == 3);
    REQUIRE(status_of([&] { world.add_body(kind + 1, bdtree::identity); }) == BDT_ERROR_INDEX);

    world.set_modes(body, {0.01, 0.0, 0.0}, {0.0, 0.5, 0.0});
    REQUIRE(near(world.q(body)[0], 0.01) && near(world.rate(body)[1], 0.5));
    REQUIRE(status_of([&] { world.set_modes(body, {0.0, 0.0, 0.0}, {0.0}); }) == BDT_ERROR_LENGTH);
    REQUIRE(status_of([&] { world.set_modes(body, {}, {}); }) == BDT_ERROR_LENGTH);
    world.add_modal_impulse(body, {0.0, 0.0, 1.0});
    REQUIRE(world.rate(body)[2] != 0.0);
    world.set_modes(body, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0});
    REQUIRE(world.energy().modal == 0.0);
    world.set_velocity(body, {0.0, -1.0, 0.0}, {});
    REQUIRE(near(world.momenta().linear, {0.0, -beam.mass().mass_kg, 0.0}));

    // Without and with forces, from the same state.
    const auto before = world.save();
    world.step();
    const auto without = world.state(body);
    world.restore(before);
    world.add_force(body, {100.0, 0.0, 0.0}, {});
    world.add_modal_force(body, {10.0, 0.0, 0.0});
    world.drive(driven, {0.0, 0.0, 0.0}, at(50.0, 9.5));
    world.step();
    REQUIRE(world.state(body).velocity.x > 0.0 && near(without.velocity.x, 0.0));
    REQUIRE(world.q(body)[0] > 0.0 && near(world.placement(driven).translation.y, 9.5));
    REQUIRE(status_of([&] { world.restore({1, 2, 3}); }) == BDT_ERROR_STATE);

    bool has_landed = false;
    for (int step = 0; step < 300 && !has_landed; step++) {
        world.step();
        for (const BdtEvent &event : world.events()) {
            has_landed |= event.phase == BDT_BEGAN && event.body1 == body && event.body2 == BDT_NONE;
        }
    }
    REQUIRE(has_landed && !world.contacts().empty() && world.contacts()[0].body1 == body);
    const bdtree::Counts counts = world.counts();
    REQUIRE(counts.bodies == 2 && counts.asleep == 0 && counts.steps > 10);
    const auto touched = world.touched_by(bdtree::ball({50.0, 9.5, 0.0}, 50.0));
    REQUIRE(!touched.empty() && touched[0].body <= 1);
    const BdtVec3 center = world.state(body).position;
    const auto hit = world.cast_ray({{center.x, 20.0, center.z}, {0.0, -1.0, 0.0}, bdtree::infinity});
    REQUIRE(hit && hit->index == body);
    REQUIRE(status_of([&] { world.state(2); }) == BDT_ERROR_INDEX);
    REQUIRE(bdtree::World().counts().bodies == 0);
}

} // namespace

int main(int argc, char **argv)
{
    try {
        REQUIRE(argc == 3);
        const std::string golden = argv[1];
        library();
        models(golden);
        characters(golden);
        const auto sphere = bdtree::Model::load(golden + "/sphere.bdt");
        instances(sphere);
        bdtree::Workspace workspace;
        bdtree::Instance body(sphere), other(sphere), far(sphere);
        other.set_placement(at(1.1, 0.2));
        far.set_placement(at(0.0, 0.0, 100.0));
        callbacks(workspace, body, other);
        queries(workspace, body, far);
        pairs(workspace, body, other, far);
        worlds(bdtree::Model::load(argv[2]));
    } catch (const std::exception &error) {
        std::cerr << error.what() << '\n';
        return 1;
    }
    std::cout << "bdtree.hpp does what bdtree.h does\n";
    return 0;
}
