//! What queries meet.

use std::mem::size_of;

use bdtree_fixtures::mutate::{put, repair, section};
use bdtree_format::{SectionKind, TriangleRecord};
use bdtree_runtime::{Ball, Contact, Datum, Instance, Model, QueryError, VertexId, Workspace};

use crate::seen::FILE;

/// The error says where the wrong number stands, not where a vertex of that number would.
#[test]
fn a_corner_that_is_no_vertex_is_placed_at_its_triangle() {
    let mut bytes = FILE.asset().bytes().to_vec();
    let place = section(&bytes, SectionKind::TRIANGLES).start + 3 * size_of::<TriangleRecord>();
    put(&mut bytes, place + 4, &65_355_u32.to_le_bytes());
    repair(&mut bytes);
    let model = Model::from_bytes(&bytes).expect("it opens");
    let mut body = Instance::new(&model).expect("an instance");
    let displaced = model.asset().displacements(VertexId(65_355));
    let errors = [
        model.asset().check_mesh().expect_err("a wrong corner"),
        body.pose()
            .deformed(VertexId(65_355))
            .expect_err("no vertex"),
        displaced.map(|_| ()).expect_err("no vertex"),
        {
            body.set_q(&[0.01; 6]).expect("q within the limits");
            let mut workspace = Workspace::new();
            let mut found: Vec<Contact> = Vec::new();
            let ball = Ball::new([0.0; 3], 100.0);
            match body.query(&mut workspace).contacts(ball, &mut found) {
                Err(QueryError::Corrupt(error)) => error,
                other => panic!("{other:?}"),
            }
        },
    ];
    for error in errors {
        assert_eq!(
            (error.section, error.byte),
            (SectionKind::TRIANGLES, place as u64),
            "{error}"
        );
        assert_eq!(error.found, Datum::from(65_355_u32));
    }
}
