//! Bones that are hard on bounds: turned, sheared, mirrored, flat, large and far apart.

use bdtree_runtime::{Asset, JointMatrix};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// Kinds of bones that [`hard_bones`] makes.
const KINDS: u64 = 8;

/// Skinning matrices of kind `kind` (modulo [`KINDS`]), one per bone; none for bones at rest, and without a skin.
pub(super) fn hard_bones(asset: &Asset<'_>, kind: u64, rng: &mut Pcg64Mcg) -> Vec<JointMatrix> {
    let kind = kind % KINDS;
    if kind == 0 {
        return Vec::new();
    }
    let size = f64::from(asset.header().position_norm_max.get()) * asset.unit();
    let origin = asset.origin();
    let one = |_| {
        let linear = linear(kind, rng);
        let reach = size * [0.0, 0.05, 1.0, 0.5, 1.0, 0.5, 1.0, 1e3][kind as usize];
        // About the asset's origin, so that one far away does not decide how far bones move.
        core::array::from_fn(|r| {
            let [x, y, z] = linear[r];
            let turned = x * origin[0] + y * origin[1] + z * origin[2];
            let moved = reach * rng.random_range(-1.0..=1.0);
            [x, y, z, origin[r] - turned + moved]
        })
    };
    (0..asset.bone_count()).map(one).collect()
}

fn linear(kind: u64, rng: &mut Pcg64Mcg) -> [[f64; 3]; 3] {
    if kind == 4 {
        return [[0.0; 3]; 3].map(|row| row.map(|_: f64| rng.random_range(-2.0..2.0)));
    }
    let largest = if kind == 1 { 0.3 } else { 3.2 };
    let mut rows = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for axis in 0..3 {
        let angle: f64 = rng.random_range(-largest..largest);
        let (sin, cos) = angle.sin_cos();
        let [i, j] = [(axis + 1) % 3, (axis + 2) % 3];
        for k in 0..3 {
            let [a, b] = [rows[i][k], rows[j][k]];
            (rows[i][k], rows[j][k]) = (cos * a - sin * b, sin * a + cos * b);
        }
    }
    let scales: [f64; 3] = match kind {
        3 => [0; 3].map(|_| rng.random_range(0.1..3.0)),
        5 => [-1.0, 1.0, 1.0],
        // As flat as a plane, a line or a point.
        6 => [[1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3]][rng.random_range(0..3_usize)],
        7 => [10_f64.powf(rng.random_range(-3.0..3.0)); 3],
        _ => [1.0; 3],
    };
    rows.map(|row| [0, 1, 2].map(|k| row[k] * scales[k]))
}
