//! Contact regions of bodies in random poses: distances, depths and areas that belong to their points.

use bdtree_build::input::read_mesh;
use bdtree_fixtures::{bake, models, poses};
use bdtree_runtime::{ContactManifold, Model, Pose, Ray, RayIntersection, Transform, Workspace};
use rand::RngExt;

use super::{apart, contact, near, rigid};

/// Regions of two deformed bodies of this kind, turned and moved at random by up to `reach`, and their poses.
fn at_random(
    model: &Model,
    count: usize,
    reach: f64,
    mut check: impl FnMut([&Pose<'_>; 2], &[ContactManifold]),
) {
    let asset = model.asset();
    let mut rng = poses::rng(11);
    for _ in 0..count {
        let qs = [0, 1].map(|_| poses::random_q(asset, 0.05, &mut rng));
        let mut placement = poses::random_transform(1.0, &mut rng);
        placement.scale = 1.0;
        placement.translation = [0, 1, 2].map(|_| rng.random_range(-reach..reach));
        let (mut memory1, mut memory2) = (vec![0.0; asset.pose_len()], vec![0.0; asset.pose_len()]);
        let a = (asset.pose(&qs[0], Transform::IDENTITY, &mut memory1)).expect("pose");
        let b = (asset.pose(&qs[1], placement, &mut memory2)).expect("pose");
        check([&a, &b], &contact(&a, &b, 0.0).1);
    }
}

/// [`regions`] checks that distances are those of the points, areas add up and no point is deeper than its region:
/// on thin shells that pass through each other, with a seam where contours end, and on rings, whose contours may have
/// holes and cover themselves. Four points are four.
#[test]
fn distances_are_those_of_the_points_in_any_pose() {
    for (name, modes, count, reach, most_ones) in
        [("chair", 10, 40, 0.4, 1000), ("torus", 3, 60, 1.0, 20)]
    {
        let mesh = read_mesh(&models::path(name)).expect("fixture");
        let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, modes, 5));
        let (mut fours, mut ones, mut gaps) = (0, 0, 0);
        at_random(&model, count, reach, |_, found| {
            for region in found {
                if region.points().len() == 4 {
                    fours += 1;
                } else {
                    ones += 1;
                }
                gaps += region.points().iter().filter(|p| p.distance > 0.0).count();
            }
        });
        assert!(fours > 30 && gaps > 0, "{name}: {fours}, {gaps} gaps");
        assert!(ones > 0 && ones < most_ones, "{name}: {ones}");
    }
}

/// The lines along the normal that leave both of two convex bodies have the depths that all hits along them tell, also
/// where the contour is far from flat, so that they begin outside one of the bodies.
#[test]
fn depths_of_convex_bodies_are_those_along_their_lines() {
    for (name, reach) in [("tetrahedron", 0.6), ("beam", 0.06), ("icosphere", 1.1)] {
        let mesh = read_mesh(&models::path(name)).expect("fixture");
        let model = rigid(&mesh);
        let (mut lines, mut off) = (0, 0);
        let mut workspace = Workspace::new();
        at_random(&model, 60, reach, |[a, b], found| {
            for region in found.iter().filter(|r| r.points().len() == 4) {
                for point in region.points() {
                    if apart(region, point)[1] > 1e-9 {
                        off += 1;
                        continue;
                    }
                    let middle = [0, 1, 2].map(|k| 0.5 * (point.point1[k] + point.point2[k]));
                    let leaves1 = last_hit(a, middle, region.normal1, &mut workspace);
                    let leaves2 = last_hit(b, middle, region.normal2, &mut workspace);
                    near(-point.distance, leaves1 + leaves2, 1e-9);
                    lines += 1;
                }
            }
        });
        assert!(
            lines > 50 && off * 50 <= lines,
            "{name}: {lines}, {off} off"
        );
    }
}

/// How far from a point a line leaves a convex body.
fn last_hit(
    pose: &Pose<'_>,
    from: [f64; 3],
    along: [f64; 3],
    workspace: &mut Workspace<'_>,
) -> f64 {
    const BEFORE: f64 = 16.0;
    let origin = [0, 1, 2].map(|k| from[k] - BEFORE * along[k]);
    let mut hits: Vec<RayIntersection> = Vec::new();
    let ray = Ray::new(origin, along);
    (pose.query(workspace).cast_ray_all(&ray, &mut hits)).expect("hits");
    hits.iter()
        .map(|hit| hit.distance - BEFORE)
        .fold(f64::NEG_INFINITY, f64::max)
}
