//! What the questions take where poses are refined first: how many a step must ask until that pays.

use std::time::Instant;

use bdtree_runtime::{
    Ball, Contact, Pose, QueryError, RayIntersection, RefinedPose, Transform, Workspace,
};
use serde::Serialize;

use super::nearby::Nearby;
use super::{BALLS, Contender, RAYS, Works, WorksError, poses};

/// Samples that are measured, of those there are: preparing takes long where a mesh is large.
const SAMPLES_MAX: usize = 6;

/// Of which the least times count.
const ROUNDS: usize = 5;

/// A time is taken over at least so many seconds …
const TIMED_S: f64 = 1e-4;

/// … but over the questions of a sample at most so many times.
const REPEATS_MAX: usize = 1000;

/// Refining must save this share of a question's time; less is within what one run measures.
pub(super) const WORTH: f64 = 0.05;

/// Whether exact bounds of whole poses pay ([`RefinedPose`]), and what they take.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Refining {
    /// Memory to grant ([`RefinedPose::bytes_for`]).
    pub bytes: usize,
    /// Of preparing one pose.
    pub prepare_seconds: f64,
    /// Balls, each for its contacts.
    pub ball: Gain,
    /// Rays, each for its first hit.
    pub ray: Gain,
    /// Where steps ask in one place; `None` where a part of the memory saves nothing to speak of.
    pub nearby: Option<Nearby>,
}

/// What one question takes either way.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Gain {
    /// Without.
    pub seconds: f64,
    /// On a refined pose, preparing not included.
    pub refined_seconds: f64,
    /// How many of them in a step make up for preparing; `None` where a question gains nothing to speak of.
    pub pays_from: Option<f64>,
}

impl Gain {
    fn new(seconds: f64, refined_seconds: f64, prepare_seconds: f64) -> Self {
        let saved = seconds - refined_seconds;
        Self {
            seconds,
            refined_seconds,
            pays_from: (saved > WORTH * seconds).then(|| prepare_seconds / saved),
        }
    }
}

/// Asks the questions of one pose.
struct Asker<'w> {
    works: &'w Works,
    workspace: Workspace<'static>,
    contacts: Vec<Contact>,
    hits: [Option<RayIntersection>; RAYS],
}

impl Asker<'_> {
    /// The balls (0) or the rays (1) of a sample.
    fn ask(
        &mut self,
        kind: usize,
        sample: usize,
        pose: &Pose<'_>,
        refined: Option<&RefinedPose<'_>>,
    ) -> Result<(), QueryError> {
        let mut query = pose.query(&mut self.workspace);
        if let Some(refined) = refined {
            query = query.refined(refined);
        }
        if kind == 1 {
            return query.cast_rays(&self.works.rays[sample], &mut self.hits);
        }
        for center in &self.works.balls[sample] {
            self.contacts.clear();
            query.contacts(Ball::new(*center, self.works.radius), &mut self.contacts)?;
        }
        Ok(())
    }

    /// Seconds of one question of a kind.
    fn seconds(
        &mut self,
        kind: usize,
        sample: usize,
        pose: &Pose<'_>,
        refined: Option<&RefinedPose<'_>>,
    ) -> Result<f64, QueryError> {
        let questions = [BALLS, RAYS][kind] as f64;
        let begin = Instant::now();
        let mut asked = 0;
        loop {
            self.ask(kind, sample, pose, refined)?;
            asked += 1;
            let seconds = begin.elapsed().as_secs_f64();
            if seconds >= TIMED_S || asked == REPEATS_MAX {
                return Ok(seconds / (asked as f64 * questions));
            }
        }
    }
}

impl Works {
    /// Times preparing and the questions with and without, in turn at each pose.
    ///
    /// # Errors
    /// Those of [`Works::count`].
    pub fn refining(&self, contender: Contender<'_>) -> Result<Refining, WorksError> {
        let asset = contender.asset;
        let (expected, found) = (self.balls.len(), contender.samples.count);
        if found != expected {
            return Err(WorksError::Samples { expected, found });
        }
        let mut memory = vec![0.0; asset.pose_len().max(1) * found];
        let poses = poses(&contender, Transform::IDENTITY, &mut memory)?;
        let mut asker = Asker {
            works: self,
            workspace: Workspace::new(),
            contacts: Vec::new(),
            hits: [None; RAYS],
        };
        let mut refined = RefinedPose::new();
        let step = poses.len().div_ceil(SAMPLES_MAX).max(1);
        let mut sums = [0.0; 5];
        let mut count = 0.0;
        for (sample, pose) in poses.iter().enumerate().step_by(step) {
            let mut least = [f64::INFINITY; 5];
            for _ in 0..ROUNDS {
                let begin = Instant::now();
                refined.prepare(pose)?;
                let times = [
                    begin.elapsed().as_secs_f64(),
                    asker.seconds(0, sample, pose, None)?,
                    asker.seconds(0, sample, pose, Some(&refined))?,
                    asker.seconds(1, sample, pose, None)?,
                    asker.seconds(1, sample, pose, Some(&refined))?,
                ];
                for (least, time) in least.iter_mut().zip(times) {
                    *least = least.min(time);
                }
            }
            for (sum, least) in sums.iter_mut().zip(least) {
                *sum += least;
            }
            count += 1.0;
        }
        let [prepare, ball, refined_ball, ray, refined_ray] = sums.map(|sum| sum / count);
        let bytes = RefinedPose::bytes_for(asset)?;
        let seen: Vec<&Pose<'_>> = poses.iter().step_by(step).collect();
        let from = self.rays.first().map_or([0.0; 3], |rays| rays[0].origin);
        Ok(Refining {
            bytes,
            nearby: Nearby::measure(&seen, from, bytes)?,
            prepare_seconds: prepare,
            ball: Gain::new(ball, refined_ball, prepare),
            ray: Gain::new(ray, refined_ray, prepare),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Gain;

    #[test]
    fn what_saves_little_never_pays() {
        assert_eq!(Gain::new(2.0, 1.0, 1000.0).pays_from, Some(1000.0));
        assert_eq!(Gain::new(1.0, 0.98, 1000.0).pays_from, None);
        assert_eq!(Gain::new(1.0, 2.0, 1000.0).pays_from, None);
    }
}
