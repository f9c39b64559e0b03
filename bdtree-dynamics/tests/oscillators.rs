//! One mode against closed forms, to 1e-12 of the state.

use bdtree_dynamics::{Oscillator, Transition};

/// The closed forms of `q̈ + 2γ q̇ + ω² q = a`, where they do not cancel: state from q, q̇ and a.
fn closed_form(omega: f64, gamma: f64, h: f64, [q, v]: [f64; 2], a: f64) -> [f64; 2] {
    // From where the constant force rests.
    let rest = a / (omega * omega);
    let x = q - rest;
    let decay = (-gamma * h).exp();
    let d = omega * omega - gamma * gamma;
    let (c, s) = if d > 0.0 {
        let root = d.sqrt();
        ((root * h).cos(), (root * h).sin() / root)
    } else if d < 0.0 {
        let root = (-d).sqrt();
        ((root * h).cosh(), (root * h).sinh() / root)
    } else {
        (1.0, h)
    };
    [
        rest + decay * (x * c + (v + gamma * x) * s),
        decay * (v * c - (omega * omega * x + gamma * v) * s),
    ]
}

fn near(found: [f64; 2], expected: [f64; 2], omega: f64, tolerance: f64) {
    // Both in units of length.
    let scale = expected[0]
        .abs()
        .max(expected[1].abs() / omega.max(1.0))
        .max(1e-3);
    assert!(
        (found[0] - expected[0]).abs() <= tolerance * scale,
        "{found:?} {expected:?}"
    );
    let speed = scale * omega.max(1.0);
    assert!(
        (found[1] - expected[1]).abs() <= tolerance * speed,
        "{found:?} {expected:?}"
    );
}

#[test]
fn a_step_is_the_closed_form() {
    for omega in [0.7, 3.0, 40.0, 900.0] {
        for ratio in [0.0, 1e-3, 0.2, 0.9, 1.0, 1.1, 2.5] {
            for h in [1e-3, 1.0 / 150.0, 0.1] {
                let gamma = ratio * omega;
                if gamma * h > 5.0 {
                    continue; // hyperbolic functions cancel
                }
                let of = Oscillator {
                    omega_rad_s: omega,
                    decay_per_s: gamma,
                };
                let step = of.transition(h).expect("a step");
                for (state, a) in [([1.0, 0.0], 0.0), ([0.0, 1.0], 0.0), ([0.3, -2.0], 50.0)] {
                    // The reference's own rest position cancels for slow modes.
                    let tolerance = if omega * h < 0.1 && a != 0.0 {
                        1e-10
                    } else {
                        1e-12
                    };
                    let expected = closed_form(omega, gamma, h, state, a);
                    near(step.apply(state, a), expected, omega, tolerance);
                }
            }
        }
    }
}

/// Without stiffness: free motion, and a decay.
#[test]
fn without_stiffness_it_flies() {
    let h = 0.02;
    let free = Oscillator {
        omega_rad_s: 0.0,
        decay_per_s: 0.0,
    }
    .transition(h)
    .expect("a step");
    near(
        free.apply([1.0, 3.0], 5.0),
        [1.0 + 3.0 * h + 2.5 * h * h, 3.0 + 5.0 * h],
        1.0,
        1e-15,
    );
    for gamma in [1e-9, 0.3, 8.0, 400.0_f64] {
        let of = Oscillator {
            omega_rad_s: 0.0,
            decay_per_s: gamma,
        };
        let step = of.transition(h).expect("a step");
        // v' = a − 2γ v.
        let x = 2.0 * gamma * h;
        let kept = (-x).exp();
        let mean = -(-x).exp_m1() / x;
        let [q, v] = step.apply([0.0, 3.0], 0.0);
        near([q, v], [3.0 * h * mean, 3.0 * kept], 1.0, 1e-13);
        let [_, v] = step.apply([0.0, 0.0], 5.0);
        near([0.0, v], [0.0, 5.0 * h * mean], 1.0, 1e-13);
    }
}

/// A thousand short steps are one long step, for all kinds of damping, where closed forms cancel too.
#[test]
fn many_steps_are_one() {
    for (omega, gamma) in [
        (1e-6, 0.0),
        (1e-3, 5.0),
        (2.0, 2.0),
        (2.0, 2.0 + 1e-9),
        (2.0, 2.0 - 1e-9),
        (5.0, 300.0),
        (300.0, 1.0),
    ] {
        let of = Oscillator {
            omega_rad_s: omega,
            decay_per_s: gamma,
        };
        let long = of.transition(0.5).expect("a step");
        let short: Transition = of.transition(0.0005).expect("a step");
        let start = [0.4, -1.0];
        let mut state = start;
        for _ in 0..1000 {
            state = short.apply(state, 2.0);
        }
        near(state, long.apply(start, 2.0), omega, 2e-12);
    }
}

/// An impulse is a change of q̇: what follows is the closed form.
#[test]
fn an_impulse_rings() {
    let (omega, gamma, h) = (31.0, 0.8, 1.0 / 150.0);
    let step = Oscillator {
        omega_rad_s: omega,
        decay_per_s: gamma,
    }
    .transition(h)
    .expect("a step");
    let mut state = [0.0, 0.25];
    for n in 1..=3000 {
        state = step.apply(state, 0.0);
        let t = f64::from(n) * h;
        let root = (omega * omega - gamma * gamma).sqrt();
        let q = 0.25 / root * (-gamma * t).exp() * (root * t).sin();
        assert!((state[0] - q).abs() < 1e-12 * 0.25, "{n}: {} {q}", state[0]);
    }
}

#[test]
fn far_too_fast_modes_are_refused() {
    for of in [
        Oscillator {
            omega_rad_s: 1e9,
            decay_per_s: 0.0,
        },
        Oscillator {
            omega_rad_s: 1.0,
            decay_per_s: f64::NAN,
        },
        Oscillator {
            omega_rad_s: -1.0,
            decay_per_s: 0.0,
        },
    ] {
        let error = of.transition(0.01).expect_err("refused").to_string();
        assert!(error.contains("at most 1e6"), "{error}");
    }
    let of = Oscillator {
        omega_rad_s: 1.0,
        decay_per_s: 0.0,
    };
    assert!(of.transition(0.0).is_err() && of.transition(f64::INFINITY).is_err());
}
