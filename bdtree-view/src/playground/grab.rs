//! Pushing bodies where the pointer is: a material point of the surface, a damped spring that holds it, and a push.

use bdtree_dynamics::{BodyId, DynamicsError, RigidMass, World};
use bdtree_runtime::{CacheSize, Instance, RayIntersection, TriangleId};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::simulation::Simulation;

/// ω of the spring with the body's mass, rad/s: a body that hangs in it is g/ω² = 2.5 cm below the pointer.
const OMEGA_RAD_S: f64 = 20.0;
/// Its damping ratio.
const DAMPING: f64 = 0.8;
/// The spring pulls as if the pointer were at most so many reaches of the body away: 20 times its weight for one of 0.5 m.
const STRETCH: f64 = 1.0;
/// What is held turns ever slower, 1/s: nobody's hand lets things spin.
const SPIN_DECAY_PER_S: f64 = 3.0;

/// A point of the surface of a body, and how it gives way.
#[derive(Debug)]
pub(super) struct Point {
    body: BodyId,
    triangle: TriangleId,
    barycentric: [f64; 3],
    /// The body as it is at the beginning of a step.
    instance: Instance,
    mass: RigidMass,
    scale: f64,
    /// How far the body reaches, m.
    reach: f64,
    /// 1/m of each mode that moves, in world units.
    inverse_masses: Vec<f64>,
}

/// Where a [`Point`] is.
struct Now {
    /// World.
    at: Vector3<f64>,
    /// From the center of mass.
    arm: Vector3<f64>,
    /// Of the body's rigid motion there, m/s.
    velocity: Vector3<f64>,
    /// Acceleration over force there, 1/kg: of frame and modes.
    compliance: Matrix3<f64>,
}

impl Point {
    /// What a ray has met.
    ///
    /// # Errors
    /// In words: a body that is not there.
    pub(super) fn new(
        simulation: &Simulation,
        body: BodyId,
        hit: &RayIntersection,
    ) -> Result<Self, String> {
        let kind = simulation.kind_of(body).ok_or("there is no such body")?;
        let able = kind.able.as_ref().map_err(Clone::clone)?;
        let instance = Instance::with_cache(&kind.model, CacheSize::NONE);
        let scale = simulation.settings().scale;
        let moving = simulation.world().model_of(body);
        let moving = moving.map_err(|error| error.to_string())?.mode_count();
        let modes = kind.model.asset().modes().iter().take(moving);
        Ok(Self {
            body,
            triangle: hit.triangle,
            barycentric: hit.barycentric,
            instance: instance.map_err(|error| error.to_string())?,
            mass: able.mass,
            scale,
            reach: able.reach,
            inverse_masses: modes
                .map(|mode| 1.0 / (mode.modal_mass_kg.get() * scale * scale))
                .collect(),
        })
    }

    /// Where it is now.
    fn look(&mut self, world: &World) -> Result<Now, DynamicsError> {
        let mut q = vec![0.0; self.inverse_masses.len()];
        world.q(self.body, &mut q)?;
        let mut of_asset = vec![0.0_f32; self.instance.q().len()];
        for (to, from) in of_asset.iter_mut().zip(&q) {
            *to = *from as f32;
        }
        let placement = world.placement(self.body)?;
        self.instance.set_pose(&of_asset, placement)?;
        let corners = self.instance.pose().deformed_triangle(self.triangle)?;
        let weighted = corners.iter().zip(self.barycentric);
        let at: Vector3<f64> = weighted.map(|(x, w)| Vector3::from(*x) * w).sum();
        let state = world.state(self.body)?;
        let arm = at - Vector3::from(state.position);
        let spin = Vector3::from(world.angular_velocity(self.body)?);
        Ok(Now {
            at,
            arm,
            velocity: Vector3::from(state.velocity) + spin.cross(&arm),
            compliance: self.compliance(state.orientation, arm)?,
        })
    }

    /// 1/m − [r] I⁻¹ [r] + U M⁻¹ Uᵀ.
    fn compliance(
        &self,
        [x, y, z, w]: [f64; 4],
        arm: Vector3<f64>,
    ) -> Result<Matrix3<f64>, DynamicsError> {
        let axes = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)).to_rotation_matrix();
        let moments = self.mass.moments * (self.scale * self.scale);
        let inverse = Matrix3::from_diagonal(&moments.map(|moment| 1.0 / moment));
        let r = arm.cross_matrix();
        let mut sum = Matrix3::from_diagonal_element(1.0 / self.mass.mass_kg)
            - r * (axes * inverse * axes.inverse()) * r;
        let along = |axis: Vector3<f64>| self.modal(axis);
        let [x, y, z] = [
            along(Vector3::x())?,
            along(Vector3::y())?,
            along(Vector3::z())?,
        ];
        for (mode, inverse) in self.inverse_masses.iter().enumerate() {
            let u = Vector3::new(x[mode], y[mode], z[mode]);
            sum += u * u.transpose() * *inverse;
        }
        Ok(sum)
    }

    /// Uᵀ f at the point, for the asset's modes.
    fn modal(&self, force: Vector3<f64>) -> Result<Vec<f64>, DynamicsError> {
        let mut out = vec![0.0; self.instance.q().len()];
        let pose = self.instance.pose();
        pose.add_generalized_force(self.triangle, self.barycentric, force.into(), &mut out)?;
        Ok(out)
    }

    /// A force there (N), and a torque, for the step to come.
    fn push(
        &self,
        world: &mut World,
        now: &Now,
        force: Vector3<f64>,
        torque: Vector3<f64>,
    ) -> Result<(), DynamicsError> {
        let torque = torque + now.arm.cross(&force);
        world.add_force(self.body, force.into(), torque.into())?;
        let modal = self.modal(force)?;
        world.add_modal_force(self.body, &modal[..self.inverse_masses.len()])
    }

    /// Pushes so hard within the next step that the point alone would get that much faster (m/s).
    ///
    /// # Errors
    /// A body that is not there.
    pub(super) fn poke(
        &mut self,
        world: &mut World,
        change: Vector3<f64>,
    ) -> Result<(), DynamicsError> {
        let now = self.look(world)?;
        let size = change.norm();
        if !(size > 0.0) {
            return Ok(());
        }
        let direction = change / size;
        let mass = 1.0 / direction.dot(&(now.compliance * direction));
        let force = change * (mass / world.options().step_s);
        self.push(world, &now, force, Vector3::zeros())
    }
}

/// A spring from a point of a body to where the pointer is.
#[derive(Debug)]
pub struct Grab {
    point: Point,
    /// Where the pointer is (world).
    pub(super) target: Vector3<f64>,
    /// Where the point was before, and is.
    before: Option<Vector3<f64>>,
    at: Vector3<f64>,
}

impl Grab {
    pub(super) fn new(point: Point, target: [f64; 3]) -> Self {
        Self {
            point,
            target: target.into(),
            before: None,
            at: target.into(),
        }
    }

    /// The body.
    pub fn body(&self) -> BodyId {
        self.point.body
    }

    /// From the point to the pointer.
    pub fn ends(&self) -> [[f64; 3]; 2] {
        [self.at.into(), self.target.into()]
    }

    /// Pulls for one step.
    ///
    /// The force is that of the end of the step, for the point alone: f = k (target − x₁) − c v₁ with v₁ = v + h C f and
    /// x₁ = x + h v₁. So the spring is stable however light the part is that it pulls.
    ///
    /// # Errors
    /// A body that is not there.
    pub(super) fn pull(&mut self, world: &mut World) -> Result<(), DynamicsError> {
        let h = world.options().step_s;
        let now = self.point.look(world)?;
        // Of the material point, as modes move it too.
        let velocity = match self.before {
            Some(before) => (now.at - before) / h,
            None => now.velocity,
        };
        self.before = Some(now.at);
        self.at = now.at;
        let mass = self.point.mass.mass_kg;
        let (k, c) = (
            mass * OMEGA_RAD_S * OMEGA_RAD_S,
            2.0 * DAMPING * OMEGA_RAD_S * mass,
        );
        let away = self.target - now.at;
        let most = STRETCH * self.point.reach;
        let away = away * (most / away.norm().max(most));
        let wanted = away * k - velocity * (k * h + c);
        let system = Matrix3::identity() + now.compliance * (h * (k * h + c));
        let force = system.lu().solve(&wanted).unwrap_or_default();
        let spin = Vector3::from(world.state(self.point.body)?.angular_momentum);
        let torque = spin * -SPIN_DECAY_PER_S;
        self.point.push(world, &now, force, torque)
    }
}
