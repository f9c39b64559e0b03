//! Where vertices stand while the tree is divided.

use super::StoredSkin;
use crate::wrap::StoredShape;

/// How far each vertex goes from where it rests to the centers of its bones. Vertices with the same bones then stand
/// closer together, so that fewer bones move a lane: spheres of characters are 2 to 5 % smaller and rays 4 to 12 % faster than
/// with 0 (docs/measured/benchmarks.md, W5). Shares from 0.3 to 0.5 do about as well; more slows down rays at meshes of
/// many triangles, whose lower nodes are then less compact.
const TOWARDS_BONES: f64 = 0.4;

/// The positions that triangles are divided by: those at rest, all fields at 0, because the bind spaces of several
/// meshes lie over each other, each moved towards the centers of its bones. Any positions are sound, since spheres are
/// made from the stored ones.
pub fn tree_positions(shape: &StoredShape, skin: &StoredSkin) -> Vec<[f32; 3]> {
    let at_rest = at_rest(shape, skin);
    let centers = bone_centers(&at_rest, skin);
    let place = |(i, p): (usize, &[f32; 3])| {
        let mut towards = [0.0; 3];
        let mut sum = 0.0;
        for influence in skin.of(i) {
            let weight = f64::from(influence.weight);
            let center = centers[usize::from(influence.bone)];
            for k in 0..3 {
                towards[k] += weight * center[k];
            }
            sum += weight;
        }
        let moved = [0, 1, 2].map(|k| {
            let from = f64::from(p[k]);
            (from + TOWARDS_BONES * (towards[k] / sum - from)) as f32
        });
        // Without weights there is no center.
        if moved.iter().all(|x| x.is_finite()) {
            moved
        } else {
            *p
        }
    };
    at_rest.iter().enumerate().map(place).collect()
}

/// The mean position of the vertices that each bone moves, by its weights; NaN where it moves none.
fn bone_centers(at_rest: &[[f32; 3]], skin: &StoredSkin) -> Vec<[f64; 3]> {
    let mut sums = vec![([0.0; 3], 0.0); skin.bones.len()];
    for (i, p) in at_rest.iter().enumerate() {
        for influence in skin.of(i) {
            let weight = f64::from(influence.weight);
            let (sum, weights) = &mut sums[usize::from(influence.bone)];
            for k in 0..3 {
                sum[k] += weight * f64::from(p[k]);
            }
            *weights += weight;
        }
    }
    let mean = |(sum, weights): ([f64; 3], f64)| sum.map(|x| x / weights);
    sums.into_iter().map(mean).collect()
}

/// Where the bones at rest put the vertices, all fields at 0 (stored units).
fn at_rest(shape: &StoredShape, skin: &StoredSkin) -> Vec<[f32; 3]> {
    let rests: Vec<[[f64; 4]; 3]> = skin
        .bones
        .iter()
        .map(|bone| bone.rest.map(|row| row.map(|x| f64::from(x.get()))))
        .collect();
    let place = |(i, p): (usize, &[f32; 3])| {
        let [x, y, z] = p.map(f64::from);
        let mut moved = [0.0; 3];
        for influence in skin.of(i) {
            let rest = &rests[usize::from(influence.bone)];
            let weight = f64::from(influence.weight);
            for (moved, row) in moved.iter_mut().zip(rest) {
                *moved += weight * (row[0] * x + row[1] * y + row[2] * z + row[3]);
            }
        }
        let moved = moved.map(|x| x as f32);
        // Farther than f32 reaches: any place will do.
        if moved.iter().all(|x| x.is_finite()) {
            moved
        } else {
            *p
        }
    };
    shape.positions.iter().enumerate().map(place).collect()
}
