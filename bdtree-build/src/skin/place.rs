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
    towards_bones(&at_rest(shape, skin), skin)
}

/// Vertices that stand at `at_rest`, moved towards the centers of their bones.
fn towards_bones(at_rest: &[[f32; 3]], skin: &StoredSkin) -> Vec<[f32; 3]> {
    let centers = bone_centers(at_rest, skin);
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

#[cfg(test)]
mod tests {
    use bdtree_format::{BoneRecord, InfluenceRecord, SkinRecord};

    use super::*;

    fn bone() -> BoneRecord {
        BoneRecord {
            joint: 0.into(),
            reserved: 0.into(),
            inverse_bind: [[0.0.into(); 4]; 3],
            rest: [[0.0.into(); 4]; 3],
            low: [0.0.into(); 3],
            high: [0.0.into(); 3],
            core_low: [0.0.into(); 3],
            core_high: [0.0.into(); 3],
        }
    }

    /// With a bone that moves nothing, and a vertex without bones, as `--weights as-stored` keeps it: it stays.
    #[test]
    fn vertices_go_towards_their_bones() {
        let influence = |bone, weight| InfluenceRecord {
            weight,
            bone,
            reserved: 0,
        };
        let skin = StoredSkin {
            record: SkinRecord {
                influences_max: 2,
                node_bones_max: 0,
                weight_defect: 1.0,
                minor_share: 0.0,
                reserved: [0; 4],
            },
            starts: vec![0, 1, 2, 4, 4],
            influences: vec![
                influence(0, 1.0),
                influence(0, 1.0),
                influence(0, 0.5),
                influence(1, 0.5),
            ],
            bones: vec![bone(); 3],
            bone_fields: Vec::new(),
            skeleton: Vec::new(),
            joints: Vec::new(),
            names: Vec::new(),
            clips: Vec::new(),
            channels: Vec::new(),
            keys: Vec::new(),
        };
        let at_rest = [[0.0; 3], [2.0, 0.0, 0.0], [5.0, 4.0, 0.0], [5.0; 3]];
        // The first bone's center is ((0, 0) + (2, 0) + (5, 4) / 2) / 2.5, the second's the third vertex.
        let first = [1.8, 0.8];
        let both = [0.5 * (1.8 + 5.0), 0.5 * (0.8 + 4.0)];
        let found = towards_bones(&at_rest, &skin);
        for (i, to) in [first, first, both].into_iter().enumerate() {
            for k in 0..2 {
                let from = f64::from(at_rest[i][k]);
                let place = from + TOWARDS_BONES * (to[k] - from);
                assert!((f64::from(found[i][k]) - place).abs() < 1e-6, "{found:?}");
            }
            assert_eq!(found[i][2], 0.0);
        }
        assert_eq!(found[3], at_rest[3]);
    }
}
