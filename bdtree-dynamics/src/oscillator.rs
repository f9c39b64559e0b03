//! One mode: a damped oscillator, integrated exactly over a step in which the force is constant.

use libm::{cos, exp, expm1, sin, sqrt};

use crate::error::DynamicsError;

/// Below this |(ωh)² − (γh)²| cosine and sine are summed up as series, which do not care about the sign.
const NEARLY_CRITICAL: f64 = 0.25;

/// Below this ωh the response to a force is summed up as a series: the closed form would cancel.
const SLOW: f64 = 0.5;

/// Terms of a series: the first one left out is below 2⁻⁶⁰ of the sum.
const TERMS: usize = 24;

/// `q̈ + 2γ q̇ + ω² q = a`: a mode of unit mass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Oscillator {
    /// ω of the undamped oscillator, rad/s; 0 for a mode without stiffness.
    pub omega_rad_s: f64,
    /// γ, 1/s; critical at ω. A damping ratio ζ is γ = ζ ω; Rayleigh damping α M + β K is γ = (α + β ω²) / 2.
    pub decay_per_s: f64,
}

/// What a step of an [`Oscillator`] does, for a constant a:
/// `q ← q_q q + q_v q̇ + q_a a`, `q̇ ← v_q q + v_v q̇ + q_v a`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transition {
    /// No unit.
    pub q_q: f64,
    /// Seconds. Also what a adds to q̇.
    pub q_v: f64,
    /// Seconds²; not negative.
    pub q_a: f64,
    /// 1/s.
    pub v_q: f64,
    /// No unit.
    pub v_v: f64,
}

impl Oscillator {
    /// The exact step of length `step_s` (Duhamel's integral of a constant force). Each number is within a few units in
    /// the last place of what it is a sum of: relative to the state, errors are below 1e-14.
    ///
    /// # Errors
    /// ω or γ that is negative, not finite or, times the step, beyond 1e6; a step that is not positive and finite.
    pub fn transition(&self, step_s: f64) -> Result<Transition, DynamicsError> {
        let (w, g) = (self.omega_rad_s * step_s, self.decay_per_s * step_s);
        if !(step_s > 0.0 && step_s.is_finite()) {
            return Err(DynamicsError::Step { step_s });
        }
        const LARGEST: f64 = 1e6;
        if !((0.0..=LARGEST).contains(&w) && (0.0..=LARGEST).contains(&g)) {
            return Err(DynamicsError::Oscillator {
                omega_rad_s: self.omega_rad_s,
                decay_per_s: self.decay_per_s,
                step_s,
            });
        }
        let delta = (w - g) * (w + g);
        // In units of the step: position from position and speed, speed from speed, position from force.
        let (q_q, q_v, v_v, q_a);
        if delta < -NEARLY_CRITICAL {
            // Two decays, e^(μ−g) and e^(−μ−g); μ − g is computed without cancellation.
            let mu = sqrt(-delta);
            let (fast, slow) = (g + mu, w * w / (g + mu));
            let (e_slow, e_fast) = (exp(-slow), exp(-fast));
            let ratio = g / mu;
            q_q = 0.5 * (e_slow * (1.0 + ratio) - e_fast * slow / mu);
            v_v = 0.5 * (e_fast * (1.0 + ratio) - e_slow * slow / mu);
            q_v = 0.5 * (e_slow - e_fast) / mu;
            q_a = 0.5 * (mean_decay(slow) - mean_decay(fast)) / mu;
        } else {
            let (c, s) = if delta > NEARLY_CRITICAL {
                let theta = sqrt(delta);
                (cos(theta), sin(theta) / theta)
            } else {
                cosine_and_sine(delta)
            };
            let decay = exp(-g);
            q_q = decay * (c + g * s);
            v_v = decay * (c - g * s);
            q_v = decay * s;
            q_a = if w >= SLOW {
                (1.0 - q_q) / (w * w)
            } else {
                response(w, g)
            };
        }
        Ok(Transition {
            q_q,
            q_v: step_s * q_v,
            q_a: step_s * step_s * q_a,
            v_q: -w * w * q_v / step_s,
            v_v,
        })
    }
}

impl Transition {
    /// The state after the step, from q, q̇ and the constant a.
    #[inline]
    pub fn apply(&self, [q, v]: [f64; 2], a: f64) -> [f64; 2] {
        [
            self.q_q * q + self.q_v * v + self.q_a * a,
            self.v_q * q + self.v_v * v + self.q_v * a,
        ]
    }
}

/// (1 − e⁻ˣ) / x: the mean of e⁻ᵗ for t from 0 to x.
fn mean_decay(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { -expm1(-x) / x }
}

/// cos √δ and sin √δ / √δ, which for negative δ are cosh √−δ and sinh √−δ / √−δ.
fn cosine_and_sine(delta: f64) -> (f64, f64) {
    let (mut c, mut s) = (0.0, 0.0);
    // From the smallest terms to the largest: 1 − δ/2 (1 − δ/12 (…)).
    for k in (1..TERMS / 2).rev() {
        let n = 2.0 * k as f64;
        c = (1.0 + c) * -delta / (n * (n - 1.0));
        s = (1.0 + s) * -delta / (n * (n + 1.0));
    }
    (1.0 + c, 1.0 + s)
}

/// Position after a unit step under a unit force from rest: the Taylor series of `s̈ = 1 − 2 g ṡ − w² s`.
fn response(w: f64, g: f64) -> f64 {
    let (mut before, mut last) = (0.0, 0.5);
    let mut sum = 0.5;
    for k in 1..TERMS {
        let k = k as f64;
        let next = -(2.0 * g * (k + 1.0) * last + w * w * before) / ((k + 2.0) * (k + 1.0));
        (before, last) = (last, next);
        sum += next;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use libm::{cosh, sinh};

    #[test]
    fn series_meet_the_functions() {
        for delta in [-0.25, -1e-3, 0.0, 1e-9, 0.25_f64] {
            let (c, s) = cosine_and_sine(delta);
            let root = sqrt(delta.abs());
            let (expected_c, expected_s) = if delta > 0.0 {
                (cos(root), sin(root) / root)
            } else if delta < 0.0 {
                (cosh(root), sinh(root) / root)
            } else {
                (1.0, 1.0)
            };
            assert!((c - expected_c).abs() < 4e-16 && (s - expected_s).abs() < 4e-16);
        }
    }
}
