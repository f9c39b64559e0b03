//! The report in a few sentences.

use super::content::{Content, TightnessRow};
use super::text::grouped;
use super::words;

/// Speed, tightness, containment.
pub(super) fn verdict(content: &Content) -> Vec<String> {
    let mut sentences = Vec::new();
    if let Some(refit) = &content.refit {
        sentences.extend(refit.curves.iter().filter_map(words::verdict));
    }
    let at = content.samples.some(content.samples.of_parts.tightness);
    sentences.extend(tightness(&content.tightness, &at));
    if let Some(margin) = &content.margin {
        sentences.push(match margin.violations {
            0 => format!("Containment: no vertex left its sphere in {} adversarial tests.", grouped(margin.cases)),
            n => format!("Containment: {n} vertices left their spheres in {} adversarial tests: do not use this file.", grouped(margin.cases)),
        });
    }
    sentences
}

/// How large spheres are in the poses of the samples.
fn tightness(rows: &[TightnessRow], at: &str) -> Option<String> {
    let (mut sum, mut count) = (0.0, 0.0);
    for row in rows.iter().filter(|row| row.displacement_rel.is_none()) {
        sum += row.bdtree.mean * row.spheres as f64;
        count += row.spheres as f64;
    }
    (count > 0.0).then(|| {
        format!(
            "Sphere radii: on average {:.2} times those of the smallest balls, at {at}.",
            sum / count
        )
    })
}

#[cfg(test)]
mod tests {
    use super::super::content::{Ratio, TightnessRow};
    use super::tightness;

    #[test]
    fn tightness_is_that_of_the_samples() {
        let row = |displacement_rel, spheres, mean| {
            let ratio = Ratio { mean, max: 2.0 };
            TightnessRow {
                displacement_rel,
                level: 0,
                spheres,
                paper: Some(ratio),
                smallest_ball: Some(ratio),
                bdtree: ratio,
            }
        };
        let rows = [
            row(Some(0.02), 8, 1.5),
            row(None, 1, 1.3),
            row(None, 3, 1.1),
        ];
        assert_eq!(
            tightness(&rows, "8 of 24 frames of the animation").as_deref(),
            Some(
                "Sphere radii: on average 1.15 times those of the smallest balls, at 8 of 24 frames of the animation."
            )
        );
        assert_eq!(tightness(&rows[..1], "the rest pose"), None);
    }
}
