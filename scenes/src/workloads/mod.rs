//! The workloads W1 to W5 that contenders are compared on: deforming bodies with balls, bodies and rays, characters.
//!
//! Everything is generated and deterministic. Modes are smooth vector fields of low frequency,
//! each scaled so that q = 1 moves its farthest vertex by 5 % of the box's diagonal; coordinates
//! over time are sines whose amplitude falls with the root of the mode's number.

pub mod bodies;
pub mod characters;
pub mod curtain;
pub mod pile;
pub mod random;
pub mod rays;

use std::f64::consts::TAU;

use bdtree_build::input::RawMesh;
use bdtree_measure::Body;
use bdtree_measure::deform::Deformer;

use random::Stream;

/// The body with `modes` fields whose wave numbers rise from 0.8 to `highest`.
pub(crate) fn with_modes(
    mesh: &RawMesh,
    name: &'static str,
    modes: usize,
    highest: f64,
    seed: u64,
) -> Body {
    Body {
        name,
        positions: mesh.positions.iter().map(|p| p.map(|x| x as f32)).collect(),
        triangles: mesh.triangles.clone(),
        fields: fields(mesh, modes, highest, seed),
        modes,
        skin: None,
    }
}

fn fields(mesh: &RawMesh, modes: usize, highest: f64, seed: u64) -> Vec<[f32; 3]> {
    let mut stream = Stream::new(seed);
    let diagonal = mesh.diagonal();
    let mut all = Vec::with_capacity(modes * mesh.positions.len());
    for j in 0..modes {
        let steps = modes.saturating_sub(1).max(1) as f64;
        let number = 0.8 + (highest - 0.8) * j as f64 / steps;
        // One wave per component: wave vector, phase, height.
        let waves: [([f64; 3], f64, f64); 3] = std::array::from_fn(|_| {
            let along = stream.direction();
            let vector = [number * along[0], number * along[1], number * along[2]];
            let phase = TAU * stream.unit();
            (vector, phase, 0.3 + 0.7 * stream.unit())
        });
        let at = |p: &[f64; 3]| {
            waves.map(|(k, phase, height)| {
                height * (k[0] * p[0] + k[1] * p[1] + k[2] * p[2] + phase).sin()
            })
        };
        let longest = mesh
            .positions
            .iter()
            .map(|p| {
                let [x, y, z] = at(p);
                (x * x + y * y + z * z).sqrt()
            })
            .fold(0.0, f64::max);
        let scaled = |c: f64| (c * 0.05 * diagonal / longest) as f32;
        all.extend(mesh.positions.iter().map(|p| at(p).map(scaled)));
    }
    all
}

/// Scales q so that the farthest vertex moves by `share` of the diagonal; leaves the deformed
/// vertices in `out`. A q that moves nothing is left as it is, which is told by `false`.
pub fn scale(body: &Body, deformer: &Deformer, q: &mut [f32], share: f64, out: &mut [f32]) -> bool {
    deformer.deform(q, &[], out);
    let moved = out.as_chunks::<3>().0.iter().zip(&body.positions);
    let farthest = moved
        .map(|(a, b)| (0..3).map(|k| f64::from(a[k] - b[k]).powi(2)).sum::<f64>())
        .fold(0.0, f64::max)
        .sqrt();
    if farthest == 0.0 {
        return false;
    }
    let by = share * body.mesh().diagonal() / farthest;
    for q in q.iter_mut() {
        *q *= by as f32;
    }
    deformer.deform(q, &[], out);
    true
}

/// Coordinates of `modes` modes over `frames` frames, frame after frame: sines of amplitude
/// `height` / √(1 + j).
pub fn sequence(frames: usize, modes: usize, height: f64, seed: u64) -> Vec<f32> {
    let mut stream = Stream::new(seed);
    let sines: Vec<[f64; 3]> = (0..modes)
        .map(|j| {
            let turns = 1.0 + 2.5 * stream.unit();
            [height / (1.0 + j as f64).sqrt(), turns, TAU * stream.unit()]
        })
        .collect();
    let mut all = Vec::with_capacity(frames * modes);
    for t in 0..frames {
        for [amplitude, turns, phase] in &sines {
            let angle = TAU * turns * t as f64 / frames as f64 + phase;
            all.push((amplitude * angle.sin()) as f32);
        }
    }
    all
}
