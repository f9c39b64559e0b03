//! What is drawn beside the mesh: spheres and lines, in drawn units.

use bdtree_render::{Line, NodeSphere, Sphere, ball_outline};

use crate::app::{Answer, App};

/// The probe.
pub(crate) const PROBE: [u8; 4] = [255, 150, 30, 120];
/// Its outline.
const RIM: [u8; 4] = [150, 80, 0, 255];
/// Where it touches, and which way it is pushed.
pub(crate) const CONTACT: [u8; 4] = [214, 20, 60, 255];
/// The spheres in which its query ended: a color that no scale of growth has.
pub(crate) const ENDS: [u8; 4] = [205, 30, 190, 46];
/// Radius of contacts and length of their normals, over the probe's radius.
const DOT: f32 = 0.035;
const NORMAL: f32 = 0.25;

/// Bones.
const BONE: [u8; 4] = [20, 120, 70, 255];

/// Spheres and lines.
#[derive(Debug, Default)]
pub(crate) struct Shapes {
    /// Spheres of the level, the probe, its contacts, the spheres in which its query ended.
    pub spheres: Vec<Sphere>,
    /// Bones, the probe's outline, normals of contacts.
    pub lines: Vec<Line>,
}

impl Shapes {
    /// Of what `app` shows.
    pub(crate) fn of(app: &App<'_>) -> Self {
        let mut shapes = Self::default();
        let view = &app.view;
        let sphere = |s: &NodeSphere, colour: [u8; 4]| Sphere {
            center: app.place.shown(s.center),
            radius: app.place.shown_length(s.radius),
            colour,
        };
        if let Ok(level) = &app.spheres {
            let opacity = (255.0 * view.opacity).round() as u8;
            let of_level = level.spheres.iter().zip(&level.growths);
            let of_level = of_level.map(|(s, growth)| {
                let [r, g, b] = view.scale.colour(*growth);
                sphere(s, [r, g, b, opacity])
            });
            shapes.spheres.extend(of_level);
        }
        shapes.lines.extend(app.bones.iter().map(|ends| Line {
            ends: ends.map(|x| app.place.shown(x)),
            colour: BONE,
            width: 2.5,
        }));
        if !view.has_probe {
            return shapes;
        }
        let center = app.place.shown(view.probe.center);
        let radius = app.place.shown_length(view.probe.radius);
        shapes.spheres.push(Sphere {
            center,
            radius,
            colour: PROBE,
        });
        if let Some(camera) = view.camera {
            let rim = ball_outline(center, radius, camera.eye);
            shapes.lines.extend(rim.into_iter().map(|ends| Line {
                ends,
                colour: RIM,
                width: 1.5,
            }));
        }
        if let Some(Ok(answer)) = &app.answer {
            if view.has_ends {
                let ends = answer.ends.iter();
                shapes.spheres.extend(ends.map(|s| sphere(s, ENDS)));
            }
            shapes.contacts(app, answer, radius);
        }
        shapes
    }

    fn contacts(&mut self, app: &App<'_>, answer: &Answer, radius: f32) {
        for contact in &answer.contacts {
            let point = app.place.shown(contact.point);
            let tip = [0, 1, 2].map(|k| point[k] + NORMAL * radius * contact.normal[k] as f32);
            self.spheres.push(Sphere {
                center: point,
                radius: DOT * radius,
                colour: CONTACT,
            });
            self.lines.push(Line {
                ends: [point, tip],
                colour: CONTACT,
                width: 1.0,
            });
        }
    }
}
