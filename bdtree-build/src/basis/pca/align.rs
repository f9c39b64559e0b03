//! The rigid motion of each frame (`--align`): generalised Procrustes analysis, every vertex with
//! the same weight.

use super::About;
use super::motion::{Motion, nearest_motion};
use super::snapshots::{Snapshots, mean};
use crate::basis::RigidMotion;
use crate::error::BakeError;
use crate::progress::Progress;

/// Most rounds of fitting the frames to their mean.
const ROUNDS_MAX: usize = 10;
/// Change of the mean shape, relative to its size, at which the rounds end.
const CHANGE_MIN: f64 = 1e-9;

/// Takes out of `snapshots` the motion for which each frame is nearest to the rest shape, and
/// returns the motions. About the mean, the rest shape is the mean of the aligned frames: from
/// `positions` on, frames are fitted to it and it is formed anew until it stays the same.
pub(super) fn align(
    snapshots: &mut Snapshots<'_>,
    positions: &[[f64; 3]],
    about: About,
    progress: &dyn Progress,
) -> Result<Vec<RigidMotion>, BakeError> {
    let rounds = match about {
        About::Input => 1,
        About::Mean => ROUNDS_MAX,
    };
    progress.stage("align", Some(rounds as u64 + 1));
    let frame_centers = frame_centers(snapshots)?;
    let center = centroid(positions);
    let mut shape = positions.to_vec();
    let mut motions = vec![RigidMotion::IDENTITY; frame_centers.len()];
    progress.advance(1);
    for round in 0..rounds {
        // The first round fits to `positions` as they are.
        let (moments, change) = fit(snapshots, &frame_centers, center, &mut shape, round > 0)?;
        let mut near = RigidMotion::IDENTITY;
        for ((motion, moments), to) in motions.iter_mut().zip(moments).zip(&frame_centers) {
            *motion = nearest_motion(moments, center, *to, &near);
            near = *motion;
        }
        snapshots.motions = motions.iter().map(Motion::from).collect();
        progress.advance(1);
        if round > 0 && change < CHANGE_MIN {
            break;
        }
    }
    Ok(motions)
}

/// The mean position of the vertices of each frame.
fn frame_centers(snapshots: &Snapshots<'_>) -> Result<Vec<[f64; 3]>, BakeError> {
    let count = snapshots.sequence.vertex_count() as f64;
    let mut sums = vec![[0.0; 3]; snapshots.sequence.frame_count()];
    let mut values = Vec::new();
    for vertices in snapshots.chunks() {
        snapshots.read(&vertices, &mut values)?;
        for (sum, column) in sums.iter_mut().zip(values.chunks_exact(3 * vertices.len())) {
            for x in column.as_chunks::<3>().0 {
                for k in 0..3 {
                    sum[k] += x[k] / count;
                }
            }
        }
    }
    Ok(sums)
}

fn centroid(points: &[[f64; 3]]) -> [f64; 3] {
    let count = points.len() as f64;
    [0, 1, 2].map(|k| points.iter().map(|p| p[k] / count).sum())
}

/// Σ (y_i − ȳ)_a (x_i − x̄)_b of one frame x and the shape y.
type Moments = [[f64; 3]; 3];

/// The moments of each frame with the shape, which becomes the mean of the aligned frames first if
/// `renew`; and how far that moved it, relative to its size.
fn fit(
    snapshots: &Snapshots<'_>,
    frame_centers: &[[f64; 3]],
    center: [f64; 3],
    shape: &mut [[f64; 3]],
    renew: bool,
) -> Result<(Vec<Moments>, f64), BakeError> {
    let mut all = vec![[[0.0; 3]; 3]; frame_centers.len()];
    let (mut change, mut size) = (0.0, 0.0);
    let (mut values, mut aligned, mut old) = (Vec::new(), Vec::new(), Vec::new());
    for vertices in snapshots.chunks() {
        let shape = &mut shape[vertices.clone()];
        let rows = 3 * vertices.len();
        snapshots.read(&vertices, &mut values)?;
        if renew {
            aligned.clone_from(&values);
            snapshots.align(&mut aligned);
            old.clear();
            old.extend_from_slice(shape);
            mean(&aligned, rows, shape);
            for (new, old) in shape.iter().zip(&old) {
                change += (0..3).map(|k| (new[k] - old[k]).powi(2)).sum::<f64>();
                size += (0..3).map(|k| (new[k] - center[k]).powi(2)).sum::<f64>();
            }
        }
        let frames = values.chunks_exact(rows).zip(frame_centers);
        for (moments, (column, to)) in all.iter_mut().zip(frames) {
            for (x, y) in column.as_chunks::<3>().0.iter().zip(shape.iter()) {
                let x: [f64; 3] = std::array::from_fn(|b| x[b] - to[b]);
                for a in 0..3 {
                    for b in 0..3 {
                        moments[a][b] += (y[a] - center[a]) * x[b];
                    }
                }
            }
        }
    }
    let change = if change > 0.0 {
        (change / size).sqrt()
    } else {
        0.0
    };
    Ok((all, change))
}
