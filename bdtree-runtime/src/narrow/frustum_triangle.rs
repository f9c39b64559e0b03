//! Where a triangle lies relative to a convex region of half spaces.

use super::Triangle;
use super::clip::Polygon;
use super::exact::{HUGE, TINY, plane_side};
use crate::math::dot;
use crate::rounding::MARGIN;

/// Planes that a [`Frustum`] has at most.
pub const FRUSTUM_PLANES_MAX: usize = 64;

/// Where something lies relative to a convex region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrustumState {
    /// All of it is in the region.
    Inside,
    /// Not inside, and perhaps not outside.
    Intersects,
    /// None of it is in the region.
    Outside,
}

/// The points x with `n · x + d ≥ 0` for each plane `[n_x, n_y, n_z, d]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frustum {
    planes: [[f64; 4]; FRUSTUM_PLANES_MAX],
    len: usize,
}

/// 2^±300: steps that no normal can take across the range between the two.
const SCALE_UP: f64 = HUGE;
const SCALE_DOWN: f64 = TINY;
/// Smaller numbers count as 0: 2⁻⁴⁰⁰.
const FLUSH: f64 = f64::from_bits((1023 - 400) << 52);
/// 2^100: no coordinate is farther.
const FAR: f64 = (1_u128 << 100) as f64;

impl Frustum {
    /// Returns the region of some planes, nothing if there are none or more than
    /// [`FRUSTUM_PLANES_MAX`], or if one has a zero normal, a number that is not finite or a d
    /// beyond 2^100 times the normal's largest.
    ///
    /// Normals need not be unit. Numbers below 2⁻¹⁰⁰ times the normal's largest may count as 0.
    pub fn new(planes: &[[f64; 4]]) -> Option<Self> {
        let mut out = Self {
            planes: [[0.0; 4]; FRUSTUM_PLANES_MAX],
            len: planes.len(),
        };
        if planes.is_empty() {
            return None;
        }
        for (i, plane) in planes.iter().enumerate() {
            let largest = plane[..3].iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            if largest == 0.0 || largest == f64::INFINITY || !(plane[3].abs() / largest <= FAR) {
                return None;
            }
            let mut factor = 1.0;
            while largest * factor < TINY {
                factor *= SCALE_UP;
            }
            while largest * factor > HUGE {
                factor *= SCALE_DOWN;
            }
            let plane = plane.map(|x| x * factor);
            if !plane.iter().all(|x| x.is_finite()) {
                return None;
            }
            *out.planes.get_mut(i)? = plane.map(|x| flushed(x, FLUSH));
        }
        Some(out)
    }

    /// Returns the planes, each perhaps times a power of two.
    pub fn planes(&self) -> &[[f64; 4]] {
        &self.planes[..self.len]
    }

    /// Returns where a closed triangle lies.
    ///
    /// `Inside` is exact: `n · x + d ≥ 0` for all corners and planes, coordinates below 2⁻³⁰⁰
    /// counting as 0. `Outside` is never said of a triangle with a point in the region; of triangles
    /// that miss it, it is said when all corners are strictly beyond one plane (exact), and when the
    /// region misses them by more than 2⁻⁴⁰ of the numbers that enter.
    pub fn triangle(&self, tri: &Triangle) -> FrustumState {
        let tri = tri.map(|corner| corner.map(|x| flushed(x, TINY)));
        // Of each corner, whether it is inside all planes so far.
        let mut inside = [true; 3];
        for [nx, ny, nz, d] in self.planes() {
            let beyond = tri.map(|corner| plane_side([*nx, *ny, *nz], *d, corner) < 0);
            if beyond == [true; 3] {
                return FrustumState::Outside;
            }
            for k in 0..3 {
                inside[k] &= !beyond[k];
            }
        }
        match inside {
            [true, true, true] => FrustumState::Inside,
            [false, false, false] if self.misses(&tri) => FrustumState::Outside,
            _ => FrustumState::Intersects,
        }
    }

    /// Whether nothing is left of the triangle when all planes, moved outwards by more than
    /// rounding, have cut it.
    #[cold]
    fn misses(&self, tri: &Triangle) -> bool {
        // A cut adds one vertex; should rounding add more, nothing is proved.
        let mut piece = Polygon::<{ FRUSTUM_PLANES_MAX + 3 }>::triangle();
        for [nx, ny, nz, d] in self.planes() {
            let n = [*nx, *ny, *nz];
            let size = |corner: &[f64; 3]| dot(n.map(f64::abs), corner.map(f64::abs)) + d.abs();
            let room = MARGIN * tri.iter().map(size).fold(0.0, f64::max);
            match piece.clipped(tri.map(|corner| dot(n, corner) + d + room)) {
                Some(rest) if rest.is_empty() => return true,
                Some(rest) => piece = rest,
                None => return false,
            }
        }
        false
    }
}

/// A number, or 0 where it is closer to 0 than `least`.
fn flushed(x: f64, least: f64) -> f64 {
    if x.abs() >= least { x } else { 0.0 }
}
