//! Boxes, mass, points and rays of one mesh.

use bdtree_fixtures::{bake, poses};
use bdtree_parry::{DeformingModel, ShapeError};
use rand::RngExt;

use super::brute::Surface;
use super::ours::DeformingMesh;
use super::parry::math::{Pose, Real, Vector};
use super::parry::query::{PointQuery, Ray, RayCast};
use super::parry::shape::{Shape, TriMesh};
use super::support;

fn trimesh(mesh: &DeformingMesh) -> TriMesh {
    let triangles = Surface::of(mesh).triangles;
    let ids = (0..triangles.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]);
    let corners = triangles.iter().flat_map(|t| [t.a, t.b, t.c]).collect();
    TriMesh::new(corners, ids.collect()).expect("a mesh")
}

#[test]
fn mass_is_that_of_the_bake() {
    let rest = DeformingMesh::at_rest(support::bumpy()).expect("a mesh");
    let record = *support::bumpy()
        .model()
        .asset()
        .mass_properties()
        .expect("a closed mesh");
    let expected = trimesh(&rest).mass_properties(1000.0);
    let found = rest.mass_properties(1000.0);
    let is_near = |a: Real, b: Real| (a - b).abs() < 1e-3 * b.abs();
    assert!(
        is_near(found.mass(), expected.mass()),
        "{found:?}, {expected:?}"
    );
    assert!(
        found.local_com.distance(expected.local_com) < 1e-3,
        "{found:?}, {expected:?}"
    );
    let (a, b) = (
        found.reconstruct_inertia_matrix(),
        expected.reconstruct_inertia_matrix(),
    );
    let size = b.x_axis.length();
    for k in 0..3 {
        assert!(a.col(k).distance(b.col(k)) < 2e-3 * size, "{a}, {b}");
    }
    let baked = rest.baked_mass_properties().expect("a closed mesh");
    assert!(is_near(baked.mass(), record.mass_kg.get() as Real));
    // Twice the size, the same mass.
    let twice = support::bumpy().scaled(1.6).expect("a model");
    let twice = DeformingMesh::at_rest(&twice)
        .expect("a mesh")
        .baked_mass_properties()
        .expect("mass");
    assert!(is_near(twice.mass(), baked.mass()));
    let of = |m: super::parry::mass_properties::MassProperties| m.principal_inertia().element_sum();
    assert!(is_near(of(twice), 4.0 * of(baked)));
}

#[test]
fn an_open_mesh_has_no_mass_and_pushes_from_both_sides() {
    let mut mesh = bake::bumpy_sphere(5, 3);
    mesh.triangles.pop();
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 2, 5));
    let model = DeformingModel::new(&model, 1.0).expect("a model");
    assert!(!model.is_closed() && support::bumpy().is_closed());
    let rest = DeformingMesh::at_rest(&model).expect("a mesh");
    assert!(rest.baked_mass_properties().is_none());
    assert_eq!(rest.mass_properties(1.0).mass(), 0.0);
    assert!(rest.normal_constraints(0).expect("a triangle").two_sided);
}

#[test]
fn boxes_points_and_rays_are_those_of_the_triangles() {
    let mut rng = poses::rng(41);
    let mut hits = 0;
    for _ in 0..5 {
        let mesh = support::mesh(support::bumpy(), &mut rng);
        let all = trimesh(&mesh);
        let (aabb, sphere) = (
            mesh.compute_local_aabb(),
            mesh.compute_local_bounding_sphere(),
        );
        for corner in all.vertices() {
            assert!(aabb.contains_local_point(*corner));
            assert!(sphere.center.distance(*corner) <= sphere.radius);
        }
        for _ in 0..50 {
            let point = support::pose(1.5, &mut rng).translation;
            let (found, expected) = (
                mesh.project_local_point(point, false),
                all.project_local_point(point, false),
            );
            let (found, expected) = (found.point.distance(point), expected.point.distance(point));
            assert!((found - expected).abs() < 1e-5, "{found}, {expected}");
            let limit = 0.9 * expected;
            assert!(
                mesh.project_local_point_with_max_dist(point, false, limit)
                    .is_none()
            );
            let towards = support::pose(0.5, &mut rng).translation - point;
            // Of any length.
            let ray = Ray::new(point, towards * rng.random_range(0.1..3.0));
            let pose = support::pose(1.0, &mut rng);
            for limit in [0.4, 1e9] {
                let found =
                    mesh.cast_ray_and_get_normal(&pose, &ray.transform_by(&pose), limit, false);
                let expected =
                    all.cast_ray_and_get_normal(&pose, &ray.transform_by(&pose), limit, false);
                assert_eq!(found.is_some(), expected.is_some(), "{ray:?}");
                let (Some(found), Some(expected)) = (found, expected) else {
                    continue;
                };
                hits += 1;
                assert!((found.time_of_impact - expected.time_of_impact).abs() < 1e-4);
                assert!(found.normal.dot(expected.normal) > 0.99);
            }
        }
    }
    assert!(hits > 100, "{hits}");
}

#[test]
fn what_is_no_mesh_is_refused() {
    let model = support::bumpy();
    assert!(matches!(
        DeformingMesh::new(model, &[0.0]),
        Err(ShapeError::Pose(_))
    ));
    let too_far = vec![f32::INFINITY; model.model().asset().mode_count()];
    assert!(matches!(
        DeformingMesh::new(model, &too_far),
        Err(ShapeError::Pose(_))
    ));
    for scale in [0.0, -1.0, f64::NAN] {
        assert!(
            matches!(model.scaled(scale), Err(ShapeError::Pose(_))),
            "{scale}"
        );
    }
    let mesh = DeformingMesh::at_rest(model).expect("a mesh");
    assert!(mesh.triangle(mesh.triangle_count()).is_none());
    let nowhere = Vector::splat(Real::NAN);
    assert!(mesh.project_local_point(nowhere, false).point.is_nan());
    let ray = Ray::new(Vector::ZERO, Vector::ZERO);
    assert!(mesh.cast_ray(&Pose::IDENTITY, &ray, 1.0, false).is_none());
    assert!(mesh.scale_dyn(Vector::new(1.0, 2.0, 1.0), 0).is_none());
    let twice = mesh
        .scale_dyn(Vector::splat(2.0), 0)
        .expect("a scale")
        .compute_local_aabb();
    let once = mesh.compute_local_aabb();
    assert!((twice.maxs - once.maxs * 2.0).length() < 1e-4);
}
