//! Many bodies and planes, step by step.
//!
//! | file | part of the step |
//! |---|---|
//! | `predict` | where bodies would be at its end without contacts |
//! | `snapshot` | the poses that trees are asked at, each for as many steps as its body stays near it |
//! | `pairs`, `find` | which contact spheres may touch: root spheres, then trees, then lists of what is near |
//! | `groups`, `workers` | what threads may work on at the same time |
//! | `contact` | one pair of spheres, linearised |
//! | `surface` | the same of a sphere and a triangle |
//! | `regions` | the same of two closed surfaces |
//! | `solve` | the forces of all contacts |
//! | `advance` | bodies at its end |
//! | `parts` | steps that are divided, where walls are thin |
//! | `events` | which pairs began to touch, touch, parted |
//! | `sleep` | islands of bodies at rest |
//! | `queries`, `save` | what can be asked of a world, and its state as bytes |

mod advance;
mod body;
mod contact;
mod events;
mod find;
mod groups;
mod pairs;
mod parts;
mod predict;
mod queries;
mod regions;
mod save;
mod sleep;
mod snapshot;
mod solve;
mod surface;
mod workers;

use alloc::vec::Vec;

use bdtree_runtime::{Instance, Model, StepCache, Transform, Workspace};
use nalgebra::{UnitQuaternion, Vector3};

use crate::body_model::{BodyModel, BodyOptions};
use crate::contact_law::ContactLaw;
use crate::error::DynamicsError;
use crate::frame::FrameState;
use body::{Body, Modal};
use contact::Contact;
use events::Touches;
use groups::Groups;
use pairs::{Memory, Pair};
use solve::Warm;
use workers::{Clock, Lock, Worker};

pub use body::{BodyState, Energy, Frame};
pub use contact::ContactRecord;
pub(crate) use contact::SLIP;
pub use events::{Event, Events, Phase};

/// Most modes of an asset (SPEC 2.1), for q in the runtime's numbers.
const MODES_MAX: usize = 512;

/// A body of a world: its number, in the order in which bodies were added.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BodyId(pub usize);

/// A body model of a world: its number, in the order in which models were added.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ModelId(pub usize);

/// The ground, or a wall: nothing goes where `normal · x < offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Unit vector, away from the solid side.
    pub normal: [f64; 3],
    /// World units along the normal.
    pub offset: f64,
}

/// What holds for all bodies of a world.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldOptions {
    /// Length of a step, seconds; default 1/150, five steps per frame at 30 frames per second.
    pub step_s: f64,
    /// Acceleration, world units per s²; default 9.81 downwards along y.
    pub gravity: [f64; 3],
    /// What contacts are made of.
    pub law: ContactLaw,
    /// Most Gauss–Seidel sweeps over the contacts in a step; default 50.
    pub sweeps: usize,
    /// Sweeps end when one changes normal forces by less than this share of their sum; default 1e-3.
    pub accuracy: f64,
    /// Bodies that touch each other fall asleep when all of them have been slower than this for half a second: root mean square of
    /// all motion, modes included, world units per second. 0: never. Default 0.01.
    pub sleep_speed: f64,
    /// Threads that step; more than one needs the feature `threads`. Default 1.
    pub threads: usize,
}

impl Default for WorldOptions {
    fn default() -> Self {
        Self {
            step_s: 1.0 / 150.0,
            gravity: [0.0, -9.81, 0.0],
            law: ContactLaw::default(),
            sweeps: 50,
            accuracy: 1e-3,
            sleep_speed: 0.01,
            threads: 1,
        }
    }
}

/// What a step did.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StepReport {
    /// Pairs of contact spheres in contact: that overlap at the beginning of the step, or push each other within it.
    pub events: u64,
    /// Contacts that were found when they overlapped already, and whose springs begin at that overlap.
    pub late: u64,
    /// Pairs of bodies, planes included, whose root spheres are near each other.
    pub pairs: u64,
    /// Pairs of contact spheres that the trees found.
    pub candidates: u64,
    /// Nodes of the trees that were looked at, which are more in the first step after a restore.
    pub nodes_visited: u64,
    /// Nodes whose bounds were computed.
    pub nodes_updated: u64,
    /// Gauss–Seidel sweeps.
    pub sweeps: u64,
    /// Parts that the step was divided into: 1 unless bodies have the shape [`ContactShape::Regions`](crate::ContactShape). Counts of
    /// pairs, candidates and contacts are those of the last part, nodes and sweeps sums, overlaps the largest; contact energy is
    /// that at the beginning of the first.
    pub parts: u64,
    /// Largest overlap at the beginning of the step, world units.
    pub penetration: f64,
    /// The same as a share of the larger one's radius.
    pub penetration_rel: f64,
    /// Energy in the springs of contacts at the beginning of the step, J.
    pub contact_energy: f64,
}

/// Where a step's time went, seconds: by the clock, but for the first two, which are sums over threads. All 0 without `std`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StepTimes {
    /// Finding contacts of spheres with spheres and planes: trees and lists.
    pub spheres_s: f64,
    /// Finding contacts of spheres with triangles, and regions of contact.
    pub triangles_s: f64,
    /// Both, and which bodies are near each other.
    pub find_s: f64,
    /// Contact forces.
    pub solve_s: f64,
    /// All of the step.
    pub all_s: f64,
}

/// Bodies that fall, touch and vibrate.
///
/// Steps are the same to the bit for any number of threads.
#[derive(Debug)]
pub struct World {
    options: WorldOptions,
    models: Vec<BodyModel>,
    /// The least mean radius of any model's contact spheres.
    finest: f64,
    /// The thinnest wall of all bodies; infinite if it does not matter.
    wall: f64,
    /// Length of the step, or of the part of it that is in hand, seconds.
    part_s: f64,
    planes: Vec<Plane>,
    bodies: Vec<Body>,
    modal: Modal,
    instances: Vec<Instance>,
    /// The bounds of each body's nodes at its snapshot.
    caches: Vec<Lock<StepCache<'static>>>,
    steps: u64,
    times: StepTimes,
    // What a step works with; kept, so that later steps allocate nothing.
    workspace: Workspace<'static>,
    workers: Vec<Worker>,
    spheres: Vec<bdtree_runtime::BoundingSphere>,
    near: Vec<[usize; 2]>,
    pairs: Vec<Pair>,
    memory: Memory,
    groups: Groups,
    touches: Touches,
    touches_before: Touches,
    /// Forces and touches between what sleeps.
    warm_asleep: Vec<Warm>,
    warm_scratch: Vec<Warm>,
    touches_asleep: Touches,
    /// Leaders of islands, which of them have restless bodies, and islands that wake.
    islands: Vec<u32>,
    restless: Vec<bool>,
    waking: Vec<u32>,
    /// Whether instances are posed as bodies are now.
    is_posed: bool,
}

impl World {
    /// A world without bodies.
    ///
    /// # Errors
    /// Options beyond their limits.
    pub fn new(options: WorldOptions) -> Result<Self, DynamicsError> {
        let step_s = options.step_s;
        if !(step_s > 0.0 && step_s.is_finite()) {
            return Err(DynamicsError::Step { step_s });
        }
        if !options.gravity.iter().all(|g| g.is_finite()) {
            return Err(DynamicsError::NotFinite { what: "gravity" });
        }
        options.law.checked()?;
        if !(options.sleep_speed >= 0.0 && options.sleep_speed.is_finite()) {
            return Err(DynamicsError::NotFinite {
                what: "sleep_speed, which is not negative",
            });
        }
        if !(0.0..=1.0).contains(&options.accuracy) {
            return Err(DynamicsError::Setting {
                name: "accuracy",
                value: options.accuracy,
                limit: 1.0,
            });
        }
        const THREADS_MAX: usize = 256;
        if !(1..=THREADS_MAX).contains(&options.threads) {
            return Err(DynamicsError::Setting {
                name: "threads",
                value: options.threads as f64,
                limit: THREADS_MAX as f64,
            });
        }
        let workers = (0..options.threads).map(|_| Worker::default()).collect();
        Ok(Self {
            options,
            models: Vec::new(),
            finest: f64::INFINITY,
            wall: f64::INFINITY,
            part_s: step_s,
            planes: Vec::new(),
            bodies: Vec::new(),
            modal: Modal::default(),
            instances: Vec::new(),
            caches: Vec::new(),
            steps: 0,
            times: StepTimes::default(),
            workspace: Workspace::new(),
            workers,
            spheres: Vec::new(),
            near: Vec::new(),
            pairs: Vec::new(),
            memory: Memory::default(),
            groups: Groups::default(),
            touches: Vec::new(),
            touches_before: Vec::new(),
            warm_asleep: Vec::new(),
            warm_scratch: Vec::new(),
            touches_asleep: Vec::new(),
            islands: Vec::new(),
            restless: Vec::new(),
            waking: Vec::new(),
            is_posed: false,
        })
    }

    /// The options.
    pub fn options(&self) -> &WorldOptions {
        &self.options
    }

    /// Adds what bodies of an asset have in common.
    ///
    /// # Errors
    /// Options beyond their limits; a skin; a damaged asset.
    pub fn add_model(
        &mut self,
        model: &Model,
        options: &BodyOptions,
    ) -> Result<ModelId, DynamicsError> {
        let model = BodyModel::new(model, options, self.options.step_s)?;
        if model.surface.is_none() {
            self.finest = self.finest.min(model.spheres.radius_mean);
        }
        self.models.push(model);
        Ok(ModelId(self.models.len() - 1))
    }

    /// What bodies of a model have in common.
    ///
    /// # Errors
    /// A model that the world does not have.
    pub fn model(&self, model: ModelId) -> Result<&BodyModel, DynamicsError> {
        let ModelId(index) = model;
        self.models.get(index).ok_or(DynamicsError::Unknown {
            what: "model",
            index,
        })
    }

    /// Adds a plane.
    ///
    /// # Errors
    /// A normal that is not of unit length to 1e-6, an offset that is not finite.
    pub fn add_plane(&mut self, plane: Plane) -> Result<(), DynamicsError> {
        let norm = Vector3::from(plane.normal).norm();
        if !((norm - 1.0).abs() <= 1e-6 && plane.offset.is_finite()) {
            return Err(DynamicsError::NotFinite {
                what: "a plane needs a unit normal and a finite offset",
            });
        }
        self.planes.push(plane);
        Ok(())
    }

    /// Adds a body at rest in its own frame: undeformed, at a placement of its mesh, without speed.
    ///
    /// # Errors
    /// A model that the world does not have, one without mass properties or with modes of a held body for a free body, one
    /// without frequencies or modal masses for a body that is not driven, a placement that its asset refuses or whose scale
    /// is not the model's.
    pub fn add_body(
        &mut self,
        model: ModelId,
        frame: Frame,
        at: impl Into<Transform>,
    ) -> Result<BodyId, DynamicsError> {
        let at = at.into();
        let ModelId(index) = model;
        let of = self.model(model)?;
        if frame == Frame::Free && of.mass.is_none() {
            return Err(DynamicsError::NoMass);
        }
        if frame != Frame::Driven
            && let Some(mode) = of.silent_mode
        {
            return Err(DynamicsError::NoFrequency { mode });
        }
        if frame == Frame::Free
            && let Some(mode) = of.held_mode()
        {
            return Err(DynamicsError::HeldMode { mode });
        }
        if at.scale != of.scale {
            return Err(DynamicsError::Scale {
                scale: at.scale,
                expected: of.scale,
            });
        }
        let mut instance = of.instance()?;
        instance.set_placement(at)?;
        let (position, orientation) = of.frame(&at);
        let state = FrameState::at(position, orientation);
        let (stride, cache_size) = (of.spheres.stride(), of.cache_size());
        self.wall = self.wall.min(of.wall);
        self.modal.add(stride);
        self.bodies
            .push(Body::new(index, frame, state, self.modal.start()));
        self.instances.push(instance);
        self.caches.push(Lock::new(StepCache::new(cache_size)));
        self.spheres.push(bdtree_runtime::BoundingSphere {
            center: [0.0; 3],
            radius: 0.0,
        });
        Ok(BodyId(self.bodies.len() - 1))
    }

    /// Number of bodies.
    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Number of steps so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The contacts of the last step, sorted by bodies and spheres.
    pub fn contacts(&self) -> impl Iterator<Item = ContactRecord> + use<'_> {
        self.sorted_contacts().map(Contact::record)
    }

    /// One step.
    ///
    /// # Errors
    /// Overlaps deeper than a contact sphere's radius or the thinner wall, bodies too fast for their walls, states that are not
    /// finite; the world then is not to be stepped on.
    pub fn step(&mut self) -> Result<StepReport, DynamicsError> {
        self.times = StepTimes::default();
        // A step that failed may have left a part's.
        self.part_s = self.options.step_s;
        let all = Clock::start();
        if core::mem::take(&mut self.is_posed) {
            self.return_to_snapshots()?;
        }
        self.fall_asleep_and_wake()?;
        core::mem::swap(&mut self.touches, &mut self.touches_before);
        self.touches.clear();
        let report = if self.wall.is_finite() {
            self.step_in_parts()?
        } else {
            let mut report = self.meet()?;
            self.part_with(&mut report)?;
            report
        };
        self.forget_forces();
        self.steps += 1;
        self.watch();
        self.times.all_s = all.seconds();
        Ok(report)
    }

    /// Finds the contact forces of a step, or of a part of one; bodies stay where they are.
    fn meet(&mut self) -> Result<StepReport, DynamicsError> {
        self.predict()?;
        let clock = Clock::start();
        let mut report = self.find()?;
        self.times.find_s += clock.seconds();
        let clock = Clock::start();
        report.sweeps = self.solve() as u64;
        self.times.solve_s += clock.seconds();
        Ok(report)
    }

    /// Tells of the contacts, and moves bodies.
    fn part_with(&mut self, report: &mut StepReport) -> Result<(), DynamicsError> {
        report.parts = 1;
        self.tell(report)?;
        self.sum_up_touches();
        self.advance()
    }

    /// Where the time of the last step went; not part of the state.
    pub fn times(&self) -> StepTimes {
        self.times
    }
}

/// The part of a slice that belongs to a body.
fn part(all: &[f64], start: usize, stride: usize) -> &[f64] {
    &all[start..start + stride]
}

/// Unit vectors across a unit vector.
fn tangents(n: &Vector3<f64>) -> [Vector3<f64>; 2] {
    // The axis that n is farthest from.
    let axis = if n.x.abs() < 0.6 {
        Vector3::x()
    } else {
        Vector3::y()
    };
    let first = n.cross(&axis).normalize();
    [first, n.cross(&first)]
}

/// Half of the way from one orientation to another.
fn half_way(from: &UnitQuaternion<f64>, to: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    let (a, b) = (from.coords, to.coords);
    let b = if a.dot(&b) < 0.0 { -b } else { b };
    UnitQuaternion::new_normalize(nalgebra::Quaternion::from(a + b))
}
