//! What queries report, and where they put it. The words are parry's.

use core::ops::ControlFlow;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// A vertex: its number among the source's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct VertexId(pub u32);

/// A triangle: its number among the source's.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    FromBytes,
    IntoBytes,
    KnownLayout,
    Immutable,
)]
#[repr(transparent)]
pub struct TriangleId(pub u32);

/// A primitive touches a triangle. World coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// The triangle.
    pub triangle: TriangleId,
    /// The triangle's point.
    pub point: [f64; 3],
    /// Unit normal, from the triangle towards the primitive.
    pub normal: [f64; 3],
    /// Signed distance: negative is penetration depth. To separate the two at `point`, move the mesh by
    /// `distance · normal`, or the shape the opposite way.
    pub distance: f64,
    /// Weights of the corners that give `point`; not negative, sum 1.
    pub barycentric: [f64; 3],
}

impl Contact {
    /// A value to fill buffers with.
    pub const EMPTY: Self = Self {
        triangle: TriangleId(u32::MAX),
        point: [0.0; 3],
        normal: [0.0; 3],
        distance: 0.0,
        barycentric: [0.0; 3],
    };
}

/// Two triangles that touch, or are within the tolerance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TrianglePair {
    /// The first asset's triangle.
    pub triangle1: TriangleId,
    /// The second asset's triangle.
    pub triangle2: TriangleId,
}

impl TrianglePair {
    /// A value to fill buffers with.
    pub const EMPTY: Self = Self {
        triangle1: TriangleId(u32::MAX),
        triangle2: TriangleId(u32::MAX),
    };
}

/// A sphere of the first asset and a triangle of the second that is within the tolerance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LaneTriangle {
    /// The first asset's lane, whose sphere it is.
    pub lane: LaneId,
    /// The second asset's triangle.
    pub triangle: TriangleId,
}

impl LaneTriangle {
    /// A value to fill buffers with.
    pub const EMPTY: Self = Self {
        lane: LaneId::EMPTY,
        triangle: TriangleId(u32::MAX),
    };
}

/// Two triangles touch, or are within the tolerance. World coordinates.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub struct PairContact {
    /// The first asset's triangle.
    pub triangle1: TriangleId,
    /// The second asset's triangle.
    pub triangle2: TriangleId,
    /// The first triangle's point.
    pub point1: [f64; 3],
    /// The second triangle's point; equal to `point1` when they touch.
    pub point2: [f64; 3],
    /// Unit, at `point1`: towards `point2`; where the triangles touch, the first triangle's own normal.
    pub normal1: [f64; 3],
    /// Unit, at `point2`: towards `point1`; where the triangles touch, the second triangle's own normal.
    pub normal2: [f64; 3],
    /// 0 when they touch.
    pub distance: f64,
    /// Weights of the first triangle's corners that give `point1`.
    pub barycentric1: [f64; 3],
    /// Weights of the second triangle's corners that give `point2`.
    pub barycentric2: [f64; 3],
}

impl PairContact {
    /// A value to fill buffers with.
    pub const EMPTY: Self = Self {
        triangle1: TriangleId(u32::MAX),
        triangle2: TriangleId(u32::MAX),
        point1: [0.0; 3],
        point2: [0.0; 3],
        normal1: [0.0; 3],
        normal2: [0.0; 3],
        distance: 0.0,
        barycentric1: [0.0; 3],
        barycentric2: [0.0; 3],
    };
}

/// The point of a deformed mesh nearest to a given one. World coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointProjection {
    /// The triangle; the lowest id of those at the same distance.
    pub triangle: TriangleId,
    /// Its point.
    pub point: [f64; 3],
    /// Unit normal, from `point` towards the given point; the triangle's own where they coincide.
    pub normal: [f64; 3],
    /// Distance to the given point.
    pub distance: f64,
    /// Weights of the corners that give `point`.
    pub barycentric: [f64; 3],
}

/// Where a ray meets a triangle. World coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayIntersection {
    /// The triangle; the lowest id of those at the same distance.
    pub triangle: TriangleId,
    /// The point.
    pub point: [f64; 3],
    /// Unit normal of the triangle, on the side that the ray comes from.
    pub normal: [f64; 3],
    /// Distance from the ray's origin.
    pub distance: f64,
    /// Weights of the corners that give `point`.
    pub barycentric: [f64; 3],
}

/// Whether the sink had room for everything that a query found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coverage {
    /// Everything that was found is in the sink.
    Complete,
    /// The sink filled up: what it took is part of the answer.
    Truncated,
}

impl Coverage {
    /// Of a query that the sink stopped, or not.
    pub(crate) fn of(stopped: bool) -> Self {
        if stopped {
            Self::Truncated
        } else {
            Self::Complete
        }
    }
}

/// A lane of a node: one of its eight children.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LaneId {
    /// The node: its place in [`Asset::nodes`](crate::Asset::nodes).
    pub node: u32,
    /// The lane, below 8.
    pub lane: u8,
}

impl LaneId {
    /// A value to fill buffers with.
    pub const EMPTY: Self = Self {
        node: u32::MAX,
        lane: 0,
    };
}

/// A sphere of a query that ends at a level ([`Query::max_level`](crate::Query::max_level)): it holds the deformed
/// triangles below a lane of the level at which the query stopped. World coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Proxy {
    /// The lane.
    pub lane: LaneId,
    /// Its center.
    pub center: [f64; 3],
    /// Its radius.
    pub radius: f64,
}

impl Proxy {
    /// A value to fill buffers with.
    pub const EMPTY: Self = Self {
        lane: LaneId::EMPTY,
        center: [0.0; 3],
        radius: 0.0,
    };
}

/// Takes what a query finds. Sinks append: clear them yourself.
///
/// Items come in the order of the traversal, which is the same on every run and with every
/// [`Kernel`](crate::Kernel); sort by id where order matters.
pub trait Sink<T> {
    /// Takes one item, or returns `Break` without taking it when there is no room: the query
    /// then stops and returns [`Coverage::Truncated`].
    fn push(&mut self, item: T) -> ControlFlow<()>;
}

/// A sink over a caller's slice.
#[derive(Debug)]
pub struct SliceSink<'s, T> {
    slots: &'s mut [T],
    len: usize,
}

impl<'s, T> SliceSink<'s, T> {
    /// An empty sink with room for `slots.len()` items; what the slots hold is overwritten.
    pub fn new(slots: &'s mut [T]) -> Self {
        Self { slots, len: 0 }
    }

    /// The items taken so far.
    pub fn items(&self) -> &[T] {
        &self.slots[..self.len]
    }

    /// The items taken so far, to sort or change in place.
    pub fn items_mut(&mut self) -> &mut [T] {
        &mut self.slots[..self.len]
    }

    /// Forgets the items.
    pub fn clear(&mut self) {
        self.len = 0;
    }
}

impl<T> Sink<T> for SliceSink<'_, T> {
    fn push(&mut self, item: T) -> ControlFlow<()> {
        match self.slots.get_mut(self.len) {
            Some(slot) => {
                *slot = item;
                self.len += 1;
                ControlFlow::Continue(())
            }
            None => ControlFlow::Break(()),
        }
    }
}

#[cfg(feature = "alloc")]
impl<T> Sink<T> for alloc::vec::Vec<T> {
    fn push(&mut self, item: T) -> ControlFlow<()> {
        self.push(item);
        ControlFlow::Continue(())
    }
}
