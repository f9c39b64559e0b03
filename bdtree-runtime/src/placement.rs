//! World ↔ stored coordinates of one placed asset, in f64, with a bound of the error.

use crate::math::rotation_matrix;
use crate::math::{add, dot, length_bound, norm, scale, sqrt, sub};
use crate::pose::hashed;
use crate::rounding::MAPS;
use crate::simd::{Quad, Quad3, add3, dot3, scale3, splat3};
use crate::transform::Transform;
use crate::view::Asset;

/// The placement of one asset.
///
/// Leaves use [`Placement::world`], the leaf arithmetic that defines the deformed mesh. Node
/// tests run in stored units, where f32 serves; the maps to and from there only have to be as
/// good as [`Placement::error`] says.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Placement {
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

impl Placement {
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
    /// once, in f64 (docs/design/guarantees.md; SPEC 5.5).
    #[inline(always)]
    pub(crate) fn world(&self, p: [f32; 3]) -> [f64; 3] {
        let p = [f64::from(p[0]), f64::from(p[1]), f64::from(p[2])];
        let mesh = add(self.origin, scale(p, self.unit));
        let [x, y, z] = self.rotation;
        let turned = [dot(x, mesh), dot(y, mesh), dot(z, mesh)];
        add(self.translation, scale(turned, self.scale))
    }

    /// [`Placement::world`] for four points: the same bits.
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

    /// What tells placements apart: rotation, translation, origin, scale and unit.
    pub(crate) fn numbers(&self) -> [[f64; 3]; 6] {
        let [a, b, c] = self.rotation;
        let rest = [self.scale, self.unit, 0.0];
        [a, b, c, self.translation, self.origin, rest]
    }

    /// A number that tells placements apart.
    pub(crate) fn fingerprint(&self) -> u64 {
        // A chain for each three numbers, so that none waits for the one before.
        let numbers = self.numbers();
        let chains = numbers
            .iter()
            .map(|three| hashed(three.iter().map(|x| x.to_bits())));
        hashed(chains)
    }

    /// Linear part of the map from stored coordinates to the world.
    pub(crate) fn linear(&self) -> [[f64; 3]; 3] {
        let factor = self.world_per_stored();
        self.rotation.map(|row| scale(row, factor))
    }

    /// World units per stored unit.
    #[inline]
    pub(crate) fn world_per_stored(&self) -> f64 {
        self.scale * self.unit
    }

    /// A world point in stored coordinates, within [`Placement::error`].
    #[inline(always)] // every query begins with it
    pub(crate) fn point_to_stored(&self, x: [f64; 3]) -> [f64; 3] {
        let rotated = self.inverse_rotate(sub(x, self.translation));
        scale(
            sub(scale(rotated, self.per_scale), self.origin),
            self.per_unit,
        )
    }

    /// A world direction in stored axes; its length is kept.
    #[inline(always)] // every query begins with it
    pub(crate) fn inverse_rotate(&self, v: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = self.rotation;
        add(add(scale(x, v[0]), scale(y, v[1])), scale(z, v[2]))
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
    #[inline]
    pub(crate) fn error(&self, x_norm: f64, reach: f64) -> f64 {
        let [translation, origin] = self.far();
        let world = x_norm + translation + origin;
        MAPS * (world / self.world_per_stored() + reach)
    }

    /// At least the lengths of the translation and of the origin as scaled.
    #[inline(always)]
    pub(crate) fn far(&self) -> [f64; 2] {
        [
            length_bound(self.translation),
            self.scale * length_bound(self.origin),
        ]
    }
}
