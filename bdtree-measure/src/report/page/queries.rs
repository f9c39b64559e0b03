//! What stopping at a level and leaving modes out of bounds bring.

use super::super::content::{Content, DepthRow, ToleranceRow};
use super::super::text::{number, percent};
use super::{Page, line};
use crate::plot::{Axis, Plot};

impl Page {
    pub(super) fn depth(&mut self, content: &Content) {
        let rows = &content.depth;
        if rows.len() < 2 {
            return;
        }
        self.heading("Depth of traversal");
        let whole = &content.depth_whole;
        self.soft(&format!(
            "A query with a ball of {} of the diagonal that stops at a level and reports its spheres, at {} samples; at {} \
             of them the ball touches nothing. One that looks into everything takes {} µs and visits {} nodes. \
             Nothing touched is missed; what is reported in excess, and how far depths are off:",
            percent(content.samples.balls.large_rel),
            content.samples.of_parts.depth,
            percent(whole.apart_rel),
            number(whole.ball_micros),
            number(whole.ball_visits),
        ));
        let line = |name: &str, of: &dyn Fn(&DepthRow) -> f64| {
            line(name, rows, |r| (r.level as f64, of(r)))
        };
        self.open();
        self.plot(&Plot {
            title: "Largest error of the penetration".to_string(),
            x: Axis::linear("level"),
            y: Axis::log("error / diagonal"),
            lines: vec![line("error", &|r| r.penetration_error_rel)],
        });
        self.plot(&Plot {
            title: "Time of a ball query".to_string(),
            x: Axis::linear("level"),
            y: Axis::linear("µs"),
            lines: vec![
                line("stopped", &|r| r.ball_micros),
                line("looking into everything", &|_| whole.ball_micros),
            ],
        });
        self.table::<DepthRow>(
            rows,
            0,
            &[
                ("level", &|r| r.level.to_string()),
                ("µs", &|r| number(r.ball_micros)),
                ("over everything", &|r| number(r.time_rel)),
                ("visits", &|r| number(r.ball_visits)),
                ("missed area / touched", &|r| percent(r.missed_area_rel)),
                ("extra area / touched", &|r| percent(r.extra_area_rel)),
                ("penetration error / diagonal", &|r| {
                    percent(r.penetration_error_rel)
                }),
                ("answers though nothing touches", &|r| percent(r.false_rel)),
            ],
        );
        self.close();
    }

    pub(super) fn tolerance(&mut self, content: &Content) {
        let rows = &content.tolerance;
        if rows.is_empty() {
            return;
        }
        self.heading("Modes left out of node bounds");
        self.soft(&format!(
            "Pose::with_tolerance: modes that move no vertex by more than the tolerance together are left out of \
             spheres, which grow by it. Answers stay the same. Means over {} samples of 16 balls of {} of the diagonal \
             and 16 rays each.",
            content.samples.of_parts.tolerance,
            percent(content.samples.balls.small_rel),
        ));
        self.open();
        self.plot(&Plot {
            title: "Time of 16 balls and 16 rays".to_string(),
            x: Axis::log("tolerance / diagonal"),
            y: Axis::linear("µs"),
            lines: vec![line("time", rows, |r| (r.tolerance_rel, r.micros))],
        });
        self.table::<ToleranceRow>(
            rows,
            0,
            &[
                ("tolerance / diagonal", &|r| percent(r.tolerance_rel)),
                ("modes left", &|r| number(r.active_modes)),
                ("visits", &|r| number(r.visits)),
                ("µs", &|r| number(r.micros)),
            ],
        );
        self.close();
    }
}
