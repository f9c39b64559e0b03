//! Whether an element has a volume, and which way round its corners go.

use super::trilinear::{CORNERS, determinant, rounding, tangents};
use crate::vec3::sub;

/// What the corners of an element enclose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Sense {
    /// A volume, in the right order.
    Positive,
    /// A volume, mirrored.
    Negative,
    /// Nothing, as far as f64 can tell.
    Flat,
    /// A hexahedron whose map from the cube folds over: the Jacobian has both signs.
    Folded,
}

/// For tetrahedra: the sign of (b − a) × (c − a) · (d − a).
pub(super) fn tetrahedron(corners: [[f64; 3]; 4]) -> Sense {
    let [a, b, c, d] = corners;
    let edges = [b, c, d].map(|p| sub(p, a));
    let value = determinant(edges);
    let zero = rounding(&corners, edges);
    if value > zero {
        Sense::Positive
    } else if value < -zero {
        Sense::Negative
    } else {
        Sense::Flat
    }
}

/// For hexahedra in VTK's order: the sign of the Jacobian at the 2 × 2 × 2 Gauss points, and at the
/// corners, where it may be zero too.
pub(super) fn hexahedron(corners: &[[f64; 3]; 8]) -> Sense {
    // (1 ± 1/√3)/2.
    let gauss = [0.5 - 0.5 / 3.0_f64.sqrt(), 0.5 + 0.5 / 3.0_f64.sqrt()];
    let sign = |xi: [f64; 3]| {
        let columns = tangents(corners, xi);
        let (value, zero) = (determinant(columns), rounding(corners, columns));
        i32::from(value > zero) - i32::from(value < -zero)
    };
    let inside = CORNERS.map(|corner| sign(corner.map(|s| gauss[usize::from(s > 0.5)])));
    let outside = CORNERS.map(sign);
    let both = inside.iter().chain(&outside);
    if inside.iter().all(|&s| s > 0) && outside.iter().all(|&s| s >= 0) {
        Sense::Positive
    } else if inside.iter().all(|&s| s < 0) && outside.iter().all(|&s| s <= 0) {
        Sense::Negative
    } else if both.clone().all(|&s| s == 0) {
        Sense::Flat
    } else {
        Sense::Folded
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_is_positive_and_its_mirror_negative() {
        assert_eq!(hexahedron(&CORNERS), Sense::Positive);
        let [a, b, c, d, e, f, g, h] = CORNERS;
        assert_eq!(hexahedron(&[e, f, g, h, a, b, c, d]), Sense::Negative);
        assert_eq!(hexahedron(&[b, a, c, d, e, f, g, h]), Sense::Folded);
        let flat = CORNERS.map(|[x, y, _]| [x, y, 0.25]);
        assert_eq!(hexahedron(&flat), Sense::Flat);
    }

    #[test]
    fn a_corner_may_be_flat_but_not_folded() {
        // Corner 6 moves towards the middle along the diagonal: its Jacobian is 3t − 2.
        let at = |t: f64| {
            let mut corners = CORNERS;
            corners[6] = [t; 3];
            hexahedron(&corners)
        };
        assert_eq!(at(0.75), Sense::Positive);
        assert_eq!(at(0.625), Sense::Folded);
        // A prism: edges 2 and 6 lie in the planes x + y = 1 of their neighbours.
        let mut prism = CORNERS;
        prism[2] = [0.5, 0.5, 0.0];
        prism[6] = [0.5, 0.5, 1.0];
        assert_eq!(hexahedron(&prism), Sense::Positive);
    }

    #[test]
    fn thin_is_not_flat() {
        let corners = |height: f64, far: f64| {
            [
                [0.0, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [0.3, 0.3, height],
            ]
            .map(|p| p.map(|x| x + far))
        };
        assert_eq!(tetrahedron(corners(1e-12, 0.0)), Sense::Positive);
        assert_eq!(tetrahedron(corners(-1e-12, 0.0)), Sense::Negative);
        assert_eq!(tetrahedron(corners(0.0, 0.0)), Sense::Flat);
        // A million away, 1e-10 is one step of f64.
        assert_eq!(tetrahedron(corners(1.2e-10, 1e6)), Sense::Flat);
        assert_eq!(tetrahedron(corners(1e-7, 1e6)), Sense::Positive);
    }
}
