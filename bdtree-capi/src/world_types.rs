//! How worlds and bodies are made, and what steps tell.

use bdtree_dynamics::{
    BodyOptions, BodyState, ContactLaw, ContactRecord, ContactShape, Damping, Energy, Event, Phase,
    StepReport, StepTimes, WorldOptions,
};
use zerocopy::FromBytes;

use crate::model::BdtMass;
use crate::status::Fault;
use crate::types::{BDT_NONE, BdtQuat, BdtVec3};

/// What holds for all bodies of a world; `bdt_world_defaults` writes the usual values.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtWorldOptions {
    /// Length of a step, seconds; default 1/150.
    pub step_s: f64,
    /// World units per s²; default 9.81 downwards along y.
    pub gravity: BdtVec3,
    /// Stiffness k of a contact over m / h², with the effective mass m of what meets and the step h: 0 to 1000; default 1.
    pub stiffness: f64,
    /// Of a contact: 0 to 10; default 0.2.
    pub damping_ratio: f64,
    /// Coulomb's coefficient: 0 to 10; default 0.4.
    pub friction: f64,
    /// Sweeps over the contacts end when one changes forces by less than this share: 0 to 1; default 1e-3.
    pub accuracy: f64,
    /// World units per second: bodies that have been slower for half a second fall asleep; 0: never. Default 0.01.
    pub sleep_speed: f64,
    /// Most sweeps over the contacts in a step; default 50.
    pub sweeps: u32,
    /// Threads that step, 1 to 256; default 1. The answers are the same for any number.
    pub threads: u32,
}

impl From<WorldOptions> for BdtWorldOptions {
    fn from(options: WorldOptions) -> Self {
        Self {
            step_s: options.step_s,
            gravity: options.gravity.into(),
            stiffness: options.law.stiffness,
            damping_ratio: options.law.damping_ratio,
            friction: options.law.friction,
            accuracy: options.accuracy,
            sleep_speed: options.sleep_speed,
            sweeps: options.sweeps as u32,
            threads: options.threads as u32,
        }
    }
}

impl From<BdtWorldOptions> for WorldOptions {
    fn from(options: BdtWorldOptions) -> Self {
        Self {
            step_s: options.step_s,
            gravity: options.gravity.into(),
            law: ContactLaw {
                stiffness: options.stiffness,
                damping_ratio: options.damping_ratio,
                friction: options.friction,
            },
            sweeps: options.sweeps as usize,
            accuracy: options.accuracy,
            sleep_speed: options.sleep_speed,
            threads: options.threads as usize,
        }
    }
}

/// `BdtBodyOptions::contact`: the spheres of a level of its tree touch others.
pub const BDT_CONTACT_SPHERES: u32 = 0;
/// `BdtBodyOptions::contact`: its triangles touch others, from both sides: for thin parts.
pub const BDT_CONTACT_TRIANGLES: u32 = 1;
/// `BdtBodyOptions::contact`: its triangles are the skin of a solid, whose regions of contact push.
pub const BDT_CONTACT_REGIONS: u32 = 2;

/// How bodies of a model are made; `bdt_body_defaults` writes the usual values.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtBodyOptions {
    /// World units per mesh unit; default 1.
    pub scale: f64,
    /// Mass properties, if `has_mass` is not 0; else those of the model.
    pub mass: BdtMass,
    /// Thickness of the thinnest wall of a body with `BDT_CONTACT_REGIONS`, world units; 0 or less (the default): found by
    /// rays.
    pub thinnest_wall: f64,
    /// Damping ratio of all modes, if `mass_per_s` and `stiffness_s` are 0; default 0.05.
    pub damping_ratio: f64,
    /// Rayleigh damping: share of the mass matrix, 1/s; default 0.
    pub mass_per_s: f64,
    /// Rayleigh damping: share of the stiffness matrix, s; default 0.
    pub stiffness_s: f64,
    /// In multiples of each mode's `q_range`; INFINITY for `q_limit`. Default 1.
    pub strain_limit: f64,
    /// Whether `mass` is used; default 0.
    pub has_mass: u32,
    /// Level of the contact spheres; `BDT_NONE` (the default): the one that has about a thousand.
    pub level: u32,
    /// `BDT_CONTACT_SPHERES` (the default), `BDT_CONTACT_TRIANGLES` or `BDT_CONTACT_REGIONS`.
    pub contact: u32,
    /// Whether the modes move; default 1.
    pub is_deformable: u32,
}

impl BdtBodyOptions {
    pub(crate) fn usual() -> Self {
        let usual = BodyOptions::default();
        Self {
            scale: usual.scale,
            mass: BdtMass {
                mass_kg: 0.0,
                center: [0.0; 3].into(),
                inertia: [0.0; 6],
            },
            thinnest_wall: 0.0,
            damping_ratio: 0.05,
            mass_per_s: 0.0,
            stiffness_s: 0.0,
            strain_limit: usual.strain_limit,
            has_mass: 0,
            level: BDT_NONE,
            contact: BDT_CONTACT_SPHERES,
            is_deformable: 1,
        }
    }
}

impl BdtBodyOptions {
    /// The library's.
    pub(crate) fn checked(&self) -> Result<BodyOptions, Fault> {
        let options = self;
        let (mass_per_s, stiffness_s) = (options.mass_per_s, options.stiffness_s);
        Ok(BodyOptions {
            scale: options.scale,
            mass: (options.has_mass != 0).then(|| options.mass.into()),
            level: (options.level != BDT_NONE).then_some(options.level as usize),
            thinnest_wall: (options.thinnest_wall > 0.0).then_some(options.thinnest_wall),
            contact: match options.contact {
                BDT_CONTACT_SPHERES => ContactShape::Spheres,
                BDT_CONTACT_TRIANGLES => ContactShape::Triangles,
                BDT_CONTACT_REGIONS => ContactShape::Regions,
                _ => return Err(Fault::Argument("contact: of no known kind")),
            },
            is_deformable: options.is_deformable != 0,
            has_redundant_updates: false,
            damping: if mass_per_s == 0.0 && stiffness_s == 0.0 {
                Damping::Ratio(options.damping_ratio)
            } else {
                Damping::Rayleigh {
                    mass_per_s,
                    stiffness_s,
                }
            },
            strain_limit: options.strain_limit,
        })
    }
}

/// Position, orientation and speeds of a body. World axes.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtBodyState {
    /// Center of mass (without mass properties the mesh's origin), world units.
    pub position: BdtVec3,
    /// From the principal axes of inertia (or the mesh's axes) to the world's.
    pub orientation: BdtQuat,
    /// World units per second.
    pub velocity: BdtVec3,
    /// About the center of mass, kg · world unit² / s.
    pub angular_momentum: BdtVec3,
    /// rad/s.
    pub angular_velocity: BdtVec3,
}

impl BdtBodyState {
    pub(crate) fn of(state: BodyState, angular_velocity: [f64; 3]) -> Self {
        Self {
            position: state.position.into(),
            orientation: state.orientation.into(),
            velocity: state.velocity.into(),
            angular_momentum: state.angular_momentum.into(),
            angular_velocity: angular_velocity.into(),
        }
    }
}

/// What a step did.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtStepReport {
    /// Pairs of contact spheres, triangles or regions in contact.
    pub contacts: u64,
    /// Of them, those that were found when they overlapped already.
    pub late: u64,
    /// Pairs of bodies, planes included, that are near each other.
    pub pairs: u64,
    /// Pairs of contact spheres that the trees found.
    pub candidates: u64,
    /// Nodes of the trees that were looked at.
    pub nodes_visited: u64,
    /// Nodes whose bounds were computed.
    pub nodes_updated: u64,
    /// Sweeps over the contacts.
    pub sweeps: u64,
    /// Parts that the step was divided into.
    pub parts: u64,
    /// Largest overlap at the beginning of the step, world units.
    pub penetration: f64,
    /// The same as a share of the larger radius.
    pub penetration_rel: f64,
    /// Energy in the contacts at the beginning of the step, J.
    pub contact_energy: f64,
    /// How long the step took, seconds by the clock.
    pub time_s: f64,
}

impl BdtStepReport {
    pub(crate) fn of(report: StepReport, times: StepTimes) -> Self {
        Self {
            contacts: report.events,
            late: report.late,
            pairs: report.pairs,
            candidates: report.candidates,
            nodes_visited: report.nodes_visited,
            nodes_updated: report.nodes_updated,
            sweeps: report.sweeps,
            parts: report.parts,
            penetration: report.penetration,
            penetration_rel: report.penetration_rel,
            contact_energy: report.contact_energy,
            time_s: times.all_s,
        }
    }
}

/// `BdtEvent::phase`: the two push each other, which they did not in the step before.
pub const BDT_BEGAN: u32 = 0;
/// `BdtEvent::phase`: the two push each other, as in the step before.
pub const BDT_TOUCHING: u32 = 1;
/// `BdtEvent::phase`: the two do not push each other any more.
pub const BDT_ENDED: u32 = 2;

/// Two bodies, or a body and a plane, in a step.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtEvent {
    /// The first body.
    pub body1: u32,
    /// The second body; `BDT_NONE` for a plane.
    pub body2: u32,
    /// `BDT_BEGAN`, `BDT_TOUCHING` or `BDT_ENDED`.
    pub phase: u32,
    /// 0.
    pub reserved: u32,
    /// What the step's contact forces have added to the first body's momentum, N s.
    pub impulse: BdtVec3,
}

impl From<Event> for BdtEvent {
    fn from(event: Event) -> Self {
        let [body1, body2] = event.bodies.map(number);
        Self {
            body1,
            body2,
            phase: match event.phase {
                Phase::Began => BDT_BEGAN,
                Phase::Touching => BDT_TOUCHING,
                Phase::Ended => BDT_ENDED,
            },
            reserved: 0,
            impulse: event.impulse.into(),
        }
    }
}

fn number(body: Option<usize>) -> u32 {
    body.map_or(BDT_NONE, |body| body as u32)
}

/// A contact of the last step.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtWorldContact {
    /// The first body.
    pub body1: u32,
    /// The second body; `BDT_NONE` for a plane.
    pub body2: u32,
    /// The first body's contact sphere or triangle.
    pub part1: u32,
    /// The second body's contact sphere or triangle; 0 of a plane.
    pub part2: u32,
    /// Where forces act.
    pub point: BdtVec3,
    /// Unit, from the second body to the first.
    pub normal: BdtVec3,
    /// Overlap at the beginning of the step, world units; negative is a gap.
    pub depth: f64,
    /// On the first body, N.
    pub force: BdtVec3,
}

impl From<ContactRecord> for BdtWorldContact {
    fn from(contact: ContactRecord) -> Self {
        let ([body1, body2], [part1, part2]) = (contact.bodies.map(number), contact.spheres);
        Self {
            body1,
            body2,
            part1: part1 as u32,
            part2: part2 as u32,
            point: contact.point.into(),
            normal: contact.normal.into(),
            depth: contact.depth,
            force: contact.force.into(),
        }
    }
}

/// Energies of a world, J where world units are meters.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtEnergy {
    /// Of the frames' motion.
    pub kinetic: f64,
    /// Of the modes: motion and deformation.
    pub modal: f64,
    /// In the field of gravity, above the world's origin.
    pub potential: f64,
}

impl From<Energy> for BdtEnergy {
    fn from(energy: Energy) -> Self {
        Self {
            kinetic: energy.kinetic,
            modal: energy.modal,
            potential: energy.potential,
        }
    }
}

// What other languages lay out by hand.
const _: () = {
    assert!(size_of::<BdtWorldOptions>() == 80);
    assert!(size_of::<BdtBodyOptions>() == 144);
    assert!(size_of::<BdtBodyState>() == 128);
    assert!(size_of::<BdtStepReport>() == 96);
    assert!(size_of::<BdtEvent>() == 40);
    assert!(size_of::<BdtWorldContact>() == 96);
    assert!(size_of::<BdtEnergy>() == 24);
};
