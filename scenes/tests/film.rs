//! A film's pictures in a folder: their names, going on, what is refused.

use std::fs;

use bdtree_render::Image;
use bdtree_scenes::contenders::assets::baked_mesh;
use bdtree_scenes::film::{Frames, Heap, sphere_wires};
use bdtree_scenes::workloads::bodies::blob;

fn picture(shade: u8) -> Image {
    Image::filled([32, 18], [shade, 10, 10, 255])
}

#[test]
fn pictures_are_numbered_and_go_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = folder.path().join("new/film");
    let mut frames = Frames::resume(&place).expect("an empty folder");
    for (number, name) in [(0, "frame-00000.png"), (1, "frame-00001.png")] {
        assert_eq!(frames.next(), number);
        let path = frames.write(&picture(number as u8)).expect("written");
        assert_eq!(path, place.join(name));
        let bytes = fs::read(&path).expect("there");
        let mut whole = Vec::new();
        picture(number as u8)
            .write_png_fast(&mut whole)
            .expect("memory");
        assert_eq!(bytes, whole);
    }
    let mut frames = Frames::resume(&place).expect("the folder");
    assert_eq!(frames.next(), 2);
    frames.write(&picture(2)).expect("written");
    // Behind a gap is another film's.
    fs::copy(frames.path(0), place.join("frame-00007.png")).expect("copied");
    assert_eq!(Frames::resume(&place).expect("the folder").next(), 3);
    // Again from the middle: what is there is replaced.
    let mut frames = Frames::from(&place, 1).expect("the folder");
    frames.write(&picture(99)).expect("replaced");
    let mut whole = Vec::new();
    picture(99).write_png_fast(&mut whole).expect("memory");
    assert_eq!(fs::read(frames.path(1)).expect("there"), whole);
    let names = fs::read_dir(&place).expect("the folder").count();
    assert_eq!(names, 4, "nothing else is left behind");
}

#[test]
fn what_is_no_picture_is_left_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = folder.path();
    let text = place.join("frame-00000.png");
    for content in ["", "notes", "notes of more than twenty-four bytes"] {
        fs::write(&text, content).expect("written");
        let mut frames = Frames::resume(place).expect("the folder");
        assert_eq!(frames.next(), 0);
        let error = frames.write(&picture(0)).expect_err("refused");
        assert_eq!(error.path, text);
        assert!(error.reason.contains("left alone"), "{error}");
        assert_eq!(fs::read_to_string(&text).expect("there"), content);
    }
    fs::create_dir(place.join("frame-00001.png")).expect("made");
    let mut frames = Frames::from(place, 1).expect("the folder");
    frames.write(&picture(0)).expect_err("a folder");
    #[cfg(unix)]
    {
        let other = place.join("other.png");
        picture(5)
            .write_png(fs::File::create(&other).expect("made"))
            .expect("written");
        std::os::unix::fs::symlink(&other, place.join("frame-00002.png")).expect("linked");
        let mut frames = Frames::from(place, 2).expect("the folder");
        frames.write(&picture(0)).expect_err("a link");
    }
    assert!(Frames::from(&text, 0).is_err(), "a file is no folder");
    assert!(Frames::from(place, 100_001).is_err());
    let mut frames = Frames::from(place, 100_000).expect("the folder");
    frames.write(&picture(0)).expect_err("six digits");
}

#[test]
fn all_pictures_have_one_size() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut frames = Frames::from(folder.path(), 4).expect("the folder");
    frames.write(&picture(0)).expect("written");
    let larger = Image::filled([32, 20], [0, 0, 0, 255]);
    for mut frames in [frames, Frames::from(folder.path(), 5).expect("the folder")] {
        let error = frames.write(&larger).expect_err("another size");
        assert_eq!(
            error.reason,
            "32 x 20 pixels, the pictures before it 32 x 18"
        );
        assert_eq!(frames.next(), 5);
    }
}

#[test]
fn heaps_are_the_same_and_stand_on_the_floor() {
    let body = blob("heap", 6, 3);
    let model = baked_mesh(&body.mesh(), &body.basis()).expect("bakes");
    let asset = model.asset();
    let heap = Heap::new(asset, 40, 7).expect("a heap");
    let again = Heap::new(asset, 40, 7).expect("a heap");
    let mut memory = vec![0.0; asset.pose_len()];
    for (body, other) in heap.bodies().iter().zip(again.bodies()) {
        assert_eq!((body.q, body.placement), (other.q, other.placement));
        assert_eq!(body.colour, other.colour);
        let within =
            |(q, mode): (&f32, &bdtree_runtime::format::ModeRecord)| q.abs() <= mode.q_range.get();
        assert!(body.q.iter().zip(asset.modes()).all(within));
        let pose = asset
            .pose(body.q, body.placement, &mut memory)
            .expect("a pose");
        let lowest = pose.exact_aabb().expect("sound").min[1];
        assert!(lowest > -1e-6, "{lowest} is below the floor");
    }
    assert!(heap.height > 0.0 && heap.radius > 0.0);
}

#[test]
fn wires_lie_on_their_sphere() {
    let lines = sphere_wires([1.0, 2.0, 3.0], 0.5, [255; 4], 1.0);
    assert_eq!(lines.len(), 96);
    for end in lines.iter().flat_map(|line| line.ends) {
        let away: f32 = (0..3).map(|k| (end[k] - [1.0, 2.0, 3.0][k]).powi(2)).sum();
        assert!((away.sqrt() - 0.5).abs() < 1e-5);
    }
}
