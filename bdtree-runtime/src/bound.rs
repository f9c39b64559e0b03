//! The bound: eight child spheres of a node at q, from q alone.
//!
//! The paper's centre and radius (eqs. 5–7) with our second-order radius
//!
//! ```text
//! c'(q)  = c + Σ_j Ū_j q_j
//! R'(q)² = R² + 2 Σ_j b_j |q_j| + s²,   s = Σ_j ΔR_j |q_j|,   b_j = b⁺_j if q_j > 0 else b⁻_j
//! ```
//!
//! which is never above the paper's R + s: per mode five multiply-adds and eight lanes at once.
//! Deviation from the paper: b± (docs/guarantees.md 2), because R + s grows under local rotations
//! and for bodies that shrink.

use bdtree_format::{ModeRows, ROW_CENTRE_X, ROW_CENTRE_Y, ROW_CENTRE_Z, ROW_RADIUS, Row};

use crate::simd::Lanes;
use crate::view::NodeRows;

/// Eight spheres, side by side (stored units, relative to the origin).
#[derive(Debug, Clone, Copy)]
pub struct Spheres {
    /// Centres.
    pub centre: [Row; 3],
    /// Radii: rounding slack included; NaN where the radicand came out negative, which every
    /// test reads as "visit".
    pub radius: Row,
}

/// [`Spheres`] still in registers.
#[derive(Clone, Copy)]
pub(crate) struct WideSpheres<V> {
    centre: [V; 3],
    radius: V,
}

impl<V: Lanes> WideSpheres<V> {
    #[inline(always)]
    pub(crate) fn store(self) -> Spheres {
        let [x, y, z] = self.centre;
        Spheres {
            centre: [x.store(), y.store(), z.store()],
            radius: self.radius.store(),
        }
    }

    /// The lanes that are not certainly farther than `reach` from `point`; `skip` is below 1 by
    /// the relative error of this test. NaN is not far.
    #[inline(always)]
    pub(crate) fn within(self, point: [f32; 3], reach: f32, skip: f32) -> u8 {
        let dx = self.centre[0].sub(V::splat(point[0]));
        let dy = self.centre[1].sub(V::splat(point[1]));
        let dz = self.centre[2].sub(V::splat(point[2]));
        let reach = self.radius.add(V::splat(reach));
        let squared = dx.mul(dx).add(dy.mul(dy)).add(dz.mul(dz));
        !squared.mul(V::splat(skip)).above(reach.mul(reach))
    }
}

/// What of a pose a node needs.
#[derive(Debug, Clone, Copy)]
pub struct BoundPose<'p> {
    /// q_j over its limit: each 0 or between 2⁻¹⁰⁰ and 1.
    pub share: &'p [f32],
    /// γ' (docs/guarantees.md): relative error of the radicand.
    pub gamma: f32,
    /// Absolute error of centre, root and deformed vertices (stored units).
    pub slack: f32,
}

/// The spheres of a node's eight lanes at q; `None` when the rows and the mode list `modes` do
/// not fit the pose (a corrupt file).
///
/// Cost: 10 m flops per lane and one pass over the rows, whatever the mesh.
#[inline(always)]
pub(crate) fn evaluate<V: Lanes>(
    rows: &NodeRows<'_>,
    modes: &[u16],
    pose: &BoundPose<'_>,
) -> Option<WideSpheres<V>> {
    let leading = rows.leading;
    let per_mode = rows.modes.get(..modes.len())?;

    // Two sums of every second mode each: the additions of one alone would wait for each other.
    let mut sums = [Sums::<V>::zero(); 2];
    let (row_pairs, row_last) = per_mode.as_chunks::<2>();
    let (mode_pairs, mode_last) = modes.as_chunks::<2>();
    for (rows, modes) in row_pairs.iter().zip(mode_pairs) {
        for k in 0..2 {
            sums[k].add_mode(&rows[k], *pose.share.get(usize::from(modes[k]))?);
        }
    }
    for (rows, mode) in row_last.iter().zip(mode_last) {
        sums[0].add_mode(rows, *pose.share.get(usize::from(*mode))?);
    }
    // Sums of whole numbers times q, which become lengths by one power of two for all modes.
    let [even, odd] = sums;
    let [centre_unit, growth_unit, cross_unit] = rows.units;
    // Spelled out: closures are not compiled with the instruction set of the caller.
    let unit = V::splat(centre_unit);
    let centre = [
        even.centre[0].add(odd.centre[0]),
        even.centre[1].add(odd.centre[1]),
        even.centre[2].add(odd.centre[2]),
    ];
    let growth = even.growth.add(odd.growth).mul(V::splat(growth_unit));
    let cross = even.cross.add(odd.cross).mul(V::splat(cross_unit));
    // c last: with c first its rounding error would be M u P instead of u P.
    let x = centre[0].mul_add(unit, V::load(&leading[ROW_CENTRE_X]));
    let y = centre[1].mul_add(unit, V::load(&leading[ROW_CENTRE_Y]));
    let z = centre[2].mul_add(unit, V::load(&leading[ROW_CENTRE_Z]));
    let rest_radius = V::load(&leading[ROW_RADIUS]);
    // R² + 2 Σ b|q| + s² + γ' T²: the terms cancel when the node shrinks, T² = (R + s)² does not.
    let total = rest_radius.add(growth);
    let radicand = rest_radius
        .mul(rest_radius)
        .add(cross.add(cross))
        .add(growth.mul(growth))
        .add(total.mul(total).mul(V::splat(pose.gamma)));
    let radius = radicand.sqrt().add(V::splat(pose.slack));
    Some(WideSpheres {
        centre: [x, y, z],
        radius,
    })
}

/// Running sums over modes.
#[derive(Clone, Copy)]
struct Sums<V> {
    /// Σ Ū_j q_j.
    centre: [V; 3],
    /// Σ ΔR_j |q_j|.
    growth: V,
    /// Σ b_j |q_j|.
    cross: V,
}

impl<V: Lanes> Sums<V> {
    #[inline(always)]
    fn zero() -> Self {
        let zero = V::splat(0.0);
        Self {
            centre: [zero; 3],
            growth: zero,
            cross: zero,
        }
    }

    #[inline(always)]
    fn add_mode(&mut self, rows: &ModeRows, share: f32) {
        let q = V::splat(share);
        let q_abs = V::splat(share.abs());
        // Chosen by index, not by a branch: the signs of a new q cannot be predicted.
        let b = &rows.cross[usize::from(share.is_sign_negative())];
        for k in 0..3 {
            self.centre[k] = V::widen(&rows.centre[k]).mul_add(q, self.centre[k]);
        }
        self.growth = V::widen_unsigned(&rows.growth).mul_add(q_abs, self.growth);
        self.cross = V::widen(b).mul_add(q_abs, self.cross);
    }
}
