//! Whether an oriented box and a triangle share a point, and the triangle's point deepest inside.
//!
//! Separating axes (Gottschalk, Lin and Manocha, "OBBTree", 1996; Akenine-Möller, "Fast 3D
//! Triangle-Box Overlap Testing", 2001) in the box's axes, where all signs are exact: three faces,
//! the triangle's plane, and each edge of the triangle seen along each axis. For boxes without
//! width and triangles without area these are still enough: widen the box a little, and one of
//! them separates; there are finitely many, so one does for boxes as thin as you like.

use super::clip::Polygon;
use super::exact::{above, tame, turn};
use super::{Triangle, combine};
use crate::math::rotation_matrix;
use crate::math::{dot, scale, sqrt, sub};

/// An oriented box: the points `center + Σ y_k axis_k` with `|y_k| ≤ half_extents[k]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientedBox {
    center: [f64; 3],
    /// Directions of its edges: unit and orthogonal to rounding.
    axes: [[f64; 3]; 3],
    half_extents: [f64; 3],
}

/// Where a triangle is deepest in a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxContact {
    /// The triangle's point.
    pub point: [f64; 3],
    /// Weights of the corners that give `point`, none negative, sum 1 within 16 u.
    pub barycentric: [f64; 3],
    /// Into the box, across the face nearest to `point`.
    pub normal: [f64; 3],
    /// Distance of `point` to that face; not negative.
    pub depth: f64,
}

impl OrientedBox {
    /// Returns the box about `center` with axes turned by the quaternion (x, y, z, w), normalised
    /// first. Half extents may be 0.
    pub fn new(center: [f64; 3], rotation: [f64; 4], half_extents: [f64; 3]) -> Self {
        let norm = sqrt(rotation.iter().fold(0.0, |sum, c| sum + c * c));
        let rows = rotation_matrix(rotation.map(|c| c / norm));
        Self {
            center,
            axes: [0, 1, 2].map(|k| rows.map(|row| row[k])),
            half_extents,
        }
    }

    /// Returns the center.
    pub fn center(&self) -> [f64; 3] {
        self.center
    }

    /// Returns the directions of its edges.
    pub fn axes(&self) -> [[f64; 3]; 3] {
        self.axes
    }

    /// Returns half the lengths of its edges.
    pub fn half_extents(&self) -> [f64; 3] {
        self.half_extents
    }

    /// Returns a point in the box's axes: `axis_k · (x − center)`, each operation rounded once.
    #[inline]
    pub fn local(&self, x: [f64; 3]) -> [f64; 3] {
        let from_center = sub(x, self.center);
        self.axes.map(|axis| dot(axis, from_center))
    }

    /// Returns where the closed triangle is deepest in the closed box, nothing if they do not share
    /// a point.
    ///
    /// That they do is decided exactly on the corners as [`OrientedBox::local`] returns them. With
    /// u = 2⁻⁵³ and L the largest `|corner − center|` of any coordinate that map is off by 12 u L,
    /// and the axes are orthogonal to within 90 u: boxes and triangles that touch here are at most
    /// 256 u L apart. `depth` is the largest of all the triangle's points within 64 u times L and the
    /// half extents (tested, not proven); among equal faces the first of x, y, z counts.
    pub fn contact(&self, tri: &Triangle) -> Option<BoxContact> {
        let local = tri.map(|corner| self.local(corner));
        if !touches(&local, self.half_extents) {
            return None;
        }
        let (barycentric, face) = deepest(&local, self.half_extents);
        // Inwards, against the face's own normal.
        let inwards = if face.positive { -1.0 } else { 1.0 };
        Some(BoxContact {
            point: combine(tri, barycentric),
            barycentric,
            normal: scale(self.axes[face.axis], inwards),
            depth: face.depth.max(0.0),
        })
    }
}

/// Returns whether a triangle in the box's axes touches the box; exact.
#[inline]
fn touches(tri: &Triangle, half: [f64; 3]) -> bool {
    for (k, h) in half.into_iter().enumerate() {
        let [a, b, c] = tri.map(|corner| corner[k]);
        if a.min(b).min(c) > h || a.max(b).max(c) < -h {
            return false;
        }
    }
    if tri.iter().any(|y| (0..3).all(|k| y[k].abs() <= half[k])) {
        return true;
    }
    let [tri, [half, ..]] = tame([*tri, [half; 3]]);
    !(plane_separates(&tri, half) || edge_separates(&tri, half))
}

/// Whether all of the box is strictly on one side of the triangle's plane.
fn plane_separates([a, b, c]: &Triangle, half: [f64; 3]) -> bool {
    let side = |corner: usize| above(*a, *b, *c, box_corner(half, corner));
    let first = side(0);
    first != 0 && (1..8).all(|corner| side(corner) == first)
}

/// Whether, seen along some axis, the line of some edge has all of the box strictly on one side
/// and the triangle not there.
fn edge_separates(tri: &Triangle, half: [f64; 3]) -> bool {
    for axis in 0..3 {
        for i in 0..3 {
            let (a, b, c) = (tri[i], tri[(i + 1) % 3], tri[(i + 2) % 3]);
            // The four corners that differ where it can be seen.
            let bits = [1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3)];
            let side = |corner| turn(axis, a, b, box_corner(half, corner));
            let first = side(0);
            let all = first != 0
                && [bits[0], bits[1], bits[0] | bits[1]]
                    .into_iter()
                    .all(|corner| side(corner) == first);
            if all && turn(axis, a, b, c) != first {
                return true;
            }
        }
    }
    false
}

/// The corner of the box whose coordinate k is positive where bit k is set.
fn box_corner(half: [f64; 3], bits: usize) -> [f64; 3] {
    [0, 1, 2].map(|k| {
        if bits >> k & 1 == 1 {
            half[k]
        } else {
            -half[k]
        }
    })
}

/// The face of the box nearest to a point.
#[derive(Clone, Copy)]
struct Face {
    axis: usize,
    positive: bool,
    /// The point's distance to it, negative outside.
    depth: f64,
}

fn nearest_face(y: [f64; 3], half: [f64; 3]) -> Face {
    let depth = |axis: usize| half[axis] - y[axis].abs();
    let nearer = |best, axis| {
        if depth(axis) < depth(best) {
            axis
        } else {
            best
        }
    };
    let axis = (1..3).fold(0, nearer);
    Face {
        axis,
        positive: y[axis] >= 0.0,
        depth: depth(axis),
    }
}

/// Returns the weights of the point that is deepest in the box, and the face nearest to it.
///
/// Where a face is the nearest one the depth below it is linear, so it is largest at a vertex of
/// that piece of the triangle.
fn deepest(tri: &Triangle, half: [f64; 3]) -> ([f64; 3], Face) {
    let below = |axis: usize, sign: f64| tri.map(|corner| half[axis] - sign * corner[axis]);
    let faces = [
        (0, 1.0),
        (0, -1.0),
        (1, 1.0),
        (1, -1.0),
        (2, 1.0),
        (2, -1.0),
    ];
    let depths = faces.map(|(axis, sign)| below(axis, sign));
    let mut best = ([1.0, 0.0, 0.0], nearest_face(tri[0], half));
    'faces: for own in depths {
        // A triangle has three vertices, and each of five cuts adds one.
        let mut piece = Polygon::<8>::triangle();
        for other in depths {
            let farther = sub(other, own);
            // Most triangles lie below one face of a large box: nothing is left below the others, and nothing is cut there.
            if farther.iter().all(|x| *x < 0.0) {
                continue 'faces;
            }
            if farther.iter().all(|x| *x >= 0.0) {
                continue;
            }
            // Cuts that rounding makes too many are left out: the piece is larger then.
            piece = piece.clipped(farther).unwrap_or(piece);
        }
        for &weights in piece.vertices() {
            let face = nearest_face(combine(tri, weights), half);
            if face.depth > best.1.depth {
                best = (weights, face);
            }
        }
    }
    best
}
