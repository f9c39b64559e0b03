//! Radii over the smallest possible, per level, in the poses of samples: of fields for three bounds, and per amplitude
//! too; of bones for the file's bound alone, and their amplitude nobody can choose.

use bdtree_build::progress::Progress;
use bdtree_build::wrap::ball::smallest_ball;
use bdtree_runtime::{Asset, FormatError, Pose, VertexId};

use super::content::{Ratio, TightnessRow};
use super::lanes;
use crate::MeasureError;
use crate::sample::{HERE, Sample};
use crate::vector::{distance, length};

/// Displacements of the vertex that moves most, over the diagonal.
const AMPLITUDES: [f64; 4] = [0.02, 0.05, 0.1, 0.2];

/// Spheres per level that are measured, spread evenly over those there are.
const SPHERES_MAX: usize = 100;

/// Vertices below a sphere that are looked at: of more, every n-th. All bounds and the optimum are of the
/// same ones, except ours, which is the file's: with fewer vertices R_opt could only be smaller.
const VERTICES_MAX: usize = 20_000;

/// Per level in the poses of the samples, and without a skin per amplitude too: the parts of each q are kept while its size
/// is changed.
pub(super) fn tightness(
    asset: &Asset<'_>,
    samples: &[&Sample],
    diagonal: f64,
    progress: &dyn Progress,
) -> Result<Vec<TightnessRow>, MeasureError> {
    let mut amplitudes = vec![None];
    if !asset.has_skin() {
        amplitudes.extend(AMPLITUDES.map(Some));
    }
    let reach = samples.iter().map(|sample| farthest(asset, &sample.q));
    let reach = reach.collect::<Result<Vec<_>, _>>()?;
    let mut memory = vec![0.0; asset.pose_len()];
    let mut rows = Vec::new();
    progress.stage(
        "measuring tightness",
        Some((asset.depth() * amplitudes.len()) as u64),
    );
    for level in 0..asset.depth() {
        let all = lanes::of_level(asset, level);
        let step = all.len().div_ceil(SPHERES_MAX).max(1);
        let spheres: Vec<Sphere> = all
            .into_iter()
            .step_by(step)
            .map(|(node, lane)| Sphere::new(asset, node, lane))
            .collect::<Result<_, _>>()?;
        for amplitude in &amplitudes {
            let mut ratios = [const { Vec::new() }; 3];
            for (sample, reach) in samples.iter().zip(&reach) {
                let pose = match amplitude {
                    None => sample.pose(asset, HERE, &mut memory)?,
                    Some(amplitude) if *reach > 0.0 => {
                        let scale = amplitude * diagonal / asset.unit() / reach;
                        asset.pose(&scaled(asset, &sample.q, scale), HERE, &mut memory)?
                    }
                    Some(_) => continue,
                };
                measure(&pose, &spheres, diagonal, &mut ratios)?;
            }
            let [paper, smallest_ball, bdtree] = ratios.map(|all| ratio(&all));
            if let Some(bdtree) = bdtree {
                rows.push(TightnessRow {
                    displacement_rel: *amplitude,
                    level,
                    spheres: spheres.len(),
                    paper,
                    smallest_ball,
                    bdtree,
                });
            }
            progress.advance(1);
        }
    }
    Ok(rows)
}

/// q times `scale`, each within its mode's limit.
fn scaled(asset: &Asset<'_>, q: &[f32], scale: f64) -> Vec<f32> {
    let modes = asset.modes().iter();
    q.iter()
        .zip(modes)
        .map(|(q, mode)| {
            let limit = mode.q_limit.get();
            ((f64::from(*q) * scale) as f32).clamp(-limit, limit)
        })
        .collect()
}

/// How far q moves the vertex that it moves farthest, before bones (stored units).
pub(super) fn farthest(asset: &Asset<'_>, q: &[f32]) -> Result<f64, FormatError> {
    let mut most = 0.0_f64;
    for vertex in 0..asset.vertex_count() as u32 {
        let mut by = [0.0; 3];
        for (mode, u) in asset.displacements(VertexId(vertex))?.iter() {
            for k in 0..3 {
                by[k] += f64::from(u[k]) * f64::from(q[mode]);
            }
        }
        most = most.max(length(by));
    }
    Ok(most)
}

/// A sphere and what two other bounds store of it (stored units).
struct Sphere {
    node: usize,
    lane: usize,
    vertices: Vec<u32>,
    /// Radius of the smallest ball at rest.
    radius: f64,
    /// Of each mode ΔR_j about the mean, and about the center of the smallest ball.
    growth: Vec<[f64; 2]>,
}

impl Sphere {
    fn new(asset: &Asset<'_>, node: usize, lane: usize) -> Result<Self, FormatError> {
        let mut vertices = lanes::vertices(asset, node, lane);
        let step = vertices.len().div_ceil(VERTICES_MAX).max(1);
        vertices = vertices.into_iter().step_by(step).collect();
        let positions = asset.positions();
        let at = |v: &u32| positions.get(*v as usize).map(|p| p.map(f64::from));
        let rest: Vec<[f64; 3]> = vertices.iter().filter_map(at).collect();
        let mut fields = vec![vec![[0.0; 3]; vertices.len()]; asset.mode_count()];
        for (place, v) in vertices.iter().enumerate() {
            for (mode, u) in asset.displacements(VertexId(*v))?.iter() {
                fields[mode][place] = u.map(f64::from);
            }
        }
        Ok(Self {
            node,
            lane,
            radius: smallest_ball(&rest).radius,
            growth: fields.iter().map(|field| growth(field)).collect(),
            vertices,
        })
    }

    /// R + Σ ΔR_j |q_j| with both centers.
    fn bounds(&self, q: &[f32]) -> [f64; 2] {
        [0, 1].map(|which| {
            let terms = self.growth.iter().zip(q);
            let sum: f64 = terms.map(|(g, q)| g[which] * f64::from(q.abs())).sum();
            self.radius + sum
        })
    }
}

/// ΔR of a mode: farthest from the mean, and the radius of the smallest ball.
fn growth(field: &[[f64; 3]]) -> [f64; 2] {
    let count = field.len().max(1) as f64;
    let mean = [0, 1, 2].map(|k| field.iter().map(|u| u[k]).sum::<f64>() / count);
    let far = field.iter().map(|u| distance(*u, mean)).fold(0.0, f64::max);
    [far, smallest_ball(field).radius]
}

/// Of some ratios, if there are any.
fn ratio(all: &[f64]) -> Option<Ratio> {
    (!all.is_empty()).then(|| Ratio {
        mean: all.iter().sum::<f64>() / all.len() as f64,
        max: all.iter().copied().fold(0.0, f64::max),
    })
}

/// Adds the ratios of some spheres in a pose: the paper's and the smallest balls', which know no bones, and ours.
fn measure(
    pose: &Pose<'_>,
    spheres: &[Sphere],
    diagonal: f64,
    ratios: &mut [Vec<f64>; 3],
) -> Result<(), MeasureError> {
    let asset = pose.asset();
    for sphere in spheres {
        let deformed = sphere.vertices.iter().map(|v| {
            let p = pose.deformed_stored(VertexId(*v))?;
            Ok(p.map(f64::from))
        });
        let deformed = deformed.collect::<Result<Vec<_>, FormatError>>()?;
        let found = lanes::tightness(pose, sphere.node, sphere.lane, &deformed, diagonal)?;
        let Some([ratio, best]) = found else {
            continue;
        };
        let [paper, smallest_ball, own] = ratios.each_mut();
        own.push(ratio);
        if !asset.has_skin() {
            for (all, radius) in [paper, smallest_ball]
                .into_iter()
                .zip(sphere.bounds(pose.q()))
            {
                all.push(radius / best);
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::growth;

    #[test]
    fn the_mean_is_never_better_than_the_smallest_ball() {
        let field = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.1, 0.0], [1.0, 0.0, 0.1]];
        let [mean, ball] = growth(&field);
        assert!((0.5..mean).contains(&ball), "{ball} {mean}");
        assert_eq!(growth(&[]), [0.0, 0.0]);
        assert_eq!(growth(&[[2.0, 3.0, 4.0]; 3]), [0.0, 0.0]);
    }
}
