//! The ball's way: thrown, pulled down, thrown back by what it touches.

use std::error::Error;

use bdtree_runtime::{Asset, Ball, Contact, Transform, Workspace};

/// Seconds from frame to frame.
const FRAME: f64 = 1.0 / 30.0;

/// Steps of a frame.
const STEPS: usize = 8;

/// Where it starts (m) and how fast (m/s): in front of the curtain, upwards and towards it.
const START: [[f64; 3]; 2] = [[0.15, 1.0, 2.2], [-0.1, 2.6, -3.2]];

/// m/s².
const GRAVITY: f64 = 9.81;

/// Share of the speed along the normal that is left after a contact.
const RESTITUTION: f64 = 0.8;

/// Center and radius in every frame; `q` holds the frames' coordinates. The curtain throws the ball back as a
/// wall would, and so does the floor at y = 0.
///
/// # Errors
/// Coordinates beyond their limits.
pub(super) fn flight(
    asset: &Asset<'_>,
    q: &[f32],
    radius: f32,
) -> Result<Vec<[f32; 4]>, Box<dyn Error>> {
    let [mut place, mut speed] = START;
    let mut memory = vec![0.0; asset.pose_len()];
    let mut workspace = Workspace::new();
    let mut found: Vec<Contact> = Vec::new();
    let radius = f64::from(radius);
    let mut all = Vec::new();
    for q in q.chunks_exact(asset.mode_count()) {
        all.push([place[0], place[1], place[2], radius].map(|x| x as f32));
        let pose = asset.pose(q, Transform::IDENTITY, &mut memory)?;
        let mut query = pose.query(&mut workspace);
        for _ in 0..STEPS {
            let step = FRAME / STEPS as f64;
            speed[1] -= GRAVITY * step;
            for k in 0..3 {
                place[k] += step * speed[k];
            }
            found.clear();
            query.contacts(Ball::new(place, radius), &mut found)?;
            let deepest = found
                .iter()
                .min_by(|a, b| a.distance.total_cmp(&b.distance));
            if let Some(contact) = deepest {
                bounce(&mut speed, contact.normal);
            }
            if place[1] < radius {
                bounce(&mut speed, [0.0, 1.0, 0.0]);
            }
        }
    }
    Ok(all)
}

/// Turns round the part of the speed that goes against a normal.
fn bounce(speed: &mut [f64; 3], normal: [f64; 3]) {
    let along: f64 = (0..3).map(|k| speed[k] * normal[k]).sum();
    if along < 0.0 {
        for k in 0..3 {
            speed[k] -= (1.0 + RESTITUTION) * along * normal[k];
        }
    }
}

/// A radius on the command line.
pub(super) fn radius(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(radius) if radius > 0.0 && radius <= 10.0 => Ok(radius),
        _ => Err("a radius is a number above 0, up to 10".to_string()),
    }
}
