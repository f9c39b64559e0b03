//! What bodies of one kind have in common: asset, mass, modes, contact spheres.

use alloc::vec::Vec;

use bdtree_runtime::{CacheSize, Instance, Model, PoseError, Transform};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use crate::error::DynamicsError;
use crate::frame::FrameMass;
use crate::level_spheres::{LevelSpheres, usual_level};
use crate::limit::StrainLimit;
use crate::mass::{MassProperties, RigidMass};
use crate::oscillator::{Oscillator, Transition};
use crate::surface::{Surface, thinnest_wall};
use crate::world::SLIP;

/// How modes lose energy.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Damping {
    /// The same damping ratio ζ for all modes: γ = ζ ω.
    Ratio(f64),
    /// Rayleigh damping α M + β K: γ = (α + β ω²) / 2.
    Rayleigh {
        /// α, 1/s.
        mass_per_s: f64,
        /// β, s.
        stiffness_s: f64,
    },
}

impl Damping {
    /// γ of a mode.
    pub fn decay_per_s(&self, omega_rad_s: f64) -> f64 {
        match *self {
            Self::Ratio(ratio) => ratio * omega_rad_s,
            Self::Rayleigh {
                mass_per_s,
                stiffness_s,
            } => 0.5 * (mass_per_s + stiffness_s * omega_rad_s * omega_rad_s),
        }
    }

    /// A mode of this frequency.
    pub fn oscillator(&self, omega_rad_s: f64) -> Oscillator {
        Oscillator {
            omega_rad_s,
            decay_per_s: self.decay_per_s(omega_rad_s),
        }
    }
}

/// What of a body touches others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum ContactShape {
    /// The spheres of a level of its tree.
    #[default]
    Spheres,
    /// Its triangles, exactly deformed, from both sides: for parts thinner than spheres of a level. Contact spheres of other
    /// bodies meet them; planes, and bodies that have this shape too, meet its spheres.
    Triangles,
    /// Its triangles, exactly deformed, as the skin of a solid: where two such bodies overlap, their regions of contact
    /// ([`PairQuery::contact_manifolds`](bdtree_runtime::PairQuery::contact_manifolds)) push, and planes meet its vertices. The
    /// surface must be closed. Steps of a world with such bodies are divided, so that within a part no vertex moves by more
    /// than half the thinnest wall. Bodies of other shapes meet its contact spheres.
    Regions,
}

/// How bodies of an asset are made.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyOptions {
    /// World units per mesh unit; default 1. Worlds count in meters where forces are newtons.
    pub scale: f64,
    /// Mass properties, which only free bodies need; default those of the asset.
    pub mass: Option<MassProperties>,
    /// Level of the contact spheres; default the one that has about a thousand.
    pub level: Option<usize>,
    /// Thickness of the thinnest wall of a body of the shape [`ContactShape::Regions`], world units; default what rays from
    /// the middle of each triangle straight inwards find at rest, which near a sharp edge is little.
    pub thinnest_wall: Option<f64>,
    /// What touches others; default the contact spheres.
    pub contact: ContactShape,
    /// Whether the modes move; default true. Without, q stays 0.
    pub is_deformable: bool,
    /// Whether trees of a body whose modes do not move are updated as if they did; default false. It changes nothing but the
    /// time that steps take, and rarely in which step a pair of spheres is found: for comparisons. (Modes at exactly 0 cost node bounds nothing.)
    pub has_redundant_updates: bool,
    /// Default a ratio of 0.05.
    pub damping: Damping,
    /// Strain limit in multiples of each mode's `q_range`, which elastic bakes take as 5 % of the mesh's diagonal; never
    /// above `q_limit`. Infinite for `q_limit`. Default 1.
    pub strain_limit: f64,
}

/// The step resolves modes up to this ωh: forces add to their speed as they do to that of a frame, within 8 %.
const SLOW: f64 = 1.0;

/// Of each mode's `q_range`: enough that node bounds take the mode into account, which leave out those at 0.
const REDUNDANT_SHARE: f32 = 1e-6;

impl Default for BodyOptions {
    fn default() -> Self {
        Self {
            scale: 1.0,
            mass: None,
            level: None,
            thinnest_wall: None,
            contact: ContactShape::Spheres,
            is_deformable: true,
            has_redundant_updates: false,
            damping: Damping::Ratio(0.05),
            strain_limit: 1.0,
        }
    }
}

/// A mode of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Mode {
    pub(crate) oscillator: Oscillator,
    pub(crate) transition: Transition,
    /// Modal mass in world units: kg for q in world units.
    pub(crate) mass: f64,
    /// Momentum of the body at unit rate, in its frame: what gravity does to the mode.
    pub(crate) momentum: Vector3<f64>,
    pub(crate) limit: StrainLimit,
}

impl Mode {
    /// What it does in a part of a step, or in the whole.
    ///
    /// # Errors
    /// Those of [`Oscillator::transition`].
    #[inline]
    pub(crate) fn transition_of(
        &self,
        part_s: f64,
        whole_s: f64,
    ) -> Result<Transition, DynamicsError> {
        if part_s == whole_s {
            return Ok(self.transition);
        }
        self.oscillator.transition(part_s)
    }
}

/// What bodies of an asset have in common in a world.
#[derive(Debug, Clone)]
pub struct BodyModel {
    pub(crate) model: Model,
    pub(crate) scale: f64,
    /// What free bodies need.
    pub(crate) mass: Option<FrameMass>,
    /// Where the body's frame is in the mesh: center of mass (mesh units) and principal axes, or the mesh's own.
    center: Vector3<f64>,
    axes: UnitQuaternion<f64>,
    pub(crate) modes: Vec<Mode>,
    /// Whether the step resolves all modes.
    pub(crate) has_slow_modes: bool,
    /// The first mode that has no frequency or modal mass: only the caller can move it.
    pub(crate) silent_mode: Option<usize>,
    pub(crate) spheres: LevelSpheres,
    pub(crate) contact: ContactShape,
    /// Where triangles touch others.
    pub(crate) surface: Option<Surface>,
    /// Infinite where regions of contact do not matter.
    pub(crate) wall: f64,
    /// What the trees of a rigid body with redundant updates are posed with, else empty, and by how much that moves any
    /// point at most, world units.
    pub(crate) redundant_q: Vec<f32>,
    pub(crate) redundant_move: f64,
    /// Acceleration of each mode's q by a unit force, over a step from rest; padded.
    pub(crate) per_mode: Vec<f64>,
    /// 1 / effective mass of each sphere in its heaviest direction: of a free body and of a held one, modes included.
    pub(crate) inverse_masses: Vec<[f64; 2]>,
}

impl BodyModel {
    /// # Errors
    /// Options beyond their limits; a skin; a damaged asset.
    pub(crate) fn new(
        model: &Model,
        options: &BodyOptions,
        step_s: f64,
    ) -> Result<Self, DynamicsError> {
        let asset = model.asset();
        let scale = options.scale;
        if asset.has_skin() {
            return Err(DynamicsError::Skin);
        }
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(PoseError::Scale.into());
        }
        let mass = options.mass.or_else(|| MassProperties::of(asset));
        let mass = mass.map(|mass| mass.rigid()).transpose()?;
        let level = options.level.unwrap_or_else(|| usual_level(asset));
        if level >= asset.depth() {
            return Err(DynamicsError::Level {
                level,
                depth: asset.depth(),
            });
        }
        if !(options.strain_limit > 0.0) {
            return Err(DynamicsError::Setting {
                name: "strain_limit",
                value: options.strain_limit,
                limit: f64::INFINITY,
            });
        }
        let (center, axes) = match &mass {
            Some(RigidMass { center, axes, .. }) => (*center, *axes),
            None => (Vector3::zeros(), UnitQuaternion::identity()),
        };
        let (mut modes, mut silent_mode) = (Vec::new(), None);
        if options.is_deformable {
            for (mode, record) in asset.modes().iter().enumerate() {
                let (mut omega_rad_s, mut kg) =
                    (record.omega_rad_s.get(), record.modal_mass_kg.get());
                if !(omega_rad_s >= 0.0 && kg > 0.0) {
                    // That of an animation: no force moves it.
                    (omega_rad_s, kg) = (0.0, f64::INFINITY);
                    silent_mode = silent_mode.or(Some(mode));
                }
                let oscillator = options.damping.oscillator(omega_rad_s);
                let momentum = match asset.mode_momenta().and_then(|all| all.get(mode)) {
                    Some(record) => axes.inverse() * Vector3::from(record.linear.map(|x| x.get())),
                    None => Vector3::zeros(),
                };
                modes.push(Mode {
                    momentum: momentum * scale,
                    oscillator,
                    transition: oscillator.transition(step_s)?,
                    mass: kg * scale * scale,
                    limit: StrainLimit::of_mode(record, options.strain_limit),
                });
            }
        }
        let (mut redundant_q, mut redundant_move) = (Vec::new(), 0.0);
        if options.has_redundant_updates && !options.is_deformable {
            for record in asset.modes() {
                let q = record.q_range.get() * REDUNDANT_SHARE;
                redundant_move += f64::from(q * record.field_norm_max.get());
                redundant_q.push(q);
            }
            redundant_move *= asset.unit() * scale * (1.0 + 1e-6);
        }
        let to_axes = axes.inverse();
        let spheres = LevelSpheres::new(
            asset,
            level,
            options.is_deformable,
            scale,
            |p| to_axes * ((p - center) * scale),
            |u| to_axes * (u * scale),
        )?;
        let surface = match options.contact {
            ContactShape::Spheres => None,
            ContactShape::Triangles | ContactShape::Regions => {
                let sizes = [spheres.mode_count(), spheres.stride()];
                Some(Surface::new(model, scale, center, axes, sizes)?)
            }
        };
        let wall = match (options.contact, options.thinnest_wall) {
            (ContactShape::Regions, Some(wall)) if wall > 0.0 && wall.is_finite() => {
                thinnest_wall(model)?;
                wall
            }
            (ContactShape::Regions, Some(wall)) => {
                return Err(DynamicsError::Setting {
                    name: "thinnest_wall",
                    value: wall,
                    limit: f64::MAX,
                });
            }
            (ContactShape::Regions, None) => thinnest_wall(model)? * scale,
            _ => f64::INFINITY,
        };
        let mut made = Self {
            model: model.clone(),
            scale,
            mass: mass.map(|mass| FrameMass {
                mass_kg: mass.mass_kg,
                moments: mass.moments * (scale * scale),
            }),
            center,
            axes,
            has_slow_modes: modes
                .iter()
                .all(|mode| mode.oscillator.omega_rad_s * step_s <= SLOW),
            modes,
            silent_mode,
            spheres,
            contact: options.contact,
            surface,
            wall,
            redundant_q,
            redundant_move,
            per_mode: Vec::new(),
            inverse_masses: Vec::new(),
        };
        let per_step = 2.0 / (step_s * step_s);
        made.per_mode = made.padded(|mode| mode.transition.q_a / mode.mass * per_step);
        made.inverse_masses = (0..made.spheres.len())
            .map(|sphere| {
                let modes = made.spheres.field(sphere).compliance(&made.per_mode);
                let rigid = made.rigid_compliance(sphere);
                [rigid + modes, modes].map(|of| of.symmetric_eigenvalues().min().max(0.0))
            })
            .collect();
        Ok(made)
    }

    /// Slip over displacement of modes.
    #[inline]
    pub(crate) fn modal_slip(&self) -> f64 {
        if self.has_slow_modes { SLIP } else { 1.0 }
    }

    /// Largest distance from the center of mass at rest of what touches others.
    pub(crate) fn extent(&self) -> f64 {
        let surface = self.surface.as_ref().map_or(0.0, |surface| surface.extent);
        self.spheres.extent.max(surface)
    }

    /// How far what touches others moves at most when q changes by `change`: roughly where that is less than `little`.
    pub(crate) fn moved(&self, change: &[f64], little: f64) -> f64 {
        let size = libm::sqrt(change.iter().map(|x| x * x).sum());
        let mut most = self.spheres.moved_within(size);
        if most > little {
            most = self.spheres.moved(change);
        }
        let surface = self.surface.as_ref().map(|surface| surface.moved(change));
        most.max(surface.unwrap_or_default())
    }

    /// No part of what touches others is farther from its place at rest for any q of length `size`.
    pub(crate) fn moved_within(&self, size: f64) -> f64 {
        let surface = (self.surface.as_ref()).map(|surface| surface.moved_within(size));
        (self.spheres.moved_within(size)).max(surface.unwrap_or_default())
    }

    /// Acceleration of a sphere's center by a force there: 1/m − [r] I⁻¹ [r].
    fn rigid_compliance(&self, sphere: usize) -> Matrix3<f64> {
        let Some(mass) = &self.mass else {
            return Matrix3::zeros();
        };
        let r = self.spheres.rest_center(sphere).cross_matrix();
        let inverse = Matrix3::from_diagonal(&mass.moments.map(|moment| 1.0 / moment));
        Matrix3::from_diagonal_element(1.0 / mass.mass_kg) - r * inverse * r
    }

    /// One number per mode, padded with zeros.
    fn padded(&self, of: impl Fn(&Mode) -> f64) -> Vec<f64> {
        let mut all: Vec<f64> = self.modes.iter().map(of).collect();
        all.resize(self.spheres.stride(), 0.0);
        all
    }

    /// The first mode that moves the center of mass or turns the body: one of a held body, which no free body vibrates in.
    ///
    /// Free bodies' modes have no momentum but for rounding and the mesh being coarser than what it moves with.
    pub(crate) fn held_mode(&self) -> Option<usize> {
        const SHARE: f64 = 1e-2;
        let mass = self.mass?;
        let momenta = self.model.asset().mode_momenta()?;
        let size = |v: [f64; 3]| Vector3::from(v).norm();
        self.modes.iter().zip(momenta).position(|(mode, of)| {
            // |∫ u dm|² ≤ ∫ dm ∫ |u|² dm, and the same for moments.
            let linear = size(of.linear.map(|x| x.get())) * self.scale;
            let angular = size(of.angular.map(|x| x.get())) * self.scale * self.scale;
            linear > SHARE * libm::sqrt(mass.mass_kg * mode.mass)
                || angular > SHARE * libm::sqrt(mass.moments.max() * mode.mass)
        })
    }

    /// The asset.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Number of modes that move; 0 for a rigid body.
    pub fn mode_count(&self) -> usize {
        self.modes.len()
    }

    /// Thickness of the thinnest wall, world units; `None` unless the contact shape is [`ContactShape::Regions`].
    pub fn thinnest_wall(&self) -> Option<f64> {
        self.wall.is_finite().then_some(self.wall)
    }

    /// The contact spheres.
    pub fn spheres(&self) -> &LevelSpheres {
        &self.spheres
    }

    /// kg; `None` without mass properties.
    pub fn mass_kg(&self) -> Option<f64> {
        self.mass.map(|mass| mass.mass_kg)
    }

    /// Where the mesh is when the center of mass is at `position` and the principal axes are turned by `orientation`.
    pub(crate) fn placement(
        &self,
        position: Vector3<f64>,
        orientation: UnitQuaternion<f64>,
    ) -> Transform {
        let rotation = orientation * self.axes.inverse();
        let translation = position - rotation * (self.center * self.scale);
        let [x, y, z, w] = <[f64; 4]>::from(rotation.coords);
        Transform {
            rotation: [x, y, z, w],
            translation: translation.into(),
            scale: self.scale,
        }
    }

    /// Position and orientation of the body's frame for a placement of the mesh.
    pub(crate) fn frame(&self, at: &Transform) -> (Vector3<f64>, UnitQuaternion<f64>) {
        let [x, y, z, w] = at.rotation;
        let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        let position = Vector3::from(at.translation) + rotation * (self.center * self.scale);
        (position, rotation * self.axes)
    }

    /// Down to the level of the contact spheres.
    pub(crate) fn cache_size(&self) -> CacheSize {
        CacheSize::to_level(self.model.asset(), self.spheres.level)
    }

    /// An instance without a step cache: those of a world are apart, so that threads can share instances.
    pub(crate) fn instance(&self) -> Result<Instance, PoseError> {
        Instance::with_cache(&self.model, CacheSize::NONE)
    }
}
