//! A box around a mesh with bones: each blended vertex lies among where its bones alone would put it.

use bdtree_format::BoneRecord;

use crate::bones::{BoneMap, columns};
use crate::math::norm;
use crate::pose::Pose;
use crate::query::Aabb;
use crate::rounding::MARGIN;
use crate::simd::{Lanes, Quad, Quad3, Work, add3, dot3, four_of, scale3, splat3, sub3};
use crate::view::Skin;

impl Pose<'_> {
    /// The box in the world around the boxes of all bones, each carried by its map; `None` without bones, or where the
    /// numbers of a damaged file make none.
    ///
    /// With Σ_b w_b = 1 a vertex is a convex combination of the T_b x of its bones, and each T_b x lies in the carried box
    /// of all rest positions that bone b moves, which the displacements of q enlarge. All but a share of μ lie in carried
    /// core boxes, so a face lies at no more than that share of the way from the cores' to the others' (SPEC 7.8). Cost:
    /// one pass over the bones and, where they have any, their displacements.
    pub(crate) fn bone_box(&self) -> Option<Aabb> {
        let (skin, posed) = (self.asset.skin.as_ref()?, self.bones()?);
        let carried = Carried {
            linear: self.placement.linear(),
            origin: self.placement.origin_in_world(),
            skin,
            maps: posed.maps,
            q: self.q,
        };
        let (whole, core) = self.asset.kernel.run(carried);
        // Weights that do not sum to 1 move a vertex by |Σ w − 1| times what its bones reach; rounding moves it too. Of a
        // vertex without bones, at the origin, the sum is 0.
        let defect = f64::from(skin.record.weight_defect) * self.reach;
        let inner = f64::from(self.stretch) * f64::from(self.inner_slack);
        let stored = defect + inner + f64::from(self.slack) + self.placement.error(0.0, self.reach);
        let around = stored * self.placement.world_per_stored() * (1.0 + MARGIN);
        let share = f64::from(skin.record.minor_share);
        let face = |side: usize, axis: usize, outward: f64| {
            let (far, near) = (whole[side][axis], core[side][axis]);
            // A skin may be without any core box: then every weight is in the share.
            let x = if near.is_finite() {
                near + share * (far - near)
            } else {
                far
            };
            x + outward * (around + MARGIN * far.abs().max(x.abs()))
        };
        let aabb = Aabb {
            min: [0, 1, 2].map(|k| face(0, k, -1.0)),
            max: [0, 1, 2].map(|k| face(1, k, 1.0)),
        };
        let is_sound = (0..3).all(|k| aabb.min[k] <= aabb.max[k] && aabb.max[k] < f64::INFINITY);
        is_sound.then_some(aabb)
    }
}

/// Least and largest coordinates of something: the wrong way round and infinite of nothing.
type Span = [[f64; 3]; 2];

/// The carried boxes of all bones before rounding, then their carried core boxes.
struct Carried<'a> {
    /// From stored coordinates to the world.
    linear: [[f64; 3]; 3],
    origin: [f64; 3],
    skin: &'a Skin<'a>,
    maps: &'a [BoneMap],
    q: &'a [f32],
}

impl Work for Carried<'_> {
    type Output = (Span, Span);

    /// Four bones are side by side.
    #[inline(always)]
    fn run<L: Lanes>(self) -> (Span, Span) {
        let (mut whole, mut core) = (Extent::<L::Quad>::new(), Extent::<L::Quad>::new());
        let bones = self.skin.bones;
        let lengths = [
            norm(self.linear[0]),
            norm(self.linear[1]),
            norm(self.linear[2]),
        ];
        let mut first = 0;
        while let Some(four) = four_of(bones.len().min(self.maps.len()), first) {
            let [x, y, z, t] = columns::<L::Quad>(self.maps, four);
            let (whole_boxes, core_boxes) = boxes([
                &bones[four[0]],
                &bones[four[1]],
                &bones[four[2]],
                &bones[four[3]],
            ]);
            let moved = self.moved::<L::Quad>(four);
            for k in 0..3 {
                // Row k of the maps to the world.
                let linear = splat3(self.linear[k]);
                let row = [dot3(linear, x), dot3(linear, y), dot3(linear, z)];
                let center = L::Quad::splat(self.origin[k]).add(dot3(linear, t));
                let reach = moved.mul(L::Quad::splat(lengths[k]));
                whole.hold(k, row, center, reach, &whole_boxes);
                core.hold(k, row, center, reach, &core_boxes);
            }
            first += 4;
        }
        (whole.span(), core.span())
    }
}

impl Carried<'_> {
    /// How far from where four bones carry points at rest they carry them with q, at most (stored units). The largest
    /// stretch stands for that along each axis, which would be a root for each: they are the same where bones only turn.
    #[inline(always)]
    fn moved<Q: Quad>(&self, four: [usize; 4]) -> Q {
        let modes = self.q.len();
        let mut sums = [Q::splat(0.0); 4];
        if modes == 0 {
            return sums[0];
        }
        let (mut fields, mut stretch): ([&[f32]; 4], _) = ([&[]; 4], [0.0; 4]);
        for k in 0..4 {
            let own = self.skin.bone_fields.get(four[k] * modes..);
            fields[k] = own.unwrap_or_default();
            stretch[k] = self.maps[four[k]].stretch;
        }
        let [a, b, c, d] = fields;
        let (a, b) = (a.as_chunks::<4>().0, b.as_chunks::<4>().0);
        let (c, d) = (c.as_chunks::<4>().0, d.as_chunks::<4>().0);
        let (q, q_rest) = self.q.as_chunks::<4>();
        for ((((a, b), c), d), q) in a.iter().zip(b).zip(c).zip(d).zip(q) {
            let q = Q::widen(q).abs();
            sums[0] = sums[0].add(Q::widen(a).mul(q));
            sums[1] = sums[1].add(Q::widen(b).mul(q));
            sums[2] = sums[2].add(Q::widen(c).mul(q));
            sums[3] = sums[3].add(Q::widen(d).mul(q));
        }
        let [a, b, c, d] = Q::transposed(sums);
        let mut moved = a.add(b).add(c).add(d);
        for (q, mode) in q_rest.iter().zip(modes - q_rest.len()..) {
            let mut field = [0.0; 4];
            for k in 0..4 {
                field[k] = fields[k].get(mode).copied().unwrap_or_default();
            }
            moved = moved.add(Q::widen(&field).mul(Q::splat(f64::from(q.abs()))));
        }
        moved.mul(Q::widen(&stretch))
    }
}

/// Boxes of four bones.
struct Boxes<Q: Quad> {
    middle: Quad3<Q>,
    half: Quad3<Q>,
    /// Those that hold nothing.
    is_empty: Q::Mask,
}

impl<Q: Quad> Boxes<Q> {
    #[inline(always)]
    fn new(low: Quad3<Q>, high: Quad3<Q>) -> Self {
        let half = Q::splat(0.5);
        Self {
            middle: scale3(add3(low, high), half),
            half: scale3(sub3(high, low), half),
            is_empty: low[0].above(high[0]),
        }
    }
}

/// The boxes of all rest positions that four bones move, and their core boxes.
#[inline(always)]
fn boxes<Q: Quad>(records: [&BoneRecord; 4]) -> (Boxes<Q>, Boxes<Q>) {
    let mut rows = [[Q::splat(0.0); 4]; 3];
    for k in 0..4 {
        let [low, high] = [&records[k].low, &records[k].high];
        let [core_low, core_high] = [&records[k].core_low, &records[k].core_high];
        let numbers = [
            [&low[0], &low[1], &low[2], &high[0]],
            [&high[1], &high[2], &core_low[0], &core_low[1]],
            [&core_low[2], &core_high[0], &core_high[1], &core_high[2]],
        ];
        // Spelled out: `array::map` would not be compiled with the instruction set of the caller.
        for r in 0..3 {
            let [a, b, c, d] = numbers[r];
            rows[r][k] = Q::widen(&[a.get(), b.get(), c.get(), d.get()]);
        }
    }
    let [a, b, c, d] = Q::transposed(rows[0]);
    let [e, f, g, h] = Q::transposed(rows[1]);
    let [i, j, l, m] = Q::transposed(rows[2]);
    (
        Boxes::new([a, b, c], [d, e, f]),
        Boxes::new([g, h, i], [j, l, m]),
    )
}

/// A [`Span`] in the making, of every fourth bone.
struct Extent<Q> {
    low: Quad3<Q>,
    high: Quad3<Q>,
}

impl<Q: Quad> Extent<Q> {
    #[inline(always)]
    fn new() -> Self {
        Self {
            low: [Q::splat(f64::INFINITY); 3],
            high: [Q::splat(f64::NEG_INFINITY); 3],
        }
    }

    /// Holds along axis `k` what `row` carries of boxes to about `center`, and what is within `reach` of it.
    #[inline(always)]
    fn hold(&mut self, k: usize, row: Quad3<Q>, center: Q, reach: Q, boxes: &Boxes<Q>) {
        let center = center.add(dot3(row, boxes.middle));
        let [x, y, z] = row;
        let reach = reach.add(dot3([x.abs(), y.abs(), z.abs()], boxes.half));
        // A box that holds nothing is on the far side of everything. NaN, of a damaged file, bounds nothing.
        let reach = Q::select(boxes.is_empty, Q::splat(f64::NEG_INFINITY), reach);
        self.low[k] = self.low[k].min(center.sub(reach));
        self.high[k] = center.add(reach).max(self.high[k]);
    }

    #[inline(always)]
    fn span(self) -> Span {
        let mut span = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        for k in 0..3 {
            for x in self.low[k].store() {
                span[0][k] = x.min(span[0][k]);
            }
            for x in self.high[k].store() {
                span[1][k] = x.max(span[1][k]);
            }
        }
        span
    }
}
