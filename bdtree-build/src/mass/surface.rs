//! What a surface encloses: whether it is closed, and the integrals of the polyhedron.
//!
//! A triangle and a fixed point span a tetrahedron whose volume has the sign of the side that the triangle shows; over
//! a closed surface their sums are the integrals of the solid (S. Lien, J. T. Kajiya, "A symbolic method for
//! calculating the integral properties of arbitrary nonconvex polyhedra", 1984; B. Mirtich, "Fast and accurate
//! computation of polyhedral mass properties", 1996). Coordinates are from the middle of the box, over its diagonal, so
//! that meshes far from the origin lose nothing; sums keep what rounding takes.

use super::integrals::{Frame, Integrals, Sum, products};
use super::{MassProperties, MassSource};
use crate::elastic::surface::components::weld;
use crate::vec3::{add, bounds, cross, dot, norm, scale, sub};

/// Volumes below this share of the sum of all tetrahedra's are what rounding leaves of nothing.
const FLAT: f64 = 1e-12;

/// What a surface encloses.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Enclosed {
    /// It is open, or folded flat.
    Nothing,
    /// A negative volume.
    InsideOut,
    /// A solid.
    Solid(Solid),
}

/// The integrals of a solid of density 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Solid {
    integrals: Integrals,
    about: [f64; 3],
    length: f64,
}

impl Solid {
    /// Its mass properties with a density; `None` where they are beyond the range of numbers.
    pub(super) fn of_solid(&self, density_kg_m3: f64, scale_m: f64) -> Option<MassProperties> {
        let frame = Frame {
            about: self.about,
            length: self.length,
        };
        let volume = self.integrals.whole * self.length.powi(3);
        let mass = density_kg_m3 * volume * scale_m.powi(3);
        let own = (density_kg_m3, scale_m);
        (volume.is_normal() && mass.is_normal())
            .then(|| (self.integrals).properties(frame, (mass, volume), own, MassSource::Surface))
    }
}

/// Looks at a surface, whose corners must be vertices.
pub(super) fn enclosed(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Enclosed {
    if !is_closed(positions, triangles) {
        return Enclosed::Nothing;
    }
    let corners = triangles.iter().flatten();
    let (low, high) = bounds(corners.map(|&v| positions[v as usize]));
    let about: [f64; 3] = std::array::from_fn(|a| 0.5 * low[a] + 0.5 * high[a]);
    let length = norm(sub(high, low));
    if !(length.is_normal() && length > 0.0) {
        return Enclosed::Nothing;
    }
    let (mut sums, mut all) = ([Sum::default(); 10], 0.0);
    for t in triangles {
        let [a, b, c] = t.map(|v| sub(positions[v as usize], about).map(|x| x / length));
        // Six times the volume of the tetrahedron whose fourth corner is the middle.
        let six = dot(a, cross(b, c));
        all += six.abs();
        let total = add(a, add(b, c));
        let [aa, bb, cc, tt] = [a, b, c, total].map(|p| products(p, p));
        sums[0].add(six / 6.0);
        for (k, x) in scale(total, six / 24.0).into_iter().enumerate() {
            sums[1 + k].add(x);
        }
        for k in 0..6 {
            sums[4 + k].add(six / 120.0 * (aa[k] + bb[k] + cc[k] + tt[k]));
        }
    }
    let [whole, first @ .., s0, s1, s2, s3, s4, s5] = sums.map(Sum::value);
    match whole {
        v if !(v.abs() > FLAT * all / 6.0) => Enclosed::Nothing,
        v if v < 0.0 => Enclosed::InsideOut,
        _ => Enclosed::Solid(Solid {
            integrals: Integrals {
                whole,
                first,
                second: [s0, s1, s2, s3, s4, s5],
            },
            about,
            length,
        }),
    }
}

/// Whether every edge belongs to two triangles, one in each direction, with corners at equal positions taken as one.
/// Triangles that have two corners at one position are left out: they are edges, and their two sides cancel.
fn is_closed(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> bool {
    let weld = weld(positions);
    let mut edges: Vec<(u32, u32, bool)> = Vec::with_capacity(3 * triangles.len());
    for t in triangles {
        let [a, b, c] = t.map(|v| weld[v as usize] as u32);
        if a != b && b != c && c != a {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                edges.push((from.min(to), from.max(to), from > to));
            }
        }
    }
    edges.sort_unstable();
    let (pairs, rest) = edges.as_chunks::<2>();
    let opposite = |[x, y]: &[(u32, u32, bool); 2]| (x.0, x.1) == (y.0, y.1) && x.2 != y.2;
    // Four at one edge sort as two in one direction before two in the other.
    !pairs.is_empty() && rest.is_empty() && pairs.iter().all(opposite)
}
