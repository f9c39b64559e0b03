//! The animations of the corpus and of the fixtures: errors against modes, checked by a second
//! reading of the source. `--nocapture` prints the table of docs/reference/animation.md.

use std::path::Path;

use crate::pca_support::*;
use bdtree_build::basis::pca::{Pca, PcaOptions, pca_basis};
use bdtree_build::input::sequence::FrameSequence;
use bdtree_build::input::{RawMesh, read_mesh};
use bdtree_build::progress::Silent;
use bdtree_fixtures::{corpus, models};

/// Name of the folder, cache and rest mesh in it, or none for the OBJ frames.
const ANIMATIONS: [(&str, Option<(&str, &str)>); 6] = [
    ("elephant", Some(("elephant.mdd", "elephant_000.obj"))),
    ("elephant", None),
    ("dragon_rider", None),
    ("cow", None),
    (
        "curtain_wind",
        Some(("curtain_wind.pc2", "curtain_wind_000.obj")),
    ),
    (
        "curtain_large",
        Some(("curtain_large.pc2", "curtain_large_rest.obj")),
    ),
];

const MODES: [usize; 8] = [1, 2, 4, 8, 12, 16, 24, 32];

struct Source {
    name: String,
    mesh: RawMesh,
    sequence: FrameSequence,
    frames: Frames,
}

impl Source {
    fn cache(path: &Path, mesh: &Path) -> Self {
        let mesh = read_mesh(mesh).expect("a mesh");
        let sequence = FrameSequence::open(path, Some(&mesh), None, &Silent).expect("a sequence");
        Self {
            name: sequence.name.to_string(),
            mesh,
            frames: read_cache(path),
            sequence,
        }
    }

    fn folder(path: &Path) -> Self {
        let sequence = FrameSequence::open(path, None, None, &Silent).expect("a sequence");
        let frame = |t| {
            read_mesh(Path::new(&sequence.place(t).to_string()))
                .expect("a frame")
                .positions
        };
        Self {
            name: format!("{}/*.obj", sequence.name),
            mesh: sequence
                .first_mesh
                .as_ref()
                .expect("frames are meshes")
                .clone(),
            frames: (0..sequence.frame_count()).map(frame).collect(),
            sequence,
        }
    }

    fn pca(&self, options: &PcaOptions) -> Pca {
        pca_basis(
            &self.mesh,
            &self.sequence,
            options,
            &Silent,
            &mut Vec::new(),
        )
        .expect("a basis")
    }
}

/// Rms is optimal and falls, playback is off by what is said, `auto` reaches its bound.
fn check(source: &Source) {
    let (n, t) = (
        source.sequence.vertex_count(),
        source.sequence.frame_count(),
    );
    assert_eq!((source.frames.len(), source.frames[0].len()), (t, n));
    let rest = mean(&source.frames);
    let values = singular_values(&snapshots(&source.frames, &rest));
    let size = diagonal(&rest);
    let all = source.pca(&count(t));
    let (rank, floor) = (all.basis.mode_count(), all.error.rms_rel);
    assert!(floor < 1e-7, "{}: {floor:e}", source.name);
    println!(
        "{}: {n} vertices, {t} frames, all modes leave {floor:.1e}",
        source.name
    );
    let mut compared = 0;
    for align in [false, true] {
        let mut before = f64::INFINITY;
        let mut row = String::new();
        for modes in MODES.into_iter().filter(|&modes| modes < rank) {
            let found = source.pca(&PcaOptions {
                align,
                ..count(modes)
            });
            assert_eq!(found.basis.mode_count(), modes, "{}", source.name);
            let rms = found.error.rms_rel;
            row += &format!(" {:.1e}/{:.1e}", found.error.max_rel, rms);
            if align {
                let lower = rms < before || rms < 10.0 * floor;
                assert!(lower, "{}, {modes}: {rms} after {before}", source.name);
                before = rms;
                continue;
            }
            let optimal = optimal_rms(&values, modes, n * t) / size;
            if optimal > 300.0 * floor {
                // What f32 adds is below 1e-5 of this.
                let off = (rms - optimal).abs() / optimal;
                assert!(off < 1e-5, "{}, {modes}: {off}", source.name);
                assert!(
                    rms < before,
                    "{}, {modes}: {rms} after {before}",
                    source.name
                );
                before = rms;
                compared += 1;
            }
            if modes % 12 == 0 {
                assert_error_is_true(&found, &source.frames, &source.name);
            }
        }
        println!("    align {align}:{row}");
    }
    assert!(compared >= 4, "{}: {compared} compared", source.name);
    for (bound, align) in [(0.05, true), (1e-2, false), (1e-3, true)] {
        let options = PcaOptions {
            align,
            ..auto(bound)
        };
        let found = source.pca(&options);
        println!(
            "    {bound}, align {align}: {} modes",
            found.basis.mode_count()
        );
        let size = diagonal(&found.mesh.positions);
        let checked = error_of(&played_back(&found), &source.frames, size);
        assert!(checked.max_rel <= bound, "{}: {checked:?}", source.name);
    }
}

#[test]
fn corpus_animations_are_compressed_as_well_as_can_be() {
    for (name, cache) in ANIMATIONS {
        let relative = format!("animations/{name}");
        let Some(folder) = corpus::path("pca_corpus_animations", &relative) else {
            return;
        };
        check(&match cache {
            Some((cache, mesh)) => Source::cache(&folder.join(cache), &folder.join(mesh)),
            None => Source::folder(&folder),
        });
    }
}

/// Every frame of the cache, of which the folder takes every fourth.
#[test]
fn corpus_folder_and_cache_have_like_modes() {
    let Some(folder) = corpus::path("pca_corpus_folder_and_cache", "animations/curtain_wind")
    else {
        return;
    };
    let frames = Source::folder(&folder);
    assert_eq!(frames.frames.len(), 25);
    let cache = read_cache(&folder.join("curtain_wind.pc2"));
    let every_fourth: Frames = cache.into_iter().step_by(4).collect();
    let made = make(every_fourth, &frames.mesh.positions, Precision::Single);
    let (a, b) = (frames.pca(&count(8)), pca(&made, &count(8)));
    // The texts are rounded to about 1e-6 of values whose gaps are 1e-2 of the largest.
    for (a, b) in a.basis.fields.iter().zip(&b.basis.fields) {
        assert!((0..3).all(|k| (a[k] - b[k]).abs() < 1e-5), "{a:?} {b:?}");
    }
    let off = (a.error.rms_rel - b.error.rms_rel).abs();
    assert!(off < 1e-5 * b.error.rms_rel, "{off}");
}

#[test]
fn the_wave_has_three_components_in_every_format() {
    let mesh = models::path("wave/wave_00.obj");
    let folder = mesh.parent().expect("a folder");
    let mut found = vec![Source::folder(folder)];
    for name in ["wave.pc2", "wave.mdd"] {
        found.push(Source::cache(&models::path(name), &mesh));
    }
    for source in &found {
        let three = source.pca(&count(3));
        // Six digits of numbers up to 1.6.
        assert!(
            three.error.max_rel < 1e-6,
            "{}: {:?}",
            source.name,
            three.error
        );
        assert!(source.pca(&count(2)).error.max_rel > 1e-3);
        assert_error_is_true(&three, &source.frames, &source.name);
    }
}

/// 110 frames of 6184 vertices.
#[test]
fn the_swaying_curtain_is_compressed_as_well_as_can_be() {
    let mesh = models::path("curtain");
    check(&Source::cache(&models::path("curtain_sway.pc2"), &mesh));
}
