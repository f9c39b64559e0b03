//! Where vertices stand while the tree is divided.

use super::StoredSkin;
use crate::wrap::StoredShape;

/// The positions that triangles are divided by: those at rest, all fields at 0, because the bind spaces of several
/// meshes lie over each other. What else should keep triangles apart (weights, say) belongs here too: any positions are
/// sound, since spheres are made from the stored ones.
pub fn tree_positions(shape: &StoredShape, skin: &StoredSkin) -> Vec<[f32; 3]> {
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
