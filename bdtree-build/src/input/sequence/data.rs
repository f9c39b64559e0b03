//! The coordinates of all frames as they lie in a file.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use bdtree_npy::Number;
use sha2::{Digest, Sha256};

use crate::error::{Part, Place, Problems};
use crate::progress::Progress;

/// Bytes that are scanned at a time: a multiple of every number's size.
const SCAN_BYTES: usize = 1 << 20;

/// Largest coordinate: files hold sizes within 2^±100 mesh units (SPEC 5.2), and the squares of
/// such numbers are far from the ends of f64.
const COORDINATE_MAX: f64 = (1u128 << 100) as f64;

/// Which index varies fastest in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    /// Axis, then vertex, then frame.
    FrameMajor,
    /// Frame, then vertex, then axis.
    FrameMinor,
}

/// The numbers of a sequence in a file whose size was checked.
#[derive(Debug)]
pub(super) struct FrameData {
    /// Locked for a seek and the read behind it.
    pub(super) file: Mutex<File>,
    /// Byte of the file at which the numbers begin.
    pub(super) offset: u64,
    pub(super) number: Number,
    pub(super) order: Order,
    pub(super) frame_count: usize,
    pub(super) vertex_count: usize,
}

impl FrameData {
    /// See [`super::FrameSequence::read`]; on failure also the frame that was being read.
    pub(super) fn read(
        &self,
        vertices: Range<usize>,
        values: &mut [f64],
    ) -> Result<(), (usize, io::Error)> {
        let (n, first) = (vertices.len(), vertices.start);
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let mut bytes = Vec::new();
        let size = self.number.size();
        let mut block = |at: usize, count: usize, bytes: &mut Vec<u8>| -> io::Result<()> {
            bytes.resize(count * size, 0);
            file.seek(SeekFrom::Start(self.offset + (at * size) as u64))?;
            file.read_exact(bytes)
        };
        match self.order {
            Order::FrameMajor => {
                let frames = values.chunks_exact_mut((3 * n).max(1)).enumerate();
                for (t, frame) in frames.take(self.frame_count) {
                    let at = 3 * (t * self.vertex_count + first);
                    block(at, 3 * n, &mut bytes).map_err(|e| (t, e))?;
                    let mut out = frame.iter_mut();
                    self.number.each(&bytes, |value| {
                        if let Some(out) = out.next() {
                            *out = value;
                        }
                    });
                }
            }
            Order::FrameMinor => {
                for axis in 0..3 {
                    let at = self.frame_count * (first + axis * self.vertex_count);
                    block(at, self.frame_count * n, &mut bytes).map_err(|e| (0, e))?;
                    let rows = bytes.chunks_exact(self.frame_count * size);
                    for (vertex, row) in rows.enumerate() {
                        let mut at = 3 * vertex + axis;
                        self.number.each(row, |value| {
                            if let Some(out) = values.get_mut(at) {
                                *out = value;
                            }
                            at += 3 * n;
                        });
                    }
                }
            }
        }
        Ok(())
    }

    /// Adds the whole file to `hash` and every number that no position can be to `problems`.
    pub(super) fn scan(
        &self,
        hash: &mut Sha256,
        place: impl Fn(usize) -> Place,
        problems: &mut Problems,
        progress: &dyn Progress,
    ) -> io::Result<()> {
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.seek(SeekFrom::Start(0))?;
        let mut header = Vec::new();
        (&mut *file).take(self.offset).read_to_end(&mut header)?;
        hash.update(&header);
        let mut left = 3 * self.frame_count * self.vertex_count * self.number.size();
        progress.stage("frames", Some((left / SCAN_BYTES) as u64));
        let mut bytes = vec![0; SCAN_BYTES.min(left)];
        let mut index = 0;
        while left > 0 {
            bytes.truncate(left);
            left -= bytes.len();
            file.read_exact(&mut bytes)?;
            hash.update(&bytes);
            self.number.each(&bytes, |value| {
                if !is_coordinate(value) {
                    problems.add(|| {
                        let (frame, vertex, axis) = self.locate(index);
                        let vertex = place(frame).at(Part::Vertex(vertex));
                        (vertex.at(Part::Axis(axis)), what_is_wrong(value))
                    });
                }
                index += 1;
            });
            progress.advance(1);
        }
        Ok(())
    }

    /// Frame, vertex and axis of the number at `index` in the file.
    fn locate(&self, index: usize) -> (usize, usize, usize) {
        let (frames, vertices) = (self.frame_count, self.vertex_count);
        match self.order {
            Order::FrameMajor => (index / 3 / vertices, index / 3 % vertices, index % 3),
            Order::FrameMinor => (
                index % frames,
                index / frames % vertices,
                index / frames / vertices,
            ),
        }
    }
}

/// Why `value` is no coordinate.
pub(super) fn what_is_wrong(value: f64) -> String {
    if value.is_finite() {
        format!("{value:e} is too large: coordinates lie within 2^100")
    } else {
        format!("{value} is not finite")
    }
}

/// True for every number that a position may have.
pub(super) fn is_coordinate(value: f64) -> bool {
    value.abs() <= COORDINATE_MAX
}
