//! Where samples come from, and what a report cannot say of an asset, in words.

use bdtree_build::advise::samples::{Bones, Samples, Source};
use bdtree_runtime::Asset;

use bdtree_build::figures::numbers;

/// Which poses an asset is judged in.
pub(super) fn source(asset: &Asset<'_>, samples: &Samples) -> String {
    let count = samples.count;
    let clips = asset.skeleton().map_or(0, |skeleton| skeleton.clip_count());
    let bones = match samples.bones {
        None => {
            return match samples.source {
                Source::Ranges => format!("{count} mixtures of all modes within ± q_range"),
                Source::Rest => "the rest pose".to_string(),
                Source::Frames | Source::Clips => format!("{count} frames of the animation"),
            };
        }
        Some(Bones::Turns) => format!("{count} poses with joints turned by up to 20°"),
        Some(Bones::Clips) if clips == 1 => format!("{count} poses of the clip"),
        Some(Bones::Clips) if clips > count => {
            format!("{count} poses of as many of the {clips} clips")
        }
        Some(Bones::Clips) => format!("{count} poses of the {clips} clips"),
    };
    match samples.source {
        Source::Ranges => format!("{bones}, each with a mixture of all modes within ± q_range"),
        _ => bones,
    }
}

/// What a report cannot say of an asset, and why.
pub(super) fn missing(asset: &Asset<'_>, samples: &Samples) -> Vec<String> {
    let mut missing = Vec::new();
    if asset.has_skin() {
        missing.extend(of_skin(samples));
    } else if asset.mode_count() == 0 {
        missing.push(
            "The asset is rigid: it has no modes, so there is nothing to say of modes, tightness, \
             refitting and margins."
                .to_string(),
        );
        return missing;
    } else if samples.source == Source::Rest {
        missing.push(
            "No mode moves anything within its q_range, and there is no animation: nothing to say of modes, \
             tightness, refitting and margins."
                .to_string(),
        );
        return missing;
    }
    let is_zero = |mode: &usize| {
        let record = asset.modes().get(*mode);
        record.is_some_and(|mode| mode.field_norm_max.get() == 0.0)
    };
    let (zero, still): (Vec<usize>, Vec<usize>) = samples.still.iter().copied().partition(is_zero);
    missing.extend(of_still(&zero, &still));
    if samples.source == Source::Ranges {
        let none = match (asset.has_skin(), asset.frame_count()) {
            (true, _) => "No clip moves a mode",
            (false, 0) => "The asset has no animation",
            (false, _) => "The asset's animation moves nothing",
        };
        missing.push(format!(
            "{none}: samples are mixtures within ± q_range, which may be more or less than \
             what a scene does."
        ));
    }
    missing
}

/// Of modes whose fields are zero, and of others that move nothing within their ranges.
fn of_still(zero: &[usize], still: &[usize]) -> Vec<String> {
    let mut lines = Vec::new();
    if !zero.is_empty() {
        let (modes, are, them) = match zero.len() {
            1 => ("Mode", "is", "it"),
            _ => ("Modes", "are", "them"),
        };
        let which = numbers(zero);
        lines.push(format!(
            "{modes} {which} {are} zero everywhere: a bake without {them} moves in the same way."
        ));
    }
    if !still.is_empty() {
        let (modes, move_, their, they) = match still.len() {
            1 => ("Mode", "moves", "its", "it does"),
            _ => ("Modes", "move", "their", "they do"),
        };
        let which = numbers(still);
        lines.push(format!(
            "{modes} {which} {move_} nothing within {their} q_range: what {they} beyond it is not in this report."
        ));
    }
    lines
}

fn of_skin(samples: &Samples) -> Vec<String> {
    let mut missing = vec![
        "Tightness is given for bdtree's spheres only: the bounds it is otherwise compared with (the paper's, and \
         that of smallest balls) do not exist for meshes with bones."
            .to_string(),
    ];
    if samples.bones == Some(Bones::Turns) {
        missing.push(
            "The asset has no clips: its joints are turned by up to 20°, which may be more or less than what a \
             scene does."
                .to_string(),
        );
    }
    missing
}

#[cfg(test)]
mod tests {
    use super::of_still;

    #[test]
    fn zero_fields_are_told_from_small_ranges() {
        assert!(of_still(&[], &[]).is_empty());
        assert_eq!(
            of_still(&[0, 1, 2], &[4]),
            [
                "Modes 0 to 2 are zero everywhere: a bake without them moves in the same way.",
                "Mode 4 moves nothing within its q_range: what it does beyond it is not in this report.",
            ]
        );
        assert_eq!(
            of_still(&[3], &[]),
            ["Mode 3 is zero everywhere: a bake without it moves in the same way."]
        );
    }
}
