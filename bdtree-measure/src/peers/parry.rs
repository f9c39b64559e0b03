//! parry3d: a deformable `TriMesh`, whose box tree is refitted when its vertices change.

use bdtree_runtime::narrow::Triangle;
use bdtree_runtime::{Contact, PairContact};
use parry3d::bounding_volume::Aabb;
use parry3d::math::Vector;
use parry3d::query::{Ray, RayCast};
use parry3d::shape::{TriMesh, TriMeshFlags};

use super::{PairPeer, Peer, Target};
use crate::Body;
use crate::leaf;

/// A body in parry.
#[derive(Debug, Clone)]
pub struct Parry(TriMesh);

impl Parry {
    /// Of a body at rest.
    ///
    /// # Panics
    /// When parry refuses the mesh.
    pub fn new(body: &Body) -> Self {
        let vertices = body.at_rest().iter().map(|p| Vector::from_array(*p));
        let flags = TriMeshFlags::DEFORMABLE;
        let mesh = TriMesh::with_flags(vertices.collect(), body.triangles.clone(), flags);
        Self(mesh.expect("a mesh with triangles"))
    }

    fn exact(&self, id: u32) -> Triangle {
        self.0.indices()[id as usize].map(|v| {
            let p = self.0.vertices()[v as usize];
            [f64::from(p.x), f64::from(p.y), f64::from(p.z)]
        })
    }
}

impl Peer for Parry {
    fn update_with(&mut self, to: Target<'_>, scratch: &mut Vec<f32>, deformed: &mut dyn FnMut()) {
        self.0.update_vertices(|vertices| {
            to.write(scratch, bytemuck::cast_slice_mut(vertices));
            deformed();
        });
    }

    fn ball(&mut self, center: [f64; 3], radius: f64, found: &mut Vec<Contact>) {
        let low = center.map(|c| ((c - radius) as f32).next_down());
        let high = center.map(|c| ((c + radius) as f32).next_up());
        let around = Aabb::new(Vector::from_array(low), Vector::from_array(high));
        for id in self.0.bvh().intersect_aabb(&around) {
            leaf::ball(id, &self.exact(id), center, radius, found);
        }
    }

    fn ray(&mut self, origin: [f32; 3], direction: [f32; 3]) -> Option<f64> {
        let ray = Ray::new(Vector::from_array(origin), Vector::from_array(direction));
        self.0.cast_local_ray(&ray, f32::MAX, false).map(f64::from)
    }
}

impl PairPeer for Parry {
    fn pair(&mut self, other: &mut Self, found: &mut Vec<PairContact>) {
        let pairs = self
            .0
            .bvh()
            .leaf_pairs(other.0.bvh(), |a, b| a.intersects(b));
        for (a, b) in pairs {
            leaf::pair((a, &self.exact(a)), (b, &other.exact(b)), found);
        }
    }
}
