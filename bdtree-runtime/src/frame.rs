//! World ↔ stored coordinates of one placed asset, in f64, with a bound of the error.

use crate::bound::WideSpheres;
use crate::cache::Posed;
use crate::math::{add, dot, length_bound, norm, scale, sqrt, sub};
use crate::pose::Transform;
use crate::rounding::{BODIES_APART, HEIGHT_MARGIN, MAPPED, MAPS, RADIUS_SCALE, round_up};
use crate::simd::{Lanes, Quad, Quad3, add3, dot3, scale3, splat3};
use crate::view::Asset;

/// The placement of one asset.
///
/// Leaves use [`Frame::world`], the leaf arithmetic that defines the deformed mesh. Node
/// tests run in stored units, where f32 serves; the maps to and from there only have to be as
/// good as [`Frame::error`] says.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    /// Rows of the rotation matrix Q.
    rotation: [[f64; 3]; 3],
    translation: [f64; 3],
    scale: f64,
    origin: [f64; 3],
    /// Mesh units per stored unit.
    unit: f64,
    /// 1 / scale.
    per_scale: f64,
    /// 1 / unit.
    per_unit: f64,
}

impl Frame {
    pub(crate) fn new(asset: &Asset<'_>, transform: &Transform) -> Self {
        Self {
            rotation: rotation_matrix(transform.rotation),
            translation: transform.translation,
            scale: transform.scale,
            origin: asset.origin(),
            unit: asset.unit(),
            per_scale: 1.0 / transform.scale,
            per_unit: 1.0 / asset.unit(),
        }
    }

    /// The leaf arithmetic's second half: `x = t + s·(Q·(origin + p'))`, every operation rounded
    /// once, in f64 (docs/guarantees.md; SPEC 5.5).
    #[inline(always)]
    pub(crate) fn world(&self, p: [f32; 3]) -> [f64; 3] {
        let p = [f64::from(p[0]), f64::from(p[1]), f64::from(p[2])];
        let mesh = add(self.origin, scale(p, self.unit));
        let [x, y, z] = self.rotation;
        let turned = [dot(x, mesh), dot(y, mesh), dot(z, mesh)];
        add(self.translation, scale(turned, self.scale))
    }

    /// [`Frame::world`] for four points: the same bits.
    #[inline(always)]
    pub(crate) fn world_four<Q: Quad>(&self, p: &[[f32; 4]; 3]) -> Quad3<Q> {
        let p = [Q::widen(&p[0]), Q::widen(&p[1]), Q::widen(&p[2])];
        let mesh = add3(splat3(self.origin), scale3(p, Q::splat(self.unit)));
        let [x, y, z] = self.rotation;
        let turned = [
            dot3(splat3(x), mesh),
            dot3(splat3(y), mesh),
            dot3(splat3(z), mesh),
        ];
        add3(
            splat3(self.translation),
            scale3(turned, Q::splat(self.scale)),
        )
    }

    /// How far a point within `reach` of the stored origin comes, at most, when it keeps its stored
    /// coordinates and the placement changes from `from` to this one; with the errors of both
    /// (world units).
    pub(crate) fn moved(&self, from: &Self, reach_from: f64, reach: f64) -> f64 {
        let origin = norm(sub(self.origin_in_world(), from.origin_in_world()));
        let mut square = 0.0;
        for (row, row_from) in self.rotation.iter().zip(&from.rotation) {
            let change = sub(scale(*row, self.scale), scale(*row_from, from.scale));
            square += dot(change, change);
        }
        // The Frobenius norm is not below the spectral one.
        let turned = sqrt(square) * self.unit * reach_from;
        let errors = self.error(0.0, reach) * self.world_per_stored()
            + from.error(0.0, reach_from) * from.world_per_stored();
        (origin + turned) * (1.0 + MAPS) + errors
    }

    /// Numbers that tell placements apart.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = f64> {
        let rotation = self.rotation;
        let rest = [self.scale, self.unit];
        rotation
            .into_iter()
            .chain([self.translation, self.origin])
            .flatten()
            .chain(rest)
    }

    /// Linear part and offset of the map from stored coordinates to the world seen from `from`.
    #[cfg(feature = "wgpu")]
    pub(crate) fn matrix(&self, from: [f64; 3]) -> ([[f64; 3]; 3], [f64; 3]) {
        let factor = self.world_per_stored();
        let linear = self.rotation.map(|row| scale(row, factor));
        (linear, sub(self.origin_in_world(), from))
    }

    /// World units per stored unit.
    pub(crate) fn world_per_stored(&self) -> f64 {
        self.scale * self.unit
    }

    /// A world point in stored coordinates, within [`Frame::error`].
    pub(crate) fn point_to_stored(&self, x: [f64; 3]) -> [f64; 3] {
        let rotated = self.inverse_rotate(sub(x, self.translation));
        scale(
            sub(scale(rotated, self.per_scale), self.origin),
            self.per_unit,
        )
    }

    /// A world direction in stored axes; its length is kept.
    pub(crate) fn inverse_rotate(&self, v: [f64; 3]) -> [f64; 3] {
        let r = &self.rotation;
        [0, 1, 2].map(|i| r[0][i] * v[0] + r[1][i] * v[1] + r[2][i] * v[2])
    }

    /// A stored direction in world axes; its length is kept.
    pub(crate) fn rotate(&self, v: [f64; 3]) -> [f64; 3] {
        self.rotation.map(|row| dot(row, v))
    }

    /// The world position of the origin of stored coordinates.
    pub(crate) fn origin_in_world(&self) -> [f64; 3] {
        self.world([0.0; 3])
    }

    /// Bound, in stored units, of all f64 errors between a world point of norm `x_norm`, its
    /// stored coordinates, the world corners of vertices within `reach` of the stored origin and
    /// distances between them.
    pub(crate) fn error(&self, x_norm: f64, reach: f64) -> f64 {
        let world =
            x_norm + length_bound(self.translation) + self.scale * length_bound(self.origin);
        MAPS * (world / self.world_per_stored() + reach)
    }
}

/// The matrix of a unit quaternion (x, y, z, w).
pub(crate) fn rotation_matrix([x, y, z, w]: [f64; 4]) -> [[f64; 3]; 3] {
    [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - w * z),
            2.0 * (x * z + w * y),
        ],
        [
            2.0 * (x * y + w * z),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - w * x),
        ],
        [
            2.0 * (x * z - w * y),
            2.0 * (y * z + w * x),
            1.0 - 2.0 * (x * x + y * y),
        ],
    ]
}

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
    /// The first's vertices and lane centres are this near to its origin, slack included.
    pub(crate) reach_a: f64,
    /// The second's likewise, in stored units of the first.
    pub(crate) reach_b: f64,
    /// Errors of f64 on both sides (stored units of the first).
    pub(crate) exact: f64,
    /// Error of s·R rounded to f32 and applied in f32; what the offset adds is 16u of its length
    /// (docs/guarantees.md, `PairFrame`).
    pub(crate) turned: f64,
}

impl PairMap {
    pub(crate) fn new(a: &Posed<'_>, b: &Posed<'_>) -> Self {
        let (fa, fb) = (&a.pose.frame, &b.pose.frame);
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
    /// No vertex or lane centre of either is farther from the first's origin.
    reach: f32,
}

impl PairFrame {
    /// The map for a pair of poses, or `None` when the two deformed meshes are certainly farther
    /// apart than `tolerance` (world units).
    pub(crate) fn new(a: &Posed<'_>, b: &Posed<'_>, tolerance: f64) -> Option<Self> {
        let map = PairMap::new(a, b);
        let extra = tolerance / map.unit_a + map.exact + map.turned + MAPPED * norm(map.offset);
        let reach = map.reach_a + map.reach_b + extra;
        if norm(map.offset) > reach * BODIES_APART {
            return None;
        }
        Some(map.rounded(map.offset, extra))
    }

    /// More than what rounding takes from the difference of two heights along a direction that is not
    /// longer than 1 (docs/guarantees.md, planes between meshes).
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
