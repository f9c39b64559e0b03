//! Lets chairs fall on a heap under rapier, flexible ones and then ones at q = 0, and prints what a step takes. While flexible ones
//! fall, chairs at q = 0 go on from where they are ten times a second, for as many steps: the same heap, without modes.
//!
//!     cargo run --release -p bdtree-parry --features rapier --example heap -- 24 4
//!
//! The example `soft_heap` lets rapier's own soft bodies fall.
//!
//! Arguments: chairs (4), simulated seconds (1), file (the chair of the fixtures, baked coarsely).

use std::time::Instant;

use bdtree_parry::{
    DeformingMesh, DeformingModel, FlexibleBodies, FlexibleOptions, MeshDispatcher,
};
use bdtree_runtime::Model;
use rapier3d::parry::query::PersistentQueryDispatcher;
use rapier3d::prelude::*;

/// Steps per second: chairs fall by several centimeters in a sixtieth, which is more than their legs are thick, and those that
/// passed into each other lie less still.
pub const RATE: usize = 240;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let chairs: usize = args.next().map_or(Ok(4), |text| text.parse())?;
    let seconds: f32 = args.next().map_or(Ok(1.0), |text| text.parse())?;
    let file = match args.next() {
        Some(path) => Model::read(path)?,
        None => bdtree_fixtures::bake::elastic("chair", 6, 30, &[]),
    };
    let model = DeformingModel::new(&file, 1.0)?;
    let mut totals = [Times::default(); 2];
    for (total, is_deformable) in totals.iter_mut().zip([true, false]) {
        println!(
            "{chairs} chairs, {}",
            if is_deformable { "flexible" } else { "q = 0" }
        );
        let mut heap = Heap::new(&model, chairs, is_deformable)?;
        let steps = (seconds * RATE as f32) as usize;
        for second in 0..steps.div_ceil(RATE) {
            let mut count = (steps - RATE * second).min(RATE);
            let mut times = Times::default();
            while count > 0 {
                times.add(&heap.steps(count.min(WINDOW), &model)?);
                count -= count.min(WINDOW);
            }
            total.add(&times);
            print!(
                "{:3} s: {:8.3} ms per step, {:10.3e} J in motion, {:5.1} mm into each other, {} asleep",
                second + 1,
                times.ms_per_step(),
                heap.kinetic_energy(),
                1e3 * heap.overlap()?,
                heap.asleep()
            );
            match is_deformable {
                true => println!(
                    ", {:.2} times q = 0 from the same places",
                    times.over_rigid()
                ),
                false => println!(),
            }
        }
    }
    let [flexible, rigid] = totals;
    println!(
        "flexible over q = 0: {:.2}, from the same places {:.2}",
        flexible.all_s / rigid.all_s,
        flexible.over_rigid()
    );
    Ok(())
}

/// Steps until chairs at q = 0 begin again where the flexible ones are...
const WINDOW: usize = RATE / 10;

/// ...and of them, those in which they find their contacts and forces, which are not compared.
const BEGIN: usize = 2;

/// What steps have taken.
#[derive(Debug, Clone, Copy, Default)]
struct Times {
    steps: usize,
    all_s: f64,
    /// Without the first steps of each window, of this heap and of chairs at q = 0 from the same places.
    compared_s: [f64; 2],
}

impl Times {
    fn add(&mut self, more: &Self) {
        self.steps += more.steps;
        self.all_s += more.all_s;
        for (own, more) in self.compared_s.iter_mut().zip(more.compared_s) {
            *own += more;
        }
    }

    fn ms_per_step(&self) -> f64 {
        1e3 * self.all_s / self.steps as f64
    }

    fn over_rigid(&self) -> f64 {
        self.compared_s[0] / self.compared_s[1]
    }
}

/// An empty world with a floor, and walls around so many chairs.
pub fn room(count: usize) -> PhysicsWorld {
    let mut world = PhysicsWorld::new();
    world.integration_parameters.dt = 1.0 / RATE as f32;
    let half = bdtree_fixtures::heap::half_width(count);
    world.insert_collider(
        ColliderBuilder::cuboid(20.0, 0.5, 20.0).translation(Vector::new(0.0, -0.5, 0.0)),
        None,
    );
    for (x, z) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
        let at = Vector::new(x * (half + 0.5), 100.0, z * (half + 0.5));
        let thick = |along: f32| if along == 0.0 { half + 1.0 } else { 0.5 };
        let wall = ColliderBuilder::cuboid(thick(x), 100.0, thick(z)).translation(at);
        world.insert_collider(wall, None);
    }
    world
}

/// Where chair `k` of `count` starts.
pub fn start(k: usize, count: usize) -> Pose {
    let [at, turn] = bdtree_fixtures::heap::start(k, count).map(Vector::from_array);
    Pose::new(at, turn)
}

/// Chairs above a floor with walls.
pub struct Heap {
    /// The rigid side.
    pub world: PhysicsWorld,
    /// Their modes.
    pub flexible: FlexibleBodies,
    /// Frame and collider of each chair.
    pub chairs: Vec<(RigidBodyHandle, ColliderHandle)>,
    /// Whether they have modes.
    pub is_deformable: bool,
}

impl Heap {
    /// Chairs at their [`start`]s.
    pub fn new(
        model: &DeformingModel,
        count: usize,
        is_deformable: bool,
    ) -> Result<Self, Box<dyn std::error::Error>> {
        let mut world = room(count);
        world.narrow_phase = NarrowPhase::with_query_dispatcher(MeshDispatcher::new());
        let mut flexible = FlexibleBodies::new();
        let options = FlexibleOptions {
            is_deformable,
            ..FlexibleOptions::default()
        };
        let mut chairs = Vec::new();
        for k in 0..count {
            // They fall by more than their legs are thick in a step: contacts are looked for as far ahead.
            let frame = RigidBodyBuilder::dynamic()
                .pose(start(k, count))
                .soft_ccd_prediction(0.2);
            let (bodies, colliders) = (&mut world.bodies, &mut world.colliders);
            chairs.push(flexible.insert(model, &options, frame, bodies, colliders)?);
        }
        Ok(Self {
            world,
            flexible,
            chairs,
            is_deformable,
        })
    }

    /// Goes on for so many steps, and then lets chairs at q = 0 do so from the same places, if these are flexible.
    fn steps(
        &mut self,
        count: usize,
        model: &DeformingModel,
    ) -> Result<Times, Box<dyn std::error::Error>> {
        let mut rigid = match self.is_deformable {
            true => Some(self.rigid(model)?),
            false => None,
        };
        let (begin_s, rest_s) = self.timed(count)?;
        let rigid_s = rigid
            .as_mut()
            .map_or(Ok((0.0, 0.0)), |heap| heap.timed(count))?;
        Ok(Times {
            steps: count,
            all_s: begin_s + rest_s,
            compared_s: [rest_s, rigid_s.1],
        })
    }

    /// Seconds that the first and the other steps take.
    fn timed(&mut self, count: usize) -> Result<(f64, f64), Box<dyn std::error::Error>> {
        let mut run = |count: usize| -> Result<f64, Box<dyn std::error::Error>> {
            let start = Instant::now();
            for _ in 0..count {
                self.flexible.step(&mut self.world)?;
            }
            Ok(start.elapsed().as_secs_f64())
        };
        let begin = count.min(BEGIN);
        Ok((run(begin)?, run(count - begin)?))
    }

    /// Chairs at q = 0 that are where these are, and as fast.
    fn rigid(&self, model: &DeformingModel) -> Result<Self, Box<dyn std::error::Error>> {
        let mut rigid = Self::new(model, self.chairs.len(), false)?;
        for ((from, _), (to, _)) in self.chairs.iter().zip(&rigid.chairs) {
            let from = &self.world.bodies[*from];
            let to = &mut rigid.world.bodies[*to];
            to.set_position(*from.position(), true);
            to.set_linvel(from.linvel(), true);
            to.set_angvel(from.angvel(), true);
            if from.is_sleeping() {
                to.sleep();
            }
        }
        Ok(rigid)
    }

    /// Of frames and modes, joules.
    pub fn kinetic_energy(&self) -> f64 {
        let each = self.chairs.iter().map(|(frame, collider)| {
            let of_frame = f64::from(self.world.bodies[*frame].kinetic_energy());
            of_frame + self.flexible.modal_kinetic_energy(*collider).unwrap_or(0.0)
        });
        each.sum()
    }

    /// How far any two chairs reach into each other, meters, asked anew.
    pub fn overlap(&self) -> Result<f64, Box<dyn std::error::Error>> {
        let mut meshes = Vec::new();
        for (_, collider) in &self.chairs {
            let mesh = self.flexible.mesh(*collider).ok_or("a chair")?;
            // A mesh of its own knows no contacts.
            let fresh = DeformingMesh::new(mesh.model(), mesh.q())?;
            meshes.push((fresh, *self.world.colliders[*collider].position()));
        }
        let mut deepest: f32 = 0.0;
        for (k, (one, at)) in meshes.iter().enumerate() {
            for (two, other) in &meshes[..k] {
                let mut manifolds: Vec<ContactManifold> = Vec::new();
                let pos12 = at.inv_mul(other);
                MeshDispatcher::new()
                    .contact_manifolds(&pos12, one, two, 0.0, &mut manifolds, &mut None)
                    .map_err(|_| "two meshes")?;
                let points = manifolds.iter().flat_map(|manifold| &manifold.points);
                deepest = points.fold(deepest, |most, point| most.max(-point.dist));
            }
        }
        Ok(f64::from(deepest))
    }

    /// How many chairs sleep.
    pub fn asleep(&self) -> usize {
        let frames = self
            .chairs
            .iter()
            .map(|(frame, _)| &self.world.bodies[*frame]);
        frames.filter(|frame| frame.is_sleeping()).count()
    }
}
