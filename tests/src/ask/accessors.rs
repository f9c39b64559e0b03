//! What a program reads of a file without asking a query.

use bdtree_runtime::{Asset, Pose, StackEntry, Transform, TriangleId, VertexId};
use bdtree_runtime::{add_generalized_force, query};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::{Answers, located, some_q};

/// Reads everything once.
pub(super) fn read_all(asset: &Asset<'_>, rng: &mut Pcg64Mcg, answers: &mut Answers) {
    if let Err(error) = asset.verify_checksums() {
        located(&error);
    }
    for group in asset.groups() {
        let _ = (group.kind, group.first_triangle, group.triangle_count);
        assert!(group.name.len() <= asset.bytes().len());
    }
    assert!(asset.metadata().len() <= asset.bytes().len());
    assert!(asset.unit() > 0.0 && asset.origin().iter().all(|x| x.is_finite()));
    assert!(asset.sections().len() <= 64);
    assert_eq!(asset.triangles().len(), asset.triangle_slots().len());
    assert!(asset.kernel().is_available());
    // A corrupt level may be any; the count never passes the nodes.
    for level in 0..=asset.depth() {
        assert!(asset.node_count_to(level) <= asset.node_count());
    }
    play(asset, answers);
    let q = some_q(asset, rng);
    let mut memory = vec![0.0; asset.pose_len()];
    let tolerance = [0.0, 1e-3, f64::INFINITY][rng.random_range(0..3)];
    let place = Transform::IDENTITY;
    let pose = Pose::with_tolerance(asset, &q, place, tolerance, &mut memory).expect("a pose");
    assert!(pose.active_modes() <= asset.mode_count() && pose.slack() > 0.0);
    assert_eq!(pose.q().len(), asset.mode_count());
    // At most a hundred of each, so that larger files cost no more.
    let step = |count: usize| (count / 100).max(1);
    for i in (0..asset.vertex_count()).step_by(step(asset.vertex_count())) {
        let vertex = VertexId(i as u32);
        let found = answers.read(asset.deformed(&pose, vertex));
        assert_eq!(
            found.is_some(),
            asset.deformed_stored(&pose, vertex).is_ok()
        );
        if let Some(own) = answers.read(asset.displacements(vertex)) {
            assert!(own.iter().count() <= asset.mode_count());
            let _ = (own.of(0), own.of(511), own.has(3));
        }
    }
    for records in asset.vertex_modes().windows(2) {
        let _ = records[0].first_entry.checked_sub(records[1].first_entry);
    }
    let mut force = vec![0.0; asset.mode_count()];
    for i in (0..asset.triangle_count()).step_by(step(asset.triangle_count())) {
        let triangle = TriangleId(i as u32);
        answers.read(asset.triangle(triangle));
        let (weights, push) = ([0.2, 0.3, 0.5], [1.0, -2.0, 3.0]);
        answers.read(add_generalized_force(
            asset, &pose, triangle, weights, push, &mut force,
        ));
    }
    for (i, node) in asset.nodes().iter().enumerate() {
        answers.read(asset.node_spheres(&pose, i as u32));
        answers.read(asset.node_modes(node));
        if let Some(rows) = answers.read(asset.node_rows(node)) {
            for k in 0..2 * rows.pairs.len() {
                let _ = rows.numbers(k, i % 8);
            }
        }
    }
    draw(asset, &pose, answers);
    // Beyond the last one.
    let vertex = VertexId(asset.vertex_count() as u32);
    assert!(asset.deformed(&pose, vertex).is_err() && asset.displacements(vertex).is_err());
    assert!(
        asset
            .triangle(TriangleId(asset.triangle_count() as u32))
            .is_err()
    );
    assert!(
        asset
            .node_spheres(&pose, asset.node_count() as u32)
            .is_err()
    );
    assert!(asset.node_spheres(&pose, u32::MAX).is_err());
}

/// What programs ask that draw the mesh themselves: one that passes its check fails nowhere.
fn draw(asset: &Asset<'_>, pose: &Pose<'_>, answers: &mut Answers) {
    assert!(pose.belongs_to(asset) && asset.id() == asset.clone().id());
    assert!(asset.check_q(pose.q()).is_ok());
    let map = pose.stored_to_world();
    let same = asset.stored_to_world(Transform::IDENTITY).expect("a map");
    assert_eq!(map.linear(), same.linear());
    assert_eq!(map.offset(), same.offset());
    assert!(map.scale() > 0.0 && map.error(1.0) > 0.0);
    if answers.read(asset.check_mesh()).is_none() {
        return;
    }
    let mut fields = 0;
    for vertex in (0..asset.vertex_count() as u32).map(VertexId) {
        let own = asset.displacements(vertex).expect("of a sound mesh");
        assert!(own.iter().all(|(mode, _)| mode < asset.mode_count()));
        fields += own.iter().count();
        let stored = asset.deformed_stored(pose, vertex).expect("sound");
        let world = asset.deformed(pose, vertex).expect("sound");
        assert_eq!(map.point(stored).map(f64::to_bits), world.map(f64::to_bits));
    }
    if asset.vertex_modes().is_empty() {
        assert_eq!(fields, asset.displacement_fields().len());
        assert!(asset.mode_list_entries().iter().count() <= asset.bytes().len());
    }
    for id in (0..asset.triangle_count() as u32).map(TriangleId) {
        let corners = asset.triangle(id).expect("of a sound mesh");
        assert!(
            corners
                .iter()
                .all(|v| (v.0 as usize) < asset.vertex_count())
        );
    }
}

/// Poses every frame, or is told why not.
fn play(asset: &Asset<'_>, answers: &mut Answers) {
    let mut memory = vec![0.0; asset.pose_len()];
    let mut stack = vec![StackEntry::default(); asset.stack_len()];
    for k in 0..asset.frame_count() {
        let frame = asset.frame(k).expect("a frame");
        assert_eq!(frame.q().len(), asset.mode_count());
        let _ = frame.time_s();
        let place = Transform::IDENTITY.after(frame.transform());
        let pose = Pose::new(asset, frame.q(), frame.transform(), &mut memory);
        assert!(place.is_ok() || pose.is_err());
        if let Ok(pose) = pose {
            let point = [0.9, 0.3, 0.2];
            answers.take(query::closest(asset, &pose, point, 1.0, &mut stack));
        }
    }
    assert!(asset.frame(asset.frame_count()).is_none());
    assert!(asset.frame(usize::MAX).is_none());
}
