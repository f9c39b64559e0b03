//! The bound with bones: the spheres of a node, carried by the maps of its bones (SPEC 5.9).
//!
//! ```text
//! p' = Σ_b w_b T_b x = c' + Σ_b w_b (y_b − c') + (Σ_b w_b A_b) (x − c) + (Σ_b w_b − 1) c',   y_b = T_b c
//! ```
//!
//! The third term is at most σ R for the sphere (c, R) before bones; of the second there are two bounds, from how far the
//! weights below the lane are from their middles (*knapsack*), and from the least weights (*simplex*). Derivation and
//! rounding: docs/design/guarantees.md, skins. The least of the knapsack's sums is not searched for: spheres would be
//! hardly smaller, and a ray at a character would take 3 to 10 % longer.

use arrayvec::ArrayVec;
use bdtree_format::{BONE_ROW_DEFECT, BONE_ROW_SPREAD, BoneEntry, LANES};

use crate::bones::{BoneMap, PosedBones, columns_of_eight};
use crate::bound::{Spheres, WideSpheres};
use crate::error::FormatError;
use crate::rounding::BONES_ROUNDING;
use crate::simd::{Lanes, Work};
use crate::view::{Asset, NodeBones};

/// Entries of a node of which places are kept; those of more are computed twice.
const PLACES: usize = 64;

impl Asset<'_> {
    /// Moves the spheres of node `index`, which are those without bones, to where bones carry them. Compiled once per
    /// instruction set, not into every walk.
    ///
    /// # Errors
    /// Entries of the node, or bones in them, that are not in the file.
    pub(crate) fn carry(
        &self,
        index: u32,
        pose: &PosedBones<'_>,
        spheres: &mut Spheres,
    ) -> Result<(), FormatError> {
        let skin = self.skin.as_ref();
        let node = skin.and_then(|skin| skin.node_bones(index as usize));
        let Some(node) = node else {
            return Err(self.bones_of_node(index));
        };
        let carried = self.kernel.run(Carry {
            node,
            pose,
            spheres,
        });
        carried.ok_or_else(|| self.unknown_bone_of_node(index))
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

/// The bones of an entry.
enum Bones<'m> {
    /// The same one in all lanes.
    One(&'m BoneMap),
    PerLane([&'m BoneMap; LANES]),
}

impl<'m> Bones<'m> {
    #[inline(always)]
    fn of(entry: &BoneEntry, maps: &'m [BoneMap]) -> Option<Self> {
        let [a, b, c, d, e, f, g, h] = *entry;
        let first = maps.get(usize::from(a))?;
        if *entry == [a; LANES] {
            return Some(Self::One(first));
        }
        Some(Self::PerLane([
            first,
            maps.get(usize::from(b))?,
            maps.get(usize::from(c))?,
            maps.get(usize::from(d))?,
            maps.get(usize::from(e))?,
            maps.get(usize::from(f))?,
            maps.get(usize::from(g))?,
            maps.get(usize::from(h))?,
        ]))
    }

    /// y = A c + t. Spelled out: a closure, and so `array::map`, would not be compiled with the instruction set of the
    /// caller.
    #[inline(always)]
    fn carry<L: Lanes>(&self, [x, y, z]: Points<L>) -> Points<L> {
        let mut carried = [x; 3];
        match self {
            Self::One(map) => {
                for r in 0..3 {
                    let [a, b, c, t] = map.rows[r];
                    let sum = x.mul(L::splat(a)).add(y.mul(L::splat(b)));
                    carried[r] = sum.add(z.mul(L::splat(c))).add(L::splat(t));
                }
            }
            Self::PerLane(maps) => {
                let [a, b, c, t] = columns_of_eight::<L>(*maps);
                for r in 0..3 {
                    let sum = x.mul(a[r]).add(y.mul(b[r]));
                    carried[r] = sum.add(z.mul(c[r])).add(t[r]);
                }
            }
        }
        carried
    }

    /// σ of each lane's bone.
    #[inline(always)]
    fn stretch<L: Lanes>(&self) -> L {
        match self {
            Self::One(map) => L::splat(map.stretch),
            Self::PerLane([a, b, c, d, e, f, g, h]) => L::load(&[
                a.stretch, b.stretch, c.stretch, d.stretch, e.stretch, f.stretch, g.stretch,
                h.stretch,
            ]),
        }
    }
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
    let defect = L::load(&node.fixed[BONE_ROW_DEFECT]);
    // c', and what the simplex shares: its corners are e + r d_b.
    let mut center = [zero; 3];
    let mut least = [zero; 3];
    let mut least_sum = zero;
    let mut stretch = zero;
    let mut places = ArrayVec::<Points<L>, PLACES>::new();
    for (entry, [middle, gap]) in node.entries.iter().zip(node.weights) {
        let bones = Bones::of(entry, pose.maps)?;
        let y = bones.carry(spheres.center);
        if !places.is_full() {
            places.push(y);
        }
        let (middle, gap) = (L::load(middle), L::load(gap));
        let low = middle.sub(gap).max(zero);
        center = add3(center, scaled(y, middle));
        least = add3(least, scaled(y, low));
        least_sum = least_sum.add(low);
        stretch = stretch.max(is_there(middle).mul(bones.stretch()));
    }
    let rest = one.sub(least_sum);
    let shift = sub3(least, scaled(center, least_sum));

    let mut farthest = zero;
    let mut corner = zero;
    let mut all = zero;
    for (k, (entry, [middle, gap])) in node.entries.iter().zip(node.weights).enumerate() {
        let y = match places.get(k) {
            Some(place) => *place,
            None => Bones::of(entry, pose.maps)?.carry(spheres.center),
        };
        let there = is_there(L::load(middle));
        let d = sub3(y, center);
        let length = squared(d).sqrt();
        farthest = farthest.max(there.mul(length));
        corner = corner.max(there.mul(squared(add3(shift, scaled(d, rest)))));
        all = all.add(L::load(gap).mul(length));
    }
    // λ = 0 and λ = the largest length.
    let knapsack = all.min(L::load(&node.fixed[BONE_ROW_SPREAD]).mul(farthest));
    let simplex = corner.sqrt().add(defect.mul(farthest));
    let moved = knapsack.min(simplex);
    let grown = one.add(defect).mul(stretch).mul(spheres.radius);
    let off = defect.mul(squared(center).sqrt());
    let m = node.entries.len() as f32;
    let rounding = L::splat(1.0 + BONES_ROUNDING * (m + 16.0));
    let slack = L::splat(pose.slack.base + m * pose.slack.per_bone);
    Some(WideSpheres {
        center,
        radius: grown.add(moved).add(off).mul(rounding).add(slack),
    })
}

/// 1 in the lanes that have a bone, whose middle weight is not 0, and 0 in the others: what is stored is 0 or at least
/// 2⁻¹²⁶.
#[inline(always)]
fn is_there<L: Lanes>(middle: L) -> L {
    middle
        .mul(L::splat(1.0 / f32::MIN_POSITIVE))
        .min(L::splat(1.0))
}
