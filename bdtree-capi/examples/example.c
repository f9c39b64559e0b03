/* Bake: bdtree-build chair.obj --modes 10 -o chair.bdt. Then: cc example.c $(pkg-config --cflags --libs bdtree) */
#include <bdtree.h>
#include <math.h>
#include <stdio.h>

int main(int argc, char **argv)
{
    BdtModel *model = NULL;
    BdtInstance *chair = NULL;
    BdtWorkspace *workspace = NULL;
    BdtTransform at = {{0, 0, 0, 1}, {0, 0, 0}, 1};
    BdtRay ray = {{0.1, 5, 0.2}, {0, -1, 0}, INFINITY};
    float q[512] = {0.01f}; /* the first mode; the rest is 0 */
    char text[256] = "usage: example FILE.bdt";
    BdtModelInfo info;
    BdtHit hit;
    int failed = argc != 2 || bdt_model_load(argv[1], &model) || bdt_model_info(model, &info) ||
                 bdt_instance_new(model, &chair) || bdt_workspace_new(&workspace) ||
                 bdt_instance_set_pose(chair, q, info.mode_count, &at) ||
                 bdt_cast_ray(workspace, chair, &ray, &hit);
    if (failed)
        bdt_last_error(text, sizeof text, NULL);
    else
        snprintf(text, sizeof text, "triangle %u at distance %.6g", (unsigned)hit.triangle, hit.distance);
    puts(text);
    bdt_workspace_free(workspace);
    bdt_instance_free(chair);
    bdt_model_free(model);
    return failed;
}
