//! The error that a basis leaves, measured with the numbers that the file stores (SPEC 5.5).

use super::motion::Motion;
use super::snapshots::Snapshots;
use crate::basis::BasisError;
use crate::basis::tally::Tally;
use crate::error::BakeError;
use crate::progress::Progress;
use crate::vec3::{norm2, sub};
use crate::wrap::StoredShape;
use crate::wrap::round::round_nearest;

/// Vertices that are evaluated together.
const TILE: usize = 128;

/// The errors of the first `from`, `from + 1`, … , M modes of `shape` against the source, every
/// frame and vertex: the distance from the vertex as played back to where the source has it.
///
/// Playback evaluates q and fields in f32 (the leaf arithmetic), then origin and unit, then the
/// motion of the frame, in f64. `q[t * M + j]`; `motions` empty or one per frame. Relative to the
/// diagonal of the box around the rest positions, or to one mesh unit where that is zero.
pub(super) fn errors(
    snapshots: &Snapshots<'_>,
    shape: &StoredShape,
    q: &[f64],
    from: usize,
    progress: &dyn Progress,
) -> Result<Vec<BasisError>, BakeError> {
    let mode_count = shape.mode_count();
    let frames = snapshots.sequence.frame_count();
    let q: Vec<f32> = q.iter().map(|&x| round_nearest(x)).collect();
    let mut tally = vec![Tally::of_frames(); (mode_count + 1).saturating_sub(from)];
    let mut values = Vec::new();
    let mut tile = Tile::new(shape);
    progress.stage("error", Some(snapshots.chunks().count() as u64));
    for vertices in snapshots.chunks() {
        snapshots.read(&vertices, &mut values)?;
        let rows = 3 * vertices.len();
        for first in vertices.clone().step_by(TILE) {
            let count = TILE.min(vertices.end - first);
            tile.load(shape, first, count);
            let offset = 3 * (first - vertices.start);
            for t in 0..frames {
                let source = &values[t * rows + offset..t * rows + offset + 3 * count];
                let motion = snapshots.motions.get(t);
                tile.sums.fill(-0.0); // adding to −0 changes no bit
                for modes in 0..=mode_count {
                    if let Some(tally) = modes.checked_sub(from).and_then(|i| tally.get_mut(i)) {
                        tile.compare(source, motion, t, tally);
                    }
                    if modes < mode_count {
                        tile.add(modes, q[t * mode_count + modes]);
                    }
                }
            }
        }
        progress.advance(1);
    }
    let count = frames * snapshots.sequence.vertex_count();
    let size = if shape.diagonal > 0.0 {
        shape.diagonal
    } else {
        1.0
    };
    Ok(tally.iter().map(|tally| tally.error(count, size)).collect())
}

/// A few vertices, mode after mode, so that they are evaluated side by side.
struct Tile {
    origin: [f64; 3],
    unit: f64,
    first: usize,
    /// Rest positions.
    positions: Vec<f32>,
    /// `fields[j * positions.len() + i]`.
    fields: Vec<f32>,
    /// The sum over modes so far.
    sums: Vec<f32>,
}

impl Tile {
    fn new(shape: &StoredShape) -> Self {
        Self {
            origin: shape.origin,
            unit: f64::powi(2.0, shape.unit_exponent),
            first: 0,
            positions: Vec::new(),
            fields: Vec::new(),
            sums: Vec::new(),
        }
    }

    fn load(&mut self, shape: &StoredShape, first: usize, count: usize) {
        let modes = shape.mode_count();
        self.first = first;
        self.positions.clear();
        let positions = &shape.positions[first..first + count];
        self.positions.extend_from_slice(positions.as_flattened());
        self.sums.resize(3 * count, 0.0);
        self.fields.clear();
        let rows = &shape.displacements[first * modes..(first + count) * modes];
        for j in 0..modes {
            let column = rows.iter().skip(j).step_by(modes);
            self.fields.extend(column.flatten());
        }
    }

    /// Adds mode `j` at `q`.
    fn add(&mut self, j: usize, q: f32) {
        let count = self.sums.len();
        let field = &self.fields[j * count..(j + 1) * count];
        for (sum, u) in self.sums.iter_mut().zip(field) {
            *sum += u * q;
        }
    }

    /// Tallies the distances to `source`, positions of frame `t`.
    fn compare(&self, source: &[f64], motion: Option<&Motion>, t: usize, tally: &mut Tally) {
        let sums = self.sums.as_chunks::<3>().0;
        let rest = self.positions.as_chunks::<3>().0;
        let source = source.as_chunks::<3>().0;
        for (i, ((sum, p), x)) in sums.iter().zip(rest).zip(source).enumerate() {
            let stored: [f32; 3] = std::array::from_fn(|k| p[k] + sum[k]);
            let mut at: [f64; 3] =
                std::array::from_fn(|k| self.origin[k] + self.unit * f64::from(stored[k]));
            if let Some(motion) = motion {
                at = motion.apply(at);
            }
            tally.add(norm2(sub(at, *x)), Some(t), self.first + i);
        }
    }
}
