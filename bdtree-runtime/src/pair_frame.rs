//! Stored coordinates of one placed asset seen from another.

use crate::bound::WideSpheres;
use crate::cache::Posed;
use crate::math::{norm, scale};
use crate::rounding::{BODIES_APART, FRAMED_MAX, HEIGHT_MARGIN, MAPPED, RADIUS_SCALE, round_up};
use crate::simd::Lanes;

/// What maps stored coordinates of a second asset to those of a first, in f64.
pub(crate) struct PairMap {
    /// World units per stored unit of the first.
    pub(crate) unit_a: f64,
    /// Stored units of the first per stored unit of the second.
    scale: f64,
    /// Rows of s·R.
    linear: [[f64; 3]; 3],
    /// Where the second's origin lies, in stored coordinates of the first.
    pub(crate) offset: [f64; 3],
    /// The first's vertices and lane centers are this near to its origin, slack included.
    pub(crate) reach_a: f64,
    /// The second's likewise, in stored units of the first.
    pub(crate) reach_b: f64,
    /// Errors of f64 on both sides (stored units of the first).
    pub(crate) exact: f64,
    /// Error of s·R rounded to f32 and applied in f32; what the offset adds is 16u of its length
    /// (docs/design/guarantees.md, `PairFrame`).
    pub(crate) turned: f64,
}

impl PairMap {
    pub(crate) fn new(a: &Posed<'_>, b: &Posed<'_>) -> Self {
        let (fa, fb) = (&a.pose.placement, &b.pose.placement);
        let ([far_a, slack_a], [far_b, slack_b]) = (a.reach_and_slack(), b.reach_and_slack());
        let unit_a = fa.world_per_stored();
        let s = fb.world_per_stored() / unit_a;
        let origin_a = fa.origin_in_world();
        let origin_b = fb.origin_in_world();
        let offset = fa.point_to_stored(origin_b);
        // Column k of s·R: where the second asset's axis k points, in the first's axes.
        let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            .map(|axis| scale(fa.inverse_rotate(fb.rotate(axis)), s));
        let linear = [0, 1, 2].map(|i| columns.map(|column| column[i]));

        // Each side's coordinates and corners, in stored units of the first.
        let norms =
            norm(origin_a) + unit_a * far_a + norm(origin_b) + fb.world_per_stored() * far_b;
        let exact = fa.error(norms, far_a) + s * fb.error(norms, far_b);
        const SQRT_3: f64 = 1.732_050_807_568_877_3;
        Self {
            unit_a,
            scale: s,
            linear,
            offset,
            reach_a: slack_a + far_a,
            reach_b: s * (slack_b + far_b),
            exact,
            turned: MAPPED * SQRT_3 * s * far_b,
        }
    }

    /// The map in f32, its radii larger by `extra`.
    pub(crate) fn rounded(&self, offset: [f64; 3], extra: f64) -> PairFrame {
        PairFrame {
            linear: self.linear.map(|row| row.map(|x| x as f32)),
            offset: offset.map(|x| x as f32),
            radius_scale: round_up(self.scale * RADIUS_SCALE),
            radius_extra: round_up(extra),
            reach: round_up(self.reach_a.max(norm(offset) + self.reach_b) + extra),
        }
    }
}

/// Stored coordinates of a second asset in those of a first, for node spheres.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PairFrame {
    /// Rows of s·R, rounded to f32.
    linear: [[f32; 3]; 3],
    /// Rounded to f32.
    offset: [f32; 3],
    /// σ = s (1 + 2⁻²²), rounded up.
    radius_scale: f32,
    /// Added to every radius of the second asset: errors of the map, f64 errors on both sides,
    /// and the tolerance (stored units of the first).
    radius_extra: f32,
    /// No vertex or lane center of either is farther from the first's origin.
    reach: f32,
}

impl PairFrame {
    /// The map for a pair of poses, or `None` when the two deformed meshes are certainly farther
    /// apart than `tolerance` (world units).
    pub(crate) fn new(a: &Posed<'_>, b: &Posed<'_>, tolerance: f64) -> Option<Self> {
        Self::nearer_than(0.0, a, b, tolerance)
    }

    /// The same for a walk that ends at spheres. They reach beyond the meshes, and nothing limits their radii, so the walk
    /// itself finds them apart; `None` only where f32 could not hold what lies between.
    pub(crate) fn of_spheres(a: &Posed<'_>, b: &Posed<'_>, tolerance: f64) -> Option<Self> {
        Self::nearer_than(FRAMED_MAX, a, b, tolerance)
    }

    /// The map, or `None` where the origins are farther apart than `least` and the meshes than `tolerance`.
    fn nearer_than(least: f64, a: &Posed<'_>, b: &Posed<'_>, tolerance: f64) -> Option<Self> {
        let map = PairMap::new(a, b);
        let extra = tolerance / map.unit_a + map.exact + map.turned + MAPPED * norm(map.offset);
        let reach = map.reach_a + map.reach_b + extra;
        if norm(map.offset) > (reach * BODIES_APART).max(least) {
            return None;
        }
        Some(map.rounded(map.offset, extra))
    }

    /// More than what rounding takes from the difference of two heights along a direction that is not
    /// longer than 1 (docs/design/guarantees.md, planes between meshes).
    pub(crate) fn height_margin(&self) -> f32 {
        self.reach * HEIGHT_MARGIN
    }

    /// Spheres of the second asset in the frame of the first.
    #[inline(always)]
    pub(crate) fn carry<L: Lanes>(&self, spheres: WideSpheres<L>) -> WideSpheres<L> {
        spheres.mapped(
            &self.linear,
            self.offset,
            self.radius_scale,
            self.radius_extra,
        )
    }
}
