//! The world, its bodies and what they have in common.

use std::error::Error;
use std::path::PathBuf;

use bdtree_dynamics::{
    BodyOptions, ContactLaw, Frame, LevelSpheres, MassProperties, ModelId, Plane, World,
    WorldOptions,
};
use bdtree_render::Floor;
use bdtree_runtime::{Model, Transform};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::Arguments;
use super::ground::ground;
use super::updated::updated;
use crate::falling::log::{Log, columns};
use crate::falling::show::{self, Show, View};
use crate::falling::waves::Waves;
use crate::falling::{About, Scene, hash, report};
use crate::{film, report::Row, row};

/// What contacts are made of: stiffer and less springy than what worlds have by themselves, as chairs are.
const LAW: ContactLaw = ContactLaw {
    stiffness: 3.0,
    damping_ratio: 0.3,
    friction: 0.4,
};

/// Distance of neighbors in a wave, m; more for larger bodies.
const SPACING: f64 = 1.3;

/// Chairs along a side of a wave, at most: with 3601 chairs, 22 waves make a heap several meters high.
const SIDE_MAX: usize = 13;

/// Height of a chair's center of mass above those below it, m: none gets much faster than 6 m/s.
const ABOVE: f64 = 1.5;

/// Steps from a wave to the next.
const EVERY: u64 = 150;

/// A world in which bodies of one asset fall.
pub(crate) struct Chairs {
    arguments: Arguments,
    pub(super) world: World,
    pub(super) model: Model,
    of: ModelId,
    pub(super) spheres: LevelSpheres,
    pub(super) extent: f64,
    waves: Waves,
}

/// What must be the same in the run that goes on. The number of threads, pictures and checks may differ.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Settings {
    pub(super) bodies: u32,
    pub(super) seed: u64,
    pub(super) rigid: bool,
    pub(super) level: usize,
    asset: String,
}

columns! {
/// What only falling chairs tell.
Own {
    /// Of the spheres' centers of some bodies near the ground at the end; none is near it: empty.
    lowest_m,
    /// Of these centers, those that are below the ground by more than the largest radius.
    below,
}
}

impl Chairs {
    pub(super) fn new(arguments: Arguments, model: Model) -> Result<Self, Box<dyn Error>> {
        let options = WorldOptions {
            law: LAW,
            // As in the paper, every body takes part in every step.
            sleep_speed: 0.0,
            threads: usize::from(arguments.options.threads),
            ..WorldOptions::default()
        };
        let body = BodyOptions {
            level: arguments.level,
            is_deformable: !arguments.rigid,
            has_redundant_updates: arguments.redundant_updates,
            ..BodyOptions::default()
        };
        let mut world = World::new(options)?;
        let of = world.add_model(&model, &body)?;
        let spheres = world.model(of)?.spheres().clone();
        let reaches = (0..spheres.len()).map(|k| spheres.rest_center(k).norm() + spheres.radius(k));
        let extent = reaches.fold(0.0, f64::max);
        let mass = MassProperties::of(model.asset());
        let center = mass.ok_or("the asset has no mass properties")?.center;
        world.add_plane(Plane {
            normal: [0.0, 1.0, 0.0],
            offset: 0.0,
        })?;
        let count = arguments.bodies as usize;
        let side = ((count as f64).sqrt().ceil() as usize).clamp(1, SIDE_MAX);
        let waves = Waves {
            seed: arguments.options.seed,
            count,
            columns: side,
            rows: side,
            spacing: f64::max(SPACING, 2.1 * extent),
            above: ABOVE,
            every: EVERY,
            center: center.into(),
            scale: 1.0,
            onto: None,
        };
        Ok(Self {
            arguments,
            world,
            model,
            of,
            spheres,
            extent,
            waves,
        })
    }

    /// Nodes of a body's tree, and of those the nodes down to the level of its contact spheres.
    pub(super) fn nodes_each(&self) -> [usize; 2] {
        let asset = self.model.asset();
        [asset.node_count(), asset.node_count_to(self.spheres.level)]
    }
}

impl Scene for Chairs {
    const NAME: &'static str = "chairs";
    const STEPS_PER_FRAME: u64 = 5;
    type Settings = Settings;
    type Own = Own;

    fn world(&self) -> &World {
        &self.world
    }

    fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }

    fn settings(&self) -> Settings {
        Settings {
            bodies: self.arguments.bodies,
            seed: self.arguments.options.seed,
            rigid: self.arguments.rigid,
            level: self.spheres.level,
            asset: hash(&self.model),
        }
    }

    fn count(&self) -> usize {
        self.arguments.bodies as usize
    }

    fn fallen(&self) -> usize {
        self.world.len()
    }

    fn add(&mut self, at: Transform) -> Result<(), Box<dyn Error>> {
        self.world.add_body(self.of, Frame::Free, at)?;
        Ok(())
    }

    fn due(&self) -> Result<Vec<Transform>, Box<dyn Error>> {
        Ok((self.waves).before(self.world.steps(), &self.positions()?))
    }

    fn spheres(&self) -> &LevelSpheres {
        &self.spheres
    }

    fn extent(&self) -> f64 {
        self.extent
    }

    fn nodes(&self) -> [usize; 2] {
        self.nodes_each().map(|nodes| self.world.len() * nodes)
    }

    fn own(&mut self) -> Result<Own, Box<dyn Error>> {
        let (lowest_m, below) = ground(self)?;
        let below = below as f64;
        Ok(Own { lowest_m, below })
    }

    fn verdict(&self, log: &Log<Own>) -> Result<(), Box<dyn Error>> {
        let below = log.sum(|row| row.own.below);
        if below > 0.0 {
            return Err(format!("{below} contact spheres were below the ground").into());
        }
        Ok(())
    }

    fn models(&self) -> Vec<Model> {
        vec![self.model.clone()]
    }

    fn look(&self, body: usize) -> (usize, [u8; 3]) {
        (0, film::colour(body))
    }

    /// The square above which chairs begin to fall.
    fn view(&self) -> View {
        let wide = self.waves.half_width() as f32;
        // A heap is wider than the waves that make it.
        let away = match self.waves.waves() {
            1 => 2.4,
            waves => 3.1 + 0.02 * waves.min(50) as f32,
        };
        let away = away * wide + 1.5;
        let eye = [0.3 * away, 0.36 * away + 0.5, 0.88 * away];
        View {
            camera: film::view(eye, [0.0, 0.12 * wide + 0.2, 0.0]),
            floor: Floor {
                height: 0.0,
                middle: [0.0; 2],
                radius: 2.0 * wide + 1.0,
                colour: film::FLOOR,
            },
            contact_radius: Some(0.012 + 0.003 * wide),
            coarser_by: 0.5,
        }
    }

    fn pictures(&self) -> Vec<PathBuf> {
        self.arguments.updated.iter().cloned().collect()
    }

    fn draw(&self, show: &mut Show, log: &Log<Own>) -> Result<Value, Box<dyn Error>> {
        let Some(path) = &self.arguments.updated else {
            return Ok(Value::Null);
        };
        let updated = updated(self)?;
        show::write(path, &show.picture(self, &updated.spheres)?)?;
        Ok(
            json!({"nodes": updated.nodes, "spheres_shown": updated.spheres.len(),
            "counted_by_the_step": log.rows.last().map(|row| row.common.nodes_updated),
            "nodes_of_all_trees": self.nodes()[0]}),
        )
    }

    fn about(&self) -> About {
        let Arguments {
            rigid,
            redundant_updates,
            ..
        } = self.arguments;
        let kind = match (rigid, redundant_updates) {
            (false, _) => "deformable",
            (true, false) => "rigid",
            (true, true) => "rigid, redundant updates",
        };
        About {
            settings: json!({"rigid": rigid, "redundant_updates": redundant_updates}),
            spheres: report::told(&self.spheres, self.nodes_each()),
            table: row! {"bodies" => kind},
        }
    }

    fn totals(&self, log: &Log<Own>) -> (Value, Row) {
        let lowest = log.rows.iter().map(|row| row.own.lowest_m);
        let lowest = lowest.fold(f64::NAN, f64::min);
        let below = log.sum(|row| row.own.below);
        let (rise, share) = energy_rise(log, self.count());
        let value = json!({"lowest_m": lowest, "below": below, "energy_rise_J": rise,
            "energy_rise_share": share});
        (
            value,
            row! {"energy above its least so far, of the first" => share},
        )
    }
}

/// By how much the energy of all bodies, contacts included, was above its least value so far at most, J; and that as a share of the
/// energy when the last of them began to fall.
fn energy_rise(log: &Log<Own>, count: usize) -> (f64, f64) {
    let all = (log.rows.iter().map(|row| &row.common)).filter(|row| row.bodies == count as f64);
    let energies = all.map(|row| row.kinetic_J + row.modal_J + row.potential_J + row.contact_J);
    let (mut first, mut least, mut rise) = (f64::NAN, f64::INFINITY, 0.0_f64);
    for energy in energies {
        if first.is_nan() {
            first = energy;
        }
        least = least.min(energy);
        rise = rise.max(energy - least);
    }
    (rise, rise / first)
}
