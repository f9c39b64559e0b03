//! One pair of contact spheres in a step, linearised: how far apart they are at its beginning and, without forces, at its
//! end, and what forces do to that.

use nalgebra::{Matrix3, Vector3};

use super::body::{Body, Frame};
use super::{Plane, World, part, tangents};
use crate::contact_law::Spring;

/// A sphere of a body, or a plane.
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

/// What happens at a pair of contact spheres in a step. World coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactRecord {
    /// The bodies; the second is `None` for a plane.
    pub bodies: [Option<usize>; 2],
    /// The spheres of their models.
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
/// displacement alone, a body that friction holds would swing from step to step.
const SPEED_SHARE: f64 = 1.0;

/// Pairs that do not touch by themselves are looked at if their gap at the end is below this share of how they move.
const NEAR: f64 = 1.0;

#[derive(Debug, Clone)]
pub(super) struct Contact {
    pub(super) sides: [Side; 2],
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

/// Compliance of the rigid motion and of the modes at a point.
struct Compliance {
    rigid: Matrix3<f64>,
    modes: Matrix3<f64>,
}

impl Contact {
    pub(super) fn record(&self) -> ContactRecord {
        let [first, second] = self.sides;
        let is_plane = second.body > u32::MAX / 2;
        ContactRecord {
            bodies: [
                Some(first.body as usize),
                (!is_plane).then_some(second.body as usize),
            ],
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

    pub(super) fn is_with_plane(&self) -> bool {
        self.sides[1].body > u32::MAX / 2
    }
}

impl World {
    /// A sphere of a body against one of another, if they touch at the beginning or at the end without forces; `near` is by
    /// how much less than that sum of their radii their centers' distance can become within the step.
    pub(super) fn touch(&self, sides: [Side; 2], near: f64) -> Option<Contact> {
        let bodies = sides.map(|side| &self.bodies[side.body as usize]);
        let sphere = sides.map(|side| side.sphere as usize);
        let radius = [0, 1].map(|k| self.models[bodies[k].model].spheres.radius(sphere[k]));
        let reach = radius[0] + radius[1];
        let starts = [0, 1].map(|k| self.center(bodies[k], sphere[k], 0));
        let start = starts[0] - starts[1];
        if start.norm_squared() > (reach + near) * (reach + near) {
            return None;
        }
        let ends = [0, 1].map(|k| self.center(bodies[k], sphere[k], 1));
        let apart = [start, ends[0] - ends[1]];
        let (normal, [before, free]) = meeting(apart, reach)?;
        let middle = normal
            * (0.5 * normal.dot(&(apart[0] + apart[1])))
                .max(0.0)
                .min(reach);
        let center = (starts[1] + ends[1]) * 0.5;
        let point = center + middle * (radius[1] / reach);
        let [a, b] = [0, 1].map(|k| self.inverse_mass(bodies[k], sphere[k]));
        let mass = 1.0 / (a + b);
        if !mass.is_finite() {
            return None; // nothing could move either
        }
        let mut contact = self.linearised(sides, normal, point, before, free, mass);
        let own = self.compliance(&contact, 0, &bodies[0].rotation);
        let other = self.compliance(&contact, 1, &bodies[1].rotation);
        let together = Compliance {
            rigid: own.rigid + other.rigid,
            modes: own.modes + other.modes,
        };
        contact.respond(&together);
        let [a, b] = [0, 1].map(|k| self.slip(bodies[k], [starts[k], ends[k]], &point));
        let slip = a - b;
        contact.slip = contact.across.map(|t| t.dot(&slip));
        Some(contact)
    }

    /// A sphere of a body against a plane.
    pub(super) fn touch_plane(&self, side: Side, index: usize) -> Option<Contact> {
        let Plane { normal, offset } = self.planes[index];
        let normal = Vector3::from(normal);
        let body = &self.bodies[side.body as usize];
        let sphere = side.sphere as usize;
        let radius = self.models[body.model].spheres.radius(sphere);
        let centers = [0, 1].map(|end| self.center(body, sphere, end));
        let [before, free] = centers.map(|center| radius + offset - normal.dot(&center));
        let way = (centers[1] - centers[0]).norm();
        if !(before > 0.0 || free > -NEAR * (way + 1e-3 * radius)) {
            return None;
        }
        let middle = (centers[0] + centers[1]) * 0.5;
        let point = middle - normal * (normal.dot(&middle) - offset);
        let mass = 1.0 / self.inverse_mass(body, sphere);
        if !mass.is_finite() {
            return None;
        }
        let sides = [side, Side::plane(index)];
        let mut contact = self.linearised(sides, normal, point, before, free, mass);
        contact.respond(&self.compliance(&contact, 0, &body.rotation));
        let slip = self.slip(body, centers, &point);
        contact.slip = contact.across.map(|t| t.dot(&slip));
        Some(contact)
    }

    fn linearised(
        &self,
        sides: [Side; 2],
        normal: Vector3<f64>,
        point: Vector3<f64>,
        before: f64,
        free: f64,
        mass: f64,
    ) -> Contact {
        let arm = |side: Side| match self.bodies.get(side.body as usize) {
            Some(body) => point - body.middle,
            None => Vector3::zeros(),
        };
        Contact {
            sides,
            normal,
            across: tangents(&normal),
            arms: sides.map(arm),
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
        }
    }

    /// Center of a contact sphere at the beginning (0) or at the free end (1) of the step.
    #[inline]
    fn center(&self, body: &Body, sphere: usize, end: usize) -> Vector3<f64> {
        let spheres = &self.models[body.model].spheres;
        let all = [&self.modal.q, &self.modal.end_q][end];
        let own = spheres.center(sphere, part(all, body.start, spheres.stride()));
        [body.state.position, body.end.position][end] + body.rotations[end] * own
    }

    fn inverse_mass(&self, body: &Body, sphere: usize) -> f64 {
        let [free, held] = self.models[body.model].inverse_masses[sphere];
        match body.frame {
            Frame::Free => free,
            Frame::Held => held,
            Frame::Driven => 0.0,
        }
    }

    /// What friction is to stop at a point of a sphere's body: displacement within the step, and share of the speed of the
    /// frame at its end.
    fn slip(&self, body: &Body, centers: [Vector3<f64>; 2], point: &Vector3<f64>) -> Vector3<f64> {
        let h = self.options.step_s;
        let middle = (centers[0] + centers[1]) * 0.5;
        let moved = centers[1] - centers[0] + body.spin.cross(&(point - middle)) * h;
        let speed = body.end.velocity + body.spin.cross(&(point - body.middle));
        moved + speed * (SPEED_SHARE * h)
    }

    fn compliance(&self, contact: &Contact, side: usize, axes: &Matrix3<f64>) -> Compliance {
        let body = &self.bodies[contact.sides[side].body as usize];
        let model = &self.models[body.model];
        let arm = contact.arms[side].cross_matrix();
        let rigid = Matrix3::from_diagonal_element(body.per_force) - arm * body.per_torque * arm;
        let stride = model.spheres.stride();
        if stride == 0 {
            return Compliance {
                rigid,
                modes: Matrix3::zeros(),
            };
        }
        let per_force = part(&self.modal.per_force, body.start, stride);
        let sphere = contact.sides[side].sphere as usize;
        let [xx, yy, zz, xy, xz, yz] = model.spheres.compliance(sphere, per_force);
        let own = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        Compliance {
            rigid,
            modes: axes * own * axes.transpose(),
        }
    }
}

impl Contact {
    /// What forces do to overlap and slip.
    fn respond(&mut self, of: &Compliance) {
        let whole = of.rigid + of.modes;
        self.response = self.normal.dot(&(whole * self.normal));
        let slipping = of.rigid * (1.0 + 2.0 * SPEED_SHARE) + of.modes;
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

/// Slip of a relative displacement by rigid motion and one by modes.
#[inline]
pub(super) fn slipping(rigid: Vector3<f64>, modes: Vector3<f64>) -> Vector3<f64> {
    rigid * (1.0 + 2.0 * SPEED_SHARE) + modes
}
