//! Seeded q and placements, ordinary and adversarial.

use bdtree_runtime::{Asset, Transform};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// A generator that gives the same numbers on every machine.
pub fn rng(seed: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed)
}

/// q whose modes move vertices by up to `share` of the bounding box's diagonal in total, with
/// random signs and amplitudes.
pub fn random_q(asset: &Asset<'_>, share: f64, rng: &mut Pcg64Mcg) -> Vec<f32> {
    let weights: Vec<f64> = (0..asset.mode_count())
        .map(|_| rng.random_range(-1.0..1.0))
        .collect();
    let total: f64 = weights.iter().map(|w: &f64| w.abs()).sum::<f64>().max(1e-9);
    asset
        .modes()
        .iter()
        .zip(&weights)
        .map(|(mode, weight)| {
            let w = f64::from(mode.field_norm_max.get());
            if w == 0.0 {
                0.0
            } else {
                let q = share * diagonal(asset) * weight / total / w;
                let limit = f64::from(mode.q_limit.get());
                q.clamp(-limit, limit) as f32
            }
        })
        .collect()
}

/// Hard q: zero, denormal, one mode only, all signs alike, alternating, at the hard limit, one
/// mode large beside others that are tiny, all reaching equally far.
pub fn hard_qs(asset: &Asset<'_>) -> Vec<Vec<f32>> {
    let m = asset.mode_count();
    let limit = |j: usize| asset.modes()[j].q_limit.get();
    let range = |j: usize| asset.modes()[j].q_range.get();
    let mut all = vec![
        vec![0.0; m],
        vec![f32::from_bits(1); m],
        vec![-f32::MIN_POSITIVE; m],
        (0..m).map(range).collect(),
        (0..m).map(|j| -range(j)).collect(),
        (0..m)
            .map(|j| {
                if j % 2 == 0 {
                    range(j)
                } else {
                    -10.0 * range(j)
                }
            })
            .collect(),
        (0..m).map(limit).collect(),
        (0..m)
            .map(|j| if j % 2 == 0 { limit(j) } else { -limit(j) })
            .collect(),
    ];
    for tiny in [1e-3, 1e-5, 1e-9, 1e-30] {
        let mut q: Vec<f32> = (0..m).map(|j| tiny * range(j)).collect();
        if let Some(q) = q.get_mut(m / 2) {
            *q /= -tiny;
        }
        all.push(q);
    }
    let reach = |j: usize| asset.modes()[j].field_norm_max.get();
    all.push((0..m).map(|j| 0.1 / reach(j).max(1e-30)).collect());
    for j in 0..m.min(3) {
        let mut q = vec![0.0; m];
        q[j] = 5.0 * range(j);
        all.push(q);
    }
    for q in &mut all {
        for (j, q) in q.iter_mut().enumerate() {
            *q = q.clamp(-limit(j), limit(j));
        }
    }
    all
}

/// The diagonal of the rest positions' bounding box (stored units).
pub fn diagonal(asset: &Asset<'_>) -> f64 {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for p in asset.positions() {
        for k in 0..3 {
            low[k] = low[k].min(f64::from(p[k]));
            high[k] = high[k].max(f64::from(p[k]));
        }
    }
    (0..3)
        .map(|k| (high[k] - low[k]).powi(2))
        .sum::<f64>()
        .sqrt()
}

/// A random rotation and scale, with a translation of up to `spread`.
pub fn random_transform(spread: f64, rng: &mut Pcg64Mcg) -> Transform {
    let mut rotation = [0.0; 4];
    loop {
        for c in &mut rotation {
            *c = rng.random_range(-1.0..1.0);
        }
        let norm = rotation.iter().map(|c: &f64| c * c).sum::<f64>().sqrt();
        if (0.1..1.0).contains(&norm) {
            rotation = rotation.map(|c| c / norm);
            break;
        }
    }
    Transform {
        rotation,
        translation: [0; 3].map(|_| rng.random_range(-spread..=spread)),
        scale: rng.random_range(0.5..2.0),
    }
}
