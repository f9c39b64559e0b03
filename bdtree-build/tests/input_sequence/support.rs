//! The fixtures' wave, and how sequences are opened and read.

use std::path::{Path, PathBuf};

use bdtree_build::input::sequence::FrameSequence;
use bdtree_build::input::{RawMesh, read_mesh};
use bdtree_build::progress::Silent;
use bdtree_fixtures::models;

pub(crate) const FRAMES: usize = 6;
pub(crate) const VERTICES: usize = 54;

pub(crate) fn fixture_folder(name: &str) -> PathBuf {
    let first = models::path(&format!("{name}/wave_00.obj"));
    first.parent().expect("a folder").to_path_buf()
}

pub(crate) fn wave_mesh() -> RawMesh {
    read_mesh(&models::path("wave/wave_00.obj")).expect("a valid fixture")
}

pub(crate) fn open(path: &Path, input: Option<&RawMesh>) -> FrameSequence {
    FrameSequence::open(path, input, None, &Silent).expect("a valid sequence")
}

/// What opening says, without the folder.
pub(crate) fn refusal(path: &Path, input: Option<&RawMesh>) -> String {
    let error = FrameSequence::open(path, input, None, &Silent).expect_err("should be refused");
    let folder = path.parent().expect("a folder").display().to_string();
    error.to_string().replace(&format!("{folder}/"), "")
}

/// All numbers, read `step` vertices at a time, frame after frame.
pub(crate) fn all(sequence: &FrameSequence, step: usize) -> Vec<[f64; 3]> {
    let (n, frames) = (sequence.vertex_count(), sequence.frame_count());
    let mut result = vec![[f64::NAN; 3]; n * frames];
    for first in (0..n).step_by(step) {
        let count = step.min(n - first);
        let mut values = vec![f64::NAN; 3 * count * frames];
        sequence
            .read(first..first + count, &mut values)
            .expect("readable");
        for t in 0..frames {
            for i in 0..count {
                let at = 3 * (t * count + i);
                result[t * n + first + i] = [values[at], values[at + 1], values[at + 2]];
            }
        }
    }
    result
}

pub(crate) fn as_single(points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let single = |x: &f64| f64::from(*x as f32);
    points
        .iter()
        .map(|p| [0, 1, 2].map(|k| single(&p[k])))
        .collect()
}

/// The wave from its OBJ texts.
pub(crate) fn expected() -> Vec<[f64; 3]> {
    let frame = |t| read_mesh(&models::path(&format!("wave/wave_0{t}.obj"))).expect("valid");
    (0..FRAMES).flat_map(|t| frame(t).positions).collect()
}
