//! Whether a triangle has an area and a fan fills its polygon, and what is said where that is not so.

use crate::vec3::{add, cross, dot, norm2};

/// Something odd about a triangle that is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Oddity {
    RepeatedCorner,
    ZeroArea,
    OutsidePolygon,
}

impl Oddity {
    pub(super) const ALL: [Self; 3] = [Self::RepeatedCorner, Self::ZeroArea, Self::OutsidePolygon];

    /// What is odd about the triangle of these corners, which must all be known.
    pub(super) fn of(corners: [u32; 3], positions: &[[f64; 3]]) -> Option<Self> {
        let [a, b, c] = corners;
        if a == b || b == c || c == a {
            return Some(Self::RepeatedCorner);
        }
        let is_degenerate = is_degenerate(corners.map(|corner| positions[corner as usize]));
        is_degenerate.then_some(Self::ZeroArea)
    }

    /// What one triangle does.
    pub(super) fn one(self) -> &'static str {
        match self {
            Self::RepeatedCorner => "repeats a corner (kept)",
            Self::ZeroArea => "has zero area (kept)",
            Self::OutsidePolygon => {
                "lies outside its polygon, which is concave and cut into a fan: triangulate it when exporting"
            }
        }
    }

    /// What several are called.
    pub(super) fn many(self) -> &'static str {
        match self {
            Self::RepeatedCorner => "triangles that repeat a corner (kept)",
            Self::ZeroArea => "triangles with zero area (kept)",
            Self::OutsidePolygon => "triangles outside their concave polygons",
        }
    }
}

/// The first triangle of a polygon's fan that lies outside of the polygon: it turns the other way than the whole does. Of
/// polygons that are far from flat nothing is said, since no surface of theirs is the right one. All corners must be known.
pub(super) fn outside(fan: &[[u32; 3]], positions: &[[f64; 3]]) -> Option<usize> {
    /// Share of the polygon's area that counts: less is what rounding leaves.
    const SHARE: f64 = 1e-6;
    /// Cosine of the angle between the normals of the triangle and of the whole, at most: 155° and more.
    const TURNED: f64 = -0.9;
    if fan.len() < 2 {
        return None;
    }
    let area = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|corner| positions[corner as usize]);
        let edge = |p: [f64; 3], q: [f64; 3]| [0, 1, 2].map(|k| q[k] - p[k]);
        cross(edge(a, b), edge(a, c))
    };
    let whole = fan.iter().map(area).fold([0.0; 3], add);
    // NaN, of coordinates whose products are beyond f64, is not below.
    fan.iter().position(|corners| {
        let area = area(corners);
        let along = dot(area, whole);
        along < -SHARE * norm2(whole) && along < TURNED * (norm2(area) * norm2(whole)).sqrt()
    })
}

/// True if the triangle's area is zero as far as f64 can tell: the cross product of two edges is
/// no longer than its own rounding error.
fn is_degenerate(corners: [[f64; 3]; 3]) -> bool {
    // Relative to the product of the edges; the cross product's rounding error is below 4 ε of it.
    const TOLERANCE: f64 = 8.0 * f64::EPSILON;
    let [a, b, c] = corners;
    // Quarter lengths: a difference of finite numbers then stays finite.
    let edge = |p: [f64; 3], q: [f64; 3]| [0, 1, 2].map(|k| 0.25 * q[k] - 0.25 * p[k]);
    let (mut e, mut f) = (edge(a, b), edge(a, c));
    // To unit size, so that neither tiny nor huge meshes leave the range of f64.
    for v in [&mut e, &mut f] {
        let size = v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        if size == 0.0 {
            return true;
        }
        *v = v.map(|x| x / size);
    }
    norm2(cross(e, f)) <= TOLERANCE * TOLERANCE * norm2(e) * norm2(f)
}
