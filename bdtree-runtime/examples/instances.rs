//! Many bodies: which may meet, which do, and what a contact solver takes of it.
use bdtree_runtime::{ContactManifold, Instance, Model, PairFront, Transform, Workspace};
use bdtree_runtime::{broad, include_bdt};
use std::collections::HashMap;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = Model::from_static(include_bdt!("../../fixtures/golden/sphere.bdt"))?;
    let mut bodies = Vec::new();
    for i in 0..27 {
        let mut body = Instance::new(&model)?;
        body.user_data = i;
        // Every third body lets the others pass.
        body.collision_mask = if i % 3 == 2 { 0 } else { u32::MAX };
        bodies.push(body);
    }
    let mut workspace = Workspace::new();
    // What each pair keeps from step to step; more than one pair cannot share it.
    let mut fronts: HashMap<[usize; 2], PairFront<'_>> = HashMap::new();
    let mut near: Vec<[usize; 2]> = Vec::new();
    let mut manifolds: Vec<ContactManifold> = Vec::new();
    for step in 0..4 {
        let phase = step as f32 * 0.1;
        for (i, body) in bodies.iter_mut().enumerate() {
            let place = [(i % 3) as f64, (i / 3 % 3) as f64, (i / 9) as f64].map(|x| 1.9 * x);
            let q = [phase.sin() * 0.3, (phase + i as f32).cos() * 0.2, 0.0];
            body.set_pose(&q, Transform::from_translation(place))?;
        }
        near.clear();
        broad::instance_pairs(&bodies, 0.0, &mut workspace, &mut near)?;
        let mut touching = 0;
        for &[i, j] in &near {
            let [a, b] = bodies.get_disjoint_mut([i, j])?;
            let front = fronts.entry([i, j]).or_default();
            manifolds.clear();
            a.against(b, &mut workspace)
                .front(front)
                .contact_manifolds(0.0, &mut manifolds)?;
            touching += usize::from(!manifolds.is_empty());
            for manifold in &manifolds {
                assert!(manifold.area >= 0.0 && !manifold.points().is_empty());
            }
        }
        println!("step {step}: {} pairs near, {touching} touch", near.len());
    }
    Ok(())
}
