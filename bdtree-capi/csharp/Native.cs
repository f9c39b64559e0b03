// The functions of bdtree.h, in its order. Handles are passed as their owners, so that they live until a call has returned.
using System;
using System.Runtime.InteropServices;
using System.Text;

namespace Bdtree
{
    internal static class Native
    {
        private const string Name = "bdtree";

        /// <summary>Throws for statuses below 0; returns the others.</summary>
        internal static Status Check(Status status)
        {
            if (status >= Status.Ok)
                return status;
            string text = Library.LastError;
            throw new BdtreeException(status, text.Length > 0 ? text : Library.StatusText(status));
        }

        /// <summary>A text closed by 0.</summary>
        internal static byte[] Utf8(string text) { return Encoding.UTF8.GetBytes(text + "\0"); }

        [DllImport(Name)] internal static extern uint bdt_version();
        [DllImport(Name)] internal static extern IntPtr bdt_version_text();
        [DllImport(Name)] internal static extern int bdt_checks_handles();
        [DllImport(Name)] internal static extern IntPtr bdt_status_text(int status);
        [DllImport(Name)] internal static extern Status bdt_last_error([Out] byte[] buffer, UIntPtr capacity,
            out UIntPtr length);
        [DllImport(Name)] internal static extern Shape bdt_ball(Vec3 center, double radius);
        [DllImport(Name)] internal static extern Shape bdt_capsule(Vec3 a, Vec3 b, double radius);
        [DllImport(Name)] internal static extern Shape bdt_cuboid(Vec3 center, Quat rotation, Vec3 halfExtents);
        [DllImport(Name)] internal static extern Shape bdt_half_space(Vec3 normal, double offset);
        [DllImport(Name)] internal static extern Status bdt_model_load(byte[] path, out IntPtr made);
        [DllImport(Name)] internal static extern Status bdt_model_read(byte[] path, out IntPtr made);
        [DllImport(Name)] internal static extern Status bdt_model_from_memory(byte[] bytes, UIntPtr length,
            out IntPtr made);
        [DllImport(Name)] internal static extern Status bdt_model_free(IntPtr model);
        [DllImport(Name)] internal static extern Status bdt_model_info(Model model, out ModelInfo found);
        [DllImport(Name)] internal static extern Status bdt_model_mode(Model model, UIntPtr index, out Mode found);
        [DllImport(Name)] internal static extern Status bdt_model_mass(Model model, out Mass found);
        [DllImport(Name)] internal static extern Status bdt_model_group(Model model, UIntPtr index, out Group found);
        [DllImport(Name)] internal static extern Status bdt_model_triangles(Model model, uint first, UIntPtr count,
            [Out] uint[] corners);
        [DllImport(Name)] internal static extern Status bdt_model_verify(Model model);
        [DllImport(Name)] internal static extern Status bdt_model_verify_checksums(Model model);
        [DllImport(Name)] internal static extern Status bdt_model_frame(Model model, UIntPtr index, [Out] float[] q,
            UIntPtr count, out Transform at, out double timeS);
        [DllImport(Name)] internal static extern Status bdt_model_sample(Model model, double timeS, [Out] float[] q,
            UIntPtr count, out Transform at);
        [DllImport(Name)] internal static extern Status bdt_model_joint_of(Model model, uint triangle, Vec3 barycentric,
            out uint joint);
        [DllImport(Name)] internal static extern Status bdt_model_mode_name(Model model, UIntPtr index,
            [Out] byte[] buffer, UIntPtr capacity, out UIntPtr length);
        [DllImport(Name)] internal static extern Status bdt_model_mode_index(Model model, byte[] name,
            out UIntPtr index);
        [DllImport(Name)] internal static extern Status bdt_model_joint_name(Model model, UIntPtr index,
            [Out] byte[] buffer, UIntPtr capacity, out UIntPtr length);
        [DllImport(Name)] internal static extern Status bdt_model_joint_index(Model model, byte[] name,
            out UIntPtr index);
        [DllImport(Name)] internal static extern Status bdt_model_joint_parent(Model model, UIntPtr index,
            out uint parent);
        [DllImport(Name)] internal static extern Status bdt_model_clip_name(Model model, UIntPtr index,
            [Out] byte[] buffer, UIntPtr capacity, out UIntPtr length);
        [DllImport(Name)] internal static extern Status bdt_model_clip_index(Model model, byte[] name,
            out UIntPtr index);
        [DllImport(Name)] internal static extern Status bdt_model_clip_duration(Model model, UIntPtr index,
            out double seconds);
        [DllImport(Name)] internal static extern Status bdt_model_group_name(Model model, UIntPtr index,
            [Out] byte[] buffer, UIntPtr capacity, out UIntPtr length);
        [DllImport(Name)] internal static extern Status bdt_instance_new(Model model, out IntPtr made);
        [DllImport(Name)] internal static extern Status bdt_instance_new_with_cache(Model model, UIntPtr nodes,
            UIntPtr leaves, out IntPtr made);
        [DllImport(Name)] internal static extern Status bdt_instance_free(IntPtr instance);
        [DllImport(Name)] internal static extern Status bdt_instance_set_q(Instance instance, float[] q, UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_instance_q(Instance instance, [Out] float[] q,
            UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_instance_set_refining(Instance instance, int on);
        [DllImport(Name)] internal static extern Status bdt_instance_set_placement(Instance instance, ref Transform at);
        [DllImport(Name)] internal static extern Status bdt_instance_placement(Instance instance, out Transform found);
        [DllImport(Name)] internal static extern Status bdt_instance_set_pose(Instance instance, float[] q,
            UIntPtr count, ref Transform at);
        [DllImport(Name)] internal static extern Status bdt_instance_set_joints(Instance instance, Matrix[] joints,
            UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_instance_set_skinning_matrices(Instance instance,
            Matrix[] bones, UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_instance_set_pose_with_joints(Instance instance, float[] q,
            UIntPtr count, Matrix[] joints, UIntPtr jointCount, ref Transform at);
        [DllImport(Name)] internal static extern Status bdt_instance_aabb(Instance instance, out Aabb found);
        [DllImport(Name)] internal static extern Status bdt_instance_exact_aabb(Instance instance, out Aabb found);
        [DllImport(Name)] internal static extern Status bdt_instance_bounding_sphere(Instance instance,
            out Sphere found);
        [DllImport(Name)] internal static extern Status bdt_instance_vertices(Instance instance, uint first,
            UIntPtr count, [Out] Vec3[] items);
        [DllImport(Name)] internal static extern Status bdt_instance_add_generalized_force(Instance instance,
            uint triangle, Vec3 barycentric, Vec3 force, [In, Out] double[] forces, UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_instance_set_tags(Instance instance, ref Tags tags);
        [DllImport(Name)] internal static extern Status bdt_instance_tags(Instance instance, out Tags found);
        [DllImport(Name)] internal static extern Status bdt_transform_after(Transform then, Transform first,
            out Transform found);
        [DllImport(Name)] internal static extern Status bdt_joint_in_model(Transform at, Matrix inWorld,
            out Matrix found);
        [DllImport(Name)] internal static extern Status bdt_skeleton_pose_new(Model model, out IntPtr made);
        [DllImport(Name)] internal static extern Status bdt_skeleton_pose_free(IntPtr pose);
        [DllImport(Name)] internal static extern Status bdt_skeleton_pose_rest(SkeletonPose pose);
        [DllImport(Name)] internal static extern Status bdt_skeleton_pose_play(SkeletonPose pose, UIntPtr clip,
            double timeS);
        [DllImport(Name)] internal static extern Status bdt_skeleton_pose_blend(SkeletonPose pose, UIntPtr clip,
            double timeS, double weight);
        [DllImport(Name)] internal static extern Status bdt_skeleton_pose_local(SkeletonPose pose, UIntPtr node,
            out Local found);
        [DllImport(Name)] internal static extern Status bdt_skeleton_pose_set_local(SkeletonPose pose, UIntPtr node,
            ref Local local);
        [DllImport(Name)] internal static extern Status bdt_skeleton_pose_update(SkeletonPose pose);
        [DllImport(Name)] internal static extern Status bdt_skeleton_pose_joints(SkeletonPose pose,
            [Out] Matrix[] joints, UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_skeleton_pose_nodes(SkeletonPose pose, [Out] Matrix[] nodes,
            UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_skeleton_pose_q(SkeletonPose pose, [Out] float[] q,
            UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_instance_set_skeleton_pose(Instance instance,
            SkeletonPose pose);
        [DllImport(Name)] internal static extern Status bdt_workspace_new(out IntPtr made);
        [DllImport(Name)] internal static extern Status bdt_workspace_free(IntPtr workspace);
        [DllImport(Name)] internal static extern Status bdt_workspace_set_shared(Workspace workspace, int isShared);
        [DllImport(Name)] internal static extern Status bdt_workspace_set_max_levels(Workspace workspace, int first,
            int second);
        [DllImport(Name)] internal static extern Status bdt_workspace_set_max_visits(Workspace workspace,
            ulong maxVisits);
        [DllImport(Name)] internal static extern Status bdt_workspace_proxies(Workspace workspace, UIntPtr side,
            [Out] Proxy[] items, UIntPtr capacity, out UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_workspace_bound(Workspace workspace, out Bound found);
        [DllImport(Name)] internal static extern Status bdt_workspace_stats(Workspace workspace, out Stats found);
        [DllImport(Name)] internal static extern Status bdt_contacts(Workspace workspace, Instance instance,
            ref Shape shape, [Out] Contact[] items, UIntPtr capacity, out UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_contacts_each(Workspace workspace, Instance instance,
            ref Shape shape, OnContact callback, IntPtr context);
        [DllImport(Name)] internal static extern Status bdt_intersects(Workspace workspace, Instance instance,
            ref Shape shape, out int isTouched);
        [DllImport(Name)] internal static extern Status bdt_project_point(Workspace workspace, Instance instance,
            Vec3 point, double maxDistance, out Hit found);
        [DllImport(Name)] internal static extern Status bdt_cast_ray(Workspace workspace, Instance instance, ref Ray ray,
            out Hit found);
        [DllImport(Name)] internal static extern Status bdt_intersects_ray(Workspace workspace, Instance instance,
            ref Ray ray, out int isMet);
        [DllImport(Name)] internal static extern Status bdt_cast_ray_all(Workspace workspace, Instance instance,
            ref Ray ray, [Out] Hit[] items, UIntPtr capacity, out UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_cast_ray_all_each(Workspace workspace, Instance instance,
            ref Ray ray, OnHit callback, IntPtr context);
        [DllImport(Name)] internal static extern Status bdt_frustum_state(Workspace workspace, Instance instance,
            Plane[] planes, UIntPtr planeCount, out Region state);
        [DllImport(Name)] internal static extern Status bdt_level_spheres(Workspace workspace, Instance instance,
            uint level, ref Shape shape, [Out] Lane[] items, UIntPtr capacity, out UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_cast_rays(Workspace workspace, Instance instance, Ray[] rays,
            UIntPtr count, [Out] Hit[] hits);
        [DllImport(Name)] internal static extern Status bdt_intersects_rays(Workspace workspace, Instance instance,
            Ray[] rays, UIntPtr count, [Out] byte[] isMet);
        [DllImport(Name)] internal static extern Status bdt_cast_rays_all(Workspace workspace, Instance instance,
            Ray[] rays, UIntPtr rayCount, [Out] Hit[] items, UIntPtr capacity, out UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_cast_rays_at_instances(Workspace workspace,
            IntPtr[] instances, UIntPtr instanceCount, Ray[] rays, UIntPtr rayCount, [Out] Hit[] hits);
        [DllImport(Name)] internal static extern Status bdt_cast_rays_nearest(Workspace workspace, IntPtr[] instances,
            UIntPtr instanceCount, Ray[] rays, UIntPtr rayCount, [Out] Hit[] hits);
        [DllImport(Name)] internal static extern Status bdt_front_new(out IntPtr made);
        [DllImport(Name)] internal static extern Status bdt_front_free(IntPtr front);
        [DllImport(Name)] internal static extern Status bdt_pair_contacts(Workspace workspace, Instance first,
            Instance second, Front front, double prediction, [Out] PairContact[] items, UIntPtr capacity,
            out UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_pair_contacts_each(Workspace workspace, Instance first,
            Instance second, Front front, double prediction, OnPairContact callback, IntPtr context);
        [DllImport(Name)] internal static extern Status bdt_pair_triangles(Workspace workspace, Instance first,
            Instance second, Front front, double prediction, [Out] IndexPair[] items, UIntPtr capacity,
            out UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_pair_intersects(Workspace workspace, Instance first,
            Instance second, Front front, out int isTouching);
        [DllImport(Name)] internal static extern Status bdt_pair_closest_points(Workspace workspace, Instance first,
            Instance second, double maxDistance, out PairContact found);
        [DllImport(Name)] internal static extern Status bdt_pair_distance(Workspace workspace, Instance first,
            Instance second, double maxDistance, out double distance);
        [DllImport(Name)] internal static extern Status bdt_pair_manifolds(Workspace workspace, Instance first,
            Instance second, Front front, double prediction, [Out] Manifold[] items, UIntPtr capacity,
            out UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_pair_condense(Workspace workspace, Instance first,
            Instance second, PairContact[] pairs, UIntPtr pairCount, [Out] Manifold[] items, UIntPtr capacity,
            out UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_pair_level_spheres(Workspace workspace, Instance first,
            Instance second, uint level1, uint level2, double prediction, double reach, [Out] LanePair[] items,
            UIntPtr capacity, out UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_pair_level_triangles(Workspace workspace, Instance first,
            Instance second, uint level, double prediction, double reach, [Out] LaneTriangle[] items, UIntPtr capacity,
            out UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_sphere_pairs(Workspace workspace, Sphere[] spheres,
            UIntPtr sphereCount, double prediction, [Out] IndexPair[] items, UIntPtr capacity, out UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_instance_pairs(Workspace workspace, IntPtr[] instances,
            UIntPtr instanceCount, double prediction, [Out] IndexPair[] items, UIntPtr capacity, out UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_world_defaults(out WorldOptions found);
        [DllImport(Name)] internal static extern Status bdt_body_defaults(out BodyOptions found);
        [DllImport(Name)] internal static extern Status bdt_world_new(ref WorldOptions options, out IntPtr made);
        [DllImport(Name)] internal static extern Status bdt_world_free(IntPtr world);
        [DllImport(Name)] internal static extern Status bdt_world_add_model(World world, Model model,
            ref BodyOptions options, out uint id);
        [DllImport(Name)] internal static extern Status bdt_world_add_plane(World world, ref Plane plane);
        [DllImport(Name)] internal static extern Status bdt_world_add_body(World world, uint model, BodyFrame frame,
            ref Transform at, out uint id);
        [DllImport(Name)] internal static extern Status bdt_world_step(World world, out StepReport report);
        [DllImport(Name)] internal static extern Status bdt_world_counts(World world, out uint bodies, out uint asleep,
            out ulong steps);
        [DllImport(Name)] internal static extern Status bdt_world_events(World world, [Out] Event[] items,
            UIntPtr capacity, out UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_world_contacts(World world, [Out] WorldContact[] items,
            UIntPtr capacity, out UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_world_energy(World world, out Energy found);
        [DllImport(Name)] internal static extern Status bdt_world_momenta(World world, out Vec3 linear,
            out Vec3 angular);
        [DllImport(Name)] internal static extern Status bdt_world_cast_ray(World world, ref Ray ray, out Hit found);
        [DllImport(Name)] internal static extern Status bdt_world_touched_by(World world, ref Shape shape,
            [Out] Contact[] items, UIntPtr capacity, out UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_world_save(World world, [Out] byte[] items, UIntPtr capacity,
            out UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_world_restore(World world, byte[] bytes, UIntPtr length);
        [DllImport(Name)] internal static extern Status bdt_body_state(World world, uint body, out BodyState found);
        [DllImport(Name)] internal static extern Status bdt_body_placement(World world, uint body, out Transform found);
        [DllImport(Name)] internal static extern Status bdt_body_mode_count(World world, uint body, out UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_body_q(World world, uint body, [Out] double[] q,
            [Out] double[] rate, UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_body_set_modes(World world, uint body, double[] q,
            double[] rate, UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_body_set_velocity(World world, uint body, Vec3 velocity,
            Vec3 angularVelocity);
        [DllImport(Name)] internal static extern Status bdt_body_add_force(World world, uint body, Vec3 force,
            Vec3 torque);
        [DllImport(Name)] internal static extern Status bdt_body_add_modal_force(World world, uint body, double[] force,
            UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_body_add_modal_impulse(World world, uint body,
            double[] impulse, UIntPtr count);
        [DllImport(Name)] internal static extern Status bdt_body_drive(World world, uint body, double[] q, UIntPtr count,
            ref Transform at);
    }
}
