//! Exact contacts of closed surfaces: the regions in which two bodies overlap, and vertices below a plane.
//!
//! Each point of a region pushes along the region's normal, at the depth that the query says; forces act on modes through the
//! barycentric weights of the points. Regions are those at the beginning of a part of a step ([`super::parts`]). A spring's energy
//! is that of its point's overlap, and the next part has other points, so that energy is not exact.

use bdtree_runtime::{HalfSpace, Workspace};
use nalgebra::Vector3;

use super::World;
use super::contact::{Contact, Meeting, NEAR, Side};
use super::groups::Group;
use super::pairs::Pair;
use super::solve::Warm;
use super::surface::Target;
use super::workers::Worker;
use crate::contact_law::Spring;
use crate::error::DynamicsError;
use crate::field::Field;

/// Share of the thinner wall within which one point stops a body.
const STOP: f64 = 0.25;

/// A point that two bodies may push each other at, or a body and a plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point {
    /// Triangles, or the vertex; then what tells those of the same elements apart.
    elements: [u32; 2],
    number: u32,
    /// Of the first and of the second body.
    triangles: [u32; 2],
    weights: [[f64; 3]; 2],
    /// Unit, from the second to the first.
    normal: Vector3<f64>,
}

impl World {
    /// Adds the contacts of two closed surfaces.
    ///
    /// # Errors
    /// A damaged asset.
    pub(super) fn look_at_regions(
        &self,
        pair: &Pair,
        warm: &[Warm],
        worker: &mut Worker,
        group: &mut Group,
    ) -> Result<(), DynamicsError> {
        let both = [pair.first, pair.second];
        let [pose_a, pose_b] = both.map(|index| self.instances[index as usize].pose());
        let [mut cache_a, mut cache_b] = both.map(|index| self.caches[index as usize].get());
        let mut unused = Workspace::in_bytes(&mut []);
        let (mut query_a, mut query_b) = (
            pose_a.query(&mut worker.workspace),
            pose_b.query(&mut unused),
        );
        if let Some(cache) = &mut cache_a {
            query_a = query_a.cached(cache);
        }
        if let Some(cache) = &mut cache_b {
            query_b = query_b.cached(cache);
        }
        worker.manifolds.clear();
        (query_a.against(query_b))
            .contact_manifolds(self.prediction(pair), &mut worker.manifolds)?;
        group.tally.add(worker);
        worker.points.clear();
        for manifold in &worker.manifolds {
            for point in manifold.points() {
                let triangles = [point.triangle1.0, point.triangle2.0];
                worker.points.push(Point {
                    elements: triangles,
                    number: worker.points.len() as u32,
                    triangles,
                    weights: [point.barycentric1, point.barycentric2],
                    normal: Vector3::from(manifold.normal2),
                });
            }
        }
        self.touch_points(both, None, warm, worker, group)
    }

    /// Adds the contacts of a closed surface's vertices with a plane.
    ///
    /// # Errors
    /// A damaged asset.
    pub(super) fn look_at_vertices(
        &self,
        pair: &Pair,
        plane: usize,
        warm: &[Warm],
        worker: &mut Worker,
        group: &mut Group,
    ) -> Result<(), DynamicsError> {
        let index = pair.first as usize;
        let at = self.planes[plane];
        let instance = &self.instances[index];
        let pose = instance.pose();
        let mut cache = self.caches[index].get();
        let mut query = pose.query(&mut worker.workspace);
        if let Some(cache) = &mut cache {
            query = query.cached(cache);
        }
        worker.triangles.clear();
        let raised = self.prediction(pair);
        query.contacts(
            HalfSpace::new(at.normal, at.offset + raised),
            &mut worker.triangles,
        )?;
        group.tally.add(worker);
        worker.points.clear();
        let asset = self.models[self.bodies[index].model].model.asset();
        for found in &worker.triangles {
            for (corner, vertex) in asset.triangle(found.triangle)?.into_iter().enumerate() {
                let mut weights = [0.0; 3];
                weights[corner] = 1.0;
                worker.points.push(Point {
                    elements: [vertex.0, 0],
                    number: found.triangle.0,
                    triangles: [found.triangle.0; 2],
                    weights: [weights; 2],
                    normal: at.normal.into(),
                });
            }
        }
        // Each vertex once, whichever triangles have it.
        (worker.points).sort_unstable_by_key(|point| (point.elements, point.number));
        worker.points.dedup_by_key(|point| point.elements);
        self.touch_points([pair.first, pair.second], Some(plane), warm, worker, group)
    }

    /// The law's spring of a stiffness (N/m).
    fn spring(&self, mass: f64, stiffness: f64) -> Spring {
        Spring {
            stiffness,
            damping: 2.0 * self.options.law.damping_ratio * libm::sqrt(stiffness * mass),
        }
    }

    /// Makes a contact stiff enough to stop what comes at it within a part of the wall. A spring that is stretched keeps its force:
    /// it begins at a larger overlap then, so that its energy does not grow.
    fn stiffen(&self, contact: &mut Contact) {
        let law = &self.options.law;
        let closing = (contact.free - contact.before) / self.part_s;
        if !(closing > 0.0 && law.stiffness > 0.0) {
            return;
        }
        // A mass on one spring alone gets as deep as its speed times this, over √κ.
        let needed_s = libm::sqrt(law.stiffness) * STOP * contact.radius / closing;
        let spring = law.spring(contact.mass, needed_s.min(self.options.step_s));
        let old = contact.spring;
        if spring.stiffness > old.stiffness {
            let stretch = (contact.before - contact.late).max(0.0);
            contact.late = (contact.before - stretch * (old.stiffness / spring.stiffness)).max(0.0);
            contact.spring = spring;
        }
    }

    /// Contacts at points that are near enough.
    fn touch_points(
        &self,
        both: [u32; 2],
        plane: Option<usize>,
        mut warm: &[Warm],
        worker: &mut Worker,
        group: &mut Group,
    ) -> Result<(), DynamicsError> {
        let targets = match plane {
            None => both.map(|index| self.target(index)),
            Some(_) => [self.target(both[0]), None],
        };
        let [Some(first), second] = targets else {
            return Ok(());
        };
        let wall = |of: &Target<'_>| self.models[of.body.model].wall;
        let radius = wall(&first).min(second.as_ref().map_or(f64::INFINITY, wall));
        let base = group.clusters[0];
        let slot = |body: u32| self.groups.places[body as usize].within(base);
        let slots = match &second {
            Some(_) => both.map(slot),
            None => [slot(both[0]); 2],
        };
        let corners = &mut worker.scratch.corners;
        if corners.is_empty() {
            corners.push(Default::default());
        }
        let corners = &mut corners[0];
        // As the contacts of the step before are sorted.
        (worker.points).sort_unstable_by_key(|point| (point.elements, point.number));
        group.tally.candidates += worker.points.len() as u64;
        for point in &worker.points {
            let (normal, fields) = (point.normal, &mut group.fields);
            let starts = [fields.len(), 0];
            let triangle = |side: usize| bdtree_runtime::TriangleId(point.triangles[side]);
            let of_first = first.point(triangle(0), point.weights[0], corners, fields)?;
            let starts = [starts[0], fields.len()];
            let of_second = match (&second, plane) {
                (Some(second), _) => {
                    second.point(triangle(1), point.weights[1], corners, fields)?
                }
                (None, Some(plane)) => {
                    let offset = self.planes[plane].offset;
                    of_first.map(|at| at - normal * (normal.dot(&at) - offset))
                }
                (None, None) => return Ok(()),
            };
            let apart = [0, 1].map(|end| of_first[end] - of_second[end]);
            let overlaps = apart.map(|apart| -normal.dot(&apart));
            // Others may yet push them together.
            let way = (apart[1] - apart[0]).norm();
            if !(overlaps[0] > 0.0 || overlaps[1] > -NEAR * (way + 1e-3 * radius)) {
                fields.truncate(starts[0]);
                continue;
            }
            let meeting = Meeting {
                normal,
                point: (of_first[0] + of_first[1] + of_second[0] + of_second[1]) * 0.25,
                overlaps,
                radius,
            };
            let fields = &group.fields;
            let own = Field(&fields[starts[0]..starts[1]]);
            let [element_a, element_b] = point.elements;
            let a = self.surface_material(&first, element_a, of_first, own, &meeting.point);
            let b = second.as_ref().map(|second| {
                let own = Field(&fields[starts[1]..]);
                self.surface_material(second, element_b, of_second, own, &meeting.point)
            });
            let side = match (&b, plane) {
                (Some(b), _) => b.side,
                (None, plane) => Side::plane(plane.unwrap_or_default()),
            };
            let Some(mut contact) = self.contact(&meeting, &a, b.as_ref(), side) else {
                group.fields.truncate(starts[0]);
                continue;
            };
            contact.fields = [Some(starts[0] as u32), Some(starts[1] as u32)];
            contact.slots = slots;
            match contact.begin_with(&mut warm) {
                Some(warm) => contact.spring = self.spring(contact.mass, warm.stiffness),
                // The spring's length is the overlap, whenever the point was found.
                None => contact.late = 0.0,
            }
            self.stiffen(&mut contact);
            group.contacts.push(contact);
        }
        Ok(())
    }
}
