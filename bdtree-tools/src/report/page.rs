//! The report as one HTML page that needs nothing else.

mod refit;

use super::content::{Content, Ratio};
use super::plot::{self, Axis, Line, Plot};
use super::text::{escaped, grouped, number, percent};

/// The page.
pub(super) fn page(content: &Content) -> String {
    let mut page = Page::default();
    page.head(content);
    page.advice(content);
    page.modes(content);
    page.refit(content);
    page.tightness(content);
    page.depth(content);
    page.tolerance(content);
    page.bytes(content);
    page.margin(content);
    page.foot(content);
    let title = escaped(&content.file);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\
         <title>{title}: report</title>\n<style>\n{}{}</style></head>\n<body>\n{}</body></html>\n",
        include_str!("style.css"),
        plot::style(),
        page.body
    )
}

#[derive(Default)]
struct Page {
    body: String,
}

impl Page {
    fn line(&mut self, text: &str) {
        self.body += text;
        self.body.push('\n');
    }

    fn heading(&mut self, text: &str) {
        self.line(&format!("<h2>{}</h2>", escaped(text)));
    }

    fn text(&mut self, text: &str) {
        self.line(&format!("<p>{}</p>", escaped(text)));
    }

    fn soft(&mut self, text: &str) {
        self.line(&format!("<p class=\"soft\">{}</p>", escaped(text)));
    }

    fn open(&mut self) {
        self.line("<div class=\"row\">");
    }

    fn close(&mut self) {
        self.line("</div>");
    }

    fn plot(&mut self, plot: &Plot) {
        if let Some(svg) = plot.svg() {
            let title = escaped(&plot.title);
            let key = |(k, name): (usize, &str)| {
                format!(
                    "<span class=\"key\"><i style=\"background:var(--series-{k})\"></i>{}</span>",
                    escaped(name)
                )
            };
            let keys: String = plot.keys().map(key).collect();
            self.line(&format!(
                "<figure role=\"img\" aria-label=\"{title}\"><figcaption>{title}</figcaption>{keys}{svg}</figure>"
            ));
        }
    }

    /// Rows of cells; the first `texts` columns are text, the others numbers.
    fn table(&mut self, head: &[&str], texts: usize, rows: &[Vec<String>]) {
        let class = |k: usize| if k < texts { " class=\"text\"" } else { "" };
        let cells = |tag: &str, row: &mut dyn Iterator<Item = String>| {
            let cell = |(k, text): (usize, String)| {
                format!("<{tag}{}>{}</{tag}>", class(k), escaped(&text))
            };
            row.enumerate().map(cell).collect::<String>()
        };
        let head = cells("th", &mut head.iter().map(|h| h.to_string()));
        let mut text = format!("<div class=\"table\"><table><thead><tr>{head}</tr></thead><tbody>");
        for row in rows {
            text += &format!("<tr>{}</tr>", cells("td", &mut row.iter().cloned()));
        }
        self.line(&(text + "</tbody></table></div>"));
    }

    fn head(&mut self, content: &Content) {
        let asset = &content.asset;
        self.line(&format!("<h1>{}</h1>", escaped(&content.file)));
        let mut facts = vec![
            ("vertices", grouped(asset.vertices as u64)),
            ("triangles", grouped(asset.triangles as u64)),
            ("modes", asset.modes.to_string()),
            ("nodes", grouped(asset.nodes as u64)),
            ("levels", asset.depth.to_string()),
            ("bytes", grouped(asset.bytes)),
            ("diagonal", number(asset.diagonal)),
        ];
        facts.extend(asset.frames.map(|n| ("frames", n.to_string())));
        let error = asset.basis_error_rel;
        facts.extend(error.map(|e| ("error of the basis against its source", percent(e))));
        let of = |(name, value): &(&str, String)| format!("<span>{name} <b>{value}</b></span>");
        let facts: String = facts.iter().map(of).collect();
        self.line(&format!("<div class=\"facts\">{facts}</div>"));
        let samples = &content.samples;
        self.soft(&format!(
            "Samples: {}, which move the farthest vertex by up to {} of the diagonal; each part says how many of them \
             it takes. Lengths are mesh units; times are of one thread of {}, kernel {}, and medians of {} \
             repetitions unless a part says otherwise.",
            samples.source,
            percent(samples.displacement_max_rel),
            content.machine.processor,
            content.machine.kernel,
            content.machine.repetitions,
        ));
        for missing in &content.missing {
            self.text(missing);
        }
    }

    fn advice(&mut self, content: &Content) {
        if content.advice.is_empty() {
            return;
        }
        self.heading("Advice");
        let item = |a: &super::content::Advice| format!("<li>{}</li>", escaped(&a.text));
        let items: String = content.advice.iter().map(item).collect();
        self.line(&format!("<ul class=\"advice\">{items}</ul>"));
    }

    fn modes(&mut self, content: &Content) {
        let rows = &content.modes;
        if rows.is_empty() {
            return;
        }
        self.heading("Modes kept");
        self.soft(&format!(
            "The first k modes of the file. Error: how far vertices are from where all modes of the file have them, over \
             {}. Bytes, visits and times: of a file baked with k modes, without groups and names; times are the least of \
             several rounds, over {} samples. A ball has a radius of {} of the diagonal, a ray is one of 16 asked \
             together, a pair is the asset beside itself.",
            content.modes_over.as_deref().unwrap_or("the samples"),
            content.samples.of_parts.modes,
            percent(content.samples.balls.large_rel),
        ));
        let line = |name: &str, of: &dyn Fn(&super::content::ModesRow) -> f64| Line {
            name: name.to_string(),
            points: rows.iter().map(|r| (r.modes as f64, of(r))).collect(),
        };
        self.open();
        self.plot(&Plot {
            title: "Error over the diagonal".to_string(),
            x: Axis::linear("modes kept"),
            y: Axis::log("error / diagonal"),
            lines: vec![
                line("largest", &|r| r.error_max_rel),
                line("root mean square", &|r| r.error_rms_rel),
            ],
        });
        self.plot(&Plot {
            title: "Time over that with all modes".to_string(),
            x: Axis::linear("modes kept"),
            y: Axis::linear("time / time with all"),
            lines: vec![line("time", &|r| r.time_rel)],
        });
        self.plot(&Plot {
            title: "Length of the file".to_string(),
            x: Axis::linear("modes kept"),
            y: Axis::linear("MB"),
            lines: vec![line("bytes", &|r| r.bytes as f64 / 1e6)],
        });
        let cells = |r: &super::content::ModesRow| {
            vec![
                r.modes.to_string(),
                number(r.error_max),
                number(r.error_rms),
                percent(r.error_max_rel),
                percent(r.error_rms_rel),
                grouped(r.bytes),
                number(r.ball_micros),
                number(r.ray_micros),
                number(r.pair_micros),
                number(r.time_rel),
                number(r.ball_visits),
                number(r.ray_visits),
                number(r.pair_visits),
            ]
        };
        let rows: Vec<_> = rows.iter().map(cells).collect();
        let head = [
            "modes",
            "largest error",
            "rms error",
            "largest / diagonal",
            "rms / diagonal",
            "bytes",
            "ball, µs",
            "ray, µs",
            "pair, µs",
            "time / all",
            "ball, visits",
            "ray, visits",
            "pair, visits",
        ];
        self.table(&head, 0, &rows);
        self.close();
    }

    fn tightness(&mut self, content: &Content) {
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
        self.open();
        for amplitude in &amplitudes {
            let of = |name: &str, ratio: &dyn Fn(&super::content::TightnessRow) -> Ratio| Line {
                name: name.to_string(),
                points: rows
                    .iter()
                    .filter(|r| r.displacement_rel == *amplitude)
                    .map(|r| (r.level as f64, ratio(r).mean))
                    .collect(),
            };
            self.plot(&Plot {
                title: format!("{} of the diagonal", percent(*amplitude)),
                x: Axis::linear("level"),
                y: Axis::from("R' / R_opt", 1.0),
                lines: vec![
                    of("paper", &|r| r.paper),
                    of("smallest balls", &|r| r.smallest_ball),
                    of("ours", &|r| r.ours),
                ],
            });
        }
        let cells = |r: &super::content::TightnessRow| {
            let mut row = vec![
                percent(r.displacement_rel),
                r.level.to_string(),
                r.spheres.to_string(),
            ];
            let of = |ratio: &Ratio| format!("{:.3} / {:.3}", ratio.mean, ratio.max);
            row.extend([&r.paper, &r.smallest_ball, &r.ours].map(of));
            row
        };
        let rows: Vec<_> = rows.iter().map(cells).collect();
        let head = [
            "displacement",
            "level",
            "spheres",
            "paper, mean / largest",
            "smallest balls",
            "ours",
        ];
        self.table(&head, 0, &rows);
        self.close();
    }

    fn depth(&mut self, content: &Content) {
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
        let line = |name: &str, of: &dyn Fn(&super::content::DepthRow) -> f64| Line {
            name: name.to_string(),
            points: rows.iter().map(|r| (r.level as f64, of(r))).collect(),
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
        let cells = |r: &super::content::DepthRow| {
            vec![
                r.level.to_string(),
                number(r.ball_micros),
                number(r.time_rel),
                number(r.ball_visits),
                percent(r.missed_area_rel),
                percent(r.extra_area_rel),
                percent(r.penetration_error_rel),
                percent(r.false_rel),
            ]
        };
        let rows: Vec<_> = rows.iter().map(cells).collect();
        let head = [
            "level",
            "µs",
            "over everything",
            "visits",
            "missed area / touched",
            "extra area / touched",
            "penetration error / diagonal",
            "answers though nothing touches",
        ];
        self.table(&head, 0, &rows);
        self.close();
    }

    fn tolerance(&mut self, content: &Content) {
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
        let line = |name: &str, of: &dyn Fn(&super::content::ToleranceRow) -> f64| Line {
            name: name.to_string(),
            points: rows.iter().map(|r| (r.tolerance_rel, of(r))).collect(),
        };
        self.open();
        self.plot(&Plot {
            title: "Time of 16 balls and 16 rays".to_string(),
            x: Axis::log("tolerance / diagonal"),
            y: Axis::linear("µs"),
            lines: vec![line("time", &|r| r.micros)],
        });
        let cells = |r: &super::content::ToleranceRow| {
            vec![
                percent(r.tolerance_rel),
                number(r.active_modes),
                number(r.visits),
                number(r.micros),
            ]
        };
        let rows: Vec<_> = rows.iter().map(cells).collect();
        self.table(
            &["tolerance / diagonal", "modes left", "visits", "µs"],
            0,
            &rows,
        );
        self.close();
    }

    fn bytes(&mut self, content: &Content) {
        self.heading("Bytes");
        self.open();
        let rows: Vec<_> = content
            .sections
            .iter()
            .map(|s| {
                vec![
                    s.kind.clone(),
                    s.purpose.clone(),
                    grouped(s.bytes),
                    percent(s.share),
                ]
            })
            .collect();
        self.table(&["section", "what it holds", "bytes", "share"], 2, &rows);
        let rows: Vec<_> = content
            .unneeded
            .iter()
            .map(|u| vec![u.scene.clone(), u.without.clone(), grouped(u.bytes)])
            .collect();
        self.table(&["a scene that", "can do without", "bytes"], 2, &rows);
        self.close();
    }

    fn margin(&mut self, content: &Content) {
        let Some(margin) = &content.margin else {
            return;
        };
        self.heading("Floating-point margins");
        let mut text = format!(
            "{} nodes at q made to break their bounds, decided in exact arithmetic: {} vertices outside.",
            grouped(margin.cases),
            margin.violations
        );
        if let Some(least) = margin.least {
            text += &format!(
                " The closest was inside by {} times what a pose adds to radii for rounding (below 0 it would be outside).",
                number(least)
            );
        }
        if let Some(certainty) = margin.certainty_rel {
            text += &format!(" Rounding adds {} to the mean radius.", percent(certainty));
        }
        self.text(&text);
    }

    fn foot(&mut self, content: &Content) {
        let parts: Vec<String> = content
            .seconds
            .iter()
            .map(|s| format!("{} {:.1} s", s.part, s.seconds))
            .collect();
        self.soft(&format!("Made in: {}.", parts.join(", ")));
    }
}
