//! A ball pushes a body: penalty forces at its contacts act on q, which swings by the modal equation
//! m q̈ + c q̇ + k q = Uᵀ f (semi-implicit Euler).
use bdtree_runtime::{Ball, Contact, Instance, Model, Workspace, include_bdt};

const STEP_S: f64 = 1.0 / 240.0;
const STIFFNESS: f64 = 400.0; // force per depth of a contact
// Of each mode.
const MASS: f64 = 1.0;
const DAMPING: f64 = 2.0;
const SPRING: f64 = 60.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = Model::from_static(include_bdt!("../../fixtures/golden/sphere.bdt"))?;
    let modes = model.asset().mode_count();
    let mut body = Instance::new(&model)?;
    let mut workspace = Workspace::new();
    let mut contacts: Vec<Contact> = Vec::new();
    let (mut q, mut velocity, mut force) = (vec![0.0; modes], vec![0.0; modes], vec![0.0; modes]);
    let mut narrow = vec![0.0; modes];
    for step in 0..=120 {
        let ball = Ball::new([1.6 - 0.005 * f64::from(step), 0.1, 0.2], 0.5);
        contacts.clear();
        body.query(&mut workspace).contacts(ball, &mut contacts)?;
        force.fill(0.0);
        for contact in &contacts {
            // Away from the shape, shared among the contacts.
            let push = STIFFNESS * contact.distance / contacts.len() as f64;
            let push = contact.normal.map(|n| n * push);
            body.pose().add_generalized_force(
                contact.triangle,
                contact.barycentric,
                push,
                &mut force,
            )?;
        }
        for j in 0..modes {
            let acceleration = (force[j] - DAMPING * velocity[j] - SPRING * q[j]) / MASS;
            velocity[j] += STEP_S * acceleration;
            q[j] += STEP_S * velocity[j];
        }
        for (narrow, q) in narrow.iter_mut().zip(&q) {
            *narrow = *q as f32;
        }
        body.set_q(&narrow)?;
        if step % 30 == 0 {
            println!("step {step}: {} contacts, q = {q:.4?}", contacts.len());
        }
    }
    Ok(())
}
