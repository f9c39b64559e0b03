//! The page's part on deform + refit: times over how much is asked, and where they cross.

use crate::comparison::{Ahead, NOISE};

use super::super::content::{Content, Curve, CurvePoint};
use super::super::text::{number, percent};
use super::super::words;
use super::{Page, line};
use crate::plot::{Axis, Mark, Plot};

impl Page {
    pub(super) fn refit(&mut self, content: &Content) {
        let Some(refit) = &content.refit else {
            return;
        };
        self.heading("Beside deform + refit");
        self.text(&format!(
            "Deform + refit first deforms all vertices{}, {} µs, and refits {}, {} µs, in every step. bdtree only sets \
             the pose: {} µs per step. Over {} samples; balls have a radius of {} of the diagonal.",
            match content.asset.skin {
                Some(_) => " and carries them by their bones",
                None => "",
            },
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
             f32; bdtree rejects four triangles at a time, and tests balls four at a time. Ratio: \
             deform + refit over bdtree. From {} to {} it is noise; beyond, one is safely ahead. Rows of the same \
             amount count as their mean.",
            NOISE[0], NOISE[1]
        ));
        self.open();
        for curve in &refit.curves {
            self.curve(curve);
        }
        self.close();
        self.open();
        for curve in &refit.curves {
            self.table::<CurvePoint>(
                &curve.points,
                0,
                &[
                    (curve.unit.as_str(), &|p| number(p.amount)),
                    ("bdtree, µs", &|p| number(p.bdtree_micros)),
                    ("deform + refit, µs", &|p| number(p.refit_micros)),
                    ("ratio", &|p| number(p.ratio)),
                    ("visits / nodes", &|p| number(p.visited_rel)),
                ],
            );
        }
        self.close();
    }

    fn curve(&mut self, curve: &Curve) {
        let lines = vec![
            line("bdtree", &curve.points, |p| (p.amount, p.bdtree_micros)),
            line("deform + refit", &curve.points, |p| {
                (p.amount, p.refit_micros)
            }),
        ];
        self.plot(&Plot {
            mark: mark(curve),
            title: words::title(curve),
            x: Axis::log(&curve.unit),
            y: Axis::log("µs per step"),
            lines,
        });
    }
}

/// What a plot marks: where the times cross, or the stretch in which neither is safely ahead; nothing where
/// one is everywhere.
fn mark(curve: &Curve) -> Option<Mark> {
    let comparison = &curve.comparison;
    let (name, ends) = match comparison.ahead {
        Ahead::Ours | Ahead::Refit => return None,
        Ahead::Crosses => ("break-even", [comparison.break_even?; 2]),
        Ahead::Close => ("neither safely ahead", [comparison.from?, comparison.to?]),
    };
    Some(Mark {
        name: name.to_string(),
        ends,
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
        assert_eq!(crosses.ends, [10.0; 2]);
        let close = mark(&curve("ray", &[(1.0, 10.0), (4.0, 1.0), (16.0, 1.0)])).expect("a mark");
        assert_eq!(close.name, "neither safely ahead");
        assert_eq!(close.ends, [1.0, 16.0]);
    }
}
