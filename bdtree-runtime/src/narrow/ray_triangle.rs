//! First point of a triangle on a ray, watertight.
//!
//! Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection" (2013): a shear that depends on
//! the ray only makes the ray an axis; edge functions of the sheared corners then decide.
//! Deviation: those signs are exact here, so that no tie breaks two ways, and edge functions keep
//! full relative precision, so that grazing hits are as accurate as frontal ones.

use super::exact::{above, det2, encloses, open_axis, tame};
use super::point_triangle::closest_weights;
use super::{Triangle, combine};
use crate::math::sub;

/// Sheared coordinates below 2⁻²⁵⁰ count as 0, so that the determinants cannot underflow.
const FLUSH: f64 = f64::from_bits((1023 - 250) << 52);

/// 2⁻⁴⁴ and 2⁻¹⁵⁰, of [`surely_open`].
const AREA_ROUNDING: f64 = f64::from_bits((1023 - 44) << 52);
const LEAST_REACH: f64 = f64::from_bits((1023 - 150) << 52);

/// A ray, prepared once for many triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PreparedRay {
    origin: [f64; 3],
    direction: [f64; 3],
    /// The coordinate of largest |direction| comes last.
    axes: [usize; 3],
    /// d_x / d_z, d_y / d_z, 1 / d_z in that order of axes.
    shear: [f64; 3],
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// Distance along the ray.
    pub t: f64,
    /// Weights of the corners, none negative, sum 1 within 4 u.
    pub barycentric: [f64; 3],
    /// The point: `Σ barycentric[i] · corner[i]`, or the origin if that is on the triangle.
    pub point: [f64; 3],
}

impl PreparedRay {
    /// Returns the ray from `origin` along `unit_direction`, whose length must be 1 to rounding.
    #[inline]
    pub fn new(origin: [f64; 3], unit_direction: [f64; 3]) -> Self {
        let d = unit_direction;
        let [x, y, z] = d.map(f64::abs);
        let last = if z >= x && z >= y {
            2
        } else if y >= x {
            1
        } else {
            0
        };
        let axes = [(last + 1) % 3, (last + 2) % 3, last];
        let shear = [d[axes[0]] / d[last], d[axes[1]] / d[last], 1.0 / d[last]];
        Self {
            origin,
            direction: d,
            axes,
            shear,
        }
    }

    /// Returns where the ray starts.
    #[inline]
    pub fn origin(&self) -> [f64; 3] {
        self.origin
    }

    /// Returns the unit direction.
    #[inline]
    pub fn direction(&self) -> [f64; 3] {
        self.direction
    }

    /// Returns a corner as (across, across, distance along the ray); depends on nothing else.
    #[inline(always)]
    fn shear(&self, corner: [f64; 3]) -> ([f64; 2], f64) {
        let a = sub(corner, self.origin);
        let [x, y, z] = self.axes.map(|k| a[k]);
        let flush = |v: f64| if v.abs() >= FLUSH { v } else { 0.0 };
        let across = [flush(x - self.shear[0] * z), flush(y - self.shear[1] * z)];
        (across, z * self.shear[2])
    }
}

/// Returns where the ray meets `tri` with 0 ≤ t ≤ `t_max`, at the least t.
///
/// *Watertight:* of the triangles around an edge or corner that the ray meets, at least one is hit,
/// since corners are sheared alike in all of them and signs are exact. The ray may meet the wrong
/// one of two neighbours within rounding, and a seam filled only by zero-area triangles may leak
/// by as much: those are missed, decided exactly on the corners.
///
/// *Accuracy:* with L the largest `|corner − origin|` of any coordinate, the point Σ w_i·corner_i lies
/// within τ = 2⁻⁴⁶ L (+ 2⁻²⁴⁹) of origin + t·direction, also for slivers and at grazing angles.
/// t itself is as good as the angle allows: τ over its sine. An origin that is a point of the triangle,
/// exactly, gives t = 0 and that point.
///
/// *Edge-on* means: exactly so after the shear. Then t is the first common point, 0 if the origin
/// is inside. A ray in the plane of the triangle in some skew direction may, by rounding, pass beside it.
#[inline(always)] // walks compile it with their instruction set
pub fn ray_hit(ray: &PreparedRay, tri: &Triangle, t_max: f64) -> Option<RayHit> {
    let (a, depth_a) = ray.shear(tri[0]);
    let (b, depth_b) = ray.shear(tri[1]);
    let (c, depth_c) = ray.shear(tri[2]);
    let depths = [depth_a, depth_b, depth_c];
    let behind = depths.iter().any(|&d| d <= 0.0);
    if behind && depths.iter().any(|&d| d >= 0.0) && starts_on(ray.origin, tri) {
        return (t_max >= 0.0).then(|| RayHit {
            t: 0.0,
            barycentric: closest_weights(ray.origin, tri).0,
            point: ray.origin,
        });
    }
    let edges = [det2(b, c), det2(c, a), det2(a, b)];
    if edges.iter().any(|&w| w < 0.0) && edges.iter().any(|&w| w > 0.0) {
        return None;
    }
    let sum = edges[0] + edges[1] + edges[2];
    let weights = if sum == 0.0 {
        edge_on([a, b, c], depths)?
    } else {
        // + 0 makes −0 a plain 0.
        edges.map(|w| w / sum + 0.0)
    };
    let t = weights[0] * depths[0] + weights[1] * depths[1] + weights[2] * depths[2];
    // False for NaN.
    if !(t >= 0.0 && t <= t_max) {
        return None;
    }
    if !surely_open(sum, &[a, b, c], depths) {
        let [[a, b, c]] = tame([*tri]);
        open_axis(a, b, c)?;
    }
    Some(RayHit {
        t: t + 0.0,
        barycentric: weights,
        point: combine(tri, weights),
    })
}

/// Returns whether a triangle has an area for sure: most do, and then the exact test is spared.
///
/// `doubled` is twice the area of the sheared corners. Were the corners collinear, it would be 0 but for rounding: with L at least
/// the largest |corner − origin| of any coordinate, sheared coordinates are at most 2 L and off by at most 5 u L, so three
/// products of two are off by 120 u L², determinants by 144 u L² and their sum by 40 u L²: together less than 2⁻⁴⁴ L².
#[inline(always)]
fn surely_open(doubled: f64, across: &[[f64; 2]; 3], depths: [f64; 3]) -> bool {
    let mut reach = 0.0_f64;
    for k in 0..3 {
        let [x, y] = across[k];
        // The sheared coordinate and what the shear took from it; the depth is the third coordinate, or more.
        reach = reach.max(x.abs().max(y.abs()) + depths[k].abs());
    }
    // Far above what was flushed.
    reach > LEAST_REACH && doubled.abs() > AREA_ROUNDING * (reach * reach)
}

/// Returns whether `p` is a point of the triangle, exactly, and the triangle has an area.
#[inline]
fn starts_on(p: [f64; 3], tri: &Triangle) -> bool {
    let boxed = (0..3).all(|k| {
        let [x, y, z] = tri.map(|c| c[k]);
        x.min(y).min(z) <= p[k] && p[k] <= x.max(y).max(z)
    });
    if !boxed {
        return false;
    }
    let [[a, b, c], [p, ..]] = tame([*tri, [p; 3]]);
    let Some(axis) = open_axis(a, b, c) else {
        return false;
    };
    above(a, b, c, p) == 0 && encloses(axis, [a, b, c], p)
}

/// Returns the weights of the first point with depth ≥ 0 of a triangle seen as a line or a point.
///
/// The sheared corners lie exactly on a line through the axis.
#[cold]
fn edge_on(corners: [[f64; 2]; 3], depths: [f64; 3]) -> Option<[f64; 3]> {
    let extent = |k: usize| corners.iter().fold(0.0_f64, |m, p| m.max(p[k].abs()));
    let k = usize::from(extent(1) > extent(0));
    // The common points are a segment along the axis, its ends on edges (or at corners).
    let mut near: Option<(f64, [f64; 3])> = None;
    let mut far: Option<(f64, [f64; 3])> = None;
    let mut visit = |weights: [f64; 3]| {
        let depth = weights[0] * depths[0] + weights[1] * depths[1] + weights[2] * depths[2];
        if near.is_none_or(|(d, _)| depth < d) {
            near = Some((depth, weights));
        }
        if far.is_none_or(|(d, _)| depth > d) {
            far = Some((depth, weights));
        }
    };
    for i in 0..3 {
        let j = (i + 1) % 3;
        let (x, y) = (corners[i][k], corners[j][k]);
        let mut weights = [0.0; 3];
        if x == 0.0 {
            weights[i] = 1.0;
            visit(weights);
        } else if (x < 0.0 && y > 0.0) || (x > 0.0 && y < 0.0) {
            weights[i] = y / (y - x);
            weights[j] = x / (x - y);
            visit(weights);
        }
    }
    let (near, far) = (near?, far?);
    if near.0 >= 0.0 || far.0 < 0.0 {
        return Some(near.1);
    }
    // The origin is between them: the point of depth 0.
    let span = far.0 - near.0;
    let (k, l) = (far.0 / span, -near.0 / span);
    Some([0, 1, 2].map(|i| near.1[i] * k + far.1[i] * l))
}
