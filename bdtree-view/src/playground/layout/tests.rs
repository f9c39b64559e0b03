//! Mouse and keyboard on controls and picture, without a window.

use egui::{Event, Modifiers, Pos2, vec2};

use super::*;
use crate::person::Person;
use crate::playground::tests::{golden_file, of, tetrahedra};

const WIDE: Vec2 = vec2(1000.0, 700.0);

fn person(count: usize, size: Vec2) -> Person<Playground> {
    let mut play = tetrahedra(count);
    play.camera = None;
    play.pace.is_running = false;
    Person::new(play, size)
}

impl Person<Playground> {
    /// Where a body is on the screen.
    fn body(&self, body: usize) -> Pos2 {
        let camera = self.app.camera.expect("a camera");
        let (center, _) = self.app.simulation.balls().nth(body).expect("a body");
        let at = center.map(|x| x as f32);
        let [x, y] = camera.project(at, self.picture).expect("in front");
        pos2(self.size.x - self.picture[0] as f32 + x, y)
    }

    fn count(&self) -> usize {
        self.app.simulation.of().len()
    }
}

#[test]
fn a_click_drops_and_buttons_drop_and_throw() {
    let mut person = person(0, WIDE);
    let at = person.middle() + vec2(60.0, 90.0);
    person.click(at);
    assert_eq!(person.count(), 1);
    // Above the place that was clicked, as the camera sees it.
    let (center, _) = person.app.simulation.balls().next().expect("a body");
    let camera = person.app.camera.expect("a camera");
    let below = camera.project([center[0] as f32, 0.0, center[2] as f32], person.picture);
    let [x, y] = below.expect("in front");
    let left = person.size.x - person.picture[0] as f32;
    assert!(
        (x + left - at.x).abs() < 1.0 && (y - at.y).abs() < 1.0,
        "{x} {y} {at}"
    );
    person.click_on("Drop");
    assert_eq!(person.count(), 2);
    person.click_on("Throw");
    assert_eq!((person.count(), &person.app.problem), (3, &None));
    person.click_on("Remove all");
    assert_eq!(person.count(), 0);
}

#[test]
fn a_body_is_dragged_and_the_background_turns_the_camera() {
    let mut person = person(1, WIDE);
    let at = person.body(0);
    let camera = person.app.camera;
    person.frame(vec![Event::PointerMoved(at)]);
    person.press(at, PointerButton::Primary, true);
    for part in [0.5, 1.0] {
        person.frame(vec![Event::PointerMoved(at + vec2(0.0, -80.0) * part)]);
    }
    let [held, pointer] = person.app.grabbed().expect("a body").ends();
    assert!(pointer[1] > held[1], "{held:?} {pointer:?}");
    assert_eq!(person.app.camera, camera);
    let depth = |person: &Person<Playground>| match person.app.hold {
        Some(Hold::Body { depth, .. }) => depth,
        _ => panic!("nothing is held"),
    };
    let before = depth(&person);
    person.wheel(at, 200.0);
    assert!(depth(&person) > 1.05 * before);
    person.press(at, PointerButton::Primary, false);
    person.wait();
    assert!(person.app.hold.is_none());
    assert_eq!(person.count(), 1, "a drag is no click");

    let corner = person.middle() + vec2(-250.0, -300.0);
    person.drag(PointerButton::Primary, corner, vec2(70.0, 0.0));
    let turned = person.app.camera.expect("a camera");
    assert_eq!(turned.target, camera.expect("a camera").target);
    assert_ne!(Some(turned), camera);
    person.drag(PointerButton::Secondary, at, vec2(70.0, 0.0));
    assert_ne!(person.app.camera.expect("a camera").target, turned.target);
    person.modifiers = Modifiers::SHIFT;
    let before = person.app.camera;
    person.drag(PointerButton::Primary, at, vec2(70.0, 0.0));
    person.modifiers = Modifiers::NONE;
    assert_ne!(
        person.app.camera, before,
        "shift moves the camera, also on a body"
    );
    person.click_on("Show all");
    assert_eq!(person.app.camera, camera);
    person.wheel(at, 200.0);
    let near = person.app.camera.expect("a camera").distance();
    assert!(near < 0.8 * camera.expect("a camera").distance());
}

#[test]
fn keys_act_where_the_pointer_is() {
    let mut person = person(1, WIDE);
    for runs in [true, false] {
        person.key(Key::Space);
        assert_eq!(person.app.pace.is_running, runs);
    }
    person.frame(vec![Event::PointerMoved(
        person.middle() + vec2(80.0, 120.0),
    )]);
    person.key(Key::D);
    assert_eq!(person.count(), 2);
    person.key(Key::T);
    assert_eq!(person.count(), 3);
    person.key(Key::R);
    assert_eq!(person.count(), 1);
    person.frame(vec![Event::PointerMoved(person.body(0))]);
    person.key(Key::P);
    person.key(Key::Period);
    person.app.advance(0.1);
    assert_eq!(person.app.simulation.world().steps(), 1, "one step");
    let state = person
        .app
        .simulation
        .world()
        .state(bdtree_dynamics::BodyId(0));
    let [x, y, z] = state.expect("a body").velocity;
    assert!(x.hypot(z).hypot(y) > 0.5, "poked");
    person.key(Key::Delete);
    assert_eq!(person.count(), 0);
    // In a field with a number, keys are for it.
    let speed = person.texts.iter().find(|(text, _)| text.ends_with(" m/s"));
    let at = speed.expect("the speed of throws").1.center();
    person.click(at);
    person.key(Key::D);
    assert_eq!(person.count(), 0);
}

#[test]
fn what_is_wrong_is_a_line_with_a_way_out() {
    let mut person = person(2, WIDE);
    for _ in 0..2 {
        let still = [[0.0; 3]; 2];
        let added = person.app.simulation.add(0, [50.0, 9.0, 0.0], still);
        added.expect("a body");
    }
    person.click_on("Run");
    person.app.advance(1.0 / 30.0);
    person.wait();
    let text = person.app.problem.as_ref().expect("a failure").text.clone();
    person.find(&text);
    person.find("Run");
    person.click_on("Remove these 2 bodies");
    assert_eq!((person.count(), &person.app.problem), (2, &None));
    person.app.save();
    person.wait();
    person.find("there is no file to save to: start with --checkpoint FILE");
    person.click_on("Close");
    assert_eq!(person.app.problem, None);
}

#[test]
fn files_are_chosen_and_those_that_cannot_fall_say_why() {
    let files = [golden_file("tetrahedron.bdt"), golden_file("sphere.bdt")];
    let mut person = Person::new(Playground::new(of(&files)), WIDE);
    person.click_on("sphere.bdt");
    assert_eq!(person.app.chosen, 1);
    person.wait();
    let why = person
        .texts
        .iter()
        .find(|(text, _)| text.starts_with("cannot fall: "));
    assert!(why.expect("why").0.ends_with("or start with --rigid"));
    person.click_on("Drop");
    assert_eq!(person.count(), 0);
    let text = person.app.problem.as_ref().expect("a reason").text.clone();
    assert!(
        text.starts_with("sphere.bdt: mode 0 has no frequency"),
        "{text}"
    );
    person.key(Key::Num1);
    person.key(Key::Num9);
    assert_eq!(person.app.chosen, 0);
    person.click_on("Drop");
    assert_eq!((person.count(), &person.app.problem), (1, &None));
}

#[test]
fn in_windows_of_any_size_nothing_is_cut_off() {
    for size in [
        [300.0, 640.0],
        [480.0, 640.0],
        [560.0, 480.0],
        [640.0, 480.0],
        [1280.0, 800.0],
    ] {
        let mut person = person(3, size.into());
        person.app.problem = Some(crate::playground::Problem {
            text: "step 1: bodies 3 and 4 overlap by more than is good for them".repeat(2),
            bodies: vec![0, 1],
            bearable: 0.5,
        });
        person.app.advance(0.1);
        person.wait();
        person.find("Throw");
        assert_eq!(person.cut, [""; 0], "{size:?}");
        let [width, height] = person.picture.map(|n| n as f32);
        assert!(
            width * height > 0.2 * size[0] * size[1],
            "{size:?}: {width} x {height}"
        );
    }
}
