//! One sequence on its way to a basis: what is known before the number of modes is.

use super::align::align;
use super::fields::{fields, held};
use super::measure;
use super::rank::{Rank, Rounding, rank};
use super::snapshots::{Snapshots, center, mean};
use super::tsqr::{Spectrum, Tsqr};
use super::{About, PcaOptions};
use crate::basis::{Animation, Basis, BasisError, BasisMode, RigidMotion};
use crate::error::{BakeError, Place};
use crate::figures::counted;
use crate::input::RawMesh;
use crate::input::sequence::FrameSequence;
use crate::progress::Progress;
use crate::wrap;

/// Rest positions, singular values, motions.
pub(super) struct Reduction<'a> {
    snapshots: Snapshots<'a>,
    memory_limit_bytes: u64,
    motions: Vec<RigidMotion>,
    /// The mesh with the rest positions.
    pub(super) mesh: RawMesh,
    pub(super) spectrum: Spectrum,
    pub(super) rank: Rank,
    /// Diagonal of the box around the rest positions, or 1 where that is zero.
    pub(super) size: f64,
}

impl<'a> Reduction<'a> {
    /// Reads the sequence once, and once more per round of `align`.
    pub(super) fn new(
        mesh: &RawMesh,
        sequence: &'a FrameSequence,
        options: &PcaOptions,
        progress: &dyn Progress,
    ) -> Result<Self, BakeError> {
        check_memory(sequence, 0, 0, options.memory_limit_bytes)?;
        let mut snapshots = Snapshots::new(sequence, options.chunk_vertices);
        let motions = if options.align {
            align(&mut snapshots, &mesh.positions, options.about, progress)?
        } else {
            Vec::new()
        };
        let mut mesh = mesh.clone();
        let rest = &mut mesh.positions;
        let (n, frames) = (rest.len(), sequence.frame_count());
        let mut tsqr = Tsqr::new(3 * n, frames);
        let resolution = tsqr.resolution();
        let mut rounding = Rounding::default();
        let mut values = Vec::new();
        progress.stage(
            "principal components",
            Some(snapshots.chunks().count() as u64),
        );
        for vertices in snapshots.chunks() {
            let rows = 3 * vertices.len();
            snapshots.read(&vertices, &mut values)?;
            rounding.add(&values, rows);
            snapshots.align(&mut values);
            let rest = &mut rest[vertices];
            if options.about == About::Mean {
                mean(&values, rows, rest);
            }
            center(&mut values, rest);
            tsqr.add(&values);
            progress.advance(1);
        }
        let spectrum = tsqr.finish().ok_or_else(|| {
            let message = "the singular value decomposition does not converge";
            BakeError::one("basis", Place::file(&sequence.name), message)
        })?;
        // Refuses what cannot be stored before the rest of the work.
        let rigid = Basis {
            vertex_count: n,
            ..Basis::default()
        };
        let diagonal = wrap::store(&mesh, &rigid, &mut Vec::new())?.diagonal;
        let rounding = rounding.singular_value(sequence.is_single(), frames);
        let rank = rank(&spectrum, rounding, resolution, diagonal);
        Ok(Self {
            snapshots,
            memory_limit_bytes: options.memory_limit_bytes,
            motions,
            mesh,
            spectrum,
            rank,
            size: if diagonal > 0.0 { diagonal } else { 1.0 },
        })
    }

    /// Root mean square over all vertices and frames of what `modes` modes leave at least, relative
    /// to the diagonal.
    pub(super) fn rms_rel(&self, modes: usize) -> f64 {
        let tail = self.spectrum.values.iter().skip(modes);
        // From the smallest on, so that small ones count.
        let sum: f64 = tail.rev().map(|s| s * s).sum();
        let frames = self.snapshots.sequence.frame_count();
        (sum / (frames * self.mesh.positions.len()) as f64).sqrt() / self.size
    }

    /// Says so if fewer than `wanted` modes exist, or none.
    pub(super) fn warn(&self, wanted: usize, warnings: &mut Vec<String>) {
        let sequence = self.sequence();
        let (name, frames) = (&sequence.name, sequence.frame_count());
        let modes = self.rank.modes;
        if modes == 0 {
            warnings.push(match frames {
                1 => format!("{name}: one frame, no modes: the shape is rigid"),
                _ => format!(
                    "{name}: the {frames} frames differ by rounding only, no modes: the shape is rigid"
                ),
            });
        } else if modes < wanted {
            let components = counted(modes, "independent component");
            let why = if modes + 1 >= frames {
                // Their differences to the mean, or to given positions: one component fewer, or as many.
                format!("{frames} frames have at most {components}")
            } else {
                format!("the {frames} frames have {components}, the rest is rounding")
            };
            warnings.push(format!(
                "{name}: {modes} of up to {wanted} modes {} stored: {why}",
                if modes == 1 { "is" } else { "are" }
            ));
        }
    }

    /// The basis of the first `count` modes, at most the rank.
    pub(super) fn basis(&self, count: usize, progress: &dyn Progress) -> Result<Basis, BakeError> {
        let sequence = self.sequence();
        let rest = &self.mesh.positions;
        let (spectrum, rank) = (&self.spectrum, self.rank.modes);
        let held = held(spectrum, rank, count);
        check_memory(sequence, count, held, self.memory_limit_bytes)?;
        let fields = fields(&self.snapshots, rest, spectrum, rank, count, progress)?;
        let frames = sequence.frame_count();
        let q = (0..frames)
            .flat_map(|t| (0..count).map(move |j| (j, t)))
            .map(|at| fields.q[at])
            .collect();
        let mode = |j| {
            let range = (0..frames).fold(0.0, |m: f64, t| m.max(fields.q[(j, t)].abs()));
            BasisMode {
                q_range: (range > 0.0).then_some(range),
                ..BasisMode::default()
            }
        };
        Ok(Basis {
            vertex_count: rest.len(),
            modes: (0..count).map(mode).collect(),
            fields: fields.fields,
            animation: Some(Animation {
                frame_count: frames,
                times_s: sequence.times_s.clone(),
                q,
                motions: self.motions.clone(),
            }),
        })
    }

    /// The errors of the first `from`, `from + 1`, … modes of `basis`.
    pub(super) fn errors(
        &self,
        basis: &Basis,
        from: usize,
        progress: &dyn Progress,
    ) -> Result<Vec<BasisError>, BakeError> {
        // The bake stores once more, and says then what is odd.
        let shape = wrap::store(&self.mesh, basis, &mut Vec::new())?;
        let q = basis.animation.as_ref().map_or(&[][..], |a| &a.q);
        measure::errors(&self.snapshots, &shape, q, from, progress)
    }

    /// Where the frames come from.
    pub(super) fn sequence(&self) -> &'a FrameSequence {
        self.snapshots.sequence
    }
}

/// Refuses work whose largest matrices need more than the limit.
///
/// `held` fields are in memory at a time to make `modes`.
fn check_memory(
    sequence: &FrameSequence,
    modes: usize,
    held: usize,
    limit_bytes: u64,
) -> Result<(), BakeError> {
    let (frames, vertices) = (sequence.frame_count(), sequence.vertex_count());
    let rows = vertices.saturating_mul(3);
    let (held_rows, columns) = Tsqr::held(rows, frames);
    let square = frames.min(rows) as u64 * frames as u64;
    // The triangle with the rows on top of it; both factors of its decomposition and as much room
    // to work; fields in f64, and those that stay once more in f32.
    let numbers = (held_rows as u64 * columns as u64).saturating_add(square.saturating_mul(5));
    let per_vertex = (held as u64 * 24).saturating_add(modes as u64 * 12);
    let fields = (vertices as u64).saturating_mul(per_vertex);
    let need = numbers.saturating_mul(8).saturating_add(fields);
    if need <= limit_bytes {
        return Ok(());
    }
    let equal = if held > modes {
        format!(" ({held} fields at a time, since singular values are equal)")
    } else {
        String::new()
    };
    let message = format!(
        "{frames} frames of {vertices} vertices with {modes} modes{equal} need about {} MiB, the \
         limit is {} MiB (--memory-limit)",
        need >> 20,
        limit_bytes >> 20
    );
    Err(BakeError::one(
        "basis",
        Place::file(&sequence.name),
        message,
    ))
}
