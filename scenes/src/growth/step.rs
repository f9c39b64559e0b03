//! Steps of balls on a moving body, ours beside a refitted tree: one step's times, and how many balls a step
//! it takes until refitting is ahead, which is asked, not extrapolated.

use std::error::Error;

use bdtree_measure::clock::Clock;
use bdtree_measure::comparison::{AMOUNTS, Ahead, Comparison, LEAF_SLOTS, MOST, Side, VISITS_MAX};
use bdtree_measure::deform::Deformer;
use bdtree_measure::peers::{Obvhs, Peer, Target};
use bdtree_measure::{Body, Place, stats};
use bdtree_runtime::{Asset, Contact};
use serde_json::{Value, json};

use crate::report::digits;
use crate::workloads::random::Stream;
use crate::workloads::{scale, sequence};
use bdtree_measure::ours::{self, Ours};

/// Steps of the motion.
pub(super) const STEPS: usize = 12;

/// Every so many steps are asked for a crossing …
const CROSSING_STEPS: usize = 3;

/// … and no more often than this.
const CROSSING_REPEATS: usize = 3;

/// A step: q and points of the deformed surface, no two the same.
struct Step {
    q: Vec<f32>,
    centers: Vec<[f32; 3]>,
}

/// Both contenders and what they are asked.
pub(super) struct Contenders<'a> {
    ours: Ours<'a>,
    nodes: usize,
    peer: Obvhs,
    deformer: Deformer,
    scratch: Vec<f32>,
    found: Vec<Contact>,
    steps: Vec<Step>,
    radius: f32,
}

/// Both at one number of balls; means over steps.
pub(super) struct Point {
    pub(super) balls: usize,
    pub(super) contacts: f64,
    pub(super) nodes: f64,
    /// Ours; theirs until the tree is refitted, and their queries.
    pub(super) seconds: [f64; 3],
}

impl Point {
    /// Deforming, refitting and asking over ours.
    pub(super) fn times(&self) -> f64 {
        let [ours, update, query] = self.seconds;
        (update + query) / ours
    }
}

impl<'a> Contenders<'a> {
    /// On a body whose farthest vertex moves by a share of its diagonal, with balls of a radius.
    pub(super) fn new(asset: Asset<'a>, body: &Body, displacement: f64, radius: f32) -> Self {
        let deformer = Deformer::new(body);
        let mut out = vec![0.0; deformer.count];
        let mut stream = Stream::new(17);
        let all = sequence(STEPS, body.modes, 0.8, 8);
        let steps = all.chunks_exact(body.modes).map(|q| {
            let mut q = q.to_vec();
            scale(body, &deformer, &mut q, displacement, &mut out);
            let points = out.as_chunks::<3>().0;
            Step {
                q,
                centers: (0..MOST)
                    .map(|_| on_surface(body, points, &mut stream))
                    .collect(),
            }
        });
        Self {
            steps: steps.collect(),
            nodes: asset.node_count(),
            ours: Ours::keeping(asset, LEAF_SLOTS),
            peer: Obvhs::new(body),
            deformer,
            scratch: Vec::new(),
            found: Vec::new(),
            radius,
        }
    }

    /// So many balls a step: every `every`-th step in turn, `repeats` times, medians.
    ///
    /// # Errors
    /// Contenders that do not find as many contacts.
    pub(super) fn measure(
        &mut self,
        balls: usize,
        every: usize,
        repeats: usize,
    ) -> Result<Point, Box<dyn Error>> {
        let count = self.steps.len().div_ceil(every);
        let mut times = vec![[const { Vec::new() }; 3]; count];
        let (mut contacts, mut nodes) = (0, 0);
        // Passes over all steps, so that no question is repeated while its branches are still known.
        for _ in 0..repeats {
            (contacts, nodes) = (0, 0);
            for (step, times) in self.steps.iter().step_by(every).zip(&mut times) {
                let centers = &step.centers[..balls];
                let radius = f64::from(self.radius);
                let own = centers.iter().map(|center| (center.map(f64::from), radius));
                let own = ours::frame(|| self.ours.balls(&step.q, own));
                let to = Target::without_bones(&self.deformer, &step.q, &Place::IDENTITY);
                let update = self.peer.update(to, &mut self.scratch);
                let start = Clock::start();
                let mut theirs = 0;
                for center in centers {
                    self.found.clear();
                    self.peer
                        .ball(center.map(f64::from), radius, &mut self.found);
                    theirs += self.found.len() as u64;
                }
                let query = start.seconds();
                if theirs != own.found {
                    return Err(
                        format!("{balls} balls: {} and {theirs} contacts", own.found).into(),
                    );
                }
                contacts += theirs;
                nodes += own.nodes.visited;
                times[0].push(own.query);
                times[1].push(update.deform + update.refit);
                times[2].push(query);
            }
        }
        let mean = |k: usize| {
            let medians = times.iter().map(|step| stats::median(&step[k]));
            medians.sum::<f64>() / count as f64
        };
        Ok(Point {
            balls,
            contacts: contacts as f64 / count as f64,
            nodes: nodes as f64 / count as f64,
            seconds: [mean(0), mean(1), mean(2)],
        })
    }

    /// Asks more and more balls a step, until refitting is safely ahead or the most is reached: 4096, or as
    /// many as visit every node a hundred times.
    ///
    /// # Errors
    /// Those of [`Contenders::measure`].
    pub(super) fn crossing(&mut self, repeats: usize) -> Result<Crossing, Box<dyn Error>> {
        let mut points = Vec::new();
        for balls in AMOUNTS {
            let point = self.measure(balls, CROSSING_STEPS, repeats.min(CROSSING_REPEATS))?;
            let is_over = Side::of(point.times()) == Some(Side::Refit)
                || point.nodes > VISITS_MAX * self.nodes as f64;
            points.push(point);
            if is_over {
                break;
            }
        }
        Ok(Crossing::of(&points))
    }
}

/// A random point of the deformed surface.
fn on_surface(body: &Body, points: &[[f32; 3]], stream: &mut Stream) -> [f32; 3] {
    let count = body.triangles.len();
    let triangle = ((count as f64 * stream.unit()) as usize).min(count - 1);
    let [a, b, c] = body.triangles[triangle].map(|v| points[v as usize].map(f64::from));
    let (mut s, mut t) = (stream.unit(), stream.unit());
    // Half of the parallelogram is folded onto the other.
    if s + t > 1.0 {
        (s, t) = (1.0 - s, 1.0 - t);
    }
    [0, 1, 2].map(|k| (a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k])) as f32)
}

/// Who is ahead over balls a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    comparison: Comparison,
    /// The most balls a step that were asked.
    most: usize,
}

impl Crossing {
    /// Of points by rising number of balls.
    pub(super) fn of(points: &[Point]) -> Self {
        let ratios: Vec<(f64, f64)> = points.iter().map(|p| (p.balls as f64, p.times())).collect();
        Self {
            comparison: Comparison::of(&ratios),
            most: points.last().map_or(0, |p| p.balls),
        }
    }

    /// For a table.
    pub(super) fn text(&self) -> String {
        let comparison = &self.comparison;
        match (comparison.ahead, comparison.break_even) {
            (Ahead::Ours, _) => format!("not up to {}", self.most),
            (Ahead::Refit, _) => "always".to_string(),
            (Ahead::Crosses, Some(at)) if comparison.above == Some(Side::Refit) => whole(at),
            (Ahead::Crosses, Some(at)) => format!("up to {}", whole(at)),
            _ => {
                let [from, to] =
                    [comparison.from, comparison.to].map(|x| x.map_or_else(String::new, whole));
                format!("even from {from} to {to}")
            }
        }
    }

    /// All of it; of times, so that it differs between runs.
    pub(super) fn json(&self) -> Value {
        let comparison = &self.comparison;
        json!({"ahead": format!("{:?}", comparison.ahead).to_lowercase(), "from": comparison.from,
            "to": comparison.to, "break_even_balls": comparison.break_even, "most_balls": self.most})
    }
}

/// Whole numbers without digits behind the point.
pub(super) fn whole(x: f64) -> String {
    if x.fract() == 0.0 {
        format!("{x:.0}")
    } else {
        digits(x)
    }
}

#[cfg(test)]
mod tests {
    use super::{Crossing, Point, whole};

    fn crossing(ratios: &[(usize, f64)]) -> Crossing {
        let point = |(balls, ratio): &(usize, f64)| Point {
            balls: *balls,
            contacts: 0.0,
            nodes: 0.0,
            seconds: [1.0, 0.25 * ratio, 0.75 * ratio],
        };
        Crossing::of(&ratios.iter().map(point).collect::<Vec<_>>())
    }

    #[test]
    fn crossings_are_told() {
        for (ratios, text) in [
            (&[(1, 20.0), (4096, 1.2)][..], "not up to 4096"),
            (&[(1, 0.5)], "always"),
            (&[(1, 10.0), (100, 0.1)], "10"),
            (&[(1, 0.5), (4, 2.0)], "up to 2"),
            (&[(1, 20.0), (64, 1.05), (256, 0.95)], "even from 1 to 256"),
        ] {
            let crossing = crossing(ratios);
            assert_eq!(crossing.text(), text);
            let is_crossing = crossing.json()["break_even_balls"].is_f64();
            assert_eq!(is_crossing, text == "10" || text == "up to 2");
        }
        assert_eq!(
            (whole(64.0), whole(2.5)),
            ("64".to_string(), "2.50".to_string())
        );
    }
}
