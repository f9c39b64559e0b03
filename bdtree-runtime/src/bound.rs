//! The bound: eight child spheres of a node at q, from q alone.
//!
//! The paper's center and radius (eqs. 5–7) with our second-order radius
//!
//! ```text
//! c'(q)  = c + Σ_j Ū_j q_j
//! R'(q)² = R² + 2 Σ_j b_j |q_j| + s²,   s = Σ_j ΔR_j |q_j|,   b_j = b⁺_j if q_j > 0 else b⁻_j
//! ```
//!
//! which is never above the paper's R + s. Rows and q are whole numbers here, so the sums over modes
//! are exact: for two modes six instructions that multiply and add pairs, eight lanes at once.
//! Deviation from the paper: b± (docs/design/guarantees.md, the bound in exact arithmetic), because R + s grows under local rotations
//! and for bodies that shrink.

use bdtree_format::{ModePair, ROW_CENTER_X, ROW_CENTER_Y, ROW_CENTER_Z, ROW_RADIUS, Row};

use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

use crate::quantized_q::QuantizedQ;
use crate::rounding::{GAMMA, GAP_RADII};
use crate::simd::{Lanes, PairSums};
use crate::view::NodeRows;

/// Eight spheres, side by side (stored units, relative to the origin).
#[derive(Debug, Clone, Copy, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub struct Spheres {
    /// Centers.
    pub center: [Row; 3],
    /// Radii: rounding slack included; NaN where the radicand came out negative, which every
    /// test reads as "visit".
    pub radius: Row,
}

/// [`Spheres`] still in registers.
#[derive(Clone, Copy)]
pub(crate) struct WideSpheres<V> {
    pub(crate) center: [V; 3],
    pub(crate) radius: V,
}

impl<V: Lanes> WideSpheres<V> {
    /// Spheres of radius 0, where others are to be put.
    #[inline(always)]
    pub(crate) fn empty() -> Self {
        let zero = V::splat(0.0);
        Self {
            center: [zero; 3],
            radius: zero,
        }
    }

    #[inline(always)]
    pub(crate) fn load(spheres: &Spheres) -> Self {
        let [x, y, z] = &spheres.center;
        Self {
            center: [V::load(x), V::load(y), V::load(z)],
            radius: V::load(&spheres.radius),
        }
    }

    /// The same centers with radii larger by `added`.
    #[inline(always)]
    pub(crate) fn grown(self, added: V) -> Self {
        Self {
            radius: self.radius.add(added),
            ..self
        }
    }

    #[inline(always)]
    pub(crate) fn store(self) -> Spheres {
        let [x, y, z] = self.center;
        Spheres {
            center: [x.store(), y.store(), z.store()],
            radius: self.radius.store(),
        }
    }

    /// The lanes that are not certainly farther than `reach` from `point`; `skip` is below 1 by
    /// the relative error of this test. NaN is not far.
    #[inline(always)]
    pub(crate) fn within(self, point: [f32; 3], reach: f32, skip: f32) -> u8 {
        let dx = self.center[0].sub(V::splat(point[0]));
        let dy = self.center[1].sub(V::splat(point[1]));
        let dz = self.center[2].sub(V::splat(point[2]));
        let reach = self.radius.add(V::splat(reach));
        let squared = dx.mul(dx).add(dy.mul(dy)).add(dz.mul(dz));
        !squared.mul(V::splat(skip)).above(reach.mul(reach))
    }

    /// Per lane a lower bound of the distance to another sphere, where it is positive; negative the
    /// deeper they overlap, NaN where nothing is known. `shrink` is below 1 by the relative error of
    /// the computation.
    #[inline(always)]
    pub(crate) fn gaps(self, [x, y, z, radius]: [f32; 4], shrink: f32) -> V {
        let dx = self.center[0].sub(V::splat(x));
        let dy = self.center[1].sub(V::splat(y));
        let dz = self.center[2].sub(V::splat(z));
        let squared = dx.mul(dx).add(dy.mul(dy)).add(dz.mul(dz));
        let reach = self.radius.add(V::splat(radius));
        squared.sqrt().mul(V::splat(shrink)).sub(reach)
    }

    /// Per lane how far all of it lies beyond all of another sphere along `direction` (unit), less
    /// what rounding takes from the radii.
    #[inline(always)]
    pub(crate) fn gaps_along(self, direction: [f32; 3], [x, y, z, radius]: [f32; 4]) -> V {
        let dx = self.center[0].sub(V::splat(x)).mul(V::splat(direction[0]));
        let dy = self.center[1].sub(V::splat(y)).mul(V::splat(direction[1]));
        let dz = self.center[2].sub(V::splat(z)).mul(V::splat(direction[2]));
        let reach = self.radius.add(V::splat(radius)).mul(V::splat(GAP_RADII));
        dx.add(dy).add(dz).sub(reach)
    }

    /// Per lane how far the sphere reaches along `direction` (not longer than 1), counting `share` of its
    /// radius.
    #[inline(always)]
    pub(crate) fn heights(self, [x, y, z]: [f32; 3], share: f32) -> V {
        let [cx, cy, cz] = self.center;
        let along = cx.mul(V::splat(x)).add(cy.mul(V::splat(y)));
        let along = along.add(cz.mul(V::splat(z)));
        along.add(self.radius.mul(V::splat(share)))
    }

    /// The spheres moved by a linear map given by its rows and an offset; radii times `factor` plus
    /// `extra`.
    #[inline(always)]
    pub(crate) fn mapped(
        self,
        linear: &[[f32; 3]; 3],
        offset: [f32; 3],
        factor: f32,
        extra: f32,
    ) -> Self {
        let [x, y, z] = self.center;
        let mut center = self.center;
        for i in 0..3 {
            let row = &linear[i];
            let sum = x.mul(V::splat(row[0])).add(y.mul(V::splat(row[1])));
            center[i] = sum.add(z.mul(V::splat(row[2]))).add(V::splat(offset[i]));
        }
        Self {
            center,
            radius: self.radius.mul(V::splat(factor)).add(V::splat(extra)),
        }
    }
}

/// What of a pose a node needs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BoundPose<'p> {
    /// q̃: q in whole numbers.
    pub(crate) quantized: QuantizedQ<'p>,
    /// Absolute error of center, root and deformed vertices before bones, and what q̃ is off (stored units).
    pub(crate) slack: f32,
}

/// The spheres of a node's eight lanes at q, of the same bits on every processor; `None` when the rows and the mode list `modes` do
/// not fit the pose (a corrupt file).
///
/// Cost: 6 sums of two products per lane and pair of modes, and one pass over the rows (two for a
/// pose in two parts), whatever the mesh.
#[inline(always)]
pub(crate) fn evaluate<V: Lanes>(
    rows: &NodeRows<'_>,
    modes: &[u16],
    pose: &BoundPose<'_>,
) -> Option<WideSpheres<V>> {
    let leading = rows.leading;
    let shares = &pose.quantized;
    let mut sums = Sums::<V>::of(rows.pairs, modes, shares, shares.coarse)?.rounded();
    if !shares.fine.is_empty() {
        let fine = Sums::<V>::of(rows.pairs, modes, shares, shares.fine)?.rounded();
        let ratio = V::splat(shares.ratio);
        for k in 0..5 {
            sums[k] = sums[k].add(fine[k].mul(ratio));
        }
    }
    // Whole numbers become shares of the limits, then lengths. In this order: a unit may be so small
    // that its product with the scale vanishes.
    let scale = V::splat(shares.scale);
    let unit = [
        V::splat(rows.units[0]),
        V::splat(rows.units[1]),
        V::splat(rows.units[2]),
    ];
    let growth = sums[3].mul(scale).mul(unit[1]);
    let cross = sums[4].mul(scale).mul(unit[2]);
    let x = sums[0].mul(scale);
    let y = sums[1].mul(scale);
    let z = sums[2].mul(scale);
    let x = V::load(&leading[ROW_CENTER_X]).add(x.mul(unit[0]));
    let y = V::load(&leading[ROW_CENTER_Y]).add(y.mul(unit[0]));
    let z = V::load(&leading[ROW_CENTER_Z]).add(z.mul(unit[0]));
    let rest_radius = V::load(&leading[ROW_RADIUS]);
    // R² + 2 Σ b|q| + s² + γ' T²: the terms cancel when the node shrinks, T² = (R + s)² does not.
    let total = rest_radius.add(growth);
    let radicand = rest_radius
        .mul(rest_radius)
        .add(cross.add(cross))
        .add(growth.mul(growth))
        .add(total.mul(total).mul(V::splat(GAMMA)));
    let radius = radicand.sqrt().add(V::splat(pose.slack));
    Some(WideSpheres {
        center: [x, y, z],
        radius,
    })
}

/// Running sums over modes: exact, in whole numbers (SPEC 5.6).
#[derive(Clone, Copy)]
struct Sums<V: Lanes> {
    /// Σ Ū_j n_j.
    center: [V::Sums; 3],
    /// Σ ΔR_j |n_j|.
    growth: V::Sums,
    /// Σ b⁺_j max(n_j, 0) and Σ b⁻_j max(−n_j, 0).
    cross: [V::Sums; 2],
}

impl<V: Lanes> Sums<V> {
    /// The sums over the modes `modes` of a node, with `numbers` (of `shares`) as n.
    #[inline(always)]
    fn of(
        pairs: &[ModePair],
        modes: &[u16],
        shares: &QuantizedQ<'_>,
        numbers: &[[i16; 2]],
    ) -> Option<Self> {
        let zero = V::Sums::zero();
        let mut sums = Self {
            center: [zero; 3],
            growth: zero,
            cross: [zero; 2],
        };
        if modes.len() == shares.mode_count {
            // The node has all modes, in the order of the pose.
            for k in shares.active {
                let k = *k as usize;
                sums.add_pair(pairs.get(k)?, *numbers.get(k)?);
            }
            return Some(sums);
        }
        let numbers = numbers.as_flattened().get(..shares.mode_count)?;
        let (listed, last) = modes.as_chunks::<2>();
        for (pair, [a, b]) in pairs.iter().zip(listed) {
            let a = *numbers.get(usize::from(*a))?;
            let b = *numbers.get(usize::from(*b))?;
            sums.add_pair(pair, [a, b]);
        }
        if let [a] = last {
            let a = *numbers.get(usize::from(*a))?;
            sums.add_pair(pairs.get(listed.len())?, [a, 0]);
        }
        Some(sums)
    }

    #[inline(always)]
    fn add_pair(&mut self, pair: &ModePair, n: [i16; 2]) {
        let [n, magnitude, positive, negative] = V::Sums::factors(n);
        for k in 0..3 {
            self.center[k] = self.center[k].add_products(&pair.center[k], n);
        }
        self.growth = self.growth.add_products(&pair.growth, magnitude);
        self.cross[0] = self.cross[0].add_products(&pair.cross[0], positive);
        self.cross[1] = self.cross[1].add_products(&pair.cross[1], negative);
    }

    /// Σ Ū_j n_j, Σ ΔR_j |n_j| and Σ b_j |n_j|, rounded to f32.
    #[inline(always)]
    fn rounded(self) -> [V; 5] {
        let [x, y, z] = self.center;
        [
            V::round(x),
            V::round(y),
            V::round(z),
            V::round(self.growth),
            V::round(self.cross[0].add(self.cross[1])),
        ]
    }
}
