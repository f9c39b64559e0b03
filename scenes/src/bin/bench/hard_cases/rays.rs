//! Rays from inside closed meshes, at corners, along edges and anywhere: each must hit.

use bdtree_build::input::RawMesh;
use bdtree_fixtures::poses::rng;

use super::fixture;
use super::libraries::answers;

use crate::prelude::*;

/// A closed mesh by its name, and where a ray may begin in it, from three random numbers in -1..1.
type Closed = (&'static str, RawMesh, fn([f64; 3]) -> [f64; 3]);

fn scaled(mut mesh: RawMesh, by: [f64; 3], to: [f64; 3]) -> RawMesh {
    for p in &mut mesh.positions {
        *p = [0, 1, 2].map(|k| to[k] + by[k] * p[k]);
    }
    mesh
}

/// On the circle inside of the torus.
fn in_torus([x, y, _]: [f64; 3]) -> [f64; 3] {
    let length = (x * x + y * y).sqrt().max(1e-3);
    [x / length, 0.0, y / length]
}

fn meshes() -> Result<Vec<Closed>> {
    let (ball, cube, torus) = (fixture("icosphere")?, fixture("cube")?, fixture("torus")?);
    let needles = scaled(ball.clone(), [4096.0, 1.0, 1.0], [0.0; 3]);
    let tiny = scaled(torus.clone(), [1e-6; 3], [0.0; 3]);
    let [far, farther] = [1e6, 1e8].map(|away| scaled(ball.clone(), [1.0; 3], [away; 3]));
    let mut all: Vec<Closed> = vec![
        ("ball", ball, |r| r.map(|x| 0.3 * x)),
        // Multiples of 1/8, so that rays run through corners and along faces' diagonals.
        ("cube, rays begin on a grid", cube, |r| {
            r.map(|x| (4.0 * x).round() / 8.0)
        }),
        ("torus", torus, in_torus),
        ("ball of needles, 1 : 1 : 4096", needles, |[x, y, z]| {
            [1228.0 * x, 0.3 * y, 0.3 * z]
        }),
        ("torus of size 1e-6", tiny, |r| {
            in_torus(r).map(|x| 1e-6 * x)
        }),
    ];
    // Coordinates that f32 holds: the mesh is the same for all.
    for x in all
        .iter_mut()
        .flat_map(|(_, mesh, _)| mesh.positions.as_flattened_mut())
    {
        *x = f64::from(*x as f32);
    }
    // Coordinates that it does not hold: rounded, the ball is another one.
    all.push(("ball 1e6 away", far, |r| r.map(|x| 1e6 + 0.3 * x)));
    all.push(("ball 1e8 away", farther, |_| [1e8; 3]));
    Ok(all)
}

/// One row per mesh.
pub(super) fn rows(count: usize) -> Result<Vec<Row>> {
    let row = |(name, mesh, inside): Closed| {
        answers(name, &mesh, |library| {
            let mut rng = rng(7);
            let mut missed = 0;
            for i in 0..count {
                let mut some = || [0; 3].map(|_| rng.random_range(-1.0..1.0));
                let (start, share) = (inside(some()), some());
                let t = mesh.triangles[i % mesh.triangles.len()];
                let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
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
            missed.to_string()
        })
    };
    Ok(meshes()?.into_iter().map(row).collect())
}
