//! Sequences made in tests, and slow twins: the dense snapshot matrix, playback through the file.

#![allow(dead_code)] // each test program uses a part

use std::path::Path;

use bdtree_build::basis::pca::{Modes, Pca, PcaOptions, pca_basis};
use bdtree_build::basis::{BasisError, RigidMotion};
use bdtree_build::error::BakeError;
use bdtree_build::input::RawMesh;
use bdtree_build::input::sequence::FrameSequence;
use bdtree_build::pipeline::{BakeSettings, Provenance, bake_fields};
use bdtree_build::progress::Silent;
use bdtree_fixtures::models::fields::npy_with;
use bdtree_runtime::{Model, Transform, VertexId};
use faer::Mat;

pub(crate) type V3 = [f64; 3];
/// Frames of positions.
pub(crate) type Frames = Vec<Vec<V3>>;

/// Frames in a file of their own, with the mesh they belong to.
pub(crate) struct Made {
    pub(crate) frames: Frames,
    pub(crate) mesh: RawMesh,
    pub(crate) sequence: FrameSequence,
    _folder: tempfile::TempDir,
}

/// How the frames are written.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Precision {
    Single,
    Double,
}

/// A strip of triangles over the vertices; positions of `rest`.
pub(crate) fn strip(rest: &[V3]) -> RawMesh {
    let count = rest.len() as u32;
    let triangles = match count {
        1 => vec![[0, 0, 0]],
        2 => vec![[0, 1, 1]],
        _ => (2..count).map(|i| [i - 2, i - 1, i]).collect(),
    };
    RawMesh {
        name: "strip.obj".into(),
        positions: rest.to_vec(),
        triangles,
        ..RawMesh::default()
    }
}

/// The frames as a sequence about the mesh whose positions are `rest`; as the file has them.
pub(crate) fn make(mut frames: Frames, rest: &[V3], precision: Precision) -> Made {
    if precision == Precision::Single {
        for x in frames.iter_mut().flatten().flatten() {
            *x = f64::from(*x as f32);
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("frames.npy");
    let shape = format!("{},{},3", frames.len(), rest.len());
    let numbers = || frames.iter().flatten().flatten();
    let bytes = match precision {
        Precision::Double => npy_with(
            "<f8",
            false,
            &shape,
            numbers().flat_map(|x| x.to_le_bytes()),
        ),
        Precision::Single => npy_with(
            "<f4",
            false,
            &shape,
            numbers().flat_map(|x| (*x as f32).to_le_bytes()),
        ),
    };
    std::fs::write(&path, bytes).expect("writable");
    let mesh = strip(rest);
    let sequence = FrameSequence::open(&path, Some(&mesh), None, &Silent).expect("valid");
    Made {
        frames,
        mesh,
        sequence,
        _folder: folder,
    }
}

/// A cloth of `n` vertices in `t` frames whose motion has a few strong and many weak components,
/// about 2 mesh units large.
pub(crate) fn cloth(n: usize, t: usize) -> Frames {
    let vertex = |i: usize| (i as f64 * 0.618_034).fract() * 2.0;
    (0..t)
        .map(|t| {
            let time = t as f64 * 0.37;
            (0..n)
                .map(|i| {
                    let (x, y) = (vertex(i), 2.0 * i as f64 / n as f64);
                    let a = (2.0 * x + time).sin();
                    let b = (3.0 * y - 1.7 * time).cos();
                    [
                        x + 0.1 * a * b + 0.2 * (0.2 * time).cos(),
                        y + 0.05 * (a * a * b + x * time.sin()),
                        0.3 * (a + 0.5 * b * b * a).tanh(),
                    ]
                })
                .collect()
        })
        .collect()
}

pub(crate) fn count(modes: usize) -> PcaOptions {
    PcaOptions {
        modes: Modes::Count(modes),
        ..PcaOptions::default()
    }
}

pub(crate) fn auto(max_error_rel: f64) -> PcaOptions {
    PcaOptions {
        modes: Modes::Auto { max_error_rel },
        ..PcaOptions::default()
    }
}

/// The basis and its warnings.
pub(crate) fn pca_with_warnings(made: &Made, options: &PcaOptions) -> (Pca, Vec<String>) {
    let mut warnings = Vec::new();
    let pca = pca_basis(&made.mesh, &made.sequence, options, &Silent, &mut warnings);
    (pca.expect("a basis"), warnings)
}

/// The basis, which should come without a warning.
pub(crate) fn pca(made: &Made, options: &PcaOptions) -> Pca {
    let (pca, warnings) = pca_with_warnings(made, options);
    assert!(warnings.is_empty(), "{warnings:?}");
    pca
}

pub(crate) fn refused(made: &Made, options: &PcaOptions) -> BakeError {
    pca_basis(
        &made.mesh,
        &made.sequence,
        options,
        &Silent,
        &mut Vec::new(),
    )
    .expect_err("should be refused")
}

/// The mean of the frames.
pub(crate) fn mean(frames: &Frames) -> Vec<V3> {
    let count = frames.len() as f64;
    (0..frames[0].len())
        .map(|i| [0, 1, 2].map(|k| frames.iter().map(|f| f[i][k]).sum::<f64>() / count))
        .collect()
}

/// Frames minus `rest`, one per column.
pub(crate) fn snapshots(frames: &Frames, rest: &[V3]) -> Mat<f64> {
    Mat::from_fn(3 * rest.len(), frames.len(), |i, t| {
        frames[t][i / 3][i % 3] - rest[i / 3][i % 3]
    })
}

/// Singular values of a dense matrix, descending.
pub(crate) fn singular_values(a: &Mat<f64>) -> Vec<f64> {
    let svd = a.thin_svd().expect("converges");
    svd.S().column_vector().iter().copied().collect()
}

/// √(Σ_{j ≥ modes} σ_j² / count).
pub(crate) fn optimal_rms(values: &[f64], modes: usize, count: usize) -> f64 {
    let tail: f64 = values[modes.min(values.len())..]
        .iter()
        .rev()
        .map(|s| s * s)
        .sum();
    (tail / count as f64).sqrt()
}

/// Diagonal of the box around points.
pub(crate) fn diagonal(points: &[V3]) -> f64 {
    let side = |k: usize| {
        let of = |p: &V3| p[k];
        let high = points.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
        high - points.iter().map(of).fold(f64::INFINITY, f64::min)
    };
    (0..3).map(|k| side(k).powi(2)).sum::<f64>().sqrt()
}

/// What the baked file plays back, by the runtime that readers use.
pub(crate) fn played_back(pca: &Pca) -> Frames {
    let baked = bake_fields(
        &pca.mesh,
        &pca.basis,
        &BakeSettings::default(),
        &Provenance::default(),
        &Silent,
    );
    let model = Model::from_bytes(&baked.expect("bakes").bytes).expect("opens");
    let asset = model.asset();
    let animation = pca.basis.animation.as_ref().expect("an animation");
    let modes = pca.basis.mode_count();
    let mut memory = vec![0.0; asset.pose_len()];
    (0..animation.frame_count)
        .map(|t| {
            let q: Vec<f32> = animation.q[t * modes..(t + 1) * modes]
                .iter()
                .map(|&q| q as f32)
                .collect();
            let RigidMotion {
                rotation,
                translation,
            } = animation
                .motions
                .get(t)
                .copied()
                .unwrap_or(RigidMotion::IDENTITY);
            let place = Transform {
                rotation,
                translation,
                scale: 1.0,
            };
            let pose = asset
                .pose(&q, place, &mut memory)
                .expect("within the limits");
            (0..pca.mesh.positions.len() as u32)
                .map(|i| pose.deformed(VertexId(i)).expect("a vertex"))
                .collect()
        })
        .collect()
}

/// The error of what is played back against the source, relative to `size`.
pub(crate) fn error_of(played: &Frames, source: &Frames, size: f64) -> BasisError {
    assert_eq!(played.len(), source.len());
    let mut worst = (0.0, 0, 0);
    let (mut sum, mut count) = (0.0, 0);
    for (t, (a, b)) in played.iter().zip(source).enumerate() {
        assert_eq!(a.len(), b.len());
        for (i, (a, b)) in a.iter().zip(b).enumerate() {
            let square: f64 = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum();
            sum += square;
            count += 1;
            if square > worst.0 {
                worst = (square, t, i);
            }
        }
    }
    BasisError {
        max_rel: f64::sqrt(worst.0) / size,
        rms_rel: f64::sqrt(sum / f64::from(count)) / size,
        frame: Some(worst.1),
        vertex: worst.2,
    }
}

/// Asserts that the stated error is what playback leaves.
pub(crate) fn assert_error_is_true(pca: &Pca, source: &Frames, what: &str) {
    let size = match diagonal(&pca.mesh.positions) {
        0.0 => 1.0,
        size => size,
    };
    let played = played_back(pca);
    let found = error_of(&played, source, size);
    let stated = pca.error;
    // f64 rounding of playback and sums; coordinates are a few diagonals large.
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * b + 1e-14;
    assert!(
        near(stated.max_rel, found.max_rel),
        "{what}: {stated:?} {found:?}"
    );
    assert!(
        near(stated.rms_rel, found.rms_rel),
        "{what}: {stated:?} {found:?}"
    );
    // Where it says; other places may be off by as much, but for rounding.
    let (t, i) = (stated.frame.expect("a frame"), stated.vertex);
    let square: f64 = (0..3)
        .map(|k| (played[t][i][k] - source[t][i][k]).powi(2))
        .sum();
    assert!(
        near(square.sqrt() / size, found.max_rel),
        "{what}: {stated:?} {found:?}"
    );
}

/// Frames of a PC2 (`little`) or MDD file, read in the plainest way.
pub(crate) fn read_cache(path: &Path) -> Frames {
    let bytes = std::fs::read(path).expect("readable");
    let little = path.extension().is_some_and(|e| e == "pc2");
    let word = |at: usize| -> [u8; 4] { bytes[at..at + 4].try_into().expect("4 bytes") };
    let (points, frames, offset) = if little {
        let at = |i| i32::from_le_bytes(word(i)) as usize;
        (at(16), at(28), 32)
    } else {
        let at = |i| i32::from_be_bytes(word(i)) as usize;
        (at(4), at(0), 8 + 4 * at(0))
    };
    let number = |i: usize| {
        let word = word(offset + 4 * i);
        f64::from(if little {
            f32::from_le_bytes(word)
        } else {
            f32::from_be_bytes(word)
        })
    };
    (0..frames)
        .map(|t| {
            (0..points)
                .map(|i| [0, 1, 2].map(|k| number(3 * (t * points + i) + k)))
                .collect()
        })
        .collect()
}
