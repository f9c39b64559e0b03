//! What stopping at a level brings.

use super::super::content::{Content, DepthRow};
use super::super::text::{count, figure, number, percent, share};
use super::{Column, Page, line};
use crate::plot::{Axis, Plot};

impl Page {
    pub(super) fn depth(&mut self, content: &Content) {
        let rows = &content.depth;
        if rows.len() < 2 {
            return;
        }
        self.heading("Depth of traversal");
        let whole = &content.depth_whole;
        let samples = content.samples.of_parts.depth;
        let at = places(samples, &content.samples.some(samples), whole.apart_rel);
        let others = match content.modes.is_empty() {
            true => "",
            false => ", not on one as in \"Modes kept\": visits and times differ",
        };
        self.soft(&format!(
            "Queries with a ball of {} of the diagonal that stop at a level and report its spheres, at {at}. The \
             center of the ball is up to 1.7 radii off a point of the surface{others}. Without a level limit a query \
             takes {} µs and visits {} nodes. With a limit it misses nothing; the tables show the extra area, the \
             depth error and false positives: samples where spheres are reported though the ball touches nothing.",
            percent(content.samples.balls.large_rel),
            number(whole.ball_micros),
            number(whole.ball_visits),
        ));
        let line = |name: &str, of: &dyn Fn(&DepthRow) -> f64| {
            line(name, rows, |r| (r.level as f64, of(r)))
        };
        self.open();
        self.plot(&Plot {
            mark: None,
            title: "Largest penetration-depth error".to_string(),
            x: Axis::linear("level"),
            y: Axis::log("% of the diagonal"),
            lines: vec![line("error", &|r| 100.0 * r.penetration_error_rel)],
        });
        self.plot(&Plot {
            mark: None,
            title: "Time of a ball query".to_string(),
            x: Axis::linear("level"),
            y: Axis::linear("µs"),
            lines: vec![
                line("with a level limit", &|r| r.ball_micros),
                line("no level limit", &|_| whole.ball_micros),
            ],
        });
        self.close();
        let level: Column<'_, DepthRow> = ("level", &|r| r.level.to_string());
        self.open();
        self.table::<DepthRow>(
            rows,
            0,
            &[
                level,
                ("missed area / touched", &|r| share(r.missed_area_rel)),
                ("extra area / touched", &|r| share(r.extra_area_rel)),
                ("depth error / diagonal", &|r| {
                    share(r.penetration_error_rel)
                }),
                ("false positives / samples", &|r| share(r.false_rel)),
            ],
        );
        self.table::<DepthRow>(
            rows,
            0,
            &[
                level,
                ("µs", &|r| figure(r.ball_micros)),
                ("time / no limit", &|r| figure(r.time_rel)),
                ("visits", &|r| figure(r.ball_visits)),
            ],
        );
        self.close();
    }
}

/// How many samples there are, `some` of them where they are one, and at how many the ball touches nothing: counted, for a
/// share of so few looks more exact than it is.
fn places(samples: usize, some: &str, apart_rel: f64) -> String {
    match (samples, apart_rel) {
        (1, 0.0) => some.to_string(),
        (1, _) => format!("{some}, where the ball touches nothing"),
        (_, 0.0) => format!("{samples} samples, in all of which the ball touches the asset"),
        (_, apart) => format!(
            "{samples} samples; at {} of them the ball touches nothing",
            count(apart * samples as f64)
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::places;

    #[test]
    fn samples_are_counted() {
        for (samples, apart_rel, text) in [
            (1, 0.0, "the rest pose"),
            (1, 1.0, "the rest pose, where the ball touches nothing"),
            (
                24,
                1.0 / 24.0,
                "24 samples; at 1 of them the ball touches nothing",
            ),
            (
                6,
                0.0,
                "6 samples, in all of which the ball touches the asset",
            ),
        ] {
            assert_eq!(places(samples, "the rest pose", apart_rel), text);
        }
    }
}
