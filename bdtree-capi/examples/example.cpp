// Bake: bdtree-build chair.obj --modes 10 -o chair.bdt. Then: c++ example.cpp $(pkg-config --cflags --libs bdtree)
#include <bdtree.hpp>
#include <iostream>

int main(int argc, char **argv)
{
    try {
        const auto model = bdtree::Model::load(argc == 2 ? argv[1] : "");
        bdtree::Instance chair(model), other(model);
        bdtree::Workspace workspace;
        std::vector<float> q(model.info().mode_count);
        q[0] = 0.01f;
        chair.set_q(q);
        other.set_placement({{0, 0, 0, 1}, {0.3, 0, 0}, 1});
        if (const auto hit = workspace.cast_ray(chair, {{0.1, 5, 0.2}, {0, -1, 0}, bdtree::infinity})) {
            std::cout << "triangle " << hit->triangle << " at distance " << hit->distance << '\n';
        }
        const auto touched = workspace.contacts(chair, bdt_ball({0, 0.4, 0}, 0.2));
        const auto regions = workspace.pair_manifolds(chair, other);
        std::cout << touched.size() << " triangles touched, " << regions.size() << " regions of contact\n";
        return 0;
    } catch (const bdtree::Error &error) {
        std::cout << error.what() << '\n';
        return 1;
    }
}
