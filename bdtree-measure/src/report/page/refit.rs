//! The page's part on deform + refit: times over how much is asked, and where they cross.

use crate::comparison::NOISE;

use super::super::content::{Content, Curve, CurvePoint, Refit};
use super::super::text::{count, figure, grouped, number, percent};
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
             deform + refit over bdtree. From {} to {} it is noise; beyond, one is safely ahead. Gray: amounts at \
             which it is unsure who is faster. One and the same side is safely ahead at every smaller amount tried, and \
             likewise at every larger one.",
            NOISE[0], NOISE[1]
        ));
        self.text(&refining(refit));
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
                    (curve.unit.as_str(), &|p| count(p.amount)),
                    ("bdtree, µs", &|p| figure(p.bdtree_micros)),
                    ("deform + refit, µs", &|p| figure(p.refit_micros)),
                    ("ratio", &|p| figure(p.ratio)),
                    ("visits / nodes", &|p| figure(p.visited_rel)),
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

/// From how much on a refined pose pays.
fn refining(refit: &Refit) -> String {
    let first = |curve: &Curve| {
        let point = curve.points.iter().find(|p| p.refined_rel == 1.0)?;
        Some(format!("{} {}", count(point.amount), curve.unit))
    };
    let from: Vec<String> = refit.curves.iter().filter_map(first).collect();
    let bytes = grouped(refit.refined_bytes);
    match from.is_empty() {
        true => format!(
            "No step here asks so much that refining the pose pays (StepCache::refining, {bytes} bytes)."
        ),
        false => format!(
            "bdtree refines its pose by itself where that pays (StepCache::refining, {bytes} bytes): of the amounts tried, \
             from {} on.",
            from.join(" and ")
        ),
    }
}

/// What a plot marks: the stretch in which it is unsure who is faster; nothing where one is safely ahead everywhere.
fn mark(curve: &Curve) -> Option<Mark> {
    let (from, to) = (curve.comparison.from?, curve.comparison.to?);
    (from < to).then(|| Mark {
        name: "unsure".to_string(),
        ends: [from, to],
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
        assert!(mark(&curve("ray", &[(1.0, 1.0)])).is_none());
        for (ratios, ends) in [
            ([(1.0, 10.0), (4.0, 3.0), (100.0, 0.1)], [4.0, 100.0]),
            ([(1.0, 10.0), (4.0, 1.0), (16.0, 1.0)], [1.0, 16.0]),
        ] {
            let mark = mark(&curve("ray", &ratios)).expect("a mark");
            assert_eq!((mark.name.as_str(), mark.ends), ("unsure", ends));
        }
    }
}
