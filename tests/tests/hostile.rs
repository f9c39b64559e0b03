//! Damaged files never cause a panic, a hang or an error without a place, and `verify` finds every
//! flipped bit and every bound that is too small.

use std::mem::{offset_of, size_of};
use std::ops::ControlFlow;
use std::sync::LazyLock;

use bdtree_build::basis::Basis;
use bdtree_build::input::{GroupKind, RawGroup, RawMesh};
use bdtree_format::{Header, NodeRecord, SectionKind, SectionRecord};
use bdtree_runtime::narrow::Frustum;
use bdtree_runtime::{
    AlignedBytes, Asset, Contact, FormatError, LeafSlot, NodeSlot, PairContact, PairStackEntry,
    Pose, QueryError, SearchEntry, SliceSink, StackEntry, StepCache, Transform, TrianglePair,
    query,
};
use bdtree_tests::{bake, mutate, poses};
use rand::RngExt;

fn sphere(n: u32) -> RawMesh {
    let mut mesh = bake::bumpy_sphere(n, 1);
    let group = |kind, name: &str, first_triangle, triangle_count| RawGroup {
        kind,
        name: name.to_string(),
        first_triangle,
        triangle_count,
    };
    mesh.groups = vec![
        group(GroupKind::Object, "sphere", 0, mesh.triangles.len() as u32),
        group(GroupKind::Material, "gläsern", 3, 7),
    ];
    mesh
}

/// Every field moves the vertices on one side only.
fn local_basis(mesh: &RawMesh, mode_count: usize) -> Basis {
    let mut basis = bake::smooth_basis(mesh, mode_count, 3);
    let count = mesh.positions.len();
    for (k, u) in basis.fields.iter_mut().enumerate() {
        let (j, p) = (k / count, mesh.positions[k % count]);
        let side = if j % 2 == 0 { 1.0 } else { -1.0 };
        if side * p[j % 3] < 0.3 {
            *u = [0.0; 3];
        }
    }
    basis
}

/// Rigid, two modes, ten local modes of which vertices list some, two modes with frames: small
/// files.
static SMALL: LazyLock<Vec<AlignedBytes>> = LazyLock::new(|| {
    let mesh = sphere(4);
    let tiny = bake::bumpy_sphere(2, 1);
    let moving = bake::smooth_basis(&tiny, 2, 1);
    let files = vec![
        bake::baked(&mesh, &bake::rigid(&mesh)),
        bake::baked(&mesh, &bake::smooth_basis(&mesh, 2, 1)),
        bake::baked(&mesh, &local_basis(&mesh, 10)),
        bake::baked(&tiny, &bake::with_frames(moving, 3, 1.0, 1)),
    ];
    let asset = Asset::open(&files[2]).expect("open");
    assert!(!asset.vertex_modes().is_empty());
    files
});

/// A few hundred triangles, on several levels.
static LARGER: LazyLock<AlignedBytes> = LazyLock::new(|| {
    let mesh = sphere(9);
    bake::baked(&mesh, &local_basis(&mesh, 6))
});

/// What pair queries hold against a damaged file.
static PARTNER: LazyLock<AlignedBytes> = LazyLock::new(|| {
    let mesh = bake::bumpy_sphere(2, 1);
    bake::baked(&mesh, &bake::smooth_basis(&mesh, 1, 1))
});

fn located(error: &FormatError) {
    assert!(error.rule.starts_with("SPEC "), "{error}");
    assert!(error.section.0.iter().any(|b| *b != 0), "{error}");
}

fn answered<T>(result: Result<T, QueryError>) -> Option<T> {
    match result {
        Ok(answer) => Some(answer),
        Err(QueryError::Corrupt(error)) => {
            located(&error);
            None
        }
        Err(other) => panic!("{other}"),
    }
}

/// Whether `verify` finds something; stops at the first error.
fn refused(asset: &Asset<'_>) -> bool {
    !asset.verify(&mut |error| {
        located(&error);
        ControlFlow::Break(())
    })
}

/// Memory that is used again from file to file.
struct Scratch {
    stack: Vec<StackEntry>,
    pair_stack: Vec<PairStackEntry>,
    contacts: Vec<Contact>,
    pairs: Vec<PairContact>,
    search: Vec<SearchEntry>,
    ids: Vec<TrianglePair>,
    turn: usize,
}

impl Scratch {
    fn new() -> Self {
        Self {
            stack: vec![StackEntry::default(); 14 * 32 + 2],
            pair_stack: vec![PairStackEntry::default(); 70 * 32 + 1],
            contacts: vec![Contact::EMPTY; 4096],
            pairs: vec![PairContact::EMPTY; 4096],
            search: vec![SearchEntry::default(); 14 * 32 + 1],
            ids: vec![TrianglePair::EMPTY; 4096],
            turn: 0,
        }
    }

    /// Poses every frame, or is told why not.
    fn play(&mut self, asset: &Asset<'_>) {
        let mut memory = vec![0.0; asset.pose_len()];
        for k in 0..asset.frame_count() {
            let frame = asset.frame(k).expect("a frame");
            assert_eq!(frame.q().len(), asset.mode_count());
            let _ = frame.time_s();
            let place = Transform::IDENTITY.after(frame.transform());
            let pose = Pose::new(asset, frame.q(), frame.transform(), &mut memory);
            assert!(place.is_ok() || pose.is_err());
            if let Ok(pose) = pose {
                let point = [0.9, 0.3, 0.2];
                let _ = answered(query::closest(asset, &pose, point, 1.0, &mut self.stack));
            }
        }
        assert!(asset.frame(asset.frame_count()).is_none());
    }

    /// All queries; nothing but panics and visits without bound can go wrong.
    fn query_all(&mut self, asset: &Asset<'_>, partner: &Asset<'_>) {
        let limit = |j: usize| asset.modes()[j].q_limit.get();
        let q: Vec<f32> = (0..asset.mode_count())
            .map(|j| [0.3_f32, -0.2, 0.0][j % 3].clamp(-limit(j), limit(j)))
            .collect();
        let mut memory = vec![0.0; asset.pose_len()];
        let pose = Pose::new(asset, &q, Transform::IDENTITY, &mut memory).expect("pose");
        self.play(asset);
        let visits_max = asset.node_count() as u64;
        let (stack, point) = (&mut self.stack, [0.9, 0.3, 0.2]);
        let mut sink = SliceSink::new(&mut self.contacts);
        if let Some(outcome) = answered(query::ball(asset, &pose, point, 0.4, stack, &mut sink)) {
            assert!(outcome.nodes_visited <= visits_max);
        }
        sink.clear();
        let normal = [1.0, 2.0, 3.0];
        if let Some(outcome) = answered(query::plane(asset, &pose, normal, 0.0, stack, &mut sink)) {
            assert!(outcome.nodes_visited <= visits_max);
        }
        sink.clear();
        let found = query::capsule(asset, &pose, point, normal, 0.1, stack, &mut sink);
        assert!(answered(found).is_none_or(|o| o.nodes_visited <= visits_max));
        sink.clear();
        let (turned, half) = ([0.0, 0.6, 0.0, 0.8], [0.3, 0.2, 0.4]);
        let found = query::cuboid(asset, &pose, point, turned, half, stack, &mut sink);
        assert!(answered(found).is_none_or(|o| o.nodes_visited <= visits_max));
        let planes = Frustum::new(&[[1.0, 2.0, 3.0, 0.0], [-1.0, 0.5, 0.0, 0.8]]).expect("planes");
        let found = answered(query::frustum(asset, &pose, &planes, stack));
        assert!(found.is_none_or(|o| o.nodes_visited <= 1 + visits_max));
        if let Some(sphere) = answered(query::root_sphere(asset, &pose)) {
            assert!(sphere.radius >= 0.0 && sphere.center.iter().all(|x| x.is_finite()));
        }
        let near = answered(query::closest(asset, &pose, point, f64::INFINITY, stack));
        assert!(near.is_none_or(|n| n.nodes_visited <= visits_max));
        let hit = answered(query::ray(
            asset,
            &pose,
            [3.0; 3],
            [-1.0; 3],
            f64::INFINITY,
            stack,
        ));
        assert!(hit.is_none_or(|n| n.nodes_visited <= visits_max));
        let mut memory = vec![0.0; partner.pose_len()];
        let other = Pose::new(
            partner,
            &vec![0.1; partner.mode_count()],
            Transform::IDENTITY,
            &mut memory,
        )
        .expect("pose");
        // One of four combinations of order and tolerance, in turn.
        self.turn += 1;
        let tolerance = if self.turn.is_multiple_of(2) {
            0.0
        } else {
            0.05
        };
        let (mut a, mut b) = ((asset, &pose), (partner, &other));
        if (self.turn / 2).is_multiple_of(2) {
            (a, b) = (b, a);
        }
        let mut sink = SliceSink::new(&mut self.pairs);
        let found = query::pair(a, b, tolerance, &mut self.pair_stack, &mut sink);
        let bound = 2 * 81 * visits_max * partner.node_count() as u64;
        let plain = answered(found);
        assert!(plain.is_none_or(|o| o.nodes_visited <= bound));

        let slots = || StepCache::new([NodeSlot::EMPTY; 20], [LeafSlot::EMPTY; 4]);
        let (mut cache_a, mut cache_b) = (slots(), slots());
        let (mut pose_a, mut pose_b) = (cache_a.start(a.1), cache_b.start(b.1));
        let (kept_a, kept_b) = ((a.0, &mut pose_a), (b.0, &mut pose_b));
        let mut sink = SliceSink::new(&mut self.ids);
        let found = query::touching(kept_a, kept_b, tolerance, &mut self.pair_stack, &mut sink);
        let cached = answered(found);
        assert_eq!(
            cached.map(|o| o.nodes_visited),
            plain.map(|o| o.nodes_visited)
        );
        if !self.turn.is_multiple_of(3) {
            return; // what follows, for every third file
        }
        let near = answered(query::distance(a, b, f64::INFINITY, &mut self.search));
        assert!(near.is_none_or(|n| n.nodes_visited <= bound));
        let mut budget = query::Budget::new(20, &mut self.search);
        answered(budget.distance(a, b, f64::INFINITY));
        answered(budget.closest(asset, &pose, point, f64::INFINITY));
        answered(budget.ray(asset, &pose, [3.0; 3], [-1.0; 3], f64::INFINITY));
        let mut sink = SliceSink::new(&mut self.contacts);
        answered(budget.ball(asset, &pose, point, 0.4, &mut sink));
        // Ids of another file's triangles are as good as any.
        let mut pairs = self.pairs[..8].to_vec();
        let mut slots = [query::ManifoldSlot::default(); query::ManifoldSlot::count(8)];
        let mut regions: Vec<query::ContactRegion> = Vec::new();
        let (stack, memory) = (&mut self.stack, &mut slots);
        answered(query::manifold(
            a,
            b,
            &mut pairs,
            memory,
            stack,
            &mut regions,
        ));
    }
}

#[test]
fn every_truncation_is_refused() {
    for bytes in SMALL.iter().chain([&*LARGER]) {
        Asset::open(bytes).expect("the whole file opens");
        for length in 0..bytes.len() {
            let error = Asset::open(&bytes[..length]).expect_err("a truncated file");
            located(&error);
        }
        let longer = AlignedBytes::copy_of(&[bytes, &[0][..]].concat());
        assert!(Asset::open(&longer).is_err());
    }
}

/// The promise of SPEC 3.4, bit by bit; and queries that nobody asked to verify survive.
#[test]
fn every_flipped_bit_is_found_and_harmless() {
    let partner = Asset::open(&PARTNER).expect("open");
    let mut scratch = Scratch::new();
    let (mut flips, mut opened) = (0, 0);
    for bytes in SMALL.iter() {
        assert!(!refused(&Asset::open(bytes).expect("open")));
        let mut flipped = bytes.to_vec();
        let body = mutate::get_u32(bytes, offset_of!(Header, header_bytes)) as usize;
        for bit in 0..8 * bytes.len() {
            flips += 1;
            flipped[bit / 8] ^= 1 << (bit % 8);
            let copy = AlignedBytes::copy_of(&flipped);
            if let Ok(asset) = Asset::open(&copy) {
                assert!(refused(&asset), "bit {bit} of {} bytes", bytes.len());
                opened += 1;
                scratch.query_all(&asset, &partner);
            }
            if bit / 8 < body {
                // The same with the checksums made to fit: no promise but to end.
                let mut repaired = flipped.clone();
                mutate::repair(&mut repaired);
                let copy = AlignedBytes::copy_of(&repaired);
                if let Ok(asset) = Asset::open(&copy) {
                    let _ = refused(&asset);
                    scratch.query_all(&asset, &partner);
                }
            }
            flipped[bit / 8] ^= 1 << (bit % 8);
        }
    }
    println!("{flips} flips, {opened} files opened");
    assert!(flips > 90_000 && opened > flips / 2);
}

/// Records set to extreme values under valid checksums.
#[test]
fn damaged_records_are_harmless() {
    let partner = Asset::open(&PARTNER).expect("open");
    let mut scratch = Scratch::new();
    let mut rng = poses::rng(2004);
    let (mut opened, mut found) = (0, 0);
    let files: Vec<&AlignedBytes> = SMALL.iter().chain([&*LARGER]).collect();
    const CASES: usize = 75_000;
    for case in 0..CASES {
        // The larger file is slower: one case in 64.
        let file = files[if case % 64 == 0 {
            SMALL.len()
        } else {
            case % SMALL.len()
        }];
        let mut bytes = file.to_vec();
        mutate::mutate(&mut bytes, &mut rng);
        let copy = AlignedBytes::copy_of(&bytes);
        let Ok(asset) = Asset::open(&copy) else {
            continue;
        };
        opened += 1;
        found += usize::from(refused(&asset));
        scratch.query_all(&asset, &partner);
        if case % 1000 == 0 {
            scratch.query_all(&asset, &asset);
        }
    }
    println!("{CASES} files, {opened} opened, {found} of them refused by verify");
    assert!(opened > CASES / 2 && found > opened / 2);
}

/// A node that is its own child and that no other node leads to: counts and levels fit.
#[test]
fn a_node_that_is_its_own_child_is_found() {
    let mut bytes = LARGER.to_vec();
    let nodes = mutate::section(&bytes, SectionKind::NODES);
    assert!(
        nodes.len() >= 2 * size_of::<NodeRecord>(),
        "two nodes are needed"
    );
    let count = 2_u32;
    let second = nodes.start + size_of::<NodeRecord>();
    // The root keeps its leaf lanes only; the second node gets one inner lane, itself.
    bytes[nodes.start + offset_of!(NodeRecord, inner_mask)] = 0;
    mutate::put(&mut bytes, second, &1_u32.to_le_bytes());
    bytes[second + offset_of!(NodeRecord, inner_mask)] = 1;
    bytes[second + offset_of!(NodeRecord, leaf_mask)] &= !1;
    bytes[second + offset_of!(NodeRecord, leaf_counts)] = 0;
    mutate::put(
        &mut bytes,
        offset_of!(Header, node_count),
        &count.to_le_bytes(),
    );
    // NODE is shortened in place: its record's length, and everything behind moves up.
    let record = mutate::record(&bytes, SectionKind::NODES);
    if nodes.len() > 64 {
        let cut = (nodes.end.next_multiple_of(64)) - (nodes.start + 64);
        bytes.drain(nodes.start + 64..nodes.start + 64 + cut);
        let sections = mutate::get_u32(&bytes, offset_of!(Header, section_count)) as usize;
        for i in 1..sections {
            let at = record + i * size_of::<SectionRecord>() + offset_of!(SectionRecord, offset);
            let offset = mutate::get_u32(&bytes, at) - cut as u32;
            mutate::put(&mut bytes, at, &offset.to_le_bytes());
        }
        let length = (bytes.len() as u64).to_le_bytes();
        mutate::put(&mut bytes, offset_of!(Header, file_bytes), &length);
    }
    mutate::put(
        &mut bytes,
        record + offset_of!(SectionRecord, length),
        &64_u64.to_le_bytes(),
    );
    mutate::repair(&mut bytes);
    let bytes = AlignedBytes::copy_of(&bytes);
    let asset = Asset::open(&bytes).expect("open");
    let mut rules = Vec::new();
    asset.verify(&mut |e| {
        rules.push(e.rule);
        ControlFlow::Continue(())
    });
    assert!(
        rules.iter().any(|r| r.contains("children stand behind")),
        "{rules:?}"
    );
}

/// Random bytes, and random bytes behind a sound header.
#[test]
fn noise_is_refused() {
    let mut rng = poses::rng(7);
    for _ in 0..20_000 {
        let mut bytes = SMALL[1].to_vec();
        let from = [0, 8, 12, 128][rng.random_range(0..4)];
        rng.fill(&mut bytes[from..]);
        assert!(Asset::open(&AlignedBytes::copy_of(&bytes)).is_err());
    }
}
