//! A box around a mesh with bones: each blended vertex lies among where its bones alone would put it.

use zerocopy::little_endian::F32;

use crate::bones::BoneMap;
use crate::pose::Pose;
use crate::query::Aabb;
use crate::rounding::MARGIN;
use crate::simd::{Lanes, Quad, Work, dot3, splat3};
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

    /// The axes of the world are side by side, the fourth number is not used.
    #[inline(always)]
    fn run<L: Lanes>(self) -> (Span, Span) {
        let mut linear = [[L::Quad::splat(0.0); 3]; 3];
        for r in 0..3 {
            linear[r] = splat3(self.linear[r]);
        }
        let [x, y, z] = self.origin;
        let origin = L::Quad::load(&[x, y, z, 0.0]);
        let (mut whole, mut core) = (Extent::<L>::new(), Extent::<L>::new());
        let modes = self.q.len();
        for (bone, (record, map)) in self.skin.bones.iter().zip(self.maps).enumerate() {
            if record.low[0].get() > record.high[0].get() {
                continue; // it moves nothing
            }
            // Each column of the map in the world: rows first, whose four numbers lie side by side.
            let rows = [
                L::Quad::widen(&map.rows[0]),
                L::Quad::widen(&map.rows[1]),
                L::Quad::widen(&map.rows[2]),
            ];
            let columns = L::Quad::transposed([
                dot3(linear[0], rows),
                dot3(linear[1], rows),
                dot3(linear[2], rows),
                origin,
            ]);
            let [x, y, z, t] = columns;
            let axes = [x, y, z];
            let center = origin.add(t);
            let fields = self.skin.bone_fields.get(bone * modes..);
            let mut moved = 0.0;
            for (field, q) in fields.unwrap_or_default().iter().zip(self.q) {
                moved += f64::from(*field) * f64::from(q.abs());
            }
            let mut reach = L::Quad::splat(0.0);
            if moved > 0.0 {
                reach = dot3(axes, axes).sqrt().mul(L::Quad::splat(moved));
            }
            whole.hold(axes, center, reach, (&record.low, &record.high));
            if record.core_low[0].get() <= record.core_high[0].get() {
                core.hold(axes, center, reach, (&record.core_low, &record.core_high));
            }
        }
        (whole.span(), core.span())
    }
}

/// A [`Span`] in the making.
struct Extent<L: Lanes> {
    low: L::Quad,
    high: L::Quad,
}

impl<L: Lanes> Extent<L> {
    #[inline(always)]
    fn new() -> Self {
        Self {
            low: L::Quad::splat(f64::INFINITY),
            high: L::Quad::splat(f64::NEG_INFINITY),
        }
    }

    /// Holds the box between two corners, carried by `axes` to about `center`, and what is within `reach` of it.
    #[inline(always)]
    fn hold(
        &mut self,
        axes: [L::Quad; 3],
        center: L::Quad,
        reach: L::Quad,
        (low, high): (&[F32; 3], &[F32; 3]),
    ) {
        let (mut middle, mut half) = ([0.0; 3], [0.0; 3]);
        for c in 0..3 {
            let (least, most) = (f64::from(low[c].get()), f64::from(high[c].get()));
            (middle[c], half[c]) = (0.5 * (least + most), 0.5 * (most - least));
        }
        let [x, y, z] = axes;
        let center = center.add(dot3(axes, splat3(middle)));
        let reach = reach.add(dot3([x.abs(), y.abs(), z.abs()], splat3(half)));
        // NaN, of a damaged file, bounds nothing.
        self.low = self.low.min(center.sub(reach));
        self.high = center.add(reach).max(self.high);
    }

    #[inline(always)]
    fn span(self) -> Span {
        let ([a, b, c, _], [d, e, f, _]) = (self.low.store(), self.high.store());
        [[a, b, c], [d, e, f]]
    }
}
