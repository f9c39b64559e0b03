//! SCENE.json: which assets stand where, and what is asked of them.
//!
//! A scene is checked as a whole before anything is answered, and every problem is told with its
//! place, a path like `queries[2].ball.radius`.

mod assets;
mod fields;
mod instances;
mod json;
mod queries;

pub use instances::Placed;
pub use queries::{Query, RaysMode};

use std::fmt;
use std::fs;
use std::io::{self, Read};
use std::path::Path;

use bdtree_runtime::{CacheSize, Instance, PoseError};

use crate::asset_file::AssetFile;
use crate::error::ToolError;
use crate::posture::bones;
use assets::Assets;
use fields::{At, Problems};
use instances::read_instances;
use json::Json;
use queries::read_queries;

/// A checked scene with its assets.
#[derive(Debug)]
pub struct Scene {
    /// What messages call the scene.
    pub source: String,
    /// The assets, each file once.
    pub files: Vec<AssetFile>,
    /// The instances, in the order of the scene.
    pub instances: Vec<Placed>,
    /// The queries, in the order of the scene.
    pub queries: Vec<Query>,
    /// What holds for all queries.
    pub options: Options,
}

/// How queries are answered.
#[derive(Debug, Clone, Copy, Default)]
pub struct Options {
    /// The level below which queries do not look.
    pub max_depth: Option<usize>,
    /// How many nodes a query may visit, where it has such a form.
    pub max_visits: Option<u64>,
}

impl Options {
    fn read(at: &At<'_>) -> Option<Self> {
        /// Above, f64 does not hold all whole numbers.
        const COUNT_MAX: f64 = (1_u64 << 53) as f64;
        let fields = at.fields("max_depth, max_visits")?;
        let max_depth = fields.nullable("max_depth").and_then(|at| {
            let level = at.whole(f64::INFINITY, "not a whole number of at least 0")?;
            Some(level as usize) // saturates: deeper than any tree is no limit
        });
        let max_visits = fields.nullable("max_visits").and_then(|at| {
            let count = at.whole(COUNT_MAX, "not a whole number from 0 to 2^53")?;
            Some(count as u64)
        });
        let both = max_depth.is_some() && max_visits.is_some();
        at.ensure(!both, "max_depth and max_visits exclude each other");
        Some(Self {
            max_depth,
            max_visits,
        })
    }
}

impl Scene {
    /// Reads a scene file, or standard input for `-`, and opens its assets, which must not
    /// change while the scene lives. `verify` checks their checksums.
    ///
    /// # Errors
    /// Every problem, with its place.
    pub fn load(path: &Path, verify: bool) -> Result<Self, ToolError> {
        if path == Path::new("-") {
            let mut text = Vec::new();
            std::io::stdin()
                .lock()
                .read_to_end(&mut text)
                .map_err(|error| cannot_read("stdin", &error))?;
            return Self::parse(&text, "stdin", Path::new(""), verify);
        }
        let text = fs::read(path).map_err(|error| cannot_read(path.display(), &error))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::parse(&text, &path.display().to_string(), folder, verify)
    }

    /// Reads a scene's text; asset paths are relative to `folder`.
    ///
    /// # Errors
    /// Every problem, with its place after `source`.
    pub fn parse(
        text: &[u8],
        source: &str,
        folder: &Path,
        verify: bool,
    ) -> Result<Self, ToolError> {
        let json = Json::parse(text).map_err(|error| not_json(source, text, &error))?;
        let problems = Problems::new(source);
        let mut assets = Assets::new(folder, verify);
        let read = read_scene(&json, &mut assets, &problems);
        let (instances, queries, options) = read.unwrap_or_default();
        if problems.count() > 0 {
            return Err(ToolError::Input(problems.into_lines()));
        }
        Ok(Self {
            source: source.to_string(),
            files: assets.into_files(),
            instances,
            queries,
            options,
        })
    }

    /// The instances as bodies that can be asked, in the order of the scene; `size` says how much each keeps of
    /// what queries compute.
    ///
    /// # Errors
    /// None that [`Scene::parse`] has not already told.
    pub fn bodies(&self, size: impl Fn(usize) -> CacheSize) -> Result<Vec<Instance>, ToolError> {
        let bodies = self.instances.iter().enumerate().map(|(index, placed)| {
            let body = Instance::with_cache(self.files[placed.file].model(), size(index));
            let posed = body.and_then(|mut body| {
                let bones = bones(placed.joints.as_deref());
                body.set_pose_with_bones(&placed.q, bones, placed.transform)?;
                Ok(body)
            });
            posed.map_err(|error| {
                let field = match error {
                    PoseError::Rotation => ".rotation",
                    PoseError::Translation => ".translation",
                    PoseError::Scale => ".scale",
                    PoseError::MatrixRange { .. } => ".joints",
                    _ if placed.frame.is_some() => ".frame",
                    _ => ".q",
                };
                let place = format!("{}: instances[{index}]{field}", self.source);
                ToolError::input(place, error)
            })
        });
        bodies.collect()
    }
}

/// The words of every file that cannot be read.
fn cannot_read(source: impl fmt::Display, error: &io::Error) -> ToolError {
    ToolError::Input(vec![format!("{source}: cannot be read: {error}")])
}

/// What is wrong with a text that is no JSON, or whose values no scene has.
fn not_json(source: &str, text: &[u8], error: &serde_json::Error) -> ToolError {
    // What is no text at all is another kind of file; its line and column say nothing.
    if std::str::from_utf8(text).is_err() {
        return ToolError::input(source, "not a JSON scene");
    }
    if text.starts_with(b"\xef\xbb\xbf") {
        return ToolError::input(source, "begins with a byte order mark: save it without one");
    }
    let said = error.to_string();
    let starts = |words: &[&str]| words.iter().any(|word| said.starts_with(word));
    let message = if error.is_data() || starts(&["number out of range", "recursion limit"]) {
        said
    } else if starts(&["expected value", "invalid number"]) {
        format!("not JSON (JSON has no NaN or Infinity): {said}")
    } else {
        format!("not JSON: {said}")
    };
    ToolError::input(source, message)
}

fn read_scene(
    json: &Json,
    assets: &mut Assets,
    problems: &Problems,
) -> Option<(Vec<Placed>, Vec<Query>, Options)> {
    let place = String::new();
    let root = At {
        json,
        place,
        problems,
    };
    let root = root.fields("instances, options, queries")?;
    let instances = root.get("instances", |at| Some(read_instances(at, assets)));
    let (instances, names) = instances.unwrap_or_default();
    let options = root.optional("options").and_then(|at| Options::read(&at));
    let queries = root.get("queries", |at| Some(read_queries(at, &names)));
    Some((
        instances,
        queries.unwrap_or_default(),
        options.unwrap_or_default(),
    ))
}

#[cfg(test)]
mod tests;
