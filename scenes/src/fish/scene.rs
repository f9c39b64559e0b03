//! The world, its bodies and what they have in common.

use std::error::Error;

use bdtree_dynamics::{
    BodyId, BodyOptions, ContactLaw, ContactShape, Frame, LevelSpheres, MassProperties, ModelId,
    World, WorldOptions,
};
use bdtree_render::Floor;
use bdtree_runtime::{Asset, Model, Transform};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::Arguments;
use super::bridge::Bridge;
use super::{assets, water};
use crate::falling::log::{Log, columns};
use crate::falling::show::View;
use crate::falling::waves::Waves;
use crate::falling::{About, Scene, hash, report};
use crate::{film, report::Row, row};

/// Softer than chairs are to each other, and damped so that little comes back: fish pushed against the bridge by those
/// above them otherwise gain speed where triangles of one plank push in many directions.
const LAW: ContactLaw = ContactLaw {
    stiffness: 2.0,
    damping_ratio: 0.7,
    friction: 0.4,
};

/// Fish fall from above the bridge and get faster than chairs, 14 m/s, and its planks are thin.
const STEPS_PER_S: u64 = 480;
const STEPS_PER_FRAME: u64 = STEPS_PER_S / 30;

/// The paper stops at level 7 of a binary tree.
const SPHERES: f64 = 128.0;

/// The bridge is the first body.
const BRIDGE: BodyId = BodyId(0);

/// Distance of neighbors in a wave, in reaches of a fish: they may turn.
const SPACING: f64 = 2.1;

/// Of the bridge's width, the part onto which fish fall.
const WIDTH: f64 = 0.8;

/// Height of a fish's center of mass above the bridge, or above those below it, m.
const ABOVE: f64 = 1.2;

/// Steps from a wave to the next.
const EVERY: u64 = STEPS_PER_S / 2;

/// How far modes may bend a fish, in multiples of 5 % of its length.
const STRAIN_LIMIT: f64 = 2.0;

/// Of the bridge, the water, and the fish.
const PAINT: [u8; 3] = [94, 112, 104];
const WATER: [u8; 3] = [120, 152, 168];
const COLOURS: [[u8; 3]; 6] = [
    [226, 130, 60],
    [196, 202, 208],
    [70, 120, 168],
    [232, 190, 92],
    [126, 160, 150],
    [206, 108, 96],
];

/// A world in which fish fall onto a bridge.
pub(super) struct Fish {
    arguments: Arguments,
    world: World,
    fish: Model,
    bridge: Bridge,
    of: ModelId,
    spheres: LevelSpheres,
    extent: f64,
    mass_kg: f64,
    waves: Waves,
    /// Centers of mass before the step.
    before: Vec<[f64; 3]>,
}

/// What must be the same in the run that goes on. The number of threads, pictures and checks may differ.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Settings {
    bodies: u32,
    seed: u64,
    level: usize,
    asset: String,
    bridge: String,
}

columns! {
/// What only fish on a bridge tell.
Own {
    /// Pairs of contact spheres of fish that push each other, and those that push the bridge.
    fish_contacts,
    bridge_contacts,
    /// Fish that touch the bridge, and those in the water.
    touching,
    in_water,
    /// Processor seconds that finding contacts took: of fish with fish, and of fish with triangles of the bridge.
    fish_seconds,
    triangle_seconds,
    /// Centers of mass whose way in this step met a triangle of the bridge.
    passed,
    /// How far the bridge's middle is from its rest, up and across.
    heave_m,
    sway_m,
}
}

impl Fish {
    pub(super) fn new(
        arguments: Arguments,
        fish: Model,
        bridge: Bridge,
    ) -> Result<Self, Box<dyn Error>> {
        let mut world = World::new(WorldOptions {
            law: LAW,
            step_s: 1.0 / STEPS_PER_S as f64,
            // As in the paper, every body takes part in every step.
            sleep_speed: 0.0,
            threads: usize::from(arguments.options.threads),
            ..WorldOptions::default()
        })?;
        let of_bridge = BodyOptions {
            // Leaves are thin.
            contact: ContactShape::Triangles,
            // Frames reach the range of each mode.
            strain_limit: f64::INFINITY,
            ..BodyOptions::default()
        };
        let of_fish = BodyOptions {
            scale: assets::FISH_SCALE,
            level: arguments.level.or_else(|| Some(level(fish.asset()))),
            strain_limit: STRAIN_LIMIT,
            ..BodyOptions::default()
        };
        let of = world.add_model(&bridge.model, &of_bridge)?;
        world.add_body(of, Frame::Driven, Transform::IDENTITY)?;
        let q = bridge.q(0.0);
        world.set_modes(BRIDGE, &q, &vec![0.0; q.len()])?;
        let of = world.add_model(&fish, &of_fish)?;
        let mass_kg = world.model(of)?.mass_kg();
        let spheres = world.model(of)?.spheres().clone();
        let reaches = (0..spheres.len()).map(|k| spheres.rest_center(k).norm() + spheres.radius(k));
        let extent = reaches.fold(0.0, f64::max);
        let mass = MassProperties::of(fish.asset());
        let center = mass.ok_or("the fish has no mass properties")?.center;
        let spacing = SPACING * extent;
        let [low, high] = bridge.bounds();
        let fitting = |length: f64| ((length / spacing) as usize).max(1);
        let waves = Waves {
            seed: arguments.options.seed,
            count: arguments.bodies as usize,
            columns: fitting(high[0] - low[0] - 2.0 * spacing),
            rows: fitting(WIDTH * (high[2] - low[2])),
            spacing,
            above: ABOVE,
            every: EVERY,
            center: center.into(),
            scale: assets::FISH_SCALE,
            onto: Some(bridge.heights()),
        };
        Ok(Self {
            arguments,
            world,
            fish,
            bridge,
            of,
            spheres,
            extent,
            mass_kg: mass_kg.ok_or("the fish has no mass")?,
            waves,
            before: Vec::new(),
        })
    }

    /// Seconds since the beginning after so many steps.
    fn time(&self, steps: f64) -> f64 {
        steps * self.world.options().step_s
    }
}

/// The level with about as many spheres as the paper's.
fn level(asset: &Asset<'_>) -> usize {
    let lanes = |level: usize| 8.0 * asset.node_count_to(level) as f64;
    let off = |level: &usize| (lanes(*level) / SPHERES).ln().abs();
    let levels = 0..asset.depth();
    levels.min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0)
}

impl Scene for Fish {
    const NAME: &'static str = "fish";
    const STEPS_PER_FRAME: u64 = STEPS_PER_FRAME;
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
            level: self.spheres.level,
            asset: hash(&self.fish),
            bridge: hash(&self.bridge.model),
        }
    }

    fn count(&self) -> usize {
        self.arguments.bodies as usize
    }

    fn fallen(&self) -> usize {
        self.world.len() - 1
    }

    fn add(&mut self, at: Transform) -> Result<(), Box<dyn Error>> {
        let at = Transform {
            scale: assets::FISH_SCALE,
            ..at
        };
        self.world.add_body(self.of, Frame::Free, at)?;
        Ok(())
    }

    fn due(&self) -> Result<Vec<Transform>, Box<dyn Error>> {
        Ok((self.waves).before(self.world.steps(), &self.positions()?))
    }

    fn drive(&mut self) -> Result<(), Box<dyn Error>> {
        let end = self.time((self.world.steps() + 1) as f64);
        let q = self.bridge.q(end);
        self.world.drive(BRIDGE, &q, Transform::IDENTITY)?;
        for body in self.falling() {
            water::push(&mut self.world, BodyId(body), self.mass_kg)?;
        }
        self.before = self.positions()?;
        Ok(())
    }

    fn spheres(&self) -> &LevelSpheres {
        &self.spheres
    }

    fn extent(&self) -> f64 {
        self.extent
    }

    fn nodes(&self) -> [usize; 2] {
        let asset = self.bridge.model.asset();
        let bridge = [asset.node_count(); 2];
        let asset = self.fish.asset();
        let each = [asset.node_count(), asset.node_count_to(self.spheres.level)];
        [0, 1].map(|k| bridge[k] + self.fallen() * each[k])
    }

    fn own(&mut self) -> Result<Own, Box<dyn Error>> {
        let (mut of_fish, mut of_bridge, mut touching) =
            (0_u64, 0_u64, vec![false; self.world.len()]);
        for contact in self.world.contacts() {
            if contact.force == [0.0; 3] {
                continue;
            }
            let bodies = contact.bodies.map(|body| body.map(BodyId));
            if bodies.contains(&Some(BRIDGE)) {
                of_bridge += 1;
                for BodyId(body) in bodies.into_iter().flatten() {
                    touching[body] = true;
                }
            } else {
                of_fish += 1;
            }
        }
        touching[BRIDGE.0] = false;
        let after = self.positions()?;
        let in_water = after.iter().filter(|at| water::is_in(at[1])).count();
        let steps = self.world.steps() as f64;
        // The bridge moves meanwhile: as it is in the middle.
        let ways = self.before.iter().zip(&after).map(|(a, b)| [*a, *b]);
        let middle = self.time(steps - 0.5);
        let passed = self.bridge.crossed(middle, ways)?;
        let times = self.world.times();
        let [_, heave_m, sway_m] = self.bridge.sway(self.time(steps))?;
        Ok(Own {
            fish_contacts: of_fish as f64,
            bridge_contacts: of_bridge as f64,
            touching: touching.into_iter().filter(|touches| *touches).count() as f64,
            in_water: in_water as f64,
            fish_seconds: times.spheres_s,
            triangle_seconds: times.triangles_s,
            passed: passed as f64,
            heave_m,
            sway_m,
        })
    }

    fn verdict(&self, log: &Log<Own>) -> Result<(), Box<dyn Error>> {
        let passed = log.sum(|row| row.own.passed);
        if passed > 0.0 {
            return Err(
                format!("{passed} times the center of a fish went through the bridge").into(),
            );
        }
        Ok(())
    }

    fn models(&self) -> Vec<Model> {
        vec![self.bridge.model.clone(), self.fish.clone()]
    }

    fn look(&self, body: usize) -> (usize, [u8; 3]) {
        if BodyId(body) == BRIDGE {
            return (0, PAINT);
        }
        (1, film::colour_of(body, &COLOURS))
    }

    fn view(&self) -> View {
        let [low, high] = self.bridge.bounds();
        let [wide, tall] = [0, 1].map(|k| (high[k] - low[k]) as f32);
        let deep = (high[2] - low[2]) as f32;
        let camera = if self.arguments.whole {
            film::view(
                [0.5 * wide, 0.18 * wide, 0.8 * wide],
                [0.0, -0.02 * wide, 0.0],
            )
        } else {
            film::view([2.6 * deep, 1.3 * tall, 3.2 * deep], [0.0, 0.2 * tall, 0.0])
        };
        View {
            camera,
            floor: Floor {
                height: water::SURFACE_M as f32,
                middle: [0.0; 2],
                radius: 3.0 * wide,
                colour: WATER,
            },
            contact_radius: None,
            coarser_by: 0.5,
        }
    }

    fn about(&self) -> About {
        let asset = self.fish.asset();
        let each = [asset.node_count(), asset.node_count_to(self.spheres.level)];
        let spheres = self
            .world
            .model_of(BRIDGE)
            .map(|model| model.spheres().len());
        About {
            settings: json!({"water_m": water::SURFACE_M, "fish_kg": self.mass_kg,
                "bridge": self.bridge.told().unwrap_or(Value::Null)}),
            spheres: report::told(&self.spheres, each),
            table: row! {"bodies" => "fish", "spheres of the bridge" => spheres.unwrap_or(0)},
        }
    }

    fn times(&self, log: &Log<Own>) -> (Value, Row) {
        let value = json!({"fish_with_fish_s": log.about(|row| row.own.fish_seconds),
            "fish_with_triangles_s": log.about(|row| row.own.triangle_seconds)});
        let per_step = |sum: f64| sum / log.rows.len().max(1) as f64;
        let row = row! {
            "fish with fish, processor s per step" => per_step(log.sum(|row| row.own.fish_seconds)),
            "fish with triangles" => per_step(log.sum(|row| row.own.triangle_seconds)),
        };
        (value, row)
    }

    fn totals(&self, log: &Log<Own>) -> (Value, Row) {
        let last = log.rows.last().map(|row| row.own);
        let passed = log.sum(|row| row.own.passed);
        let value = json!({
            "fish_contacts": log.about(|row| row.own.fish_contacts),
            "bridge_contacts": log.about(|row| row.own.bridge_contacts),
            "touching": last.map(|own| own.touching), "in_water": last.map(|own| own.in_water),
            "passed": passed, "sway_m": log.most(|row| row.own.sway_m.abs()),
            "heave_m": log.most(|row| row.own.heave_m.abs()),
        });
        let row = row! {
            "of them with the bridge" => log.sum(|row| row.own.bridge_contacts),
            "in the water" => last.map_or(f64::NAN, |own| own.in_water), "passed" => passed,
        };
        (value, row)
    }
}
