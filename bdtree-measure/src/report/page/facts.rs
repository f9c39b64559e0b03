//! What the file is, what to do with it, and what it is made of.

use super::super::content::{Advice, Content, SectionRow, Unneeded};
use super::super::made::UNKNOWN_INPUT;
use super::super::text::{escaped, grouped, number, percent, share};
use super::{Page, Picture, prose};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// Sides of the box below this, over its diagonal, are shown as 0.
const FLAT: f64 = 1e-9;

/// Sides of the box, with their unit.
fn size(sides: [f64; 3], diagonal: f64, scale_m: Option<f64>) -> String {
    // What rounding leaves of a flat mesh's third side is no length.
    let side = |x| match x < FLAT * diagonal {
        true => number(0.0),
        false => number(x),
    };
    let sides = sides.map(side).join(" × ");
    match scale_m {
        Some(1.0) => format!("{sides} m"),
        Some(scale) => format!("{sides} units of {} m", number(scale)),
        None => format!("{sides} units"),
    }
}

/// The name that the processor's makers gave the instructions of a kernel.
fn instructions(kernel: &str) -> String {
    match kernel {
        "Scalar" => "none".to_string(),
        name => name.to_uppercase(),
    }
}

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
            (
                match asset.skin {
                    Some(_) => "size with the bones at rest",
                    None => "size",
                },
                size(asset.size, asset.diagonal, content.made.scale_m),
            ),
        ];
        if let Some(skin) = &asset.skin {
            facts.extend([
                ("joints", skin.joints.to_string()),
                ("bones", skin.bones.to_string()),
                ("most bones of a vertex", skin.influences_max.to_string()),
                ("clips", skin.clips.to_string()),
            ]);
        }
        facts.extend(asset.frames.map(|n| ("frames", n.to_string())));
        let error = asset.basis_error_rel;
        facts.extend(error.map(|e| ("error of the basis against its source", percent(e))));
        let of = |(name, value): &(&str, String)| format!("<span>{name} <b>{value}</b></span>");
        let facts: String = facts.iter().map(of).collect();
        self.line(&format!("<div class=\"facts\">{facts}</div>"));
    }

    pub(super) fn pictures(&mut self, pictures: &[Picture]) {
        if pictures.is_empty() {
            return;
        }
        self.open();
        for Picture { caption, png } in pictures {
            let (caption, data) = (escaped(caption), STANDARD.encode(png));
            self.line(&format!(
                "<figure class=\"photo\"><figcaption>{caption}</figcaption>\
                 <img alt=\"{caption}\" src=\"data:image/png;base64,{data}\"></figure>"
            ));
        }
        self.close();
    }

    pub(super) fn verdict(&mut self, content: &Content) {
        if !content.verdict.is_empty() {
            let item = |text: &String| format!("<li>{}</li>", prose(text));
            let items: String = content.verdict.iter().map(item).collect();
            self.line(&format!("<ul class=\"verdict\">{items}</ul>"));
        }
        for missing in &content.missing {
            self.text(missing);
        }
    }

    /// Where the file comes from, and how it is baked as advised.
    pub(super) fn made(&mut self, content: &Content) {
        let made = &content.made;
        let settings = made.settings.iter();
        // Sums of files are in `bdtree info`.
        let settings = settings.filter(|(name, _)| !name.ends_with("-sha256"));
        let settings: Vec<String> = settings
            .map(|(name, value)| format!("{name} {value}"))
            .collect();
        let basis = match (&content.asset.skin, content.asset.modes) {
            (Some(_), 0) => Some("bones, no modes".to_string()),
            _ => made.basis.clone(),
        };
        let facts = [
            ("source", made.source.clone()),
            ("basis", basis),
            (
                "settings",
                (!settings.is_empty()).then(|| settings.join(", ")),
            ),
            ("builder", made.builder.clone()),
            ("measured", Some(content.date.clone())),
        ];
        let known = facts
            .iter()
            .filter_map(|(name, value)| Some((name, value.as_ref()?)));
        let items: String = known
            .map(|(name, value)| format!("<dt>{name}</dt><dd>{}</dd>", escaped(value)))
            .collect();
        self.line(&format!("<dl>{items}</dl>"));
        if made.is_as_advised == Some(true) {
            self.text("The file already has the advised settings.");
        }
        if let Some(command) = &made.command {
            self.text(match command.contains(&format!(" {UNKNOWN_INPUT} ")) {
                true => "This command bakes it as advised below; INPUT is the path of its source:",
                false => "This command bakes it as advised below:",
            });
            // Lines break between words only, not behind the hyphens of an option.
            let words = command.split(' ');
            let words = words.map(|word| format!("<span>{}</span>", escaped(word)));
            let words: Vec<String> = words.collect();
            self.line(&format!("<pre>{}</pre>", words.join(" ")));
        }
    }

    /// What was asked, and on what.
    pub(super) fn samples(&mut self, content: &Content) {
        let samples = &content.samples;
        self.heading("How it was measured");
        let moved = match samples.displacement_max_rel {
            0.0 => String::new(),
            moved => format!(
                ", which move vertices by up to {} of the diagonal; each part says how many of them it takes",
                percent(moved)
            ),
        };
        let simd = instructions(&content.machine.kernel);
        self.soft(&format!(
            "At {}{moved}. Lengths are mesh units. Times are of one thread of {} (SIMD: {simd}) and medians of {} \
             repetitions unless a part says otherwise.",
            samples.source, content.machine.processor, content.machine.repetitions,
        ));
    }

    pub(super) fn advice(&mut self, content: &Content) {
        if content.advice.is_empty() {
            return;
        }
        self.heading("Advice");
        let item = |a: &Advice| format!("<li>{}</li>", prose(&a.text));
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
                ("share", &|s| share(s.share)),
            ],
        );
        self.table::<Unneeded>(
            &content.unneeded,
            2,
            &[
                ("use", &|u| u.scene.clone()),
                ("never read", &|u| u.without.clone()),
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
        let left = match margin.violations {
            0 => "no vertex left its sphere".to_string(),
            1 => "1 vertex left its sphere".to_string(),
            n => format!("{} vertices left their spheres", grouped(n as u64)),
        };
        let mut text = format!(
            "{} adversarial tests, checked in exact arithmetic: {left}.",
            grouped(margin.cases)
        );
        if let Some(least) = margin.least {
            text += &format!(
                " The smallest margin was {} of the rounding allowance (negative would mean a violation).",
                percent(least)
            );
        }
        if let Some(slack) = margin.rounding_slack_rel {
            text += &format!(" The allowance is {} of the mean radius.", percent(slack));
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

#[cfg(test)]
mod tests {
    use super::{instructions, size};

    #[test]
    fn a_flat_mesh_has_a_side_of_0() {
        let sides = [1.6, 1.0, 5.551e-17];
        assert_eq!(size(sides, 1.89, Some(1.0)), "1.6 × 1 × 0 m");
        assert!(size(sides, 1e-16, None).contains("5.55e"));
    }

    #[test]
    fn kernels_have_the_names_of_their_instructions() {
        assert_eq!(instructions("Scalar"), "none");
        assert_eq!(instructions("Avx2"), "AVX2");
    }
}
