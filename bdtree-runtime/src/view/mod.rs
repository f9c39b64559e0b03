//! The typed view of an opened file: one accessor per section, names as in `SPEC.md`.

mod displacements;
mod mass;
mod skin;

pub use displacements::Displacements;
pub use skin::NodeBones;
pub(crate) use skin::Skin;

use bdtree_format::{
    FrameRecord, GroupRecord, Header, MassRecord, ModeMomentum, ModePair, ModeRecord, NodeRecord,
    ROWS_LEADING, ROWS_PER_PAIR, Row, SectionKind, SectionRecord, TriangleRecord, VertexModes,
    group_kind, pair_count, row_count,
};
use zerocopy::{FromBytes, IntoBytes};

use crate::bones::MAP_LEN;
use crate::contact::{TriangleId, VertexId};
use crate::error::{Check, Datum, FormatError, TRIANGLE_BELOW, VERTEX_BELOW};
use crate::simd::Kernel;

/// An opened `.bdt` file: borrowed, read-only, shareable between threads and instances.
///
/// Opening checks header and tables only. Of a file that was damaged later, every access is checked: an index that leads
/// nowhere is a [`crate::QueryError::Corrupt`]. A damaged *number*, such as a coordinate, is not noticed: the answers are
/// then wrong without an error. Call [`Asset::verify_checksums`] after opening a file that may have been damaged on its
/// way; [`Asset::verify`] checks every rule besides.
#[derive(Debug, Clone, Copy)]
pub struct Asset<'a> {
    pub(crate) bytes: &'a [u8],
    pub(crate) header: &'a Header,
    pub(crate) modes: &'a [ModeRecord],
    pub(crate) sections: &'a [SectionRecord],
    pub(crate) nodes: &'a [NodeRecord],
    pub(crate) rows: &'a [Row],
    pub(crate) mode_lists: &'a [u16],
    pub(crate) triangles: &'a [TriangleRecord],
    pub(crate) triangle_slots: &'a [u32],
    pub(crate) positions: &'a [[f32; 3]],
    pub(crate) displacements: &'a [[f32; 3]],
    /// Empty where all modes move all vertices.
    pub(crate) vertex_modes: &'a [VertexModes],
    pub(crate) skin: Option<Skin<'a>>,
    pub(crate) mass: Option<&'a MassRecord>,
    /// One per mode; empty where there are none.
    pub(crate) momenta: &'a [ModeMomentum],
    pub(crate) frames: &'a [FrameRecord],
    pub(crate) frame_q: &'a [f32],
    pub(crate) groups: &'a [GroupRecord],
    pub(crate) group_names: &'a [u8],
    pub(crate) metadata: &'a [u8],
    /// 2^unit_exponent.
    pub(crate) unit: f64,
    pub(crate) kernel: Kernel,
    /// Rows of each node, where all modes act on all nodes: those of node i begin at i times this. Else 0.
    pub(crate) row_stride: usize,
    /// About the radius of spheres above leaves of four triangles (stored units).
    pub(crate) leaf_radius: f64,
}

/// The rows of a node (SPEC 6.5).
#[derive(Debug, Clone, Copy)]
pub struct NodeRows<'a> {
    /// c and R (stored units).
    pub leading: &'a [Row; ROWS_LEADING],
    /// One for every two active modes, in [`NodeRows::units`].
    pub pairs: &'a [ModePair],
    /// δR and the δR of scaled steps (stored units).
    pub steps: &'a [Row; 2],
    /// What one unit of Ū, of ΔR (stored units) and of b± (their square) in `pairs` is, for a
    /// mode that is at its limit.
    pub units: [f32; 3],
}

impl NodeRows<'_> {
    /// Ū_x, Ū_y, Ū_z, ΔR, b⁺ and b⁻ of one lane for the node's k-th active mode, in
    /// [`NodeRows::units`]; zeros where there is none.
    pub fn numbers(&self, k: usize, lane: usize) -> [i16; 6] {
        self.pairs
            .get(k / 2)
            .map_or([0; 6], |pair| pair.numbers(k, lane))
    }
}

/// 2^e for each e, 0 for e below −126 (SPEC 6.1).
#[inline(always)]
fn units(exponents: [i8; 3]) -> [f32; 3] {
    let [a, b, c] = exponents;
    [unit(a), unit(b), unit(c)]
}

#[inline(always)]
fn unit(exponent: i8) -> f32 {
    // The bias added, the exponent's bits of an f32.
    f32::from_bits(((i32::from(exponent) + 127).max(0) as u32) << 23)
}

/// What a source uses the name of a [`Group`] for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum GroupKind {
    /// An object: OBJ `o`, a mesh of glTF.
    Object,
    /// A group: OBJ `g`.
    Group,
    /// A material: OBJ `usemtl`.
    Material,
}

impl GroupKind {
    /// The kind of a record, if it is known (SPEC 7.4).
    fn of(kind: u32) -> Option<Self> {
        match kind {
            group_kind::OBJECT => Some(Self::Object),
            group_kind::GROUP => Some(Self::Group),
            group_kind::MATERIAL => Some(Self::Material),
            _ => None,
        }
    }
}

/// A run of triangles that the source put under one name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Group<'a> {
    /// What the source used the name for.
    pub kind: GroupKind,
    /// First triangle id.
    pub first_triangle: TriangleId,
    /// Number of triangles.
    pub triangle_count: u32,
    /// The source's name.
    pub name: &'a str,
}

impl<'a> Asset<'a> {
    /// Number of vertices N, unused ones included.
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// Number of triangles F; ids are `0..F`.
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// Number of modes M: the length of q.
    pub fn mode_count(&self) -> usize {
        self.modes.len()
    }

    /// Number of eight-wide nodes.
    pub fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// Number of node levels; the root's is level 0.
    pub fn depth(&self) -> usize {
        self.header.depth.get() as usize
    }

    /// The file's bytes.
    pub fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// The fixed header.
    pub fn header(&self) -> &'a Header {
        self.header
    }

    /// The mode table: limits, ranges, frequencies and masses, one record per mode. Frequency and mass are −1 where they are
    /// unknown: only vibration modes have them.
    pub fn modes(&self) -> &'a [ModeRecord] {
        self.modes
    }

    /// The section table, in file order.
    pub fn sections(&self) -> &'a [SectionRecord] {
        self.sections
    }

    /// All nodes, breadth first.
    pub fn nodes(&self) -> &'a [NodeRecord] {
        self.nodes
    }

    /// The rows of a node.
    ///
    /// # Errors
    /// When they lie outside the row section.
    #[inline(always)]
    pub fn node_rows(&self, node: &NodeRecord) -> Result<NodeRows<'a>, FormatError> {
        let start = node.row_start as usize;
        let m = usize::from(node.mode_count);
        let count = pair_count(m);
        let end = start.saturating_add(row_count(m));
        let rows = self.rows.get(start..end).unwrap_or_default();
        if let Some((leading, rest)) = rows.split_first_chunk::<ROWS_LEADING>()
            && let Some((pairs, steps)) = rest.split_at_checked(ROWS_PER_PAIR * count)
            && let Ok(pairs) = <[ModePair]>::ref_from_bytes_with_elems(pairs.as_bytes(), count)
            && let Some(steps) = steps.first_chunk()
        {
            return Ok(NodeRows {
                leading,
                pairs,
                steps,
                units: units(node.scale_exponents),
            });
        }
        Err(self.ends_outside(SectionKind::ROWS, end, self.rows.len(), 32))
    }

    /// The modes that act on a node, ascending.
    ///
    /// # Errors
    /// When they lie outside the mode-list section.
    #[inline(always)]
    pub fn node_modes(&self, node: &NodeRecord) -> Result<&'a [u16], FormatError> {
        let start = node.mode_list_start as usize;
        let end = start.saturating_add(usize::from(node.mode_count));
        match self.mode_lists.get(start..end) {
            Some(modes) => Ok(modes),
            None => {
                let len = self.mode_lists.len();
                Err(self.ends_outside(SectionKind::MODE_LISTS, end, len, 2))
            }
        }
    }

    /// The triangles in leaf order.
    pub fn triangles(&self) -> &'a [TriangleRecord] {
        self.triangles
    }

    /// The place of each triangle id in [`Asset::triangles`].
    pub fn triangle_slots(&self) -> &'a [u32] {
        self.triangle_slots
    }

    /// A triangle's corners as vertex ids, in the source's order.
    ///
    /// # Errors
    /// If the id is not below [`Asset::triangle_count`] (`found` is the id, `expected` the count), or its record lies
    /// outside the file.
    pub fn triangle(&self, id: TriangleId) -> Result<[VertexId; 3], FormatError> {
        let count = self.triangle_slots.len();
        let slot = *self.triangle_slots.get(id.0 as usize).ok_or_else(|| {
            self.out_of_range(SectionKind::TRIANGLE_SLOTS, id.0 as usize, count, 4)
        })? as usize;
        let record = self.triangles.get(slot).ok_or_else(|| {
            self.out_of_range(SectionKind::TRIANGLES, slot, self.triangles.len(), 16)
        })?;
        Ok(record.corners.map(VertexId))
    }

    /// Rest positions (stored units, relative to the origin), in source order.
    pub fn positions(&self) -> &'a [[f32; 3]] {
        self.positions
    }

    /// The origin that stored positions are relative to (mesh units).
    pub fn origin(&self) -> [f64; 3] {
        self.header.origin.map(|x| x.get())
    }

    /// Mesh units per stored unit: a power of two.
    pub fn unit(&self) -> f64 {
        self.unit
    }

    /// The source's groups, in file order, those of unknown kinds left out (SPEC 7.4); names that
    /// are not UTF-8 read as empty.
    pub fn groups(&self) -> impl Iterator<Item = Group<'a>> + use<'a> {
        let names = self.group_names;
        self.groups.iter().filter_map(move |g| {
            let start = g.name_start as usize;
            let bytes = names
                .get(start..start.saturating_add(g.name_bytes as usize))
                .unwrap_or_default();
            Some(Group {
                kind: GroupKind::of(g.kind)?,
                first_triangle: TriangleId(g.first_triangle),
                triangle_count: g.triangle_count,
                name: core::str::from_utf8(bytes).unwrap_or_default(),
            })
        })
    }

    /// The metadata section's bytes; empty when there is none.
    pub fn metadata(&self) -> &'a [u8] {
        self.metadata
    }

    /// The instruction set that node bounds are evaluated with.
    pub fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// The same asset with another kernel, for tests and measurements; `None` when this
    /// processor lacks it. Results and visited nodes are the same with every kernel.
    pub fn with_kernel(self, kernel: Kernel) -> Option<Self> {
        kernel.is_available().then_some(Self { kernel, ..self })
    }

    /// Numbers that the `memory` of [`Asset::pose`] needs: five for every two modes and sixteen for every bone.
    pub fn pose_len(&self) -> usize {
        let m = self.modes.len();
        m + 3 * pair_count(m) + MAP_LEN * self.bone_count()
    }

    /// Entries that the stack of a single-asset query needs.
    pub(crate) fn stack_len(&self) -> usize {
        // Two nodes are popped at a time and push at most sixteen, so each level leaves fourteen
        // behind; or fifteen, where the second is the only one of a deeper level, which then
        // holds eight. Walks by keys push leaves, too, and pop a node alone where a leaf comes next:
        // that leaves fifteen behind, but then of at most eight on the next level.
        14 * self.depth() + 2
    }

    /// Entries that the stack of a pair query between `self` and `other` needs.
    pub(crate) fn pair_stack_len(&self, other: &Asset<'_>) -> usize {
        // A popped pair of nodes pushes at most 64 pairs and descends in both trees; a leaf lane
        // against a node pushes eight and descends in one.
        let (a, b) = (self.depth(), other.depth());
        63 * a.min(b) + 7 * a.max(b) + 1
    }

    /// Entries that the stack of a distance query between `self` and `other` needs.
    pub(crate) fn distance_stack_len(&self, other: &Asset<'_>) -> usize {
        // Each visit opens one node of one side and puts eight pairs in place of one.
        7 * (self.depth() + other.depth()) + 1
    }

    /// Offset of a section from the start of the file, for error messages.
    pub(crate) fn section_offset(&self, kind: SectionKind) -> u64 {
        self.sections
            .iter()
            .find(|s| s.kind == kind)
            .map_or(0, |s| s.offset.get())
    }

    /// The place of a byte of a section, for error messages.
    pub(crate) fn at(&self, kind: SectionKind, offset: usize) -> Check {
        Check::at(
            kind,
            self.section_offset(kind).saturating_add(offset as u64),
        )
    }

    /// The error for a range that ends beyond a section's end.
    #[cold]
    pub(crate) fn ends_outside(
        &self,
        kind: SectionKind,
        end: usize,
        len: usize,
        element_bytes: usize,
    ) -> FormatError {
        FormatError {
            expected: Datum::at_most(len),
            ..self.out_of_range(kind, end, len, element_bytes)
        }
    }

    /// The error for a vertex that the asset lacks: at the first triangle that has it as a corner, else, where a
    /// caller asked for it, at the end of the vertices.
    #[cold]
    pub(crate) fn unknown_vertex(&self, vertex: VertexId) -> FormatError {
        let has_it = |triangle: &TriangleRecord| triangle.corners.contains(&vertex.0);
        match self.triangles.iter().position(has_it) {
            Some(slot) => self.no_corner(slot, vertex.0),
            None => {
                let (i, count) = (vertex.0 as usize, self.positions.len());
                self.out_of_range(SectionKind::POSITIONS, i, count, 12)
            }
        }
    }

    /// The error for a triangle with a corner that is no vertex.
    #[cold]
    pub(crate) fn no_corner(&self, slot: usize, vertex: u32) -> FormatError {
        let start = slot * size_of::<TriangleRecord>();
        let place = self.at(SectionKind::TRIANGLES, start);
        let count = self.positions.len() as u64;
        place
            .rule("SPEC 7.1: corners are vertex indices")
            .broken(Datum::Below(count), vertex)
    }

    /// The error for an index beyond a section's end.
    #[cold]
    pub(crate) fn out_of_range(
        &self,
        kind: SectionKind,
        index: usize,
        len: usize,
        element_bytes: usize,
    ) -> FormatError {
        let rule = match kind {
            SectionKind::NODES => "SPEC 6.8: a child is a node of the file",
            SectionKind::ROWS => "SPEC 6.3: a node's rows lie inside ROWS",
            SectionKind::MODE_LISTS => "SPEC 6.7: mode lists lie inside LIST",
            SectionKind::TRIANGLES => "SPEC 6.3: slots lie inside TRIS",
            SectionKind::TRIANGLE_SLOTS => TRIANGLE_BELOW,
            SectionKind::POSITIONS => VERTEX_BELOW,
            SectionKind::INFLUENCE_STARTS => {
                "SPEC 7.7: the influences of a vertex lie inside INFL, their bones inside BONE"
            }
            SectionKind::BONE_LIST_STARTS => {
                "SPEC 6.10: the bones of a node lie inside BLST, their rows inside BROW"
            }
            SectionKind::BONE_LISTS => "SPEC 6.10: the bones of a node are bones of the file",
            _ => "SPEC 7.3: a displacement is one of a vertex and a mode of the file",
        };
        let place = self.at(kind, index.saturating_mul(element_bytes));
        place.rule(rule).broken(Datum::Below(len as u64), index)
    }
}
