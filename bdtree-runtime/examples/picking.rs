//! Picking in a frame loop: the mesh deforms, the pointer moves, a ray tells what is below it.
use bdtree_runtime::{Instance, Model, Ray, Transform, Workspace, include_bdt};

/// The ray through a pixel of a camera at (0, 0, 5) that looks along -z with a vertical field of view of 60°.
fn pointer_ray([x, y]: [f64; 2], [width, height]: [f64; 2]) -> Ray {
    let half = 30_f64.to_radians().tan();
    let across = (2.0 * x / width - 1.0) * half * width / height;
    let up = (1.0 - 2.0 * y / height) * half;
    Ray::new([0.0, 0.0, 5.0], [across, up, -1.0])
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = Model::from_static(include_bdt!("../../fixtures/golden/sphere.bdt"))?;
    let mut body = Instance::new(&model)?;
    // Made once: after the first frame nothing is allocated.
    let mut workspace = Workspace::new();
    for frame in 0..8 {
        let t = frame as f32 / 8.0;
        body.set_pose(&[0.3 * t, 0.1, -0.2 * t], Transform::IDENTITY)?;
        let ray = pointer_ray([560.0 + 30.0 * f64::from(frame), 400.0], [1280.0, 800.0]);
        let mut query = body.query(&mut workspace);
        match query.cast_ray(&ray)? {
            Some(hit) => {
                let stats = query.stats();
                println!(
                    "frame {frame}: triangle {} at {:.3?}, normal {:.3?}; {} nodes visited",
                    hit.triangle.0, hit.point, hit.normal, stats.nodes_visited
                );
            }
            None => println!("frame {frame}: nothing below the pointer"),
        }
    }
    Ok(())
}
