//! Damaged files never cause a panic, a hang or an error without a place, and `verify` finds every
//! flipped bit and every bound that is too small (docs/design/fuzzing.md).

use std::collections::BTreeSet;
use std::mem::{offset_of, size_of};
use std::ops::ControlFlow;
use std::sync::LazyLock;
use std::time::Duration;

use bdtree_fixtures::ask::{Answers, ask_everything, located, read_skin, refused};
use bdtree_fixtures::compare::kernels;
use bdtree_fixtures::golden;
use bdtree_fixtures::hostile::{Run, Sources, agreed};
use bdtree_fixtures::judge::{Judgement, judge};
use bdtree_fixtures::mutate::Damage;
use bdtree_fixtures::sections::{put_together, take_apart};
use bdtree_fixtures::skin::skinned_bar;
use bdtree_fixtures::{mutate, poses};
use bdtree_format::{Header, NodeRecord, SectionKind, SectionRecord};
use bdtree_runtime::{
    Asset, Ball, CacheSize, Capsule, Contact, Cuboid, HalfSpace, Model, QueryError, Shape,
    StepCache, Transform, Workspace,
};
use rand::RngExt;

static SOURCES: LazyLock<Sources> = LazyLock::new(Sources::new);

/// Files that `fuzz-files` makes first; `BDTREE_FUZZ_CASES` names another number.
#[test]
fn damaged_files_are_harmless() {
    let cases = std::env::var("BDTREE_FUZZ_CASES").ok();
    let cases = cases.map_or(6000, |text| text.parse().expect("a number of cases"));
    let run = Run {
        seed: 2004,
        first: 0,
        cases,
        threads: std::thread::available_parallelism().map_or(1, usize::from),
        limit: Duration::from_secs(300),
    };
    let summary = run.go(&SOURCES, |_, _| {});
    println!("{summary}");
    assert!(summary.failures.is_empty(), "{summary}");
    if cases < 6000 {
        return; // shares of so few say nothing
    }
    // The cases reach what they are meant to reach.
    assert!(summary.opened > cases / 2 && summary.refused > cases / 2);
    assert!(summary.compared > cases / 50 && summary.broken > cases / 20);
    assert!(summary.holding > cases / 100 && summary.unclear < cases / 1000);
    assert!(summary.corrupt > cases && summary.answers > 10 * summary.corrupt);
}

/// Skins, skeletons and clips are read without a panic, whatever they hold; what passes the check is read whole.
#[test]
fn damaged_skins_are_harmless() {
    let sound = Model::from_bytes(&skinned_bar()).expect("a sound file");
    let mut answers = Answers::default();
    read_skin(sound.asset(), &mut answers);
    assert_eq!(
        (answers.given > 40, answers.corrupt),
        (true, 0),
        "{answers:?}"
    );
    let (mut opened, mut passed) = (0, 0);
    for case in 0..4000 {
        let mut rng = poses::rng(case);
        let damage = [
            Damage::Records,
            Damage::Layout,
            Damage::Tree,
            Damage::Several,
        ];
        let bytes = damage[case as usize % 4].done_to(sound.asset(), &mut rng);
        let model = match Model::from_bytes(&bytes) {
            Ok(model) => model,
            Err(error) => {
                located(&error);
                continue;
            }
        };
        opened += 1;
        let mut answers = Answers::default();
        read_skin(model.asset(), &mut answers);
        if !refused(model.asset()) {
            passed += 1;
            assert_eq!(answers.corrupt, 0, "case {case}: verify passed this file");
            let judgement = judge(model.asset());
            let broken = matches!(judgement, Judgement::Broken(_));
            assert!(!broken, "case {case}: {judgement:?}");
        }
    }
    assert!(
        opened > 1500 && passed > 100,
        "{opened} opened, {passed} passed"
    );
}

/// `verify` refuses changed bones of lanes, bone rows and other bounds of a skinned file exactly where one no longer holds.
#[test]
fn changed_bone_rows_are_judged_alike() {
    let tube = Model::read(golden::folder().join("skinned.bdt")).expect("a golden file");
    let bar = Model::from_bytes(&skinned_bar()).expect("a sound file");
    // What the judge says first.
    let mut broken = BTreeSet::new();
    for sound in [&tube, &bar] {
        assert_eq!(judge(sound.asset()), Judgement::Holds);
        let (mut holding, mut unclear) = (0, 0);
        let cases = 2000;
        for case in 0..cases {
            let bytes = Damage::Numbers.done_to(sound.asset(), &mut poses::rng(case));
            let model = Model::from_bytes(&bytes).expect("it opens");
            match agreed(model.asset(), refused(model.asset())) {
                Judgement::Holds => holding += 1,
                Judgement::Unclear => unclear += 1,
                Judgement::Broken(what) => {
                    broken.insert(what);
                }
            }
        }
        println!("{holding} hold, {unclear} unclear");
        assert!(holding > cases / 20 && unclear < cases / 50);
    }
    for rule in [
        "names no bone",
        "is negative",
        "names its bone again",
        "has a gap only",
        "is left out",
        "g of bone",
        ": S,",
        "epsilon,",
        "S or epsilon is negative",
        "an empty lane",
        "sum of beta",
    ] {
        let found = broken.iter().any(|what| what.contains(rule));
        assert!(found, "never broken first: {rule}");
    }
}

#[test]
fn every_truncation_is_refused() {
    let mut lengths = 0;
    for (name, model) in SOURCES.all() {
        let bytes = model.asset().bytes();
        for length in 0..bytes.len() {
            let error = Asset::open(&bytes[..length]);
            located(&error.expect_err("a truncated file"));
        }
        lengths += bytes.len();
        let longer = [bytes, &[0][..]].concat();
        assert!(Model::from_bytes(&longer).is_err(), "{name}");
    }
    println!("{lengths} lengths");
}

/// Flips one bit in every `step`, from bit `first` on: each must be found (SPEC 3.4). Of every
/// `asked`-th file that opens, and of the same with its checksums made to fit, everything is asked.
/// Returns the flips and the files opened.
fn flip(bytes: &[u8], first: usize, step: usize, asked: usize) -> [usize; 2] {
    let partner = SOURCES.partner.asset();
    let mut rng = poses::rng(first as u64);
    let body = mutate::get_u32(bytes, offset_of!(Header, header_bytes)) as usize;
    let mut flipped = bytes.to_vec();
    let mut counts = [0, 0];
    for bit in (first..8 * bytes.len()).step_by(step) {
        flipped[bit / 8] ^= 1 << (bit % 8);
        let ask = counts[0] % asked == 0;
        counts[0] += 1;
        if let Ok(model) = Model::from_bytes(&flipped) {
            assert!(refused(model.asset()), "bit {bit} of {} bytes", bytes.len());
            counts[1] += 1;
            if ask {
                ask_everything(model.asset(), partner, &mut rng);
            }
        }
        if ask && bit / 8 < body {
            // No promise but to end.
            let mut repaired = flipped.clone();
            mutate::repair(&mut repaired);
            if let Ok(model) = Model::from_bytes(&repaired) {
                let _ = refused(model.asset());
                ask_everything(model.asset(), partner, &mut rng);
            }
        }
        flipped[bit / 8] ^= 1 << (bit % 8);
    }
    counts
}

/// The small files in full, golden and baked, of the larger ones one bit in seventeen; these in full too
/// with `BDTREE_FLIP_ALL=1`.
#[test]
fn every_flipped_bit_is_found_and_harmless() {
    let all = std::env::var_os("BDTREE_FLIP_ALL").is_some();
    let mut total = [0, 0];
    for (k, (name, model)) in SOURCES.all().iter().enumerate() {
        assert!(!refused(model.asset()), "{name}");
        let bytes = model.asset().bytes();
        let small = bytes.len() < 6_000;
        let (step, asked) = match *name {
            "tetrahedron.bdt" => (1, 1),
            _ if all || small => (1, 64),
            _ => (17, 64),
        };
        let [flips, opened] = flip(bytes, k % step, step, asked);
        println!(
            "{name}: {flips} of {} bits, {opened} files opened",
            8 * bytes.len()
        );
        assert_eq!(flips, (8 * bytes.len() - k % step).div_ceil(step));
        total = [total[0] + flips, total[1] + opened];
    }
    println!("{} flips, {} files opened", total[0], total[1]);
    assert!(total[1] > total[0] / 2);
}

/// Every public function that reads a file, poses it or asks a query is one that is asked of damaged
/// files.
#[test]
fn nothing_public_is_left_out() {
    /// What damaged files cannot reach: plain memory, placements, and the file's own doors.
    const ELSEWHERE: [&str; 27] = [
        "open",
        "load",
        "from_static",
        "items",
        "items_mut",
        "state",
        "to_columns",
        "from_columns",
        "with_scale",
        // Arithmetic on matrices and transforms, and what owns them; tests/skeletons.rs.
        "compose",
        "invert",
        "transform_point",
        "joint_in_model",
        "to_matrix",
        "blended",
        "blend_q",
        "blend_with",
        "sample_over",
        "update",
        "locals",
        "locals_mut",
        "nodes",
        "play",
        "q",
        "rows",
        "stretch",
        // Of what a step has in its memory: an index against tags.
        "keeps",
    ];
    let asked = [
        include_str!("../../fixtures/src/ask/mod.rs"),
        include_str!("../../fixtures/src/ask/accessors.rs"),
        include_str!("../../fixtures/src/ask/instance.rs"),
        include_str!("../../fixtures/src/ask/pairs.rs"),
        include_str!("../../fixtures/src/ask/single.rs"),
        include_str!("../../fixtures/src/ask/skeleton.rs"),
        include_str!("../../fixtures/src/hostile/case.rs"),
        include_str!("../../fixtures/src/compare/sound.rs"),
        include_str!("../../fixtures/src/hostile/sources.rs"),
        include_str!("../../fixtures/src/judge.rs"),
    ]
    .concat();
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/src");
    let mut folders = vec![std::path::PathBuf::from(root)];
    let mut names = BTreeSet::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("the sources") {
            let path = entry.expect("an entry").path();
            // Arithmetic on what others give it.
            let arithmetic = ["narrow", "simd", "math.rs"];
            if arithmetic.iter().any(|own| path.ends_with(own)) {
                continue;
            }
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let text = std::fs::read_to_string(&path).expect("a source");
            for line in text.lines().map(str::trim_start) {
                let line = line
                    .strip_prefix("pub const fn ")
                    .or(line.strip_prefix("pub fn "));
                let end = |line: &str| line.find(|c: char| !c.is_alphanumeric() && c != '_');
                if let Some(line) = line {
                    names.insert(line[..end(line).unwrap_or(line.len())].to_string());
                }
            }
        }
    }
    assert!(names.len() > 60, "{names:?}");
    let called = |name: &String| {
        [".", "::", " ", "("]
            .iter()
            .any(|before| asked.contains(&format!("{before}{name}(")))
    };
    let missing: Vec<_> = names
        .iter()
        .filter(|name| !called(name) && !ELSEWHERE.contains(&name.as_str()))
        .collect();
    assert!(
        missing.is_empty(),
        "never asked of a damaged file: {missing:?}"
    );
}

/// A few hundred triangles, on several levels.
fn larger() -> &'static [u8] {
    let (_, model) = SOURCES.larger().last().expect("one");
    model.asset().bytes()
}

/// A node that is its own child and that no other node leads to: counts and levels fit.
#[test]
fn a_node_that_is_its_own_child_is_found() {
    let mut bytes = larger().to_vec();
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
    let model = Model::from_bytes(&bytes).expect("open");
    let mut rules = Vec::new();
    model.asset().verify(&mut |e| {
        rules.push(e.rule);
        ControlFlow::Continue(())
    });
    assert!(
        rules.iter().any(|r| r.contains("children stand behind")),
        "{rules:?}"
    );
}

/// Two nodes with the same leaf: each triangle is met twice, which no walk of one tree may do.
#[test]
fn leaves_that_share_triangles_end_a_walk() {
    let sound = SOURCES.small()[0].1.asset().bytes();
    let mut parts = take_apart(sound);
    let nodes = parts.iter_mut().find(|p| p.kind() == SectionKind::NODES);
    let nodes = &mut nodes.expect("nodes").body;
    let root = nodes[..size_of::<NodeRecord>()].to_vec();
    nodes.clear();
    for (inner, leaf, child) in [(3_u8, 0_u8, 1_u32), (0, 1, 3), (0, 1, 3)] {
        let mut node = root.clone();
        mutate::put(
            &mut node,
            offset_of!(NodeRecord, first_child),
            &child.to_le_bytes(),
        );
        mutate::put(&mut node, offset_of!(NodeRecord, first_slot), &[0; 4]);
        node[offset_of!(NodeRecord, inner_mask)] = inner;
        node[offset_of!(NodeRecord, leaf_mask)] = leaf;
        // Of 48 triangles; twice 20 would not be too many.
        let counts = [if leaf == 1 { 30 } else { 0 }, 0, 0, 0, 0, 0, 0, 0];
        mutate::put(&mut node, offset_of!(NodeRecord, leaf_counts), &counts);
        nodes.extend(node);
    }
    let mut bytes = put_together(sound, parts);
    for (at, value) in [
        (offset_of!(Header, node_count), 3_u32),
        (offset_of!(Header, depth), 2),
    ] {
        mutate::put(&mut bytes, at, &value.to_le_bytes());
    }
    mutate::repair(&mut bytes);
    let model = Model::from_bytes(&bytes).expect("open");
    for asset in kernels(model.asset()) {
        assert!(refused(&asset));
        let pose = asset.pose(&[], Transform::IDENTITY, &mut []).expect("pose");
        let mut workspace = Workspace::new();
        let mut cache = StepCache::new(CacheSize {
            nodes: 4,
            leaves: 40,
        });
        cache.start(&pose);
        let (at, far) = ([0.0; 3], 100.0);
        let mut found: Vec<Contact> = Vec::new();
        let mut proxies = Vec::new();
        let ball = Ball::new(at, far);
        let mut answers = Vec::new();
        for shape in [
            ball.into(),
            HalfSpace::new([1.0, 0.0, 0.0], far).into(),
            Capsule::new(at, [1.0; 3], far).into(),
            Shape::from(Cuboid::new(at, [far; 3])),
        ] {
            let mut query = pose.query(&mut workspace);
            answers.push(query.contacts(shape, &mut found).err());
        }
        let mut query = pose.query(&mut workspace).cached(&mut cache);
        answers.push(query.contacts(ball, &mut found).err());
        let mut query = pose.query(&mut workspace).max_level(9, &mut proxies);
        answers.push(query.contacts(ball, &mut found).err());
        let mut query = pose.query(&mut workspace).max_visits(u64::MAX);
        answers.push(query.contacts(ball, &mut found).err());
        for answer in answers {
            let Some(QueryError::Corrupt(error)) = answer else {
                panic!("{answer:?}");
            };
            assert!(
                error.rule.contains("every triangle is in one leaf lane"),
                "{error}"
            );
        }
        assert!(found.len() <= 7 * 48);
    }
}

/// Random bytes, and random bytes behind a sound header.
#[test]
fn noise_is_refused() {
    let mut rng = poses::rng(7);
    for _ in 0..20_000 {
        let mut bytes = SOURCES.small()[1].1.asset().bytes().to_vec();
        let from = [0, 8, 12, 128][rng.random_range(0..4)];
        rng.fill(&mut bytes[from..]);
        assert!(Model::from_bytes(&bytes).is_err());
    }
}
