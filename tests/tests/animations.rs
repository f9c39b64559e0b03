//! Animations of the corpus and of `fixtures/`: baked, verified, and asked beside brute force on
//! their frames; what plays is the source, within the error that the bake states.

use std::ops::ControlFlow;
use std::path::Path;

use bdtree_build::basis::pca::{About, Modes, PcaOptions, pca_basis};
use bdtree_build::input::read_mesh;
use bdtree_build::input::sequence::FrameSequence;
use bdtree_build::progress::Silent;
use bdtree_fixtures::compare::{check_pairs, check_pose};
use bdtree_fixtures::{bake, corpus, models, poses};
use bdtree_runtime::{Asset, VertexId};

/// Largest error of a vertex over the diagonal of the rest positions.
const ERROR: f64 = 0.02;

/// Bakes the frames at `path` as moves of `mesh` (of the first frame without) and asks.
fn check(name: &str, mesh: Option<&Path>, path: &Path, align: bool, about: About) {
    let input = mesh.map(|mesh| read_mesh(mesh).expect("mesh"));
    let sequence = FrameSequence::open(path, input.as_ref(), None, &Silent)
        .unwrap_or_else(|e| panic!("{name}: {e}"));
    let mesh = input
        .or_else(|| sequence.first_mesh.clone())
        .expect("a mesh");
    let options = PcaOptions {
        modes: Modes::Auto {
            max_error_rel: ERROR,
        },
        about,
        align,
        ..PcaOptions::default()
    };
    let pca = pca_basis(&mesh, &sequence, &options, &Silent, &mut Vec::new())
        .unwrap_or_else(|e| panic!("{name}: {e}"));
    let model = bake::baked(&pca.mesh, &pca.basis);
    let asset = model.asset();
    let is_sound = asset.verify(&mut |e| {
        println!("{name}: {e}");
        ControlFlow::Continue(())
    });
    assert!(is_sound, "{name}");
    let count = sequence.frame_count();
    assert_eq!(asset.frame_count(), count, "{name}");

    let worst = worst_error(asset, &sequence) / (poses::diagonal(asset) * asset.unit());
    assert!(worst <= ERROR, "{name}: {worst}");
    // The stored diagonal is rounded to f32.
    let stated = pca.error.max_rel;
    assert!(
        (worst - stated).abs() <= 1e-6 * stated + 1e-12,
        "{name}: {worst} {stated}"
    );
    let mut rng = poses::rng(3);
    for t in [0, count / 3, 2 * count / 3, count - 1] {
        let frame = asset.frame(t).expect("frame");
        check_pose([*asset], frame.q(), frame.transform(), 1, 3);
        let placed = poses::random_transform(5.0, &mut rng);
        check_pose([*asset], frame.q(), placed, 2, 3);
    }
    check_pairs(asset, 6, 2, 0.3);
}

/// The farthest that a vertex is from its source in any frame (mesh units).
fn worst_error(asset: &Asset<'_>, sequence: &FrameSequence) -> f64 {
    let (n, count) = (sequence.vertex_count(), sequence.frame_count());
    let mut source = vec![0.0; 3 * n * count];
    sequence.read(0..n, &mut source).expect("frames");
    let mut worst = 0.0f64;
    let mut memory = vec![0.0; asset.pose_len()];
    for t in 0..count {
        let frame = asset.frame(t).expect("frame");
        let pose = asset.pose(frame.q(), frame.transform(), &mut memory);
        let pose = pose.expect("pose");
        for i in 0..n {
            let p = pose.deformed(VertexId(i as u32)).expect("vertex");
            let square: f64 = (0..3)
                .map(|k| (p[k] - source[3 * (t * n + i) + k]).powi(2))
                .sum();
            worst = worst.max(square.sqrt());
        }
    }
    worst
}

#[test]
fn fixtures_play() {
    let folder = models::folder();
    let rest = models::path("wave/wave_00.obj");
    for (file, align, about) in [
        ("wave", false, About::Mean),
        ("wave.pc2", true, About::Mean),
        ("wave.mdd", false, About::Input),
        ("wave.npy", true, About::Input),
    ] {
        let mesh = (file != "wave").then_some(rest.as_path());
        check(file, mesh, &folder.join(file), align, about);
    }
    let curtain = models::path("curtain");
    let sway = models::path("curtain_sway.pc2");
    check("curtain_sway", Some(&curtain), &sway, false, About::Mean);
}

#[test]
fn corpus_animations_play() {
    const NAME: &str = "corpus_animations_play";
    for (mesh, frames) in [
        (None, "elephant"),
        (Some("elephant/elephant_000.obj"), "elephant/elephant.mdd"),
        (None, "dragon_rider"),
        (None, "cow"),
        (None, "curtain_wind"),
        (
            Some("curtain_wind/curtain_wind_000.obj"),
            "curtain_wind/curtain_wind.pc2",
        ),
        (
            Some("curtain_large/curtain_large_rest.obj"),
            "curtain_large/curtain_large.pc2",
        ),
    ] {
        let place = |file: &str| corpus::path(NAME, &format!("animations/{file}"));
        let Some(path) = place(frames) else {
            return;
        };
        let mesh = mesh.and_then(place);
        check(frames, mesh.as_deref(), &path, false, About::Mean);
        check(frames, mesh.as_deref(), &path, true, About::Mean);
    }
}
