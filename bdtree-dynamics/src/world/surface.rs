//! Contact spheres of one body against the triangles of another.

use alloc::vec::Vec;

use bdtree_runtime::TriangleId;
use bdtree_runtime::narrow::closest_point;
use nalgebra::Vector3;

use super::body::Body;
use super::contact::{Contact, Material, Meeting, Mover, NEAR, Side};
use super::groups::Group;
use super::pairs::{Candidate, Pair};
use super::solve::Warm;
use super::{World, part};
use crate::error::DynamicsError;
use crate::field::Field;
use crate::surface::{Corners, Surface};

/// Steps towards the first touch of a sphere and a triangle; each leaves a share of the gap.
const ADVANCES: usize = 24;

/// A first touch is found to this share of the sphere's radius.
const TOUCH: f64 = 1e-3;

/// A triangle that a sphere meets, or may meet.
#[derive(Debug, Clone)]
pub(super) struct Near {
    triangle: u32,
    /// From the triangle to the sphere.
    normal: Vector3<f64>,
    weights: [f64; 3],
    /// The point of the triangle nearest to the sphere, at the beginning and at the end.
    way: [Vector3<f64>; 2],
    overlaps: [f64; 2],
    /// When they first touch, as a share of the step, if they do; infinite if not. And their distance at the beginning.
    first: [f64; 2],
    corners: usize,
}

/// What a thread needs for triangles.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    near: Vec<Near>,
    pub(super) corners: Vec<Corners>,
    /// Of a triangle of the step before.
    old: Corners,
}

/// A body whose triangles touch others, in a step.
pub(super) struct Target<'w> {
    index: u32,
    pub(super) body: &'w Body,
    surface: &'w Surface,
    q: [&'w [f64]; 2],
    /// Whether forces move modes.
    has_field: bool,
}

impl Target<'_> {
    /// The corners in the world, at the beginning (0) and at the end (1) of the step.
    fn at(&self, corners: &Corners, end: usize) -> [Vector3<f64>; 3] {
        let own = self.surface.at(corners, self.q[end]);
        let position = [&self.body.state, &self.body.end][end].position;
        own.map(|corner| position + self.body.rotations[end] * corner)
    }

    /// The point with these weights of a triangle's corners: where it is at the beginning and at the end of the step. Its
    /// field follows in `fields`.
    ///
    /// # Errors
    /// A damaged asset, a triangle that it does not have.
    pub(super) fn point(
        &self,
        triangle: TriangleId,
        weights: [f64; 3],
        corners: &mut Corners,
        fields: &mut Vec<f64>,
    ) -> Result<[Vector3<f64>; 2], DynamicsError> {
        self.surface.corners(triangle, corners)?;
        self.put_field(corners, weights, fields);
        Ok([0, 1].map(|end| weighted(&self.at(corners, end), weights)))
    }

    fn put_field(&self, corners: &Corners, weights: [f64; 3], fields: &mut Vec<f64>) {
        if self.has_field {
            self.surface.field(corners, weights, fields);
        }
    }
}

fn weighted(corners: &[Vector3<f64>; 3], weights: [f64; 3]) -> Vector3<f64> {
    corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2]
}

/// On which side of what a sphere was in the step before.
struct Held<'w> {
    old: &'w [Warm],
    /// Which of the sides the spheres are.
    sphere: usize,
    number: u32,
    triangle: u32,
}

impl Held<'_> {
    /// Whether the sphere has been pressed through the surface: its center, in direction `away` of the triangle, was on the other
    /// side of it in the step before, or of a triangle that pushed it and that it is behind by now. A wall that faces what
    /// pushed it, in a narrow place, is not what it was pressed through.
    ///
    /// # Errors
    /// A damaged asset.
    fn is_across(
        &self,
        target: &Target<'_>,
        center: &Vector3<f64>,
        away: &Vector3<f64>,
        corners: &mut Corners,
    ) -> Result<bool, DynamicsError> {
        const ALIKE: f64 = 0.7;
        let size = away.norm();
        let (mut is_alike, mut is_through) = (false, false);
        for warm in self.old {
            if warm.sides[self.sphere].sphere != self.number {
                continue;
            }
            // Towards the sphere.
            let along = if self.sphere == 0 {
                warm.along
            } else {
                -warm.along
            };
            let share = along.dot(away);
            let triangle = warm.sides[1 - self.sphere].sphere;
            if triangle == self.triangle {
                return Ok(share < 0.0);
            }
            is_alike |= share > ALIKE * size;
            if share < -ALIKE * size && warm.normal > 0.0 {
                target.surface.corners(TriangleId(triangle), corners)?;
                let at = target.at(corners, 0);
                let closest = closest_point((*center).into(), &at.map(Into::into));
                let off = center - weighted(&at, closest.barycentric);
                is_through |= along.dot(&off) < 0.0;
            }
        }
        Ok(is_through && !is_alike)
    }
}

impl World {
    /// Adds the contacts of a body's spheres with another body's triangles. `list` has pairs of a sphere and a triangle;
    /// where `is_swapped`, the triangles are the first body's of the pair.
    ///
    /// # Errors
    /// A damaged asset.
    pub(super) fn look_at_surface(
        &self,
        pair: &Pair,
        is_swapped: bool,
        list: &[Candidate],
        warm: &[Warm],
        scratch: &mut Scratch,
        group: &mut Group,
    ) -> Result<(), DynamicsError> {
        if list.is_empty() {
            return Ok(());
        }
        let both = [pair.first, pair.second];
        let [of_sphere, of_triangle] = if is_swapped { [both[1], both[0]] } else { both };
        let mover = self.mover(of_sphere);
        let Some(target) = self.target(of_triangle) else {
            return Ok(());
        };
        let base = group.clusters[0];
        let slots =
            [of_sphere, of_triangle].map(|body| self.groups.places[body as usize].within(base));
        let (a, b) = (mover.body, target.body);
        let near = 3.0 * ((a.way - b.way).norm() + a.swing + b.swing + a.ripple + b.ripple);
        for run in list.chunk_by(|one, other| one.elements[0] == other.elements[0]) {
            let sphere = run[0].elements[0] as usize;
            let way = [mover.start(sphere), mover.end(sphere)];
            scratch.near.clear();
            for (k, of) in run.iter().enumerate() {
                let [_, triangle] = of.elements;
                if scratch.corners.len() <= k {
                    scratch.corners.push(Corners::default());
                }
                let corners = &mut scratch.corners[k];
                target.surface.corners(TriangleId(triangle), corners)?;
                let radius = mover.spheres.radius(sphere);
                let held = Held {
                    old: warm,
                    sphere: usize::from(is_swapped),
                    number: sphere as u32,
                    triangle,
                };
                let old = &mut scratch.old;
                let found = meeting(&target, corners, way, radius, near, &held, old)?;
                scratch.near.extend(found.map(|found| Near {
                    triangle,
                    corners: k,
                    ..found
                }));
            }
            leave_out(&mut scratch.near, mover.spheres.radius(sphere));
            for found in &scratch.near {
                let corners = &scratch.corners[found.corners];
                let start = group.fields.len();
                target.put_field(corners, found.weights, &mut group.fields);
                let own = Field(&group.fields[start..]);
                let contact = self.touch_triangle(&mover, &target, sphere, way, found, own);
                let Some(mut contact) = contact else {
                    group.fields.truncate(start);
                    continue;
                };
                contact.fields[1] = Some(start as u32);
                contact.slots = slots;
                if is_swapped {
                    contact.swap();
                }
                contact.begin_with_any(warm, usize::from(is_swapped));
                group.contacts.push(contact);
            }
        }
        Ok(())
    }

    /// A body whose shape is triangles.
    pub(super) fn target(&self, index: u32) -> Option<Target<'_>> {
        let body = &self.bodies[index as usize];
        let model = &self.models[body.model];
        let stride = model.spheres.stride();
        let modal = &self.modal;
        Some(Target {
            index,
            body,
            surface: model.surface.as_ref()?,
            q: [&modal.q, &modal.end_q].map(|q| part(q, body.start, stride)),
            has_field: stride > 0 && body.per_mode_moves(&modal.per_force, stride),
        })
    }

    /// A point of a triangle, or a vertex, as a side of a contact at `point`.
    pub(super) fn surface_material<'w>(
        &self,
        of: &Target<'w>,
        element: u32,
        way: [Vector3<f64>; 2],
        field: Field<'w>,
        point: &Vector3<f64>,
    ) -> Material<'w> {
        let mut material = Material {
            side: Side {
                body: of.index,
                sphere: element,
            },
            body: of.body,
            way,
            field,
            inverse_mass: 0.0,
        };
        material.inverse_mass = self.inverse_mass_at(&material, point);
        material
    }

    fn touch_triangle<'w>(
        &self,
        mover: &Mover<'w>,
        target: &Target<'w>,
        sphere: usize,
        way: [Vector3<f64>; 2],
        found: &Near,
        field: Field<'w>,
    ) -> Option<Contact> {
        let meeting = Meeting {
            normal: found.normal,
            point: (found.way[0] + found.way[1]) * 0.5,
            overlaps: found.overlaps,
            radius: mover.spheres.radius(sphere),
        };
        let first = self.material(mover, sphere, way);
        let (triangle, way) = (found.triangle, found.way);
        let second = self.surface_material(target, triangle, way, field, &meeting.point);
        self.contact(&meeting, &first, Some(&second), second.side)
    }
}

/// A sphere on its way and a triangle, if they touch or may touch within the step.
///
/// Where the triangle moves with the body it is taken to move as its point that the sphere meets.
fn meeting(
    target: &Target<'_>,
    corners: &Corners,
    [from, to]: [Vector3<f64>; 2],
    radius: f64,
    near: f64,
    held: &Held<'_>,
    old: &mut Corners,
) -> Result<Option<Near>, DynamicsError> {
    let start = target.at(corners, 0);
    let mut closest = closest_point(from.into(), &start.map(Into::into));
    if closest.distance > radius + near {
        return Ok(None);
    }
    let distance = closest.distance;
    let end = target.at(corners, 1);
    // How the sphere moves seen from the point at these weights.
    let seen = |w: [f64; 3]| (to - from) - (weighted(&end, w) - weighted(&start, w));
    let mut at = 0.0;
    let mut center = from;
    let mut is_met = closest.distance <= radius;
    if !is_met {
        // No step passes the first touch: the distance changes by no more than the way.
        for _ in 0..ADVANCES {
            let way = seen(closest.barycentric);
            let size = way.norm();
            let step = (closest.distance - radius) / size;
            if !(at + step < 1.0) {
                break;
            }
            at += step;
            center = from + way * at;
            closest = closest_point(center.into(), &start.map(Into::into));
            if closest.distance <= radius * (1.0 + TOUCH) {
                is_met = true;
                break;
            }
        }
    }
    if !is_met {
        let last = closest_point(to.into(), &end.map(Into::into));
        let way = seen(last.barycentric).norm();
        if !(last.distance - radius < NEAR * (way + 1e-3 * radius)) {
            return Ok(None);
        }
        // Others may yet push them together.
        let way = [&start, &end].map(|of| weighted(of, last.barycentric));
        let Some(normal) = (to - way[1]).try_normalize(1e-9 * radius) else {
            return Ok(None);
        };
        return Ok(Some(Near {
            triangle: 0,
            normal,
            weights: last.barycentric,
            way,
            // As far apart as they are, whatever side of the triangle's edge it comes from.
            overlaps: [radius - distance, radius - last.distance],
            first: [f64::INFINITY, distance],
            corners: 0,
        }));
    }
    let weights = closest.barycentric;
    let mut away = center - weighted(&start, weights);
    // Pressed so deep that its center is on the other side of the triangle.
    if distance <= radius && held.is_across(target, &from, &away, old)? {
        away = -away;
    }
    let normal = match away.try_normalize(1e-9 * radius) {
        Some(normal) => normal,
        // The center is in the triangle: along its own normal.
        None => {
            let across = (start[1] - start[0]).cross(&(start[2] - start[0]));
            let Some(normal) = across.try_normalize(0.0) else {
                return Ok(None);
            };
            normal
        }
    };
    let way = [&start, &end].map(|of| weighted(of, weights));
    Ok(Some(Near {
        triangle: 0,
        normal,
        weights,
        way,
        overlaps: [
            radius - normal.dot(&(from - way[0])),
            radius - normal.dot(&(to - way[1])),
        ],
        first: [at, distance],
        corners: 0,
    }))
}

/// Leaves out triangles that lie behind what the sphere meets before: of a flat or convex part of the surface, one triangle
/// pushes; in a corner, one of each side does.
fn leave_out(near: &mut Vec<Near>, radius: f64) {
    const SHARE: f64 = 1e-2;
    near.sort_unstable_by(|a, b| {
        let [(at, from), (at_b, from_b)] = [a, b].map(|of| (of.first[0], of.first[1]));
        (at.total_cmp(&at_b))
            .then(from.total_cmp(&from_b))
            .then(a.triangle.cmp(&b.triangle))
    });
    let mut kept = 0;
    for k in 0..near.len() {
        let is_behind = |one: &Near| {
            let same_side = one.normal.dot(&near[k].normal) > 0.0;
            let before = one.normal.dot(&(near[k].way[0] - one.way[0]));
            // In one plane they are one sheet, from whichever side.
            before.abs() <= SHARE * radius || same_side && before <= 0.0
        };
        if !near[..kept].iter().any(is_behind) {
            near.swap(kept, k);
            kept += 1;
        }
    }
    near.truncate(kept);
}
