//! Who is ahead of deform + refit, in words: the titles of plots and the sentences of advice, which say what
//! [`Comparison`](crate::comparison::Comparison) says in numbers.

use crate::comparison::{Ahead, Side};

use super::content::Curve;
use super::text::number;
use super::verdict::times;

/// The title of a curve's plot.
pub(super) fn title(curve: &Curve) -> String {
    let comparison = &curve.comparison;
    let verdict = match (comparison.ahead, comparison.break_even) {
        (Ahead::Ours, _) => "bdtree is ahead at every amount tried".to_string(),
        (Ahead::Refit, _) => "deform + refit is ahead at every amount tried".to_string(),
        (Ahead::Crosses, Some(at)) => {
            let who = match comparison.above {
                Some(Side::Ours) => "bdtree",
                _ => "deform + refit",
            };
            format!("{who} is ahead from about {}", number(at))
        }
        _ => format!("neither is safely ahead {}", stretch(curve)),
    };
    format!("{}: {verdict}", curve.unit)
}

/// The advice of a curve: how fast, and what to do. `None` where nothing was measured.
pub(super) fn sentence(curve: &Curve) -> Option<String> {
    let points = curve.merged();
    let (first, last) = (points.first()?, points.last()?);
    let comparison = &curve.comparison;
    if let Ahead::Ours | Ahead::Refit = comparison.ahead {
        let ratios = points.iter().map(|(_, ratio)| *ratio);
        let least = ratios.clone().fold(f64::INFINITY, f64::min);
        let most = ratios.fold(0.0, f64::max);
        let tried = match points.len() {
            1 => format!("with {}", amount(first.0, &curve.unit)),
            _ => format!("at every amount tried ({})", range(first.0, last.0, curve)),
        };
        return Some(match comparison.ahead {
            Ahead::Ours => format!(
                "bdtree is {} than deform + refit {tried}.",
                times(least, most, "faster")
            ),
            _ => format!(
                "bdtree is {} than deform + refit {tried}: deform and refit instead.",
                times(1.0 / most, 1.0 / least, "slower")
            ),
        });
    }
    let than = match Side::of(first.1) {
        Some(_) => "than",
        None => "as",
    };
    let mut text = format!(
        "With {} bdtree is {} {than} deform + refit",
        amount(first.0, &curve.unit),
        pace(first.1)
    );
    if points.len() > 1 {
        text += &format!(
            ", with {}, the most that was tried, {}",
            amount(last.0, &curve.unit),
            pace(last.1)
        );
    }
    let unsure = stretch(curve);
    text += &match (comparison.ahead, comparison.above, comparison.break_even) {
        (Ahead::Crosses, Some(Side::Ours), Some(at)) => format!(
            ": up to about {}, deform and refit instead ({unsure} neither is safely ahead).",
            amount(at, &curve.unit)
        ),
        (Ahead::Crosses, _, Some(at)) => format!(
            ": from about {} on, deform and refit instead ({unsure} neither is safely ahead).",
            amount(at, &curve.unit)
        ),
        _ => format!(": {unsure} neither is safely ahead."),
    };
    Some(text)
}

/// From the least to the most that was tried.
fn range(first: f64, last: f64, curve: &Curve) -> String {
    let from = match first {
        0.0 => "nothing touching".to_string(),
        first => number(first),
    };
    format!("{from} to {}", amount(last, &curve.unit))
}

/// How fast bdtree is where deform + refit takes `ratio` times as long.
fn pace(ratio: f64) -> String {
    match Side::of(ratio) {
        Some(Side::Ours) => format!("{ratio:.1} times faster"),
        Some(Side::Refit) => format!("{:.1} times slower", 1.0 / ratio),
        None => "about as fast".to_string(),
    }
}

/// Where neither is safely ahead.
fn stretch(curve: &Curve) -> String {
    match (curve.comparison.from, curve.comparison.to) {
        (Some(from), Some(to)) if from == to => match to {
            0.0 => "with nothing touching".to_string(),
            to => format!("at {}", amount(to, &curve.unit)),
        },
        (Some(from), Some(to)) => {
            let from = match from {
                0.0 => "nothing touching".to_string(),
                from => number(from),
            };
            format!("between {from} and {}", amount(to, &curve.unit))
        }
        _ => "anywhere".to_string(),
    }
}

/// So many of a unit.
fn amount(n: f64, unit: &str) -> String {
    let unit = match (n, unit) {
        (0.0, _) => return "nothing touching".to_string(),
        (1.0, "balls per step") => "ball per step",
        (1.0, "rays per step") => "ray per step",
        (1.0, "touching pairs of triangles") => "touching pair of triangles",
        (_, unit) => unit,
    };
    format!("{} {unit}", number(n))
}

#[cfg(test)]
pub(super) mod tests {
    use crate::comparison::Comparison;

    use super::super::content::{Curve, CurvePoint};
    use super::{sentence, title};

    /// A curve of (amount, ratio); ours takes 1 µs.
    pub(in super::super) fn curve(question: &str, ratios: &[(f64, f64)]) -> Curve {
        let unit = match question {
            "pair" => "touching pairs of triangles".to_string(),
            other => format!("{other}s per step"),
        };
        let point = |(amount, ratio): &(f64, f64)| CurvePoint {
            amount: *amount,
            bdtree_micros: 1.0,
            refit_micros: *ratio,
            ratio: *ratio,
            visited_rel: 0.0,
        };
        Curve {
            question: question.to_string(),
            unit,
            points: ratios.iter().map(point).collect(),
            comparison: Comparison::of(ratios),
        }
    }

    #[test]
    fn every_comparison_is_told() {
        for (question, ratios, in_title, says) in [
            (
                "ball",
                &[(1.0, 30.76), (4096.0, 1.2)][..],
                "balls per step: bdtree is ahead at every amount tried",
                "bdtree is 1.2 to 30.8 times faster than deform + refit at every amount tried (1 to 4096 balls per \
                 step).",
            ),
            (
                "ray",
                &[(1.0, 0.5), (4.0, 0.1)],
                "rays per step: deform + refit is ahead at every amount tried",
                "bdtree is 2.0 to 10.0 times slower than deform + refit at every amount tried (1 to 4 rays per step): \
                 deform and refit instead.",
            ),
            (
                "ray",
                &[(1.0, 12.0), (12.0, 12.0), (1200.0, 1.0 / 12.0)],
                "rays per step: deform + refit is ahead from about 120",
                "With 1 ray per step bdtree is 12.0 times faster than deform + refit, with 1200 rays per step, \
                 the most that was tried, 12.0 times slower: from about 120 rays per step on, deform and refit \
                 instead (between 12 and 1200 rays per step neither is safely ahead).",
            ),
            (
                "ball",
                &[(1.0, 0.5), (4.0, 2.0)],
                "balls per step: bdtree is ahead from about 2",
                "With 1 ball per step bdtree is 2.0 times slower than deform + refit, with 4 balls per step, \
                 the most that was tried, 2.0 times faster: up to about 2 balls per step, deform and refit \
                 instead (between 1 and 4 balls per step neither is safely ahead).",
            ),
            (
                "pair",
                &[(0.0, 9.0), (0.0, 4.0), (1.0, 1.0), (900.0, 1.04)],
                "touching pairs of triangles: neither is safely ahead between nothing touching and 900 touching \
                 pairs of triangles",
                "With nothing touching bdtree is 6.0 times faster than deform + refit, with 900 touching pairs \
                 of triangles, the most that was tried, about as fast: between nothing touching and 900 touching \
                 pairs of triangles neither is safely ahead.",
            ),
            (
                "pair",
                &[(0.0, 1.0)],
                "touching pairs of triangles: neither is safely ahead with nothing touching",
                "With nothing touching bdtree is about as fast as deform + refit: with nothing touching neither \
                 is safely ahead.",
            ),
        ] {
            let curve = curve(question, ratios);
            assert_eq!(title(&curve), in_title);
            assert_eq!(sentence(&curve).as_deref(), Some(says));
        }
        assert_eq!(sentence(&curve("ball", &[])), None);
    }

    #[test]
    fn nothing_is_one_time_faster() {
        for k in 0..400 {
            let ratio = 0.8 + 0.001 * f64::from(k);
            let text = sentence(&curve("ball", &[(1.0, ratio), (4.0, ratio)])).expect("a point");
            assert!(
                !text.contains("1.0 times") && !text.contains(" 1 times"),
                "{text}"
            );
        }
    }
}
