//! The playground without its window: the simulation, the camera, and what hands do.

use std::path::PathBuf;
use std::time::Instant;

use bdtree_dynamics::BodyId;
use bdtree_render::{Camera, Framing, Place, ViewDirection};
use bdtree_runtime::{Ray, RayIntersection};
use nalgebra::Vector3;

use super::checkpoint;
use super::grab::{Grab, Point};
use super::pace::Pace;
use super::places::{self, Throw};
use super::simulation::Simulation;
use crate::orbit;

/// From where the camera of the beginning looks, degrees.
const AZIMUTH_DEG: f32 = 30.0;
const ELEVATION_DEG: f32 = 20.0;

/// Farther away the ground is not aimed at, in distances from the camera to its target.
const FAR: f64 = 10.0;

/// Speeds of throws at first, m/s over √(reach/m): 5 m/s for a body that reaches 0.6 m.
const THROW: f64 = 6.5;
/// Of pokes, as a part of the speed of throws.
const POKE: f64 = 0.5;

/// Part of the last frame in the times that are shown.
const SHARE: f64 = 0.1;

/// What a drag moves.
#[derive(Debug)]
pub enum Hold {
    /// The camera around its target.
    Orbit,
    /// Camera and target.
    Pan,
    /// A body.
    Body {
        /// The spring.
        grab: Box<Grab>,
        /// From the camera to the pointer's place, along the view.
        depth: f64,
    },
}

/// What is wrong, and which bodies are to blame.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// In one line.
    pub text: String,
    /// Bodies that may be taken out or slowed down.
    pub bodies: Vec<usize>,
    /// The part of their speed that would do.
    pub bearable: f64,
}

impl Problem {
    /// One that no body is to blame for.
    fn new(text: String) -> Self {
        Self {
            text,
            bodies: Vec::new(),
            bearable: 1.0,
        }
    }
}

/// Bodies that are slowed down keep at most so much of their speed, and so much of what would just do.
const SLOWER: f64 = 0.8;

/// Means over the last frames, in milliseconds.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Times {
    /// All steps of a frame.
    pub simulation: Option<f64>,
    /// Number of these steps.
    pub steps: Option<f64>,
    /// The picture, until the device has drawn it.
    pub drawing: Option<f64>,
}

/// Follows a number frame by frame.
pub(super) fn follow(mean: &mut Option<f64>, now: f64) {
    let before = mean.unwrap_or(now);
    *mean = Some(before + SHARE * (now - before));
}

/// The state of the playground.
#[derive(Debug)]
pub struct Playground {
    /// The bodies.
    pub simulation: Simulation,
    /// How time goes on.
    pub pace: Pace,
    /// The kind that is dropped and thrown.
    pub chosen: usize,
    /// Of throws, m/s.
    pub speed: f64,
    /// Whether the last step's contacts are drawn.
    pub has_contacts: bool,
    /// From where it is seen; `None`: from where everything is.
    pub camera: Option<Camera>,
    /// What the mouse holds.
    pub hold: Option<Hold>,
    /// What is wrong.
    pub problem: Option<Problem>,
    /// How long frames take.
    pub times: Times,
    /// Where the state is saved.
    pub checkpoint: Option<PathBuf>,
}

impl Playground {
    /// Of a simulation as it is, which is the beginning.
    pub fn new(mut simulation: Simulation) -> Self {
        simulation.begin_here();
        let kinds = simulation.kinds();
        let chosen = kinds.iter().position(|kind| kind.able.is_ok());
        let reach = chosen.map_or(1.0, |chosen| kinds[chosen].reach());
        let mut playground = Self {
            pace: Pace::new(simulation.settings().step_s),
            chosen: 0,
            speed: (10.0 * THROW * reach.sqrt()).round() / 10.0,
            has_contacts: true,
            camera: None,
            hold: None,
            problem: None,
            times: Times::default(),
            checkpoint: None,
            simulation,
        };
        // One file that cannot fall among others is told where it is listed; of the only one there is more to say.
        match chosen {
            Some(chosen) => playground.chosen = chosen,
            None => playground.try_to(|play| play.simulation.able(0).map(drop)),
        }
        playground
    }

    /// Does something, or says why not.
    fn try_to(&mut self, what: impl FnOnce(&mut Self) -> Result<(), String>) {
        if let Err(text) = what(self) {
            self.problem = Some(Problem::new(text));
        }
    }

    /// Does something that only changes what it has.
    fn change(&mut self, what: impl FnOnce(&mut Self) -> Result<(), String>) {
        self.problem = None;
        self.try_to(what);
    }

    /// Lets time pass: all steps that are due. One that fails halts at the state before the frame.
    pub fn advance(&mut self, dt_s: f64) {
        let count = self.pace.due(dt_s);
        if count == 0 {
            return;
        }
        let grab = match &mut self.hold {
            Some(Hold::Body { grab, .. }) => Some(&mut **grab),
            _ => None,
        };
        let begin = Instant::now();
        let stepped = self.simulation.steps(count, grab);
        follow(
            &mut self.times.simulation,
            1e3 * begin.elapsed().as_secs_f64(),
        );
        follow(&mut self.times.steps, count as f64);
        if let Err(failure) = stepped {
            self.pace.halt();
            self.let_go();
            self.problem = Some(Problem {
                text: format!("{failure}; halted at the state before"),
                bodies: failure.bodies,
                bearable: failure.bearable,
            });
        }
    }

    /// The beginning again.
    pub fn reset(&mut self) {
        self.let_go();
        self.pace.forget();
        self.change(|play| play.simulation.reset());
    }

    /// Takes out all bodies.
    pub fn clear(&mut self) {
        self.let_go();
        self.change(|play| play.simulation.clear());
    }

    /// Takes out some bodies.
    pub fn remove(&mut self, bodies: &[usize]) {
        self.let_go();
        self.change(|play| play.simulation.remove(bodies));
    }

    /// Slows down the bodies that are to blame, and goes on.
    pub fn slow_down(&mut self, problem: &Problem) {
        let factor = SLOWER * problem.bearable.min(1.0);
        self.change(|play| play.simulation.slow(&problem.bodies, factor));
        self.pace.is_running = true;
    }

    /// Writes the state to the file for it.
    pub fn save(&mut self) {
        self.change(|play| match &play.checkpoint {
            Some(path) => {
                checkpoint::write(path, &play.simulation).map_err(|error| error.to_string())
            }
            None => Err("there is no file to save to: start with --checkpoint FILE".to_string()),
        });
    }

    /// What a pixel of a picture shows: from the eye, unit.
    fn ray(&self, at: [f32; 2], size: [u32; 2]) -> Option<(Camera, Ray)> {
        let camera = self.camera?;
        let direction = camera.toward(at, size).as_dvec3().to_array();
        Some((
            camera,
            Ray::new(camera.eye.as_dvec3().to_array(), direction),
        ))
    }

    /// The body at a pixel.
    fn body_at(
        &mut self,
        at: [f32; 2],
        size: [u32; 2],
    ) -> Result<Option<(BodyId, RayIntersection)>, String> {
        let Some((_, ray)) = self.ray(at, size) else {
            return Ok(None);
        };
        let hit = self.simulation.world_mut().cast_ray(&ray);
        hit.map_err(|error| error.to_string())
    }

    /// How far away from the eye a body or the ground is at a pixel.
    fn distance(&mut self, at: [f32; 2], size: [u32; 2]) -> Result<Option<f64>, String> {
        let body = self.body_at(at, size)?.map(|(_, hit)| hit.distance);
        let Some((camera, ray)) = self.ray(at, size) else {
            return Ok(None);
        };
        let down = -ray.direction[1];
        let ground = (down > 0.0 && ray.origin[1] > 0.0).then(|| ray.origin[1] / down);
        let ground = ground.filter(|t| *t < FAR * f64::from(camera.distance()));
        // Nothing is seen through the ground.
        Ok(match (body, ground) {
            (Some(body), Some(ground)) => Some(body.min(ground)),
            (body, ground) => body.or(ground),
        })
    }

    /// Drops a body above what a pixel shows; nothing above the sky.
    pub fn drop_at(&mut self, at: [f32; 2], size: [u32; 2]) {
        self.change(|play| {
            let (Some(distance), Some((_, ray))) = (play.distance(at, size)?, play.ray(at, size))
            else {
                return Ok(());
            };
            let point = Vector3::from(ray.origin) + Vector3::from(ray.direction) * distance;
            places::drop_above(&mut play.simulation, play.chosen, point.into())
        });
    }

    /// Throws a body at what a pixel shows.
    pub fn throw_at(&mut self, at: [f32; 2], size: [u32; 2]) {
        self.change(|play| {
            let distance = play.distance(at, size)?;
            let Some((camera, ray)) = play.ray(at, size) else {
                return Ok(());
            };
            let throw = Throw {
                eye: ray.origin,
                direction: ray.direction,
                distance: distance.unwrap_or(f64::from(camera.distance())),
                speed: play.speed,
            };
            places::throw(&mut play.simulation, play.chosen, throw)
        });
    }

    /// Pushes the body at a pixel away from the camera.
    pub fn poke_at(&mut self, at: [f32; 2], size: [u32; 2]) {
        let speed = POKE * self.speed;
        self.change(|play| {
            let (Some((body, hit)), Some((_, ray))) = (play.body_at(at, size)?, play.ray(at, size))
            else {
                return Ok(());
            };
            let mut point = Point::new(&play.simulation, body, &hit)?;
            let change = Vector3::from(ray.direction) * speed;
            let poked = point.poke(play.simulation.world_mut(), change);
            poked.map_err(|error| error.to_string())
        });
    }

    /// Takes out the body at a pixel.
    pub fn remove_at(&mut self, at: [f32; 2], size: [u32; 2]) {
        let found = self.body_at(at, size);
        match found {
            Ok(Some((body, _))) => self.remove(&[body.0]),
            Ok(None) => {}
            Err(text) => self.try_to(|_| Err(text)),
        }
    }

    /// Takes what is at a pixel: the body, or else the camera.
    pub fn grab(&mut self, at: [f32; 2], size: [u32; 2]) {
        self.hold = Some(Hold::Orbit);
        self.try_to(|play| {
            let (Some((body, hit)), Some((camera, _))) =
                (play.body_at(at, size)?, play.ray(at, size))
            else {
                return Ok(());
            };
            let forward = camera.axes()[2].as_dvec3().to_array();
            let eye = camera.eye.as_dvec3().to_array();
            let depth = (0..3).map(|k| forward[k] * (hit.point[k] - eye[k])).sum();
            let point = Point::new(&play.simulation, body, &hit)?;
            play.hold = Some(Hold::Body {
                grab: Box::new(Grab::new(point, hit.point)),
                depth,
            });
            Ok(())
        });
    }

    /// Moves the camera that is held by so many pixels, right and down, and the body to where the pointer is now.
    pub fn drag(&mut self, moved: [f32; 2], at: [f32; 2], size: [u32; 2]) {
        let ray = self.ray(at, size);
        match (&mut self.hold, ray) {
            (Some(Hold::Orbit), Some((camera, _))) => {
                self.camera = Some(orbit::turned(camera, moved, size[1]));
            }
            (Some(Hold::Pan), Some((camera, _))) => {
                self.camera = Some(orbit::moved(camera, moved, size[1]));
            }
            (Some(Hold::Body { grab, depth }), Some((camera, ray))) => {
                let forward = Vector3::from(camera.axes()[2].as_dvec3().to_array());
                let direction = Vector3::from(ray.direction);
                let along = *depth / direction.dot(&forward);
                let mut target = Vector3::from(ray.origin) + direction * along;
                target.y = target.y.max(0.0);
                grab.target = target;
            }
            _ => {}
        }
    }

    /// Lets go: a body flies on as fast as it was moved.
    pub fn let_go(&mut self) {
        self.hold = None;
    }

    /// The body that is held.
    pub fn grabbed(&self) -> Option<&Grab> {
        match &self.hold {
            Some(Hold::Body { grab, .. }) => Some(grab),
            _ => None,
        }
    }

    /// The wheel: a body that is held goes away or comes nearer, else the camera does.
    pub fn wheel(&mut self, steps: f32) {
        match &mut self.hold {
            Some(Hold::Body { depth, .. }) => *depth *= 1.05_f64.powf(f64::from(steps)),
            _ => self.camera = self.camera.map(|camera| orbit::zoomed(camera, steps)),
        }
    }

    /// Puts the camera where all bodies are seen, and room for the next one, in a picture of `aspect`.
    pub fn fit(&mut self, aspect: f32) {
        let direction = ViewDirection::new(AZIMUTH_DEG, ELEVATION_DEG);
        let mut framing = Framing::new(direction, aspect);
        let reach = self.reach();
        framing.hold([0.0, reach, 0.0], 2.0 * reach);
        for ([x, y, z], reach) in self.simulation.balls() {
            framing.hold([x, y, z], reach);
            framing.hold([x, 0.5 * reach, z], reach);
        }
        let meters = Place {
            middle: [0.0; 3],
            size: 1.0,
        };
        self.camera = Some(framing.camera(&meters));
    }

    /// Of the largest body that can fall, m.
    pub(super) fn reach(&self) -> f64 {
        let reaches = self.simulation.kinds().iter().map(|kind| kind.reach());
        let largest = reaches.fold(0.0, f64::max);
        if largest > 0.0 { largest } else { 1.0 }
    }

    /// Whether something moves by itself.
    pub fn is_moving(&self) -> bool {
        self.pace.is_moving() && !self.simulation.of().is_empty() || self.hold.is_some()
    }

    /// Chooses the file of a number key.
    pub fn choose(&mut self, kind: usize) {
        if kind < self.simulation.kinds().len() {
            self.chosen = kind;
        }
    }
}
