//! Standard questions to an asset, the same in every run: what they find, what they visit, how long they take.
//!
//! At every sample: [`BALLS`] balls about points of the deformed surface, [`RAYS`] rays from outside towards
//! others of its points, and the asset against a second instance of itself in the pose of another sample, beside it
//! so that they touch. Only queries are timed; poses are prepared before.

mod ask;
mod nearby;
mod questions;
mod refined;

use std::borrow::Cow;
use std::time::Instant;

use bdtree_runtime::{Asset, FormatError, Pose, PoseError, QueryError, Ray, Transform, VertexId};
use cpu_time::ThreadTime;
use serde::Serialize;

use super::samples::Samples;
use ask::Asked;
pub use nearby::Nearby;
pub use refined::{Gain, Refining};

/// Balls per sample.
pub const BALLS: usize = 4;

/// Radius of a ball over the diagonal of the box around the rest positions.
pub const BALL_RADIUS_REL: f64 = 0.05;

/// Rays per sample.
pub const RAYS: usize = 16;

/// A time is taken over at least this many seconds, the questions being repeated until then …
const TIMED_S: f64 = 1e-3;

/// … but not more often than this.
const REPEATS_MAX: usize = 1000;

/// Questions that fit one asset, and those baked from the same mesh with other modes or leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct Works {
    /// World units, which are mesh units here.
    radius: f64,
    /// Per sample.
    balls: Vec<[[f64; 3]; BALLS]>,
    /// Per sample.
    rays: Vec<[Ray; RAYS]>,
    /// Where the second instance of the pair stands; the first stands at the identity.
    pub beside: Transform,
}

/// One kind of question, asked at every sample.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Work {
    /// Number of questions: balls, rays, pairs of instances.
    pub questions: u64,
    /// Contacts of balls, hits of rays, pairs of triangles: of all questions together.
    pub found: u64,
    /// Nodes that all questions together visit; of pairs, what [`bdtree_runtime::PairQuery::contacts`] counts.
    pub nodes_visited: u64,
    /// Seconds of one question, of the thread's own time: over all of them, the least of the rounds, since what
    /// shares the core or its caches only adds. 0 where nothing was timed.
    pub seconds: f64,
}

/// What the works did with an asset.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Measured {
    /// Balls.
    pub ball: Work,
    /// Rays, each for its first hit.
    pub ray: Work,
    /// The asset against a second instance of itself.
    pub pair: Work,
}

impl Measured {
    /// The kinds of questions with their names.
    pub fn works(&self) -> [(&'static str, Work); 3] {
        [("ball", self.ball), ("ray", self.ray), ("pair", self.pair)]
    }

    /// Whether every kind of question visits as many nodes as `other` does.
    pub fn visits_like(&self, other: &Self) -> bool {
        let mut pairs = self.works().into_iter().zip(other.works());
        pairs.all(|((_, own), (_, other))| own.nodes_visited == other.nodes_visited)
    }

    /// How long this took over how long `other` took: the geometric mean over the kinds of questions, so that
    /// each counts the same however long it takes. 1 where either was not timed.
    pub fn time_over(&self, other: &Self) -> f64 {
        let pairs = self.works().into_iter().zip(other.works());
        let ratios: Vec<f64> = pairs
            .map(|((_, own), (_, other))| own.seconds / other.seconds)
            .filter(|ratio| ratio.is_finite() && *ratio > 0.0)
            .map(f64::ln)
            .collect();
        (ratios.iter().sum::<f64>() / ratios.len().max(1) as f64).exp()
    }
}

/// One asset to measure: samples are its own, or [`Samples::select`]ed for the modes that it has.
#[derive(Debug, Clone, Copy)]
pub struct Contender<'a> {
    /// The asset.
    pub asset: &'a Asset<'a>,
    /// Its poses.
    pub samples: &'a Samples,
}

impl Works {
    /// Questions for an asset at its samples.
    ///
    /// # Errors
    /// An asset whose bytes break the format's rules, or frames that no pose takes.
    pub fn new(asset: &Asset<'_>, samples: &Samples) -> Result<Self, WorksError> {
        questions::make(asset, samples)
    }

    /// The sample whose q the second instance of the pair has at `sample` of `count`.
    pub fn partner(sample: usize, count: usize) -> usize {
        (sample + count / 2) % count.max(1)
    }

    /// What the works find and visit, without times.
    ///
    /// # Errors
    /// Those of [`Works::new`]; samples of another number than the questions are for.
    pub fn count(&self, contender: Contender<'_>) -> Result<Measured, WorksError> {
        let mut measured = self.measure(&[contender], 0)?;
        Ok(measured.pop().unwrap_or_default())
    }

    /// The works of several assets, each `rounds` times in turn, so that what slows the machine down meets all
    /// of them; with 0 rounds they are only counted. In the order of `contenders`.
    ///
    /// # Errors
    /// Those of [`Works::count`].
    pub fn measure(
        &self,
        contenders: &[Contender<'_>],
        rounds: usize,
    ) -> Result<Vec<Measured>, WorksError> {
        let mut memories: Vec<[Vec<f32>; 2]> = contenders
            .iter()
            .map(|c| [(); 2].map(|()| vec![0.0; c.asset.pose_len().max(1) * c.samples.count]))
            .collect();
        let mut asked = Vec::with_capacity(contenders.len());
        for (contender, [here, there]) in contenders.iter().zip(&mut memories) {
            let found = contender.samples.count;
            if found != self.balls.len() {
                let expected = self.balls.len();
                return Err(WorksError::Samples { expected, found });
            }
            asked.push(Asked::new(
                poses(contender, Transform::IDENTITY, here)?,
                poses(contender, self.beside, there)?,
            ));
        }
        let mut measured = Vec::with_capacity(contenders.len());
        for asked in &mut asked {
            let [ball, ray, pair] = asked.all(self)?;
            measured.push(Measured { ball, ray, pair });
        }
        if rounds > 0 {
            self.time(&mut asked, &mut measured, rounds)?;
        }
        Ok(measured)
    }

    /// Fills in the seconds.
    fn time(
        &self,
        asked: &mut [Asked<'_>],
        measured: &mut [Measured],
        rounds: usize,
    ) -> Result<(), WorksError> {
        // The first asset says for all how often a question is asked within one time.
        let mut repeats = [1; 3];
        if let Some(first) = asked.first_mut() {
            for (kind, repeats) in repeats.iter_mut().enumerate() {
                let once = first.seconds(self, kind, 1)?;
                *repeats = ((TIMED_S / once).ceil() as usize).clamp(1, REPEATS_MAX);
            }
        }
        let count = asked.len();
        let mut times = vec![[const { Vec::new() }; 3]; count];
        for round in 0..rounds {
            for turn in 0..count {
                let k = (round + turn) % count;
                for kind in 0..3 {
                    times[k][kind].push(asked[k].seconds(self, kind, repeats[kind])?);
                }
            }
        }
        for (measured, times) in measured.iter_mut().zip(times) {
            let works = [&mut measured.ball, &mut measured.ray, &mut measured.pair];
            for (work, times) in works.into_iter().zip(times) {
                work.seconds = least(&times) / work.questions.max(1) as f64;
            }
        }
        Ok(())
    }
}

impl Asked<'_> {
    /// Seconds of all questions of a kind, once, the mean of several times.
    fn seconds(&mut self, works: &Works, kind: usize, repeats: usize) -> Result<f64, WorksError> {
        let (thread, wall) = (ThreadTime::try_now(), Instant::now());
        for _ in 0..repeats {
            std::hint::black_box(self.one(works, kind)?);
        }
        // The thread's own clock stands while others have the processor; where there is none, the wall's serves.
        let (wall, thread) = (wall.elapsed(), thread.and_then(|begin| begin.try_elapsed()));
        let time = thread.map_or(wall, |thread| thread.min(wall));
        Ok(time.as_secs_f64() / repeats as f64)
    }
}

/// Where the vertices of an asset are in its source without an animation, relative to its origin (stored units): with a
/// skin not its positions, since bind spaces of several meshes may lie over each other.
///
/// # Errors
/// Bones at rest that no pose takes, records that break the format's rules.
pub fn at_rest<'a>(asset: &Asset<'a>) -> Result<Cow<'a, [[f32; 3]]>, WorksError> {
    if !asset.has_skin() {
        return Ok(Cow::Borrowed(asset.positions()));
    }
    let (still, mut memory) = (vec![0.0; asset.mode_count()], vec![0.0; asset.pose_len()]);
    let pose = asset.pose(&still, Transform::IDENTITY, &mut memory);
    let pose = pose.map_err(WorksError::Rest)?;
    let vertices = (0..asset.vertex_count() as u32).map(VertexId);
    let places = vertices.map(|vertex| pose.deformed_stored(vertex));
    Ok(Cow::Owned(places.collect::<Result<_, _>>()?))
}

/// The poses of all samples.
fn poses<'m>(
    contender: &Contender<'m>,
    transform: Transform,
    memory: &'m mut [f32],
) -> Result<Vec<Pose<'m>>, WorksError> {
    let Contender { asset, samples } = *contender;
    memory
        .chunks_exact_mut(asset.pose_len().max(1))
        .enumerate()
        .map(|(sample, memory)| {
            asset
                .pose_with_bones(samples.q(sample), samples.joints(sample), transform, memory)
                .map_err(|error| WorksError::Pose { sample, error })
        })
        .collect()
}

/// The least; 0 of none.
fn least(times: &[f64]) -> f64 {
    times.iter().copied().reduce(f64::min).unwrap_or(0.0)
}

/// Why questions cannot be asked.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum WorksError {
    /// A sample's q or bones are refused.
    #[error("sample {sample}: {error}")]
    Pose {
        /// The sample, from 0.
        sample: usize,
        /// Why.
        error: PoseError,
    },
    /// Bones at rest are refused.
    #[error("at rest: {0}")]
    Rest(PoseError),
    /// A query gives no answer.
    #[error(transparent)]
    Query(#[from] QueryError),
    /// The asset's bytes break a rule of the format.
    #[error("damaged .bdt file: {0}")]
    Corrupt(#[from] FormatError),
    /// The asset has another number of samples than the questions are for.
    #[error("the questions are for {expected} samples, the asset has {found}")]
    Samples {
        /// What they are for.
        expected: usize,
        /// What the asset has.
        found: usize,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_time_counts() {
        assert_eq!(least(&[]), 0.0);
        assert_eq!(least(&[3.0, 1.0, 2.0]), 1.0);
    }

    #[test]
    fn every_kind_of_question_counts_the_same() {
        let took = |seconds: [f64; 3]| {
            let [ball, ray, pair] = seconds.map(|seconds| Work {
                seconds,
                ..Work::default()
            });
            Measured { ball, ray, pair }
        };
        let ratio = took([2.0, 1.0, 4.0]).time_over(&took([1.0, 1.0, 1.0]));
        assert!((ratio - 2.0).abs() < 1e-15);
        assert_eq!(took([1.0; 3]).time_over(&took([0.0; 3])), 1.0);
    }
    #[test]
    fn visits_are_alike_where_every_kind_has_as_many() {
        let visited = |nodes: [u64; 3]| {
            let [ball, ray, pair] = nodes.map(|nodes_visited| Work {
                nodes_visited,
                ..Work::default()
            });
            Measured { ball, ray, pair }
        };
        assert!(visited([36, 14, 804]).visits_like(&visited([36, 14, 804])));
        assert!(!visited([36, 14, 804]).visits_like(&visited([37, 14, 804])));
    }
}
