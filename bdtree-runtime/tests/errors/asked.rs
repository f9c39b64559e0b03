//! What queries meet.

use std::mem::{offset_of, size_of};

use bdtree_fixtures::mutate::{put, repair, section};
use bdtree_format::{Header, NodeRecord, SectionKind, TriangleRecord};
use bdtree_runtime::{Ball, Contact, Datum, Instance, Model, QueryError, VertexId, Workspace};

use crate::edits::{Change, node, node_count, of_node_u32, u32_at};
use crate::seen::FILE;

/// Changes of a sound file, checksums repaired afterwards.
pub(crate) fn changes() -> Vec<Change> {
    vec![
        Box::new(of_node_u32(0, offset_of!(NodeRecord, first_child), 0)),
        Box::new(of_node_u32(0, offset_of!(NodeRecord, first_child), 1 << 20)),
        Box::new(of_node_u32(0, offset_of!(NodeRecord, row_start), u32::MAX)),
        Box::new(of_node_u32(
            0,
            offset_of!(NodeRecord, mode_list_start),
            u32::MAX,
        )),
        Box::new(|b| {
            for i in 0..node_count(b) {
                let at = node(b, i) + offset_of!(NodeRecord, first_slot);
                u32_at(b, at, u32::MAX);
            }
        }),
        Box::new(shared_children(32, 3)),
        Box::new(shared_children(1, 0xff)),
    ]
}

/// Every node's lanes 0 and 1 (or all lanes) lead to the nodes behind it; the last two are leaves.
fn shared_children(depth: u32, mask: u8) -> impl Fn(&mut Vec<u8>) {
    move |b| {
        u32_at(b, offset_of!(Header, depth), depth);
        let count = node_count(b);
        for i in 0..count - 2 {
            let at = node(b, i);
            u32_at(b, at, i as u32 + 1);
            b[at + offset_of!(NodeRecord, inner_mask)] = mask;
            b[at + offset_of!(NodeRecord, leaf_mask)] = 0;
        }
        for i in count - 2..count {
            let at = node(b, i);
            b[at + offset_of!(NodeRecord, inner_mask)] = 0;
        }
        // All spheres are entered: NaN means visit.
        for at in section(b, SectionKind::ROWS).step_by(4) {
            put(b, at, &f32::NAN.to_le_bytes());
        }
    }
}

/// The error says where the wrong number stands, not where a vertex of that number would.
#[test]
fn a_corner_that_is_no_vertex_is_placed_at_its_triangle() {
    let mut bytes = FILE.asset().bytes().to_vec();
    let place = section(&bytes, SectionKind::TRIANGLES).start + 3 * size_of::<TriangleRecord>();
    u32_at(&mut bytes, place + 4, 65_355);
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
