//! The river below the bridge: what falls in is carried by it and braked, and hangs where it has come to rest.

use std::error::Error;

use bdtree_dynamics::{BodyId, BodyState, World};

/// Height of its surface, m.
pub(super) const SURFACE_M: f64 = -15.0;

/// Depth over which a body dips in, m.
const DIP_M: f64 = 0.2;

/// Half of density times drag coefficient times area, over the mass of a fish: what brakes it, per meter of its way.
const DRAG_PER_M: f64 = 2.5;

/// What brakes its turning, 1/s.
const TURNING_PER_S: f64 = 3.0;

/// How much of a body at this height is below the surface.
fn dipped(height: f64) -> f64 {
    ((SURFACE_M - height) / DIP_M + 0.5).clamp(0.0, 1.0)
}

/// Whether most of a body at this height is in the water.
pub(super) fn is_in(height: f64) -> bool {
    dipped(height) > 0.5
}

/// Pushes a body as heavy as water for the next step.
pub(super) fn push(world: &mut World, body: BodyId, mass_kg: f64) -> Result<(), Box<dyn Error>> {
    let BodyState {
        position,
        velocity,
        angular_momentum,
        ..
    } = world.state(body)?;
    let share = dipped(position[1]);
    if share == 0.0 {
        return Ok(());
    }
    let options = world.options();
    let speed = velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
    // As if at the speed that the drag leaves at the end of the step: it never turns a body back.
    let braked = DRAG_PER_M * speed / (1.0 + DRAG_PER_M * speed * options.step_s);
    let force = [0, 1, 2].map(|k| -share * mass_kg * (options.gravity[k] + braked * velocity[k]));
    let torque = angular_momentum.map(|l| -share * TURNING_PER_S * l);
    world.add_force(body, force, torque)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use bdtree_build::input::read_mesh;
    use bdtree_dynamics::{BodyOptions, Frame, MassProperties, WorldOptions};
    use bdtree_fixtures::{bake, models};
    use bdtree_runtime::Transform;

    use super::*;

    /// A ball that falls in at 17 m/s is stopped within some meters and stays there.
    #[test]
    fn what_falls_in_comes_to_rest() {
        let mesh = read_mesh(&models::path("tetrahedron")).expect("the fixture");
        let model = bake::baked(&mesh, &bake::rigid(&mesh));
        let mut world = World::new(WorldOptions::default()).expect("a world");
        let options = BodyOptions {
            mass: Some(MassProperties::ball(9.0, 0.2, [0.0; 3])),
            ..BodyOptions::default()
        };
        let of = world.add_model(&model, &options).expect("a model");
        let body = world
            .add_body(of, Frame::Free, Transform::IDENTITY)
            .expect("a body");
        (world.set_velocity(body, [0.0; 3], [4.0, 0.0, 1.0])).expect("it turns");
        let mut fastest = 0.0_f64;
        for _ in 0..3000 {
            push(&mut world, body, 9.0).expect("pushed");
            world.step().expect("a step");
            let state = world.state(body).expect("a state");
            fastest = fastest.max(-state.velocity[1]);
            assert!(state.velocity[1] < 1e-9, "it does not come back");
        }
        let state = world.state(body).expect("a state");
        assert!((17.0..17.5).contains(&fastest), "{fastest}");
        assert!(
            is_in(state.position[1]) && state.position[1] > SURFACE_M - 4.0,
            "{state:?}"
        );
        assert!(state.velocity[1].abs() < 0.05 && state.angular_momentum[0].abs() < 1e-9);
    }
}
