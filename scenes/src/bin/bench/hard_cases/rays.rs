//! Rays from inside closed meshes, at corners, along edges and anywhere: each must hit.

use std::error::Error;

use bdtree_build::input::RawMesh;
use bdtree_fixtures::poses::rng;
use rand::RngExt;

use super::fixture;
use super::libraries::{Given, entries};

/// A closed mesh, in f32 numbers, and places inside of it.
struct Closed {
    name: &'static str,
    mesh: RawMesh,
    /// Where a ray may begin, from three random numbers in -1..1.
    inside: fn([f64; 3]) -> [f64; 3],
}

fn scaled(mut mesh: RawMesh, by: [f64; 3], to: [f64; 3]) -> RawMesh {
    for p in &mut mesh.positions {
        *p = [0, 1, 2].map(|k| to[k] + by[k] * p[k]);
    }
    mesh
}

fn meshes() -> Result<Vec<Closed>, Box<dyn Error>> {
    let in_ball = |r: [f64; 3]| r.map(|x| 0.3 * x);
    let (ball, cube, torus) = (fixture("icosphere")?, fixture("cube")?, fixture("torus")?);
    let mut all = vec![
        Closed {
            name: "ball",
            mesh: ball.clone(),
            inside: in_ball,
        },
        Closed {
            name: "cube, rays begin on a grid",
            mesh: cube,
            // Multiples of 1/8, so that rays run through corners and along faces' diagonals.
            inside: |r| r.map(|x| (4.0 * x).round() / 8.0),
        },
        Closed {
            name: "torus",
            mesh: torus.clone(),
            inside: |[x, y, _]| {
                let length = (x * x + y * y).sqrt().max(1e-3);
                [x / length, 0.0, y / length]
            },
        },
        Closed {
            name: "ball of needles, 1 : 1 : 4096",
            mesh: scaled(ball.clone(), [4096.0, 1.0, 1.0], [0.0; 3]),
            inside: |[x, y, z]| [1228.0 * x, 0.3 * y, 0.3 * z],
        },
        Closed {
            name: "torus of size 1e-6",
            mesh: scaled(torus, [1e-6; 3], [0.0; 3]),
            inside: |[x, y, _]| {
                let length = (x * x + y * y).sqrt().max(1e-3);
                [1e-6 * x / length, 0.0, 1e-6 * y / length]
            },
        },
    ];
    // Coordinates that f32 holds: the mesh is the same for all.
    for closed in &mut all {
        for x in closed.mesh.positions.iter_mut().flatten() {
            *x = f64::from(*x as f32);
        }
    }
    // Coordinates that it does not hold: rounded, the ball is another one.
    all.push(Closed {
        name: "ball 1e6 away",
        mesh: scaled(ball.clone(), [1.0; 3], [1e6; 3]),
        inside: |r| r.map(|x| 1e6 + 0.3 * x),
    });
    all.push(Closed {
        name: "ball 1e8 away",
        mesh: scaled(ball, [1.0; 3], [1e8; 3]),
        inside: |_| [1e8; 3],
    });
    Ok(all)
}

/// One row per mesh.
pub(super) fn table(count: usize) -> Result<(), Box<dyn Error>> {
    for closed in meshes()? {
        let given = Given::new(closed.mesh.clone());
        let mut row = Vec::new();
        for entry in entries() {
            let mut library = match (entry.build)(&given) {
                Ok(library) => library,
                Err(error) => {
                    row.push(error);
                    continue;
                }
            };
            let mut rng = rng(7);
            let mut missed = 0;
            for i in 0..count {
                let mut some = || [0; 3].map(|_| rng.random_range(-1.0..1.0));
                let (start, share) = ((closed.inside)(some()), some());
                let t = closed.mesh.triangles[i % closed.mesh.triangles.len()];
                let [a, b, c] = t.map(|v| closed.mesh.positions[v as usize]);
                // A corner, the middle of an edge, a place on it, a place inside.
                let target = [0, 1, 2].map(|k| match i % 4 {
                    0 => a[k],
                    1 => 0.5 * (a[k] + b[k]),
                    2 => b[k] + share[0].abs() * (c[k] - b[k]),
                    _ => (a[k] + b[k] + c[k]) / 3.0,
                });
                let start = start.map(|x| x as f32);
                let direction = [0, 1, 2].map(|k| (target[k] - f64::from(start[k])) as f32);
                if direction != [0.0; 3] && library.ray(start, direction).is_none() {
                    missed += 1;
                }
            }
            row.push(missed.to_string());
        }
        println!("| {} | {} |", closed.name, row.join(" | "));
    }
    Ok(())
}
