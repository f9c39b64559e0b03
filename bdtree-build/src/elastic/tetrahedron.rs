//! The linear (constant-strain) tetrahedron.
//! O. C. Zienkiewicz, R. L. Taylor, "The Finite Element Method" 1 (2000), chapter 6.

use super::assemble::ElementMatrices;
use super::law::Law;
use super::vec3::{cross, dot, scale, sub};

/// Volume of a tetrahedron, positive for (b − a) × (c − a) · (d − a) > 0.
pub(crate) fn volume(p: &[[f64; 3]; 4]) -> f64 {
    let [b, c, d] = [1, 2, 3].map(|k| sub(p[k], p[0]));
    dot(cross(b, c), d) / 6.0
}

/// Stiffness and consistent mass; the volume must be positive.
pub(crate) fn matrices(p: &[[f64; 3]; 4], law: &Law, density: f64) -> ElementMatrices {
    let [b, c, d] = [1, 2, 3].map(|k| sub(p[k], p[0]));
    let six = dot(cross(b, c), d);
    let volume = six / 6.0;
    // Gradients of the barycentric coordinates.
    let [gb, gc, gd] = [cross(c, d), cross(d, b), cross(b, c)].map(|n| scale(n, 1.0 / six));
    let ga = std::array::from_fn(|k| -(gb[k] + gc[k] + gd[k]));
    let gradients = [ga, gb, gc, gd];
    let mut own = ElementMatrices {
        stiffness: vec![[0.0; 9]; 16],
        mass: vec![density * volume / 20.0; 16],
    };
    for i in 0..4 {
        own.mass[5 * i] *= 2.0;
        for j in 0..4 {
            let block = &mut own.stiffness[4 * i + j];
            law.add(block, gradients[i], gradients[j], volume);
        }
    }
    own
}
