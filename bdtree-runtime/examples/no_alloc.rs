//! Static memory only: what a microcontroller or an audio thread does. Nothing here allocates but `println!`.
use bdtree_runtime::{Asset, Ball, Contact, SliceSink, Transform, Workspace, include_bdt};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let asset = Asset::open(include_bdt!("../../fixtures/golden/sphere.bdt"))?;
    let (mut numbers, mut bytes) = ([0.0; 16], [0; 8192]);
    let mut slots = [Contact::EMPTY; 32];
    let mut contacts = SliceSink::new(&mut slots);
    let mut workspace = Workspace::in_bytes(&mut bytes);

    let pose = asset.pose(&[0.2, -0.1, 0.3], Transform::IDENTITY, &mut numbers)?;
    let ball = Ball::new([1.0, 0.2, 0.0], 0.3);
    let coverage = pose.query(&mut workspace).contacts(ball, &mut contacts)?;

    println!("{coverage:?}: {} contacts", contacts.items().len());
    // How much memory that takes is known before, from the asset alone.
    println!("numbers for a pose: {}", asset.pose_len());
    println!("bytes for queries: {}", Workspace::bytes_for(&[&asset]));
    Ok(())
}
