//! How much larger than necessary spheres are.

use super::super::content::{Content, Ratio, TightnessRow};
use super::super::text::percent;
use super::{Page, line};
use crate::plot::{Axis, Plot};

impl Page {
    pub(super) fn tightness(&mut self, content: &Content) {
        let rows = &content.tightness;
        if rows.is_empty() {
            return;
        }
        self.heading("Tightness");
        self.soft(&format!(
            "Radius over that of the smallest ball around the deformed vertices, mean per level (0 is the root's), \
             along {} samples made longer or shorter until the farthest vertex moves by so much of the diagonal.",
            content.samples.of_parts.tightness
        ));
        let mut amplitudes: Vec<f64> = rows.iter().map(|r| r.displacement_rel).collect();
        amplitudes.sort_by(f64::total_cmp);
        amplitudes.dedup();
        // One axis for all, so that they can be compared.
        let means = |r: &TightnessRow| [r.paper.mean, r.smallest_ball.mean, r.bdtree.mean];
        let most = rows.iter().flat_map(means).fold(1.0, f64::max);
        self.open();
        for amplitude in &amplitudes {
            let own: Vec<&TightnessRow> = rows
                .iter()
                .filter(|r| r.displacement_rel == *amplitude)
                .collect();
            let of = |name: &str, ratio: &dyn Fn(&TightnessRow) -> Ratio| {
                line(name, &own, |r| (r.level as f64, ratio(r).mean))
            };
            self.plot(&Plot {
                mark: None,
                title: format!("{} of the diagonal", percent(*amplitude)),
                x: Axis::linear("level"),
                y: Axis::from("R' / R_opt", 1.0).to(most),
                lines: vec![
                    of("paper", &|r| r.paper),
                    of("smallest balls", &|r| r.smallest_ball),
                    of("bdtree", &|r| r.bdtree),
                ],
            });
        }
        let both = |ratio: &Ratio| format!("{:.3} / {:.3}", ratio.mean, ratio.max);
        let mut rows = rows.clone();
        rows.sort_by(|a, b| a.displacement_rel.total_cmp(&b.displacement_rel));
        self.table::<TightnessRow>(
            &rows,
            0,
            &[
                ("moved by", &|r| percent(r.displacement_rel)),
                ("level", &|r| r.level.to_string()),
                ("spheres", &|r| r.spheres.to_string()),
                ("paper, mean / largest", &|r| both(&r.paper)),
                ("smallest balls", &|r| both(&r.smallest_ball)),
                ("bdtree", &|r| both(&r.bdtree)),
            ],
        );
        self.close();
    }
}
