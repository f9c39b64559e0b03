//! How much larger than necessary spheres are.

use super::super::content::{Content, Ratio, TightnessRow};
use super::super::text::percent;
use super::{Page, line};
use crate::plot::{Axis, Plot};

impl Page {
    pub(super) fn tightness(&mut self, content: &Content) {
        if content.tightness.is_empty() {
            return;
        }
        self.heading("Tightness");
        match content.asset.skin {
            Some(_) => self.tightness_in_poses(content),
            None => self.tightness_by_amplitude(content),
        }
    }

    /// With a skin: ours alone, in the poses of samples.
    fn tightness_in_poses(&mut self, content: &Content) {
        let rows = &content.tightness;
        self.soft(&format!(
            "Radius over that of the smallest ball around the deformed vertices, per level (0 is the root's), in {} of \
             the samples.",
            content.samples.of_parts.tightness
        ));
        self.open();
        self.plot(&Plot {
            mark: None,
            title: "In the poses of the samples".to_string(),
            x: Axis::linear("level"),
            y: Axis::from("R' / R_opt", 1.0),
            lines: vec![
                line("mean", rows, |r| (r.level as f64, r.bdtree.mean)),
                line("largest", rows, |r| (r.level as f64, r.bdtree.max)),
            ],
        });
        self.table::<TightnessRow>(
            rows,
            0,
            &[
                ("level", &|r| r.level.to_string()),
                ("spheres measured", &|r| r.spheres.to_string()),
                ("mean / largest", &|r| both(&r.bdtree)),
            ],
        );
        self.close();
    }

    fn tightness_by_amplitude(&mut self, content: &Content) {
        let rows = &content.tightness;
        self.soft(&format!(
            "Radius over that of the smallest ball around the deformed vertices, mean per level (0 is the root's): in {} of \
             the samples as they are, and scaled until the vertex that moves most moves by the share of the diagonal \
             in the plot's title.",
            content.samples.of_parts.tightness
        ));
        // The samples as they are stand first.
        let order =
            |a: &Option<f64>, b: &Option<f64>| a.unwrap_or(0.0).total_cmp(&b.unwrap_or(0.0));
        let mut amplitudes: Vec<Option<f64>> = rows.iter().map(|r| r.displacement_rel).collect();
        amplitudes.sort_by(order);
        amplitudes.dedup();
        // One axis for all, so that they can be compared.
        let means = |r: &TightnessRow| [paper(r), smallest_ball(r), r.bdtree].map(|r| r.mean);
        let most = rows.iter().flat_map(means).fold(1.0, f64::max);
        self.open();
        for amplitude in &amplitudes {
            let own = rows.iter().filter(|r| r.displacement_rel == *amplitude);
            let own: Vec<&TightnessRow> = own.collect();
            let of = |name: &str, ratio: &dyn Fn(&TightnessRow) -> Ratio| {
                line(name, &own, |r| (r.level as f64, ratio(r).mean))
            };
            self.plot(&Plot {
                mark: None,
                title: match amplitude {
                    None => "In the poses of the samples".to_string(),
                    Some(amplitude) => format!("{} of the diagonal", percent(*amplitude)),
                },
                x: Axis::linear("level"),
                y: Axis::from("R' / R_opt", 1.0).to(most),
                lines: vec![
                    of("paper", &paper),
                    of("smallest balls", &smallest_ball),
                    of("bdtree", &|r| r.bdtree),
                ],
            });
        }
        let mut rows = rows.clone();
        rows.sort_by(|a, b| order(&a.displacement_rel, &b.displacement_rel));
        self.table::<TightnessRow>(
            &rows,
            0,
            &[
                ("moved by", &|r| {
                    r.displacement_rel.map_or("as is".to_string(), percent)
                }),
                ("level", &|r| r.level.to_string()),
                ("spheres measured", &|r| r.spheres.to_string()),
                ("paper, mean / largest", &|r| both(&paper(r))),
                ("smallest balls", &|r| both(&smallest_ball(r))),
                ("bdtree", &|r| both(&r.bdtree)),
            ],
        );
        self.close();
    }
}

/// What a row has without a skin; nothing else is asked for it.
const NONE: Ratio = Ratio {
    mean: f64::NAN,
    max: f64::NAN,
};

fn paper(row: &TightnessRow) -> Ratio {
    row.paper.unwrap_or(NONE)
}

fn smallest_ball(row: &TightnessRow) -> Ratio {
    row.smallest_ball.unwrap_or(NONE)
}

fn both(ratio: &Ratio) -> String {
    format!("{:.3} / {:.3}", ratio.mean, ratio.max)
}
