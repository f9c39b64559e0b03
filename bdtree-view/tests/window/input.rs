//! What the pointer does.

use bdtree_tools::{AssetFile, Posture};
use bdtree_view::ProbeText;
use bdtree_view::app::{App, Grab, Probe};

use crate::display::{Display, Picture, Running};
use crate::find::{Rect, buttons, fields, middle};
use crate::hands::{Hands, LEFT};
use crate::{CONTROLS, EDGE, PICTURE, SIZE, file, screenshot};

/// The controls without the last line: what follows the time of a frame there moves with its number of digits.
const UNTIMED: [u32; 4] = [CONTROLS[0], CONTROLS[1], CONTROLS[2], CONTROLS[3] - 50];

/// A viewer that is running, and hands for it.
pub(crate) struct Session {
    pub(crate) viewer: Running,
    pub(crate) hands: Hands,
    display: Display,
    /// The screen at the beginning.
    pub(crate) first: Picture,
}

impl Session {
    /// Starts the viewer; returns when it shows what it shows at last if nobody does anything.
    pub(crate) fn start(name: &str, options: &[&str]) -> Self {
        let display = Display::start();
        let settled = screenshot(&display, &file(name), options);
        let mut viewer = display.viewer();
        viewer.arg(file(name)).args(["--size", "1000x700"]);
        let mut viewer = Running(viewer.args(options).spawn().expect("the viewer starts"));
        let first = display.wait_for(&mut viewer, |screen| {
            screen.difference(&settled, PICTURE) == 0.0
                && screen.difference(&settled, UNTIMED) < 0.005
        });
        Self {
            viewer,
            hands: Hands::on(&display),
            display,
            first,
        }
    }

    #[track_caller]
    pub(crate) fn wait_for(&mut self, is_ready: impl FnMut(&Picture) -> bool) -> Picture {
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

    /// Presses and releases the left button there.
    pub(crate) fn click(&mut self, at: [u32; 2]) {
        self.go_to(at);
        self.hands.press(LEFT);
        self.hands.release(LEFT);
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
}

/// The viewer's state at the beginning, which the tests change as the pointer should.
fn with_app(name: &str, ball: Option<ProbeText>, test: impl FnOnce(App<'_>)) {
    let file = AssetFile::read(&file(name)).expect("a golden file");
    let asset = file.checked_asset(true).expect("sound");
    let posture = Posture::of_q(vec![0.0; asset.mode_count()]);
    let mut app = App::new(&file, posture).expect("a state");
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

/// Where the probe's center is on the screen.
fn probe_of(app: &App<'_>) -> [f32; 2] {
    let camera = app.view.camera.expect("a camera");
    let center = app.place.shown(app.view.probe.center);
    let [x, y] = camera.project(center, OF_PICTURE).expect("in front");
    [x + EDGE as f32, y]
}

#[test]
fn the_probe_is_dragged_and_says_what_it_touches() {
    let text = "0.7,0.8,0.6,0.2";
    let mut session = Session::start("sphere.bdt", &["--probe", text]);
    let first = session.first.clone();
    // Its four numbers, and below them contacts, the deepest and nodes visited.
    let all = fields(&first);
    let [.., x, _, _, radius] = all[..] else {
        panic!("{all:?}")
    };
    let numbers = [x[0], x[1], radius[2], radius[3]];
    let contacts = [CONTROLS[0], radius[3], CONTROLS[2] - 4, radius[3] + 66];
    with_app("sphere.bdt", text.parse().ok(), |mut app| {
        let place = app.place;
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
