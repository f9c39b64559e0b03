//! The linear (constant-strain) tetrahedron.
//! O. C. Zienkiewicz, R. L. Taylor, "The Finite Element Method" 1 (2000), chapter 6.

use crate::elastic::element::ElementMatrices;
use crate::elastic::element::material::Material;
use crate::vec3::{cross, dot, scale, sub};

/// Volume of a tetrahedron, positive for (b − a) × (c − a) · (d − a) > 0.
pub(crate) fn volume(p: &[[f64; 3]; 4]) -> f64 {
    let [b, c, d] = [1, 2, 3].map(|k| sub(p[k], p[0]));
    dot(cross(b, c), d) / 6.0
}

/// Consistent mass.
pub(crate) fn mass(p: &[[f64; 3]; 4], density: f64) -> Vec<f64> {
    let mut mass = vec![density * volume(p) / 20.0; 16];
    for i in 0..4 {
        mass[5 * i] *= 2.0;
    }
    mass
}

/// Stiffness and consistent mass; the volume must be positive.
pub(crate) fn matrices(p: &[[f64; 3]; 4], material: &Material, density: f64) -> ElementMatrices {
    let [b, c, d] = [1, 2, 3].map(|k| sub(p[k], p[0]));
    let six = dot(cross(b, c), d);
    let volume = six / 6.0;
    // Gradients of the barycentric coordinates.
    let [gb, gc, gd] = [cross(c, d), cross(d, b), cross(b, c)].map(|n| scale(n, 1.0 / six));
    let ga = std::array::from_fn(|k| -(gb[k] + gc[k] + gd[k]));
    let gradients = [ga, gb, gc, gd];
    let mut own = ElementMatrices {
        stiffness: vec![[0.0; 9]; 16],
        mass: mass(p, density),
    };
    for i in 0..4 {
        for j in 0..4 {
            let block = &mut own.stiffness[4 * i + j];
            material.add(block, gradients[i], gradients[j], volume);
        }
    }
    own
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elastic::assemble::energy;

    const SKEWED: [[f64; 3]; 4] = [
        [0.1, 0.0, -0.2],
        [1.3, 0.2, 0.1],
        [0.2, 0.9, 0.0],
        [0.4, 0.3, 1.7],
    ];

    #[test]
    fn rigid_motions_cost_nothing_and_constant_strain_is_exact() {
        let own = matrices(&SKEWED, &Material::new(2.0, 0.3), 3.0);
        let v = volume(&SKEWED);
        let at = |u: &dyn Fn([f64; 3]) -> [f64; 3]| energy(&own, &SKEWED.map(u));
        assert!(at(&|_| [1.0, 2.0, -1.0]).abs() < 1e-14);
        assert!(at(&|[x, y, z]| [y - z, -x + 2.0 * z, x - 2.0 * y]).abs() < 1e-14);
        // Uniaxial stress: half of E ε² per volume; shear: half of μ γ².
        assert!((at(&|[x, y, z]| [x, -0.3 * y, -0.3 * z]) / v - 1.0).abs() < 1e-14);
        assert!((at(&|[_, y, _]| [y, 0.0, 0.0]) / (0.5 * v / 1.3) - 1.0).abs() < 1e-13);
    }

    /// Against the integral of Nᵢ Nⱼ by a rule that is exact for second degree (Keast 1986).
    #[test]
    fn mass_is_the_integral_of_the_functions() {
        let mut own = matrices(&SKEWED, &Material::new(1.0, 0.3), 3.0);
        let v = volume(&SKEWED);
        let (near, far) = (0.585_410_196_624_968_5, 0.138_196_601_125_010_5);
        for i in 0..4 {
            for j in 0..4 {
                let sum: f64 = (0..4)
                    .map(|p| [i, j].map(|n| if n == p { near } else { far }))
                    .map(|[a, b]| 3.0 * v / 4.0 * a * b)
                    .sum();
                assert!((own.mass[4 * i + j] - sum).abs() < 1e-15);
            }
        }
        own.lump();
        for (n, m) in own.mass.iter().enumerate() {
            let want = if n % 5 == 0 { 3.0 * v / 4.0 } else { 0.0 };
            assert!((m - want).abs() < 1e-15);
        }
    }
}
