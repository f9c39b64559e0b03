//! The number that tells maps apart, and what f32 has the range for. What maps are is tested beside the poses that have
//! them (tests/bone_maps.rs).

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

/// A turn about an axis that is no coordinate axis, scaled.
fn turned(scale: f32) -> BoneMap {
    let rows = [[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]];
    BoneMap {
        rows: rows.map(|[x, y, z]| [scale * x, scale * y, scale * z, 1.0]),
        stretch: f32::NAN,
        unused: [0.0; 3],
    }
}

#[test]
fn stretches_in_f32_are_close_or_not_taken() {
    use crate::simd::Compact;
    for count in [1, 7, 8, 9, 17] {
        for scale in [1e-2, 0.5, 1.0, 300.0, 1e8, 1e12] {
            let mut maps = std::vec![turned(scale); count];
            maps[count / 2] = turned(0.0);
            if count == 1 {
                maps[0] = turned(scale);
            }
            let (farthest, largest) = eight::reach::<Compact>(&mut maps, 2.0).expect("in range");
            let close = scale..=scale * (1.0 + 2e-5);
            assert!(close.contains(&largest), "{scale}: {largest}");
            let reach = f64::from(scale) * 2.0 + f64::sqrt(3.0);
            assert!(farthest >= reach && farthest <= reach * (1.0 + 2e-5));
            for (bone, map) in maps.iter().enumerate() {
                if count > 1 && bone == count / 2 {
                    assert!(map.stretch > 0.0 && map.stretch < 1e-8);
                } else {
                    assert!(close.contains(&map.stretch), "{scale}: {}", map.stretch);
                }
            }
        }
    }
    for scale in [0.0, 1e-9, 1e30, f32::INFINITY, f32::NAN] {
        for beside in 0..3 {
            let mut maps = std::vec![turned(scale); 1 + beside];
            assert_eq!(eight::reach::<Compact>(&mut maps, 2.0), None, "{scale}");
        }
    }
    // Farther than any map may reach.
    assert_eq!(eight::reach::<Compact>(&mut [turned(1.0)], 2e18), None);
    assert_eq!(eight::reach::<Compact>(&mut [], 2.0), None);
}
