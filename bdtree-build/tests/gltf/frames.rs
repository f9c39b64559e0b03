//! Characters in the poses of their clips: vertices, boxes and contacts against a plain evaluation in f64 that shares no
//! code with the builder or the runtime.

use std::path::Path;

use bdtree_fixtures::models::math::V3;
use bdtree_fixtures::{corpus, models, poses};
use bdtree_runtime::narrow::closest_point;
use bdtree_runtime::{Ball, BoneMatrices, Contact, Pose, SkeletonPose, Transform, VertexId};
use bdtree_runtime::{Model, Workspace};

use super::skin_rows::{baked, checked};
use super::twin::{self, File};

/// u, half the spacing of f32 at 1.
const U: f64 = 1.0 / (1 << 24) as f64;

/// Where a plain evaluation puts the vertices, and how far the stored numbers and their arithmetic may be off (SPEC 5.9:
/// each of I influences and M modes rounds, relative to what the bones reach).
fn evaluated(file: &File, model: &Model) -> (Vec<V3>, f64) {
    let twin = file.scene();
    let record = model.asset().skin_record().expect("a skin");
    let mut reach = 0.0_f64;
    let vertices = (0..twin.positions.len()).map(|i| {
        let mut x = twin.positions[i];
        for (field, weight) in twin.fields.iter().zip(&twin.weights) {
            for k in 0..3 {
                x[k] += weight * field[i][k];
            }
        }
        // What cancels in the sum is rounded before.
        let matrix = &twin.carried[i];
        for row in 0..3 {
            let terms = (0..4).map(|k| (matrix[k][row] * [x[0], x[1], x[2], 1.0][k]).abs());
            reach = reach.max(terms.sum());
        }
        twin::apply(matrix, &x, 1.0)
    });
    let vertices: Vec<V3> = vertices.collect();
    // Stored positions are rounded relative to the whole mesh, whose origin is not that of the scene.
    let size = poses::diagonal(model.asset()) * model.asset().unit();
    let (influences, modes) = (f64::from(record.influences_max), twin.fields.len() as f64);
    let bound = (2.0 * influences + 2.0 * modes + 48.0) * U * (2.0 * reach + size);
    (vertices, bound)
}

fn vertices_are_there(pose: &Pose<'_>, expected: &[V3], bound: f64, name: &str) {
    let aabb = pose.aabb().expect("a box");
    let sphere = pose.bounding_sphere().expect("a sphere");
    for (i, p) in expected.iter().enumerate() {
        let found = pose.deformed(VertexId(i as u32)).expect("vertex");
        let off = (0..3)
            .map(|k| (found[k] - p[k]).powi(2))
            .sum::<f64>()
            .sqrt();
        assert!(
            off <= bound,
            "{name}: vertex {i} is {off:e} off, bound {bound:e}"
        );
        for k in 0..3 {
            assert!(
                aabb.min[k] - bound <= p[k] && p[k] <= aabb.max[k] + bound,
                "{name}"
            );
        }
        let apart = (0..3)
            .map(|k| (sphere.center[k] - p[k]).powi(2))
            .sum::<f64>()
            .sqrt();
        assert!(apart <= sphere.radius + bound, "{name}");
    }
}

/// Balls about some vertices meet what brute force over the plain evaluation says, but for the bound.
fn balls_meet(
    (pose, workspace): (&Pose<'_>, &mut Workspace),
    expected: &[V3],
    bound: f64,
    name: &str,
) {
    let asset = pose.asset();
    let radius = 0.04 * poses::diagonal(asset) * asset.unit();
    for center in expected.iter().step_by(1 + expected.len() / 2) {
        let mut found: Vec<Contact> = Vec::new();
        let mut query = pose.query(workspace);
        query
            .contacts(Ball::new(*center, radius), &mut found)
            .expect("ball");
        let mut ids: Vec<u32> = found.iter().map(|contact| contact.triangle.0).collect();
        ids.sort_unstable();
        for id in 0..asset.triangle_count() as u32 {
            let corners = asset
                .triangle(bdtree_runtime::TriangleId(id))
                .expect("triangle");
            let triangle = corners.map(|v| expected[v.0 as usize]);
            let distance = closest_point(*center, &triangle).distance;
            let is_found = ids.binary_search(&id).is_ok();
            assert!(
                is_found || distance >= radius - bound,
                "{name}: {id} missed"
            );
            assert!(
                !is_found || distance <= radius + bound,
                "{name}: {id} too many"
            );
        }
    }
}

/// Every frame of every clip, and every second time between two frames; the number of poses.
fn clips_agree(path: &Path) -> usize {
    let name = path.display().to_string();
    let model = checked(&baked(path));
    let asset = model.asset();
    let mut memory = vec![0.0; asset.pose_len()];
    let mut workspace = Workspace::new();
    let mut skeleton = SkeletonPose::new(&model).expect("a skeleton");
    let clips = asset.skeleton().expect("a skeleton").clip_count();
    let mut count = 0;
    for clip in 0..clips {
        let mut file = File::open(path);
        let times = file.times(clip);
        let between = times.windows(2).step_by(2).map(|t| 0.5 * (t[0] + t[1]));
        for time in times.iter().copied().chain(between) {
            file.play(clip, time);
            skeleton.rest().expect("at rest");
            skeleton.play(clip, time).expect("plays");
            let bones = BoneMatrices::Joints(skeleton.joints());
            let pose = asset
                .pose_with_bones(skeleton.q(), bones, Transform::IDENTITY, &mut memory)
                .expect("a pose");
            let (expected, bound) = evaluated(&file, &model);
            let name = format!("{name}, clip {clip} at {time} s");
            vertices_are_there(&pose, &expected, bound, &name);
            balls_meet((&pose, &mut workspace), &expected, bound, &name);
            count += 1;
        }
    }
    count
}

#[test]
fn fixtures_in_their_clips_agree_with_a_plain_evaluation() {
    let count = clips_agree(&models::path("skinned_tube.glb"));
    assert!(count >= 8, "{count}");
}

#[test]
fn characters_in_their_clips_agree_with_a_plain_evaluation() {
    let test = "gltf_characters_in_their_clips_agree_with_a_plain_evaluation";
    let Some(folder) = corpus::path(test, "characters") else {
        return;
    };
    for name in [
        "RiggedSimple.glb",
        "Fox.glb",
        "CesiumMan.glb",
        "RobotExpressive.glb",
    ] {
        let count = clips_agree(&folder.join(name));
        println!("{name}: {count} poses");
        assert!(count >= 3, "{name}: {count}");
    }
}
