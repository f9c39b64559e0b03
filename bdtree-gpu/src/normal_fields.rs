//! Normals of the deformed mesh from fields: two tangents per vertex that move with q.
//!
//! `n' ∥ (t₁ + T₁ q) × (t₂ + T₂ q)`. The normal weighted by area is a sum of cross products of edges,
//! each of them linear in q, so it is quadratic in q. T is chosen so that the terms of first order
//! are met exactly and those of second order as well as six numbers per mode can
//! (docs/design/decisions/normal-fields.md).

use std::collections::BTreeMap;
use std::ops::Range;
use std::thread;

use bdtree_format::VertexModes;
use bdtree_runtime::{Asset, VertexId};

use crate::error::GpuError;
use crate::ranges::FieldSet;
use crate::samples::Samples;
use crate::tangents::{Around, wide};
use crate::vertex_triangles::{VertexTriangles, triangles};

/// Two tangents per vertex at rest, and how each mode moves them.
#[derive(Debug)]
pub struct NormalFields {
    mode_count: usize,
    /// t₁ and t₂ of each vertex; zeros where a vertex has no triangle with an area.
    rest: Vec<[f32; 3]>,
    /// Of each vertex T₁ of its modes, then T₂ of them (per unit of q).
    fields: Vec<[f32; 3]>,
    /// As VMOD (SPEC 7.6), entries counted once for both tangents; empty where fields are of all modes.
    records: Vec<VertexModes>,
    lists: Vec<u16>,
    /// Of the vertices at which the fields are too far off.
    marked: VertexTriangles,
}

impl NormalFields {
    /// The fields of an asset. Where vertices list their modes, a vertex's fields are of the modes that
    /// move it or a vertex of its triangles. Tried at poses that move the farthest vertex by a tenth of the
    /// diagonal, each mode alone, fixed mixtures and, up to 24 modes, each pair of modes: vertices that are
    /// off by more than 0.3° in any are marked. Poses tried: M² + 32 up to 24 modes, M + 32 beyond, each in both
    /// directions. Computed by as many threads as there are processors.
    ///
    /// # Errors
    /// Records that break the format's rules; sizes beyond 32 bits.
    pub fn new(asset: &Asset<'_>) -> Result<Self, GpuError> {
        let (vertex_count, mode_count) = (asset.vertex_count(), asset.mode_count());
        asset.check_mesh()?;
        let around_all = VertexTriangles::new(vertex_count, &triangles(asset)?)?;
        let listed = !asset.vertex_modes().is_empty();
        let job = Job {
            asset,
            around_all: &around_all,
            listed,
            amplitudes: &amplitudes(asset),
            samples: &Samples::new(asset)?,
        };
        let mut made = Self {
            mode_count,
            rest: Vec::with_capacity(2 * vertex_count),
            fields: Vec::new(),
            records: Vec::new(),
            lists: Vec::new(),
            marked: around_all.of(Vec::new()),
        };
        let (mut marked, mut known) = (Vec::new(), BTreeMap::new());
        for part in job.parts(vertex_count)? {
            let mut entries = made.fields.len() / 2;
            for modes in part.modes {
                let (count, end) = (modes.len(), made.lists.len() as u32);
                let start = *known.entry(modes).or_insert_with_key(|modes| {
                    made.lists.extend(modes);
                    end
                });
                made.records.push(record(entries, start)?);
                entries += count;
            }
            made.rest.extend(part.rest);
            made.fields.extend(part.fields);
            marked.extend(part.marked);
        }
        if listed {
            made.records.push(record(made.fields.len() / 2, 0)?);
        }
        made.marked = around_all.of(marked);
        Ok(made)
    }

    /// Bytes of all numbers on the device.
    pub fn bytes(&self) -> u64 {
        let lists = 8 * self.records.len() + 2 * self.lists.len();
        (12 * (self.rest.len() + self.fields.len()) + lists) as u64 + self.marked_bytes()
    }

    /// Those that marked vertices need.
    pub fn marked_bytes(&self) -> u64 {
        8 * (self.marked.vertices.len() + self.marked.corners.len()) as u64
    }

    /// Vertices at which the fields are too far off, ascending: compute passes take their normals from the
    /// triangles around them instead, as [`Normals::Exact`](crate::Normals::Exact) does of all.
    pub fn marked(&self) -> &[u32] {
        &self.marked.vertices
    }

    pub(crate) fn marked_triangles(&self) -> &VertexTriangles {
        &self.marked
    }

    /// Both tangents of a vertex at q, in stored axes, formed in f64, each with the sum of the lengths
    /// of what it is made of: what rounding errors are relative to. Zeros where there is no such vertex.
    pub fn tangents(&self, vertex: usize, q: &[f32]) -> [([f64; 3], f64); 2] {
        let set = self.set();
        [0, 1].map(|side| {
            let Some(rest) = self.rest.get(2 * vertex + side) else {
                return ([0.0; 3], 0.0);
            };
            let mut sum = (wide(*rest), wide(*rest).length());
            for (mode, u) in set.of(vertex, side) {
                let q = q.get(mode).copied().map_or(0.0, f64::from);
                let by = wide(u) * q;
                sum = (sum.0 + by, sum.1 + by.length());
            }
            (sum.0.to_array(), sum.1)
        })
    }

    pub(crate) fn set(&self) -> FieldSet<'_> {
        FieldSet {
            mode_count: self.mode_count,
            sides: 2,
            rest: &self.rest,
            fields: &self.fields,
            records: &self.records,
            lists: &self.lists,
        }
    }
}

/// Of a vertex whose fields come after so many entries.
fn record(entries: usize, mode_list_start: u32) -> Result<VertexModes, GpuError> {
    let too_large = |_| GpuError::AssetTooLarge {
        what: "normal fields",
        bytes: 24 * entries as u64,
        limit: 24 * u64::from(u32::MAX),
    };
    Ok(VertexModes {
        first_entry: u32::try_from(entries).map_err(too_large)?,
        mode_list_start,
    })
}

/// What every thread reads.
#[derive(Clone, Copy)]
struct Job<'j> {
    asset: &'j Asset<'j>,
    around_all: &'j VertexTriangles,
    listed: bool,
    amplitudes: &'j [f64],
    samples: &'j Samples,
}

/// Fields of a run of vertices.
#[derive(Default)]
struct Part {
    rest: Vec<[f32; 3]>,
    fields: Vec<[f32; 3]>,
    /// Of each vertex, where vertices list them.
    modes: Vec<Vec<u16>>,
    marked: Vec<u32>,
}

/// Fewer vertices are no work for another thread.
const VERTICES_PER_THREAD: usize = 500;

impl Job<'_> {
    /// The fields of all vertices in order, by as many threads as there are processors.
    fn parts(self, vertex_count: usize) -> Result<Vec<Part>, GpuError> {
        let threads = thread::available_parallelism().map_or(1, usize::from);
        let each = vertex_count.div_ceil(threads).max(VERTICES_PER_THREAD);
        let part = |start: usize| self.part(start..vertex_count.min(start + each));
        if each >= vertex_count {
            return Ok(vec![part(0)?]); // WebAssembly has no other threads
        }
        thread::scope(|scope| {
            let starts = (0..vertex_count).step_by(each);
            let workers: Vec<_> = starts
                .map(|start| scope.spawn(move || part(start)))
                .collect();
            let join = |worker: thread::ScopedJoinHandle<'_, _>| match worker.join() {
                Ok(part) => part,
                Err(panic) => std::panic::resume_unwind(panic),
            };
            workers.into_iter().map(join).collect()
        })
    }

    fn part(self, vertices: Range<usize>) -> Result<Part, GpuError> {
        let mode_count = self.asset.mode_count();
        let mut made = Part::default();
        let mut around = Around::default();
        let mut modes: Vec<u16> = (0..mode_count as u16).collect();
        let mut places: Vec<Option<usize>> = (0..mode_count).map(Some).collect();
        let mut amplitudes = self.amplitudes.to_vec();
        for vertex in vertices {
            let triangles = self.around_all.around(vertex);
            if self.listed {
                modes = acting(self.asset, triangles, vertex)?;
                places.fill(None);
                for (place, mode) in modes.iter().enumerate() {
                    places[usize::from(*mode)] = Some(place);
                }
                amplitudes.clear();
                amplitudes.extend(modes.iter().map(|j| self.amplitudes[usize::from(*j)]));
            }
            around.gather(self.asset, triangles, vertex, &modes, &amplitudes)?;
            let tangents = around.tangents(&amplitudes);
            if self.samples.off(&around, &tangents, &places) {
                made.marked.push(vertex as u32);
            }
            if self.listed {
                made.modes.push(modes.clone());
            }
            made.rest.extend(tangents.rest);
            for side in 0..2 {
                made.fields
                    .extend(tangents.moved.iter().map(|both| both[side]));
            }
        }
        Ok(made)
    }
}

/// For each mode the q that moves a vertex by a tenth of the mesh's extent: what counts as large.
fn amplitudes(asset: &Asset<'_>) -> Vec<f64> {
    let extent = f64::from(asset.header().position_norm_max.get());
    let one = |record: &bdtree_format::ModeRecord| {
        let most = f64::from(record.field_norm_max.get());
        if most > 0.0 { 0.2 * extent / most } else { 0.0 }
    };
    asset.modes().iter().map(one).collect()
}

/// The modes that move a vertex or one of its triangles' others.
fn acting(asset: &Asset<'_>, triangles: &[[u32; 2]], vertex: usize) -> Result<Vec<u16>, GpuError> {
    let mut modes = Vec::new();
    for v in triangles.as_flattened().iter().chain(&[vertex as u32]) {
        let of_one = asset.displacements(VertexId(*v))?;
        modes.extend(of_one.iter().map(|(mode, _)| mode as u16)); // there are at most 2^16
    }
    modes.sort_unstable();
    modes.dedup();
    Ok(modes)
}
