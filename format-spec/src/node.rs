//! Eight-wide nodes and their rows (SPEC 6).

use core::ops::Range;

use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// Child spheres of a node, stored side by side.
pub const LANES: usize = 8;

/// One quantity of the eight child spheres, and the unit in which the row section is counted.
pub type Row = [f32; LANES];

/// One quantity of the eight child spheres for two modes: lane by lane the numbers of the two, side
/// by side, as instructions that sum products of pairs take them.
pub type PairRow = [[i16; 2]; LANES];

/// What two modes do to the eight child spheres, in 16 bits: six [`Row`]s' worth of bytes.
///
/// Numbers count a power of two that the node's lanes and modes share
/// ([`NodeRecord::scale_exponents`]), and are those of a q that reaches its limit:
/// Ū_j `q_limit`_j, ΔR_j `q_limit`_j and b±_j `q_limit`_j. Where a node's modes are odd in number,
/// the second of its last pair is zero.
#[derive(
    Debug, Clone, Copy, Default, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable,
)]
#[repr(C)]
pub struct ModePair {
    /// Ū_x, Ū_y and Ū_z.
    pub center: [PairRow; 3],
    /// ΔR, not negative.
    pub growth: PairRow,
    /// b⁺ and b⁻.
    pub cross: [PairRow; 2],
}

const _: () = assert!(size_of::<ModePair>() == ROWS_PER_PAIR * size_of::<Row>());

impl ModePair {
    /// Ū_x, Ū_y, Ū_z, ΔR, b⁺ and b⁻ of one lane for the first mode of the pair (`which` even) or
    /// the second (odd), in units.
    pub fn numbers(&self, which: usize, lane: usize) -> [i16; 6] {
        let [x, y, z] = &self.center;
        let [plus, minus] = &self.cross;
        [x, y, z, &self.growth, plus, minus].map(|row| row[lane % LANES][which % 2])
    }
}

/// A node: eight child spheres, each a *lane* that is empty, leads to a child node (inner) or
/// holds triangles (leaf). 32 bytes.
///
/// Nodes stand breadth first: the children of node i are `first_child .. first_child + popcount
/// (inner_mask)`, in lane order, and `first_child` is 1 plus the number of children of all nodes
/// before i. In the same way `first_slot` counts the triangles, and `row_start` the rows, of all
/// nodes before i.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub struct NodeRecord {
    /// Node index of the first inner lane's child.
    pub first_child: u32,
    /// Place in the triangle section of the first leaf lane's first triangle.
    pub first_slot: u32,
    /// Index of the node's first row in the row section.
    pub row_start: u32,
    /// Index of the node's first mode index in the mode-list section.
    pub mode_list_start: u32,
    /// Number of modes that act on the node, m.
    pub mode_count: u16,
    /// Bit k: lane k leads to a child node.
    pub inner_mask: u8,
    /// Bit k: lane k holds triangles.
    pub leaf_mask: u8,
    /// Number of triangles of each leaf lane, 0 for other lanes.
    pub leaf_counts: [u8; LANES],
    /// Distance from the root.
    pub level: u8,
    /// Binary exponents of the units in which the node's [`ModePair`]s count: Ū's, ΔR's and b±'s.
    pub scale_exponents: [i8; 3],
}

impl NodeRecord {
    /// The lanes that hold anything.
    pub fn lanes(&self) -> impl Iterator<Item = usize> + use<> {
        let used = self.inner_mask | self.leaf_mask;
        (0..LANES).filter(move |lane| used >> lane & 1 != 0)
    }

    /// The node that an inner lane leads to; in a file that nobody has verified there may be no such node.
    pub fn child(&self, lane: usize) -> Option<u32> {
        let bit = 1_u8 << lane;
        let before = (self.inner_mask & (bit - 1)).count_ones();
        (self.inner_mask & !self.leaf_mask & bit != 0)
            .then(|| self.first_child.saturating_add(before))
    }

    /// The triangle slots of a leaf lane; as with [`NodeRecord::child`].
    pub fn slots(&self, lane: usize) -> Range<usize> {
        let counts = self.leaf_counts.map(usize::from);
        let start = self.first_slot as usize + counts[..lane].iter().sum::<usize>();
        start..start + counts[lane]
    }
}

const _: () = assert!(size_of::<NodeRecord>() == 32);

/// Row of the centers' x (stored units), relative to the origin.
pub const ROW_CENTER_X: usize = 0;
/// Row of the centers' y.
pub const ROW_CENTER_Y: usize = 1;
/// Row of the centers' z.
pub const ROW_CENTER_Z: usize = 2;
/// Row of the rest radii R.
pub const ROW_RADIUS: usize = 3;

/// Rows before the first mode's.
pub const ROWS_LEADING: usize = 4;

/// Rows whose bytes a [`ModePair`] takes.
pub const ROWS_PER_PAIR: usize = 6;

/// Rows of a node without its modes': the four leading ones, then, behind the pairs, δR and
/// the δR of scaled steps.
pub const ROWS_FIXED: usize = 6;

/// Pairs that `mode_count` modes fill, the last one perhaps by half.
pub const fn pair_count(mode_count: usize) -> usize {
    mode_count.div_ceil(2)
}

/// First row of the k-th [`ModePair`] of a node, which holds its active modes 2 k and 2 k + 1.
pub const fn pair_row(k: usize) -> usize {
    ROWS_LEADING + ROWS_PER_PAIR * k
}

/// Number of rows of a node with `mode_count` active modes.
pub const fn row_count(mode_count: usize) -> usize {
    ROWS_FIXED + ROWS_PER_PAIR * pair_count(mode_count)
}
