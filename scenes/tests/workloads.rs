//! The workloads are what they say they are, and all contenders see the product's vertices.

use std::path::Path;

use bdtree_fixtures::bake;
use bdtree_measure::deform::Deformer;
use bdtree_measure::{Body, Place};
use bdtree_runtime::{Transform, VertexId};
use bdtree_scenes::workloads::{bodies, curtain, pile, rays, sequence};

/// Counts and sizes by the workloads' description.
#[test]
fn workloads_have_their_sizes() {
    let (name, across, down) = curtain::SIZES[0];
    let cloth = curtain::curtain(name, across, down);
    assert_eq!(cloth.body.positions.len(), 6162);
    assert_eq!(cloth.body.triangles.len(), 12012);
    assert_eq!(cloth.q.len(), 110 * 12);
    let two = bodies::bodies();
    assert_eq!(two.body.triangles.len(), 35280);
    // A closed surface of a sphere's kind: V − E + F = 2.
    assert_eq!(two.body.positions.len(), 35280 / 2 + 2);
    let pile = pile::pile();
    assert_eq!(pile.body.triangles.len(), 18000);
    assert_eq!(pile.pairs.len(), 2700);
    for body in [&cloth.body, &two.body, &pile.body] {
        let diagonal = body.mesh().diagonal();
        for field in body.fields.chunks_exact(body.positions.len()) {
            let longest = field
                .iter()
                .map(|u| u.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt())
                .fold(0.0, f64::max);
            assert!((longest / diagonal - 0.05).abs() < 1e-6, "{longest}");
        }
    }
    let (name, n) = rays::SIZES[0];
    for [_, direction] in rays::rays(name, n).of(29, 5000) {
        let square: f32 = direction.iter().map(|x| x * x).sum();
        assert!((square - 1.0).abs() < 1e-6);
    }
}

/// The numbers of a file of the generator of the workloads' description.
fn numbers(folder: &Path, name: &str) -> Vec<u32> {
    let bytes = std::fs::read(folder.join(name)).expect("a file of the generator");
    let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let words = bytes[header..].as_chunks::<4>().0;
    words.iter().map(|w| u32::from_le_bytes(*w)).collect()
}

fn bits<'a>(values: impl IntoIterator<Item = &'a f32>) -> Vec<u32> {
    values.into_iter().map(|x| x.to_bits()).collect()
}

/// Poses pass through a quaternion here, so they may differ in f32's last place.
fn near(places: &[Place], expected: &[u32]) {
    let found = places.iter().flat_map(|place| place.rows().concat());
    assert_eq!(places.len() * 12, expected.len());
    for (found, expected) in found.zip(expected) {
        let expected = f32::from_bits(*expected);
        let scale = expected.abs().max(0.1);
        assert!(
            (found - expected).abs() <= 2e-7 * scale,
            "{found} {expected}"
        );
    }
}

fn same_body(body: &Body, folder: &Path) {
    assert_eq!(
        bits(body.positions.as_flattened()),
        numbers(folder, "verts.npy")
    );
    assert_eq!(body.triangles.concat(), numbers(folder, "faces.npy"));
    assert_eq!(
        bits(body.fields.as_flattened()),
        numbers(folder, "basis.npy")
    );
}

/// Compares with what the generator of the workloads' description wrote, if the variable
/// BDTREE_WORKLOADS names its output folder.
#[test]
fn workloads_are_those_of_the_description() {
    let Some(folder) = std::env::var_os("BDTREE_WORKLOADS") else {
        eprintln!("BDTREE_WORKLOADS is not set: nothing compared");
        return;
    };
    let of = |name: &str| Path::new(&folder).join(name);
    let (name, across, down) = curtain::SIZES[0];
    let cloth = curtain::curtain(name, across, down);
    same_body(&cloth.body, &of(name));
    assert_eq!(bits(&cloth.q), numbers(&of(name), "q.npy"));
    assert_eq!(
        bits(cloth.balls.as_flattened()),
        numbers(&of(name), "ball.npy")
    );

    let two = bodies::bodies();
    same_body(&two.body, &of("blob36k"));
    assert_eq!(bits(&two.q[0]), numbers(&of("blob36k"), "qa.npy"));
    assert_eq!(bits(&two.q[1]), numbers(&of("blob36k"), "qb.npy"));
    near(&two.places, &numbers(&of("blob36k"), "pose.npy"));
    near(
        &two.rigid_places,
        &numbers(&of("blob36k"), "pose_rigid.npy"),
    );

    let (name, n) = rays::SIZES[0];
    let shots = rays::rays(name, n);
    assert_eq!(bits(&shots.q), numbers(&of(name), "q.npy"));
    assert_eq!(
        bits(shots.rays.as_flattened().as_flattened()),
        numbers(&of(name), "rays.npy")
    );

    let pile = pile::pile();
    same_body(&pile.body, &of("blob18k"));
    assert_eq!(bits(&pile.q), numbers(&of("blob18k"), "q.npy"));
    near(&pile.places, &numbers(&of("blob18k"), "pose.npy"));
    assert_eq!(pile.pairs.concat(), numbers(&of("blob18k"), "pairs.npy"));
}

/// Everybody's deformed vertices have the bits of the product's.
#[test]
fn deformation_is_the_products() {
    // 1681 vertices: the last block of coordinates is not full.
    for body in [curtain::cloth("cloth", 41, 41), bodies::blob("blob", 7, 3)] {
        let model = bake::baked(&body.mesh(), &body.basis());
        let asset = model.asset();
        assert_eq!((asset.origin(), asset.unit()), ([0.0; 3], 1.0));
        let deformer = Deformer::new(&body);
        let mut out = vec![0.0; deformer.count];
        let mut memory = vec![0.0; asset.pose_len()];
        for q in sequence(5, body.modes, 0.8, 77).chunks_exact(body.modes) {
            deformer.deform(q, &[], &mut out);
            let pose = asset
                .pose(q, Transform::IDENTITY, &mut memory)
                .expect("pose");
            for (i, p) in out.as_chunks::<3>().0.iter().enumerate() {
                let own = pose.deformed_stored(VertexId(i as u32)).expect("vertex");
                assert_eq!(own.map(f32::to_bits), p.map(f32::to_bits), "vertex {i}");
            }
        }
    }
}
