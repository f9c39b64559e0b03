//! Skeletons and clips of a file, against matrices that the fixtures compute by themselves and by hand.

use std::ops::ControlFlow;

use bdtree_build::progress::Silent;
use bdtree_build::recipe::{Motion, Recipe};
use bdtree_fixtures::bake;
use bdtree_fixtures::models;
use bdtree_fixtures::skin::{
    ClipSource, LocalSource, NodeSource, bar, bar_skin, node_matrices, skinned_bar, skinned_tree,
    with_skin,
};
use bdtree_runtime::joint::{self, transform_point};
use bdtree_runtime::skeleton::{blend, blend_q};
use bdtree_runtime::{JointMatrix, LocalTransform, Model, Skeleton, SkeletonError, SkeletonPose};

fn near(found: &[JointMatrix], expected: &[JointMatrix]) {
    assert_eq!(found.len(), expected.len());
    let pairs = found.as_flattened().as_flattened().iter();
    for (a, b) in pairs.zip(expected.as_flattened().as_flattened()) {
        assert!((a - b).abs() < 1e-6, "{found:?}, not {expected:?}");
    }
}

/// The matrices of joints of a clip at a time, and q.
fn sampled(skeleton: &Skeleton<'_>, clip: usize, time_s: f64) -> (Vec<JointMatrix>, f32) {
    let mut locals = vec![LocalTransform::IDENTITY; skeleton.node_count()];
    let mut q = [7.0];
    let clip = skeleton.clip(clip).expect("a clip");
    clip.sample(time_s, &mut locals, &mut q).expect("a pose");
    (joints(skeleton, &locals), q[0])
}

fn joints(skeleton: &Skeleton<'_>, locals: &[LocalTransform]) -> Vec<JointMatrix> {
    let mut nodes = vec![joint::IDENTITY; skeleton.node_count()];
    skeleton.model_space(locals, &mut nodes).expect("matrices");
    let mut joints = vec![joint::IDENTITY; skeleton.joint_count()];
    skeleton.joints(&nodes, &mut joints).expect("joints");
    joints
}

#[test]
fn hand_made_skins_are_sound() {
    for bytes in [skinned_bar(), skinned_tree()] {
        let model = Model::from_bytes(&bytes).expect("it opens");
        let mut errors = Vec::new();
        model.asset().verify(&mut |error| {
            errors.push(error.to_string());
            ControlFlow::Continue(())
        });
        assert!(errors.is_empty(), "{errors:#?}");
    }
}

#[test]
fn joints_have_names_and_parents() {
    let model = Model::from_bytes(&skinned_bar()).expect("it opens");
    let skeleton = model.asset().skeleton().expect("a skeleton");
    assert_eq!((skeleton.joint_count(), skeleton.node_count()), (3, 4));
    let names: Vec<_> = (0..4).map(|j| skeleton.joint_name(j)).collect();
    assert_eq!(names, [Some("root"), Some("elbow"), Some("tip"), None]);
    let parents: Vec<_> = (0..4).map(|j| skeleton.joint_parent(j)).collect();
    assert_eq!(parents, [None, Some(0), Some(1), None]);
    assert_eq!(skeleton.joint_index("tip"), Some(2));
    // A node that is no joint.
    assert_eq!(skeleton.joint_index("armature"), None);
    assert_eq!(skeleton.node_name(0), Some("armature"));
    assert_eq!(skeleton.node_parent(0), None);
    assert_eq!(skeleton.node_parent(3), Some(2));
    assert_eq!(skeleton.joint_node(2), Some(3));

    let clips: Vec<_> = skeleton
        .clips()
        .map(|clip| (clip.name(), clip.duration_s()))
        .collect();
    assert_eq!(clips, [("bend", 1.0), ("stretch", 2.0)]);
    assert!(skeleton.clip(2).is_none());
    assert_eq!(skeleton.clip_index("walk"), None);
    assert_eq!(skeleton.clip_index("stretch"), Some(1));

    let rigid = bake::bumpy_sphere(4, 1);
    let rigid = bake::baked(&rigid, &bake::rigid(&rigid));
    assert!(rigid.asset().skeleton().is_none());
    assert_eq!(SkeletonPose::new(&rigid).err(), Some(SkeletonError::NoSkin));
}

#[test]
fn the_hierarchy_is_followed() {
    let model = Model::from_bytes(&skinned_bar()).expect("it opens");
    let skeleton = model.asset().skeleton().expect("a skeleton");
    let mut locals = vec![LocalTransform::IDENTITY; 4];
    skeleton.rest(&mut locals).expect("rest");
    let source = bar_skin();
    let expected = node_matrices(&source.nodes);
    near(&joints(&skeleton, &locals), &expected[1..]);
    // At rest bones change nothing.
    for (b, bone) in model.asset().bones().iter().enumerate() {
        let inverse = bone.inverse_bind.map(|row| row.map(|x| x.get()));
        let map = joint::compose(&expected[b + 1], &inverse);
        near(&[map], &[joint::IDENTITY]);
        let rest = bone.rest.map(|row| row.map(|x| f64::from(x.get())));
        near(&[rest], &[joint::IDENTITY]);
    }
}

#[test]
fn clips_bend_the_bar() {
    let model = Model::from_bytes(&skinned_bar()).expect("it opens");
    let skeleton = model.asset().skeleton().expect("a skeleton");
    let (joints, q) = sampled(&skeleton, 0, 1.0);
    assert_eq!(q, 0.0);
    // The bar begins at (1, 2, 3); the elbow is 1.5 along x and the tip 1.5 behind it, along y after a quarter turn.
    let origin = [0.0; 3];
    let at = |joint: usize| transform_point(&joints[joint], origin);
    for (found, expected) in [
        (at(0), [1.0, 2.0, 3.0]),
        (at(1), [2.5, 2.0, 3.0]),
        (at(2), [2.5, 3.5, 3.0]),
    ] {
        let apart = (0..3).map(|k| (found[k] - expected[k]).abs());
        assert!(apart.fold(0.0, f64::max) < 1e-6, "{found:?}");
    }
    // Axes of the tip, twice as long: two quarter turns take its y axis from x to −x.
    let y = transform_point(&joints[2], [0.0, 1.0, 0.0]);
    assert!(
        (y[0] - 0.5).abs() < 1e-6 && (y[1] - 3.5).abs() < 1e-6,
        "{y:?}"
    );
    // Halfway the mode is raised, and each joint is turned by half of it.
    let (joints, q) = sampled(&skeleton, 0, 0.5);
    assert_eq!(q, 1.0);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let tip = transform_point(&joints[2], origin);
    assert!((tip[0] - (2.5 + 1.5 * half)).abs() < 1e-6, "{tip:?}");
    assert!((tip[1] - (2.0 + 1.5 * half)).abs() < 1e-6, "{tip:?}");
    // Outside, the first and the last key hold.
    assert_eq!(sampled(&skeleton, 0, -3.0), sampled(&skeleton, 0, 0.0));
    assert_eq!(sampled(&skeleton, 0, 9.0), sampled(&skeleton, 0, 1.0));
}

#[test]
fn clips_stretch_and_mirror_the_bar() {
    let model = Model::from_bytes(&skinned_bar()).expect("it opens");
    let skeleton = model.asset().skeleton().expect("a skeleton");
    let mut locals = vec![LocalTransform::IDENTITY; 4];
    let mut q = [7.0];
    let clip = skeleton.clip(1).expect("a clip");
    clip.sample(1.0, &mut locals, &mut q).expect("a pose");
    assert_eq!(q, [0.0], "no channel animates it");
    let parts = |local: &LocalTransform| match *local {
        LocalTransform::Parts {
            translation,
            rotation,
            scale,
        } => (translation, rotation, scale),
        LocalTransform::Matrix(_) => panic!("parts"),
    };
    // Halfway between 0.5 and 1.5, one second apart: half of (1, 0, 0.5), and an eighth of the out-tangent (1, 0, 0)
    // less the in-tangent (0, 1, 0).
    let (translation, rotation, _) = parts(&locals[1]);
    assert_eq!(translation, [0.625, -0.125, 0.25]);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let apart = rotation.iter().zip([0.0, half, -half, 0.0]);
    assert!(apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-7);
    assert_eq!(parts(&locals[3]).2, [2.0; 3]);
    clip.sample(0.999, &mut locals, &mut q).expect("a pose");
    assert_eq!(parts(&locals[3]).2, [1.0; 3]);
    clip.sample(2.0, &mut locals, &mut q).expect("a pose");
    assert_eq!(parts(&locals[3]).2, [1.0, 1.0, -1.0]);
    let mirrored = joints(&skeleton, &locals)[2].map(|[x, y, z, _]| [x, y, z]);
    let [a, b, c] = mirrored;
    let volume = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0]);
    assert!((volume + 8.0).abs() < 1e-6, "{volume}");
}

#[test]
fn poses_own_their_memory() {
    let model = Model::from_bytes(&skinned_bar()).expect("it opens");
    let skeleton = model.asset().skeleton().expect("a skeleton");
    let mut pose = SkeletonPose::new(&model).expect("a pose");
    let rest = pose.joints().to_vec();
    near(&rest, &node_matrices(&bar_skin().nodes)[1..]);
    pose.play(0, 0.75).expect("a clip");
    let (expected, q) = sampled(&skeleton, 0, 0.75);
    assert_eq!((pose.joints(), pose.q()), (&expected[..], &[q][..]));
    assert_eq!(q, 0.5);
    pose.blend_with(1, 1.25, 0.25).expect("a mixture");
    let mut locals = vec![LocalTransform::IDENTITY; 4];
    let mut other = locals.clone();
    let (mut q, mut other_q) = ([0.0], [0.0]);
    let [bend, stretch] = [0, 1].map(|i| skeleton.clip(i).expect("a clip"));
    bend.sample(0.75, &mut locals, &mut q).expect("a pose");
    stretch
        .sample(1.25, &mut other, &mut other_q)
        .expect("a pose");
    blend(&mut locals, &other, 0.25).expect("a mixture");
    blend_q(&mut q, &other_q, 0.25).expect("a mixture");
    assert_eq!((pose.locals(), pose.q()), (&locals[..], &q[..]));
    assert_eq!(pose.joints(), joints(&skeleton, &locals));
    // One clip over another: what only the second animates is its, the rest stays.
    bend.sample(1.0, &mut locals, &mut q).expect("a pose");
    let bent = locals[2];
    q[0] = 0.375;
    stretch
        .sample_over(1.0, &mut locals, &mut q)
        .expect("a pose");
    assert_eq!((locals[2], q), (bent, [0.375]));

    let head = pose.locals()[3];
    pose.locals_mut()[3] = LocalTransform::IDENTITY;
    assert_ne!(head, LocalTransform::IDENTITY);
    pose.update().expect("matrices");
    assert_eq!(pose.nodes()[3], pose.nodes()[2]);
    pose.rest().expect("rest");
    assert_eq!((pose.joints(), pose.q()), (&rest[..], &[0.0][..]));
}

#[test]
fn what_cannot_be_posed_is_refused() {
    let model = Model::from_bytes(&skinned_bar()).expect("it opens");
    let mut pose = SkeletonPose::new(&model).expect("a pose");
    for time in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(pose.play(0, time), Err(SkeletonError::Time));
    }
    let missing = Err(SkeletonError::NoClip { count: 2, found: 2 });
    assert_eq!(pose.play(2, 0.0), missing);
    assert_eq!(pose.blend_with(2, 0.0, 0.5), missing);
    let weight = Err(SkeletonError::Weight);
    assert_eq!(pose.blend_with(0, 0.0, f64::NAN), weight);
    let skeleton = model.asset().skeleton().expect("a skeleton");
    let mut locals = [LocalTransform::IDENTITY; 3];
    let short = |what, expected, found| {
        Err(SkeletonError::Length {
            what,
            expected,
            found,
        })
    };
    let expected = short("local transforms", 4, 3);
    assert_eq!(skeleton.rest(&mut locals), expected);
    let clip = skeleton.clip(0).expect("a clip");
    assert_eq!(clip.sample(0.0, &mut locals, &mut [0.0]), expected);
    let mut locals = [LocalTransform::IDENTITY; 4];
    let expected = short("entries of q", 1, 0);
    assert_eq!(clip.sample(0.0, &mut locals, &mut []), expected);
    let mut nodes = [joint::IDENTITY; 3];
    let expected = short("matrices of nodes", 4, 3);
    assert_eq!(skeleton.model_space(&locals, &mut nodes), expected);
    let mut joints = [joint::IDENTITY; 3];
    assert_eq!(skeleton.joints(&nodes, &mut joints), expected);
    let nodes = [joint::IDENTITY; 4];
    let expected = short("matrices of joints", 3, 4);
    assert_eq!(skeleton.joints(&nodes, &mut nodes.clone()), expected);
}

#[test]
fn joints_need_not_hang_together() {
    // Joints in another order than nodes, a node between two joints, a second root.
    let mut skin = bar_skin();
    let between = NodeSource {
        name: String::new(),
        parent: Some(3),
        local: LocalSource::Parts {
            translation: [0.0; 3],
            rotation: [0.0, 0.0, 0.0, 1.0],
            scale: [1.0; 3],
        },
    };
    skin.nodes.push(between.clone());
    skin.nodes.push(NodeSource {
        parent: Some(4),
        name: "finger".into(),
        ..between.clone()
    });
    skin.nodes.push(NodeSource {
        parent: None,
        name: "prop".into(),
        ..between
    });
    skin.joints = vec![5, 1, 6, 3];
    skin.bones
        .iter_mut()
        .zip([1, 3, 0])
        .for_each(|(bone, joint)| bone.joint = joint);
    skin.clips = vec![ClipSource {
        name: "still".into(),
        channels: vec![],
    }];
    let model = Model::from_bytes(&with_skin(&bar(), &skin)).expect("it opens");
    assert!(model.asset().verify(&mut |error| panic!("{error}")));
    let skeleton = model.asset().skeleton().expect("a skeleton");
    let parents: Vec<_> = (0..4).map(|j| skeleton.joint_parent(j)).collect();
    assert_eq!(parents, [Some(3), None, None, Some(1)]);
    assert_eq!(skeleton.joint_name(0), Some("finger"));
    let mut pose = SkeletonPose::new(&model).expect("a pose");
    pose.play(0, 5.0).expect("a clip");
    assert_eq!(pose.joints()[0], pose.nodes()[5]);
}

/// Without a clip a character looks as its source says: morph targets have their default weights.
#[test]
fn default_weights_are_those_of_the_source() {
    let animated = bdtree_fixtures::golden::folder().join("animated.bdt");
    let animated = Model::read(animated).expect("a golden file");
    let weights: Vec<_> = animated.asset().default_q().collect();
    assert_eq!(weights, [Some(0.125), None]);
    let motion = Motion::MorphsElseSkin(Default::default(), Default::default());
    let recipe = Recipe::of_surface(models::path("skinned_tube.glb"), motion);
    let tube = bdtree_build::bake(&recipe, &Silent).expect("bakes").bytes;
    let tube = Model::from_bytes(&tube).expect("it opens");
    assert!(tube.asset().default_q().eq([Some(0.25)]));
    let mut pose = SkeletonPose::new(&tube).expect("a skin");
    assert_eq!(pose.q(), [0.25]);
    // "slide" moves the weight; at rest it is back.
    pose.play(1, 0.5).expect("plays");
    assert_ne!(pose.q(), [0.25]);
    pose.rest().expect("rests");
    assert_eq!(pose.q(), [0.25]);
}
