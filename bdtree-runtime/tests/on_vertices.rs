//! Queries exactly on a vertex, by the coordinates that `deform` writes: limits are inclusive, so every shape of size 0
//! touches all triangles of that corner, and the nearest is at distance 0, of the lowest id.

use bdtree_build::input::RawMesh;
use bdtree_fixtures::{bake, hard};
use bdtree_runtime::{Ball, Capsule, Contact, Cuboid, TriangleId, VertexId, Workspace};
use bdtree_runtime::{Pose, Transform};

/// Vertices asked for per mesh.
const VERTICES: usize = 400;

#[test]
fn every_shape_of_size_0_touches_the_triangles_of_a_corner() {
    let mut asked = 0;
    let mut meshes: Vec<RawMesh> = hard::hard_cases()
        .into_iter()
        .map(|case| case.mesh)
        .collect();
    meshes.push(bake::bumpy_sphere(24, 32));
    for mesh in &meshes {
        let model = bake::baked(mesh, &bake::rigid(mesh));
        let asset = model.asset();
        for transform in [
            Transform::IDENTITY,
            Transform::from_translation([3.0, -0.1, 1e3]),
        ] {
            let pose = asset.pose(&[], transform, &mut []).expect("pose");
            asked += ask_all(&pose);
        }
    }
    assert!(asked > 1000, "{asked}");
}

fn ask_all(pose: &Pose<'_>) -> usize {
    let asset = pose.asset();
    let mut of_vertex = vec![Vec::new(); asset.vertex_count()];
    for id in (0..asset.triangle_count() as u32).map(TriangleId) {
        for corner in asset.triangle(id).expect("a triangle") {
            of_vertex[corner.0 as usize].push(id);
        }
    }
    let used: Vec<usize> = (0..of_vertex.len())
        .filter(|&v| !of_vertex[v].is_empty())
        .collect();
    let step = used.len().div_ceil(VERTICES).max(1);
    let mut workspace = Workspace::new();
    let mut query = pose.query(&mut workspace);
    let mut asked = 0;
    for &v in used.iter().step_by(step) {
        let at = pose.deformed(VertexId(v as u32)).expect("a vertex");
        let mut touching = |shape: bdtree_runtime::Shape| -> Vec<TriangleId> {
            let mut contacts: Vec<Contact> = Vec::new();
            query.contacts(shape, &mut contacts).expect("contacts");
            let mut ids: Vec<TriangleId> = contacts.iter().map(|c| c.triangle).collect();
            ids.sort_unstable();
            ids
        };
        let ball = touching(Ball::new(at, 0.0).into());
        for id in &of_vertex[v] {
            assert!(ball.contains(id), "vertex {v}: {id:?} is not in {ball:?}");
        }
        assert_eq!(
            ball,
            touching(Capsule::new(at, at, 0.0).into()),
            "vertex {v}"
        );
        // A box decides on corners as it sees them from its center, so it may find more by a rounding.
        let cuboid = touching(Cuboid::new(at, [0.0; 3]).into());
        for id in &of_vertex[v] {
            assert!(
                cuboid.contains(id),
                "vertex {v}: {id:?} is not in {cuboid:?}"
            );
        }
        let nearest = query.project_point(at, f64::INFINITY).expect("nearest");
        let nearest = nearest.expect("the mesh has triangles");
        assert_eq!(
            (nearest.distance, nearest.triangle),
            (0.0, ball[0]),
            "vertex {v}"
        );
        asked += 1;
    }
    asked
}
