//! The world and its bodies, step by step, with a way back from a step that fails.

use std::fmt;

use bdtree_dynamics::{
    BodyId, BodyOptions, ContactLaw, DynamicsError, Frame, Plane, StepReport, World, WorldOptions,
};
use bdtree_runtime::Transform;
use bdtree_tools::AssetFile;
use nalgebra::Vector3;

use super::grab::Grab;
use super::kinds::{Able, Kind};
use super::random::Stream;

/// What contacts are made of: that of the falling chairs of the scenes.
const LAW: ContactLaw = ContactLaw {
    stiffness: 3.0,
    damping_ratio: 0.3,
    friction: 0.4,
};

/// m/s², downwards.
pub(super) const GRAVITY: f64 = 9.81;

/// Steps per second of a world that nobody has asked for another of: five per frame at 30 frames per second.
pub const RATE: u32 = 150;

/// What holds for a whole session.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Length of a step, seconds.
    pub step_s: f64,
    /// Threads that step.
    pub threads: usize,
    /// Meters per mesh unit.
    pub scale: f64,
    /// Whether bodies vibrate.
    pub is_deformable: bool,
    /// Level of the contact spheres; without it that with about a thousand.
    pub level: Option<usize>,
    /// Of orientations.
    pub seed: u64,
}

impl Settings {
    fn world(&self) -> Result<World, DynamicsError> {
        let mut world = World::new(WorldOptions {
            step_s: self.step_s,
            gravity: [0.0, -GRAVITY, 0.0],
            law: LAW,
            threads: self.threads,
            ..WorldOptions::default()
        })?;
        world.add_plane(Plane {
            normal: [0.0, 1.0, 0.0],
            offset: 0.0,
        })?;
        Ok(world)
    }

    fn bodies(&self) -> BodyOptions {
        BodyOptions {
            scale: self.scale,
            level: self.level,
            is_deformable: self.is_deformable,
            ..BodyOptions::default()
        }
    }
}

/// Which bodies there are, and the world's bytes.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// The kind of each body.
    pub of: Vec<usize>,
    /// Bodies that there have ever been.
    pub added: u64,
    /// As [`World::save`] has them.
    pub world: Vec<u8>,
}

/// A step that failed. The world is as it was before the steps of the frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Failure {
    /// The step's number.
    pub step: u64,
    /// What was wrong.
    pub reason: String,
    /// Bodies that it was about.
    pub bodies: Vec<usize>,
    /// The part of their speed that steps of this length bear, about.
    pub bearable: f64,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "step {}: {}", self.step, self.reason)
    }
}

/// Bodies of several kinds on the ground, which is y = 0.
#[derive(Debug)]
pub struct Simulation {
    settings: Settings,
    kinds: Vec<Kind>,
    world: World,
    of: Vec<usize>,
    added: u64,
    report: StepReport,
    beginning: Option<State>,
    /// The world before the steps of a frame.
    kept: Vec<u8>,
}

impl Simulation {
    /// Without bodies.
    ///
    /// # Errors
    /// Settings that no world has. A file whose bodies cannot fall is none: [`Kind::able`] says what it lacks.
    pub fn new(files: &[AssetFile], settings: Settings) -> Result<Self, DynamicsError> {
        let mut world = settings.world()?;
        let kind = |file| Kind::new(file, &settings.bodies(), &mut world);
        Ok(Self {
            kinds: files.iter().map(kind).collect(),
            settings,
            world,
            of: Vec::new(),
            added: 0,
            report: StepReport::default(),
            beginning: None,
            kept: Vec::new(),
        })
    }

    /// What was asked for.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// One per file.
    pub fn kinds(&self) -> &[Kind] {
        &self.kinds
    }

    /// Its bodies and contacts.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// To ask where rays go, and to push.
    pub(super) fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }

    /// The kind of each body.
    pub fn of(&self) -> &[usize] {
        &self.of
    }

    /// What the last step did.
    pub fn report(&self) -> &StepReport {
        &self.report
    }

    /// The kind of a body.
    pub(super) fn kind_of(&self, body: BodyId) -> Option<&Kind> {
        self.kinds.get(*self.of.get(body.0)?)
    }

    /// What can be known of the bodies of a kind.
    ///
    /// # Errors
    /// What the file lacks, with its name.
    pub fn able(&self, kind: usize) -> Result<&Able, String> {
        let kind = self.kinds.get(kind).ok_or("there is no such file")?;
        let named = |problem: &String| format!("{}: {problem}", kind.name);
        kind.able.as_ref().map_err(named)
    }

    /// Adds a body with its center of mass at a point, turned as chance has it, with a velocity and an angular velocity.
    ///
    /// # Errors
    /// What the file lacks; a place too far away.
    pub fn add(
        &mut self,
        kind: usize,
        center: [f64; 3],
        [velocity, spin]: [[f64; 3]; 2],
    ) -> Result<BodyId, String> {
        let model = self.able(kind)?.model;
        let rotation = Stream::of(self.settings.seed, self.added).rotation();
        let at = self.kinds[kind].placed(center, rotation, self.settings.scale);
        let added = self.world.add_body(model, Frame::Free, at);
        let body = added.map_err(|error| error.to_string())?;
        self.of.push(kind);
        self.added += 1;
        let set = self.world.set_velocity(body, velocity, spin);
        set.map_err(|error| error.to_string())?;
        Ok(body)
    }

    /// A number from 0 to 1 for the next body: the same in each run.
    pub(super) fn chance(&self) -> f64 {
        Stream::of(!self.settings.seed, self.added).unit()
    }

    /// Center of mass and reach of each body.
    pub fn balls(&self) -> impl Iterator<Item = ([f64; 3], f64)> + '_ {
        self.of.iter().enumerate().filter_map(|(body, kind)| {
            let state = self.world.state(BodyId(body)).ok()?;
            Some((state.position, self.kinds[*kind].reach()))
        })
    }

    /// Whether a ball is free of bodies, and above the ground.
    pub(super) fn is_free(&self, center: [f64; 3], reach: f64) -> bool {
        let away = |at: [f64; 3]| (Vector3::from(at) - Vector3::from(center)).norm();
        center[1] >= reach && self.balls().all(|(at, other)| away(at) >= reach + other)
    }

    /// Steps, with what holds a body. Where one fails, the world goes back to where it was before the first of them.
    ///
    /// # Errors
    /// The first step that failed.
    pub fn steps(&mut self, count: usize, grab: Option<&mut Grab>) -> Result<(), Failure> {
        self.kept.clear();
        self.world.save(&mut self.kept);
        let stepped = self.try_steps(count, grab);
        stepped.map_err(|error| {
            let step = self.world.steps() + 1;
            let (bodies, bearable) = match &error {
                DynamicsError::Penetration {
                    bodies, step_max_s, ..
                } => {
                    let bearable = step_max_s / self.settings.step_s;
                    (bodies.iter().flatten().copied().collect(), bearable)
                }
                _ => (Vec::new(), 1.0),
            };
            // Its own bytes; were they refused, the error at hand says more.
            let _ = self.world.restore(&self.kept);
            Failure {
                step,
                reason: error.to_string(),
                bodies,
                bearable,
            }
        })
    }

    fn try_steps(
        &mut self,
        count: usize,
        mut grab: Option<&mut Grab>,
    ) -> Result<(), DynamicsError> {
        for _ in 0..count {
            if let Some(grab) = &mut grab {
                grab.pull(&mut self.world)?;
            }
            self.report = self.world.step()?;
        }
        Ok(())
    }

    /// Multiplies the velocities of bodies.
    ///
    /// # Errors
    /// A body that there is not.
    pub fn slow(&mut self, bodies: &[usize], factor: f64) -> Result<(), String> {
        let mut slow = |body: BodyId| {
            let velocity = self.world.state(body)?.velocity.map(|v| v * factor);
            let spin = self.world.angular_velocity(body)?.map(|w| w * factor);
            self.world.set_velocity(body, velocity, spin)
        };
        let slowed = bodies.iter().try_for_each(|body| slow(BodyId(*body)));
        slowed.map_err(|error| error.to_string())
    }

    /// Steps per second that are enough for bodies of all kinds in everyday falls: one from four times its reach moves by
    /// at most two mean radii of its contact spheres in a step. A multiple of 150, at most 1200.
    pub fn fitting_rate(&self) -> u32 {
        let of = |able: &Able| {
            let fall = (2.0 * GRAVITY * 4.0 * able.reach).sqrt();
            (fall / (2.0 * able.radius * f64::from(RATE))).ceil()
        };
        let all = self.kinds.iter().filter_map(|kind| kind.able.as_ref().ok());
        // At least 1, also where there are none.
        RATE * all.map(of).fold(1.0, f64::max).min(8.0) as u32
    }

    /// Which bodies there are and what they do.
    pub fn state(&self) -> State {
        let mut bytes = Vec::new();
        self.world.save(&mut bytes);
        State {
            of: self.of.clone(),
            added: self.added,
            world: bytes,
        }
    }

    /// Puts everything into a state.
    ///
    /// # Errors
    /// A state of other files or settings; all is then as it was.
    pub fn set_state(&mut self, state: &State) -> Result<(), String> {
        let mut world = self.empty(&state.of)?;
        for kind in &state.of {
            let at = self.kinds[*kind].placed([0.0; 3], [0.0, 0.0, 0.0, 1.0], self.settings.scale);
            let added = world.add_body(self.able(*kind)?.model, Frame::Free, at);
            added.map_err(|error| error.to_string())?;
        }
        (world.restore(&state.world)).map_err(|error| error.to_string())?;
        self.world = world;
        self.of.clone_from(&state.of);
        self.added = state.added;
        self.report = StepReport::default();
        Ok(())
    }

    /// A world of the same models without bodies, for bodies of these kinds.
    fn empty(&self, of: &[usize]) -> Result<World, String> {
        of.iter().try_for_each(|kind| self.able(*kind).map(drop))?;
        let made = || {
            let mut world = self.settings.world()?;
            // In the order of their numbers.
            for kind in self.kinds.iter().filter(|kind| kind.able.is_ok()) {
                world.add_model(&kind.model, &self.settings.bodies())?;
            }
            Ok(world)
        };
        made().map_err(|error: DynamicsError| error.to_string())
    }

    /// Takes out some bodies. The others stay where they are and keep their speed, their shape and its rate; forces between
    /// them are found anew.
    ///
    /// # Errors
    /// A state that cannot be had again; all is then as it was.
    pub fn remove(&mut self, bodies: &[usize]) -> Result<(), String> {
        let stay: Vec<usize> = (0..self.of.len()).filter(|b| !bodies.contains(b)).collect();
        let of: Vec<usize> = stay.iter().map(|body| self.of[*body]).collect();
        let mut world = self.empty(&of)?;
        self.copy_to(&mut world, &stay)
            .map_err(|error| error.to_string())?;
        self.world = world;
        self.of = of;
        Ok(())
    }

    fn copy_to(&self, world: &mut World, bodies: &[usize]) -> Result<(), DynamicsError> {
        for body in bodies {
            let old = BodyId(*body);
            let Ok(able) = &self.kinds[self.of[*body]].able else {
                continue;
            };
            let at: Transform = self.world.placement(old)?;
            let new = world.add_body(able.model, Frame::Free, at)?;
            let velocity = self.world.state(old)?.velocity;
            world.set_velocity(new, velocity, self.world.angular_velocity(old)?)?;
            let mut q = vec![0.0; self.world.model_of(old)?.mode_count()];
            let mut rate = q.clone();
            self.world.q(old, &mut q)?;
            self.world.q_rate(old, &mut rate)?;
            world.set_modes(new, &q, &rate)?;
        }
        Ok(())
    }

    /// Makes what is now the beginning, to which [`Simulation::reset`] goes back.
    pub fn begin_here(&mut self) {
        self.beginning = Some(self.state());
    }

    /// Goes back to the beginning.
    ///
    /// # Errors
    /// Those of [`Simulation::set_state`].
    pub fn reset(&mut self) -> Result<(), String> {
        match self.beginning.take() {
            Some(state) => {
                let set = self.set_state(&state);
                self.beginning = Some(state);
                set
            }
            None => self.clear(),
        }
    }

    /// Takes out all bodies.
    ///
    /// # Errors
    /// None that is expected.
    pub fn clear(&mut self) -> Result<(), String> {
        self.world = self.empty(&[])?;
        self.of.clear();
        self.report = StepReport::default();
        Ok(())
    }

    /// q of a body, in the runtime's numbers.
    pub fn q(&self, body: usize) -> Vec<f32> {
        let id = BodyId(body);
        let modes = self.kind_of(id).map(|kind| kind.model.asset().mode_count());
        let moving = self.world.model_of(id).map_or(0, |of| of.mode_count());
        let mut q = vec![0.0; moving];
        // Only of bodies that there are, and of as many modes as they have.
        let known = self.world.q(id, &mut q).is_ok();
        let mut q: Vec<f32> = q.iter().map(|q| *q as f32).collect();
        if !known {
            q.clear();
        }
        q.resize(modes.unwrap_or(0), 0.0);
        q
    }
}
