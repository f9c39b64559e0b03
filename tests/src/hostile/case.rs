//! One case: a damaged file that its number says, and what became of it.

use std::time::{Duration, Instant};

use bdtree_runtime::{AlignedBytes, Asset};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::{Sources, sound};
use crate::ask::{Answers, ask_everything, kernels, located, refused};
use crate::judge::{Judgement, judge};
use crate::mutate::Damage;
use crate::poses;

/// A case of a run: the same seed and number make the same file and ask the same, on every machine
/// (but for the kernels that it has).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Case {
    /// Of the run.
    pub seed: u64,
    /// Of the case.
    pub number: u64,
}

/// What became of a file.
#[derive(Debug, Clone)]
pub struct Examined {
    /// The sound file it was made of.
    pub source: &'static str,
    /// What was done to it.
    pub damage: Damage,
    /// Header and tables were accepted.
    pub opened: bool,
    /// `verify` found something.
    pub refused: bool,
    /// Of an opened file with changed numbers only.
    pub judgement: Option<Judgement>,
    /// A file that `verify` passed was compared with brute force.
    pub compared: bool,
    /// What queries said.
    pub answers: Answers,
    /// How long all of it took.
    pub took: Duration,
}

impl Case {
    /// Larger files are slower: one case in so many.
    const LARGER: u64 = 32;
    /// So is a pair of two damaged files.
    const ITSELF: u64 = 16;

    fn rng(self) -> Pcg64Mcg {
        // Two odd multipliers, so that neighbours in seed or number have nothing in common.
        let seed = self.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let number = self.number.wrapping_mul(0xd1b5_4a32_d192_ed03);
        poses::rng(seed ^ number.rotate_left(32))
    }

    /// The sound file, what is done to it, the damaged file, and what chooses the questions.
    pub fn file(self, sources: &Sources) -> (&'static str, Damage, Vec<u8>, Pcg64Mcg) {
        let mut rng = self.rng();
        let from = if self.number.is_multiple_of(Self::LARGER) {
            sources.larger()
        } else {
            sources.small()
        };
        let (name, sound) = &from[rng.random_range(0..from.len())];
        let damage = Damage::ALL[rng.random_range(0..Damage::ALL.len())];
        let bytes = damage.done_to(sound, &mut rng);
        (name, damage, bytes, rng)
    }

    /// Makes the file, opens it, verifies it, and asks everything with one kernel; what `verify`
    /// passes is compared with brute force, with all kernels.
    ///
    /// # Panics
    /// When anything is wrong with the product.
    pub fn examine(self, sources: &Sources) -> Examined {
        let begin = Instant::now();
        let (source, damage, bytes, mut rng) = self.file(sources);
        let copy = AlignedBytes::copy_of(&bytes);
        let mut examined = Examined {
            source,
            damage,
            opened: false,
            refused: false,
            judgement: None,
            compared: false,
            answers: Answers::default(),
            took: Duration::ZERO,
        };
        let partner = Asset::open(&sources.partner).expect("the partner opens");
        match Asset::open(&copy) {
            Err(error) => located(&error),
            Ok(asset) => {
                examined.opened = true;
                examined.refused = refused(&asset);
                if damage == Damage::Numbers {
                    examined.judgement = Some(agreed(&asset, examined.refused));
                } else if !examined.refused {
                    let judgement = judge(&asset);
                    assert!(!matches!(judgement, Judgement::Broken(_)), "{judgement:?}");
                }
                let kernels = kernels();
                let kernel = kernels[rng.random_range(0..kernels.len())];
                let asset = asset.with_kernel(kernel).expect("an available kernel");
                examined.answers = ask_everything(&asset, &partner, &mut rng);
                if self.number.is_multiple_of(Self::ITSELF) {
                    ask_everything(&asset, &asset, &mut rng);
                }
                if !examined.refused {
                    assert_eq!(examined.answers.corrupt, 0, "verify passed this file");
                    examined.compared = sound::compare(&asset, &partner, &mut rng);
                }
            }
        }
        examined.took = begin.elapsed();
        examined
    }
}

/// What is to be said of a file with changed numbers; `verify` must have said the same.
fn agreed(asset: &Asset<'_>, refused: bool) -> Judgement {
    let judgement = judge(asset);
    match &judgement {
        Judgement::Broken(what) => assert!(refused, "verify passes a file: {what}"),
        Judgement::Holds => assert!(!refused, "verify refuses a file whose bounds hold"),
        Judgement::Unclear => {}
    }
    judgement
}
