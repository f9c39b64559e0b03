//! Rigid meshes in the libraries that people use, each asked in its own way and precision.

use bdtree_build::input::RawMesh;
use bdtree_build::pipeline::{BakeSettings, Provenance, bake_fields};
use bdtree_build::progress::Silent;
use bdtree_fixtures::bake::rigid;
use bdtree_runtime::{Instance, Ray};

use crate::prelude::*;

/// A mesh in a library.
pub(super) trait Library {
    /// The distance along a ray (f32 numbers; the direction of any length, the distance in its lengths),
    /// if it meets the mesh.
    fn ray(&mut self, origin: [f32; 3], direction: [f32; 3]) -> Option<f64>;

    /// The distance of a point; `None` where the library has no such question.
    fn closest(&mut self, to: [f64; 3]) -> Option<f64>;
}

/// Names and precision of coordinates, the product first.
pub(super) const LIBRARIES: &[(&str, &str)] = &[
    ("bdtree", "f32 about an origin in f64, tests in f64"),
    #[cfg(feature = "peers")]
    ("parry3d", "f32"),
    #[cfg(feature = "peers")]
    ("obvhs", "f32"),
];

/// A mesh in a library.
pub(super) fn build(library: &str, mesh: &RawMesh) -> Result<Box<dyn Library>, String> {
    Ok(match library {
        #[cfg(feature = "peers")]
        "parry3d" => Box::new(peers::Parry::new(mesh)?),
        #[cfg(feature = "peers")]
        "obvhs" => Box::new(peers::Obvhs::new(mesh)),
        _ => Box::new(Own::new(mesh)?),
    })
}

/// What each library answers on a mesh, or why it does not take the mesh.
pub(super) fn answers(
    name: &str,
    mesh: &RawMesh,
    mut ask: impl FnMut(&mut dyn Library) -> String,
) -> Row {
    let mut row = row! {"mesh" => name};
    for (library, _) in LIBRARIES {
        let built = build(library, mesh);
        let answer = built.map_or_else(|error| error, |mut library| ask(library.as_mut()));
        row.extend(row! {*library => answer});
    }
    row
}

struct Own {
    body: Instance,
    workspace: Workspace<'static>,
}

impl Own {
    fn new(mesh: &RawMesh) -> Result<Self, String> {
        let (settings, provenance) = (BakeSettings::default(), Provenance::default());
        let baked = bake_fields(mesh, &rigid(mesh), &settings, &provenance, &Silent);
        let model = Model::from_bytes(&baked.map_err(|e| e.to_string())?.bytes);
        let body = Instance::new(&model.expect("a sound file")).expect("a pose at rest");
        let workspace = Workspace::new();
        Ok(Self { body, workspace })
    }
}

impl Library for Own {
    fn ray(&mut self, origin: [f32; 3], direction: [f32; 3]) -> Option<f64> {
        let [o, d] = [origin, direction].map(|v| v.map(f64::from));
        let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
        let mut query = self.body.query(&mut self.workspace);
        let hit = query.cast_ray(&Ray::new(o, d)).expect("a ray");
        hit.map(|hit| hit.distance / length)
    }

    fn closest(&mut self, to: [f64; 3]) -> Option<f64> {
        let mut query = self.body.query(&mut self.workspace);
        let near = query.project_point(to, f64::INFINITY).expect("a point");
        near.map(|near| near.distance)
    }
}

#[cfg(feature = "peers")]
mod peers {
    use std::time::Duration;

    use glam::Vec3A;
    use obvhs::BvhBuildParams;
    use obvhs::bvh2::Bvh2;
    use obvhs::bvh2::builder::build_bvh2_from_tris;
    use obvhs::ray::RayHit;
    use obvhs::rt_triangle::RtTriangle;
    use obvhs::triangle::Triangle;
    use parry3d::math::Vector;
    use parry3d::query::{PointQuery, Ray, RayCast};
    use parry3d::shape::TriMesh;

    use bdtree_build::input::RawMesh;

    use super::Library;

    pub(super) struct Parry(TriMesh);

    impl Parry {
        pub(super) fn new(mesh: &RawMesh) -> Result<Self, String> {
            let vertices = mesh.positions.iter();
            let vertices = vertices.map(|p| Vector::from_array(p.map(|x| x as f32)));
            let mesh = TriMesh::new(vertices.collect(), mesh.triangles.clone());
            mesh.map(Self).map_err(|e| e.to_string())
        }
    }

    impl Library for Parry {
        fn ray(&mut self, origin: [f32; 3], direction: [f32; 3]) -> Option<f64> {
            let ray = Ray::new(Vector::from_array(origin), Vector::from_array(direction));
            self.0.cast_local_ray(&ray, f32::MAX, false).map(f64::from)
        }

        fn closest(&mut self, to: [f64; 3]) -> Option<f64> {
            let to = Vector::from_array(to.map(|x| x as f32));
            Some(f64::from(self.0.distance_to_local_point(to, false)))
        }
    }

    pub(super) struct Obvhs {
        tree: Bvh2,
        triangles: Vec<RtTriangle>,
    }

    impl Obvhs {
        pub(super) fn new(mesh: &RawMesh) -> Self {
            let corner = |v: u32| Vec3A::from_array(mesh.positions[v as usize].map(|x| x as f32));
            let triangle = |t: &[u32; 3]| {
                let [v0, v1, v2] = t.map(corner);
                Triangle { v0, v1, v2 }
            };
            let triangles: Vec<Triangle> = mesh.triangles.iter().map(triangle).collect();
            let settings = BvhBuildParams::medium_build();
            let tree = build_bvh2_from_tris(&triangles, settings, &mut Duration::default());
            let ordered = tree.primitive_indices.iter();
            let ordered = ordered.map(|i| RtTriangle::from(&triangles[*i as usize]));
            Self {
                triangles: ordered.collect(),
                tree,
            }
        }
    }

    impl Library for Obvhs {
        fn ray(&mut self, origin: [f32; 3], direction: [f32; 3]) -> Option<f64> {
            let ray = obvhs::ray::Ray::new_inf(origin.into(), direction.into());
            let mut hit = RayHit::none();
            let triangles = &self.triangles;
            self.tree
                .ray_traverse(ray, &mut hit, |ray, i| triangles[i].intersect(ray));
            hit.t.is_finite().then_some(f64::from(hit.t))
        }

        fn closest(&mut self, _: [f64; 3]) -> Option<f64> {
            None
        }
    }
}
