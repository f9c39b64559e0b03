//! Compressed animations, baked, verified, and queried beside brute force on their own frames.

use std::ops::ControlFlow;
use std::path::Path;

use bdtree_build::basis::RigidMotion;
use bdtree_build::basis::pca::{Modes, PcaOptions, pca_basis};
use bdtree_build::input::read_mesh;
use bdtree_build::input::sequence::FrameSequence;
use bdtree_build::progress::Silent;
use bdtree_runtime::{Asset, Transform};
use bdtree_tests::compare::{check_pairs, check_pose};
use bdtree_tests::{bake, corpus, fixtures};

/// Frames that are queried: the first, the last and some between.
const FRAMES_CHECKED: usize = 6;

fn check(frames: &Path, mesh: Option<&Path>, modes: usize) {
    let mesh = mesh.map(|path| read_mesh(path).expect("a mesh"));
    let sequence = FrameSequence::open(frames, mesh.as_ref(), None, &Silent).expect("a sequence");
    let name = sequence.name();
    let mesh = mesh.as_ref().or(sequence.first_mesh()).expect("a mesh");
    for align in [false, true] {
        let options = PcaOptions {
            modes: Modes::Count(modes),
            align,
            ..PcaOptions::default()
        };
        let pca = pca_basis(mesh, &sequence, &options, &Silent, &mut Vec::new()).expect("a basis");
        let bytes = bake::baked(&pca.mesh, &pca.basis);
        let asset = Asset::open(&bytes).expect("open");
        let sound = asset.verify(&mut |e| {
            println!("{name}: {e}");
            ControlFlow::Continue(())
        });
        assert!(sound, "{name}");
        let animation = pca.basis.animation.as_ref().expect("an animation");
        let modes = pca.basis.mode_count();
        let last = animation.frame_count - 1;
        for step in 0..FRAMES_CHECKED {
            let t = last * step / (FRAMES_CHECKED - 1);
            let q: Vec<f32> = animation.q[t * modes..(t + 1) * modes]
                .iter()
                .map(|&q| q as f32)
                .collect();
            let motion = animation.motions.get(t).copied();
            let motion = motion.unwrap_or(RigidMotion::IDENTITY);
            let place = Transform {
                rotation: motion.rotation,
                translation: motion.translation,
                scale: 1.0,
            };
            check_pose(&asset, &q, place, 1 + t as u64, 2);
        }
        check_pairs(&bytes, 6, 2, 0.3);
    }
}

#[test]
fn fixtures_answer_like_brute_force() {
    let mesh = fixtures::path("wave/wave_00.obj");
    check(mesh.parent().expect("a folder"), None, 2);
    check(&fixtures::path("wave.pc2"), Some(&mesh), 3);
    let curtain = fixtures::path("curtain");
    check(&fixtures::path("curtain_sway.pc2"), Some(&curtain), 12);
}

#[test]
fn corpus_answers_like_brute_force() {
    for (frames, mesh) in [
        ("elephant/elephant.mdd", Some("elephant/elephant_000.obj")),
        ("dragon_rider", None),
        ("cow", None),
        (
            "curtain_wind/curtain_wind.pc2",
            Some("curtain_wind/curtain_wind_000.obj"),
        ),
        (
            "curtain_large/curtain_large.pc2",
            Some("curtain_large/curtain_large_rest.obj"),
        ),
    ] {
        let test = "animation_queries_corpus";
        let path = |name| corpus::path(test, &format!("animations/{name}"));
        let Some(frames) = path(frames) else {
            return;
        };
        check(&frames, mesh.and_then(path).as_deref(), 8);
    }
}
