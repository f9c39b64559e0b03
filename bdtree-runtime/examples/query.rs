//! Embeds a file, poses it, asks which triangles a ball touches.

use bdtree_runtime::{Asset, Contact, Pose, SliceSink, StackEntry, Transform, include_bdt, query};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let asset = Asset::open(include_bdt!("../../fixtures/golden/sphere.bdt"))?;
    let mut memory = vec![0.0; asset.pose_len()];
    let mut contacts = [Contact::EMPTY; 64];
    let pose = Pose::new(&asset, &[0.2, -0.1, 0.3], Transform::IDENTITY, &mut memory)?;
    let mut stack = vec![StackEntry::default(); asset.stack_len()];
    let mut sink = SliceSink::new(&mut contacts);
    query::ball(&asset, &pose, [1.0, 0.2, 0.0], 0.3, &mut stack, &mut sink)?;
    for contact in sink.items() {
        println!(
            "triangle {} at {:?}: {}",
            contact.triangle.0, contact.point, contact.dist
        );
    }
    Ok(())
}
