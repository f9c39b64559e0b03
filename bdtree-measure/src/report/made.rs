//! What a file was made of, and the command that bakes it as advised.

use bdtree_build::advise::Advice;
use bdtree_format::Metadata;
use bdtree_runtime::Asset;

use super::content::Made;

/// As the metadata say.
pub(super) fn made(asset: &Asset<'_>) -> Made {
    let Ok(metadata) = Metadata::from_bytes(asset.metadata()) else {
        return Made::default();
    };
    let known = |text: String| (!text.is_empty()).then_some(text);
    let scale = metadata.settings.get("scale");
    Made {
        scale_m: scale.and_then(|text| text.parse().ok()),
        source: known(metadata.source_name),
        builder: known(metadata.builder),
        basis: known(metadata.basis),
        settings: metadata.settings,
        is_as_advised: None,
        command: None,
    }
}

/// The options that follow `advice`, names and values in turn; `None` where the file is as advised.
pub(super) fn options(advice: &Advice) -> Option<Vec<String>> {
    let mut options = Vec::new();
    if !advice.takes_first {
        options.extend([
            "--max-error-rel".to_string(),
            advice.max_error_rel.to_string(),
        ]);
    } else if advice.chosen.modes.len() != advice.all.modes.len() {
        options.extend(["--modes".to_string(), advice.chosen.modes.len().to_string()]);
    }
    if advice.chosen.leaf_size != advice.all.leaf_size {
        options.extend([
            "--leaf-size".to_string(),
            advice.chosen.leaf_size.to_string(),
        ]);
    }
    (!options.is_empty()).then_some(options)
}

/// Whether a file was baked with these options already.
pub(super) fn has(made: &Made, options: &[String]) -> bool {
    options.chunks(2).all(|option| match option {
        [name, value] => made.settings.get(name.trim_start_matches('-')) == Some(value),
        _ => false,
    })
}

/// Stands where the path of the source is not known.
pub(super) const UNKNOWN_INPUT: &str = "INPUT";

/// The command that bakes anew with other options, from `input` if it is known, into `output`. Of vibration modes of a mesh alone, whose metadata have all options;
/// other files do not say where their input lies.
pub(super) fn command(
    made: &Made,
    options: &[String],
    input: Option<&str>,
    output: &str,
) -> Option<String> {
    let has_skin = made.settings.contains_key("skin-weights");
    if made.source.is_none() || made.basis.as_deref() != Some("elastic") || has_skin {
        return None;
    }
    let input = input.unwrap_or(UNKNOWN_INPUT);
    let mut parts = vec!["bdtree-build".to_string(), quoted(input)];
    // Sums of files are no options.
    let settings = made.settings.iter();
    for (name, value) in settings.filter(|(name, _)| !name.ends_with("-sha256")) {
        let option = format!("--{name}");
        if options.contains(&option) {
            continue;
        }
        match (name.as_str(), value.as_str()) {
            // Each of them is an option.
            ("fix", fixes) => {
                parts.extend(
                    fixes
                        .split(' ')
                        .flat_map(|fix| [option.clone(), quoted(fix)]),
                );
            }
            (_, "true") => parts.push(option),
            (_, value) => parts.extend([option, quoted(value)]),
        }
    }
    parts.extend(options.iter().cloned());
    parts.extend(["-o".to_string(), quoted(output)]);
    Some(parts.join(" "))
}

/// As a POSIX shell reads it back.
fn quoted(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+@%".contains(c);
    match !text.is_empty() && text.chars().all(is_plain) {
        true => text.to_string(),
        false => format!("'{}'", text.replace('\'', r"'\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::super::content::Made;
    use super::{command, has};

    #[test]
    fn commands_replace_what_is_advised() {
        let settings = [
            ("fix", "lowest:0.02 group:legs"),
            ("modes", "10"),
            ("nested", "true"),
            ("tets-sha256", "00"),
            ("young", "2e9"),
        ];
        let settings = settings.map(|(name, value)| (name.to_string(), value.to_string()));
        let mut made = Made {
            source: Some("a chair.obj".to_string()),
            basis: Some("elastic".to_string()),
            settings: settings.into(),
            ..Made::default()
        };
        let options = ["--modes", "6"].map(str::to_string);
        assert_eq!(
            command(&made, &options, Some("in/a chair.obj"), "out.bdt").as_deref(),
            Some(
                "bdtree-build 'in/a chair.obj' --fix lowest:0.02 --fix group:legs --nested --young 2e9 --modes 6 \
                 -o out.bdt"
            )
        );
        let command = |made: &Made| command(made, &options, None, "out.bdt");
        assert!(command(&made).is_some_and(|text| text.starts_with("bdtree-build INPUT --fix")));
        // Metadata do not say where arrays lie.
        let mut skinned = made.clone();
        let array = ("skin-weights".to_string(), "W.npy".to_string());
        skinned.settings.extend([array]);
        assert_eq!(command(&skinned), None);
        made.basis = Some("pca".to_string());
        assert_eq!(command(&made), None);
        assert!(!has(&made, &options));
        assert!(has(&made, &["--modes", "10"].map(str::to_string)));
    }
}
