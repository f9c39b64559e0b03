//! Meshes, shapes and poses of tests.

use std::sync::OnceLock;

use bdtree_fixtures::{bake, poses};
use bdtree_parry::DeformingModel;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::ours::DeformingMesh;
use super::parry::bounding_volume::{Aabb, BoundingSphere};
use super::parry::mass_properties::MassProperties;
use super::parry::math::{IVector, Pose, Real, Rotation, Vector};
use super::parry::query::{PointProjection, PointQuery, Ray, RayCast, RayIntersection};
use super::parry::shape::{
    Cuboid, FeatureId, PolygonalFeatureMap, Shape, ShapeType, SharedShape, SupportMap, TypedShape,
};
use super::parry::utils::Array2;

/// A closed, bumpy surface of about unit radius with four smooth fields.
pub(crate) fn bumpy() -> &'static DeformingModel {
    static MODEL: OnceLock<DeformingModel> = OnceLock::new();
    MODEL.get_or_init(|| {
        let mesh = bake::bumpy_sphere(6, 3);
        let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 4, 5));
        DeformingModel::new(&model, 0.8).expect("a model")
    })
}

/// The model at a random q within its range.
pub(crate) fn mesh(model: &DeformingModel, rng: &mut Pcg64Mcg) -> DeformingMesh {
    let modes = model.model().asset().modes();
    let q: Vec<f32> = modes
        .iter()
        .map(|mode| mode.q_range.get() * rng.random_range(-1.5..1.5_f32))
        .collect();
    DeformingMesh::new(model, &q).expect("a mesh")
}

/// A random pose whose origin is at most `spread` away.
pub(crate) fn pose(spread: f64, rng: &mut Pcg64Mcg) -> Pose {
    let at = poses::random_transform(spread, rng);
    let [x, y, z, w] = at.rotation.map(|c| c as Real);
    let rotation = Rotation::from_xyzw(x, y, z, w).normalize();
    Pose::from_parts(vector(at.translation), rotation)
}

pub(crate) fn vector(v: [f64; 3]) -> Vector {
    Vector::from_array(v.map(|x| x as Real))
}

fn points(count: usize, size: f64, seed: u64) -> Vec<Vector> {
    let mut rng = poses::rng(seed);
    let coordinate = |_| rng.random_range(-size..size);
    let all: Vec<f64> = (0..3 * count).map(coordinate).collect();
    all.chunks_exact(3)
        .map(|p| vector([p[0], p[1], p[2]]))
        .collect()
}

/// A shape of every kind that parry has, by name.
pub(crate) fn shape(kind: &str) -> SharedShape {
    let v = |x, y, z| vector([x, y, z]);
    match kind {
        "ball" => SharedShape::ball(0.3),
        "cuboid" => SharedShape::cuboid(0.3, 0.2, 0.4),
        "capsule" => SharedShape::capsule(v(-0.3, 0.0, 0.1), v(0.3, 0.2, 0.0), 0.15),
        "segment" => SharedShape::segment(v(-0.4, 0.1, 0.0), v(0.3, 0.3, 0.2)),
        "triangle" => SharedShape::triangle(v(-0.4, 0.0, 0.1), v(0.4, 0.0, 0.0), v(0.0, 0.5, 0.2)),
        "convex_polyhedron" => SharedShape::convex_hull(&points(12, 0.4, 7)).expect("a hull"),
        "cylinder" => SharedShape::cylinder(0.3, 0.25),
        "cone" => SharedShape::cone(0.3, 0.3),
        "round_cuboid" => SharedShape::round_cuboid(0.2, 0.2, 0.3, 0.05),
        "round_triangle" => {
            SharedShape::round_triangle(v(-0.4, 0.0, 0.1), v(0.4, 0.0, 0.0), v(0.0, 0.5, 0.2), 0.1)
        }
        "round_cylinder" => SharedShape::round_cylinder(0.25, 0.2, 0.06),
        "round_cone" => SharedShape::round_cone(0.25, 0.25, 0.06),
        "round_convex_polyhedron" => {
            SharedShape::round_convex_hull(&points(12, 0.3, 8), 0.06).expect("a hull")
        }
        "half_space" => SharedShape::halfspace(v(0.0, 1.0, 0.0)),
        "tri_mesh" => {
            let corners = points(24, 0.5, 9);
            let triangles = (0..8).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
            SharedShape::trimesh(corners, triangles).expect("a mesh")
        }
        "polyline" => SharedShape::polyline(points(9, 0.5, 10), None),
        "height_field" => {
            let mut rng = poses::rng(11);
            let heights = (0..36).map(|_| rng.random_range(-0.2..0.2)).collect();
            SharedShape::heightfield(Array2::new(6, 6, heights), v(2.0, 1.0, 2.0))
        }
        "voxels" => {
            let cells: Vec<IVector> = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 1, 1], [-2, 0, 1]]
                .map(IVector::from_array)
                .to_vec();
            SharedShape::voxels(v(0.2, 0.15, 0.25), &cells)
        }
        "compound" => SharedShape::compound(vec![
            (Pose::translation(0.3, 0.0, 0.0), SharedShape::ball(0.2)),
            (
                Pose::translation(-0.3, 0.1, 0.0),
                SharedShape::cuboid(0.1, 0.2, 0.3),
            ),
            (
                Pose::translation(0.0, 0.4, 0.2),
                SharedShape::cone(0.2, 0.2),
            ),
        ]),
        "custom" => SharedShape::new(Mine(Cuboid::new(v(0.3, 0.2, 0.25)))),
        _ => panic!("{kind}: no such shape"),
    }
}

/// A shape of a user's: a box that does not say that it is one.
#[derive(Clone, Debug)]
pub(crate) struct Mine(pub(crate) Cuboid);

impl PointQuery for Mine {
    fn project_local_point(&self, pt: Vector, solid: bool) -> PointProjection {
        self.0.project_local_point(pt, solid)
    }

    fn project_local_point_and_get_feature(&self, pt: Vector) -> (PointProjection, FeatureId) {
        self.0.project_local_point_and_get_feature(pt)
    }
}

impl RayCast for Mine {
    fn cast_local_ray_and_get_normal(
        &self,
        ray: &Ray,
        max_time_of_impact: Real,
        solid: bool,
    ) -> Option<RayIntersection> {
        self.0
            .cast_local_ray_and_get_normal(ray, max_time_of_impact, solid)
    }
}

impl Shape for Mine {
    fn compute_local_aabb(&self) -> Aabb {
        Shape::compute_local_aabb(&self.0)
    }

    fn compute_local_bounding_sphere(&self) -> BoundingSphere {
        Shape::compute_local_bounding_sphere(&self.0)
    }

    fn clone_dyn(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }

    fn scale_dyn(&self, _: Vector, _: u32) -> Option<Box<dyn Shape>> {
        None
    }

    fn mass_properties(&self, density: Real) -> MassProperties {
        Shape::mass_properties(&self.0, density)
    }

    fn shape_type(&self) -> ShapeType {
        ShapeType::Custom
    }

    fn as_typed_shape(&self) -> TypedShape<'_> {
        TypedShape::Custom(self)
    }

    fn ccd_thickness(&self) -> Real {
        self.0.ccd_thickness()
    }

    fn ccd_angular_thickness(&self) -> Real {
        self.0.ccd_angular_thickness()
    }

    fn is_convex(&self) -> bool {
        true
    }

    fn as_support_map(&self) -> Option<&dyn SupportMap> {
        Some(&self.0)
    }

    fn as_polygonal_feature_map(&self) -> Option<(&dyn PolygonalFeatureMap, Real)> {
        Some((&self.0, 0.0))
    }
}
