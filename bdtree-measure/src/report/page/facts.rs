//! What the file is, what to do with it, and what it is made of.

use super::super::content::{Advice, Content, SectionRow, Unneeded};
use super::super::text::{escaped, grouped, number, percent};
use super::Page;

impl Page {
    pub(super) fn head(&mut self, content: &Content) {
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

    pub(super) fn advice(&mut self, content: &Content) {
        if content.advice.is_empty() {
            return;
        }
        self.heading("Advice");
        let item = |a: &Advice| format!("<li>{}</li>", escaped(&a.text));
        let items: String = content.advice.iter().map(item).collect();
        self.line(&format!("<ul class=\"advice\">{items}</ul>"));
    }

    pub(super) fn bytes(&mut self, content: &Content) {
        self.heading("Bytes");
        self.open();
        self.table::<SectionRow>(
            &content.sections,
            2,
            &[
                ("section", &|s| s.kind.clone()),
                ("what it holds", &|s| s.purpose.clone()),
                ("bytes", &|s| grouped(s.bytes)),
                ("share", &|s| percent(s.share)),
            ],
        );
        self.table::<Unneeded>(
            &content.unneeded,
            2,
            &[
                ("a scene that", &|u| u.scene.clone()),
                ("can do without", &|u| u.without.clone()),
                ("bytes", &|u| grouped(u.bytes)),
            ],
        );
        self.close();
    }

    pub(super) fn margin(&mut self, content: &Content) {
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
        if let Some(slack) = margin.rounding_slack_rel {
            text += &format!(" Rounding adds {} to the mean radius.", percent(slack));
        }
        self.text(&text);
    }

    pub(super) fn foot(&mut self, content: &Content) {
        let parts: Vec<String> = content
            .seconds
            .iter()
            .map(|s| format!("{} {:.1} s", s.part, s.seconds))
            .collect();
        self.soft(&format!("Made in: {}.", parts.join(", ")));
    }
}
