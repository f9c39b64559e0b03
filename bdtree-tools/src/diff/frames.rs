//! The frames of the animation: times, rigid motions and q, within the tolerance.

use bdtree_runtime::{AnimationFrame, Asset};

use super::findings::{Findings, largest};
use super::numbers::{AXES, mesh_size};
use super::words::known;
use crate::output::digits;

/// Compares two animations of as many frames and modes. An unknown time equals only an unknown
/// one.
pub(super) fn compare(a: &Asset<'_>, b: &Asset<'_>, findings: &mut Findings) {
    let frames: Vec<(AnimationFrame<'_>, AnimationFrame<'_>)> = (0..a.frame_count())
        .filter_map(|k| Some((a.frame(k)?, b.frame(k)?)))
        .collect();
    type Values<'v> = &'v dyn Fn(&AnimationFrame<'_>) -> Vec<f64>;
    let mut quantity = |what: &str, axes: &[&str], size: f64, values: Values<'_>| {
        let pairs: Vec<(Vec<f64>, Vec<f64>)> =
            frames.iter().map(|(x, y)| (values(x), values(y))).collect();
        let scale = largest(pairs.iter().flat_map(|(x, y)| x.iter().chain(y)).copied());
        let scale = scale.max(size);
        let mut numbers = findings.numbers(what, scale);
        for (k, (x, y)) in pairs.iter().enumerate() {
            if x.len() != y.len() {
                let told = [x, y].map(|own| known(own.first().map(|x| digits(*x))));
                findings.compare(&format!("{what}: known or not, frame {k}"), told);
            }
            for (i, (x, y)) in x.iter().zip(y).enumerate() {
                numbers.compare(*x, *y, || match axes.get(i) {
                    Some(axis) => format!("frame {k} {axis}"),
                    None => format!("frame {k}"),
                });
            }
        }
        numbers.finish(findings);
    };
    quantity("section FRMS: times", &[], 0.0, &|frame| {
        frame.time_s().into_iter().collect()
    });
    quantity(
        "section FRMS: rotations",
        &["x", "y", "z", "w"],
        0.0,
        &|frame| frame.transform().rotation.to_vec(),
    );
    // Motions that are rounding only are as good as none.
    let size = mesh_size(a).max(mesh_size(b));
    quantity("section FRMS: translations", &AXES, size, &|frame| {
        frame.transform().translation.to_vec()
    });
    for j in 0..a.mode_count() {
        quantity(
            &format!("section FRMQ: q of mode {j}"),
            &[],
            0.0,
            &|frame| vec![f64::from(frame.q()[j])],
        );
    }
}
