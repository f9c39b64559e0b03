//! The frames of the animation: times, rigid motions and q, within the tolerance.

use bdtree_runtime::{AnimationFrame, Asset};

use super::findings::{Findings, largest};
use super::numbers::mesh_size;

/// Compares two animations of as many frames and modes. An unknown time equals only an unknown
/// one.
pub(super) fn compare(a: &Asset<'_>, b: &Asset<'_>, findings: &mut Findings) {
    let frames: Vec<(AnimationFrame<'_>, AnimationFrame<'_>)> = (0..a.frame_count())
        .filter_map(|k| Some((a.frame(k)?, b.frame(k)?)))
        .collect();
    let mut quantity = |what: &str, size: f64, values: &dyn Fn(&AnimationFrame<'_>) -> Vec<f64>| {
        let pairs: Vec<(Vec<f64>, Vec<f64>)> =
            frames.iter().map(|(x, y)| (values(x), values(y))).collect();
        let scale = largest(pairs.iter().flat_map(|(x, y)| x.iter().chain(y)).copied());
        let scale = scale.max(size);
        let mut numbers = findings.numbers(what, scale);
        for (k, (x, y)) in pairs.iter().enumerate() {
            if x.len() != y.len() {
                findings.compare(&format!("{what}: known or not, frame {k}"), [x, y]);
            }
            for (i, (x, y)) in x.iter().zip(y).enumerate() {
                numbers.compare(*x, *y, || format!("frame {k} [{i}]"));
            }
        }
        numbers.finish(findings);
    };
    quantity("section FRMS: times", 0.0, &|frame| {
        frame.time_s().into_iter().collect()
    });
    quantity("section FRMS: rotations", 0.0, &|frame| {
        frame.transform().rotation.to_vec()
    });
    // Motions that are rounding only are as good as none.
    let size = mesh_size(a).max(mesh_size(b));
    quantity("section FRMS: translations", size, &|frame| {
        frame.transform().translation.to_vec()
    });
    for j in 0..a.mode_count() {
        quantity(&format!("section FRMQ: q of mode {j}"), 0.0, &|frame| {
            vec![f64::from(frame.q()[j])]
        });
    }
}
