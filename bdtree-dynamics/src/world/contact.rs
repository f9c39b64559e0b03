//! One pair of contact spheres in a step, linearised: how far apart they are at its beginning and, without forces, at its
//! end, and what forces do to that.

use nalgebra::{Matrix3, Vector3};

use super::body::{Body, Frame};
use super::find::Slot;
use super::{Plane, World, part, tangents};
use crate::contact_law::Spring;
use crate::field::Field;
use crate::level_spheres::LevelSpheres;

/// A sphere or a triangle of a body, or a plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Side {
    /// The body's number; of a plane, that counted from the end of the numbers.
    pub(super) body: u32,
    pub(super) sphere: u32,
}

impl Side {
    pub(super) fn plane(index: usize) -> Self {
        Self {
            body: u32::MAX - index as u32,
            sphere: 0,
        }
    }
}

/// The plane that a side's number stands for; `None` for a body.
pub(super) fn plane_of(side: u32) -> Option<usize> {
    (side > u32::MAX / 2).then_some((u32::MAX - side) as usize)
}

/// The bodies of two sides; the second may be a plane.
pub(super) fn bodies_of([first, second]: [u32; 2]) -> [Option<usize>; 2] {
    let second_body = plane_of(second).is_none().then_some(second as usize);
    [Some(first as usize), second_body]
}

/// What happens at a pair of contact spheres in a step. World coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactRecord {
    /// The bodies; the second is `None` for a plane.
    pub bodies: [Option<usize>; 2],
    /// The spheres of their models; of a body whose triangles touch others the triangle, of exact surfaces the triangle or, at a
    /// plane, the vertex; 0 of a plane.
    pub spheres: [usize; 2],
    /// Where forces act.
    pub point: [f64; 3],
    /// Unit, from the second body to the first.
    pub normal: [f64; 3],
    /// Overlap at the beginning of the step; negative is a gap.
    pub depth: f64,
    /// Force on the first body, N.
    pub force: [f64; 3],
}

/// How much the speed at the end of the step counts for friction, beside the displacement within it: with the
/// displacement alone, a body that friction holds would swing from step to step. It is that of the frame and of the modes: with the
/// frame's alone, the foot of a chair that rocks would creep along and feed the motion. Modes that are too fast for the step to resolve
/// count with their displacement.
const SPEED_SHARE: f64 = 1.0;

/// Slip over displacement by a constant force, which adds 2/h times what it displaces to the speed: exactly so for the frame,
/// within 8 % for a mode of ωh = 1.
pub(crate) const SLIP: f64 = 1.0 + 2.0 * SPEED_SHARE;

/// Pairs that do not touch by themselves are looked at if their gap at the end is below this share of how they move.
pub(super) const NEAR: f64 = 1.0;

#[derive(Debug, Clone)]
pub(super) struct Contact {
    pub(super) sides: [Side; 2],
    /// Where the solver has the bodies.
    pub(super) slots: [Slot; 2],
    /// Where the fields of sides that are triangles begin in the group's list.
    pub(super) fields: [Option<u32>; 2],
    /// The larger one of the spheres', or the thinner wall.
    pub(super) radius: f64,
    /// The effective one in the heaviest directions.
    pub(super) mass: f64,
    pub(super) normal: Vector3<f64>,
    pub(super) across: [Vector3<f64>; 2],
    /// From the bodies' centers to the point.
    pub(super) arms: [Vector3<f64>; 2],
    point: Vector3<f64>,
    /// Overlap at the beginning, and at the end without forces.
    pub(super) before: f64,
    pub(super) free: f64,
    /// Overlap that the pair had when it was found, if it overlapped before it was looked at: its spring begins there.
    pub(super) late: f64,
    pub(super) spring: Spring,
    /// Overlap that a unit normal force takes away.
    pub(super) response: f64,
    /// Slip without forces, along `across`.
    pub(super) slip: [f64; 2],
    /// Force over slip along `across`: the inverse of what forces do to it (xx, yy, xy).
    pub(super) hold: [f64; 3],
    /// Slip along `across` that a unit normal force makes.
    pub(super) leak: [f64; 2],
    /// Overlap along the normal at the end, as the last visit leaves it.
    pub(super) after: f64,
    /// Along the normal and `across`, N.
    pub(super) force: [f64; 3],
}

/// A body's contact spheres in a step.
pub(super) struct Mover<'w> {
    pub(super) index: u32,
    pub(super) body: &'w Body,
    pub(super) spheres: &'w LevelSpheres,
    q: &'w [f64],
    end_q: &'w [f64],
}

impl Mover<'_> {
    /// Center of a sphere at the beginning of the step.
    #[inline]
    pub(super) fn start(&self, sphere: usize) -> Vector3<f64> {
        let own = self.spheres.center(sphere, self.q);
        self.body.state.position + self.body.rotations[0] * own
    }

    /// Center of a sphere at the end of the step without forces.
    #[inline]
    pub(super) fn end(&self, sphere: usize) -> Vector3<f64> {
        let own = self.spheres.center(sphere, self.end_q);
        self.body.end.position + self.body.rotations[1] * own
    }
}

/// How two things meet.
pub(super) struct Meeting {
    /// Unit, from the second to the first.
    pub(super) normal: Vector3<f64>,
    /// Where forces act.
    pub(super) point: Vector3<f64>,
    /// Overlap along the normal at the beginning of the step, and at its end without forces.
    pub(super) overlaps: [f64; 2],
    /// What overlaps are compared with.
    pub(super) radius: f64,
}

/// What of a body meets something.
pub(super) struct Material<'w> {
    pub(super) side: Side,
    pub(super) body: &'w Body,
    /// Where it is at the beginning of the step and at its end without forces.
    pub(super) way: [Vector3<f64>; 2],
    pub(super) field: Field<'w>,
    /// 1 / effective mass in its heaviest direction.
    pub(super) inverse_mass: f64,
}

/// Compliance of the rigid motion and of the modes at a point.
struct Compliance {
    whole: Matrix3<f64>,
    /// Of the slip.
    slip: Matrix3<f64>,
}

impl Contact {
    /// The same contact with the other side first.
    pub(super) fn swap(&mut self) {
        self.sides.swap(0, 1);
        self.slots.swap(0, 1);
        self.fields.swap(0, 1);
        self.arms.swap(0, 1);
        // What pushes the one pushes the other back: along the normal the same, and all else with it.
        self.normal = -self.normal;
        self.across = self.across.map(|across| -across);
    }

    pub(super) fn record(&self) -> ContactRecord {
        let [first, second] = self.sides;
        ContactRecord {
            bodies: bodies_of([first.body, second.body]),
            spheres: [first.sphere as usize, second.sphere as usize],
            point: self.point.into(),
            normal: self.normal.into(),
            depth: self.before,
            force: self.force_vector().into(),
        }
    }

    pub(super) fn force_vector(&self) -> Vector3<f64> {
        self.normal * self.force[0]
            + self.across[0] * self.force[1]
            + self.across[1] * self.force[2]
    }

    /// Whether it is an event: an overlap or a force.
    pub(super) fn is_event(&self) -> bool {
        self.before > 0.0 || self.force[0] > 0.0
    }

    /// Whether it is one of exact surfaces.
    pub(super) fn is_of_regions(&self) -> bool {
        self.fields.iter().all(Option::is_some)
    }

    pub(super) fn is_with_plane(&self) -> bool {
        plane_of(self.sides[1].body).is_some()
    }
}

impl World {
    /// What moves a body's contact spheres in the step.
    pub(super) fn mover(&self, index: u32) -> Mover<'_> {
        let body = &self.bodies[index as usize];
        let spheres = &self.models[body.model].spheres;
        let stride = spheres.stride();
        Mover {
            index,
            body,
            spheres,
            q: part(&self.modal.q, body.start, stride),
            end_q: part(&self.modal.end_q, body.start, stride),
        }
    }

    /// A sphere of a body against one of another, if they touch or may touch within the step; the first one's center
    /// is at `start_a` at its beginning, and `near` is by how much their distance may become smaller within it.
    #[inline]
    pub(super) fn touch(
        &self,
        [a, b]: [&Mover<'_>; 2],
        [sphere_a, sphere_b]: [usize; 2],
        start_a: Vector3<f64>,
        near: f64,
    ) -> Option<Contact> {
        let reach = a.spheres.radius(sphere_a) + b.spheres.radius(sphere_b);
        let starts = [start_a, b.start(sphere_b)];
        let start = starts[0] - starts[1];
        if start.norm_squared() > (reach + near) * (reach + near) {
            return None;
        }
        let ends = [a.end(sphere_a), b.end(sphere_b)];
        let apart = [start, ends[0] - ends[1]];
        let (normal, [before, free]) = meeting(apart, reach)?;
        let radius = b.spheres.radius(sphere_b);
        let apart = (apart[0] + apart[1]) * 0.5;
        let middle = normal * normal.dot(&apart).max(0.0).min(reach);
        let meeting = Meeting {
            normal,
            point: (starts[1] + ends[1]) * 0.5 + middle * (radius / reach),
            overlaps: [before, free],
            radius: radius.max(reach - radius),
        };
        let first = self.material(a, sphere_a, [starts[0], ends[0]]);
        let second = self.material(b, sphere_b, [starts[1], ends[1]]);
        self.contact(&meeting, &first, Some(&second), second.side)
    }

    /// A sphere of a body against a plane.
    pub(super) fn touch_plane(
        &self,
        of: &Mover<'_>,
        sphere: usize,
        index: usize,
    ) -> Option<Contact> {
        let Plane { normal, offset } = self.planes[index];
        let normal = Vector3::from(normal);
        let radius = of.spheres.radius(sphere);
        let centers = [of.start(sphere), of.end(sphere)];
        let overlaps = centers.map(|center| radius + offset - normal.dot(&center));
        let way = (centers[1] - centers[0]).norm();
        if !(overlaps[0] > 0.0 || overlaps[1] > -NEAR * (way + 1e-3 * radius)) {
            return None;
        }
        let middle = (centers[0] + centers[1]) * 0.5;
        let meeting = Meeting {
            normal,
            point: middle - normal * (normal.dot(&middle) - offset),
            overlaps,
            radius,
        };
        let first = self.material(of, sphere, centers);
        self.contact(&meeting, &first, None, Side::plane(index))
    }

    pub(super) fn material<'w>(
        &self,
        of: &Mover<'w>,
        sphere: usize,
        way: [Vector3<f64>; 2],
    ) -> Material<'w> {
        Material {
            side: Side {
                body: of.index,
                sphere: sphere as u32,
            },
            body: of.body,
            way,
            field: of.spheres.field(sphere),
            inverse_mass: self.inverse_mass(of.body, sphere),
        }
    }

    /// The contact of two bodies, or of a body and a plane; `None` if nothing could move either.
    pub(super) fn contact(
        &self,
        meeting: &Meeting,
        first: &Material<'_>,
        second: Option<&Material<'_>>,
        second_side: Side,
    ) -> Option<Contact> {
        let Meeting {
            normal,
            point,
            overlaps: [before, free],
            radius,
        } = *meeting;
        let inverse_mass = |of: &Material<'_>| of.inverse_mass;
        let mass = 1.0 / (first.inverse_mass + second.map_or(0.0, inverse_mass));
        if !mass.is_finite() {
            return None;
        }
        let arm = |of: &Material<'_>| point - of.body.middle;
        let arms = [arm(first), second.map_or(Vector3::zeros(), arm)];
        let mut together = self.compliance(first, arms[0]);
        let mut slip = self.slip(first, &point);
        if let Some(second) = second {
            let other = self.compliance(second, arms[1]);
            together.whole += other.whole;
            together.slip += other.slip;
            slip -= self.slip(second, &point);
        }
        let mut contact = Contact {
            sides: [first.side, second_side],
            slots: [Slot::default(); 2],
            fields: [None; 2],
            radius,
            mass,
            normal,
            across: tangents(&normal),
            arms,
            point,
            before,
            free,
            late: before.max(0.0),
            spring: self.options.law.spring(mass, self.options.step_s),
            response: 0.0,
            slip: [0.0; 2],
            hold: [0.0; 3],
            leak: [0.0; 2],
            after: free,
            force: [0.0; 3],
        };
        contact.respond(&together);
        contact.slip = contact.across.map(|t| t.dot(&slip));
        Some(contact)
    }

    fn inverse_mass(&self, body: &Body, sphere: usize) -> f64 {
        let [free, held] = self.models[body.model].inverse_masses[sphere];
        match body.frame {
            Frame::Free => free,
            Frame::Held => held,
            Frame::Driven => 0.0,
        }
    }

    /// What friction is to stop at a point: displacement within the step, and share of the speed of the frame at its end.
    fn slip(&self, of: &Material<'_>, point: &Vector3<f64>) -> Vector3<f64> {
        let (body, [start, end]) = (of.body, of.way);
        let h = self.part_s;
        let moved = end - start + body.spin.cross(&(point - (start + end) * 0.5)) * h;
        if body.frame == Frame::Driven {
            return moved * (1.0 + SPEED_SHARE);
        }
        let mut speed = body.end.velocity + body.spin.cross(&(point - body.middle));
        let stride = of.field.stride();
        if stride > 0 && self.models[body.model].has_slow_modes {
            let rate = part(&self.modal.end_q_rate, body.start, stride);
            speed += body.rotation * of.field.displacement(rate);
        }
        moved + speed * (SPEED_SHARE * h)
    }

    fn compliance(&self, of: &Material<'_>, arm: Vector3<f64>) -> Compliance {
        let body = of.body;
        let arm = arm.cross_matrix();
        let rigid = Matrix3::from_diagonal_element(body.per_force) - arm * body.per_torque * arm;
        let modes = match of.field.stride() {
            0 => Matrix3::zeros(),
            stride => {
                let per_force = part(&self.modal.per_force, body.start, stride);
                let axes = &body.rotation;
                axes * of.field.compliance(per_force) * axes.transpose()
            }
        };
        let slip = rigid * SLIP + modes * self.models[body.model].modal_slip();
        Compliance {
            whole: rigid + modes,
            slip,
        }
    }

    /// 1 / effective mass of a point in its heaviest direction, modes included: also of a body that sleeps, which no force moves
    /// in this step.
    pub(super) fn inverse_mass_at(&self, of: &Material<'_>, point: &Vector3<f64>) -> f64 {
        let (body, model) = (of.body, &self.models[of.body.model]);
        if body.frame == Frame::Driven {
            return 0.0;
        }
        let axes = &body.rotation;
        let mut whole = Matrix3::zeros();
        if let (Frame::Free, Some(mass)) = (body.frame, &model.mass) {
            let arm = (point - body.middle).cross_matrix();
            let inverse = Matrix3::from_diagonal(&mass.moments.map(|moment| 1.0 / moment));
            whole += Matrix3::from_diagonal_element(1.0 / mass.mass_kg)
                - arm * axes * inverse * axes.transpose() * arm;
        }
        if of.field.stride() > 0 {
            whole += axes * of.field.compliance(&model.per_mode) * axes.transpose();
        }
        whole.symmetric_eigenvalues().min().max(0.0)
    }
}

impl Contact {
    /// What forces do to overlap and slip.
    fn respond(&mut self, of: &Compliance) {
        self.response = self.normal.dot(&(of.whole * self.normal));
        let slipping = of.slip;
        let [s, t] = self.across;
        let (by_s, by_t) = (slipping * s, slipping * t);
        let (ss, tt, st) = (s.dot(&by_s), t.dot(&by_t), s.dot(&by_t));
        let determinant = ss * tt - st * st;
        self.hold = if determinant > 0.0 {
            [tt / determinant, ss / determinant, -st / determinant]
        } else {
            [0.0; 3]
        };
        let along = slipping * self.normal;
        self.leak = self.across.map(|t| t.dot(&along));
    }
}

/// The normal along which two spheres push each other and their overlaps along it at the beginning and the end, if they
/// touch; `apart` is from the second to the first center then, `reach` the sum of the radii.
fn meeting([start, end]: [Vector3<f64>; 2], reach: f64) -> Option<(Vector3<f64>, [f64; 2])> {
    let way = end - start;
    let from = start.norm();
    if from >= reach {
        // They are apart. Where they first touch says along what they push each other: bodies that would pass through
        // each other within the step are stopped too.
        let (a, b, c) = (
            way.norm_squared(),
            start.dot(&way),
            from * from - reach * reach,
        );
        let inside = b * b - a * c;
        let at = if b < 0.0 && inside > 0.0 {
            c / (-b + libm::sqrt(inside))
        } else {
            f64::INFINITY
        };
        if !(at < 1.0) {
            // Other contacts may yet push them together.
            let gap = end.norm() - reach;
            if !(gap < NEAR * (libm::sqrt(a) + 1e-3 * reach)) {
                return None;
            }
            let normal = end / (gap + reach);
            return Some((normal, [reach - from, -gap]));
        }
        let normal = (start + way * at).normalize();
        return Some((
            normal,
            [reach - normal.dot(&start), reach - normal.dot(&end)],
        ));
    }
    // Along both together: the distance changes by that component of the displacement (Simo and Gonzalez), as long as
    // the centers do not pass each other.
    let middle = (start + end).try_normalize(1e-9 * reach);
    let normal = match middle {
        Some(middle) if 2.0 * middle.dot(&start) >= from => middle,
        _ => start.try_normalize(1e-9 * reach).unwrap_or(Vector3::y()),
    };
    let free = if normal.dot(&end) > 0.0 {
        end.norm()
    } else {
        normal.dot(&end)
    };
    Some((normal, [reach - from, reach - free]))
}
