//! The page's part on deform + refit: times over how much is asked, and where they cross.

use crate::comparison::{Ahead, NOISE};

use super::super::content::{Content, Curve, CurvePoint};
use super::super::text::{number, percent};
use super::super::words;
use super::{Page, line};
use crate::plot::{Axis, Line, Plot};

impl Page {
    pub(super) fn refit(&mut self, content: &Content) {
        let Some(refit) = &content.refit else {
            return;
        };
        self.heading("Beside deform + refit");
        self.text(&format!(
            "Deforming all vertices takes {} µs and refitting {} another {} µs, every step, before anything is \
             asked. Here a step begins with a pose, {} µs. Over {} samples; balls have a radius of {} of the diagonal.",
            number(refit.deform_micros),
            refit.library,
            number(refit.refit_micros),
            number(refit.pose_micros),
            content.samples.of_parts.refit,
            percent(content.samples.balls.small_rel),
        ));
        self.soft(&format!(
            "Both find the same contacts on the same deformed vertices. At leaves the refitted tree tests balls and \
             pairs triangle by triangle with this library's public scalar functions and rays with its own test in \
             f32; this asset's queries reject four triangles at a time, and test balls four at a time. Ratio: \
             deform + refit over this asset. From {} to {} it is noise; beyond, one is safely ahead.",
            NOISE[0], NOISE[1]
        ));
        self.open();
        for curve in &refit.curves {
            self.curve(curve);
        }
        for curve in &refit.curves {
            self.table::<CurvePoint>(
                &curve.points,
                0,
                &[
                    (curve.unit.as_str(), &|p| number(p.amount)),
                    ("ours, µs", &|p| number(p.ours_micros)),
                    ("deform + refit, µs", &|p| number(p.refit_micros)),
                    ("ratio", &|p| number(p.ratio)),
                    ("visits / nodes", &|p| number(p.visited_rel)),
                ],
            );
        }
        self.close();
    }

    fn curve(&mut self, curve: &Curve) {
        let mut lines = vec![
            line("this asset", &curve.points, |p| (p.amount, p.ours_micros)),
            line("deform + refit", &curve.points, |p| {
                (p.amount, p.refit_micros)
            }),
        ];
        lines.extend(mark(curve));
        self.plot(&Plot {
            title: words::title(curve),
            x: Axis::log(&curve.unit),
            y: Axis::log("µs per step"),
            lines,
        });
    }
}

/// What a plot marks: where the times cross, or the stretch in which neither is safely ahead; nothing where
/// one is everywhere.
fn mark(curve: &Curve) -> Option<Line> {
    let times = || {
        let both = |p: &CurvePoint| [p.ours_micros, p.refit_micros];
        curve.points.iter().flat_map(both)
    };
    let low = times().fold(f64::INFINITY, f64::min);
    let high = times().fold(0.0, f64::max);
    let comparison = &curve.comparison;
    let (name, points) = match comparison.ahead {
        Ahead::Ours | Ahead::Refit => return None,
        Ahead::Crosses => {
            let at = comparison.break_even?;
            ("break-even", vec![(at, low), (at, high)])
        }
        Ahead::Close => {
            let (from, to) = (comparison.from?, comparison.to?);
            let around = [(from, low), (from, high), (to, high), (to, low)];
            ("neither safely ahead", around.to_vec())
        }
    };
    Some(Line {
        name: name.to_string(),
        points,
    })
}

#[cfg(test)]
mod tests {
    use super::super::super::words::tests::curve;
    use super::mark;

    #[test]
    fn marks_are_where_the_words_are() {
        assert!(mark(&curve("ray", &[(1.0, 9.0), (4.0, 2.0)])).is_none());
        assert!(mark(&curve("ray", &[(1.0, 0.2)])).is_none());
        let crosses = mark(&curve("ray", &[(1.0, 10.0), (100.0, 0.1)])).expect("a mark");
        assert_eq!(crosses.name, "break-even");
        assert!(crosses.points.iter().all(|p| p.0 == 10.0));
        let close = mark(&curve("ray", &[(1.0, 10.0), (4.0, 1.0), (16.0, 1.0)])).expect("a mark");
        assert_eq!(close.name, "neither safely ahead");
        let at: Vec<f64> = close.points.iter().map(|p| p.0).collect();
        assert_eq!(at, [1.0, 1.0, 16.0, 16.0]);
        // From the fastest to the slowest of all times: 1 and 10 µs.
        assert!(close.points.iter().all(|p| p.1 == 1.0 || p.1 == 10.0));
    }
}
