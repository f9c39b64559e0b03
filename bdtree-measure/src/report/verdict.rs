//! The report in a few sentences.

use crate::comparison::{Ahead, Side};

use super::content::{Content, Curve, TightnessRow};
use super::text::{capitalised, grouped, number, percent};

/// Speed, tightness, containment.
pub(super) fn verdict(content: &Content) -> Vec<String> {
    let mut sentences = Vec::new();
    if let Some(refit) = &content.refit {
        sentences.extend(refit.curves.iter().filter_map(speed));
    }
    sentences.extend(tightness(
        &content.tightness,
        content.samples.displacement_max_rel,
    ));
    if let Some(margin) = &content.margin {
        sentences.push(match margin.violations {
            0 => format!("Containment: no vertex left its sphere in {} adversarial tests.", grouped(margin.cases)),
            n => format!("Containment: {n} vertices left their spheres in {} adversarial tests: do not use this file.", grouped(margin.cases)),
        });
    }
    sentences
}

/// Who answers one kind of query faster.
fn speed(curve: &Curve) -> Option<String> {
    const THAN: &str = "than deform + refit";
    let comparison = &curve.comparison;
    let points = curve.merged();
    let ratios = || points.iter().map(|(_, ratio)| *ratio);
    let most = ratios().fold(0.0, f64::max);
    let least = ratios().fold(f64::INFINITY, f64::min);
    let tried = number(points.last()?.0);
    let verdict = match comparison.ahead {
        Ahead::Ours => {
            format!(
                "{} {THAN}, up to the {tried} tried",
                times(least, most, "faster")
            )
        }
        Ahead::Refit => {
            let words = times(1.0 / most, 1.0 / least, "slower");
            format!("{words} {THAN}, up to the {tried} tried")
        }
        Ahead::Crosses => {
            let side = match comparison.above {
                Some(Side::Ours) => "above",
                _ => "below",
            };
            format!(
                "faster {THAN} {side} about {}",
                number(comparison.break_even?)
            )
        }
        Ahead::Close if comparison.below == Some(Side::Ours) => {
            let from = number(comparison.from?);
            format!("faster {THAN} up to {from}; beyond, neither is safely ahead")
        }
        Ahead::Close => format!("about as fast as deform + refit, up to the {tried} tried"),
    };
    Some(format!("{}: {verdict}.", capitalised(&curve.unit)))
}

/// Of two ratios, the smaller first.
pub(super) fn times(least: f64, most: f64, than: &str) -> String {
    let [least, most] = [least, most].map(|x| format!("{x:.1}"));
    match least == most {
        true => format!("{most} times {than}"),
        false => format!("{least} to {most} times {than}"),
    }
}

/// How large spheres are where the farthest vertex moves about as far as in the samples.
fn tightness(rows: &[TightnessRow], moved: f64) -> Option<String> {
    // With a skin all rows are of the samples as they are.
    let off = |row: &&TightnessRow| row.displacement_rel.map_or(0.0, |d| (d / moved).ln().abs());
    let nearest = rows.iter().min_by(|a, b| off(a).total_cmp(&off(b)))?;
    let own = rows
        .iter()
        .filter(|row| row.displacement_rel == nearest.displacement_rel);
    let (mut sum, mut count) = (0.0, 0.0);
    for row in own {
        sum += row.bdtree.mean * row.spheres as f64;
        count += row.spheres as f64;
    }
    let at = match nearest.displacement_rel {
        Some(moved) => format!(
            "where the farthest vertex moves by {} of the diagonal",
            percent(moved)
        ),
        None => "in the poses of the samples".to_string(),
    };
    Some(format!(
        "Sphere radii: on average {:.2} times those of the smallest balls, {at}.",
        sum / count
    ))
}

#[cfg(test)]
mod tests {
    use super::super::content::{Ratio, TightnessRow};
    use super::super::words::sentence;
    use super::super::words::tests::curve;
    use super::{speed, tightness};

    #[test]
    fn every_comparison_has_a_verdict() {
        for (ratios, says) in [
            (
                &[(1.0, 30.0), (4096.0, 1.5)][..],
                "Balls per step: 1.5 to 30.0 times faster than deform + refit, up to the 4096 tried.",
            ),
            (
                &[(1.0, 0.5), (4.0, 0.1)],
                "Balls per step: 2.0 to 10.0 times slower than deform + refit, up to the 4 tried.",
            ),
            (
                &[(1.0, 12.0), (12.0, 12.0), (1200.0, 1.0 / 12.0)],
                "Balls per step: faster than deform + refit below about 120.",
            ),
            (
                &[(1.0, 0.5), (4.0, 2.0)],
                "Balls per step: faster than deform + refit above about 2.",
            ),
            (
                &[(1.0, 9.0), (4.0, 1.0)],
                "Balls per step: faster than deform + refit up to 1; beyond, neither is safely ahead.",
            ),
            (
                &[(1.0, 1.0), (4.0, 1.0)],
                "Balls per step: about as fast as deform + refit, up to the 4 tried.",
            ),
        ] {
            assert_eq!(speed(&curve("ball", ratios)).as_deref(), Some(says));
        }
    }

    /// Rows of the same amount count as their mean in the headline and in the advice.
    #[test]
    fn the_verdict_and_the_advice_have_the_same_range() {
        let curve = curve("pair", &[(0.0, 9.0), (0.0, 4.0), (8.0, 2.0)]);
        let said = [speed(&curve), sentence(&curve)].map(|text| text.expect("points"));
        for text in said {
            assert!(text.contains("2.0 to 6.0 times faster"), "{text}");
        }
    }

    #[test]
    fn tightness_is_that_of_the_nearest_amplitude() {
        let row = |displacement_rel, spheres, mean| {
            let ratio = Ratio { mean, max: 2.0 };
            TightnessRow {
                displacement_rel: Some(displacement_rel),
                level: 0,
                spheres,
                paper: Some(ratio),
                smallest_ball: Some(ratio),
                bdtree: ratio,
            }
        };
        let rows = [row(0.02, 8, 1.5), row(0.1, 1, 1.3), row(0.1, 3, 1.1)];
        let text = tightness(&rows, 0.08).expect("rows");
        assert!(
            text.starts_with("Sphere radii: on average 1.15 times"),
            "{text}"
        );
        assert!(text.contains("moves by 10 % of the"), "{text}");
        assert_eq!(tightness(&[], 0.1), None);
    }
}
