//! The contour along which two surfaces pass through each other, as sums over pairs of triangles.
//!
//! Each pair adds the piece that its triangles share, directed along the product of their normals: so
//! pieces need no order, and holes count negative.

use super::super::unit;
use crate::math::{add, add_scaled, cross, dot, norm, scale, sqrt, sub};
use crate::narrow::{Triangle, area_vector};

/// A contour is open if the ends of its pieces are farther apart than this share of its length.
const OPEN: f64 = 1e-4;

/// Thinner regions than this share of the contour's length are no regions.
const THIN: f64 = 1e-7;

/// Sums over the pieces of a contour, relative to its first point.
#[derive(Default)]
pub(super) struct Contour {
    origin: Option<[f64; 3]>,
    /// Σ (q − p).
    ends: [f64; 3],
    length: f64,
    /// ½ Σ p × q.
    area: [f64; 3],
    /// Normal and two axes across it.
    axes: [[f64; 3]; 3],
    /// In the plane of the axes: twice the area, six times the first, twelve times the second moments
    /// (xx, xy, yy).
    flat_area: f64,
    first: [f64; 2],
    second: [f64; 3],
    /// Σ length · height along the normal.
    height: f64,
}

/// Where a region lies.
pub(super) struct Place {
    pub(super) center: [f64; 3],
    pub(super) area: f64,
    /// Principal axes, as long as the standard deviations along them.
    pub(super) spread: [[f64; 3]; 2],
    /// Length of the contour.
    pub(super) size: f64,
}

impl Contour {
    /// Adds a pair of triangles to length and vector area.
    pub(super) fn outline(&mut self, a: &Triangle, b: &Triangle) {
        let Some([p, q]) = crossing(a, b) else {
            return;
        };
        let origin = *self.origin.get_or_insert(p);
        let piece = sub(q, p);
        self.ends = add(self.ends, piece);
        self.length += norm(piece);
        let turned = cross(sub(p, origin), sub(q, origin));
        self.area = add_scaled(self.area, 0.5, turned);
    }

    /// The length of the vector area.
    pub(super) fn area(&self) -> f64 {
        norm(self.area)
    }

    /// The direction of the vector area, if the contour is closed and encloses anything.
    pub(super) fn normal(&self) -> Option<[f64; 3]> {
        let closed = norm(self.ends) <= OPEN * self.length;
        let wide = norm(self.area) > THIN * self.length * self.length;
        if closed && wide {
            unit(self.area, "").ok()
        } else {
            None
        }
    }

    /// Moments are taken across `normal` from now on.
    pub(super) fn begin_moments(&mut self, normal: [f64; 3]) {
        // The coordinate axis that is most across it.
        let [x, y, z] = normal.map(f64::abs);
        let axis = if x <= y && x <= z {
            [1.0, 0.0, 0.0]
        } else if y <= z {
            [0.0, 1.0, 0.0]
        } else {
            [0.0, 0.0, 1.0]
        };
        let u = cross(normal, axis);
        let u = scale(u, 1.0 / norm(u));
        self.axes = [normal, u, cross(normal, u)];
    }

    /// Adds a pair of triangles to the moments.
    pub(super) fn measure(&mut self, a: &Triangle, b: &Triangle) {
        let (Some(origin), Some([p, q])) = (self.origin, crossing(a, b)) else {
            return;
        };
        let [n, u, v] = self.axes;
        let (p, q) = (sub(p, origin), sub(q, origin));
        let ([px, py], [qx, qy]) = ([dot(p, u), dot(p, v)], [dot(q, u), dot(q, v)]);
        let turn = px * qy - py * qx;
        self.flat_area += turn;
        self.first[0] += turn * (px + qx);
        self.first[1] += turn * (py + qy);
        self.second[0] += turn * (px * px + px * qx + qx * qx);
        self.second[1] += turn * (px * py + 0.5 * (px * qy + qx * py) + qx * qy);
        self.second[2] += turn * (py * py + py * qy + qy * qy);
        self.height += 0.5 * norm(sub(q, p)) * (dot(p, n) + dot(q, n));
    }

    /// Center, area and spread of what the contour encloses; `None` where its projection overlaps itself so that
    /// they are those of no region.
    pub(super) fn place(&self) -> Option<Place> {
        let origin = self.origin?;
        let area = 0.5 * self.flat_area;
        if !(area > 0.0) {
            return None;
        }
        let [x, y] = self.first.map(|m| m / (6.0 * area));
        let [xx, xy, yy] = self.second.map(|m| m / (12.0 * area));
        let (xx, xy, yy) = (xx - x * x, xy - x * y, yy - y * y);
        // Eigenvectors of the symmetric matrix.
        let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let root = sqrt(half * half + xy * xy);
        // Both second moments are positive unless parts that are wound the other way outweigh the rest.
        if !(mean > root) {
            return None;
        }
        let (c, s) = if root <= 1e-9 * mean {
            (1.0, 0.0)
        } else if half >= 0.0 {
            (half + root, xy)
        } else {
            (xy, root - half)
        };
        let length = sqrt(c * c + s * s);
        let (c, s) = (c / length, s / length);
        let [n, u, v] = self.axes;
        let major = add_scaled(scale(u, c), s, v);
        let minor = add_scaled(scale(u, -s), c, v);
        let center = add_scaled(add_scaled(origin, x, u), y, v);
        Some(Place {
            center: add_scaled(center, self.height / self.length, n),
            area,
            spread: [
                scale(major, sqrt(mean + root)),
                scale(minor, sqrt(mean - root)),
            ],
            size: self.length,
        })
    }
}

/// The piece of a line that two triangles share, directed along the product of their normals; `None`
/// if they do not pass through each other.
fn crossing(a: &Triangle, b: &Triangle) -> Option<[[f64; 3]; 2]> {
    let (normal_a, normal_b) = (area_vector(a), area_vector(b));
    let direction = cross(normal_a, normal_b);
    let along = |x: [f64; 3]| dot(sub(x, a[0]), direction);
    let ends_a = cut(a, b[0], normal_b, along)?;
    let ends_b = cut(b, a[0], normal_a, along)?;
    let low = if ends_a[0].0 >= ends_b[0].0 {
        ends_a[0]
    } else {
        ends_b[0]
    };
    let high = if ends_a[1].0 <= ends_b[1].0 {
        ends_a[1]
    } else {
        ends_b[1]
    };
    (low.0 < high.0).then_some([low.1, high.1])
}

/// Where a plane cuts a triangle's edges, by the parameter `along` there. Corners in the plane
/// count as above it, so neighbours are cut alike.
fn cut(
    triangle: &Triangle,
    origin: [f64; 3],
    normal: [f64; 3],
    along: impl Fn([f64; 3]) -> f64,
) -> Option<[(f64, [f64; 3]); 2]> {
    let heights = triangle.map(|x| dot(sub(x, origin), normal));
    let mut ends = [(0.0, [0.0; 3]); 2];
    let mut count = 0;
    for i in 0..3 {
        let j = (i + 1) % 3;
        if (heights[i] < 0.0) == (heights[j] < 0.0) {
            continue;
        }
        let t = heights[i] / (heights[i] - heights[j]);
        let x = add_scaled(triangle[i], t, sub(triangle[j], triangle[i]));
        ends[count & 1] = (along(x), x);
        count += 1;
    }
    if count != 2 {
        return None;
    }
    if ends[0].0 > ends[1].0 {
        ends.swap(0, 1);
    }
    Some(ends)
}
