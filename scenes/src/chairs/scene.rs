//! The world, its bodies and what they have in common.

use std::error::Error;

use bdtree_dynamics::{
    BodyId, BodyOptions, ContactLaw, Frame, LevelSpheres, MassProperties, ModelId, Plane, World,
    WorldOptions,
};
use bdtree_runtime::{Model, Transform};

use super::Arguments;
use super::waves::Waves;

/// What contacts are made of: stiffer and less springy than what worlds have by themselves, as chairs are.
const LAW: ContactLaw = ContactLaw {
    stiffness: 3.0,
    damping_ratio: 0.3,
    friction: 0.4,
};

/// A world in which bodies of one asset fall.
pub(super) struct Scene {
    pub(super) world: World,
    pub(super) model: Model,
    of: ModelId,
    pub(super) spheres: LevelSpheres,
    /// How far any contact sphere of an undeformed body reaches from the center of mass.
    pub(super) extent: f64,
    pub(super) waves: Waves,
}

impl Scene {
    pub(super) fn new(arguments: &Arguments, model: Model) -> Result<Self, Box<dyn Error>> {
        let options = WorldOptions {
            law: LAW,
            // As in the paper, every body takes part in every step.
            sleep_speed: 0.0,
            threads: usize::from(arguments.threads),
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
        let waves = Waves::new(arguments.seed, arguments.bodies as usize, center, extent);
        Ok(Self {
            world,
            model,
            of,
            spheres,
            extent,
            waves,
        })
    }

    /// Adds a body. Where the world is restored afterwards, its place does not matter.
    pub(super) fn add(&mut self, at: Transform) -> Result<(), Box<dyn Error>> {
        self.world.add_body(self.of, Frame::Free, at)?;
        Ok(())
    }

    /// Adds the bodies that begin to fall now.
    pub(super) fn add_wave(&mut self) -> Result<(), Box<dyn Error>> {
        let step = self.world.steps();
        for at in self.waves.before(step, &self.positions()?) {
            self.add(at)?;
        }
        Ok(())
    }

    /// Centers of mass.
    pub(super) fn positions(&self) -> Result<Vec<[f64; 3]>, Box<dyn Error>> {
        let of = |body| Ok(self.world.state(BodyId(body))?.position);
        (0..self.world.len()).map(of).collect()
    }

    /// q of a body, as long as contact spheres take it.
    pub(super) fn q(&self, body: usize) -> Result<Vec<f64>, Box<dyn Error>> {
        let mut q = vec![0.0; self.spheres.mode_count()];
        self.world.q(BodyId(body), &mut q)?;
        q.resize(self.spheres.stride(), 0.0);
        Ok(q)
    }

    /// The world's state.
    pub(super) fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.world.save(&mut bytes);
        bytes
    }

    /// Nodes of a body's tree, and of those the nodes down to the level of its contact spheres.
    pub(super) fn nodes(&self) -> [usize; 2] {
        let asset = self.model.asset();
        [asset.node_count(), asset.node_count_to(self.spheres.level)]
    }
}
