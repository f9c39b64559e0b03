/*
 * The conversion of docs/guide/unreal.md: what Unreal's transforms do in Unreal's axes, the converted ones do in the
 * mesh's. Transforms move points as FTransform::TransformPosition says: rotate(scale * p) + translation.
 */
#include "BdtreeAxes.h"
#include <cmath>
#include <cstdio>
#include <cstdlib>

struct Vector {
    double X, Y, Z;
    Vector(double x, double y, double z) : X(x), Y(y), Z(z) {}
};
struct Quat {
    double X, Y, Z, W;
};

static void expect(bool holds, const char *what)
{
    if (!holds) {
        std::printf("%s\n", what);
        std::exit(1);
    }
}

static Vector cross(const Vector &a, const Vector &b)
{
    return Vector(a.Y * b.Z - a.Z * b.Y, a.Z * b.X - a.X * b.Z, a.X * b.Y - a.Y * b.X);
}

/* FQuat::RotateVector. */
static Vector rotated(const Quat &q, const Vector &v)
{
    const Vector axis(q.X, q.Y, q.Z);
    const Vector once = cross(axis, v);
    const Vector t(2 * once.X, 2 * once.Y, 2 * once.Z);
    const Vector twice = cross(axis, t);
    return Vector(v.X + q.W * t.X + twice.X, v.Y + q.W * t.Y + twice.Y, v.Z + q.W * t.Z + twice.Z);
}

static bool same(const BdtVec3 &a, const BdtVec3 &b)
{
    return std::fabs(a.x - b.x) + std::fabs(a.y - b.y) + std::fabs(a.z - b.z) < 1e-12;
}

static BdtVec3 moved(const BdtMatrix &by, const BdtVec3 &p)
{
    const auto row = [&](int r) { return by.rows[r][0] * p.x + by.rows[r][1] * p.y + by.rows[r][2] * p.z + by.rows[r][3]; };
    return {row(0), row(1), row(2)};
}

static double next()
{
    static unsigned state = 12345;
    state = state * 1664525u + 1013904223u;
    return (state >> 8) / double(1 << 24) * 2 - 1;
}

int main(int argc, char **argv)
{
    /* One meter up and half a meter to the front: a file of glTF has y up. */
    const Vector point(50, 0, 100);
    expect(same(BdtreeAxes::Point(point), {0.5, 1.0, 0.0}), "y is up in the mesh, in meters");
    /* Unreal turns x to y about z; the same turn goes about the mesh's y. */
    const double half = std::sqrt(0.5);
    const Vector y = rotated({0, 0, half, half}, Vector(1, 0, 0));
    expect(std::fabs(y.Y - 1) < 1e-12, "Unreal turns x to y");

    const bdtree::Model model = bdtree::Model::load(argc == 2 ? argv[1] : "");
    bdtree::Instance rest(model), placed(model);
    const std::vector<BdtVec3> vertices = rest.vertices(0, model.info().vertex_count);
    for (int i = 0; i < 200; i++) {
        Quat turn{next(), next(), next(), next()};
        const double length = std::sqrt(turn.X * turn.X + turn.Y * turn.Y + turn.Z * turn.Z + turn.W * turn.W);
        turn = {turn.X / length, turn.Y / length, turn.Z / length, turn.W / length};
        const Vector translation(300 * next(), 300 * next(), 300 * next());
        const Vector scale(2 * next(), 0.5, 1 + 0.5 * next());
        const Vector p(100 * next(), 100 * next(), 100 * next());

        const Vector there = rotated(turn, Vector(scale.X * p.X, scale.Y * p.Y, scale.Z * p.Z));
        const Vector unreal(there.X + translation.X, there.Y + translation.Y, there.Z + translation.Z);
        const BdtVec3 mesh = moved(BdtreeAxes::Joint(translation, turn, scale), BdtreeAxes::Point(p));
        expect(same(mesh, BdtreeAxes::Point(unreal)), "bones move points as in Unreal");

        const Vector back = BdtreeAxes::FromPoint<Vector>(BdtreeAxes::Point(p));
        const Vector along = BdtreeAxes::FromDirection<Vector>(BdtreeAxes::Direction(p));
        expect(std::fabs(back.X - p.X) + std::fabs(back.Y - p.Y) + std::fabs(back.Z - p.Z) < 1e-10, "points come back");
        expect(along.X == p.X && along.Y == p.Y && along.Z == p.Z, "directions come back");

        /* A placed model: each vertex as Unreal would move it. */
        placed.set_placement(BdtreeAxes::Placement(translation, turn, 1.5));
        const std::vector<BdtVec3> after = placed.vertices(0, vertices.size());
        for (std::size_t v = 0; v < vertices.size(); v++) {
            const Vector own = BdtreeAxes::FromPoint<Vector>(vertices[v]);
            const Vector turned = rotated(turn, Vector(1.5 * own.X, 1.5 * own.Y, 1.5 * own.Z));
            const Vector at(turned.X + translation.X, turned.Y + translation.Y, turned.Z + translation.Z);
            expect(same(after[v], BdtreeAxes::Point(at)), "placements move the mesh as in Unreal");
        }
    }
    std::puts("axes and units: 200 transforms");
}
