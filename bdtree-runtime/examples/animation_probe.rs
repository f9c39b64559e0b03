//! A stored animation plays while a probe moves through it: the nearest point, and contact.
use bdtree_runtime::{Ball, Instance, Model, Workspace, include_bdt};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = Model::from_static(include_bdt!("../../fixtures/golden/animated.bdt"))?;
    let asset = model.asset();
    let duration = asset
        .duration_s()
        .ok_or("the asset has no timed animation")?;
    let mut body = Instance::new(&model)?;
    let mut workspace = Workspace::new();
    let mut q = vec![0.0; asset.mode_count()];
    for step in 0..=12 {
        let time = f64::from(step) * 0.25;
        // The rigid motion that the bake took out of the frames comes back with q.
        let motion = asset.sample(time % duration, &mut q)?;
        body.set_pose(&q, motion)?;
        // The probe circles the body, now closer, now farther away.
        let (sphere, angle) = (body.bounding_sphere()?, 0.7 * f64::from(step));
        let [x, y, z] = sphere.center;
        let away = sphere.radius * (0.7 + 0.3 * angle.sin());
        let probe = [x + away * angle.cos(), y, z + away * angle.sin()];
        let mut query = body.query(&mut workspace);
        let nearest = query.project_point(probe, f64::INFINITY)?;
        let touches = query.intersects(Ball::new(probe, 0.25))?;
        if let Some(nearest) = nearest {
            println!(
                "{time:4.2} s: {:.3} from triangle {}{}",
                nearest.distance,
                nearest.triangle.0,
                if touches { ", touching" } else { "" }
            );
        }
    }
    Ok(())
}
