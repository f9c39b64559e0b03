//! The number that tells maps apart. What maps are is tested beside the poses that have them (tests/bone_maps.rs).

use super::*;

#[test]
fn maps_that_differ_have_different_numbers() {
    let plain = BoneMap {
        rows: [
            [0.0, 0.0, 0.0, 0.0],
            [-1.0, 2.0, 0.5, 3.0],
            [1.0, 1.0, 1.0, 1.0],
        ],
        stretch: 1.0,
        unused: [0.0; 3],
    };
    let mut seen = std::collections::BTreeSet::new();
    let mut count = 0;
    let mut add = |maps: &[BoneMap]| {
        count += 1;
        seen.insert(hashed_maps(maps));
    };
    let maps = [plain; 3];
    add(&[]);
    add(&maps[..1]);
    add(&maps);
    // One bit, and the signs of two numbers.
    for bone in 0..3 {
        for (r, c) in (0..12).map(|k| (k / 4, k % 4)) {
            for bit in 0..32 {
                let mut one = maps;
                let x = &mut one[bone].rows[r][c];
                *x = f32::from_bits(x.to_bits() ^ (1 << bit));
                add(&one);
            }
            for (other, s, d) in (0..36).map(|k| (k / 12, k / 4 % 3, k % 4)) {
                if (other, s, d) > (bone, r, c) {
                    let mut two = maps;
                    two[bone].rows[r][c] = -two[bone].rows[r][c];
                    two[other].rows[s][d] = -two[other].rows[s][d];
                    add(&two);
                }
            }
        }
    }
    assert_eq!(seen.len(), count);
}
