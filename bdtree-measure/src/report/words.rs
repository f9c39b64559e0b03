//! Who is ahead of deform + refit, in words: verdict, advice and the titles of plots, all of which say what
//! [`Comparison`](crate::comparison::Comparison) says in numbers.

use crate::comparison::{Ahead, Side};

use super::content::Curve;
use super::text::{capitalised, count};

/// The title of a curve's plot.
pub(super) fn title(curve: &Curve) -> String {
    format!("{}: bdtree is {}", curve.unit, standing(curve))
}

/// The verdict on a curve; `None` where nothing was measured.
pub(super) fn verdict(curve: &Curve) -> Option<String> {
    let unit = capitalised(&curve.unit);
    let last = curve.points.last()?;
    let tried = format!("up to the {} tried", count(last.amount));
    Some(match speed(curve) {
        Some(speed) => format!("{unit}: {speed} deform + refit, {tried}."),
        None => format!("{unit}, against deform + refit: {}.", standing(curve)),
    })
}

/// The advice of a curve: how fast, and what to do. `None` where nothing was measured.
pub(super) fn sentence(curve: &Curve) -> Option<String> {
    let (first, last) = (curve.points.first()?, curve.points.last()?);
    if let Some(speed) = speed(curve) {
        let tried = match curve.points.len() {
            1 => format!("with {}", amount(first.amount, &curve.unit)),
            _ => format!("at every amount tried ({})", range(curve)),
        };
        let instead = match curve.comparison.ahead {
            Ahead::Refit => ": deform and refit instead",
            _ => "",
        };
        return Some(format!(
            "bdtree is {speed} deform + refit {tried}{instead}."
        ));
    }
    let than = match Side::of(first.ratio) {
        Some(_) => "than",
        None => "as",
    };
    let mut text = format!(
        "With {} bdtree is {} {than} deform + refit",
        amount(first.amount, &curve.unit),
        pace(first.ratio)
    );
    if curve.points.len() > 1 {
        text += &format!(
            ", with {}, the most that was tried, {}",
            amount(last.amount, &curve.unit),
            pace(last.ratio)
        );
    }
    let part = |(who, span): (Option<Side>, String)| match who {
        Some(Side::Refit) => format!("{span}, deform and refit instead"),
        who => format!("{} {span}", word(who)),
    };
    let parts: Vec<String> = spans(curve).into_iter().map(part).collect();
    Some(format!("{text}: {}.", parts.join("; ")))
}

/// How fast bdtree is where: `faster up to 16, unsure between 16 and 64, slower from 64 on`.
fn standing(curve: &Curve) -> String {
    if is_noise(curve) {
        return "about as fast at every amount tried".to_string();
    }
    let part = |(who, span): (Option<Side>, String)| format!("{} {span}", word(who));
    let parts: Vec<String> = spans(curve).into_iter().map(part).collect();
    parts.join(", ")
}

/// Who is safely ahead, and where: at few, between, at many; one span where that is all the same.
fn spans(curve: &Curve) -> Vec<(Option<Side>, String)> {
    let comparison = &curve.comparison;
    let (below, above) = (comparison.below, comparison.above);
    let (Some(from), Some(to), true) = (
        comparison.from,
        comparison.to,
        below.is_some() || above.is_some(),
    ) else {
        return vec![(below, "at every amount tried".to_string())];
    };
    let is_none = from == 0.0;
    let [from, to] = [from, to].map(count);
    let first = match is_none {
        true => NOTHING.to_string(),
        false => format!("up to {from}"),
    };
    let between = match (below, above) {
        (Some(_), Some(_)) if !is_none => format!("between {from} and {to}"),
        (_, Some(_)) => format!("below {to}"),
        (_, None) if is_none => "beyond".to_string(),
        (_, None) => format!("above {from}"),
    };
    let mut spans = vec![(None, between)];
    if below.is_some() {
        spans.insert(0, (below, first));
    }
    if above.is_some() {
        spans.push((above, format!("from {to} on")));
    }
    spans
}

fn word(who: Option<Side>) -> &'static str {
    match who {
        Some(Side::Ours) => "faster",
        Some(Side::Refit) => "slower",
        None => "unsure",
    }
}

/// Whether no amount has anybody safely ahead.
fn is_noise(curve: &Curve) -> bool {
    let mut sides = curve.points.iter().map(|point| Side::of(point.ratio));
    sides.all(|side| side.is_none())
}

/// How fast bdtree is, where that is the same everywhere: how many times faster or slower `than`, or `about as fast as`.
fn speed(curve: &Curve) -> Option<String> {
    let ratios = || curve.points.iter().map(|point| point.ratio);
    let least = ratios().fold(f64::INFINITY, f64::min);
    let most = ratios().fold(0.0, f64::max);
    match curve.comparison.ahead {
        Ahead::Ours => Some(times(least, most, "faster") + " than"),
        Ahead::Refit => Some(times(1.0 / most, 1.0 / least, "slower") + " than"),
        _ => is_noise(curve).then(|| "about as fast as".to_string()),
    }
}

/// Of two ratios, the smaller first.
fn times(least: f64, most: f64, than: &str) -> String {
    let [least, most] = [least, most].map(|x| format!("{x:.1}"));
    match least == most {
        true => format!("{most} times {than}"),
        false => format!("{least} to {most} times {than}"),
    }
}

/// How fast bdtree is where deform + refit takes `ratio` times as long.
fn pace(ratio: f64) -> String {
    match Side::of(ratio) {
        Some(Side::Ours) => times(ratio, ratio, "faster"),
        Some(Side::Refit) => times(1.0 / ratio, 1.0 / ratio, "slower"),
        None => "about as fast".to_string(),
    }
}

/// From the least to the most that was tried.
fn range(curve: &Curve) -> String {
    let [first, last] = [curve.points.first(), curve.points.last()];
    let [first, last] = [first, last].map(|point| point.map_or(0.0, |point| point.amount));
    let from = match first {
        0.0 => "nothing touching".to_string(),
        first => count(first),
    };
    format!("{from} to {}", amount(last, &curve.unit))
}

/// Where no pairs touch.
const NOTHING: &str = "with nothing touching";

/// So many of a unit.
fn amount(n: f64, unit: &str) -> String {
    let unit = match (n, unit) {
        (0.0, _) => return "nothing touching".to_string(),
        (1.0, "balls per step") => "ball per step",
        (1.0, "rays per step") => "ray per step",
        (1.0, "touching pairs of triangles") => "touching pair of triangles",
        (_, unit) => unit,
    };
    format!("{} {unit}", count(n))
}

#[cfg(test)]
pub(super) mod tests {
    use crate::comparison::Comparison;

    use super::super::content::{Curve, CurvePoint};
    use super::{sentence, title, verdict};

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
            refined_rel: 0.0,
        };
        Curve {
            question: question.to_string(),
            unit,
            points: ratios.iter().map(point).collect(),
            comparison: Comparison::of(ratios),
        }
    }

    /// Of a curve of balls that is safely ahead nowhere throughout: title and verdict end with the same words, and the
    /// advice says what to do there.
    #[test]
    fn title_verdict_and_advice_say_the_same() {
        for (ratios, standing, advice) in [
            (
                &[(1.0, 12.0), (16.0, 12.0), (64.0, 0.5)][..],
                "faster up to 16, unsure between 16 and 64, slower from 64 on",
                "With 1 ball per step bdtree is 12.0 times faster than deform + refit, with 64 balls per step, the \
                 most that was tried, 2.0 times slower: faster up to 16; unsure between 16 and 64; from 64 on, deform \
                 and refit instead.",
            ),
            (
                &[(1.0, 0.5), (4.0, 2.0)],
                "slower up to 1, unsure between 1 and 4, faster from 4 on",
                "With 1 ball per step bdtree is 2.0 times slower than deform + refit, with 4 balls per step, the most \
                 that was tried, 2.0 times faster: up to 1, deform and refit instead; unsure between 1 and 4; faster \
                 from 4 on.",
            ),
            // A dip between two safe ends.
            (
                &[
                    (0.0, 3.4),
                    (18.0, 0.92),
                    (53.0, 1.14),
                    (87.0, 1.09),
                    (156.0, 1.19),
                    (436.0, 1.39),
                ],
                "faster with nothing touching, unsure below 156, faster from 156 on",
                "With nothing touching bdtree is 3.4 times faster than deform + refit, with 436 balls per step, the \
                 most that was tried, 1.4 times faster: faster with nothing touching; unsure below 156; faster from \
                 156 on.",
            ),
            // Noise at an end.
            (
                &[(1.0, 9.0), (4.0, 2.0), (16.0, 1.0), (20_000.0, 1.0)],
                "faster up to 4, unsure above 4",
                "With 1 ball per step bdtree is 9.0 times faster than deform + refit, with 20\u{202f}000 balls per \
                 step, the most that was tried, about as fast: faster up to 4; unsure above 4.",
            ),
            // The most alone is hardly outside the noise.
            (
                &[(1.0, 9.0), (114.0, 2.0), (600.0, 1.0), (1468.0, 1.104)],
                "faster up to 114, unsure above 114",
                "With 1 ball per step bdtree is 9.0 times faster than deform + refit, with 1468 balls per step, the \
                 most that was tried, 1.1 times faster: faster up to 114; unsure above 114.",
            ),
            (
                &[(0.0, 6.0), (900.0, 1.04)],
                "faster with nothing touching, unsure beyond",
                "With nothing touching bdtree is 6.0 times faster than deform + refit, with 900 balls per step, the \
                 most that was tried, about as fast: faster with nothing touching; unsure beyond.",
            ),
            (
                &[(1.0, 1.0), (4.0, 1.05), (256.0, 1.9)],
                "unsure below 256, faster from 256 on",
                "With 1 ball per step bdtree is about as fast as deform + refit, with 256 balls per step, the most \
                 that was tried, 1.9 times faster: unsure below 256; faster from 256 on.",
            ),
            // At both.
            (
                &[(1.0, 0.95), (4.0, 0.5), (16.0, 1.0)],
                "unsure at every amount tried",
                "With 1 ball per step bdtree is about as fast as deform + refit, with 16 balls per step, the most \
                 that was tried, about as fast: unsure at every amount tried.",
            ),
        ] {
            let curve = curve("ball", ratios);
            assert_eq!(
                title(&curve),
                format!("balls per step: bdtree is {standing}")
            );
            let says = format!("Balls per step, against deform + refit: {standing}.");
            assert_eq!(verdict(&curve), Some(says));
            assert_eq!(sentence(&curve).as_deref(), Some(advice));
        }
        assert_eq!(sentence(&curve("ball", &[])), None);
        assert_eq!(verdict(&curve("ball", &[])), None);
    }

    #[test]
    fn what_is_the_same_everywhere_is_said_once() {
        let curve = |ratios: &[(f64, f64)]| curve("ray", ratios);
        let ours = curve(&[(1.0, 30.76), (4096.0, 1.2)]);
        assert_eq!(
            title(&ours),
            "rays per step: bdtree is faster at every amount tried"
        );
        assert_eq!(
            verdict(&ours).as_deref(),
            Some(
                "Rays per step: 1.2 to 30.8 times faster than deform + refit, up to the 4096 tried."
            )
        );
        assert_eq!(
            sentence(&ours).as_deref(),
            Some(
                "bdtree is 1.2 to 30.8 times faster than deform + refit at every amount tried (1 to 4096 rays per \
                 step)."
            )
        );
        let refit = curve(&[(1.0, 0.5), (4.0, 0.1)]);
        assert_eq!(
            title(&refit),
            "rays per step: bdtree is slower at every amount tried"
        );
        assert_eq!(
            verdict(&refit).as_deref(),
            Some("Rays per step: 2.0 to 10.0 times slower than deform + refit, up to the 4 tried.")
        );
        assert_eq!(
            sentence(&refit).as_deref(),
            Some(
                "bdtree is 2.0 to 10.0 times slower than deform + refit at every amount tried (1 to 4 rays per step): \
                 deform and refit instead."
            )
        );
        let noise = curve(&[(1.0, 1.0)]);
        assert_eq!(
            title(&noise),
            "rays per step: bdtree is about as fast at every amount tried"
        );
        assert_eq!(
            verdict(&noise).as_deref(),
            Some("Rays per step: about as fast as deform + refit, up to the 1 tried.")
        );
        assert_eq!(
            sentence(&noise).as_deref(),
            Some("bdtree is about as fast as deform + refit with 1 ray per step.")
        );
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
