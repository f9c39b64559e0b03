//! Cutting triangles along the planes of the lattice, and integrating over the fragments.

use super::vec3::{add, cross, norm, scale, sub};

/// A convex fragment: a triangle cut by six planes has at most nine corners.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Polygon {
    points: [[f64; 3]; 12],
    count: usize,
}

impl Polygon {
    fn new(triangle: [[f64; 3]; 3]) -> Self {
        let mut points = [[0.0; 3]; 12];
        points[..3].copy_from_slice(&triangle);
        Self { points, count: 3 }
    }

    /// Its corners in order.
    pub(crate) fn corners(&self) -> &[[f64; 3]] {
        &self.points[..self.count]
    }

    /// The part with `side · (x[axis] − at) ≥ 0`.
    fn clip(&self, axis: usize, at: f64, side: f64) -> Self {
        let mut out = Self {
            points: [[0.0; 3]; 12],
            count: 0,
        };
        let distance = |p: [f64; 3]| side * (p[axis] - at);
        for i in 0..self.count {
            let (p, q) = (self.points[i], self.points[(i + 1) % self.count]);
            let (dp, dq) = (distance(p), distance(q));
            if dp >= 0.0 {
                out.push(p);
            }
            if (dp > 0.0 && dq < 0.0) || (dp < 0.0 && dq > 0.0) {
                let mut x = add(p, scale(sub(q, p), dp / (dp - dq)));
                x[axis] = at;
                out.push(x);
            }
        }
        out
    }

    fn push(&mut self, p: [f64; 3]) {
        // Rounding could add a corner to a sliver; twelve places are room to spare.
        if self.count < self.points.len() {
            self.points[self.count] = p;
            self.count += 1;
        }
    }

    fn range(&self, axis: usize) -> (f64, f64) {
        self.corners()
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), p| {
                (lo.min(p[axis]), hi.max(p[axis]))
            })
    }
}

/// Calls `visit(cell, fragment)` for the fragments of a triangle in lattice coordinates (cell
/// size 1); every point of it falls into exactly one fragment. A part that lies in a lattice
/// plane goes to the upper cell, and what lies outside the lattice to the nearest cell.
pub(crate) fn for_each_fragment(
    triangle: [[f64; 3]; 3],
    dims: [usize; 3],
    visit: &mut impl FnMut([usize; 3], &Polygon),
) {
    slabs(&Polygon::new(triangle), 0, dims, [0; 3], visit);
}

fn slabs(
    polygon: &Polygon,
    axis: usize,
    dims: [usize; 3],
    mut cell: [usize; 3],
    visit: &mut impl FnMut([usize; 3], &Polygon),
) {
    if axis == 3 {
        visit(cell, polygon);
        return;
    }
    let last = dims[axis].saturating_sub(1);
    let index = |x: f64| (x.floor().max(0.0) as usize).min(last);
    let (lo, hi) = polygon.range(axis);
    let first = index(lo);
    let mut end = index(hi);
    if end > first && hi == end as f64 {
        end -= 1; // it only touches the upper slab
    }
    if first == end {
        cell[axis] = first;
        slabs(polygon, axis + 1, dims, cell, visit);
        return;
    }
    let mut rest = *polygon;
    for i in first..=end {
        cell[axis] = i;
        if i == end {
            slabs(&rest, axis + 1, dims, cell, visit);
        } else {
            let at = (i + 1) as f64;
            let part = rest.clip(axis, at, -1.0);
            if part.count >= 3 {
                slabs(&part, axis + 1, dims, cell, visit);
            }
            rest = rest.clip(axis, at, 1.0);
            if rest.count < 3 {
                return;
            }
        }
    }
}

/// Weights and barycentric coordinates of the seven-point rule of degree 5 (Radon 1948).
const RULE: [(f64, [f64; 3]); 7] = {
    const A: f64 = 0.470_142_064_105_115_1;
    const B: f64 = 0.101_286_507_323_456_34;
    const WA: f64 = 0.132_394_152_788_506_2;
    const WB: f64 = 0.125_939_180_544_827_15;
    const T: f64 = 1.0 / 3.0;
    [
        (0.225, [T, T, T]),
        (WA, [A, A, 1.0 - 2.0 * A]),
        (WA, [A, 1.0 - 2.0 * A, A]),
        (WA, [1.0 - 2.0 * A, A, A]),
        (WB, [B, B, 1.0 - 2.0 * B]),
        (WB, [B, 1.0 - 2.0 * B, B]),
        (WB, [1.0 - 2.0 * B, B, B]),
    ]
};

/// Calls `visit(point, area vector)` for the quadrature points of a fragment.
pub(crate) fn integrate(polygon: &Polygon, visit: &mut impl FnMut([f64; 3], [f64; 3])) {
    let points = polygon.corners();
    for i in 1..points.len().saturating_sub(1) {
        let (a, b, c) = (points[0], points[i], points[i + 1]);
        let vector = scale(cross(sub(b, a), sub(c, a)), 0.5);
        if norm(vector) == 0.0 {
            continue;
        }
        for (w, l) in RULE {
            let p = add(add(scale(a, l[0]), scale(b, l[1])), scale(c, l[2]));
            visit(p, scale(vector, w));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fragments_cover_a_triangle_once() {
        for triangle in [
            [[0.1, 0.2, 0.3], [7.7, 1.4, 2.9], [2.1, 6.6, 5.0]],
            [[0.0, 0.0, 3.0], [4.0, 0.0, 3.0], [0.0, 4.0, 3.0]],
            [[1.0, 1.0, 1.0], [5.0, 5.0, 5.0], [5.0, 1.0, 3.0]],
        ] {
            let area = |p: &[[f64; 3]]| -> f64 {
                (1..p.len() - 1)
                    .map(|i| 0.5 * norm(cross(sub(p[i], p[0]), sub(p[i + 1], p[0]))))
                    .sum()
            };
            let mut total = 0.0;
            for_each_fragment(triangle, [8; 3], &mut |cell, polygon| {
                total += area(polygon.corners());
                for p in polygon.corners() {
                    for a in 0..3 {
                        let x = p[a] - cell[a] as f64;
                        assert!((-1e-12..=1.0 + 1e-12).contains(&x));
                    }
                }
            });
            assert!((total - area(&triangle)).abs() < 1e-12 * (1.0 + total));
        }
    }
}
