//! Those who deform all vertices carry them by bones as the product does, and find the same.

use std::path::Path;
use std::rc::Rc;

use bdtree_build::advise::samples::{Samples, Source};
use bdtree_build::{bake, progress::Silent, recipe};
use bdtree_measure::deform::Deformer;
use bdtree_measure::paper_tree::PaperTree;
use bdtree_measure::peers::{LayeredPeer, Obvhs, Peer, Target};
use bdtree_measure::{Body, Place};
use bdtree_runtime::{Ball, Contact, Model, Transform, VertexId, Workspace};

/// Bones with a morph target and four influences; twelve influences without targets and clips.
const FIXTURES: [(&str, usize, usize); 2] = [("skinned_tube.glb", 1, 4), ("skinned_12.glb", 0, 12)];

fn model(name: &str) -> Model {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../fixtures")
        .join(name);
    let morphs = recipe::Motion::MorphsElseSkin(Default::default(), Default::default());
    let recipe = recipe::Recipe::of_surface(path, morphs);
    let baked = bake(&recipe, &Silent).expect("bakes");
    Model::from_bytes(&baked.bytes).expect("opens")
}

#[test]
fn all_vertices_have_the_bits_of_the_leaves() {
    for (name, modes, influences) in FIXTURES {
        let model = model(name);
        let asset = model.asset();
        let record = asset.skin_record().expect("a skin");
        let counts = (asset.mode_count(), record.influences_max as usize);
        assert_eq!(counts, (modes, influences), "{name}");
        let samples = Samples::of(asset, 24).expect("samples");
        // Where modes move, too: in the tube's clips.
        assert_eq!(samples.source == Source::Clips, modes > 0, "{name}");
        let deformer = Deformer::new(&Body::of_asset(asset).expect("sound"));
        let mut out = vec![0.0; deformer.count];
        let mut memory = vec![0.0; asset.pose_len()];
        for sample in 0..samples.count {
            let (q, joints) = (samples.q(sample), samples.joints(sample));
            let pose = asset.pose_with_bones(q, joints, Transform::IDENTITY, &mut memory);
            let pose = pose.expect("a pose");
            deformer.deform(pose.q(), pose.bone_maps(), &mut out);
            for (vertex, p) in (0..).map(VertexId).zip(out.as_chunks::<3>().0) {
                let own = pose.deformed_stored(vertex).expect("a vertex");
                assert_eq!(p.map(f32::to_bits), own.map(f32::to_bits), "{name}");
            }
        }
    }
}

#[test]
fn those_who_refit_find_what_the_product_finds() {
    for (name, ..) in FIXTURES {
        let model = model(name);
        let asset = model.asset();
        let samples = Samples::of(asset, 6).expect("samples");
        let body = Body::of_asset(asset).expect("sound");
        let deformer = Deformer::new(&body);
        let tree = Rc::new(PaperTree::build(asset));
        let mut peers: [Box<dyn Peer>; 2] = [
            Box::new(Obvhs::new(&body)),
            Box::new(LayeredPeer::new(tree, &deformer)),
        ];
        let (mut memory, mut workspace) = (vec![0.0; asset.pose_len()], Workspace::new());
        let mut touched = 0;
        for sample in 0..samples.count {
            let (q, joints) = (samples.q(sample), samples.joints(sample));
            let pose = asset.pose_with_bones(q, joints, Transform::IDENTITY, &mut memory);
            let pose = pose.expect("a pose");
            let to = Target {
                deformer: &deformer,
                q: pose.q(),
                bones: pose.bone_maps(),
                place: &Place::IDENTITY,
            };
            for peer in &mut peers {
                peer.update_untimed(to, &mut Vec::new());
            }
            for vertex in (0..asset.vertex_count() as u32).step_by(7).map(VertexId) {
                // Peers are in stored units about the origin.
                let center = pose.deformed_stored(vertex).expect("a vertex");
                let center = center.map(f64::from);
                let radius = 0.1 / asset.unit();
                let world = [0, 1, 2].map(|k| asset.origin()[k] + asset.unit() * center[k]);
                let mut own: Vec<Contact> = Vec::new();
                let mut query = pose.query(&mut workspace);
                query
                    .contacts(Ball::new(world, 0.1), &mut own)
                    .expect("an answer");
                let ids = |found: &[Contact]| {
                    let mut ids: Vec<u32> = found.iter().map(|c| c.triangle.0).collect();
                    ids.sort_unstable();
                    ids
                };
                touched += own.len();
                for peer in &mut peers {
                    let mut found = Vec::new();
                    peer.ball(center, radius, &mut found);
                    assert_eq!(ids(&found), ids(&own), "{name}, {vertex:?}");
                }
            }
        }
        assert!(touched > 100, "{name}: {touched}");
    }
}
