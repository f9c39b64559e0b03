//! Pushing a reduced body: `Uᵀ f` of a force at a contact.

use bdtree_format::SectionKind;

use crate::contact::TriangleId;
use crate::error::{Datum, FormatError, OUT_LENGTH};
use crate::pose::Pose;

impl Pose<'_> {
    /// Adds the generalised force of a world force that acts on the material point `barycentric` of
    /// a triangle: `out[j] += Σ_k w_k (∂x_k/∂q_j)·f`, which for an instance at scale 1 is `Uᵀ f`, and with
    /// bones `Uᵀ Aᵀ f`, A being the linear part of the blended matrix. The modal equation of an elastic asset takes it as its
    /// right-hand side.
    ///
    /// `out` holds one number per mode. The force and the weights are not checked: NaN goes into `out`, and `set_q` refuses
    /// what comes of it.
    ///
    /// # Errors
    /// A triangle id that is not below [`Asset::triangle_count`](crate::Asset::triangle_count); `out` shorter than the
    /// mode count; a corrupt asset.
    pub fn add_generalized_force(
        &self,
        triangle: TriangleId,
        barycentric: [f64; 3],
        force: [f64; 3],
        out: &mut [f64],
    ) -> Result<(), FormatError> {
        let asset = self.asset;
        let corners = asset.triangle(triangle)?;
        let m = asset.mode_count();
        let found = out.len();
        let Some(out) = out.get_mut(..m) else {
            let place = asset.at(SectionKind::DISPLACEMENTS, 0);
            return Err(place.rule(OUT_LENGTH).broken(Datum::at_least(m), found));
        };
        // x = t + s Q (origin + unit p'), so ∂x/∂q_j · f = s unit U_ij · (Qᵀ f).
        let local = self.placement.inverse_rotate(force);
        let scale = self.placement.world_per_stored();
        for (corner, weight) in corners.iter().zip(barycentric) {
            // With bones U_ij is turned and stretched by the linear part of the blended matrix, so f is by its transpose.
            let local = match self.bones() {
                None => local,
                Some(bones) => {
                    let rows = asset.blended(bones, corner.0 as usize)?;
                    [0, 1, 2].map(|c| {
                        (0..3)
                            .map(|r| f64::from(rows[r][c]) * local[r])
                            .sum::<f64>()
                    })
                }
            };
            for (mode, u) in asset.displacements(*corner)?.iter() {
                let Some(out) = out.get_mut(mode) else {
                    return Err(asset.unknown_mode_of(*corner));
                };
                let [x, y, z] = u.map(f64::from);
                *out += weight * scale * (x * local[0] + y * local[1] + z * local[2]);
            }
        }
        Ok(())
    }
}
