//! The contact law: Kelvin–Voigt along the normal, Coulomb across it.
//!
//! Two spheres that overlap by δ > 0 push each other apart with `k δ + d δ̇`, never together. Over a step the force is
//! constant, and it is the one that does as much work as the spring's energy `½ k max(δ, 0)²` changes (the discrete
//! gradient of Simo and Gonzalez), plus damping:
//!
//! ```text
//! f = (V(δ₁) − V(δ₀)) / (δ₁ − δ₀) + d (max(δ₁, 0) − max(δ₀, 0)) / h,   at least 0
//! ```
//!
//! δ₁ depends on f: `δ₁ = δ_free − G f`, G being how far a unit force moves the two apart within the step. With modes
//! and motion exact for a constant force, the spring gives back what it takes, whatever its stiffness: no step makes it
//! unstable. A contact that opens or closes within the step is part of the formula.

use libm::sqrt;

use crate::error::DynamicsError;

/// What contacts are made of, for all bodies of a world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactLaw {
    /// κ: stiffness k of a contact is κ m / h², where h is the step and m the effective mass of what meets, modes included;
    /// √κ is the angle (radians) that its undamped oscillation covers in a step. 0 to π².
    pub stiffness: f64,
    /// ζ, the damping ratio of a contact: d = 2 ζ √(k m). 0 to 10.
    pub damping_ratio: f64,
    /// μ of Coulomb friction; 0 to 10.
    pub friction: f64,
}

/// Beyond it a contact's oscillation has fewer than two steps to a period.
const STIFFNESS_MAX: f64 = 1000.0;

impl Default for ContactLaw {
    /// κ = 1, ζ = 0.2, μ = 0.4.
    fn default() -> Self {
        Self {
            stiffness: 1.0,
            damping_ratio: 0.2,
            friction: 0.4,
        }
    }
}

impl ContactLaw {
    /// The law whose contacts have the stiffness `newton_per_m` where the effective mass of what meets is `mass_kg`.
    ///
    /// # Errors
    /// A step too long for the stiffness; the error says which step and which stiffness would do.
    pub fn with_stiffness(
        self,
        newton_per_m: f64,
        mass_kg: f64,
        step_s: f64,
    ) -> Result<Self, DynamicsError> {
        let stiffness = newton_per_m * step_s * step_s / mass_kg;
        if stiffness > STIFFNESS_MAX {
            return Err(DynamicsError::TooStiff {
                newton_per_m,
                step_s,
                step_max_s: sqrt(STIFFNESS_MAX * mass_kg / newton_per_m),
                newton_per_m_max: STIFFNESS_MAX * mass_kg / (step_s * step_s),
            });
        }
        Self { stiffness, ..self }.checked()
    }

    /// The same, if all numbers are within their limits.
    ///
    /// # Errors
    /// Those that are not.
    pub fn checked(self) -> Result<Self, DynamicsError> {
        const OF: [(&str, f64); 3] = [
            ("stiffness", STIFFNESS_MAX),
            ("damping_ratio", 10.0),
            ("friction", 10.0),
        ];
        let values = [self.stiffness, self.damping_ratio, self.friction];
        for ((name, limit), value) in OF.into_iter().zip(values) {
            if !(0.0..=limit).contains(&value) {
                return Err(DynamicsError::Setting { name, value, limit });
            }
        }
        Ok(self)
    }

    /// Stiffness (N/m) and damping (N s/m) of a contact whose effective mass is `mass_kg`.
    #[inline]
    pub fn spring(&self, mass_kg: f64, step_s: f64) -> Spring {
        let per_step = mass_kg / step_s;
        Spring {
            stiffness: self.stiffness * per_step / step_s,
            damping: 2.0 * self.damping_ratio * sqrt(self.stiffness) * per_step,
        }
    }
}

/// A contact's spring and damper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring {
    /// k, N/m.
    pub stiffness: f64,
    /// d, N s/m.
    pub damping: f64,
}

impl Spring {
    /// Energy of the spring at overlap `depth`, J.
    #[inline]
    pub fn energy(&self, depth: f64) -> f64 {
        let depth = depth.max(0.0);
        0.5 * self.stiffness * depth * depth
    }

    /// The normal force of the step, N, not negative: from overlap `before` (negative: a gap) at its beginning, the
    /// overlap `free` that the end would have without this force, and the `response` of the overlap to it (m/N, not
    /// negative).
    pub fn force(&self, before: f64, free: f64, response: f64, step_s: f64) -> f64 {
        let (k, d) = (self.stiffness, self.damping / step_s);
        if before < 0.0 {
            if !(free > 0.0) {
                return 0.0;
            }
            // It closes, and stays closed: f (δ₁ − δ₀) = ½ k δ₁² + d δ₁ (δ₁ − δ₀), with δ₁ = free − G f.
            let gap = -before;
            let g = response;
            let a = 1.0 + g * (0.5 * k + d);
            let b = gap - free + g * d * gap;
            let depth = positive_root(a, b, -free * gap);
            return 0.5 * k * depth * depth / (depth + gap) + d * depth;
        }
        // It stays closed.
        let spring = 0.5 * k;
        let force =
            (spring * (before + free) + d * (free - before)) / (1.0 + response * (spring + d));
        if free - response * force >= 0.0 {
            return force.max(0.0);
        }
        // It opens: (f + d δ₀) (δ₀ − δ₁) = ½ k δ₀².
        let pull = d * before;
        let apart = before - free;
        let rest = spring * before * before - pull * apart;
        if !(rest > 0.0) {
            return 0.0;
        }
        if response == 0.0 {
            return rest / apart;
        }
        positive_root(response, apart + pull * response, -rest)
    }
}

/// The positive root of a x² + b x + c with a > 0 and c ≤ 0, without cancellation.
fn positive_root(a: f64, b: f64, c: f64) -> f64 {
    let root = sqrt(b * b - 4.0 * a * c);
    if b > 0.0 {
        -2.0 * c / (b + root)
    } else {
        (root - b) / (2.0 * a)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The force that is found solves its equation, for all ways to begin and to end.
    #[test]
    fn the_force_is_that_of_the_discrete_gradient() {
        let mut solved = 0;
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        for _ in 0..20_000 {
            let h = 0.01;
            let spring = Spring {
                stiffness: libm::exp(8.0 * random()),
                damping: if random() < 0.5 { 0.0 } else { 10.0 * random() },
            };
            let (before, free) = (2.0 * random() - 1.0, 4.0 * random() - 2.0);
            let response = libm::exp(6.0 * random() - 8.0);
            let force = spring.force(before, free, response, h);
            let after = free - response * force;
            let rate = (after.max(0.0) - before.max(0.0)) / h;
            let work = spring.energy(after) - spring.energy(before);
            let expected = if after == before {
                spring.stiffness * before.max(0.0)
            } else {
                work / (after - before)
            } + spring.damping * rate;
            assert!(force >= 0.0);
            if expected > 0.0 {
                let size = expected.max(free.abs() / response);
                assert!(
                    (force - expected).abs() <= 1e-9 * size,
                    "{force} {expected}"
                );
                solved += 1;
            } else {
                assert!(force == 0.0, "{force} {expected}");
            }
        }
        assert!(solved > 5000);
    }
}
