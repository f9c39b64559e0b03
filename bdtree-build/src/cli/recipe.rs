//! What the arguments ask for, as a recipe.

use std::path::PathBuf;

use bdtree_build::basis::dropped::Keep;
use bdtree_build::basis::elastic::ElasticOptions;
use bdtree_build::basis::pca::{self, About, PcaOptions};
use bdtree_build::basis::volume::VolumeOptions;
use bdtree_build::error::{BakeError, Part};
use bdtree_build::input::{BadFaces, SkinArrays};
use bdtree_build::mass::Body;
use bdtree_build::pipeline::BakeSettings;
use bdtree_build::recipe::{Elastic, Frames, Given, Morphs, Motion, Recipe, Source, Volume};

use super::Arguments;
use super::arguments::Modes;

/// Modes where neither the arguments nor the source name a number.
const MODES_DEFAULT: usize = 10;

/// The recipe of arguments that [`Arguments::check`] passed.
pub(super) fn of(arguments: &Arguments) -> Result<Recipe, BakeError> {
    let surface = arguments.input.clone();
    let source = if let Some((path, surface)) = arguments.frames() {
        frames(arguments, path, surface)
    } else if let Some(path) = arguments.tets.clone() {
        volume(arguments, path, surface)?
    } else {
        Source::Surface {
            path: surface.unwrap_or_default(),
            clip: arguments.clip.clone(),
            motion: motion(arguments),
        }
    };
    Ok(Recipe {
        source,
        settings: BakeSettings {
            leaf_size: arguments.leaf_size.map(usize::from),
            split: arguments.split,
            nested: arguments.nested,
            weights: arguments.weights.unwrap_or_default(),
            body: body(arguments),
            threads: threads(arguments),
        },
        bad_faces: match arguments.skip_bad_faces {
            true => BadFaces::Skip,
            false => BadFaces::Refuse,
        },
        skin: skin(arguments),
        stated: arguments.stated(),
    })
}

/// What the body weighs that the surface encloses.
fn body(arguments: &Arguments) -> Body {
    let default = Body::default();
    Body {
        density_kg_m3: arguments.density.unwrap_or(default.density_kg_m3),
        scale_m: arguments.scale.unwrap_or(default.scale_m),
        ..default
    }
}

/// The arrays of a skin; clap has seen to it that all are given or none.
fn skin(arguments: &Arguments) -> Option<SkinArrays> {
    Some(SkinArrays {
        weights: arguments.skin_weights.clone()?,
        joints: arguments.skin_joints.clone()?,
        inverse_bind: arguments.inverse_bind.clone()?,
    })
}

/// As many as asked for, or as the machine runs at once.
fn threads(arguments: &Arguments) -> usize {
    let all = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    arguments.threads.map_or_else(all, usize::from)
}

/// What moves a surface.
fn motion(arguments: &Arguments) -> Motion {
    let keep = match arguments.modes() {
        Modes::Unsaid => Keep::All,
        Modes::Count(count) => Keep::First(count),
        Modes::Auto(max_error_rel) => Keep::Auto { max_error_rel },
    };
    if let Some(path) = arguments.basis.clone() {
        return Motion::Given(Given {
            path,
            layout: arguments.basis_layout,
            frequencies: arguments.frequencies.clone(),
            keep,
            range_rel: arguments.range_rel,
        });
    }
    let morphs = Morphs {
        keep,
        memory_limit_bytes: memory_limit_bytes(arguments),
    };
    match vibration_modes(arguments) {
        Some(mode_count) if arguments.modes() == Modes::Unsaid => {
            Motion::MorphsElseSkin(morphs, elastic(arguments, mode_count))
        }
        Some(mode_count) => Motion::MorphsElseElastic(morphs, elastic(arguments, mode_count)),
        // Only morph targets know how far fewer of them are from all.
        None => Motion::Morphs(morphs),
    }
}

fn elastic(arguments: &Arguments, mode_count: usize) -> Elastic {
    let default = ElasticOptions::default();
    Elastic {
        options: ElasticOptions {
            mode_count,
            resolution: arguments.resolution,
            young_pa: arguments.young.unwrap_or(default.young_pa),
            poisson: arguments.poisson.unwrap_or(default.poisson),
            density_kg_m3: arguments.density.unwrap_or(default.density_kg_m3),
            scale_m: arguments.scale.unwrap_or(default.scale_m),
            thickness: arguments.thickness,
            fixes: arguments.fix.clone(),
            memory_limit_bytes: memory_limit_bytes(arguments),
            threads: threads(arguments),
            ..default
        },
        range_rel: arguments.range_rel,
    }
}

fn volume(
    arguments: &Arguments,
    path: PathBuf,
    surface: Option<PathBuf>,
) -> Result<Source, BakeError> {
    let default = VolumeOptions::default();
    let Some(mode_count) = vibration_modes(arguments) else {
        let option = Part::Option("--max-error-rel", None);
        let message = "the modes of a volume have no source to measure an error against: give their number (--modes K)";
        return Err(BakeError::one("basis", option, message));
    };
    Ok(Source::Volume(Volume {
        path,
        surface,
        options: VolumeOptions {
            mode_count,
            young_pa: arguments.young,
            poisson: arguments.poisson,
            density_kg_m3: arguments.density,
            scale_m: arguments.scale.unwrap_or(default.scale_m),
            mass: arguments.mass.unwrap_or(default.mass),
            fixes: arguments.fix.clone(),
            memory_limit_bytes: memory_limit_bytes(arguments),
            threads: threads(arguments),
            ..default
        },
        range_rel: arguments.range_rel,
    }))
}

fn frames(arguments: &Arguments, path: PathBuf, surface: Option<PathBuf>) -> Source {
    Source::Frames(Frames {
        path,
        surface,
        fps: arguments.fps,
        options: PcaOptions {
            modes: match arguments.modes() {
                Modes::Unsaid => pca::Modes::Count(MODES_DEFAULT),
                Modes::Count(count) => pca::Modes::Count(count),
                Modes::Auto(max_error_rel) => pca::Modes::Auto { max_error_rel },
            },
            about: arguments.about.unwrap_or(About::Mean),
            align: arguments.align,
            memory_limit_bytes: memory_limit_bytes(arguments),
            ..PcaOptions::default()
        },
    })
}

/// The number of vibration modes; `None` where an error is to choose it, which they cannot.
fn vibration_modes(arguments: &Arguments) -> Option<usize> {
    match arguments.modes() {
        Modes::Unsaid => Some(MODES_DEFAULT),
        Modes::Count(count) => Some(count),
        Modes::Auto(_) => None,
    }
}

fn memory_limit_bytes(arguments: &Arguments) -> u64 {
    arguments.memory_limit.saturating_mul(1 << 20)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use clap::Parser;

    use super::*;

    fn recipe(arguments: &[&str]) -> Recipe {
        let all = [&["bdtree-build"], arguments].concat();
        let arguments = Arguments::try_parse_from(all).expect("arguments");
        arguments.check().expect("no usage error");
        of(&arguments).expect("a recipe")
    }

    fn motion(arguments: &[&str]) -> Motion {
        match recipe(arguments).source {
            Source::Surface { motion, .. } => motion,
            other => panic!("{arguments:?}: {other:?}"),
        }
    }

    #[test]
    fn arguments_choose_the_source() {
        let Motion::MorphsElseSkin(morphs, elastic) = motion(&["a.glb"]) else {
            panic!("a file without options has what it holds");
        };
        assert_eq!((morphs.keep, elastic.options.mode_count), (Keep::All, 10));
        let Motion::MorphsElseElastic(morphs, elastic) = motion(&["a.obj", "--modes", "3"]) else {
            panic!("a number of modes serves both");
        };
        assert_eq!(
            (morphs.keep, elastic.options.mode_count),
            (Keep::First(3), 3)
        );
        // Vibration modes cannot answer to an error.
        assert!(matches!(
            motion(&["a.obj", "--max-error-rel", "0.1"]),
            Motion::Morphs(_)
        ));
        assert!(matches!(
            motion(&["a.obj", "--basis", "u.npy"]),
            Motion::Given(_)
        ));
        let source = recipe(&["--tets", "a.veg", "b.obj"]).source;
        assert_eq!(source.main_file(), Path::new("b.obj"));
        assert!(matches!(source, Source::Volume(_)));
        let source = recipe(&["--animation", "frames"]).source;
        assert_eq!(source.main_file(), Path::new("frames"));
        assert!(matches!(source, Source::Frames(_)));
    }

    #[test]
    fn every_file_that_is_read_is_named() {
        let files = |arguments: &[&str]| -> Vec<String> {
            let source = recipe(arguments).source;
            let files = source.files().into_iter();
            files.map(|path| path.display().to_string()).collect()
        };
        let given = ["a.obj", "--basis", "u.npy", "--frequencies", "f.txt"];
        assert_eq!(files(&given), ["a.obj", "u.npy", "f.txt"]);
        assert_eq!(files(&["a.obj", "--fix", "x:@l"]), ["a.obj", "l"]);
        let volume = ["a.obj", "--tets", "b.veg", "--fix", "x:@l"];
        assert_eq!(files(&volume), ["a.obj", "b.veg", "l"]);
        assert_eq!(files(&["--animation", "w", "a.obj"]), ["a.obj", "w"]);
    }
}
