//! Displacements of listed modes (SPEC 7.6): the same numbers as those of all modes, and every broken
//! rule is found.

use std::mem::{offset_of, size_of};
use std::ops::ControlFlow;

use bdtree_fixtures::{bake, mutate, poses, sections};
use bdtree_format::{SectionKind, VertexModes};
use bdtree_runtime::{
    Asset, Ball, Capsule, Contact, Cuboid, HalfSpace, Model, PairContact, Shape, Transform,
    VertexId, Workspace,
};

/// Places and rules of all errors.
fn errors(model: &Model) -> Vec<(SectionKind, u64, &'static str)> {
    let mut errors = Vec::new();
    model.asset().verify(&mut |e| {
        errors.push((e.section, e.byte, e.rule));
        ControlFlow::Continue(())
    });
    errors
}

/// A sphere with twelve fields: the first moves nothing, the others are local.
fn sphere() -> Model {
    let mesh = bake::bumpy_sphere(12, 1);
    let mut basis = bake::local_basis(&mesh, 12, 1);
    basis.fields[..mesh.positions.len()].fill([0.0; 3]);
    bake::baked(&mesh, &basis)
}

/// Contacts of a ball, a plane, a capsule and a box, and of a pair with the mesh at rest.
fn answers(asset: &Asset<'_>, q: &[f32], place: Transform) -> (Vec<Contact>, Vec<PairContact>) {
    let mut memory = vec![0.0; asset.pose_len()];
    let mut memory2 = memory.clone();
    let pose = asset.pose(q, place, &mut memory).expect("pose");
    let rest = vec![0.0; asset.mode_count()];
    let other = asset
        .pose(&rest, Transform::IDENTITY, &mut memory2)
        .expect("pose");
    let mut workspace = Workspace::new();
    let (mut contacts, mut pairs) = (Vec::new(), Vec::new());
    let point = [0.8, 0.1, -0.3];
    let mut query = pose.query(&mut workspace);
    let cuboid = Cuboid::new(point, [0.4; 3]).rotated([0.0, 0.0, 0.6, 0.8]);
    for shape in [
        Ball::new(point, 0.5).into(),
        HalfSpace::new(point, 0.2).into(),
        Capsule::new(point, [0.0; 3], 0.2).into(),
        Shape::from(cuboid),
    ] {
        query.contacts(shape, &mut contacts).expect("contacts");
    }
    let mut query = pose.against(&other, &mut workspace);
    query.contacts(0.01, &mut pairs).expect("pair");
    (contacts, pairs)
}

#[test]
fn both_layouts_give_equal_numbers() {
    let sparse = sphere();
    let dense = sections::with_all_displacements(sparse.asset());
    let (a, b) = (*sparse.asset(), *dense.asset());
    assert!(!a.vertex_modes().is_empty() && b.vertex_modes().is_empty());
    assert!(errors(&sparse).is_empty() && errors(&dense).is_empty());
    assert!(4 * a.bytes().len() < 3 * b.bytes().len());
    for i in (0..a.vertex_count() as u32).map(VertexId) {
        let (own, all) = (
            a.displacements(i).expect("a vertex"),
            b.displacements(i).expect("a vertex"),
        );
        assert_eq!(all.iter().count(), a.mode_count());
        for (j, u) in all.iter() {
            assert_eq!(own.of(j), u);
            assert_eq!(own.has(j), u != [0.0; 3], "nothing else is stored");
        }
        assert!(own.iter().all(|(j, u)| all.of(j) == u));
        assert_eq!(own.of(a.mode_count()), [0.0; 3]);
        assert!(!all.has(a.mode_count()));
    }
    for asset in [&a, &b] {
        let beyond = VertexId(asset.vertex_count() as u32);
        assert!(asset.displacements(beyond).is_err());
        assert!(asset.displacements(VertexId(u32::MAX)).is_err());
    }
    let mut rng = poses::rng(4);
    let mut qs = poses::hard_qs(&a);
    qs.extend((0..8).map(|_| poses::random_q(&a, 0.3, &mut rng)));
    let mut found = 0;
    for q in qs {
        let (mut memory, mut memory2) = (vec![0.0; a.pose_len()], vec![0.0; a.pose_len()]);
        let place = poses::random_transform(0.5, &mut rng);
        let pose_a = a.pose(&q, place, &mut memory).expect("pose");
        let pose_b = b.pose(&q, place, &mut memory2).expect("pose");
        for i in (0..a.vertex_count() as u32).map(VertexId) {
            let (x, y) = (pose_a.deformed_stored(i), pose_b.deformed_stored(i));
            assert_eq!(x.expect("a vertex"), y.expect("a vertex"), "{i:?} {q:?}");
        }
        let (contacts, pairs) = answers(&a, &q, place);
        found += contacts.len() + pairs.len();
        assert!((contacts, pairs) == answers(&b, &q, place), "{q:?}");
    }
    assert!(found > 1000, "{found}");
}

/// A sphere of which each record of VMOD breaks each rule once: found at its place, by its rule.
#[test]
fn every_broken_vertex_record_is_found() {
    const FIRST: usize = offset_of!(VertexModes, first_entry);
    const LIST: usize = offset_of!(VertexModes, mode_list_start);
    const ENTRIES: &str = "SPEC 7.6: first entries ascend";
    const ENDS: &str = "SPEC 7.6: the first record begins at 0";
    const WHOLE: &str = "SPEC 6.7: nodes and vertices use whole mode lists";
    let model = sphere();
    let asset = *model.asset();
    let sound = asset.bytes();
    let records = asset.vertex_modes();
    let last = records.len() - 1;
    let start = mutate::section(sound, SectionKind::VERTEX_MODES).start;
    let size = size_of::<VertexModes>();
    let check = |i: usize, field: usize, value: u32, reported: usize, rule: &str| {
        let mut bytes = sound.to_vec();
        mutate::put(&mut bytes, start + i * size + field, &value.to_le_bytes());
        mutate::repair(&mut bytes);
        let found = errors(&Model::from_bytes(&bytes).expect("open"));
        let byte = (start + reported * size) as u64;
        assert!(
            found.iter().any(|(section, at, text)| {
                *section == SectionKind::VERTEX_MODES && *at == byte && text.starts_with(rule)
            }),
            "record {i}, {field}: {value}, not {:?}: {found:?}",
            records[i]
        );
    };
    let lists = asset.sections().iter();
    let lists = lists.filter(|s| s.kind == SectionKind::MODE_LISTS);
    let entries = lists.map(|s| s.length.get() as u32 / 2).sum::<u32>();
    for i in 0..last {
        let count = records[i + 1].first_entry - records[i].first_entry;
        if count == 0 {
            check(i, LIST, 1, i, "SPEC 6.7: an empty mode list starts at 0");
        } else {
            check(i, LIST, u32::MAX, i, "SPEC 6.7: mode lists lie inside LIST");
            check(i, LIST, entries - count + 1, i, "SPEC 6.7: mode lists lie");
            // The list before ends, or this one begins, elsewhere.
            if count > 1 {
                check(i, LIST, records[i].mode_list_start + 1, i, "SPEC 6.7");
                check(i + 1, FIRST, records[i + 1].first_entry - 1, i, WHOLE);
            }
        }
        if i > 0 {
            let before = records[i - 1].first_entry;
            check(i, FIRST, u32::MAX, i, ENTRIES);
            check(i, FIRST, before + 13, i - 1, ENTRIES); // more than twelve modes
            if before > 0 {
                check(i, FIRST, before - 1, i - 1, ENTRIES);
            }
        }
    }
    check(0, FIRST, 1, 0, ENDS);
    check(last, FIRST, records[last].first_entry + 1, last, ENDS);
    check(last, FIRST, 0, last, ENDS);
    check(last, LIST, 1, last, ENDS);
}

/// A list that nothing uses, one twice, one out of order, modes that do not exist.
#[test]
fn every_broken_list_is_found() {
    let model = sphere();
    let sound = model.asset().bytes();
    let place = mutate::section(sound, SectionKind::MODE_LISTS);
    let entries: Vec<u16> = sound[place]
        .chunks(2)
        .map(|pair| u16::from_le_bytes([pair[0], pair[1]]))
        .collect();
    // In descending order: mode 11 alone is the first list, mode 1 alone the last.
    assert_eq!((entries[0], entries[entries.len() - 1]), (11, 1));
    for (more, rule) in [
        (
            &[0][..],
            "SPEC 6.7: every mode list is a node's or a vertex's",
        ),
        (
            &[1],
            "SPEC 6.7: mode lists stand in descending order, each once",
        ),
        (
            &[1, 7],
            "SPEC 6.7: mode lists stand in descending order, each once",
        ),
        (
            &[0, 12],
            "SPEC 6.7: mode lists hold indices below the mode count",
        ),
    ] {
        let mut parts = sections::take_apart(sound);
        for part in &mut parts {
            if part.kind() == SectionKind::MODE_LISTS {
                part.body
                    .extend(more.iter().flat_map(|j: &u16| j.to_le_bytes()));
            }
        }
        let bytes = sections::put_together(sound, parts);
        let place = mutate::section(&bytes, SectionKind::MODE_LISTS);
        let found = errors(&Model::from_bytes(&bytes).expect("open"));
        let (section, byte, text) = found[0];
        assert_eq!((section, text), (SectionKind::MODE_LISTS, rule), "{more:?}");
        assert!(
            (place.end as u64 - 4..place.end as u64).contains(&byte),
            "{byte}"
        );
    }
}

/// `p + U q` of what `rest_vertex` gives is the deformed vertex, in both layouts.
#[test]
fn vertices_at_rest_and_their_displacements_give_the_deformed_ones() {
    let mesh = bake::bumpy_sphere(8, 1);
    let mut rng = poses::rng(6);
    let (mut layouts, mut zeros) = (Vec::new(), 0);
    for basis in [
        bake::smooth_basis(&mesh, 6, 5),
        bake::local_basis(&mesh, 9, 5),
    ] {
        let model = bake::baked(&mesh, &basis);
        let asset = model.asset();
        let modes = asset.mode_count();
        layouts.push(asset.vertex_modes().is_empty());
        let q = poses::random_q(asset, 0.3, &mut rng);
        let mut memory = vec![0.0; asset.pose_len()];
        let pose = asset.pose(&q, Transform::IDENTITY, &mut memory);
        let pose = pose.expect("a pose");
        // One entry behind the modes, which is not touched.
        let mut fields = vec![[7.0; 3]; modes + 1];
        let size = poses::diagonal(asset) * asset.unit();
        for vertex in (0..asset.vertex_count() as u32).map(VertexId) {
            let rest = asset.rest_vertex(vertex, &mut fields).expect("a vertex");
            assert_eq!(fields[modes], [7.0; 3]);
            let deformed = pose.deformed(vertex).expect("a vertex");
            for k in 0..3 {
                let moved = fields.iter().zip(&q).map(|(u, q)| u[k] * f64::from(*q));
                let off = (rest[k] + moved.sum::<f64>() - deformed[k]).abs();
                assert!(off <= 1e-6 * size, "{vertex:?}: {off}");
            }
            zeros += fields[..modes].iter().filter(|u| **u == [0.0; 3]).count();
        }
    }
    assert_eq!(layouts, [true, false]);
    assert!(zeros > 100, "modes that a vertex does not list: {zeros}");
}
