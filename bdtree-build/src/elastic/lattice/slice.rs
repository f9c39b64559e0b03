//! Cutting triangles along the planes of the lattice, and integrating over the fragments.

use crate::elastic::lattice::grid::Slab;
use crate::vec3::{add, cross, norm, scale, sub};

/// A convex fragment: a triangle cut by six planes has at most nine corners.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Polygon {
    points: [[f64; 3]; 16],
    count: usize,
}

impl Polygon {
    fn new(triangle: [[f64; 3]; 3]) -> Self {
        let mut points = [[0.0; 3]; 16];
        points[..3].copy_from_slice(&triangle);
        Self { points, count: 3 }
    }

    /// Its corners in order.
    pub(crate) fn corners(&self) -> &[[f64; 3]] {
        &self.points[..self.count]
    }

    /// The part with `side · (x[axis] − at) ≥ 0`.
    pub(crate) fn clip(&self, axis: usize, at: f64, side: f64) -> Self {
        let mut out = Self {
            points: [[0.0; 3]; 16],
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
        // Six more planes of a region make fifteen; rounding could add a corner to a sliver.
        if self.count < self.points.len() {
            self.points[self.count] = p;
            self.count += 1;
        }
    }

    /// Least and greatest coordinate.
    pub(crate) fn range(&self, axis: usize) -> (f64, f64) {
        self.corners()
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), p| {
                (lo.min(p[axis]), hi.max(p[axis]))
            })
    }
}

/// Calls `visit(cell, fragment)` for the fragments of a triangle in lattice coordinates (cell
/// size 1) that lie in a slab; every point of it falls into exactly one fragment, to the same bits whatever the
/// slabs. A part that lies in a lattice plane goes to the upper cell, and what lies outside the lattice to the
/// nearest cell.
pub(crate) fn for_each_fragment(
    triangle: [[f64; 3]; 3],
    dims: [usize; 3],
    within: &Slab,
    visit: &mut impl FnMut([usize; 3], &Polygon),
) {
    let polygon = Polygon::new(triangle);
    // Most triangles are small: those of other slabs are told by their ends.
    let (first, last) = places(&polygon, within.axis, dims);
    if first < within.end && last >= within.first {
        cut(&polygon, 0, dims, within, [0; 3], visit);
    }
}

/// The first and the last cell on an axis that a polygon has a part in.
fn places(polygon: &Polygon, axis: usize, dims: [usize; 3]) -> (usize, usize) {
    let last = dims[axis].saturating_sub(1);
    let index = |x: f64| (x.floor().max(0.0) as usize).min(last);
    let (lo, hi) = polygon.range(axis);
    let first = index(lo);
    let mut end = index(hi);
    if end > first && hi == end as f64 {
        end -= 1; // it only touches the upper slab
    }
    (first, end)
}

fn cut(
    polygon: &Polygon,
    axis: usize,
    dims: [usize; 3],
    within: &Slab,
    mut cell: [usize; 3],
    visit: &mut impl FnMut([usize; 3], &Polygon),
) {
    if axis == 3 {
        visit(cell, polygon);
        return;
    }
    let (first, last) = places(polygon, axis, dims);
    let (mut rest, mut cut_off);
    rest = polygon;
    for i in first..last {
        if axis == within.axis && i >= within.end {
            return;
        }
        // Other slabs' parts are cut off too: so each part's corners are the same whoever asks.
        let at = (i + 1) as f64;
        cell[axis] = i;
        if within.meets(axis, i) {
            let part = rest.clip(axis, at, -1.0);
            if part.count >= 3 {
                cut(&part, axis + 1, dims, within, cell, visit);
            }
        }
        cut_off = rest.clip(axis, at, 1.0);
        rest = &cut_off;
        if rest.count < 3 {
            return;
        }
    }
    cell[axis] = last;
    if within.meets(axis, last) {
        cut(rest, axis + 1, dims, within, cell, visit);
    }
}

/// Gauss-Legendre points on [0, 1] and their weights, by Newton's method on P_n.
fn gauss_legendre<const N: usize>() -> [(f64, f64); N] {
    std::array::from_fn(|i| {
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (N as f64 + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..8 {
            let (mut p, mut before) = (x, 1.0);
            for k in 2..=N {
                let k = k as f64;
                (p, before) = (((2.0 * k - 1.0) * x * p - (k - 1.0) * before) / k, p);
            }
            slope = N as f64 * (x * p - before) / (x * x - 1.0);
            x -= p / slope;
        }
        (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
    })
}

/// Quadrature points of a triangle: barycentric coordinates of its last two corners and the
/// weight, adding up to 1.
type Rule = Vec<([f64; 2], f64)>;

/// Rules of rising degree with the half extent (in cells) of the fragments they are for.
///
/// The integrands are polynomials of degree 13. Where a rule's degree is less, the remainder
/// shrinks with that power of the extent: at the extents given here it stays below 4e-9 of the
/// fragment's area (C(13, 2n) h²ⁿ / 2²ⁿ⁻¹ with h the extent in cells).
pub(crate) struct Rules {
    whole: [(f64, Rule); 5],
    /// The same with fewer points across the shortest edge of a triangle, for half extents of that edge up to the
    /// one given: fans of faces with thousands of corners are slivers. Across, the integrands are polynomials of
    /// degree 13 as well.
    slivers: [(f64, [Rule; 5]); 2],
}

impl Rules {
    /// Gauss-Legendre points on a square folded into the triangle (Duffy 1982).
    pub(crate) fn new() -> Self {
        /// `N` points from the first corner to the opposite edge, `M` along that edge.
        fn folded<const N: usize, const M: usize>() -> Rule {
            let mut rule = Vec::with_capacity(N * M);
            for (u, wu) in gauss_legendre::<N>() {
                for (v, wv) in gauss_legendre::<M>() {
                    rule.push(([u * (1.0 - v), u * v], 2.0 * wu * wv * u));
                }
            }
            rule
        }
        fn sliver<const M: usize>() -> [Rule; 5] {
            [
                folded::<4, M>(),
                folded::<5, M>(),
                folded::<6, M>(),
                folded::<7, M>(),
                folded::<8, M>(),
            ]
        }
        Self {
            whole: [
                (0.025, folded::<4, 4>()),
                (0.075, folded::<5, 5>()),
                (0.125, folded::<6, 6>()),
                (0.25, folded::<7, 7>()),
                (f64::INFINITY, folded::<8, 8>()),
            ],
            slivers: [(5e-4, sliver::<2>()), (5e-3, sliver::<3>())],
        }
    }

    /// Calls `visit(point, area vector)` for the quadrature points of a fragment.
    pub(crate) fn integrate(&self, polygon: &Polygon, visit: &mut impl FnMut([f64; 3], [f64; 3])) {
        let along = self.along(polygon);
        let points = polygon.corners();
        for i in 1..points.len().saturating_sub(1) {
            let (rule, [a, b, c]) = self.fitting(along, [points[0], points[i], points[i + 1]]);
            let (ab, ac) = (sub(b, a), sub(c, a));
            let vector = scale(cross(ab, ac), 0.5);
            if norm(vector) == 0.0 {
                continue;
            }
            for &([u, v], w) in rule {
                visit(add(a, add(scale(ab, u), scale(ac, v))), scale(vector, w));
            }
        }
    }

    /// Calls `visit` with sixteen points of every triangle of a fragment.
    pub(crate) fn for_each_point(&self, polygon: &Polygon, visit: &mut impl FnMut([f64; 3])) {
        let [(_, coarsest), ..] = &self.whole;
        let points = polygon.corners();
        for i in 1..points.len().saturating_sub(1) {
            let (a, b, c) = (points[0], points[i], points[i + 1]);
            for &([u, v], _) in coarsest {
                visit(add(a, add(scale(sub(b, a), u), scale(sub(c, a), v))));
            }
        }
    }

    /// Which rules are for a fragment of this size.
    fn along(&self, polygon: &Polygon) -> usize {
        let half = (0..3).fold(0.0f64, |most, a| {
            let (lo, hi) = polygon.range(a);
            most.max(0.5 * (hi - lo))
        });
        let fitting = self.whole.iter().position(|(most, _)| half <= *most);
        fitting.unwrap_or(self.whole.len() - 1)
    }

    /// The rule for a triangle of a fragment, and the triangle with its shortest edge opposite to the first corner
    /// where that is a sliver's.
    fn fitting(&self, along: usize, [a, b, c]: [[f64; 3]; 3]) -> (&Rule, [[f64; 3]; 3]) {
        let turned = [[a, b, c], [b, c, a], [c, a, b]];
        let half = |t: &[[f64; 3]; 3]| {
            let edge = sub(t[2], t[1]);
            edge.iter().fold(0.0f64, |most, x| most.max(0.5 * x.abs()))
        };
        let halves = [0, 1, 2].map(|k| half(&turned[k]));
        let shortest = (0..3).fold(0, |best, k| if halves[k] < halves[best] { k } else { best });
        let sliver = self
            .slivers
            .iter()
            .find(|(most, _)| halves[shortest] <= *most);
        match sliver {
            Some((_, rules)) => (&rules[along], turned[shortest]),
            None => (&self.whole[along].1, turned[0]),
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
            for_each_fragment(triangle, [8; 3], &Slab::ALL, &mut |cell, polygon| {
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

    /// Slivers with any of their edges the short one, beside the finest rule.
    #[test]
    fn slivers_are_integrated_as_precisely() {
        let rules = Rules::new();
        let finest = Rules {
            whole: std::array::from_fn(|_| (f64::INFINITY, rules.whole[4].1.clone())),
            slivers: std::array::from_fn(|k| (-1.0, rules.slivers[k].1.clone())),
        };
        for width in [1e-2, 9.9e-3, 3e-3, 9.9e-4, 1e-5] {
            let (a, b) = ([0.98, 0.99, 1.0], [0.1, 0.05, 0.2]);
            let c = [b[0] + 0.7 * width, b[1] - width, b[2] + 0.4 * width];
            for triangle in [[a, b, c], [b, c, a], [c, a, b], [b, a, c]] {
                let sum = |rules: &Rules| {
                    let mut sum = 0.0;
                    let f = |p: [f64; 3]| {
                        let [x, y, z] = p.map(|c| 2.0 * c - 1.0);
                        x.powi(5) * y.powi(4) * z.powi(4)
                    };
                    let polygon = Polygon::new(triangle);
                    rules.integrate(&polygon, &mut |p, vector| sum += f(p) * norm(vector));
                    sum
                };
                let area = 0.5 * norm(cross(sub(b, a), sub(c, a)));
                let (found, want) = (sum(&rules), sum(&finest));
                assert!((found - want).abs() < 4e-9 * area, "{width} {found} {want}");
            }
        }
    }

    #[test]
    fn rules_integrate_the_highest_powers() {
        let rules = Rules::new();
        for size in [1.0, 0.5, 0.25, 0.15, 0.05] {
            let p = [[0.9, 0.95, 1.0], [1.0, 0.9, 0.97], [0.96, 1.0, 0.91]];
            let q = p.map(|c| std::array::from_fn(|a| 1.0 - size * (1.0 - c[a]) / 0.1));
            let polygon = Polygon::new(q);
            let f = |p: [f64; 3]| {
                let [x, y, z] = p.map(|c| 2.0 * c - 1.0);
                x.powi(5) * y.powi(4) * z.powi(4)
            };
            let mut sum = 0.0;
            rules.integrate(&polygon, &mut |p, vector| sum += f(p) * norm(vector));
            // The same over 64 small triangles with the finest rule.
            let mut fine = vec![q];
            for _ in 0..3 {
                fine = fine
                    .into_iter()
                    .flat_map(|[a, b, c]| {
                        let half = |p, q| scale(add(p, q), 0.5);
                        let (ab, bc, ca) = (half(a, b), half(b, c), half(c, a));
                        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
                    })
                    .collect();
            }
            let only_last = Rules {
                whole: std::array::from_fn(|_| (f64::INFINITY, rules.whole[4].1.clone())),
                slivers: std::array::from_fn(|k| (-1.0, rules.slivers[k].1.clone())),
            };
            let mut want = 0.0;
            for t in fine {
                only_last.integrate(&Polygon::new(t), &mut |p, v| want += f(p) * norm(v));
            }
            let area = 0.5 * norm(cross(sub(q[1], q[0]), sub(q[2], q[0])));
            assert!((sum - want).abs() < 4e-9 * area, "{size} {sum} {want}");
        }
    }
}
