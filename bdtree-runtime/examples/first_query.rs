//! Load, pose, ray, ball, pair.
use bdtree_runtime::{Ball, Contact, Instance, Model, Ray, Transform, Workspace};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/golden/sphere.bdt");

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = Model::read(FILE)?; // or Model::load, which maps the file (feature mmap)
    let (mut one, mut other) = (Instance::new(&model)?, Instance::new(&model)?);
    one.set_q(&[0.2, -0.1, 0.3])?;
    other.set_placement(Transform::from_translation([1.8, 0.0, 0.0]))?;
    let mut workspace = Workspace::new();
    let mut query = one.query(&mut workspace);
    let hit = query.cast_ray(&Ray::new([0.0, 5.0, 0.0], [0.0, -1.0, 0.0]))?;
    let mut contacts: Vec<Contact> = Vec::new();
    query.contacts(Ball::new([1.0, 0.2, 0.0], 0.3), &mut contacts)?;
    let gap = one.against(&mut other, &mut workspace).distance(1.0)?;

    println!("the ray meets the mesh at {:?}", hit.map(|hit| hit.point));
    for contact in contacts {
        println!(
            "triangle {}: {:?}, {} deep",
            contact.triangle.0, contact.point, -contact.distance
        );
    }
    println!("the two are {gap:?} apart");
    Ok(())
}
