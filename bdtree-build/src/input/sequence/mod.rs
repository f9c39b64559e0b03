//! Sequences of frames: the same vertices at every moment of a motion.
//!
//! [`FrameSequence::open`] reads a folder of OBJ frames, a PC2, MDD or NPY file. It checks sizes
//! and every number once; after that a range of vertices is read for all frames at a time, so
//! that memory follows the range and not the length of the sequence.

mod caches;
mod data;
mod folder;
mod names;

use std::fs;
use std::ops::Range;
use std::path::Path;

use super::{RawMesh, load};
use crate::error::{BakeError, Part, Place};
use crate::progress::Progress;
use data::FrameData;

/// What every refusal of a format ends with.
const SUPPORTED: &str = "an animation is a folder of OBJ frames, a .pc2, .mdd or .npy file";

/// T frames of the same N vertices, in the source's own coordinates and order.
#[derive(Debug)]
pub struct FrameSequence {
    /// File or folder name without the folder it lies in.
    pub name: String,
    /// SHA-256 of the file; of a folder: of the names, each followed by a zero byte and the
    /// SHA-256 of the frame's file.
    pub hash: [u8; 32],
    /// Seconds of each frame, ascending; `None` where neither the source nor `fps` tells.
    pub times_s: Option<Vec<f64>>,
    /// The first frame as a mesh, named and hashed like the sequence; `None` for files and where
    /// there was an INPUT.
    pub first_mesh: Option<RawMesh>,
    /// What was odd but kept, each with its place.
    pub warnings: Vec<String>,
    places: Places,
    data: FrameData,
}

/// Where frames come from.
#[derive(Debug)]
enum Places {
    /// All from one file.
    File(String),
    /// Each from a file of its own.
    Folder(Vec<String>),
}

impl FrameSequence {
    /// The sequence at `path`: a folder of `.obj` and `.obj.gz` frames in byte order of their
    /// names, a `.pc2`, `.mdd` or `.npy` file of shape (T, N, 3).
    ///
    /// `input` is the mesh that the frames deform; without one, a folder's first frame is
    /// ([`FrameSequence::first_mesh`]). `fps`: frames per second, for times; MDD files have times of their
    /// own, which `fps` replaces. The frames of a folder go to a temporary file without a name,
    /// 24 bytes per vertex.
    ///
    /// # Errors
    /// A path that cannot be read or is no sequence; a file that is shorter or longer than its
    /// header says; no frames or no vertices; another number of vertices than `input`; frames of a
    /// folder whose vertices or faces differ in number or order, and everything that is wrong with
    /// a frame ([`super::read_mesh`]); coordinates that are not finite or beyond 2^100; a file
    /// without `input`; `fps` that is not positive. Each with file or frame, the first 100.
    pub fn open(
        path: &Path,
        input: Option<&RawMesh>,
        fps: Option<f64>,
        progress: &dyn Progress,
    ) -> Result<Self, BakeError> {
        let path = &names::plain(path);
        let place = path.display().to_string();
        if let Some(fps) = fps.filter(|fps| !(*fps > 0.0 && fps.is_finite())) {
            let message = format!("{fps} is not a positive number of frames per second");
            return Err(BakeError::one("input", Place::option("--fps"), message));
        }
        let meta = fs::metadata(path).map_err(|e| load::unreadable(&place, &e))?;
        let mut sequence = if meta.is_dir() {
            folder::open(path, input, fps, progress)?
        } else {
            caches::open(path, input, fps, progress)?
        };
        load::forget_folder(path, &mut sequence.warnings);
        sequence.name = path.file_name().map_or_else(
            || "frames".to_string(), // `.` and `..`
            |name| name.to_string_lossy().into_owned(),
        );
        if let Some(mesh) = &mut sequence.first_mesh {
            load::forget_folder(path, &mut mesh.warnings);
            mesh.name.clone_from(&sequence.name);
            mesh.hash = sequence.hash;
        }
        Ok(sequence)
    }

    /// Number of frames T, 1 or more.
    pub fn frame_count(&self) -> usize {
        self.data.frame_count
    }

    /// Number of vertices N, 1 or more.
    pub fn vertex_count(&self) -> usize {
        self.data.vertex_count
    }

    /// Where `frame` comes from: `frames/cow_003.obj` or `cow.pc2: frame 3`.
    pub fn place(&self, frame: usize) -> Place {
        self.places.of(frame)
    }

    /// True if the source holds float32.
    pub(crate) fn is_single(&self) -> bool {
        self.data.number.is_single()
    }

    /// Reads `vertices` (a range within N) of all frames into `values`, 3 T numbers per vertex:
    /// frame after frame, vertex after vertex, x y z.
    ///
    /// # Errors
    /// A range or a length that does not fit, a file that cannot be read any more.
    pub fn read(&self, vertices: Range<usize>, values: &mut [f64]) -> Result<(), BakeError> {
        let room = 3 * vertices.len() * self.frame_count();
        if vertices.end > self.vertex_count() || values.len() != room {
            let message = format!(
                "{} numbers of vertices {vertices:?} asked for; there are {} vertices, 3 numbers \
                 per frame and vertex",
                values.len(),
                self.vertex_count()
            );
            return Err(BakeError::one("input", Place::file(&self.name), message));
        }
        self.data
            .read(vertices, values)
            .map_err(|(frame, error)| load::unreadable(&self.place(frame).to_string(), &error))
    }
}

impl Places {
    fn of(&self, frame: usize) -> Place {
        match self {
            Places::File(file) => Place::file(file).at(Part::Frame(frame)),
            Places::Folder(files) => match files.get(frame) {
                Some(file) => Part::FrameFile(file.clone()).into(),
                None => Place::NOWHERE,
            },
        }
    }
}

/// Refuses a sequence whose frames have another number of vertices than `input`.
fn check_vertex_count(
    place: &str,
    input: Option<&RawMesh>,
    vertex_count: usize,
) -> Result<(), BakeError> {
    let Some(input) = input.filter(|input| input.positions.len() != vertex_count) else {
        return Ok(());
    };
    let message = format!(
        "{vertex_count} vertices per frame, but {} has {}",
        input.name,
        input.positions.len()
    );
    Err(BakeError::one("input", Place::file(place), message))
}
