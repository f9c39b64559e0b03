//! Steps that change little: fronts of pairs that stay close (P58), beside asking anew.

use bdtree_measure::Place;
use bdtree_runtime::{Motion, PairFront, TrianglePair, VertexId};
use bdtree_scenes::contenders::assets::baked;
use bdtree_scenes::workloads::bodies::{Bodies, MODES, bodies};
use nalgebra::Vector3;

use crate::prelude::*;

#[derive(Args)]
pub(crate) struct Arguments {
    /// Steps of each run
    #[arg(long, default_value_t = 200)]
    steps: usize,
    /// Steps from one frame of W2 to the next, run by run
    #[arg(long, value_delimiter = ',', default_value = "1,10,100,1000")]
    speeds: Vec<usize>,
}

/// Pairs of leaves that a front has room for, 16 bytes each.
const FRONT_SLOTS: usize = 4096;

pub(crate) fn run(arguments: &Arguments, rounds: usize) -> Result<Vec<Table>> {
    let work = bodies();
    let model = baked(&work.body)?;
    let mut fronts = Vec::new();
    for (place, apart) in [("touching", 0.0), ("0.15 apart", 0.15), ("0.5 apart", 0.5)] {
        for speed in &arguments.speeds {
            let run = Run {
                asset: *model.asset(),
                work: &work,
                steps: arguments.steps,
                per_frame: *speed,
                rounds,
            };
            fronts.extend(run.pairs(place, apart)?);
        }
    }
    let title = "W2's two bodies, per step; the motion is the largest in a step";
    Ok(vec![table("pairs", title, &fronts)])
}

/// q of one of the two bodies after so many steps, frames joined by straight lines.
fn at(work: &Bodies, body: usize, step: usize, per_frame: usize) -> Vec<f32> {
    let frames = work.q[body].len() / MODES;
    let (frame, part) = (step / per_frame, step % per_frame);
    let q = |frame: usize| &work.q[body][frame % frames * MODES..][..MODES];
    let share = part as f32 / per_frame as f32;
    let pairs = q(frame).iter().zip(q(frame + 1));
    pairs.map(|(a, b)| a + share * (b - a)).collect()
}

/// The way of the vertex that moves most in a step, in the mean over the steps, in per cent of the diagonal.
fn motion(poses: &[Pose<'_>]) -> Result<f64> {
    let (mut sum, mut low, mut high) = (0.0, [f64::MAX; 3].into(), [f64::MIN; 3].into());
    let some = &poses[..poses.len().min(20)];
    for two in some.windows(2) {
        let mut most = 0.0_f64;
        for i in 0..two[0].asset().vertex_count() as u32 {
            let [a, b] = [0, 1].map(|k| two[k].deformed(VertexId(i)).map(Vector3::from));
            let (a, b) = (a?, b?);
            most = most.max((a - b).norm());
            (low, high) = (a.inf(&low), a.sup(&high));
        }
        sum += most;
    }
    Ok(100.0 * sum / (some.len() - 1) as f64 / (high - low).norm())
}

/// So many steps, which are so many a frame of W2.
struct Run<'a> {
    asset: Asset<'a>,
    work: &'a Bodies,
    steps: usize,
    per_frame: usize,
    rounds: usize,
}

impl Run<'_> {
    /// Poses of a body at all steps.
    fn poses<'m>(
        &'m self,
        body: usize,
        place: Transform,
        memory: &'m mut Vec<f32>,
    ) -> Result<Vec<Pose<'m>>> {
        let len = self.asset.pose_len();
        memory.resize(self.steps * len, 0.0);
        let pose = |(step, memory): (usize, &'m mut [f32])| {
            let q = at(self.work, body, step, self.per_frame);
            Ok(self.asset.pose(&q, place, memory)?)
        };
        memory.chunks_exact_mut(len).enumerate().map(pose).collect()
    }

    /// Two bodies so far apart, from the root and with a front.
    fn pairs(&self, place_name: &str, apart: f64) -> Result<Vec<Row>> {
        let work = self.work;
        let [x, y, z] = work.places[0].translation;
        let far = 1.0 + apart / (x * x + y * y + z * z).sqrt();
        let place = Place {
            translation: [x * far, y * far, z * far],
            ..work.places[0]
        };
        let (mut memory_a, mut memory_b) = (Vec::new(), Vec::new());
        let a = &self.poses(0, Transform::IDENTITY, &mut memory_a)?;
        let b = &self.poses(1, place.transform(), &mut memory_b)?;
        let run = |name: &str, has_front: bool| {
            let mut workspace = Workspace::new();
            let mut found: Vec<TrianglePair> = Vec::new();
            Entry::new(name, Role::Ours, Counts::Same, move |_| {
                let mut slots = vec![0; PairFront::SLOT_BYTES * FRONT_SLOTS];
                let mut front = PairFront::in_bytes(&mut slots);
                let mut motions = [Motion::new(&a[0]), Motion::new(&b[0])];
                frame(|| {
                    let mut answer = Answer::default();
                    for step in 0..self.steps {
                        found.clear();
                        if has_front {
                            let before = step.saturating_sub(1);
                            motions[0].advance(&a[before], &a[step])?;
                            motions[1].advance(&b[before], &b[step])?;
                            let one = a[step].moving(&motions[0])?;
                            let two = b[step].moving(&motions[1])?;
                            let pair = one.against(&two, &mut workspace);
                            pair.front(&mut front).triangle_pairs(0.0, &mut found)?;
                        } else {
                            let mut pair = a[step].against(&b[step], &mut workspace);
                            pair.triangle_pairs(0.0, &mut found)?;
                        }
                        answer.nodes.add(workspace.stats());
                        answer.found += found.len() as u64;
                    }
                    Ok(answer)
                })
            })
        };
        let entries = vec![run("from the root", false), run("front", true)];
        let about = row! {"place" => place_name, "motion, %" => motion(a)?};
        let measured = compare(entries, 1, self.rounds)?;
        Ok(rows(&about, &measured, self.steps, "µs per step"))
    }
}

#[cfg(test)]
mod tests {
    use bdtree_scenes::workloads::bodies::{MODES, bodies};

    use super::at;

    #[test]
    fn steps_join_frames() {
        let work = bodies();
        let frame = |k: usize| work.q[1][k * MODES..(k + 1) * MODES].to_vec();
        assert_eq!(at(&work, 1, 20, 10), frame(2));
        let between = at(&work, 1, 25, 10);
        for j in 0..MODES {
            let middle = 0.5 * (frame(2)[j] + frame(3)[j]);
            assert!((between[j] - middle).abs() <= 1e-6 * middle.abs().max(1e-3));
        }
    }
}
