/* Asks the questions of the golden files through bdtree.h and prints the answers as fixtures/golden has them. */
#include <bdtree.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void check(BdtStatus status)
{
    if (status != BDT_OK) {
        char text[512] = "";
        bdt_last_error(text, sizeof text, NULL);
        fprintf(stderr, "%s: %s\n", bdt_status_text(status), text);
        exit(1);
    }
}

static void *room(size_t count, size_t size)
{
    void *memory = calloc(count ? count : 1, size);
    if (!memory)
        exit(1);
    return memory;
}

/* The shortest decimals that read back equal, written as JSON writers of Rust do. */
static void number(double x)
{
    char text[40], digits[20];
    int precision, count = 0, point, i;
    const char *e;
    for (precision = 0; precision < 17; precision++) {
        sprintf(text, "%.*e", precision, x);
        if (strtod(text, NULL) == x)
            break;
    }
    if (signbit(x))
        putchar('-');
    e = strchr(text, 'e');
    for (i = 0; text + i < e; i++)
        if (text[i] >= '0' && text[i] <= '9')
            digits[count++] = text[i];
    while (count > 1 && digits[count - 1] == '0')
        count--;
    point = atoi(e + 1) + 1; /* digits before the point */
    if (x == 0.0) {
        printf("0.0");
    } else if (count <= point && point <= 16) {
        printf("%.*s%.*s.0", count, digits, point - count, "0000000000000000");
    } else if (point > 0 && point <= 16) {
        printf("%.*s.%.*s", point, digits, count - point, digits + point);
    } else if (point > -5 && point <= 0) {
        printf("0.%.*s%.*s", -point, "0000", count, digits);
    } else if (count == 1) {
        printf("%ce%d", digits[0], point - 1);
    } else {
        printf("%c.%.*se%d", digits[0], count - 1, digits + 1, point - 1);
    }
}

static void vector(BdtVec3 v)
{
    putchar('[');
    number(v.x);
    putchar(',');
    number(v.y);
    putchar(',');
    number(v.z);
    putchar(']');
}

static int by_triangle(const void *a, const void *b)
{
    const BdtContact *x = a, *y = b;
    return (x->triangle > y->triangle) - (x->triangle < y->triangle);
}

static int by_pair(const void *a, const void *b)
{
    const BdtPairContact *x = a, *y = b;
    if (x->triangle1 != y->triangle1)
        return x->triangle1 > y->triangle1 ? 1 : -1;
    return (x->triangle2 > y->triangle2) - (x->triangle2 < y->triangle2);
}

static void end(const char *kind, int step)
{
    printf(",\"kind\":\"%s\",\"step\":%d}\n", kind, step);
}

static void contacts(BdtWorkspace *workspace, BdtInstance *body, BdtShape shape, const char *kind, int step)
{
    size_t count = 0, again = 0, i;
    BdtContact *found;
    BdtStatus status = bdt_contacts(workspace, body, &shape, NULL, 0, &count);
    if (status != (count ? BDT_TRUNCATED : BDT_OK))
        exit(1);
    found = room(count, sizeof *found);
    check(bdt_contacts(workspace, body, &shape, found, count, &again));
    if (again != count)
        exit(1);
    qsort(found, count, sizeof *found, by_triangle);
    printf("{\"answer\":[");
    for (i = 0; i < count; i++) {
        printf("%s[%u,", i ? "," : "", (unsigned)found[i].triangle);
        vector(found[i].point);
        putchar(',');
        vector(found[i].normal);
        putchar(',');
        number(found[i].distance);
        putchar(',');
        vector(found[i].barycentric);
        putchar(']');
    }
    putchar(']');
    end(kind, step);
    free(found);
}

static void hit(const BdtHit *found, const char *kind, int step)
{
    printf("{\"answer\":");
    if (found->triangle == BDT_NONE) {
        printf("null");
    } else {
        printf("[%u,", (unsigned)found->triangle);
        vector(found->point);
        putchar(',');
        number(found->distance);
        putchar(',');
        vector(found->barycentric);
        putchar(']');
    }
    end(kind, step);
}

static void pairs(BdtWorkspace *workspace, BdtInstance *body, BdtInstance *other, int step)
{
    size_t count = 0, i;
    BdtPairContact *found;
    bdt_pair_contacts(workspace, body, other, NULL, 0.0, NULL, 0, &count);
    found = room(count, sizeof *found);
    check(bdt_pair_contacts(workspace, body, other, NULL, 0.0, found, count, &count));
    qsort(found, count, sizeof *found, by_pair);
    printf("{\"answer\":[%u,[", (unsigned)count);
    for (i = 0; i < count && i < 40; i++)
        printf("%s[%u,%u]", i ? "," : "", (unsigned)found[i].triangle1, (unsigned)found[i].triangle2);
    printf("]]");
    end("pair", step);
    free(found);
}

/* Joints that turn a little more with each bone and step, about an axis that changes. */
static void turn(BdtSkeletonPose *pose, size_t nodes, int step, BdtMatrix *joints, size_t count)
{
    static const BdtQuat turns[3] = {{0.0, 0.0, 0.0, 1.0}, {0.0, 0.0, 0.28, 0.96}, {0.36, 0.48, 0.0, 0.8}};
    size_t node;
    check(bdt_skeleton_pose_rest(pose));
    for (node = 0; node < nodes; node++) {
        BdtLocal local;
        check(bdt_skeleton_pose_local(pose, node, &local));
        local.rotation = turns[step % 3];
        check(bdt_skeleton_pose_set_local(pose, node, &local));
    }
    check(bdt_skeleton_pose_update(pose));
    check(bdt_skeleton_pose_joints(pose, joints, count));
}

int main(int argc, char **argv)
{
    static const BdtQuat turns[3] = {{0.0, 0.0, 0.0, 1.0}, {0.6, 0.0, 0.8, 0.0}, {0.5, 0.5, 0.5, 0.5}};
    BdtModel *model;
    BdtModelInfo info;
    BdtInstance *body, *other;
    BdtWorkspace *workspace;
    BdtSkeletonPose *skeleton = NULL;
    BdtMatrix *joints;
    BdtTransform second = {{0.0, 0.0, 0.0, 1.0}, {0.0, 0.0, 0.0}, 1.0};
    float *q;
    int step, steps;
    if (argc != 2)
        return 2;
    check(bdt_model_load(argv[1], &model));
    check(bdt_model_verify(model));
    check(bdt_model_info(model, &info));
    check(bdt_instance_new(model, &body));
    check(bdt_instance_new(model, &other));
    check(bdt_workspace_new(&workspace));
    if (info.joint_count)
        check(bdt_skeleton_pose_new(model, &skeleton));
    q = room(info.mode_count, sizeof *q);
    joints = room(info.joint_count, sizeof *joints);
    steps = 3 + 2 * (int)info.frame_count;
    for (step = 0; step < steps; step++) {
        BdtTransform at;
        BdtHit found;
        BdtVec3 point = {0.75, 0.5, 0.25};
        BdtRay ray = {{3.0, 1.5, 0.5}, {-1.0, -0.5, -0.25}, 100.0};
        BdtVec3 normal = {0.0, 3.0, 4.0};
        size_t j;
        if (step < 3) {
            for (j = 0; j < info.mode_count; j++)
                q[j] = (float)step * (j % 2 == 0 ? 0.25f : -0.125f);
            at.rotation = turns[step];
            at.translation.x = step;
            at.translation.y = 0.0;
            at.translation.z = -0.5;
            at.scale = 1.0 + 0.5 * step;
            if (step == 1)
                second = at;
        } else {
            check(bdt_model_frame(model, (size_t)(step - 3) / 2, q, info.mode_count, &at, NULL));
            if ((step - 3) % 2)
                check(bdt_transform_after(second, at, &at));
        }
        if (skeleton)
            turn(skeleton, info.skeleton_node_count, step, joints, info.joint_count);
        check(bdt_instance_set_pose_with_joints(body, q, info.mode_count, joints, info.joint_count, &at));
        contacts(workspace, body, bdt_ball(point, 0.5), "ball", step);
        contacts(workspace, body, bdt_half_space(normal, -0.75), "plane", step);
        check(bdt_project_point(workspace, body, point, INFINITY, &found));
        hit(&found, "closest", step);
        check(bdt_cast_ray(workspace, body, &ray, &found));
        hit(&found, "ray", step);
        pairs(workspace, body, other, step);
    }
    free(q);
    free(joints);
    check(bdt_model_free(model));
    check(bdt_instance_free(body));
    check(bdt_instance_free(other));
    check(bdt_workspace_free(workspace));
    check(bdt_skeleton_pose_free(skeleton));
    return 0;
}
