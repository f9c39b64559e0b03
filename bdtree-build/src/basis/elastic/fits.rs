//! How many cells along the longest side fit into the memory, where more were refused.

use super::{ElasticOptions, limits};
use crate::elastic::assemble::system::System;
use crate::elastic::constraint::fix::constrain_all;
use crate::elastic::element::spline::Element;
use crate::elastic::lattice::Subject;
use crate::elastic::lattice::resolution::cell_limit;
use crate::elastic::solve::{Needs, SolveError, needs};
use crate::progress::Progress;

/// Resolutions that are tried at most. Each is about as fine as what fits, so that trying one takes a part of a bake.
const TRIES: usize = 8;

/// The first that is tried: coarse enough to cost next to nothing.
const FIRST: u32 = 12;

/// What fits is good enough where this many times its resolution does not, or if it uses so much of the memory.
const NEAR: f64 = 1.2;
const FULL: f64 = 0.6;

/// The next that is tried is so many times as fine as one that fits, or finer.
const STEP: f64 = 1.25;

/// How memory grows with the resolution: from sheets to stout bodies, and what is taken where nothing is known.
const POWERS: [f64; 2] = [1.5, 4.5];
const POWER: f64 = 4.0;

/// What a resolution takes.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Trial {
    /// These bytes, within the limit.
    Fits(u64),
    /// Less than the limit, but the lattice does not hold what is asked of it.
    TooCoarse,
    /// Bytes beyond the limit, `None` where cells alone are.
    Refused(Option<u64>),
}

/// The most cells along the longest side that a search finds to pass what refuses bakes: the lattice, its cells, its
/// number of modes, the memory of the solution. `refused` does not, for the predicted bytes if they are known.
pub(super) fn finest(
    subject: &Subject<'_>,
    options: &ElasticOptions,
    refused: u32,
    bytes: Option<u64>,
    progress: &dyn Progress,
) -> Option<u32> {
    progress.stage("a resolution that fits", None);
    let limit = options.memory_limit_bytes;
    search(limit, refused, bytes, |resolution| {
        trial(subject, options, resolution)
    })
}

fn trial(subject: &Subject<'_>, options: &ElasticOptions, resolution: u32) -> Trial {
    let limit = cell_limit(options.memory_limit_bytes);
    let Ok(lattice) = subject.lattice(f64::from(resolution), limit) else {
        return Trial::Refused(None);
    };
    let Ok(constraints) = constrain_all(subject, &lattice, &options.fixes) else {
        return Trial::TooCoarse;
    };
    let element = Element::new(options.poisson);
    let system = |c: usize| System::of_lattice(&lattice.components[c], &element, &constraints[c]);
    match needs(&lattice.sizes(), system, limits(options)) {
        Ok(Needs { bytes, available }) if available >= options.mode_count => Trial::Fits(bytes),
        Ok(_) => Trial::TooCoarse,
        Err(SolveError::Memory(bytes)) => Trial::Refused(Some(bytes)),
        Err(_) => Trial::Refused(None),
    }
}

/// From coarse to fine, so that nothing is tried that is much finer than what fits.
fn search(
    limit: u64,
    refused: u32,
    bytes: Option<u64>,
    mut trial: impl FnMut(u32) -> Trial,
) -> Option<u32> {
    let (mut high, mut high_bytes) = (refused, bytes);
    let mut low = 0;
    let mut best: Option<(u32, u64)> = None;
    let mut next = FIRST.min(refused / 2);
    for _ in 0..TRIES {
        if high - low <= 1 {
            break;
        }
        let tried = next.clamp(low + 1, high - 1);
        match trial(tried) {
            Trial::Fits(bytes) => {
                (low, best) = (tried, Some((tried, bytes)));
                if bytes as f64 >= FULL * limit as f64 {
                    break;
                }
            }
            Trial::TooCoarse => low = tried,
            Trial::Refused(bytes) => (high, high_bytes) = (tried, bytes),
        }
        if best.is_some_and(|(fits, _)| f64::from(high) <= NEAR * f64::from(fits)) {
            break;
        }
        next = match (best, high_bytes) {
            (Some(best), bytes) => {
                between(limit, best, (high, bytes)).max((STEP * f64::from(low)) as u32)
            }
            (None, _) if low > 0 => (2 * low).min(low.midpoint(high)),
            (None, _) => high / 2,
        };
    }
    best.map(|(fits, _)| fits)
}

/// About the finest resolution within the limit, between one that fits and one that is refused.
fn between(limit: u64, (low, low_bytes): (u32, u64), high: (u32, Option<u64>)) -> u32 {
    let power = match high {
        (high, Some(bytes)) => {
            let grown = (bytes as f64 / low_bytes.max(1) as f64).ln();
            grown / (f64::from(high) / f64::from(low)).ln()
        }
        (_, None) => POWER,
    };
    scaled(low, limit, low_bytes, power.clamp(POWERS[0], POWERS[1]))
}

/// What takes the limit where `resolution` takes `bytes` and memory grows with this power.
fn scaled(resolution: u32, limit: u64, bytes: u64, power: f64) -> u32 {
    let factor = (limit as f64 / bytes.max(1) as f64).powf(1.0 / power);
    (f64::from(resolution) * factor) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Searches where memory grows with a power of the resolution, which is too coarse below `coarse`; beyond `cells`
    /// cells alone are too many. Returns what was found and what was tried.
    fn found(
        limit: u64,
        refused: u32,
        power: f64,
        cells: u32,
        coarse: u32,
    ) -> (Option<u32>, Vec<u32>) {
        let bytes = |resolution: u32| (1000.0 * f64::from(resolution).powf(power)) as u64;
        let mut tried = Vec::new();
        let known = (refused <= cells).then(|| bytes(refused));
        let best = search(limit, refused, known, |resolution| {
            tried.push(resolution);
            match bytes(resolution) {
                _ if resolution > cells => Trial::Refused(None),
                _ if resolution < coarse => Trial::TooCoarse,
                bytes if bytes > limit => Trial::Refused(Some(bytes)),
                bytes => Trial::Fits(bytes),
            }
        });
        (best, tried)
    }

    #[test]
    fn what_is_found_fits_and_is_near_the_finest() {
        for power in [1.5, 2.0, 3.0, 4.0] {
            for finest in [1_u32, 2, 5, 11, 30, 77, 300] {
                let limit = (1000.0 * f64::from(finest).powf(power)) as u64;
                for refused in [finest + 1, 2 * finest + 1, 1024] {
                    for cells in [1024, finest + 1, 2 * finest] {
                        let (best, tried) = found(limit, refused, power, cells, 0);
                        let told =
                            format!("{power} {finest} {refused} {cells}: {best:?} of {tried:?}");
                        let best = best.unwrap_or_else(|| panic!("{told}"));
                        assert!(best <= finest && 10 * (best + 1) >= 7 * finest, "{told}");
                        // Nothing is tried that takes much longer.
                        assert!(tried.iter().all(|r| *r <= 2 * finest + FIRST), "{told}");
                    }
                }
            }
        }
    }

    #[test]
    fn nothing_is_found_where_nothing_fits() {
        for (refused, cells) in [(40, 1024), (1, 1024), (2, 0)] {
            assert_eq!(found(10, refused, 3.0, cells, 0).0, None);
        }
        // Too coarse below 20, too fine beyond 30.
        let (best, tried) = found(27_000_000, 1024, 3.0, 1024, 20);
        assert!(
            best.is_some_and(|best| (20..=30).contains(&best)),
            "{best:?} of {tried:?}"
        );
    }
}
