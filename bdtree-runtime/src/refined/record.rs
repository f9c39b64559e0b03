//! What is kept of a node and of a leaf.

use bdtree_format::{LANES, Row};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

use crate::bound::WideSpheres;
use crate::cache::CHUNK;
use crate::rounding::{BOX_AROUND, BOX_RADIUS};
use crate::simd::Lanes;

/// Eight boxes, side by side (stored units, relative to the origin): the least and the greatest coordinates of all deformed
/// corners below a lane, exactly; above branches, boxes that hold them. Of a lane that leads nowhere the least is above the greatest,
/// or they are any numbers.
#[derive(Debug, Clone, Copy, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub(crate) struct Boxes {
    pub(crate) low: [Row; 3],
    pub(crate) high: [Row; 3],
}

impl Boxes {
    /// Boxes around spheres (docs/design/guarantees.md, boxes around spheres).
    #[inline(always)]
    pub(super) fn around<L: Lanes>(spheres: &WideSpheres<L>) -> Self {
        let [mut low, mut high] = [[[0.0; LANES]; 3]; 2];
        for axis in 0..3 {
            let center = spheres.center[axis];
            let size = center.max(L::splat(0.0).sub(center)).add(spheres.radius);
            let reach = spheres.radius.add(size.mul(L::splat(BOX_AROUND)));
            low[axis] = center.sub(reach).store();
            high[axis] = center.add(reach).store();
        }
        Self { low, high }
    }

    /// Spheres around the boxes; `added` to all radii, it pays for centers that are farther from the origin than any vertex is
    /// (docs/design/guarantees.md, spheres around boxes).
    #[inline(always)]
    pub(crate) fn spheres<L: Lanes>(&self, added: f32) -> WideSpheres<L> {
        let half = L::splat(0.5);
        let mut spheres = WideSpheres::empty();
        let mut squared = L::splat(0.0);
        for axis in 0..3 {
            let (low, high) = (L::load(&self.low[axis]), L::load(&self.high[axis]));
            let center = low.add(high).mul(half);
            let far = high.sub(center).max(center.sub(low));
            squared = squared.add(far.mul(far));
            spheres.center[axis] = center;
        }
        let radius = squared.sqrt().mul(L::splat(BOX_RADIUS));
        spheres.radius = radius.add(L::splat(added));
        spheres
    }

    /// Squares of the distances from a point to the boxes: 0 within one.
    #[inline(always)]
    pub(crate) fn squared_distances<L: Lanes>(&self, point: [f32; 3]) -> L {
        let mut squared = L::splat(0.0);
        for axis in 0..3 {
            let (low, high) = (L::load(&self.low[axis]), L::load(&self.high[axis]));
            let at = L::splat(point[axis]);
            let gap = low.sub(at).max(at.sub(high)).max(L::splat(0.0));
            squared = squared.add(gap.mul(gap));
        }
        squared
    }
}

/// A node: its boxes, and where its lanes lead, so that walks need not read the asset's.
#[derive(Debug, Clone, Copy, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub(crate) struct RefinedNode {
    pub(crate) boxes: Boxes,
    /// Where each lane leads: the index of a node, or of the first group of a leaf. With the bit
    /// [`UNREFINED`](crate::traverse::UNREFINED) that of a node of the asset, or of a leaf's first triangle slot.
    pub(crate) starts: [u32; LANES],
    /// Of each lane's leaf; 0 where it leads to a node.
    pub(crate) triangles: [u8; LANES],
    /// Lanes that lead anywhere, and of these those that lead to nodes.
    pub(crate) used: u8,
    pub(super) inner_mask: u8,
    /// Fills up to a multiple of eight bytes.
    pub(super) unused: [u8; 6],
}

/// Up to four triangles of a leaf, deformed.
#[derive(Debug, Clone, Copy, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub(crate) struct RefinedLeaf {
    /// Stored units: of each corner, of each coordinate, that of the four. Places without a triangle repeat the first one.
    pub(crate) corners: [[[f32; CHUNK]; 3]; 3],
    pub(crate) ids: [u32; CHUNK],
}

/// Groups of four triangles that a leaf with so many triangles makes.
#[inline(always)]
pub(super) fn groups_of(triangles: u8) -> u32 {
    u32::from(triangles).div_ceil(CHUNK as u32)
}

/// The same of a node's leaves together.
#[inline(always)]
pub(super) fn groups_in(leaf_counts: &[u8; LANES]) -> u32 {
    // Four numbers of sixteen bits at once: each rounded up to fours, then added.
    const EVEN: u64 = 0x00ff_00ff_00ff_00ff;
    const THREE: u64 = 0x0003_0003_0003_0003;
    const FOURS: u64 = 0x003f_003f_003f_003f | 0x0040_0040_0040_0040;
    let all = u64::from_le_bytes(*leaf_counts);
    let groups = |counts: u64| ((counts + THREE) >> 2) & FOURS;
    let pairs = groups(all & EVEN) + groups((all >> 8) & EVEN);
    (pairs.wrapping_mul(0x0001_0001_0001_0001) >> 48) as u32
}

#[cfg(test)]
mod tests {
    use bdtree_format::{LANES, Row};
    use num_rational::BigRational;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::{Boxes, groups_in, groups_of};
    use crate::bound::{Spheres, WideSpheres};
    use crate::simd::Compact;

    fn exact(x: f32) -> BigRational {
        BigRational::from_float(x).expect("finite")
    }

    #[test]
    fn boxes_hold_the_spheres_that_they_are_around() {
        let mut rng = Pcg64Mcg::seed_from_u64(4);
        for _ in 0..3000 {
            let size = f32::from(rng.random_range(-100..=90_i8)).exp2();
            let mut row = |from: f32| -> Row {
                // Centers and radii of the same size, or of any other.
                core::array::from_fn(|_| {
                    let share = f32::from(rng.random_range(-20..=20_i8)).exp2();
                    size * share * rng.random_range(from..1.0)
                })
            };
            let spheres = Spheres {
                center: [row(-1.0), row(-1.0), row(-1.0)],
                radius: row(0.0),
            };
            let boxes = Boxes::around(&WideSpheres::<Compact>::load(&spheres));
            for axis in 0..3 {
                for lane in 0..LANES {
                    let center = exact(spheres.center[axis][lane]);
                    let radius = exact(spheres.radius[lane]);
                    assert!(exact(boxes.low[axis][lane]) <= &center - &radius);
                    assert!(exact(boxes.high[axis][lane]) >= &center + &radius);
                    // And no more than rounding takes.
                    let most =
                        &radius + (center.clone().max(-center.clone()) + &radius) * exact(8e-7);
                    assert!(exact(boxes.low[axis][lane]) >= &center - &most);
                    assert!(exact(boxes.high[axis][lane]) <= &center + &most);
                }
            }
        }
    }

    #[test]
    fn groups_are_counts_rounded_up_to_fours() {
        for (count, groups) in [(0, 0), (1, 1), (4, 1), (5, 2), (254, 64), (255, 64)] {
            assert_eq!(groups_of(count), groups);
        }
        for counts in [[0, 1, 4, 5, 255, 3, 254, 255], [255; 8], [0; 8]] {
            let expected: u32 = counts.iter().map(|n| groups_of(*n)).sum();
            assert_eq!(groups_in(&counts), expected);
        }
    }
}
