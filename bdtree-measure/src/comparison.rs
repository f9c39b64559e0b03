//! Who is ahead over how much is asked per step: ours, or whoever deforms all vertices and refits.
//!
//! Times of two contenders within a tenth of each other are taken as equal: runs on a machine that does
//! other work differ by as much. So a curve of ratios may have one crossing, none, or a stretch in which
//! neither is safely ahead, and [`Comparison`] says which.

use serde::Serialize;

/// Questions per step at which the two are compared, until one of the limits below is met.
pub const AMOUNTS: [usize; 7] = [1, 4, 16, 64, 256, 1024, MOST];

/// The most questions per step.
pub const MOST: usize = 4096;

/// A curve ends where questions visit every node this many times: long past where refitting pays.
pub const VISITS_MAX: f64 = 100.0;

/// From how many questions per step on a `StepCache` serves ours: one slot per node …
pub const CACHED: usize = 4;

/// … and so many slots for leaves.
pub const LEAF_SLOTS: usize = 1 << 12;

/// Ratios of times between these are noise.
pub const NOISE: [f64; 2] = [0.9, 1.1];

/// Ratios of times between these say nothing where the most amount alone is outside the noise, after one within it: one
/// run in some leaves the noise by as little.
const DOUBTED: [f64; 2] = [0.8, 1.2];

/// One of the two.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Ours: the ratio is above the noise.
    #[serde(rename = "bdtree")]
    Ours,
    /// Deform + refit: it is below.
    Refit,
}

impl Side {
    /// Who is safely ahead where deform + refit takes `ratio` times as long as ours; `None` within noise.
    pub fn of(ratio: f64) -> Option<Self> {
        match ratio {
            r if r > NOISE[1] => Some(Self::Ours),
            r if r < NOISE[0] => Some(Self::Refit),
            _ => None,
        }
    }
}

/// What a curve says as a whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ahead {
    /// Ours is safely ahead at every amount measured.
    #[serde(rename = "bdtree")]
    Ours,
    /// Deform + refit is.
    Refit,
    /// One is safely ahead at few, the other at many, with nothing but noise between them.
    Crosses,
    /// One is safely ahead at an end, or at both, but not as simply: the other end is noise, or there is a dip into
    /// noise or more than one crossing between. `below`, `from`, `to` and `above` say where.
    Partly,
    /// Noise at both ends.
    Close,
}

/// Who is ahead, and where.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Comparison {
    /// The whole curve in a word.
    pub ahead: Ahead,
    /// Who is safely ahead at the least amount; null within noise.
    pub below: Option<Side>,
    /// Who is safely ahead at the most; null within noise, and where the most alone is outside it by no more than the
    /// noise is wide.
    pub above: Option<Side>,
    /// `below` is safely ahead at all amounts measured up to this one, which is the least measured where
    /// `below` is null; null where one is ahead at all of them.
    pub from: Option<f64>,
    /// `above` is safely ahead at all amounts measured from this one on, which is the most measured where
    /// `above` is null; null where one is ahead at all of them. Between `from` and `to` neither is safely
    /// ahead.
    pub to: Option<f64>,
    /// Where both take as long, to two digits, if `ahead` is `crosses`; else null. From there on `above`
    /// is the faster one.
    pub break_even: Option<f64>,
}

impl Comparison {
    /// Of points (amount, time of deform + refit over ours), in any order. Those of equal amounts count as
    /// one of their geometric mean; a ratio that is not above 0 and finite says nothing.
    pub fn of(points: &[(f64, f64)]) -> Self {
        let all = merged(points);
        let side = |p: &(f64, f64)| Side::of(p.1);
        let below = all.first().and_then(side);
        let above = all.last().and_then(side).filter(|_| !is_last_doubted(&all));
        // How many at an end are like its first.
        let alike = |end: Option<Side>, points: &mut dyn Iterator<Item = &(f64, f64)>| match end {
            None => 0,
            Some(_) => points.take_while(|p| side(p) == end).count(),
        };
        let head = alike(below, &mut all.iter());
        let tail = alike(above, &mut all.iter().rev());
        let mut comparison = Self {
            ahead: match (below, above) {
                (None, None) => Ahead::Close,
                _ => Ahead::Partly,
            },
            below,
            above,
            from: None,
            to: None,
            break_even: None,
        };
        if let (true, Some(one)) = (head == all.len(), below) {
            comparison.ahead = match one {
                Side::Ours => Ahead::Ours,
                Side::Refit => Ahead::Refit,
            };
            return comparison;
        }
        let (first, end) = (head.saturating_sub(1), all.len() - tail);
        let to = end.min(all.len().saturating_sub(1));
        comparison.from = all.get(first).map(|p| p.0);
        comparison.to = all.get(to).map(|p| p.0);
        let is_noise = all[head..end].iter().all(|p| side(p).is_none());
        if head > 0 && tail > 0 && below != above && is_noise {
            comparison.ahead = Ahead::Crosses;
            comparison.break_even = crossing(&all[first..=to]).map(two_digits);
        }
        comparison
    }
}

/// Whether the most amount is the only one outside the noise since the one before it, and hardly outside.
fn is_last_doubted(points: &[(f64, f64)]) -> bool {
    match points {
        [.., (_, before), (_, last)] => {
            Side::of(*before).is_none() && (DOUBTED[0]..=DOUBTED[1]).contains(last)
        }
        _ => false,
    }
}

/// Points by rising amount, equal amounts as one point of their geometric mean.
fn merged(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let says = |p: &&(f64, f64)| p.0.is_finite() && p.1.is_finite() && p.1 > 0.0;
    let mut all: Vec<(f64, f64)> = points.iter().filter(says).copied().collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let same = all.chunk_by(|a, b| a.0 == b.0);
    let mean = |group: &[(f64, f64)]| match group {
        [one] => *one,
        all => {
            let logs: f64 = all.iter().map(|p| p.1.ln()).sum();
            (all[0].0, (logs / all.len() as f64).exp())
        }
    };
    same.map(mean).collect()
}

/// Where the ratio is last 1 on its way from one side at the first point to the other at the last: between
/// amounts above 0 as powers are, else evenly.
fn crossing(points: &[(f64, f64)]) -> Option<f64> {
    let first = points.first()?.1.ln().signum();
    let lead = |p: &(f64, f64)| first * p.1.ln();
    let k = points.iter().rposition(|p| lead(p) > 0.0)?;
    let (a, b) = (&points[k], points.get(k + 1)?);
    let share = lead(a) / (lead(a) - lead(b));
    Some(match a.0 > 0.0 {
        true => a.0 * (b.0 / a.0).powf(share),
        false => a.0 + share * (b.0 - a.0),
    })
}

/// Two digits that count: as many as runs agree in.
pub fn two_digits(x: f64) -> f64 {
    format!("{x:.1e}").parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::{Ahead, Comparison, Side, merged, two_digits};

    /// Of ratios at 1, 4, 16, …
    fn of(ratios: &[f64]) -> Comparison {
        let amounts = (0..).map(|k| 4.0_f64.powi(k));
        Comparison::of(&amounts.zip(ratios.iter().copied()).collect::<Vec<_>>())
    }

    fn stretch(comparison: &Comparison) -> (Option<f64>, Option<f64>) {
        (comparison.from, comparison.to)
    }

    const OURS: Option<Side> = Some(Side::Ours);
    const REFIT: Option<Side> = Some(Side::Refit);

    #[test]
    fn one_is_ahead_everywhere() {
        for (ratios, ahead, side) in [
            (&[30.0, 3.0, 1.2][..], Ahead::Ours, OURS),
            (&[1.11], Ahead::Ours, OURS),
            (&[0.89, 0.5], Ahead::Refit, REFIT),
        ] {
            let comparison = of(ratios);
            assert_eq!(comparison.ahead, ahead, "{ratios:?}");
            assert_eq!((comparison.below, comparison.above), (side, side));
            assert_eq!(stretch(&comparison), (None, None));
            assert_eq!(comparison.break_even, None);
        }
    }

    #[test]
    fn one_crossing_either_way() {
        // As 10 / amount: equal at 10.
        let comparison = of(&[10.0, 2.5, 0.625, 0.15]);
        assert_eq!(
            (comparison.ahead, comparison.break_even),
            (Ahead::Crosses, Some(10.0))
        );
        assert_eq!((comparison.below, comparison.above), (OURS, REFIT));
        assert_eq!(stretch(&comparison), (Some(4.0), Some(16.0)));
        // Through noise, in which it goes to and fro: the last time counts.
        let comparison = of(&[2.0, 0.95, 1.05, 1.0 / 1.05, 0.5]);
        assert_eq!(
            (comparison.ahead, comparison.break_even),
            (Ahead::Crosses, Some(32.0))
        );
        assert_eq!(stretch(&comparison), (Some(1.0), Some(256.0)));
        let comparison = of(&[0.5, 2.0]);
        assert_eq!((comparison.below, comparison.above), (REFIT, OURS));
        assert_eq!(
            (comparison.ahead, comparison.break_even),
            (Ahead::Crosses, Some(2.0))
        );
    }

    #[test]
    fn what_is_not_simple_says_where() {
        use Ahead::{Close, Partly};
        for (ratios, ahead, below, above, from, to) in [
            // Noise at an end, at both, throughout.
            (&[8.0, 2.0, 1.05][..], Partly, OURS, None, 4.0, 16.0),
            (&[1.0, 2.0, 3.0], Partly, None, OURS, 1.0, 4.0),
            (&[0.95, 0.5, 1.0], Close, None, None, 1.0, 16.0),
            (&[1.09], Close, None, None, 1.0, 1.0),
            // A last one that is hardly outside the noise, after one within it; not after one outside.
            (&[8.0, 1.05, 1.11], Partly, OURS, None, 1.0, 16.0),
            (&[8.0, 1.05, 0.85], Partly, OURS, None, 1.0, 16.0),
            (&[1.0, 1.05, 1.19], Close, None, None, 1.0, 16.0),
            (&[1.0, 1.15, 1.15], Partly, None, OURS, 1.0, 4.0),
            // A dip into noise; both sides of it the same.
            (&[2.0, 1.0, 1.5], Partly, OURS, OURS, 1.0, 16.0),
            // More than one crossing.
            (&[3.0, 0.5, 2.0, 0.5], Partly, OURS, REFIT, 1.0, 64.0),
            (&[3.0, 2.0, 0.5, 2.0, 3.0], Partly, OURS, OURS, 4.0, 64.0),
            (&[0.5, 1.5, 1.0, 0.5, 0.2], Partly, REFIT, REFIT, 1.0, 64.0),
        ] {
            let comparison = of(ratios);
            assert_eq!(comparison.ahead, ahead, "{ratios:?}");
            assert_eq!(
                (comparison.below, comparison.above),
                (below, above),
                "{ratios:?}"
            );
            assert_eq!(stretch(&comparison), (Some(from), Some(to)), "{ratios:?}");
            assert_eq!(comparison.break_even, None, "{ratios:?}");
        }
        assert_eq!(of(&[]).ahead, Ahead::Close);
        assert_eq!(stretch(&of(&[f64::NAN, 0.0])), (None, None));
    }

    #[test]
    fn equal_amounts_are_one_point_and_none_is_an_amount() {
        let points = [(0.0, 8.0), (5.0, 0.5), (0.0, 0.5), (9.0, 0.1)];
        let all = merged(&points);
        assert_eq!(all.len(), 3);
        assert!((all[0].1 - 2.0).abs() < 1e-12, "{all:?}");
        // Evenly from 0: half of the way to 5.
        let comparison = Comparison::of(&points);
        assert_eq!(
            (comparison.ahead, comparison.break_even),
            (Ahead::Crosses, Some(2.5))
        );
        assert_eq!(stretch(&comparison), (Some(0.0), Some(5.0)));
    }

    #[test]
    fn two_digits_count() {
        for (x, rounded) in [(143.06, 140.0), (14.57, 15.0), (0.254, 0.25), (0.0, 0.0)] {
            assert_eq!(two_digits(x), rounded);
        }
    }
}
