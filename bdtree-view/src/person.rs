//! Mouse and keyboard on controls and picture, without a window: egui is given events as from one.

use egui::epaint::Shape;
use egui::{
    Context, Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, Pos2,
    RawInput, Rect, TextureId, TouchPhase, Vec2, pos2, vec2,
};

use crate::content::Content;
use crate::panel::{self, Status};

/// A person before the window.
pub(crate) struct Person<C> {
    pub(crate) app: C,
    context: Context,
    pub(crate) size: Vec2,
    time_s: f64,
    pub(crate) modifiers: Modifiers,
    /// What can be read, and where.
    pub(crate) texts: Vec<(String, Rect)>,
    /// What cannot, for its beginning or end is beyond the edge of what it is in.
    pub(crate) cut: Vec<String>,
    /// The picture's size.
    pub(crate) picture: [u32; 2],
}

impl<C: Content> Person<C> {
    /// With the window as it is after a while.
    pub(crate) fn new(app: C, size: Vec2) -> Self {
        let context = Context::default();
        panel::dress(&context);
        let mut person = Self {
            app,
            context,
            size,
            time_s: 0.0,
            modifiers: Modifiers::NONE,
            texts: Vec::new(),
            cut: Vec::new(),
            picture: [0; 2],
        };
        person.wait();
        person
    }

    /// A frame after some events.
    pub(crate) fn frame(&mut self, mut events: Vec<Event>) {
        events.insert(0, Event::ModifiersChanged(self.modifiers));
        self.time_s += 1.0 / 60.0;
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, self.size)),
            time: Some(self.time_s),
            events,
            ..RawInput::default()
        };
        let (app, status) = (&mut self.app, Status::default());
        let mut size = [0; 2];
        let mut output = self.context.run_ui(input, |ui| {
            size = app
                .lay_out(ui, &status, TextureId::default())
                .expect("a camera");
        });
        // egui panics where they are dropped unused.
        output.textures_delta.set.clear();
        output.textures_delta.free.clear();
        self.picture = size;
        self.app.refresh();
        self.texts.clear();
        self.cut.clear();
        for clipped in &output.shapes {
            let clip = clipped.clip_rect;
            read(&clipped.shape, clip, &mut self.texts, &mut self.cut);
        }
    }

    /// Until what moves by itself has come to rest.
    pub(crate) fn wait(&mut self) {
        (0..60).for_each(|_| self.frame(Vec::new()));
    }

    pub(crate) fn sees(&self, text: &str) -> Option<Pos2> {
        let mut found = self.texts.iter().filter(|(of, _)| of == text);
        found.next().map(|(_, area)| area.center())
    }

    #[track_caller]
    pub(crate) fn find(&self, text: &str) -> Pos2 {
        let all: Vec<&str> = self.texts.iter().map(|(text, _)| text.as_str()).collect();
        self.sees(text)
            .unwrap_or_else(|| panic!("{text} is not among {all:?}"))
    }

    pub(crate) fn press(&mut self, pos: Pos2, button: PointerButton, pressed: bool) {
        let modifiers = self.modifiers;
        self.frame(vec![Event::PointerButton {
            pos,
            button,
            pressed,
            modifiers,
        }]);
    }

    pub(crate) fn drag(&mut self, button: PointerButton, from: Pos2, by: Vec2) {
        self.frame(vec![Event::PointerMoved(from)]);
        self.press(from, button, true);
        for part in [0.5, 1.0] {
            self.frame(vec![Event::PointerMoved(from + by * part)]);
        }
        self.press(from + by, button, false);
        self.wait();
    }

    pub(crate) fn click(&mut self, at: Pos2) {
        self.drag(PointerButton::Primary, at, Vec2::ZERO);
    }

    #[track_caller]
    pub(crate) fn click_on(&mut self, text: &str) {
        self.click(self.find(text));
    }

    pub(crate) fn wheel(&mut self, at: Pos2, points: f32) {
        self.frame(vec![
            Event::PointerMoved(at),
            Event::MouseWheel {
                unit: MouseWheelUnit::Point,
                delta: vec2(0.0, points),
                phase: TouchPhase::Move,
                source: MouseWheelSource::Unknown,
                modifiers: self.modifiers,
            },
        ]);
        self.wait();
    }

    pub(crate) fn key(&mut self, key: Key) {
        for pressed in [true, false] {
            self.frame(vec![Event::Key {
                key,
                physical_key: None,
                pressed,
                repeat: false,
                modifiers: self.modifiers,
            }]);
        }
    }

    /// The middle of the picture.
    pub(crate) fn middle(&self) -> Pos2 {
        let [width, height] = self.picture.map(|n| n as f32);
        pos2(self.size.x - 0.5 * width, 0.5 * height)
    }
}

/// Texts that are not cut off, and those that are at the left or right. What is cut above or below is scrolled to.
fn read(shape: &Shape, clip: Rect, texts: &mut Vec<(String, Rect)>, cut: &mut Vec<String>) {
    match shape {
        Shape::Vec(shapes) => shapes.iter().for_each(|s| read(s, clip, texts, cut)),
        Shape::Text(text) => {
            let area = text.visual_bounding_rect();
            let content = text.galley.text().to_string();
            if clip.contains_rect(area) {
                texts.push((content, area));
            } else if area.left() < clip.left() || area.right() > clip.right() {
                cut.push(content);
            }
        }
        _ => {}
    }
}
