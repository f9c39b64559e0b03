//! Manifolds keep what the engine stores in them from step to step.

use bdtree_fixtures::poses;

use super::ours::{DeformingMesh, MeshDispatcher};
use super::parry::math::{Pose, Real};
use super::parry::query::{ContactManifold, ContactManifoldsWorkspace, PersistentQueryDispatcher};
use super::parry::shape::{Cuboid, Shape};
use super::support;

const PREDICTION: Real = 0.05;

/// What an engine keeps: a mark for each manifold and each point.
type Kept = ContactManifold<u32, u32>;

fn update(pos12: &Pose, one: &dyn Shape, two: &dyn Shape, kept: &mut Vec<Kept>) {
    // An engine drops the workspace when a shape has changed.
    let mut workspace: Option<ContactManifoldsWorkspace> = None;
    MeshDispatcher::new()
        .contact_manifolds(pos12, one, two, PREDICTION, kept, &mut workspace)
        .expect("manifolds");
    assert!(
        workspace.is_some(),
        "tells that the order of manifolds may change"
    );
}

#[test]
fn marks_stay_with_points_that_stay() {
    let mut rng = poses::rng(31);
    let model = support::bumpy();
    let mesh = support::mesh(model, &mut rng);
    let ground = Cuboid::new(support::vector([2.0, 0.5, 2.0]));
    let height = -0.5 - 0.8 + 0.1;
    for is_swapped in [false, true] {
        let mut kept: Vec<Kept> = Vec::new();
        let (mut found, mut lost, mut marks) = (0, 0, 1);
        for step in 0..40 {
            // Sinks slowly, slides a little, and q wobbles.
            let wobble = 0.002 * (step as f32).sin();
            let q: Vec<f32> = mesh.q().iter().map(|q| q + wobble).collect();
            let mesh = DeformingMesh::new(model, &q).expect("a mesh");
            let slide = 0.0005 * step as Real;
            let pos = Pose::translation(slide, height + 0.2 * slide, 0.0);
            let before: usize = kept
                .iter()
                .map(|m| m.points.iter().filter(|p| p.data > 0).count())
                .sum();
            match is_swapped {
                false => update(&pos, &mesh, &ground, &mut kept),
                true => update(&pos.inverse(), &ground, &mesh, &mut kept),
            }
            let points = || kept.iter().flat_map(|m| &m.points);
            let marked: Vec<u32> = points().map(|p| p.data).filter(|mark| *mark > 0).collect();
            let mut once = marked.clone();
            once.sort_unstable();
            once.dedup();
            assert_eq!(once.len(), marked.len(), "no mark is there twice");
            found += marked.len();
            lost += before - marked.len().min(before);
            for manifold in &mut kept {
                if step > 0 && manifold.data == 0 {
                    marks += 1;
                }
                manifold.data = manifold.data.max(marks);
                for point in &mut manifold.points {
                    if point.data == 0 {
                        marks += 1;
                        point.data = marks;
                    }
                }
            }
            assert!(!kept.is_empty(), "step {step}: no contact");
        }
        assert!(
            found > 40 && lost * 5 < found,
            "{found} marks stayed, {lost} were lost"
        );
    }
}

#[test]
fn what_parted_leaves_no_manifold() {
    let mut rng = poses::rng(37);
    let mesh = support::mesh(support::bumpy(), &mut rng);
    let ground = Cuboid::new(support::vector([2.0, 0.5, 2.0]));
    let mut kept: Vec<Kept> = Vec::new();
    update(
        &Pose::translation(0.0, -1.2, 0.0),
        &mesh,
        &ground,
        &mut kept,
    );
    assert!(!kept.is_empty());
    update(
        &Pose::translation(0.0, -3.0, 0.0),
        &mesh,
        &ground,
        &mut kept,
    );
    assert!(kept.is_empty());
}
