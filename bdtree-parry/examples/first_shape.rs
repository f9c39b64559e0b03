//! Asks a deforming sphere about a ball, as parry asks.

use bdtree_parry::{DeformingMesh, DeformingModel, MeshDispatcher};
use bdtree_runtime::{Model, include_bdt};
use parry3d::math::Pose;
use parry3d::query::QueryDispatcher;
use parry3d::shape::Ball;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = Model::from_static(include_bdt!("../../fixtures/golden/sphere.bdt"))?;
    let model = DeformingModel::new(&file, 1.0)?; // world units per mesh unit
    let mut q = vec![0.0; file.asset().mode_count()];
    let ball = Ball::new(0.25);
    let place = Pose::translation(0.0, 1.5, 0.0); // the ball's, in the mesh's frame
    for step in 0..3 {
        q[0] = 0.1 * step as f32;
        let mesh = DeformingMesh::new(&model, &q)?;
        let apart = MeshDispatcher::new().distance(&place, &mesh, &ball)?;
        println!("{:.4} from triangle {}", apart.distance, apart.subshape1);
    }
    Ok(())
}
