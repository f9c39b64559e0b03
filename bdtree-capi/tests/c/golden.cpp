// Asks the questions of the golden files through bdtree.hpp and prints the answers as fixtures/golden has them.
#include <bdtree.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iostream>
#include <string>
#include <tuple>

namespace {

// The shortest decimals that read back equal, written as JSON writers of Rust do.
std::string number(double x)
{
    char text[64];
    const auto end = std::to_chars(text, text + sizeof text, std::fabs(x), std::chars_format::scientific).ptr;
    const std::string all(text, end);
    const auto e = all.find('e');
    std::string digits = all.substr(0, e);
    digits.erase(std::remove(digits.begin(), digits.end(), '.'), digits.end());
    const int count = static_cast<int>(digits.size()), point = std::stoi(all.substr(e + 1)) + 1;
    const std::string sign = std::signbit(x) ? "-" : "";
    if (x == 0.0) {
        return sign + "0.0";
    }
    if (count <= point && point <= 16) {
        return sign + digits + std::string(static_cast<std::size_t>(point - count), '0') + ".0";
    }
    if (point > 0 && point <= 16) {
        return sign + digits.insert(static_cast<std::size_t>(point), ".");
    }
    if (point > -5 && point <= 0) {
        return sign + "0." + std::string(static_cast<std::size_t>(-point), '0') + digits;
    }
    if (count > 1) {
        digits.insert(1, ".");
    }
    return sign + digits + "e" + std::to_string(point - 1);
}

std::string vector(const BdtVec3 &v)
{
    return "[" + number(v.x) + "," + number(v.y) + "," + number(v.z) + "]";
}

void line(const std::string &answer, const char *kind, int step)
{
    std::cout << "{\"answer\":" << answer << ",\"kind\":\"" << kind << "\",\"step\":" << step << "}\n";
}

std::string contacts(std::vector<BdtContact> found)
{
    std::sort(found.begin(), found.end(),
              [](const BdtContact &a, const BdtContact &b) { return a.triangle < b.triangle; });
    std::string out = "[";
    for (const BdtContact &c : found) {
        out += (out.size() > 1 ? ",[" : "[") + std::to_string(c.triangle) + "," + vector(c.point) + "," +
               vector(c.normal) + "," + number(c.distance) + "," + vector(c.barycentric) + "]";
    }
    return out + "]";
}

std::string hit(const std::optional<BdtHit> &found)
{
    return !found ? "null"
                  : "[" + std::to_string(found->triangle) + "," + vector(found->point) + "," +
                        number(found->distance) + "," + vector(found->barycentric) + "]";
}

std::string pairs(const std::vector<BdtPairContact> &found)
{
    std::vector<std::pair<std::uint32_t, std::uint32_t>> ids;
    for (const BdtPairContact &pair : found) {
        ids.emplace_back(pair.triangle1, pair.triangle2);
    }
    std::sort(ids.begin(), ids.end());
    std::string out;
    for (std::size_t i = 0; i < ids.size() && i < 40; i++) {
        out += (i ? ",[" : "[") + std::to_string(ids[i].first) + "," + std::to_string(ids[i].second) + "]";
    }
    return "[" + std::to_string(ids.size()) + ",[" + out + "]]";
}

// Joints that turn a little more with each bone and step, about an axis that changes.
std::vector<BdtMatrix> turned(bdtree::SkeletonPose &pose, std::size_t nodes, int step)
{
    const BdtQuat turns[3] = {{0.0, 0.0, 0.0, 1.0}, {0.0, 0.0, 0.28, 0.96}, {0.36, 0.48, 0.0, 0.8}};
    pose.rest();
    for (std::size_t node = 0; node < nodes; node++) {
        BdtLocal local = pose.local(node);
        local.rotation = turns[step % 3];
        pose.set_local(node, local);
    }
    pose.update();
    return pose.joints();
}

void answers(const char *path)
{
    const auto model = bdtree::Model::read(path);
    const BdtModelInfo info = model.info();
    bdtree::Instance body(model), other(model);
    bdtree::Workspace workspace;
    std::optional<bdtree::SkeletonPose> skeleton;
    if (info.joint_count > 0) {
        skeleton.emplace(model);
    }
    const BdtQuat turns[3] = {{0.0, 0.0, 0.0, 1.0}, {0.6, 0.0, 0.8, 0.0}, {0.5, 0.5, 0.5, 0.5}};
    const auto place = [&](int step) {
        return BdtTransform{turns[step], {static_cast<double>(step), 0.0, -0.5}, 1.0 + 0.5 * step};
    };
    for (int step = 0; step < 3 + 2 * static_cast<int>(info.frame_count); step++) {
        std::vector<float> q(info.mode_count);
        BdtTransform at;
        if (step < 3) {
            at = place(step);
            for (std::size_t j = 0; j < q.size(); j++) {
                q[j] = static_cast<float>(step) * (j % 2 == 0 ? 0.25f : -0.125f);
            }
        } else {
            std::tie(q, at) = model.frame(static_cast<std::size_t>(step - 3) / 2);
            if ((step - 3) % 2) {
                at = bdtree::transform_after(place(1), at);
            }
        }
        const auto joints = skeleton ? turned(*skeleton, info.skeleton_node_count, step) : std::vector<BdtMatrix>();
        body.set_pose(q, joints, at);
        const BdtVec3 point{0.75, 0.5, 0.25};
        line(contacts(workspace.contacts(body, bdtree::ball(point, 0.5))), "ball", step);
        line(contacts(workspace.contacts(body, bdtree::half_space({0.0, 3.0, 4.0}, -0.75))), "plane", step);
        line(hit(workspace.project_point(body, point)), "closest", step);
        line(hit(workspace.cast_ray(body, {{3.0, 1.5, 0.5}, {-1.0, -0.5, -0.25}, 100.0})), "ray", step);
        line(pairs(workspace.pair_contacts(body, other)), "pair", step);
    }
}

} // namespace

int main(int argc, char **argv)
{
    if (argc != 2) {
        return 2;
    }
    try {
        bdtree::Model::load("no such file");
        return 1;
    } catch (const bdtree::Error &error) {
        if (error.status() != BDT_ERROR_IO) {
            return 1;
        }
    }
    answers(argv[1]);
    return 0;
}
