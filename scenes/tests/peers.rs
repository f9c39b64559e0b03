//! All who refit, and the paper's lazy tree, find what testing every triangle finds.

use std::rc::Rc;

use bdtree_fixtures::bake;
use bdtree_measure::deform::Deformer;
use bdtree_measure::leaf;
use bdtree_measure::paper_tree::{Between, Memory, PaperTree};
#[cfg(feature = "embree")]
use bdtree_measure::peers::{Embree, embree};
use bdtree_measure::peers::{LayeredPeer, PairPeer, Peer, Target};
use bdtree_measure::{Body, Place};
use bdtree_runtime::narrow::{PreparedRay, Triangle, ray_hit};
use bdtree_runtime::{Contact, PairContact, Transform, Workspace};
use bdtree_scenes::workloads::{bodies, rays, sequence};

/// A body with everyone who can answer for it.
struct Case {
    body: Body,
    deformer: Deformer,
}

impl Case {
    fn new(body: Body) -> Self {
        Self {
            deformer: Deformer::new(&body),
            body,
        }
    }

    fn at<'a>(&'a self, q: &'a [f32], place: &'a Place) -> Target<'a> {
        Target::without_bones(&self.deformer, q, place)
    }

    /// All triangles at q and a place, moved in f32 as the peers do.
    fn triangles(&self, q: &[f32], place: &Place) -> Vec<Triangle> {
        let mut out = vec![0.0; self.deformer.count];
        self.deformer
            .deform_at(q, &[], place, &mut Vec::new(), &mut out);
        let points = out.as_chunks::<3>().0;
        let corners = |t: &[u32; 3]| t.map(|v| points[v as usize].map(f64::from));
        self.body.triangles.iter().map(corners).collect()
    }

    fn peers(&self, tree: &Rc<PaperTree>) -> Vec<(&'static str, Box<dyn Peer>)> {
        let peers: Vec<(_, Box<dyn Peer>)> = vec![
            (
                "layered",
                Box::new(LayeredPeer::new(Rc::clone(tree), &self.deformer)),
            ),
            #[cfg(feature = "peers")]
            (
                "parry",
                Box::new(bdtree_measure::peers::Parry::new(&self.body)),
            ),
            #[cfg(feature = "peers")]
            (
                "obvhs",
                Box::new(bdtree_measure::peers::Obvhs::new(&self.body)),
            ),
            #[cfg(feature = "peers")]
            (
                "tinybvh",
                Box::new(bdtree_measure::peers::TinyBvh::new(&self.body)),
            ),
        ];
        #[cfg(feature = "embree")]
        if let Some(device) = embree::Device::find().expect("a library that can be used") {
            let embree = Embree::new(&device, &self.body).expect("a mesh");
            return peers
                .into_iter()
                .chain([("embree", Box::new(embree) as Box<dyn Peer>)])
                .collect();
        }
        peers
    }
}

fn ids(found: &[Contact]) -> Vec<u32> {
    let mut ids: Vec<u32> = found.iter().map(|c| c.triangle.0).collect();
    ids.sort_unstable();
    ids
}

/// Balls and rays: the paper's lazy tree and all who refit against every triangle.
#[test]
fn balls_and_rays_equal_brute_force() {
    let case = Case::new(bodies::blob("blob", 10, 3));
    let model = bake::baked(&case.body.mesh(), &case.body.basis());
    let asset = model.asset();
    let tree = Rc::new(PaperTree::build(asset));
    let mut peers = case.peers(&tree);
    let mut memory = Memory::new(&tree, asset);
    let mut numbers = vec![0.0; asset.pose_len()];
    let (mut scratch, mut contacts) = (Vec::new(), 0);
    let shots = rays::rays("blob", 1);
    for (frame, q) in sequence(6, 10, 0.8, 5).chunks_exact(10).enumerate() {
        let triangles = case.triangles(q, &Place::IDENTITY);
        let pose = asset
            .pose(q, Transform::IDENTITY, &mut numbers)
            .expect("pose");
        memory.begin_step(&pose);
        for (_, peer) in &mut peers {
            peer.update(case.at(q, &Place::IDENTITY), &mut scratch);
        }
        for [origin, direction] in shots.of(frame, 50) {
            let center = [0, 1, 2].map(|k| f64::from(0.4 * origin[k]));
            let mut expected = Vec::new();
            for (id, corners) in triangles.iter().enumerate() {
                leaf::ball(id as u32, corners, center, 0.3, &mut expected);
            }
            contacts += expected.len();
            let mut found = Vec::new();
            tree.walk_ball(&mut memory.at(&pose), (center, 0.3), &mut found);
            assert_eq!(ids(&found), ids(&expected), "the paper's tree");
            let ray = PreparedRay::new(origin.map(f64::from), leaf::unit(direction.map(f64::from)));
            let hit = triangles
                .iter()
                .filter_map(|t| ray_hit(&ray, t, f64::INFINITY))
                .map(|hit| hit.t)
                .reduce(f64::min);
            let lazy = tree.walk_ray(&mut memory.at(&pose), origin, direction);
            assert_eq!(lazy, hit, "the paper's tree");
            for (name, peer) in &mut peers {
                let mut found = Vec::new();
                peer.ball(center, 0.3, &mut found);
                assert_eq!(ids(&found), ids(&expected), "{name}");
                let own = peer.ray(origin, direction);
                assert_eq!(own.is_some(), hit.is_some(), "{name}");
                // Libraries test triangles in f32.
                assert!(
                    (own.unwrap_or(0.0) - hit.unwrap_or(0.0)).abs() < 1e-4,
                    "{name}"
                );
            }
        }
    }
    assert!(
        contacts > 1000,
        "only {contacts} contacts: the test shows nothing"
    );
}

fn pairs_of<P: PairPeer>(name: &str, peers: [P; 2], case: &Case, q: [&[f32]; 2], place: &Place) {
    let [mut a, mut b] = peers;
    let mut scratch = Vec::new();
    a.update(case.at(q[0], &Place::IDENTITY), &mut scratch);
    b.update(case.at(q[1], place), &mut scratch);
    let mut found = Vec::new();
    a.pair(&mut b, &mut found);
    let mut found: Vec<_> = found
        .iter()
        .map(|c| (c.triangle1.0, c.triangle2.0))
        .collect();
    found.sort_unstable();
    let (one, two) = (
        case.triangles(q[0], &Place::IDENTITY),
        case.triangles(q[1], place),
    );
    let mut expected = Vec::new();
    for (i, one) in one.iter().enumerate() {
        for (j, two) in two.iter().enumerate() {
            leaf::pair((i as u32, one), (j as u32, two), &mut expected);
        }
    }
    let expected: Vec<_> = expected
        .iter()
        .map(|c| (c.triangle1.0, c.triangle2.0))
        .collect();
    assert!(
        expected.len() > 20,
        "{} pairs: the test shows nothing",
        expected.len()
    );
    assert_eq!(found, expected, "{name}");
}

/// Two bodies: all who refit, and the paper's lazy tree, against all pairs of triangles.
#[test]
fn pairs_equal_brute_force() {
    let case = Case::new(bodies::blob("blob", 8, 3));
    let model = bake::baked(&case.body.mesh(), &case.body.basis());
    let asset = model.asset();
    let tree = Rc::new(PaperTree::build(asset));
    let q = sequence(2, 10, 0.8, 11);
    let q = [&q[..10], &q[10..]];
    let place = Place::new([0.1, 0.5, -0.1, 0.73_f64.sqrt()], [1.1, 1.2, -0.7]);
    let layered = || LayeredPeer::new(Rc::clone(&tree), &case.deformer);
    pairs_of("layered", [layered(), layered()], &case, q, &place);
    #[cfg(feature = "peers")]
    {
        use bdtree_measure::peers::{Parry, TinyBvh};
        let parry = Parry::new(&case.body);
        pairs_of("parry", [parry.clone(), parry], &case, q, &place);
        let tiny = TinyBvh::new(&case.body);
        pairs_of("tinybvh", [tiny.clone(), tiny], &case, q, &place);
    }
    let mut numbers = [(); 2].map(|()| vec![0.0; asset.pose_len()]);
    let [one, two] = &mut numbers;
    let pose_a = asset.pose(q[0], Transform::IDENTITY, one).expect("pose");
    let pose_b = asset.pose(q[1], place.transform(), two).expect("pose");
    let mut memories = [(); 2].map(|()| Memory::new(&tree, asset));
    memories[0].begin_step(&pose_a);
    memories[1].begin_step(&pose_b);
    let [a, b] = &mut memories;
    let mut found = Vec::new();
    PaperTree::walk_pair(
        (&tree, &mut a.at(&pose_a)),
        (&tree, &mut b.at(&pose_b)),
        &Between::new(&Place::IDENTITY, &place),
        &mut found,
    );
    let mut workspace = Workspace::new();
    let mut expected: Vec<PairContact> = Vec::new();
    let mut query = pose_a.against(&pose_b, &mut workspace);
    query.contacts(0.0, &mut expected).expect("pair");
    let ids = |all: &[PairContact]| {
        let mut ids: Vec<_> = all.iter().map(|c| (c.triangle1, c.triangle2)).collect();
        ids.sort_unstable();
        ids
    };
    assert_eq!(ids(&found), ids(&expected));
}

/// What is named as Embree and is not: one error that names the file.
#[cfg(feature = "embree")]
#[test]
fn libraries_that_are_not_embree_are_refused() {
    let own = std::env::current_exe().expect("this program");
    for path in [std::path::Path::new("no/such/library.so"), &own] {
        let error = embree::Device::open(path).err().expect("an error");
        assert!(error.contains(embree::VARIABLE), "{error}");
        assert!(error.contains(&path.display().to_string()), "{error}");
    }
}
