//! Which joint a hit belongs to, and with which weights bones carry it.

use crate::contact::TriangleId;
use crate::error::FormatError;
use crate::view::Asset;

impl<'a> Asset<'a> {
    /// The bones that carry the point `barycentric` of a triangle, with their weights there: those of the first corner,
    /// then those of the others, so a bone may come up to three times; its shares add up. None without a skin. Hits and
    /// contacts have both arguments.
    ///
    /// # Errors
    /// An unknown triangle, a corrupt asset.
    pub fn bone_weights_at(
        &self,
        triangle: TriangleId,
        barycentric: [f64; 3],
    ) -> Result<impl Iterator<Item = (usize, f64)> + Clone + use<'a>, FormatError> {
        let [a, b, c] = self.triangle(triangle)?;
        let of = [
            self.influences(a)?,
            self.influences(b)?,
            self.influences(c)?,
        ];
        let corners = of.into_iter().zip(barycentric);
        Ok(corners.flat_map(|(influences, share)| {
            influences.iter().map(move |influence| {
                (
                    usize::from(influence.bone),
                    share * f64::from(influence.weight),
                )
            })
        }))
    }

    /// The joint that carries most of the point `barycentric` of a triangle: that of the largest weight, of equal ones the
    /// lowest index; `None` without a skin or where no bone moves the point.
    ///
    /// # Errors
    /// An unknown triangle, a corrupt asset.
    pub fn joint_of(
        &self,
        triangle: TriangleId,
        barycentric: [f64; 3],
    ) -> Result<Option<usize>, FormatError> {
        let bones = self.bones();
        let joints = self
            .bone_weights_at(triangle, barycentric)?
            .filter_map(|(bone, weight)| Some((bones.get(bone)?.joint.get() as usize, weight)));
        let mut best: Option<(f64, usize)> = None;
        for (joint, _) in joints.clone() {
            // Few enough to be added up for each, which needs no memory.
            let own = joints.clone().filter(|(other, _)| *other == joint);
            let sum: f64 = own.map(|(_, weight)| weight).sum();
            let better = |(most, first)| sum > most || (sum == most && joint < first);
            if sum > 0.0 && best.is_none_or(better) {
                best = Some((sum, joint));
            }
        }
        Ok(best.map(|(_, joint)| joint))
    }
}
