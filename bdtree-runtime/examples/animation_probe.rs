//! A stored animation plays under a ball that stands still: how near the mesh comes, and when it touches.
use bdtree_runtime::{Ball, Contact, Instance, Model, Workspace, include_bdt};

/// Queries per second; they need not fall on the animation's frames.
const QUERIES_PER_S: f64 = 50.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A sheet of 1.6 by 1 mesh units whose waves are up to 0.2 high, in the repository's root:
    // bdtree-build fixtures/wave/wave_00.obj --animation fixtures/wave.mdd --modes 2 -o bdtree-runtime/examples/wave.bdt
    let model = Model::from_static(include_bdt!("wave.bdt"))?;
    let asset = model.asset();
    let duration_s = asset.duration_s().ok_or("no timed animation")?;
    let ball = Ball::new([0.3, 0.5, 0.25], 0.18);
    println!(
        "A ball of radius {} hangs over a sheet that waves for {duration_s:.2} s.",
        ball.radius
    );
    println!("Lengths are mesh units.");

    let mut sheet = Instance::new(&model)?;
    let mut workspace = Workspace::new();
    let mut q = vec![0.0; asset.mode_count()];
    let mut contacts: Vec<Contact> = Vec::new();
    for step in 0..=10 {
        let time_s = f64::from(step) / QUERIES_PER_S;
        // Fills q and returns the placement: the rigid motion that --align took out of the frames, else the identity.
        let placement = asset.sample(time_s.min(duration_s), &mut q)?;
        sheet.set_pose(&q, placement)?;
        let mut query = sheet.query(&mut workspace);
        let nearest = query.project_point(ball.center, f64::INFINITY)?;
        let gap = nearest.map_or(f64::INFINITY, |nearest| nearest.distance - ball.radius);
        contacts.clear();
        query.contacts(ball, &mut contacts)?;
        match contacts.len() {
            0 => println!("At {time_s:.2} s the sheet is {gap:.3} away from the ball."),
            n => println!(
                "At {time_s:.2} s it is {:.3} deep in the ball, with {n} triangles.",
                -gap
            ),
        }
    }
    Ok(())
}
