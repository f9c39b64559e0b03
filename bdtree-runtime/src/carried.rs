//! The bound with bones: the spheres of a node, carried by the maps of its bones (SPEC 5.9).
//!
//! ```text
//! p' = Σ_b w_b T_b x = c' + Σ_b w_b (y_b − c') + (Σ_b w_b A_b) (x − c) + (Σ_b w_b − 1) c',   y_b = T_b c
//! ```
//!
//! The third term is at most σ R for the sphere (c, R) before bones; of the second there are two bounds, from how far the
//! weights below the lane are from their middles (*knapsack*), and from the least weights (*simplex*). Derivation and
//! rounding: docs/design/guarantees.md, skins.

use arrayvec::ArrayVec;
use bdtree_format::{BONE_ROW_DEFECT, BONE_ROW_SCALE, BONE_ROW_SPREAD};

use crate::bones::{BoneMap, PosedBones};
use crate::bound::{Spheres, WideSpheres};
use crate::error::FormatError;
use crate::rounding::BONES_ROUNDING;
use crate::simd::{Lanes, Work};
use crate::view::{Asset, NodeBones};

/// Bones of a node of which places are kept; those of more are computed twice.
const PLACES: usize = 64;

/// Bones of a node of which places and distances are kept, so that the knapsack is solved exactly; of more, only the two
/// ends of its range are looked at.
const KEPT: usize = 8;

impl Asset<'_> {
    /// Moves the spheres of node `index`, which are those without bones, to where bones carry them. Compiled once per instruction set, not into every
    /// walk.
    ///
    /// # Errors
    /// Bones of the node that are not in the file.
    pub(crate) fn carry(
        &self,
        index: u32,
        pose: &PosedBones<'_>,
        spheres: &mut Spheres,
    ) -> Result<(), FormatError> {
        let skin = self.skin.as_ref();
        let node = skin.and_then(|skin| skin.node_bones(index as usize));
        let carried = node.and_then(|node| {
            self.kernel.run(Carry {
                node,
                pose,
                spheres,
            })
        });
        carried.ok_or_else(|| self.bones_of_node(index))
    }
}

struct Carry<'c> {
    node: NodeBones<'c>,
    pose: &'c PosedBones<'c>,
    /// In place: returned by value they would be copied in narrower parts than they are read in, for which a processor
    /// waits (a twentieth of a ray).
    spheres: &'c mut Spheres,
}

impl Work for Carry<'_> {
    type Output = Option<()>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Option<()> {
        let spheres = WideSpheres::<L>::load(self.spheres);
        *self.spheres = carried(&self.node, self.pose, spheres)?.store();
        Some(())
    }
}

/// A point per lane.
type Points<L> = [L; 3];

#[inline(always)]
fn add3<L: Lanes>(a: Points<L>, b: Points<L>) -> Points<L> {
    [a[0].add(b[0]), a[1].add(b[1]), a[2].add(b[2])]
}

#[inline(always)]
fn sub3<L: Lanes>(a: Points<L>, b: Points<L>) -> Points<L> {
    [a[0].sub(b[0]), a[1].sub(b[1]), a[2].sub(b[2])]
}

#[inline(always)]
fn scaled<L: Lanes>(a: Points<L>, by: L) -> Points<L> {
    [a[0].mul(by), a[1].mul(by), a[2].mul(by)]
}

/// y = A c + t. Spelled out: a closure, and so `array::map`, would not be compiled with the instruction set of the caller.
#[inline(always)]
fn carried_by<L: Lanes>(map: &BoneMap, [x, y, z]: Points<L>) -> Points<L> {
    let mut carried = [x; 3];
    for r in 0..3 {
        let [a, b, c, t] = map.rows[r];
        let sum = x.mul(L::splat(a)).add(y.mul(L::splat(b)));
        carried[r] = sum.add(z.mul(L::splat(c))).add(L::splat(t));
    }
    carried
}

#[inline(always)]
fn squared<L: Lanes>([x, y, z]: Points<L>) -> L {
    x.mul(x).add(y.mul(y)).add(z.mul(z))
}

#[inline(always)]
fn carried<L: Lanes>(
    node: &NodeBones<'_>,
    pose: &PosedBones<'_>,
    spheres: WideSpheres<L>,
) -> Option<WideSpheres<L>> {
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    let scale = L::load(&node.fixed[BONE_ROW_SCALE]);
    let defect = L::load(&node.fixed[BONE_ROW_DEFECT]);
    // c', and what the simplex shares: its corners are e + r d_b.
    let mut center = [zero; 3];
    let mut least = [zero; 3];
    let mut least_sum = zero;
    let mut stretch = zero;
    let mut places = ArrayVec::<Points<L>, PLACES>::new();
    for (&bone, [low, high]) in node.bones.iter().zip(node.weights) {
        let map = pose.maps.get(usize::from(bone))?;
        let y = carried_by(map, spheres.center);
        if !places.is_full() {
            places.push(y);
        }
        let (low, high) = (L::load(low), L::load(high));
        center = add3(center, scaled(y, scale.mul(low.add(high))));
        least = add3(least, scaled(y, low));
        least_sum = least_sum.add(low);
        stretch = stretch.max(is_there(high).mul(L::splat(map.stretch)));
    }
    let rest = one.sub(least_sum);
    let shift = sub3(least, scaled(center, least_sum));

    let mut farthest = zero;
    let mut corner = zero;
    let mut all = zero;
    let mut kept = ArrayVec::<_, KEPT>::new();
    for (k, (&bone, [low, high])) in node.bones.iter().zip(node.weights).enumerate() {
        let y = match places.get(k) {
            Some(place) => *place,
            None => carried_by(pose.maps.get(usize::from(bone))?, spheres.center),
        };
        let (low, high) = (L::load(low), L::load(high));
        let there = is_there(high);
        let d = sub3(y, center);
        let middle = scale.mul(low.add(high));
        let gap = high.sub(middle).max(middle.sub(low)).max(zero);
        let length = squared(d).sqrt();
        farthest = farthest.max(there.mul(length));
        corner = corner.max(there.mul(squared(add3(shift, scaled(d, rest)))));
        all = all.add(gap.mul(length));
        if !kept.is_full() {
            kept.push((gap, length));
        }
    }
    let spread = L::load(&node.fixed[BONE_ROW_SPREAD]);
    // λ = 0 and λ = the largest length.
    let mut knapsack = all.min(spread.mul(farthest));
    let count = node.bones.len();
    if (3..=KEPT).contains(&count) {
        // The minimum over λ is at one of the lengths.
        for (_, lambda) in &kept {
            let mut sum = spread.mul(*lambda);
            for (gap, length) in &kept {
                sum = sum.add(gap.mul(length.sub(*lambda).max(zero)));
            }
            knapsack = knapsack.min(sum);
        }
    }
    let simplex = corner.sqrt().add(defect.mul(farthest));
    let moved = knapsack.min(simplex);
    let grown = one.add(defect).mul(stretch).mul(spheres.radius);
    let off = defect.mul(squared(center).sqrt());
    let m = count as f32;
    let rounding = L::splat(1.0 + BONES_ROUNDING * (m + 16.0));
    let slack = L::splat(pose.slack.base + m * pose.slack.per_bone);
    Some(WideSpheres {
        center,
        radius: grown.add(moved).add(off).mul(rounding).add(slack),
    })
}

/// 1 in the lanes that have a bone, whose largest weight is `high`, and 0 in the others: weights are 0 or at least 2⁻³².
#[inline(always)]
fn is_there<L: Lanes>(high: L) -> L {
    const LARGE: f32 = (1_u64 << 32) as f32;
    high.mul(L::splat(LARGE)).min(L::splat(1.0))
}
