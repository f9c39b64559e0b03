//! A skinned tube in bent poses, beside loops over all of its deformed triangles.

use bdtree_runtime::joint::{IDENTITY, compose, transform_point};
use bdtree_runtime::{Capsule, Cuboid, JointMatrix, SkeletonPose, VertexId};

use super::*;
use crate::place::bone_in_model;

const SKINNED: &[u8] = include_bytes!("../../../fixtures/golden/skinned.bdt");
const RIGID: &[u8] = include_bytes!("../../../fixtures/golden/tetrahedron.bdt");

fn open(bytes: &[u8]) -> Body {
    Body::new(Arc::new(Model::from_bytes(bytes).expect("a file"))).expect("a body")
}

/// The tube, bent by a clip, its morph target half out, twice as large and turned, away from the origin.
fn bent(time: f64) -> Body {
    let mut body = open(SKINNED);
    let mut pose = SkeletonPose::new(&body.model).expect("a skeleton");
    pose.play(0, time).expect("a clip");
    body.set_q(&[0.5]).expect("one mode");
    body.pose(BoneMatrices::Joints(pose.joints()), somewhere())
        .expect("a pose");
    body
}

fn somewhere() -> Transform {
    Transform {
        rotation: [0.5, -0.5, 0.5, 0.5],
        translation: [3.0, -1.0, 2.0],
        scale: 2.0,
    }
}

/// All deformed triangles.
fn triangles(body: &Body) -> Vec<[[f64; 3]; 3]> {
    let pose = body.instance.pose();
    let corner = |vertex| pose.deformed(VertexId(vertex)).expect("a vertex");
    let all = 0..body.asset().triangle_count() as u32;
    all.map(|id| body.asset().triangle(TriangleId(id)).expect("a triangle"))
        .map(|corners| corners.map(|vertex| corner(vertex.0)))
        .collect()
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    dot(sub(a, b), sub(a, b)).sqrt()
}

/// Where the segment meets a triangle, as its share of the segment (Möller and Trumbore).
fn share([a, b, c]: [[f64; 3]; 3], from: [f64; 3], to: [f64; 3]) -> Option<f64> {
    let (ab, ac, along) = (sub(b, a), sub(c, a), sub(to, from));
    let p = cross(along, ac);
    let det = dot(ab, p);
    let s = sub(from, a);
    let u = dot(s, p) / det;
    let q = cross(s, ab);
    let (v, t) = (dot(along, q) / det, dot(ac, q) / det);
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && (0.0..=1.0).contains(&t)).then_some(t)
}

/// The distance of a point to a triangle, by a search of its own: ever finer grids of barycentric coordinates.
fn reach([a, b, c]: [[f64; 3]; 3], point: [f64; 3]) -> f64 {
    let at = |u: f64, v: f64| [0, 1, 2].map(|k| a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]));
    let (mut best, mut width) = ((1.0 / 3.0, 1.0 / 3.0), 1.0);
    for _ in 0..45 {
        let (u0, v0) = best;
        for i in -2..=2 {
            for j in -2..=2 {
                let u = (u0 + width * f64::from(i) / 2.0).clamp(0.0, 1.0);
                let v = (v0 + width * f64::from(j) / 2.0).clamp(0.0, 1.0 - u);
                if distance(at(u, v), point) < distance(at(best.0, best.1), point) {
                    best = (u, v);
                }
            }
        }
        width *= 0.6;
    }
    distance(at(best.0, best.1), point)
}

/// Points in and around a box, always the same ones.
fn points(body: &Body, count: usize) -> Vec<[f64; 3]> {
    let (low, size) = body.aabb().expect("a box");
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..count)
        .map(|_| [0, 1, 2].map(|k| f64::from(low[k]) + (1.4 * next() - 0.2) * f64::from(size[k])))
        .collect()
}

#[test]
fn rays_meet_what_brute_force_meets() {
    let mut hits = 0;
    for time in [0.0, 0.3, 0.7] {
        let mut body = bent(time);
        let all = triangles(&body);
        for ends in points(&body, 400).as_chunks::<2>().0 {
            let [from, to] = *ends;
            let found = body.cast_ray(from, to).expect("a ray");
            let shares = all.iter().filter_map(|corners| share(*corners, from, to));
            let nearest = shares.fold(f64::INFINITY, f64::min) * distance(from, to);
            let Some(found) = found else {
                assert_eq!(nearest, f64::INFINITY, "{from:?} {to:?}");
                continue;
            };
            hits += 1;
            assert!((found.distance - nearest).abs() < 1e-9, "{from:?} {to:?}");
            assert!(distance(from, found.point) - nearest < 1e-9);
            check(&found, &all);
            // The surface's normal looks back along the ray.
            assert!(dot(found.normal, sub(to, from)) <= 0.0);
        }
    }
    assert!(hits > 100, "{hits}");
}

/// What every answer promises.
fn check(found: &Found, all: &[[[f64; 3]; 3]]) {
    let corners = all[found.triangle as usize];
    let point = [0, 1, 2].map(|k| (0..3).map(|c| found.barycentric[c] * corners[c][k]).sum());
    assert!(distance(point, found.point) < 1e-9, "{found:?}");
    assert!((dot(found.normal, found.normal) - 1.0).abs() < 1e-9);
    // The tube has four bones, and each of its vertices is on one at least.
    assert!(found.joint.is_some_and(|joint| joint < 4), "{found:?}");
}

#[test]
fn shapes_and_points_are_answered_as_brute_force_answers() {
    let mut touched = 0;
    for time in [0.2, 0.6] {
        let mut body = bent(time);
        let all = triangles(&body);
        for center in points(&body, 8) {
            let reaches: Vec<_> = all.iter().map(|corners| reach(*corners, center)).collect();
            let nearest = reaches.iter().copied().fold(f64::INFINITY, f64::min);

            let found = body.closest_point(center, f64::INFINITY).expect("a point");
            let found = found.expect("without a limit there is one");
            assert!((found.distance - nearest).abs() < 1e-6);
            check(&found, &all);
            let limited = body
                .closest_point(center, 0.999 * nearest)
                .expect("a point");
            assert_eq!(limited, None);

            for radius in [0.999 * nearest, 1.001 * nearest, 0.5, 1.0] {
                let contacts = body.contacts(center, radius).expect("a ball");
                let expected: Vec<_> = (0..all.len() as u32)
                    .filter(|id| reaches[*id as usize] <= radius)
                    .collect();
                let ids: Vec<_> = contacts.iter().map(|contact| contact.triangle).collect();
                assert_eq!(ids, expected, "{center:?} {radius}");
                for contact in &contacts {
                    check(contact, &all);
                    let depth = reaches[contact.triangle as usize] - radius;
                    assert!((contact.distance - depth).abs() < 1e-6);
                }
                touched += contacts.len();
                let is_touched = !expected.is_empty();
                let ball = body.intersects(Ball::new(center, radius)).expect("a ball");
                let same = body.intersects(Capsule::new(center, center, radius));
                assert_eq!((ball, same.expect("a capsule")), (is_touched, is_touched));
            }
            // A box within the ball that touches nothing, and one around the nearest point.
            let half = [0.5 * nearest; 3];
            assert!(!body.intersects(Cuboid::new(center, half)).expect("a box"));
            let around = Cuboid::new(found.point, [1e-6; 3]);
            assert!(body.intersects(around).expect("a box"));
            // A capsule that ends there.
            let up_to = Capsule::new(center, found.point, 1e-6);
            assert!(body.intersects(up_to).expect("a capsule"));
        }
    }
    assert!(touched > 30, "{touched}");
}

#[test]
fn boxes_hold_all_vertices_after_rounding() {
    for time in [0.0, 0.25, 0.5, 0.75, 1.0] {
        let body = bent(time);
        let (low, size) = body.aabb().expect("a box");
        for corner in triangles(&body).as_flattened() {
            for k in 0..3 {
                assert!(f64::from(low[k]) <= corner[k] && corner[k] <= f64::from(low[k] + size[k]));
            }
        }
    }
    // Numbers that f32 does not have are rounded away from the box.
    for (min, max) in [
        (0.1, 0.3),
        (-1e9 - 0.3, 1e9 + 0.7),
        (1e-30, 2e-30),
        (-0.1, 1e9 + 0.1),
    ] {
        let (low, size) = outwards(&Aabb {
            min: [min; 3],
            max: [max; 3],
        });
        assert!(f64::from(low[0]) <= min && f64::from(low[0] + size[0]) >= max);
        // By no more than rounding makes necessary.
        let extent = max - min;
        assert!(f64::from(size[0]) <= extent + 4e-7 * (extent + min.abs()));
    }
}

#[test]
fn dictionaries_have_what_the_page_lists() {
    let names: Vec<_> = ["a", "b", "c", "d"].map(String::from).into();
    let found = Found {
        triangle: 7,
        point: [1.0, 2.0, 3.0],
        normal: [0.0, -1.0, 0.0],
        barycentric: [0.25, 0.25, 0.5],
        distance: -0.125,
        joint: Some(2),
    };
    let expected = [
        ("point", Value::Vector([1.0, 2.0, 3.0])),
        ("normal", Value::Vector([0.0, -1.0, 0.0])),
        ("triangle", Value::Int(7)),
        ("barycentric", Value::Vector([0.25, 0.25, 0.5])),
        ("distance", Value::Float(-0.125)),
        ("bone", Value::Name("c".into())),
    ];
    assert_eq!(found.entries(&names), expected);
    // Without a skin there is no bone.
    let bare = Found {
        joint: None,
        ..found
    };
    assert_eq!(bare.entries(&[])[5], ("bone", Value::Name(String::new())));
    let page = include_str!("../../../docs/guide/godot.md");
    for (key, _) in expected {
        assert!(page.contains(&format!("| `{key}` |")), "{key}");
    }
}

#[test]
fn poses_follow_bones_weights_and_placement() {
    let mut body = open(SKINNED);
    assert_eq!(body.joint_names().len(), 4);
    assert_eq!(body.mode_names().len(), 1);
    let rest: Vec<JointMatrix> = {
        let pose = SkeletonPose::new(&body.model).expect("a skeleton");
        pose.joints().to_vec()
    };
    let before = triangles(&body);
    body.pose(BoneMatrices::Joints(&rest), Transform::IDENTITY)
        .expect("at rest");
    let moved = |body: &Body| {
        let after = triangles(body);
        let corners = before.as_flattened().iter().zip(after.as_flattened());
        corners.map(|(a, b)| distance(*a, *b)).fold(0.0, f64::max)
    };
    assert!(moved(&body) < 1e-6);
    // The same by the products with the inverse bind matrices.
    let products: Vec<JointMatrix> = (body.asset().bones().iter())
        .map(|bone| {
            let inverse = bone.inverse_bind.map(|row| row.map(|x| x.get()));
            bdtree_runtime::joint::compose(&rest[bone.joint.get() as usize], &inverse)
        })
        .collect();
    body.pose(BoneMatrices::Skinning(&products), Transform::IDENTITY)
        .expect("at rest");
    assert!(moved(&body) < 1e-6);
    body.set_weight(0, 1.0);
    assert!(moved(&body) < 1e-6, "a weight counts from the next pose on");
    body.pose(BoneMatrices::Joints(&rest), Transform::IDENTITY)
        .expect("at rest");
    assert!(moved(&body) > 0.01);
    let one = body.pose(BoneMatrices::Joints(&[IDENTITY]), Transform::IDENTITY);
    assert!(matches!(one, Err(Fault::Pose(_))), "one matrix of four");
    assert!(matches!(
        body.set_q(&[]),
        Err(Fault::Length {
            expected: 1,
            found: 0
        })
    ));
}

#[test]
fn a_skinned_mesh_is_where_it_is_drawn_wherever_the_collider_stands() {
    // What Godot draws: sum of weights * (mesh * pose * bind) * p.
    let poses: Vec<JointMatrix> = {
        let model = Model::from_bytes(SKINNED).expect("a file");
        let mut pose = SkeletonPose::new(&model).expect("a skeleton");
        pose.play(0, 0.4).expect("a clip");
        pose.joints().to_vec()
    };
    // Mirrored, sheared and of three lengths, as a collider must not be.
    let mesh = [
        [0.0, -2.0, 0.0, 1.0],
        [1.0, 0.25, 0.0, -3.0],
        [0.0, 0.5, 0.5, 2.0],
    ];
    let mut body = open(SKINNED);
    body.set_q(&[0.0]).expect("one mode");
    let asset = body.asset();
    let bind = |bone: usize| {
        asset.bones()[bone]
            .inverse_bind
            .map(|row| row.map(|x| x.get()))
    };
    let drawn: Vec<[f64; 3]> = (0..asset.vertex_count() as u32)
        .map(|vertex| {
            let p = asset.positions()[vertex as usize];
            let p = [0, 1, 2].map(|k| asset.origin()[k] + f64::from(p[k]) * asset.unit());
            let influences = asset.influences(VertexId(vertex)).expect("a vertex");
            let parts = influences.iter().map(|influence| {
                let bone = usize::from(influence.bone);
                let joint = asset.bones()[bone].joint.get() as usize;
                let carried = compose(&mesh, &compose(&poses[joint], &bind(bone)));
                let weight = f64::from(influence.weight);
                transform_point(&carried, p).map(|x| weight * x)
            });
            parts.fold([0.0; 3], |sum, part| [0, 1, 2].map(|k| sum[k] + part[k]))
        })
        .collect();
    let (joint_of, binds): (Vec<_>, Vec<_>) = (
        body.joints_of_bones(),
        (0..asset.bone_count()).map(bind).collect(),
    );
    for at in [Transform::IDENTITY, somewhere()] {
        let joints: Vec<_> = (poses.iter())
            .map(|pose| bone_in_model(&at, &mesh, pose))
            .collect();
        let products: Vec<_> = (joint_of.iter().zip(&binds))
            .map(|(joint, bind)| compose(&joints[*joint], bind))
            .collect();
        for bones in [
            BoneMatrices::Joints(&joints),
            BoneMatrices::Skinning(&products),
        ] {
            body.pose(bones, at).expect("a pose");
            let pose = body.instance.pose();
            for (vertex, expected) in drawn.iter().enumerate() {
                let found = pose.deformed(VertexId(vertex as u32)).expect("a vertex");
                assert!(
                    distance(found, *expected) < 1e-5,
                    "{at:?}: {found:?} {expected:?}"
                );
            }
        }
    }
}

#[test]
fn files_without_a_skin_are_placed() {
    let mut body = open(RIGID);
    body.pose(BoneMatrices::Rest, somewhere()).expect("a place");
    let all = triangles(&body);
    let center = all[0][0];
    let found = body.contacts(center, 1e-6).expect("a ball");
    assert!(!found.is_empty());
    assert!(found.iter().all(|found| found.joint.is_none()));
    // The two ends of a ray must differ.
    assert!(matches!(
        body.cast_ray(center, center),
        Err(Fault::Query(_))
    ));
}

#[test]
fn the_demo_says_what_it_will_print_at_rest() {
    let mut body = open(SKINNED);
    let found = body.cast_ray([2.0, 10.0, 0.0], [2.0, -10.0, 0.0]);
    let found = found.expect("a ray").expect("a hit");
    let [x, y, z] = found.point;
    let line = format!(
        "# At rest: triangle {} at ({x}, {y:.6}, {z}).",
        found.triangle
    );
    let demo = include_str!("../../addon/demo/demo.gd");
    assert!(demo.contains(&line), "{line}");
}
