//! The whole path on the corpus's exact lists: bake both meshes, place and deform them, ask for
//! their touching triangles. Only pairs that storing coordinates as f32 moves may differ.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use bdtree_build::basis::{Basis, BasisMode};
use bdtree_build::input::read_mesh;
use bdtree_fixtures::{bake, corpus, oracle};
use bdtree_runtime::narrow::{Triangle, triangle_distance};
use bdtree_runtime::{Model, PairContact, Transform, Workspace};

use crate::collisions;

fn baked(folder: &Path, side: &collisions::Side) -> Model {
    let mesh = read_mesh(&folder.join(&side.mesh)).expect("mesh");
    let fields = side
        .fields
        .iter()
        .flat_map(|field| field.as_chunks::<3>().0.iter().map(|u| u.map(f64::from)));
    let basis = Basis {
        vertex_count: mesh.positions.len(),
        fields: fields.collect(),
        modes: vec![BasisMode::default(); side.fields.len()],
        animation: None,
    };
    bake::baked(&mesh, &basis)
}

/// The placement that a similarity matrix means.
fn transform(m: &[f64]) -> Transform {
    let scale = (m[0] * m[0] + m[4] * m[4] + m[8] * m[8]).sqrt();
    let r = |i: usize, j: usize| m[4 * i + j] / scale;
    // Shepperd: the largest of the four squares first.
    let trace = r(0, 0) + r(1, 1) + r(2, 2);
    let squares = [
        1.0 + 2.0 * r(0, 0) - trace,
        1.0 + 2.0 * r(1, 1) - trace,
        1.0 + 2.0 * r(2, 2) - trace,
        1.0 + trace,
    ];
    let k = (0..4).max_by(|i, j| squares[*i].total_cmp(&squares[*j]));
    let k = k.unwrap_or(3);
    let half = squares[k].sqrt() / 2.0;
    let f = 1.0 / (4.0 * half);
    let skew = [r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1)];
    let mut rotation = [0.0; 4];
    rotation[k] = half;
    if k == 3 {
        for i in 0..3 {
            rotation[i] = skew[i] * f;
        }
    } else {
        for i in 0..3 {
            if i != k {
                rotation[i] = (r(i, k) + r(k, i)) * f;
            }
        }
        rotation[3] = skew[k] * f;
    }
    Transform {
        rotation,
        translation: [m[3], m[7], m[11]],
        scale,
    }
}

/// How far the corners of a triangle lie from where they should.
fn moved(stored: &Triangle, exact: &Triangle) -> f64 {
    stored
        .iter()
        .zip(exact)
        .map(|(s, e)| (0..3).map(|k| (s[k] - e[k]).powi(2)).sum::<f64>().sqrt())
        .fold(0.0, f64::max)
}

#[test]
fn pair_queries_agree_with_exact_lists() {
    let test = "pair_queries_agree_with_exact_lists";
    let Some(folder) = corpus::path(test, "") else {
        return;
    };
    let mut files: HashMap<String, Model> = HashMap::new();
    let mut workspace = Workspace::new();
    let (mut pairs, mut borderline) = (0, 0);
    for case in collisions::cases(&folder) {
        let sides = ["a", "b"].map(|name| case.side(name));
        for side in &sides {
            let key = format!("{} {}", side.mesh, side.q.len());
            files.entry(key).or_insert_with(|| baked(&folder, side));
        }
        let assets = [0, 1].map(|i| {
            let key = format!("{} {}", sides[i].mesh, sides[i].q.len());
            *files[&key].asset()
        });
        let mut memory = [0, 1].map(|i| vec![0.0_f32; assets[i].pose_len()]);
        let qs = [0, 1].map(|i| sides[i].q.iter().map(|q| *q as f32).collect::<Vec<_>>());
        let [memory_a, memory_b] = &mut memory;
        let a = assets[0]
            .pose(&qs[0], transform(&sides[0].matrix), memory_a)
            .expect("pose");
        let b = assets[1]
            .pose(&qs[1], transform(&sides[1].matrix), memory_b)
            .expect("pose");
        let mut found: Vec<PairContact> = Vec::new();
        let mut query = a.against(&b, &mut workspace);
        query.contacts(0.0, &mut found).expect("query");
        let found: HashSet<(u32, u32)> = found
            .iter()
            .map(|c| (c.triangle1.0, c.triangle2.0))
            .collect();
        let listed = case.listed();
        pairs += listed.len();

        let exact = ["a", "b"].map(|name| case.triangles(name));
        let stored = [
            oracle::deformed_triangles(&a),
            oracle::deformed_triangles(&b),
        ];
        let mut differing = 0;
        for &(i, j) in found.symmetric_difference(&listed) {
            let (i, j) = (i as usize, j as usize);
            let error = moved(&stored[0][i], &exact[0][i]) + moved(&stored[1][j], &exact[1][j]);
            // Two triangles that touch in one set of coordinates are at most `error` apart in the
            // other.
            let (ta, tb) = if found.contains(&(i as u32, j as u32)) {
                (&exact[0][i], &exact[1][j])
            } else {
                (&stored[0][i], &stored[1][j])
            };
            let distance = triangle_distance(ta, tb).distance;
            if distance > error * (1.0 + 1e-9) {
                // The list's own slip: a triangle with a repeated corner, 0.06 from its partner
                // (see narrow_corpus.rs, where exact arithmetic decides).
                assert!(
                    case.id() == "pairs_s11" && j == 31953,
                    "{}: {i} {j}: distance {distance:e}, storing moved them by {error:e}",
                    case.id()
                );
                continue;
            }
            differing += 1;
        }
        borderline += differing;
        println!(
            "{}: {} listed, {} found, {differing} moved by f32 storage",
            case.id(),
            listed.len(),
            found.len()
        );
    }
    println!("{pairs} pairs listed, {borderline} moved by f32 storage");
    assert!(pairs > 30_000 && borderline * 100 < pairs);
}
