//! What fewer modes cost and save.

use bdtree_build::figures::numbers;

use super::super::content::{Content, ModesAdvised, ModesRow};
use super::super::text::{figure, grouped, percent, share};
use super::{Column, Page, line};
use crate::plot::{Axis, Plot};

impl Page {
    pub(super) fn modes(&mut self, content: &Content) {
        let rows = &content.modes;
        if rows.is_empty() {
            return;
        }
        self.heading("Modes kept");
        self.soft(&format!(
            "The first k modes of the file. Error: how far vertices are from where all modes of the file have them, over \
             {}. Bytes, visits and times: of a file baked again with k modes, whose metadata are shorter than this file's; \
             times are the least of several rounds, over {} samples. Each row was timed in turn with all modes, so only \
             \"time / all\" is comparable between rows. A ball has a radius of {} of the diagonal and its center on the \
             surface, a ray is one of 16 asked together, a pair is the asset beside itself.",
            content.modes_over.as_deref().unwrap_or("the samples"),
            content.samples.of_parts.modes,
            percent(content.samples.balls.large_rel),
        ));
        let line = |name: &str, of: &dyn Fn(&ModesRow) -> f64| {
            line(name, rows, |r| (r.modes as f64, of(r)))
        };
        self.open();
        // Of one mode there is a single point.
        if rows.len() > 1 {
            self.plot(&Plot {
                mark: None,
                title: "Error / box diagonal".to_string(),
                x: Axis::linear("modes kept"),
                y: Axis::log("% of the diagonal"),
                lines: vec![
                    line("largest", &|r| 100.0 * r.error_max_rel),
                    line("root mean square", &|r| 100.0 * r.error_rms_rel),
                ],
            });
        }
        self.plot(&Plot {
            mark: None,
            title: "Query time relative to all modes".to_string(),
            x: Axis::linear("modes kept"),
            y: Axis::linear("time / time with all modes"),
            lines: vec![line("time", &|r| r.time_rel)],
        });
        self.plot(&Plot {
            mark: None,
            title: "File size".to_string(),
            x: Axis::linear("modes kept"),
            y: Axis::linear("MB"),
            lines: vec![line("bytes", &|r| r.bytes as f64 / 1e6)],
        });
        self.close();
        if let Some(advised) = &content.modes_advised {
            let mut text = beside_the_first(advised);
            if content.made.basis.as_deref() == Some("morph") {
                text += " A bake takes these with --max-error-rel; --modes K takes the first.";
            }
            self.soft(&text);
        }
        // As the plots above: errors, times, and what they come from.
        let modes: Column<'_, ModesRow> = ("modes", &|r| r.modes.to_string());
        self.open();
        self.table::<ModesRow>(
            rows,
            0,
            &[
                modes,
                ("largest error", &|r| figure(r.error_max)),
                ("rms error", &|r| figure(r.error_rms)),
                ("largest / diagonal", &|r| share(r.error_max_rel)),
                ("rms / diagonal", &|r| share(r.error_rms_rel)),
            ],
        );
        self.table::<ModesRow>(
            rows,
            0,
            &[
                modes,
                ("ball, µs", &|r| figure(r.ball_micros)),
                ("ray, µs", &|r| figure(r.ray_micros)),
                ("pair, µs", &|r| figure(r.pair_micros)),
                ("time / all", &|r| figure(r.time_rel)),
            ],
        );
        self.table::<ModesRow>(
            rows,
            0,
            &[
                modes,
                ("bytes", &|r| grouped(r.bytes)),
                ("ball, visits", &|r| figure(r.ball_visits)),
                ("ray, visits", &|r| figure(r.ray_visits)),
                ("pair, visits", &|r| figure(r.pair_visits)),
            ],
        );
        self.close();
    }
}

/// What the plots do not show: they are of the first modes.
fn beside_the_first(advised: &ModesAdvised) -> String {
    let which = numbers(&advised.modes);
    let error = match advised.error_max_rel {
        0.0 => "no error".to_string(),
        // What is as small is rounding.
        error if error < 1e-5 => "an error below 0.001 % of the diagonal".to_string(),
        error => format!("an error of at most {} of the diagonal", percent(error)),
    };
    match advised.modes.len() {
        0 => format!("The advice is to keep none of the modes, which leaves {error}."),
        1 => format!("The advised mode, {which}, is not the first one: it leaves {error}."),
        count => {
            format!("The advised modes ({which}) are not the first {count}: they leave {error}.")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::content::ModesAdvised;
    use super::beside_the_first;

    #[test]
    fn advised_modes_that_are_not_the_first_are_named() {
        let text = |modes: &[usize], error_max_rel| {
            beside_the_first(&ModesAdvised {
                modes: modes.to_vec(),
                error_max_rel,
            })
        };
        assert_eq!(
            text(&[6, 7, 8], 0.0),
            "The advised modes (6 to 8) are not the first 3: they leave no error."
        );
        assert_eq!(
            text(&[1, 4], 2.5e-8),
            "The advised modes (1, 4) are not the first 2: they leave an error below 0.001 % of the diagonal."
        );
        assert_eq!(
            text(&[2], 0.0042),
            "The advised mode, 2, is not the first one: it leaves an error of at most 0.42 % of the diagonal."
        );
    }
}
