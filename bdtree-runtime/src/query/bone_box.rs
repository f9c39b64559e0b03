//! A box around a mesh with bones: each blended vertex lies among where its bones alone would put it.

use crate::math::{dot, norm};
use crate::pose::Pose;
use crate::query::Aabb;
use crate::rounding::MARGIN;

impl Pose<'_> {
    /// The box in the world around the boxes of all bones, each carried by its map; `None` without bones, or where the
    /// numbers of a damaged file make none.
    ///
    /// With Σ_b w_b = 1 a vertex is a convex combination of the T_b x of its bones, and each T_b x lies in the carried box
    /// of all rest positions that bone b moves, which the displacements of q enlarge. Cost: one pass over the bones and,
    /// where they have any, their displacements.
    pub(crate) fn bone_box(&self) -> Option<Aabb> {
        let (skin, posed) = (self.asset.skin.as_ref()?, self.bones()?);
        let (linear, origin) = (self.placement.linear(), self.placement.origin_in_world());
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        let modes = self.q.len();
        for (bone, (record, map)) in skin.bones.iter().zip(posed.maps).enumerate() {
            let (least, most) = (record.low.map(|x| x.get()), record.high.map(|x| x.get()));
            if least[0] > most[0] {
                continue; // it moves nothing
            }
            let middle = [0, 1, 2].map(|c| 0.5 * (f64::from(least[c]) + f64::from(most[c])));
            let half = [0, 1, 2].map(|c| 0.5 * (f64::from(most[c]) - f64::from(least[c])));
            let fields = skin.bone_fields.get(bone * modes..).unwrap_or_default();
            let moved: f64 = fields
                .iter()
                .zip(self.q)
                .map(|(field, q)| f64::from(*field) * f64::from(q.abs()))
                .sum();
            let rows = map.rows.map(|row| row.map(f64::from));
            let column = |c: usize| [rows[0][c], rows[1][c], rows[2][c]];
            let [x, y, z, t] = [column(0), column(1), column(2), column(3)];
            for axis in 0..3 {
                let to = linear[axis];
                let row = [dot(to, x), dot(to, y), dot(to, z)];
                let center = origin[axis] + dot(row, middle) + dot(to, t);
                let mut reach = dot(row.map(f64::abs), half);
                if moved > 0.0 {
                    reach += norm(row) * moved;
                }
                low[axis] = low[axis].min(center - reach);
                high[axis] = high[axis].max(center + reach);
            }
        }
        // Weights that do not sum to 1 move a vertex by |Σ w − 1| times what its bones reach; rounding moves it too. Of a
        // vertex without bones, at the origin, the sum is 0.
        let defect = f64::from(skin.record.weight_defect) * self.reach;
        let inner = f64::from(self.stretch) * f64::from(self.inner_slack);
        let stored = defect + inner + f64::from(self.slack) + self.placement.error(0.0, self.reach);
        let around = stored * self.placement.world_per_stored() * (1.0 + MARGIN);
        let rounded = |x: f64| around + MARGIN * x.abs();
        let aabb = Aabb {
            min: low.map(|x| x - rounded(x)),
            max: high.map(|x| x + rounded(x)),
        };
        let is_sound = (0..3).all(|k| aabb.min[k] <= aabb.max[k] && aabb.max[k] < f64::INFINITY);
        is_sound.then_some(aabb)
    }
}
