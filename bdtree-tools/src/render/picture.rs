//! From what is shown to pixels.
//!
//! Everything is drawn about the middle of all frames' bodies, in units of their size: f32 has the
//! digits for it wherever they stand and however large they are.

use std::path::Path;

use bdtree_render::tightness::{Scale, growths, mean_and_max};
use bdtree_render::{
    Camera, Framing, Ground, Image, Legend, Line, NodeSphere, Place, RenderError, Scene,
    SkinnedMesh, Sphere, Studio, ViewDirection, ball_outline, capsule_outline,
};
use glam::Vec3;

use super::arguments::Arguments;
use super::body::Content;
use super::options::AgainstChoice;
use super::queries::{Shape, key};
use crate::error::ToolError;
use crate::output::printable;
use crate::q::counted;

/// One picture's worth.
pub(super) struct Frame<'a> {
    /// In a line of the legend.
    pub(super) about: String,
    /// Of the animation.
    pub(super) number: Option<u64>,
    pub(super) content: Vec<Content<'a>>,
    /// What queries are about.
    pub(super) queries: Vec<Shape>,
    pub(super) nodes_visited: Option<u64>,
}

impl Frame<'_> {
    /// How many spheres are drawn, and how many of them are leaves above the level that was asked for.
    pub(super) fn sphere_count(&self, arguments: &Arguments) -> String {
        let spheres = || self.content.iter().flat_map(|content| &content.spheres);
        let is_above = |sphere: &&NodeSphere| arguments.spheres.is_some_and(|l| sphere.level < l);
        let (all, above) = (spheres().count(), spheres().filter(is_above).count());
        match above {
            0 => counted(all, "sphere"),
            _ => format!(
                "{} and {} above it",
                counted(all - above, "sphere"),
                counted(above, "leaf")
            ),
        }
    }
}

/// What frames take up.
pub(super) struct Bounds {
    /// Corners of the boxes of bodies.
    bodies: Vec<[f64; 3]>,
    /// All that is to be seen.
    framing: Framing,
    /// Where shadows are drawn, the upward axis, and from them toward the light, as far as a unit up.
    upward: Option<[[f64; 3]; 2]>,
    /// Vertices that throw shadows.
    above: Vec<[f64; 3]>,
    /// The least of them along that axis.
    lowest: f64,
}

impl Bounds {
    /// Of no frame yet, for pictures as asked.
    pub(super) fn new(arguments: &Arguments) -> Self {
        let direction = ViewDirection {
            azimuth_deg: arguments.view.azimuth_deg,
            elevation_deg: arguments.view.elevation_deg,
            up: arguments.upright.up.direction().into(),
        };
        let [width, height] = inner_size(arguments);
        let up = arguments.upright.up.direction().map(f64::from);
        let [right, ..] = direction.camera(Vec3::ZERO).axes();
        let light = [0, 1, 2].map(|k| up[k] - SLANT * f64::from(right[k]));
        Self {
            bodies: Vec::new(),
            framing: Framing::new(direction, width as f32 / height as f32),
            upward: arguments.shadow.then_some([up, light]),
            above: Vec::new(),
            lowest: f64::INFINITY,
        }
    }

    /// The camera, and the ground where that sees shadows on it. From below it sees none, and they get no room.
    fn seen(mut self, place: &Place, zoom: f32) -> (Camera, Option<Ground>) {
        let camera = |framing: &Framing| framing.camera(place).at_distance(1.0 / zoom);
        let without = camera(&self.framing);
        let ground = self.ground(place);
        let Some(ground) = ground.filter(|ground| ground.is_seen_from(without.eye)) else {
            return (without, None);
        };
        self.hold_shadows();
        let with = camera(&self.framing);
        // Farther away it may be below.
        match ground.is_seen_from(with.eye) {
            true => (with, Some(ground)),
            false => (without, None),
        }
    }

    /// Where shadows are drawn, below all frames (drawn units).
    fn ground(&self, place: &Place) -> Option<Ground> {
        let [up, light] = self.upward.filter(|_| self.lowest.is_finite())?;
        let lowest = place.shown(up.map(|x| x * self.lowest));
        let [up, light] = [up, light].map(|v| v.map(|x| x as f32));
        Some(Ground {
            up,
            height: (0..3).map(|k| up[k] * lowest[k]).sum(),
            light,
            shadow: SHADOW,
        })
    }

    /// Makes them hold the shadows, too, which lie below all frames.
    fn hold_shadows(&mut self) {
        let Some([up, light]) = self.upward else {
            return;
        };
        for p in std::mem::take(&mut self.above) {
            let above = dot(up, p) - self.lowest;
            self.framing
                .hold([0, 1, 2].map(|k| p[k] - above * light[k]), 0.0);
        }
    }

    /// Makes them hold a frame.
    pub(super) fn hold(&mut self, frame: &Frame<'_>) {
        let framing = &mut self.framing;
        for content in &frame.content {
            let body = &content.body;
            self.bodies.extend(body.bounds);
            // Vertices outside are not of any triangle.
            let [low, high] = body.bounds;
            let is_seen = |p: &&[f64; 3]| (0..3).all(|k| low[k] <= p[k] && p[k] <= high[k]);
            let seen = body.positions.iter().filter(is_seen);
            for p in seen {
                framing.hold(*p, 0.0);
                if let Some([up, _]) = self.upward {
                    self.lowest = self.lowest.min(dot(up, *p));
                    self.above.push(*p);
                }
            }
            let spheres = content.spheres.iter();
            spheres.for_each(|s| framing.hold(s.center, s.radius));
        }
        for shape in &frame.queries {
            match shape {
                Shape::Ball { center, radius } => framing.hold(*center, *radius),
                Shape::Point(point) => framing.hold(*point, 0.0),
                Shape::Capsule { ends, radius } => {
                    ends.iter().for_each(|end| framing.hold(*end, *radius));
                }
                Shape::Edge(ends) => ends.iter().for_each(|end| framing.hold(*end, 0.0)),
                // They come from anywhere: the picture shows them where they are near.
                Shape::Ray(_) => {}
            }
        }
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

/// How far to the right of what throws it a shadow lies, over its height: straight below a cube none is seen.
const SLANT: f64 = 0.35;
/// Of shadows.
const SHADOW: [u8; 3] = [222, 225, 230];
/// Bodies that only stand beside.
const BESIDE: [u8; 3] = [150, 160, 176];
const WHITE: [u8; 4] = [255; 4];
/// What queries are about, and its outline.
const QUERY: [u8; 4] = [60, 60, 70, 110];
const OUTLINE: [u8; 4] = [16, 16, 24, 255];
/// How far a point's cross goes from its middle, over the width of its lines.
const CROSS_ARM: f32 = 6.0;

/// What all pictures share: device, camera, meshes.
pub(super) struct Painter<'a> {
    arguments: &'a Arguments,
    studio: Studio,
    /// One for every body of a frame.
    meshes: Vec<SkinnedMesh>,
    place: Place,
    camera: Camera,
    ground: Option<Ground>,
}

impl<'a> Painter<'a> {
    /// For frames within `bounds` that have the bodies of `frame`.
    pub(super) fn new(
        arguments: &'a Arguments,
        studio: Studio,
        bounds: Bounds,
        frame: &Frame<'_>,
    ) -> Result<Self, ToolError> {
        let place = Place::around(bounds.bodies.iter().copied());
        let mut meshes = Vec::new();
        for content in &frame.content {
            let path = content.body.file.path().display();
            let mesh = studio.skinned(content.body.asset());
            let mut mesh = mesh.map_err(|error| ToolError::input(path, error))?;
            if !content.is_file {
                mesh.mesh_mut().set_colour(BESIDE);
            }
            meshes.push(mesh);
        }
        let (camera, ground) = bounds.seen(&place, arguments.view.zoom);
        Ok(Self {
            arguments,
            studio,
            meshes,
            place,
            camera,
            ground,
        })
    }

    /// Where a point of the world is in the pictures.
    pub(super) fn pixel(&self, x: [f64; 3]) -> Option<[f32; 2]> {
        let size = inner_size(self.arguments);
        let [x, y] = self.camera.project(self.place.shown(x), size)?;
        Some([x, y + legend_room(self.arguments)[0] as f32])
    }

    /// The picture, and the growth of its spheres, body by body.
    pub(super) fn paint(&mut self, frame: &Frame<'_>) -> Result<(Image, Vec<f64>), ToolError> {
        for (content, mesh) in frame.content.iter().zip(&mut self.meshes) {
            let body = &content.body;
            let gpu = &self.studio.gpu;
            let transform = self.place.shown_transform(body.instance.placement());
            let path = body.file.path().display();
            let posed = body.instance.pose().placed(transform);
            let pose = posed.map_err(|error| ToolError::input(&path, error))?;
            mesh.pose(gpu, &pose)
                .map_err(|error| ToolError::input(&path, error))?;
        }
        let mut all_growths = Vec::new();
        let mut spheres = Vec::new();
        let scale = Scale::from(self.arguments.scale);
        let opacity = (255.0 * self.arguments.opacity).round() as u8;
        for content in &frame.content {
            let body = &content.body;
            let against = self.arguments.against.into();
            let growths = growths(body.asset(), &content.spheres, &body.positions, against)
                .map_err(|error| body.file.error(error))?;
            for (sphere, growth) in content.spheres.iter().zip(&growths) {
                let [r, g, b] = scale.colour_to(self.arguments.scale_max, *growth);
                spheres.push(self.sphere(sphere.center, sphere.radius, [r, g, b, opacity]));
            }
            all_growths.extend(growths);
        }
        let outlines: Vec<_> = frame.queries.iter().flat_map(|q| self.outline(q)).collect();
        spheres.extend(frame.queries.iter().flat_map(|q| self.filling(q)));
        let lines = self.in_two_tones(&outlines);
        let meshes: Vec<_> = self.meshes.iter().map(|own| &own.mesh).collect();
        let scene = Scene {
            ground: self.ground,
            background: WHITE,
            meshes: &meshes,
            spheres: &spheres,
            lines: &lines,
        };
        let size = inner_size(self.arguments);
        let shown = self.studio.picture(size, &self.camera, &scene);
        let shown = shown.map_err(|error| graphics(&error))?;
        if self.arguments.no_legend {
            return Ok((shown, all_growths));
        }
        let mut image = Image::filled(self.arguments.size.0, WHITE);
        let [above, _] = legend_room(self.arguments);
        image.paste([0, i64::from(above)], &shown);
        self.legend(frame, &all_growths).draw(&mut image);
        Ok((image, all_growths))
    }

    fn sphere(&self, center: [f64; 3], radius: f64, colour: [u8; 4]) -> Sphere {
        Sphere {
            center: self.place.shown(center),
            radius: self.place.shown_length(radius),
            colour,
        }
    }

    /// A query's shape, as spheres.
    fn filling(&self, query: &Shape) -> Vec<Sphere> {
        let sphere = |center, radius| self.sphere(center, radius, QUERY);
        match query {
            Shape::Ball { center, radius } => vec![sphere(*center, *radius)],
            Shape::Capsule { ends, radius } => ends.map(|end| sphere(end, *radius)).into(),
            Shape::Point(_) | Shape::Edge(_) | Shape::Ray(_) => Vec::new(),
        }
    }

    /// Where a query's shape ends, as lines (drawn units).
    fn outline(&self, query: &Shape) -> Vec<[[f32; 3]; 2]> {
        let (place, eye) = (self.place, self.camera.eye);
        let shown = |ends: &[[f64; 3]; 2]| ends.map(|end| place.shown(end));
        match query {
            Shape::Ball { center, radius } => {
                ball_outline(place.shown(*center), place.shown_length(*radius), eye)
            }
            Shape::Point(point) => self.cross(place.shown(*point)).into(),
            Shape::Capsule { ends, radius } => {
                capsule_outline(shown(ends), place.shown_length(*radius), eye)
            }
            Shape::Edge(ends) | Shape::Ray(ends) => vec![shown(ends)],
        }
    }

    /// Two lines through a point (drawn units), as long in the picture wherever it is.
    fn cross(&self, point: [f32; 3]) -> [[[f32; 3]; 2]; 2] {
        let [right, up, forward] = self.camera.axes();
        let point = Vec3::from(point);
        let [_, height] = inner_size(self.arguments);
        let depth = (point - self.camera.eye).dot(forward);
        let pixel = 2.0 * (0.5 * self.camera.fov_y_rad).tan() * depth / height as f32;
        let arm = CROSS_ARM * self.line_width() * pixel;
        [right, up].map(|way| [-arm, arm].map(|far| (point + way * far).to_array()))
    }

    /// Of outlines, in pixels.
    fn line_width(&self) -> f32 {
        let [width, height] = self.arguments.size.0;
        (width.min(height) as f32 / 400.0).max(1.5)
    }

    /// Dark lines over wider white ones: one of them is seen before anything.
    fn in_two_tones(&self, lines: &[[[f32; 3]; 2]]) -> Vec<Line> {
        let pixels = self.line_width();
        let tone = |colour, width| {
            move |ends: &[[f32; 3]; 2]| Line {
                ends: *ends,
                colour,
                width,
            }
        };
        let below = lines.iter().map(tone(WHITE, 2.2 * pixels));
        below
            .chain(lines.iter().map(tone(OUTLINE, pixels)))
            .collect()
    }

    fn legend(&self, frame: &Frame<'_>, growths: &[f64]) -> Legend {
        let arguments = self.arguments;
        let mut lines = vec![title(&arguments.file), printable(&frame.about)];
        let count = frame.sphere_count(arguments);
        lines.extend(spheres_text(arguments, &count, growths));
        lines.extend(key(&frame.queries));
        Legend {
            lines,
            scale: (!growths.is_empty()).then(|| scale(arguments)),
        }
    }
}

/// What a picture says of the spheres that were asked for, of which there are so many with such growths.
fn spheres_text(arguments: &Arguments, count: &str, growths: &[f64]) -> Option<String> {
    let level = arguments.spheres.map(|level| format!("level {level}: "));
    match (mean_and_max(growths), level) {
        (Some(numbers), level) => {
            let which = level.unwrap_or_default();
            Some(spheres_line(arguments, &which, count, numbers))
        }
        (None, Some(level)) if arguments.query.is_some() => Some(level + "no visited spheres"),
        (None, level) => level.map(|level| level + count),
    }
}

/// Rows above and below what is shown, for the legend: the title, a line on what is shown, one on spheres with
/// numbers as they usually are, and one on queries. What needs more rows lies over what is shown. None where what is shown goes beyond the
/// picture: it would end at them instead of at the picture's edges.
fn legend_room(arguments: &Arguments) -> [u32; 2] {
    if arguments.no_legend || arguments.view.zoom > 1.0 {
        return [0; 2];
    }
    let has_spheres = arguments.spheres.is_some() || arguments.query.is_some();
    let mut lines = vec![title(&arguments.file), String::new()];
    if has_spheres {
        let which = arguments.spheres.map_or("", |_| "level 0: ");
        lines.push(spheres_line(arguments, which, "1000 spheres", [1.0; 2]));
    }
    // What queries are about.
    lines.extend(arguments.query.as_ref().map(|_| String::new()));
    let legend = Legend {
        lines,
        scale: has_spheres.then(|| scale(arguments)),
    };
    legend.room(arguments.size.0)
}

/// What a picture says of its spheres.
fn spheres_line(arguments: &Arguments, which: &str, count: &str, [mean, max]: [f64; 2]) -> String {
    let ratio = match arguments.against {
        AgainstChoice::Rest => "growth",
        AgainstChoice::Deformed => "looseness",
    };
    format!("{which}{count}, {ratio} mean {mean:.3}, largest {max:.3}")
}

/// The scale of colors, and what it means.
fn scale(arguments: &Arguments) -> (Scale, f64, String) {
    let meaning = match arguments.against {
        AgainstChoice::Rest => "growth: radius over that at rest",
        AgainstChoice::Deformed => {
            "looseness: radius over the smallest that holds the deformed vertices"
        }
    };
    let colours = arguments.scale.into();
    (colours, arguments.scale_max, meaning.to_string())
}

/// What the legend leaves of a picture.
fn inner_size(arguments: &Arguments) -> [u32; 2] {
    let [above, below] = legend_room(arguments);
    let [width, height] = arguments.size.0;
    [width, height - above - below]
}

/// The file's name.
fn title(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    printable(&name.to_string_lossy())
}

/// What the graphics device says, which names no file.
pub(super) fn graphics(error: &RenderError) -> ToolError {
    ToolError::Input(vec![error.to_string()])
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::super::arguments::Arguments;
    use super::{legend_room, spheres_text};

    #[derive(Parser)]
    struct Command {
        #[command(flatten)]
        arguments: Arguments,
    }

    fn asked(options: &[&str]) -> Arguments {
        let fixed = ["render", "a.bdt", "-o", "a.png"];
        let line = fixed.iter().chain(options);
        let Command { arguments } = Command::try_parse_from(line).expect("options");
        arguments
    }

    /// docs/reference/pictures.md says from which height on the legend has room of its own.
    #[test]
    fn text_lies_over_what_is_shown_in_low_pictures_only() {
        let lowest = |options: &[&str]| {
            let mut arguments = asked(options);
            let mut has_room = |size: [u32; 2]| {
                arguments.size.0 = size;
                legend_room(&arguments) != [0; 2]
            };
            let mut is_over = |height: u32| {
                let mut widths = (200..2000).step_by(20);
                widths.any(|width| !has_room([width, height]))
            };
            let over = (200..800).rev().find(|height| is_over(*height));
            over.map_or(200, |height| height + 1)
        };
        assert_eq!(lowest(&[]), 200);
        let most = [
            "--query",
            "s.json",
            "--spheres",
            "0",
            "--against",
            "deformed",
        ];
        let lowest = lowest(&most);
        assert!((440..=460).contains(&lowest), "{lowest}");
    }

    #[test]
    fn a_picture_says_which_spheres_it_has_not() {
        let text = |options: &[&str], count: &str, growths: &[f64]| {
            spheres_text(&asked(options), count, growths)
        };
        assert_eq!(text(&[], "0 spheres", &[]), None);
        assert_eq!(text(&["--query", "s.json"], "0 spheres", &[]), None);
        let level = ["--query", "s.json", "--spheres", "4"];
        let none = "level 4: no visited spheres";
        assert_eq!(text(&level, "0 spheres", &[]).as_deref(), Some(none));
        let some = "level 4: 2 spheres, growth mean 1.500, largest 2.000";
        assert_eq!(
            text(&level, "2 spheres", &[1.0, 2.0]).as_deref(),
            Some(some)
        );
    }
}
