//! Sphere and box in the world around the spheres of a root's lanes.

use bdtree_format::{LANES, Row};

use super::bounds::{Aabb, BoundingSphere};
use crate::bound::Spheres;
use crate::pose::Pose;
use crate::rounding::{MAPS, MARGIN};
use crate::simd::{Lanes, Quad, Quad3, Work, dot3, splat3, sub3};

/// The sphere around all lanes, and the box around those of the lanes, of which none says more than that sphere.
pub(super) struct RootBox<'a> {
    pub(super) pose: &'a Pose<'a>,
    pub(super) spheres: &'a Spheres,
    /// Those that there are.
    pub(super) lanes: u8,
}

impl Work for RootBox<'_> {
    type Output = (BoundingSphere, Aabb);

    /// Four lanes are side by side.
    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let (pose, spheres, lanes) = (self.pose, self.spheres, self.lanes);
        let (center, radius) = around::<L::Quad>(spheres, lanes);
        // No vertex is farther from the origin than B; a radius that is NaN is not smaller.
        let farthest = pose.reach + f64::from(pose.slack);
        let all = if radius < farthest {
            pose.world_sphere(center, radius, pose.reach)
        } else {
            pose.world_sphere([0.0; 3], farthest, pose.reach)
        };
        let (middle, most) = (splat3::<L::Quad>(all.center), L::Quad::splat(all.radius));
        let mut low = [L::Quad::splat(f64::INFINITY); 3];
        let mut high = [L::Quad::splat(f64::NEG_INFINITY); 3];
        for first in [0, 4] {
            let (center, radius) = four_spheres::<L::Quad>(pose, spheres, first);
            // Anything but a smaller radius, NaN of a corrupt file included, says no more than the whole.
            let is_smaller = most.above(radius);
            let radius = L::Quad::select(is_smaller, radius, most);
            let is_there = is_there::<L::Quad>(lanes >> first);
            for k in 0..3 {
                let center = L::Quad::select(is_smaller, center[k], middle[k]);
                // The sums' own rounding.
                let far = L::Quad::splat(f64::EPSILON).mul(center.abs().add(radius));
                let (least, largest) = (center.sub(radius).sub(far), center.add(radius).add(far));
                let least = L::Quad::select(is_there, least, L::Quad::splat(f64::INFINITY));
                let largest = L::Quad::select(is_there, largest, L::Quad::splat(f64::NEG_INFINITY));
                // NaN, of a damaged file, bounds nothing.
                low[k] = low[k].min(least);
                high[k] = largest.max(high[k]);
            }
        }
        let mut aabb = Aabb {
            min: [f64::INFINITY; 3],
            max: [f64::NEG_INFINITY; 3],
        };
        for k in 0..3 {
            for x in low[k].store() {
                aabb.min[k] = x.min(aabb.min[k]);
            }
            for x in high[k].store() {
                aabb.max[k] = x.max(aabb.max[k]);
            }
        }
        (all, aabb)
    }
}

/// [`Pose::world_sphere`] of four lanes from `first` on.
#[inline(always)]
fn four_spheres<Q: Quad>(pose: &Pose<'_>, spheres: &Spheres, first: usize) -> (Quad3<Q>, Q) {
    let placement = &pose.placement;
    let center = placement.world_four::<Q>(&four_centers(spheres, first));
    let [translation, origin] = placement.far();
    let far = dot3(center, center).sqrt();
    let far = far.add(Q::splat(translation)).add(Q::splat(origin));
    let per_stored = Q::splat(placement.world_per_stored());
    // A lane's center lies within twice the reach (docs/design/guarantees.md).
    let stored = far.div(per_stored).add(Q::splat(2.0 * pose.reach));
    let radius = Q::widen(&four(&spheres.radius, first)).add(stored.mul(Q::splat(MAPS)));
    let radius = radius.mul(per_stored).mul(Q::splat(1.0 + MARGIN));
    (center, radius)
}

/// A sphere around those of some lanes (stored units): about the middle of their box, which f32
/// holds exactly enough since the radius is formed about what it holds.
#[inline(always)]
fn around<Q: Quad>(spheres: &Spheres, lanes: u8) -> ([f32; 3], f64) {
    let mut center = [0.0; 3];
    for axis in 0..3 {
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for k in 0..LANES {
            let (x, radius) = (spheres.center[axis][k], spheres.radius[k]);
            if lanes & (1 << k) != 0 {
                // NaN is passed over.
                low = if x - radius < low { x - radius } else { low };
                high = if x + radius > high { x + radius } else { high };
            }
        }
        center[axis] = 0.5 * low + 0.5 * high;
    }
    // Without lanes, which no sound root is, nothing is known.
    let mut radius = if lanes == 0 { f64::INFINITY } else { 0.0 };
    let middle = [
        f64::from(center[0]),
        f64::from(center[1]),
        f64::from(center[2]),
    ];
    for first in [0, 4] {
        let [x, y, z] = four_centers(spheres, first);
        let apart = sub3([Q::widen(&x), Q::widen(&y), Q::widen(&z)], splat3(middle));
        let apart = dot3(apart, apart).sqrt().mul(Q::splat(1.0 + MARGIN));
        let reach = apart.add(Q::widen(&four(&spheres.radius, first))).store();
        for k in 0..4 {
            // Anything but "not larger" counts, so that NaN stays.
            let is_within = reach[k] <= radius || radius.is_nan();
            if lanes & (1 << (first + k)) != 0 && !is_within {
                radius = reach[k];
            }
        }
    }
    (center, radius)
}

#[inline(always)]
fn four(row: &Row, first: usize) -> [f32; 4] {
    [row[first], row[first + 1], row[first + 2], row[first + 3]]
}

#[inline(always)]
fn four_centers(spheres: &Spheres, first: usize) -> [[f32; 4]; 3] {
    let [x, y, z] = &spheres.center;
    [four(x, first), four(y, first), four(z, first)]
}

/// Of the first four bits which are set.
#[inline(always)]
fn is_there<Q: Quad>(lanes: u8) -> Q::Mask {
    let mut is_there = [0.0; 4];
    for k in 0..4 {
        is_there[k] = f64::from((lanes >> k) & 1);
    }
    Q::load(&is_there).above(Q::splat(0.0))
}
