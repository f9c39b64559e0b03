//! Isotropic, linear materials: what relates strain and stress.

/// A material by Lamé's λ and μ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Material {
    /// First parameter.
    pub lambda: f64,
    /// Shear modulus.
    pub mu: f64,
}

impl Material {
    /// From Young's modulus and Poisson's ratio in (-1, 0.5).
    pub(crate) fn new(young: f64, poisson: f64) -> Self {
        Self {
            lambda: young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)),
            mu: 0.5 * young / (1.0 + poisson),
        }
    }

    /// Adds `weight` times the stiffness between two functions with these gradients to a 3 × 3
    /// block, row-major: λ ∂ᵢa ∂ⱼb + μ (∂ⱼa ∂ᵢb + ∇a·∇b δᵢⱼ).
    pub(crate) fn add(&self, block: &mut [f64; 9], a: [f64; 3], b: [f64; 3], weight: f64) {
        let (lambda, mu) = (weight * self.lambda, weight * self.mu);
        let along = mu * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
        for i in 0..3 {
            for j in 0..3 {
                block[3 * i + j] += lambda * a[i] * b[j] + mu * a[j] * b[i];
            }
            block[4 * i] += along;
        }
    }
}
