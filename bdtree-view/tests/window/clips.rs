//! Skins: what a clip shows, and how it plays.

use std::fs;

use bdtree_runtime::{SkeletonPose, VertexId};
use bdtree_tools::{AssetFile, PostureArguments, posture};
use bdtree_view::app::App;

use crate::display::{Display, Picture};
use crate::find::{buttons, middle};
use crate::hands::LEFT;
use crate::input::Session;
use crate::{BACKGROUND, EDGE, PICTURE, SIZE, file, screenshot};

const SKIN: &str = "skinned.bdt";
const CLIP: &str = "wave";

/// Left, top, right and bottom of what is drawn.
fn drawn(picture: &Picture) -> [u32; 4] {
    let [left, top, right, bottom] = PICTURE;
    let pixels = (left..right).flat_map(|x| (top..bottom).map(move |y| [x, y]));
    let drawn = pixels.filter(|[x, y]| picture.at(*x, *y) != BACKGROUND);
    drawn.fold([u32::MAX, u32::MAX, 0, 0], |[a, b, c, d], [x, y]| {
        [a.min(x), b.min(y), c.max(x), d.max(y)]
    })
}

/// Where the vertices are that the runtime carries by the clip's bones, before a camera that sees all of the clip, or
/// only that moment where joints are given.
fn expected(time: f64, is_clip: bool) -> [f32; 4] {
    let file = AssetFile::read(&file(SKIN)).expect("a golden file");
    let asset = file.checked_asset(true).expect("sound");
    let asked = PostureArguments {
        clip: Some(CLIP.to_string()),
        time,
        ..PostureArguments::default()
    };
    let posture = posture(&file, &asked).expect("a posture");
    let mut app = App::new(&file, posture.clone()).expect("a state");
    if is_clip {
        let mut clips = asset.skeleton().expect("a skeleton").clips();
        let clip = clips.position(|clip| clip.name() == CLIP);
        app.begin_clip(clip.expect("a clip"), time, false);
    }
    let size = [SIZE[0] - EDGE, SIZE[1]];
    app.fit(size[0] as f32 / size[1] as f32).expect("a camera");
    let camera = app.view.camera.expect("a camera");
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = asset
        .pose_with_bones(&posture.q, posture.bones(), posture.transform, &mut memory)
        .expect("a pose");
    let mut seen = [f32::MAX, f32::MAX, f32::MIN, f32::MIN];
    for corner in asset.triangles().iter().flat_map(|t| t.corners) {
        let p = pose.deformed(VertexId(corner)).expect("a vertex");
        let [x, y] = camera.project(app.place.shown(p), size).expect("in front");
        let [x, y] = [x + EDGE as f32, y];
        seen = [
            seen[0].min(x),
            seen[1].min(y),
            seen[2].max(x),
            seen[3].max(y),
        ];
    }
    seen
}

#[track_caller]
fn is_where_expected(picture: &Picture, expected: [f32; 4]) {
    let drawn = drawn(picture);
    let apart = drawn.iter().zip(expected);
    let apart = apart.map(|(a, b)| (*a as f32 - b).abs());
    assert!(apart.fold(0.0, f32::max) < 2.0, "{drawn:?} {expected:?}");
}

#[test]
fn a_clip_carries_the_mesh() {
    let display = Display::start();
    let shot = |options: &[&str]| screenshot(&display, &file(SKIN), options);
    let mut before = shot(&[]);
    for time in ["0.25", "0.75"] {
        let picture = shot(&["--clip", CLIP, "--time", time]);
        assert!(picture.difference(&before, PICTURE) > 0.01, "{time}");
        is_where_expected(&picture, expected(time.parse().expect("seconds"), true));
        before = picture;
    }

    // The same joints as an array.
    let model = AssetFile::read(&file(SKIN)).expect("a golden file");
    let mut pose = SkeletonPose::new(model.model()).expect("a skeleton");
    let clip = model.asset().skeleton().expect("a skeleton");
    let clip = clip.clips().position(|clip| clip.name() == CLIP);
    pose.play(clip.expect("a clip"), 0.75).expect("a moment");
    let joints = pose.joints();
    let numbers = joints.iter().flat_map(|m| m.iter().flatten().copied());
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("joints.npy");
    let array = bdtree_fixtures::models::fields::npy(&[joints.len(), 3, 4], numbers);
    fs::write(&path, array).expect("written");
    let q: Vec<String> = pose.q().iter().map(f32::to_string).collect();
    let options = [
        "--joints",
        path.to_str().expect("UTF-8"),
        "--q",
        &q.join(","),
    ];
    is_where_expected(&shot(&options), expected(0.75, false));
}

#[test]
fn a_clip_plays_and_halts() {
    let mut session = Session::start(SKIN, &["--clip", CLIP]);
    // The first is "Zero all", then there is one for each mode.
    let modes = AssetFile::read(&file(SKIN)).expect("a golden file");
    let play = buttons(&session.first)[1 + modes.asset().mode_count()];
    let mut last = session.first.clone();
    session.click(middle(play));
    for _ in 0..3 {
        let moved = |screen: &Picture| screen.difference(&last, PICTURE) > 0.001;
        last = session.wait_for(moved);
    }
    session.hands.press(LEFT);
    session.hands.release(LEFT);
    session.viewer.wait_for_rest();
}
