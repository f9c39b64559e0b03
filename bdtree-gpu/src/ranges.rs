//! An asset's side of the bindings: ranges of vertices whose buffers fit the device.

use std::ops::Range;

use bdtree_format::VertexModes;
use zerocopy::IntoBytes;

use crate::device::largest_binding;
use crate::error::GpuError;
use crate::influences::Influences;
use crate::skinner::Skinner;
use crate::vertex_triangles::VertexTriangles;

/// Points or normals at rest and their fields, as a file stores them: of all modes, vertex-major, or
/// of those that each vertex lists (SPEC 7.3, 7.6).
#[derive(Debug, Clone, Copy)]
pub(crate) struct FieldSet<'a> {
    pub(crate) mode_count: usize,
    /// Vectors per vertex and per vertex and mode: one, or two tangents, the second's of all modes of a
    /// vertex behind the first's.
    pub(crate) sides: usize,
    pub(crate) rest: &'a [[f32; 3]],
    pub(crate) fields: &'a [[f32; 3]],
    /// One record per vertex and one more; empty where fields are of all modes.
    pub(crate) records: &'a [VertexModes],
    pub(crate) lists: &'a [u16],
}

/// A range of vertices and its bind group.
#[derive(Debug)]
pub(crate) struct BoundRange {
    pub(crate) count: u32,
    pub(crate) group: wgpu::BindGroup,
    /// Parameters, and what the shaders read, in the order of their bindings.
    pub(crate) buffers: [wgpu::Buffer; 4],
}

impl<'a> FieldSet<'a> {
    pub(crate) fn listed(&self) -> bool {
        !self.records.is_empty()
    }

    /// Mode and field of a vertex's side.
    pub(crate) fn of(&self, vertex: usize, side: usize) -> impl Iterator<Item = (usize, [f32; 3])> {
        let (start, count, modes) = match self.listed() {
            true => {
                let [own, next] = [self.records[vertex], self.records[vertex + 1]];
                let (start, count) = (own.first_entry, next.first_entry - own.first_entry);
                let modes = &self.lists[own.mode_list_start as usize..][..count as usize];
                (start as usize, count as usize, modes)
            }
            false => (vertex * self.mode_count, self.mode_count, &[][..]),
        };
        let fields = &self.fields[self.sides * start + side * count..][..count];
        let mode = move |k: usize| modes.get(k).map_or(k, |j| usize::from(*j));
        fields.iter().enumerate().map(move |(k, u)| (mode(k), *u))
    }

    /// Fields of a range of vertices, and the index of their first.
    fn entries(&self, range: &Range<usize>) -> Range<usize> {
        let first = |i: usize| match self.listed() {
            true => self.sides * self.records[i].first_entry as usize,
            false => self.sides * i * self.mode_count,
        };
        first(range.start)..first(range.end)
    }

    /// The largest binding of a range.
    fn bytes(&self, range: &Range<usize>, skin: Option<&Influences<'_>>) -> u64 {
        let fields = 12 * self.entries(range).len();
        let lists = match self.listed() {
            true => 8 * (range.len() + 1) + 4 * self.lists.len().div_ceil(2),
            false => 0,
        };
        let lists = lists + skin.map_or(0, |skin| skin.bytes(range));
        fields.max(lists).max(12 * self.sides * range.len()) as u64
    }

    /// `skin` where bones carry the vertices: its influences lie behind the lists of modes.
    pub(crate) fn upload(
        &self,
        skinner: &Skinner,
        what: &'static str,
        skin: Option<&Influences<'_>>,
    ) -> Result<Vec<BoundRange>, GpuError> {
        let total = self.rest.len() / self.sides;
        let bytes = |range: &Range<usize>| self.bytes(range, skin);
        upload(skinner, what, total, bytes, |range| {
            let entries = self.entries(range);
            let rest = &self.rest[self.sides * range.start..self.sides * range.end];
            let mut numbers = Numbers {
                total,
                mode_count: self.mode_count,
                ..Numbers::default()
            };
            let mut lists: Vec<&[u8]> = Vec::new();
            if self.listed() {
                let records = &self.records[range.start..=range.end];
                numbers.entry_base = entries.start / self.sides;
                numbers.list_base = 2 * records.len();
                lists.extend([records.as_bytes(), self.lists.as_bytes()]);
                numbers.influences = numbers.list_base + self.lists.len().div_ceil(2);
            }
            if let Some(skin) = skin {
                lists.extend(skin.runs(range));
                numbers.bone_count = skin.bone_count;
            }
            let fields = self.fields[entries].as_bytes();
            (numbers, [vec![rest.as_bytes()], vec![fields], lists])
        })
    }
}

impl VertexTriangles {
    pub(crate) fn upload(
        &self,
        skinner: &Skinner,
        mode_count: usize,
    ) -> Result<Vec<BoundRange>, GpuError> {
        let entries = |range: &Range<usize>| {
            self.starts[range.start] as usize..self.starts[range.end] as usize
        };
        let bytes =
            |range: &Range<usize>| (8 * entries(range).len()).max(4 * (range.len() + 1)) as u64;
        let what = "triangles around vertices";
        upload(skinner, what, self.starts.len() - 1, bytes, |range| {
            let entries = entries(range);
            let numbers = Numbers {
                total: self.vertex_count,
                mode_count,
                entry_base: entries.start,
                ..Numbers::default()
            };
            let starts = self.starts[range.start..=range.end].as_bytes();
            let corners = self.corners[entries].as_bytes();
            // Empty where of all.
            let vertices = self.vertices.get(range.clone()).unwrap_or_default();
            let vertices = vertices.as_bytes();
            (numbers, [vec![starts], vec![corners], vec![vertices]])
        })
    }
}

/// Ranges of `count` vertices whose buffers, the largest of `bytes`, can be bound; `content` are a range's
/// numbers and the bytes of its three buffers.
fn upload<'d>(
    skinner: &Skinner,
    what: &'static str,
    count: usize,
    bytes: impl Fn(&Range<usize>) -> u64,
    content: impl Fn(&Range<usize>) -> (Numbers, [Vec<&'d [u8]>; 3]),
) -> Result<Vec<BoundRange>, GpuError> {
    let ranges = split(count, largest_binding(&skinner.device), what, bytes)?;
    let make = |range: Range<usize>| {
        let (numbers, [a, b, c]) = content(&range);
        let words = [
            range.len(),
            range.start,
            numbers.total,
            numbers.mode_count,
            numbers.entry_base,
            numbers.list_base,
            numbers.bone_count,
            numbers.influences,
        ];
        // All are numbers of things that a file counts in u32.
        let words = words.map(|x| x as u32);
        let uniform = wgpu::BufferUsages::UNIFORM;
        let storage = wgpu::BufferUsages::STORAGE;
        let buffers = [
            skinner.filled("parameters", uniform, &[words.as_bytes()])?,
            skinner.filled(what, storage, &a)?,
            skinner.filled(what, storage, &b)?,
            skinner.filled(what, storage, &c)?,
        ];
        Ok(BoundRange {
            count: range.len() as u32,
            group: skinner.bind(&skinner.layouts.fields, &buffers.each_ref()),
            buffers,
        })
    };
    ranges.into_iter().map(make).collect()
}

/// `Params` of the shaders, but for the range.
#[derive(Default)]
struct Numbers {
    total: usize,
    mode_count: usize,
    entry_base: usize,
    list_base: usize,
    bone_count: usize,
    influences: usize,
}

/// Ranges of `0 .. count`, as few as keep `bytes` of each within `limit`.
fn split(
    count: usize,
    limit: u64,
    what: &'static str,
    bytes: impl Fn(&Range<usize>) -> u64,
) -> Result<Vec<Range<usize>>, GpuError> {
    let mut ranges = Vec::new();
    let mut start = 0;
    while start < count {
        // `fit` fits (or is `start`), `over` does not (or is beyond the end).
        let (mut fit, mut over) = (start, count + 1);
        while fit + 1 < over {
            let middle = if over > count {
                count
            } else {
                fit.midpoint(over)
            };
            if bytes(&(start..middle)) <= limit {
                fit = middle;
            } else {
                over = middle;
            }
            if fit == count {
                break;
            }
        }
        if fit == start {
            let bytes = bytes(&(start..start + 1));
            return Err(GpuError::AssetTooLarge { what, bytes, limit });
        }
        ranges.push(start..fit);
        start = fit;
    }
    Ok(ranges)
}
