//! The floating frame: free fall, free spin, angular momentum.

use bdtree_dynamics::rotation::{principal_axes, rotation};
use bdtree_dynamics::{FrameMass, FrameState, MassProperties};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

fn turned() -> UnitQuaternion<f64> {
    rotation(Vector3::new(0.4, -1.1, 0.7))
}

/// Position and velocity are those of the parabola.
#[test]
fn free_fall_is_exact() {
    let mass = FrameMass {
        mass_kg: 3.0,
        moments: Vector3::new(1.0, 2.0, 2.5),
    };
    let mut state = FrameState::at(Vector3::new(1.0, 100.0, -2.0), turned());
    state.velocity = Vector3::new(4.0, 1.0, 0.0);
    let h = 1.0 / 150.0;
    let weight = Vector3::new(0.0, -9.81 * 3.0, 0.0);
    for n in 1..=600 {
        state = state.after(&mass, weight, Vector3::zeros(), h);
        let t = f64::from(n) * h;
        let y = 100.0 + t - 0.5 * 9.81 * t * t;
        let off = state.position - Vector3::new(1.0 + 4.0 * t, y, -2.0);
        assert!(off.norm() < 1e-11, "{n}: {off}");
        assert!((state.velocity.y - (1.0 - 9.81 * t)).abs() < 1e-11);
    }
}

/// A symmetric top precesses: orientation = exp(t L / I₁) · Q₀ · exp(t (1/I₃ − 1/I₁) L₃ e₃).
#[test]
fn a_symmetric_top_precesses() {
    let moments = Vector3::new(2.0, 2.0, 3.5);
    let mass = FrameMass {
        mass_kg: 1.0,
        moments,
    };
    let start = FrameState::at(Vector3::zeros(), turned());
    let spin = Vector3::new(1.5, -2.0, 4.0);
    let error = |steps: u32| {
        let (end, h) = (1.2, 1.2 / f64::from(steps));
        let mut state = start;
        state.angular_momentum = start.momentum_of(&mass, spin);
        let momentum = state.angular_momentum;
        for _ in 0..steps {
            state = state.after(&mass, Vector3::zeros(), Vector3::zeros(), h);
        }
        // To the bit: it is not computed.
        assert_eq!(state.angular_momentum, momentum);
        let own = start.orientation.inverse_transform_vector(&momentum);
        let about = Vector3::new(0.0, 0.0, (1.0 / 3.5 - 1.0 / 2.0) * own.z * end);
        let expected = rotation(momentum * (end / 2.0)) * start.orientation * rotation(about);
        state.orientation.angle_to(&expected)
    };
    let (coarse, fine) = (error(100), error(400));
    assert!(coarse < 2e-3, "{coarse}");
    // Second order: a quarter of the step, a sixteenth of the error.
    assert!((12.0..20.0).contains(&(coarse / fine)), "{coarse} {fine}");
}

/// About a principal axis every step is exact.
#[test]
fn spin_about_an_axis_is_exact() {
    let mass = FrameMass {
        mass_kg: 1.0,
        moments: Vector3::new(1.0, 2.0, 2.5),
    };
    for axis in 0..3 {
        let mut state = FrameState::at(Vector3::zeros(), turned());
        let mut own = Vector3::zeros();
        own[axis] = 3.0;
        state.angular_momentum = state.momentum_of(&mass, turned() * own);
        for _ in 0..150 {
            state = state.after(&mass, Vector3::zeros(), Vector3::zeros(), 1.0 / 150.0);
        }
        let off = state.orientation.angle_to(&(turned() * rotation(own)));
        assert!(off < 1e-7, "{axis}: {off}"); // angles near 0 come from a cosine
    }
}

/// A body with three moments tumbles for ten minutes: the energy error stays where it is.
#[test]
fn energy_of_a_tumbling_body_does_not_drift() {
    let mass = FrameMass {
        mass_kg: 1.0,
        moments: Vector3::new(1.0, 2.0, 2.5),
    };
    let mut state = FrameState::at(Vector3::zeros(), turned());
    state.angular_momentum = state.momentum_of(&mass, Vector3::new(0.2, 5.0, 0.1));
    let energy = state.kinetic_energy(&mass);
    let mut worst = [0.0_f64; 2];
    for n in 0..90_000 {
        state = state.after(&mass, Vector3::zeros(), Vector3::zeros(), 1.0 / 150.0);
        let off = (state.kinetic_energy(&mass) / energy - 1.0).abs();
        let half = usize::from(n >= 45_000);
        worst[half] = worst[half].max(off);
    }
    assert!(worst[0] < 1e-3 && worst[1] < 1.05 * worst[0], "{worst:?}");
}

#[test]
fn principal_axes_give_the_tensor_back() {
    let tensor = Matrix3::new(3.0, 0.4, -0.2, 0.4, 2.0, 0.1, -0.2, 0.1, 4.0);
    let (moments, axes) = principal_axes(&tensor).expect("a tensor");
    let r = axes.to_rotation_matrix();
    let again = r.matrix() * Matrix3::from_diagonal(&moments) * r.matrix().transpose();
    assert!((again - tensor).abs().max() < 1e-14);
    assert!(moments.x <= moments.y && moments.y <= moments.z);
    assert!(principal_axes(&Matrix3::zeros()).is_none());
    let ball = MassProperties::ball(2.0, 0.5, [1.0, 2.0, 3.0])
        .rigid()
        .expect("a ball");
    assert!((ball.moments - Vector3::repeat(0.2)).norm() < 1e-15);
}
