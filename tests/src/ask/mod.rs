//! Everything that a program can ask of a file, whatever bytes it has. Needs the runtime only, so that
//! an interpreter can run it (ci/miri.sh).

mod accessors;
mod instance;
mod pairs;
mod single;

use std::ops::ControlFlow;

use bdtree_runtime::{Asset, FormatError, Kernel, Pose, PoseError, QueryError, Transform};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::poses;

/// Asserts that an error says where and which rule.
///
/// # Panics
/// When it does not.
pub fn located(error: &FormatError) {
    assert!(error.rule.starts_with("SPEC "), "{error}");
    assert!(error.section.0.iter().any(|b| *b != 0), "{error}");
}

/// Whether `verify` finds something; stops at the first error.
pub fn refused(asset: &Asset<'_>) -> bool {
    !asset.verify(&mut |error| {
        located(&error);
        ControlFlow::Break(())
    })
}

/// What queries said.
#[derive(Debug, Clone, Copy, Default)]
pub struct Answers {
    /// Queries that gave an answer.
    pub given: u64,
    /// Queries that said that the file is corrupt.
    pub corrupt: u64,
}

impl Answers {
    /// The answer, or nothing where the file is corrupt.
    ///
    /// # Panics
    /// On any other error: arguments and memory are right.
    fn take<T>(&mut self, result: Result<T, QueryError>) -> Option<T> {
        match result {
            Ok(answer) => {
                self.given += 1;
                Some(answer)
            }
            Err(QueryError::Corrupt(error)) => {
                located(&error);
                self.corrupt += 1;
                None
            }
            Err(other) => panic!("{other}"),
        }
    }

    /// The same for what reads the file without a query.
    fn read<T>(&mut self, result: Result<T, FormatError>) -> Option<T> {
        self.take(result.map_err(QueryError::Corrupt))
    }
}

/// q within the limits, whatever else the file says: at rest, small, within the range, at the limits.
fn some_q(asset: &Asset<'_>, rng: &mut Pcg64Mcg) -> Vec<f32> {
    let kind = rng.random_range(0..4);
    let modes = asset.modes().iter();
    let q = modes.map(|mode| {
        let (range, limit) = (mode.q_range.get(), mode.q_limit.get());
        let share = rng.random_range(-1.0..=1.0_f32);
        match kind {
            0 => 0.0,
            1 => 0.01 * range * share,
            2 => range * share,
            _ => limit * share.signum(),
        }
    });
    q.collect()
}

/// Where an instance stands: mostly near the origin.
fn some_place(rng: &mut Pcg64Mcg) -> Transform {
    match rng.random_range(0..4) {
        0 => Transform::IDENTITY,
        3 => poses::random_transform(1e6, rng),
        _ => poses::random_transform(0.3, rng),
    }
}

/// Asks everything of an opened file, with the kernel that it was opened with; `partner` is what pair
/// queries hold against it. The answers depend on `rng` alone.
///
/// # Panics
/// When something is wrong with the product.
pub fn ask_everything(asset: &Asset<'_>, partner: &Asset<'_>, rng: &mut Pcg64Mcg) -> Answers {
    let mut answers = Answers::default();
    accessors::read_all(asset, rng, &mut answers);
    let (q, place) = (some_q(asset, rng), some_place(rng));
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = match Pose::new(asset, &q, place, &mut memory) {
        Ok(pose) => pose,
        Err(PoseError::Translation) => return answers,
        Err(error) => panic!("{error}"),
    };
    single::ask(asset, &pose, rng, &mut answers);
    pairs::ask([asset, partner], &pose, rng, &mut answers);
    answers
}

/// The kernels of this processor.
pub fn kernels() -> Vec<Kernel> {
    let all = Kernel::ALL.into_iter();
    all.filter(|kernel| kernel.is_available()).collect()
}
