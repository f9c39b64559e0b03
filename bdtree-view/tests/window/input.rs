//! What pointer and keyboard do.

use bdtree_runtime::Transform;
use bdtree_tools::AssetFile;
use bdtree_view::ProbeText;
use bdtree_view::app::{App, Grab, Probe};
use std::time::{Duration, Instant};

use crate::display::{Display, Picture, Running};
use crate::find::{Rect, buttons, middle, probe, slider_fills};
use crate::hands::{Hands, LEFT, RIGHT, SHIFT, SPACE};
use crate::{CONTROLS, EDGE, PICTURE, SIZE, file, screenshot};

/// A viewer that is running, and hands for it.
struct Session {
    viewer: Running,
    hands: Hands,
    display: Display,
    /// The screen at the beginning.
    first: Picture,
}

impl Session {
    /// Starts the viewer; returns when it shows what it shows at last if nobody does anything.
    fn start(name: &str, options: &[&str]) -> Self {
        let display = Display::start();
        let settled = screenshot(&display, &file(name), options);
        let mut viewer = display.viewer();
        viewer.arg(file(name)).args(["--size", "1000x700"]);
        let mut viewer = Running(viewer.args(options).spawn().expect("the viewer starts"));
        let first = display.wait_for(&mut viewer, |screen| {
            screen.difference(&settled, PICTURE) == 0.0
                && screen.difference(&settled, CONTROLS) < 0.005
        });
        Self {
            viewer,
            hands: Hands::on(&display),
            display,
            first,
        }
    }

    #[track_caller]
    fn wait_for(&mut self, is_ready: impl FnMut(&Picture) -> bool) -> Picture {
        self.display.wait_for(&mut self.viewer, is_ready)
    }

    /// "Zero all", which stands above all that changes.
    fn zero_all(&self) -> Rect {
        buttons(&self.first)[0]
    }

    /// Moves the pointer, and returns once the viewer has followed it: a button over which it has been on its
    /// way looks as before. Drags that begin there are then measured from there.
    fn go_to(&mut self, at: [u32; 2]) {
        let (first, button) = (self.first.clone(), self.zero_all());
        let is_plain = move |screen: &Picture| screen.difference(&first, button) == 0.0;
        self.hands.point(middle(button));
        self.wait_for(|screen| !is_plain(screen));
        self.hands.point(at);
        self.wait_for(is_plain);
    }

    /// Drags from one place to another with a button, and lets go once that has had its effect.
    #[track_caller]
    fn drag(
        &mut self,
        button: u8,
        [from, to]: [[u32; 2]; 2],
        is_done: impl FnMut(&Picture) -> bool,
    ) -> Picture {
        self.go_to(from);
        self.hands.press(button);
        self.hands.point(to);
        let done = self.wait_for(is_done);
        self.hands.release(button);
        done
    }

    /// Drags a slider's knob in the same way. egui goes by where the pointer is at the end of a frame, so the
    /// viewer first shows that it has seen the press, and in the end that it has seen the release.
    #[track_caller]
    fn slide(
        &mut self,
        [knob, to]: [[u32; 2]; 2],
        is_done: impl FnMut(&Picture) -> bool,
    ) -> Picture {
        self.go_to(knob);
        self.hands.press(LEFT);
        // Grey while it is held, else bluish; and the slider ends before the pointer does.
        let row = [EDGE / 3, knob[1] - 8, 2 * EDGE / 3, knob[1] + 8];
        let is_held = |screen: &Picture| screen.share(row, |c| c == [165; 3]) > 0.01;
        self.wait_for(is_held);
        self.hands.point(to);
        let done = self.wait_for(is_done);
        self.hands.release(LEFT);
        self.wait_for(|screen| !is_held(screen));
        done
    }

    /// Clicks until that has had its effect: where the viewer sees more than 0.8 s between press and release,
    /// because the machine does other things, it takes them for no click.
    #[track_caller]
    fn click(&mut self, at: [u32; 2], mut is_done: impl FnMut(&Picture) -> bool) -> Picture {
        let mut last: Option<Instant> = None;
        let Self {
            viewer,
            hands,
            display,
            ..
        } = self;
        display.wait_for(viewer, |screen| {
            if is_done(screen) {
                return true;
            }
            if last.is_none_or(|last| last.elapsed() > Duration::from_secs(5)) {
                hands.point(at);
                hands.press(LEFT);
                hands.release(LEFT);
                last = Some(Instant::now());
            }
            false
        })
    }

    /// Presses a key and lets go of it.
    fn tap(&self, key: u32) {
        self.hands.press_key(key);
        self.hands.release_key(key);
    }
}

/// The viewer's state at the beginning, which the tests change as the pointer should.
fn with_app(name: &str, ball: Option<ProbeText>, test: impl FnOnce(App<'_>)) {
    let file = AssetFile::read(&file(name)).expect("a golden file");
    let asset = file.checked_asset(true).expect("sound");
    let posture = (vec![0.0; asset.mode_count()], Transform::IDENTITY);
    let mut app = App::new(&file, asset, posture).expect("a state");
    if let Some(ProbeText { center, radius }) = ball {
        app.view.has_probe = true;
        app.view.probe = Probe { center, radius };
    }
    let [width, height] = OF_PICTURE;
    app.fit(width as f32 / height as f32).expect("a camera");
    test(app);
}

/// Width and height of the picture.
const OF_PICTURE: [u32; 2] = [SIZE[0] - EDGE, SIZE[1]];

/// Where the probe's centre is on the screen.
fn probe_of(app: &App<'_>) -> [f32; 2] {
    let camera = app.view.camera.expect("a camera");
    let center = app.place().shown(app.view.probe.center);
    let [x, y] = camera.project(center, OF_PICTURE).expect("in front");
    [x + EDGE as f32, y]
}

#[test]
fn a_slider_moves_the_mesh_and_zero_all_brings_it_back() {
    let mut session = Session::start("sphere.bdt", &[]);
    let first = session.first.clone();
    let fill = slider_fills(&first)[0];
    let [left, top, right, bottom] = fill;
    // The knob stands where its fill ends, at the slider's middle; the number is the next field.
    let knob = [right + 6, u32::midpoint(top, bottom)];
    let of_row = |b: &&Rect| (b[1]..b[3]).contains(&knob[1]) && b[0] > knob[0];
    let number = *buttons(&first).iter().find(of_row).expect("a number");
    let is_first = |screen: &Picture| {
        screen.difference(&first, PICTURE) == 0.0 && screen.difference(&first, number) == 0.0
    };
    let fill_of = |screen: &Picture| {
        let mut all = slider_fills(screen).into_iter();
        all.find(|f| f[0] == left && (f[1]..f[3]).contains(&knob[1]))
    };

    // The knob follows the pointer, the mesh the knob.
    session.slide([knob, [knob[0] + 20, knob[1]]], |screen| {
        let moved = fill_of(screen).map(|f| f[2].abs_diff(right + 20));
        moved.is_some_and(|off| off <= 3)
            && screen.difference(&first, PICTURE) > 0.005
            && screen.difference(&first, number) > 0.02
    });
    let zero_all = middle(session.zero_all());
    session.click(zero_all, is_first);

    // Beyond its end the slider stays at q_range: the picture is that of `--q`, as soon as the camera is too.
    let path = file("sphere.bdt");
    let asset = AssetFile::read(&path).expect("a golden file");
    let range = asset.checked_asset(true).expect("sound").modes()[0]
        .q_range
        .get();
    let end = screenshot(&session.display, &path, &["--q", &format!("{range},0,0")]);
    session.slide([knob, [EDGE - 6, knob[1]]], |screen| {
        screen.difference(&end, number) == 0.0 && screen.difference(&first, PICTURE) > 0.02
    });
    let show_all = middle(*buttons(&first).last().expect("buttons"));
    session.click(show_all, |screen| screen.difference(&end, PICTURE) < 0.002);
    session.click(zero_all, |screen| screen.difference(&first, number) == 0.0);
    session.click(show_all, is_first);
}

#[test]
fn dragging_and_the_wheel_move_the_camera() {
    // In front of the mesh and touching nothing: it shows where things are seen.
    let text = "1.25,0.6,1.18,0.1";
    let mut session = Session::start("sphere.bdt", &["--probe", text]);
    let first = session.first.clone();
    with_app("sphere.bdt", text.parse().ok(), |mut app| {
        let place = *app.place();
        let is_at = |[x, y]: [f32; 2]| {
            move |screen: &Picture| {
                probe(screen).is_some_and(|[a, b]| (a - x).abs() < 2.0 && (b - y).abs() < 2.0)
            }
        };
        assert!(
            is_at(probe_of(&app))(&first),
            "{:?} {:?}",
            probe(&first),
            probe_of(&app)
        );
        let from = [EDGE + 200, 560];
        let drag = |app: &mut App<'_>, grab, [x, y]: [i32; 2]| {
            let before = probe_of(app);
            app.view
                .drag(&place, grab, [x as f32, y as f32], OF_PICTURE);
            let after = probe_of(app);
            assert!((after[0] - before[0]).hypot(after[1] - before[1]) > 20.0);
            let to = [from[0].strict_add_signed(x), from[1].strict_add_signed(y)];
            ([from, to], is_at(after))
        };

        let (way, is_there) = drag(&mut app, Grab::Orbit, [70, -50]);
        session.drag(LEFT, way, is_there);
        let (way, is_there) = drag(&mut app, Grab::Pan, [-40, -90]);
        session.drag(RIGHT, way, is_there);
        let (way, is_there) = drag(&mut app, Grab::Pan, [-120, 60]);
        session.hands.press_key(SHIFT);
        session.drag(LEFT, way, is_there);
        session.hands.release_key(SHIFT);
        for notches in [-5, 3] {
            let before = probe_of(&app);
            app.view.zoom(notches as f32);
            let after = probe_of(&app);
            assert!((after[0] - before[0]).hypot(after[1] - before[1]) > 20.0);
            session.go_to(from);
            session.hands.wheel(notches);
            session.wait_for(is_at(after));
        }
    });
    let show_all = middle(*buttons(&first).last().expect("buttons"));
    session.click(show_all, |screen| screen.difference(&first, PICTURE) == 0.0);
}

#[test]
fn the_probe_is_dragged_and_says_what_it_touches() {
    let text = "1.3,0,-0.75,0.3";
    let mut session = Session::start("sphere.bdt", &["--probe", text]);
    let first = session.first.clone();
    // Its four numbers, and below them contacts, the deepest and nodes visited.
    let all = buttons(&first);
    let [.., x, _, _, radius, _show_all] = all[..] else {
        panic!("{all:?}")
    };
    let numbers = [x[0], x[1], radius[2], radius[3]];
    let contacts = [CONTROLS[0], radius[3], CONTROLS[2] - 4, radius[3] + 66];
    with_app("sphere.bdt", text.parse().ok(), |mut app| {
        let place = *app.place();
        let from = probe_of(&app).map(|x| x.round() as u32);
        let to = [from[0] - 70, from[1] + 20];
        app.view
            .drag(&place, Grab::Probe, [-70.0, 20.0], OF_PICTURE);
        let Probe {
            center: [x, y, z],
            radius,
        } = app.view.probe;
        let text = format!("{x},{y},{z},{radius}");
        let moved = screenshot(&session.display, &file("sphere.bdt"), &["--probe", &text]);
        for area in [numbers, contacts] {
            assert!(moved.difference(&first, area) > 0.005, "{area:?}");
        }
        session.drag(LEFT, [from, to], |screen| {
            screen.difference(&moved, PICTURE) == 0.0
                && screen.difference(&moved, numbers) == 0.0
                && screen.difference(&moved, contacts) == 0.0
        });
        // Let go of, it stays: the next drag turns the camera.
        let to = [EDGE + 60, 600];
        session.drag(LEFT, [to, [to[0] + 80, to[1]]], |screen| {
            screen.difference(&moved, PICTURE) > 0.02 && screen.difference(&moved, numbers) == 0.0
        });
    });
}

#[test]
fn space_plays_and_halts() {
    let mut session = Session::start("animated.bdt", &[]);
    let first = session.first.clone();
    // Play and speed, the level, "Show all".
    let all = buttons(&first);
    let [.., play, _speed, _level, _show_all] = all[..] else {
        panic!("{all:?}")
    };
    let mut last = first.clone();
    session.go_to([EDGE + 60, 600]);
    for _ in 0..2 {
        session.tap(SPACE);
        for _ in 0..3 {
            last = session.wait_for(|screen| {
                screen.difference(&last, PICTURE) > 0.001 && screen.difference(&first, play) > 0.01
            });
        }
        session.tap(SPACE);
        last = session.wait_for(|screen| screen.difference(&first, play) == 0.0);
        // Frames are made for the pointer; time does not go on.
        session.go_to([EDGE + 90, 650]);
        session.go_to([EDGE + 60, 600]);
        let after = session.display.screen();
        assert_eq!(after.difference(&last, PICTURE), 0.0);
    }
}
