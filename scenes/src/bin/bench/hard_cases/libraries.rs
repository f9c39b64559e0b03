//! Rigid meshes in the libraries that people use, each asked in its own way and precision.

use bdtree_build::basis::Basis;
use bdtree_build::input::RawMesh;
use bdtree_build::pipeline::{BakeSettings, Provenance, bake_fields};
use bdtree_build::progress::Silent;
use bdtree_runtime::{Instance, Model, Ray, Workspace};

/// A mesh as it is given, and rounded for those who take f32.
pub(super) struct Given {
    pub(super) mesh: RawMesh,
    /// Three corners per triangle.
    #[cfg(feature = "peers")]
    soup: Vec<[f32; 3]>,
}

impl Given {
    pub(super) fn new(mesh: RawMesh) -> Self {
        Self {
            #[cfg(feature = "peers")]
            soup: soup(&mesh),
            mesh,
        }
    }
}

/// The corners of all triangles; of one that has none, nothing is taken.
#[cfg(feature = "peers")]
fn soup(mesh: &RawMesh) -> Vec<[f32; 3]> {
    let corner = |v: &u32| mesh.positions.get(*v as usize);
    let corners = mesh.triangles.as_flattened().iter().filter_map(corner);
    corners.map(|p| p.map(|x| x as f32)).collect()
}

/// A mesh in a library.
pub(super) trait Library {
    /// The distance along a ray (f32 numbers; the direction of any length, the distance in its lengths),
    /// if it meets the mesh.
    fn ray(&mut self, origin: [f32; 3], direction: [f32; 3]) -> Option<f64>;

    /// The distance of a point; `None` where the library has no such question.
    fn closest(&mut self, to: [f64; 3]) -> Option<f64>;
}

/// Name, precision of coordinates, and how a mesh gets in.
pub(super) struct Entry {
    pub(super) name: &'static str,
    pub(super) precision: &'static str,
    pub(super) build: fn(&Given) -> Result<Box<dyn Library + '_>, String>,
}

/// The product first.
pub(super) fn entries() -> Vec<Entry> {
    vec![
        Entry {
            name: "bdtree",
            precision: "f32 about an origin in f64, tests in f64",
            build: |given| Ok(Box::new(Own::new(given)?)),
        },
        #[cfg(feature = "peers")]
        Entry {
            name: "parry3d",
            precision: "f32",
            build: |given| Ok(Box::new(peers::Parry::new(given)?)),
        },
        #[cfg(feature = "peers")]
        Entry {
            name: "obvhs",
            precision: "f32",
            build: |given| Ok(Box::new(peers::Obvhs::new(given))),
        },
    ]
}

struct Own {
    body: Instance,
    workspace: Workspace<'static>,
}

impl Own {
    fn new(given: &Given) -> Result<Self, String> {
        let basis = Basis {
            vertex_count: given.mesh.positions.len(),
            ..Basis::default()
        };
        let baked = bake_fields(
            &given.mesh,
            &basis,
            &BakeSettings::default(),
            &Provenance::default(),
            &Silent,
        );
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
        let hit = self
            .body
            .query(&mut self.workspace)
            .cast_ray(&Ray::new(o, d));
        hit.expect("a ray").map(|hit| hit.distance / length)
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

    use super::{Given, Library};

    pub(super) struct Parry(TriMesh);

    impl Parry {
        pub(super) fn new(given: &Given) -> Result<Self, String> {
            let vertices = given.mesh.positions.iter();
            let vertices = vertices.map(|p| Vector::from_array(p.map(|x| x as f32)));
            let mesh = TriMesh::new(vertices.collect(), given.mesh.triangles.clone());
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
        pub(super) fn new(given: &Given) -> Self {
            let triangles: Vec<Triangle> = (given.soup.as_chunks::<3>().0.iter())
                .map(|corners| {
                    let [v0, v1, v2] = corners.map(Vec3A::from_array);
                    Triangle { v0, v1, v2 }
                })
                .collect();
            let settings = BvhBuildParams::medium_build();
            let tree = build_bvh2_from_tris(&triangles, settings, &mut Duration::default());
            let ordered = tree.primitive_indices.iter();
            Self {
                triangles: ordered
                    .map(|i| RtTriangle::from(&triangles[*i as usize]))
                    .collect(),
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
