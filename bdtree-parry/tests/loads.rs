//! Loads that last bend flexible bodies as far as their stiffness says.

use std::sync::OnceLock;

use bdtree_build::basis::elastic::ElasticOptions;
use bdtree_fixtures::bake;
use bdtree_parry::DeformingModel;
use bdtree_runtime::{Instance, Model, VertexId};

use super::ours::{FlexibleBodies, FlexibleOptions, MeshDispatcher};
use super::parry::math::Real;
use super::rapier::prelude::*;

/// A rubber beam of 1 m, 5 cm thick: of 20 MPa, which sags by 1 cm under its weight.
fn beam() -> &'static Model {
    static BEAM: OnceLock<Model> = OnceLock::new();
    BEAM.get_or_init(|| {
        let options = ElasticOptions {
            mode_count: 6,
            resolution: Some(40),
            young_pa: 2e7,
            ..ElasticOptions::default()
        };
        bake::elastic_of("beam", &options)
    })
}

/// q where forces (N, upwards) at points of the beam are balanced by its stiffness: `Uᵀ f = K q`.
fn balanced(forces: &[([f64; 3], f64)]) -> Vec<f64> {
    let asset = beam().asset();
    let at_rest: Vec<[f64; 3]> = (asset.positions().iter())
        .map(|p| std::array::from_fn(|k| f64::from(p[k]) * asset.unit() + asset.origin()[k]))
        .collect();
    let nearest = |point: &[f64; 3]| {
        let distance = |vertex: usize| {
            (0..3)
                .map(|k| (at_rest[vertex][k] - point[k]).powi(2))
                .sum::<f64>()
        };
        let vertices = 0..at_rest.len();
        vertices.min_by(|a, b| distance(*a).total_cmp(&distance(*b)))
    };
    let mut instance = Instance::new(beam()).expect("an instance");
    let each = asset.modes().iter().enumerate().map(|(k, mode)| {
        const SMALL: f64 = 1e-3;
        let mut q = vec![0.0; asset.modes().len()];
        q[k] = SMALL as f32;
        instance.set_q(&q).expect("a pose");
        let work = forces.iter().map(|(point, up)| {
            let vertex = nearest(point).expect("vertices");
            let moved = instance
                .pose()
                .deformed(VertexId(vertex as u32))
                .expect("a vertex");
            up * (moved[1] - at_rest[vertex][1]) / SMALL
        });
        work.sum::<f64>() / (mode.modal_mass_kg.get() * mode.omega_rad_s.get().powi(2))
    });
    each.collect()
}

/// The beam on two edges 76 cm apart, and a load of this many kg on its middle.
struct Bridge {
    world: PhysicsWorld,
    flexible: FlexibleBodies,
    frame: RigidBodyHandle,
    collider: ColliderHandle,
    load: RigidBodyHandle,
}

impl Bridge {
    fn new(load_kg: f64, steps_per_second: u32) -> Self {
        let mut world = PhysicsWorld::new();
        world.narrow_phase = NarrowPhase::with_query_dispatcher(MeshDispatcher::new());
        world.integration_parameters.dt = 1.0 / steps_per_second as Real;
        for x in [0.1, 0.9] {
            let support = ColliderBuilder::cuboid(0.02, 0.1, 0.1);
            world.insert_collider(support.translation(Vector::new(x, -0.1, 0.0)), None);
        }
        let model = DeformingModel::new(beam(), 1.0).expect("a model");
        let mut flexible = FlexibleBodies::new();
        let frame = RigidBodyBuilder::dynamic().translation(Vector::new(0.0, 0.026, 0.0));
        let options = FlexibleOptions::default();
        let (frames, colliders) = (&mut world.bodies, &mut world.colliders);
        let made = flexible.insert(&model, &options, frame, frames, colliders);
        let (frame, collider) = made.expect("a body");
        let load = RigidBodyBuilder::dynamic().translation(Vector::new(0.5, 0.073, 0.0));
        let cube = ColliderBuilder::cuboid(0.02, 0.02, 0.02).mass(load_kg as Real);
        let (load, _) = world.insert(load, cube);
        Self {
            world,
            flexible,
            frame,
            collider,
            load,
        }
    }

    fn run(&mut self, seconds: Real) {
        let steps = seconds / self.world.integration_parameters.dt;
        for _ in 0..steps.round() as usize {
            self.flexible.step(&mut self.world).expect("a step");
        }
    }

    /// How far the beam may be from balance under this load, meters: each mode's farthest vertex, added up.
    fn off(&self, load_kg: f64) -> f64 {
        let weight = (f64::from(self.world.bodies[self.frame].mass()) + load_kg) * 9.81;
        let load = load_kg * -9.81;
        let balanced = balanced(&[
            ([0.12, -0.025, 0.0], 0.5 * weight),
            ([0.88, -0.025, 0.0], 0.5 * weight),
            ([0.48, 0.025, 0.0], 0.5 * load),
            ([0.52, 0.025, 0.0], 0.5 * load),
        ]);
        let q = self.flexible.q(self.collider).expect("modes");
        let modes = beam().asset().modes().iter();
        let each = modes.zip(balanced).zip(q).map(|((mode, goal), q)| {
            let reach = f64::from(mode.field_norm_max.get()) * beam().asset().unit();
            (goal - f64::from(q)).abs() * reach
        });
        each.sum()
    }
}

/// Half a percent of the beam's radius: how far colliders may be from the mesh.
const TOLERANCE: f64 = 2.5e-3;

#[test]
fn a_load_bends_a_beam_as_far_as_its_stiffness_says() {
    for (load_kg, steps_per_second) in [(0.5, 60), (0.5, 240), (1.5, 60), (1.5, 240)] {
        let mut bridge = Bridge::new(load_kg, steps_per_second);
        bridge.run(6.0);
        let off = bridge.off(load_kg);
        assert!(off < TOLERANCE, "{load_kg} kg, {steps_per_second}: {off} m");
        // Straight it would be far from it.
        let bent = bridge.flexible.q(bridge.collider).expect("modes")[0];
        assert!(f64::from(bent.abs()) > 4.0 * TOLERANCE, "{bent}");
        for body in [bridge.frame, bridge.load] {
            assert!(bridge.world.bodies[body].is_sleeping());
        }
    }
}

/// A body at rest goes on bending once its load grows, and back once it is gone.
#[test]
fn a_beam_follows_its_load() {
    let mut bridge = Bridge::new(1.0, 120);
    bridge.run(4.0);
    assert!(bridge.world.bodies[bridge.frame].is_sleeping());
    let more = RigidBodyBuilder::dynamic().translation(Vector::new(0.5, 0.11, 0.0));
    let cube = ColliderBuilder::cuboid(0.02, 0.02, 0.02).mass(1.0);
    let (more, _) = bridge.world.insert(more, cube);
    bridge.run(4.0);
    let off = bridge.off(2.0);
    assert!(off < TOLERANCE, "{off}");
    for load in [bridge.load, more] {
        bridge.world.bodies[load].set_translation(Vector::new(5.0, 0.0, 0.0), true);
    }
    bridge.run(4.0);
    let off = bridge.off(0.0);
    assert!(off < TOLERANCE, "{off}");
}

/// Modes that a force bends to and fro, every second, go on less and less often. Once they have rested for long enough they
/// follow their load at once.
#[test]
fn a_beam_that_is_pressed_to_and_fro_comes_to_rest() {
    const MORE_KG: f64 = 1.5;
    let mut bridge = Bridge::new(1.0, 120);
    bridge.run(4.0);
    let press = |bridge: &mut Bridge, is_pressed: bool| {
        let load = &mut bridge.world.bodies[bridge.load];
        load.reset_forces(true);
        if is_pressed {
            load.add_force(Vector::new(0.0, -9.81 * MORE_KG as Real, 0.0), true);
        }
    };
    // The share of steps in which modes moved, of each four seconds.
    let mut shares = Vec::new();
    for _ in 0..8 {
        let mut moving = 0;
        for second in 0..4 {
            press(&mut bridge, second % 2 == 0);
            for _ in 0..120 {
                bridge.run(1.0 / 120.0);
                let energy = bridge.flexible.modal_kinetic_energy(bridge.collider);
                moving += i32::from(energy.expect("a body") > 0.0);
            }
        }
        shares.push(f64::from(moving) / 480.0);
    }
    let late = shares[4..].iter().sum::<f64>() / 4.0;
    assert!(shares[0] > 0.2 && late < 0.1, "{shares:?}");
    press(&mut bridge, true);
    bridge.run(10.0);
    let load = &mut bridge.world.bodies[bridge.load];
    load.set_translation(Vector::new(5.0, 0.0, 0.0), true);
    bridge.run(4.0);
    let off = bridge.off(0.0);
    assert!(off < TOLERANCE, "{off}");
}
