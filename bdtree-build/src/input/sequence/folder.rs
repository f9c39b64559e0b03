//! A folder of OBJ frames: every frame is read and checked once, its positions go to a temporary
//! file.

use std::collections::HashSet;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::sync::Mutex;

use bdtree_npy::Number;
use sha2::{Digest, Sha256};

use super::data::{FrameData, Order, is_coordinate, what_is_wrong};
use super::names::{self, Frames};
use super::{FrameSequence, Places, caches, check_vertex_count};
use crate::error::{BakeError, Part, Place, Problems};
use crate::input::{RawMesh, load, read_mesh};
use crate::progress::Progress;

/// The frames in the folder at `path`.
pub(super) fn open(
    path: &Path,
    input: Option<&RawMesh>,
    fps: Option<f64>,
    progress: &dyn Progress,
) -> Result<FrameSequence, BakeError> {
    let place = path.display().to_string();
    let frames = names::list(path).map_err(|e| load::unreadable(&place, &e))?;
    if frames.paths.is_empty() {
        let message = match frames.others.len() {
            0 => "an empty folder: no .obj frames".to_string(),
            others => match others {
                1 => "its one entry is no .obj frame".to_string(),
                _ => format!("no .obj frames among the {others} entries of this folder"),
            },
        };
        return Err(BakeError::one("input", path, message));
    }
    let mut reader = Reader::new(&frames, input)?;
    progress.stage("frames", Some(frames.paths.len() as u64));
    for frame in 0..frames.paths.len() {
        reader.frame(frame)?;
        progress.advance(1);
    }
    reader.finish(&place, fps)
}

/// What is known so far while the frames go by.
struct Reader<'a> {
    frames: &'a Frames,
    input: Option<&'a RawMesh>,
    hash: Sha256,
    problems: Problems,
    spill: BufWriter<File>,
    /// The first frame that could be read, and its number: the one the others are compared with.
    first: Option<(usize, RawMesh)>,
    /// Warnings of the first frame, without the file's name.
    known: HashSet<String>,
    /// Number of other warnings in later frames, and the first of them.
    more: usize,
    more_first: Option<String>,
    warnings: Vec<String>,
}

impl<'a> Reader<'a> {
    fn new(frames: &'a Frames, input: Option<&'a RawMesh>) -> Result<Self, BakeError> {
        let file = tempfile::tempfile().map_err(|e| spill_error(&e))?;
        Ok(Self {
            frames,
            input,
            hash: Sha256::new(),
            problems: Problems::new("input"),
            spill: BufWriter::new(file),
            first: None,
            known: HashSet::new(),
            more: 0,
            more_first: None,
            warnings: frames.warnings.clone(),
        })
    }

    fn place(&self, frame: usize) -> String {
        self.frames.paths[frame].display().to_string()
    }

    /// Reads frame `frame`: a place in the list.
    fn frame(&mut self, frame: usize) -> Result<(), BakeError> {
        let mesh = match read_mesh(&self.frames.paths[frame]) {
            Ok(mesh) => mesh,
            Err(error) => {
                self.problems.join(error);
                return Ok(());
            }
        };
        self.hash.update(self.frames.names[frame].as_bytes());
        self.hash.update([0]);
        self.hash.update(mesh.hash);
        let place = self.place(frame);
        for (vertex, p) in mesh.positions.iter().enumerate() {
            if let Some(axis) = p.iter().position(|&x| !is_coordinate(x)) {
                let file = || Place::from(Part::FrameFile(place.clone()));
                let at = || file().at(Part::Vertex(vertex)).at(Part::Axis(axis));
                self.problems.add(|| (at(), what_is_wrong(p[axis])));
            }
        }
        let warnings = mesh.warnings.iter();
        let bare = warnings.map(|text| text.strip_prefix(&place).unwrap_or(text).to_string());
        let Some((first_frame, first)) = &self.first else {
            self.known.extend(bare);
            self.write(&mesh.positions)?;
            self.take_first(frame, mesh);
            return Ok(());
        };
        if let Some(message) = difference(&mesh, first) {
            let first_place = self.place(*first_frame);
            let hint = match self.problems.is_empty() {
                true => ": a folder holds the frames of one animation; meshes are baked one by one",
                false => "",
            };
            let message = format!("{message} {first_place}{hint}");
            self.problems.add(|| (Place::file(place), message));
            return Ok(());
        }
        for text in bare.filter(|text| !self.known.contains(text)) {
            self.more += 1;
            self.more_first.get_or_insert(format!("{place}{text}"));
        }
        self.write(&mesh.positions)
    }

    /// Compares the first frame with INPUT.
    fn take_first(&mut self, frame: usize, mut mesh: RawMesh) {
        let place = self.place(frame);
        if let Some(input) = self.input {
            let count = mesh.positions.len();
            if let Err(error) = check_vertex_count(&place, self.input, count) {
                self.problems.join(error);
            } else if let Some(difference) = difference(&mesh, input) {
                let name = &input.name;
                self.warnings.push(format!(
                    "{place}: {difference} {name}; the faces of {name} are used"
                ));
            }
            self.warnings.append(&mut mesh.warnings);
        }
        self.first = Some((frame, mesh));
    }

    fn write(&mut self, positions: &[[f64; 3]]) -> Result<(), BakeError> {
        positions
            .as_flattened()
            .iter()
            .try_for_each(|x| self.spill.write_all(&x.to_le_bytes()))
            .map_err(|e| spill_error(&e))
    }

    fn finish(mut self, place: &str, fps: Option<f64>) -> Result<FrameSequence, BakeError> {
        self.problems.into_result(Place::file(place))?;
        let Some((_, first)) = self.first else {
            // Not reached: a frame that cannot be read is a problem.
            return Err(BakeError::one("input", Place::file(place), "no frames"));
        };
        if let Some(text) = self.more_first {
            self.warnings.push(match self.more {
                1 => text,
                more => format!(
                    "{text}; {} more warnings in this and later frames",
                    more - 1
                ),
            });
        }
        let file = self
            .spill
            .into_inner()
            .map_err(|e| spill_error(e.error()))?;
        let frame_count = self.frames.paths.len();
        let paths = self.frames.paths.iter();
        Ok(FrameSequence {
            name: String::new(), // with the path
            hash: self.hash.finalize().into(),
            times_s: fps.map(|fps| caches::even_times(frame_count, fps)),
            warnings: self.warnings,
            places: Places::Folder(paths.map(|path| path.display().to_string()).collect()),
            data: FrameData {
                file: Mutex::new(file),
                offset: 0,
                number: Number::F8Le,
                order: Order::FrameMajor,
                frame_count,
                vertex_count: first.positions.len(),
            },
            first_mesh: self.input.is_none().then_some(first),
        })
    }
}

fn spill_error(error: &std::io::Error) -> BakeError {
    let place = std::env::temp_dir().display().to_string();
    let message = format!("cannot hold the frames in a temporary file: {error}");
    BakeError::one("input", Place::file(place), message)
}

/// How the vertices or faces of `mesh` differ from those of `other`, as the start of a sentence
/// that ends with the other's name; `None` if they do not.
fn difference(mesh: &RawMesh, other: &RawMesh) -> Option<String> {
    let (vertices, others) = (mesh.positions.len(), other.positions.len());
    if vertices != others {
        return Some(format!("{vertices} vertices, but {others} in"));
    }
    let (triangles, others) = (mesh.triangles.len(), other.triangles.len());
    let mut pairs = mesh.triangles.iter().zip(&other.triangles);
    if let Some(id) = pairs.position(|(a, b)| a != b) {
        let [a, b] = [mesh.triangles[id], other.triangles[id]].map(|t| t.map(|c| c + 1));
        return Some(format!(
            "triangle {id} has the corners {} {} {}, but {} {} {} (vertices from 1) in",
            a[0], a[1], a[2], b[0], b[1], b[2]
        ));
    }
    (triangles != others).then(|| format!("{triangles} triangles, but {others} in"))
}
