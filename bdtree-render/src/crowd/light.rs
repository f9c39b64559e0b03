//! How much of the sky the points among many bodies see: what makes a heap dark inside and the floor below it.
//!
//! A body counts as its sphere, thinly filled. From the top down each layer of a grid adds what bodies hold in its cells,
//! and spreads it a little, since the sky is not only straight above.

use bdtree_runtime::BoundingSphere;

use crate::renderer::Light;

/// Cells that stay empty around the bodies, so that shade ends within the grid.
const MARGIN: f64 = 5.0;
/// Part of a sphere's disc that its body covers.
const FILLED: f64 = 0.4;
/// Parts of what lies above that come from the cell above and from each of the four beside that.
const STRAIGHT: f32 = 0.2;
const ASIDE: f32 = 0.2;

impl Light {
    /// Among bodies, relative to `origin`; the floor, if there is one, is the lowest layer.
    pub(crate) fn among(spheres: &[BoundingSphere], origin: [f64; 3], floor: Option<f32>) -> Self {
        let balls: Vec<([f64; 3], f64)> = spheres
            .iter()
            .map(|s| ([0, 1, 2].map(|k| s.center[k] - origin[k]), s.radius))
            .filter(|(c, r)| c.iter().all(|x| x.is_finite()) && *r > 0.0 && r.is_finite())
            .collect();
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for (center, radius) in &balls {
            for k in 0..3 {
                low[k] = low[k].min(center[k] - radius);
                high[k] = high[k].max(center[k] + radius);
            }
        }
        if let Some(height) = floor {
            low[1] = f64::from(height);
        }
        if balls.is_empty() || !(high[1] > low[1]) {
            return Self::unshaded();
        }
        let room = Self::CELLS.map(|n| n as f64);
        let fit = |k: usize, margin: f64| (high[k] - low[k]) / (room[k] - margin);
        let cell = fit(0, 2.0 * MARGIN)
            .max(fit(2, 2.0 * MARGIN))
            .max(fit(1, 2.0));
        // Of a few sizes and at steps of them, so that shades do not swim when bodies move a little.
        let cell = (0.25 * (4.0 * cell.log2()).ceil()).exp2();
        let from = |k: usize| {
            let middle = (0.5 * (low[k] + high[k]) / cell).round();
            (middle - 0.5 * room[k]) * cell
        };
        let corner = [from(0), low[1] - 0.5 * cell, from(2)];
        let mut held = vec![0.0_f32; Self::CELLS.iter().product()];
        for (center, radius) in &balls {
            let at = [0, 1, 2].map(|k| (center[k] - corner[k]) / cell - 0.5);
            spread(&mut held, at, radius / cell);
        }
        Self {
            low: corner.map(|x| x as f32),
            sizes: room.map(|n| (n * cell) as f32),
            open: seen_from_below(&held),
        }
    }

    /// All of the sky is seen.
    fn unshaded() -> Self {
        Self {
            low: [0.0; 3],
            sizes: [1.0; 3],
            open: vec![u8::MAX; Self::CELLS.iter().product()],
        }
    }
}

/// Adds what a body covers of its cells' columns; place and radius in cells.
fn spread(held: &mut [f32], at: [f64; 3], radius: f64) {
    let reach = radius + 1.0;
    let range = |k: usize| {
        let last = Light::CELLS[k] as f64 - 1.0;
        let [from, to] = [at[k] - reach, at[k] + reach].map(|x| x.clamp(0.0, last));
        from.ceil() as usize..=to.floor() as usize
    };
    // 1 in the middle, falling smoothly to 0.
    let weight = |cell: [usize; 3]| {
        let apart = [0, 1, 2].map(|k| cell[k] as f64 - at[k]);
        let square = apart.iter().map(|d| d * d).sum::<f64>() / (reach * reach);
        (1.0 - square).max(0.0).powi(2)
    };
    let cells = || {
        let planes = range(2).flat_map(|z| range(1).map(move |y| (y, z)));
        planes.flat_map(|(y, z)| range(0).map(move |x| [x, y, z]))
    };
    let total: f64 = cells().map(weight).sum();
    if !(total > 0.0) {
        return;
    }
    let covers = FILLED * std::f64::consts::PI * radius * radius / total;
    for cell in cells() {
        held[index(cell)] += (covers * weight(cell)) as f32;
    }
}

/// What of the sky each cell sees through what the cells above hold.
fn seen_from_below(held: &[f32]) -> Vec<u8> {
    let [nx, ny, nz] = Light::CELLS;
    let mut open = vec![u8::MAX; held.len()];
    let mut above = vec![0.0_f32; nx * nz];
    let mut next = above.clone();
    for y in (0..ny).rev() {
        for z in 0..nz {
            for x in 0..nx {
                let own = held[index([x, y, z])];
                let through = |x: usize, z: usize| above[x + nx * z];
                let beside = through(x.saturating_sub(1), z)
                    + through((x + 1).min(nx - 1), z)
                    + through(x, z.saturating_sub(1))
                    + through(x, (z + 1).min(nz - 1));
                let spread = STRAIGHT * through(x, z) + ASIDE * beside;
                let share = (-(spread + 0.5 * own)).exp();
                open[index([x, y, z])] = (255.0 * share).round() as u8;
                next[x + nx * z] = spread + own;
            }
        }
        std::mem::swap(&mut above, &mut next);
    }
    open
}

fn index([x, y, z]: [usize; 3]) -> usize {
    let [nx, ny, _] = Light::CELLS;
    x + nx * (y + ny * z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_dark_below_a_body_and_bright_beside_and_above_it() {
        let body = BoundingSphere {
            center: [7.0, 1.0, -3.0],
            radius: 0.5,
        };
        let light = Light::among(&[body], [5.0, 0.0, 0.0], Some(0.0));
        let at = |p: [f64; 3]| {
            let cell = [0, 1, 2].map(|k| {
                let share = (p[k] - f64::from(light.low[k])) / f64::from(light.sizes[k]);
                (share * Light::CELLS[k] as f64) as usize
            });
            light.open[index(cell)]
        };
        let (below, beside, above) = (
            at([2.0, 0.0, -3.0]),
            at([2.7, 0.0, -3.0]),
            at([2.0, 1.45, -3.0]),
        );
        assert!(below < 200 && below + 20 < beside, "{below} {beside}");
        assert!(beside > 230 && above > 245, "{beside} {above}");
        // The lowest layer's middle is the floor.
        let cell = light.sizes[1] / Light::CELLS[1] as f32;
        assert!((light.low[1] + 0.5 * cell).abs() < 1e-6);
        assert!(
            Light::among(&[], [0.0; 3], None)
                .open
                .iter()
                .all(|x| *x == 255)
        );
    }
}
