//! What walks ask and what they tell.

use bdtree_format::{LANES, Row};
use core::ops::ControlFlow;

use super::pair_stack::FrontSlot;
use crate::bound::WideSpheres;
use crate::contact::{LaneId, TriangleId};
use crate::narrow::Triangle;
use crate::placement::Placement;
use crate::refined::Boxes;
use crate::simd::{Lanes, Quad};

/// A question about one deformed mesh.
pub(crate) trait Visitor {
    /// Whether nearer lanes are to be visited first (by `keys`).
    const ORDERED: bool;

    /// Whether it stands for any other ([`super::shared`]).
    const IS_SHARED: bool = false;

    /// Whether [`Visitor::boxes`] says anything; others ask for spheres around the boxes of a refined pose.
    const HAS_BOXES: bool = false;

    /// What visiting a node's boxes saves against its spheres, in the unit of [`Walk::gain`] (measured: docs/measured/benchmarks.md,
    /// refined poses).
    const NODE_GAIN: u64 = 4;

    /// Four times the ratio of what spheres would have gained ([`Walk::gain`]) to what boxes, which are tighter, gain; measured.
    const OF_SPHERES: u8 = 6;

    /// The lanes that may hold an answer, and, when ordered, a lower bound for each of what the
    /// question minimises. Anything not proved useless is kept, NaN included.
    fn lanes<L: Lanes>(&self, spheres: WideSpheres<L>, keys: &mut Row) -> u8;

    /// [`Visitor::lanes`] for exact boxes.
    #[inline(always)]
    fn boxes<L: Lanes>(&self, _boxes: &Boxes, keys: &mut Row) -> u8 {
        *keys = [f32::NEG_INFINITY; LANES];
        u8::MAX
    }

    /// Above this no key is an answer.
    #[inline(always)]
    fn bound(&self) -> f32 {
        f32::INFINITY
    }

    /// Whether a subtree with this lower bound may still hold an answer.
    #[inline(always)]
    fn wanted(&self, key: f32) -> bool {
        let beyond = key > self.bound();
        !beyond
    }

    /// Whether a triangle with these corners (stored units) certainly is no answer: a cheap test
    /// that spares the exact one.
    #[inline(always)]
    fn misses(&self, _corners: &[[f32; 3]; 3]) -> bool {
        false
    }

    /// Whether triangles are taken four at a time, by [`Visitor::fours`].
    const IN_FOURS: bool = false;

    /// [`Visitor::misses`] for four (of each corner, of each coordinate, that of the four).
    #[inline(always)]
    fn misses_four<Q: Quad>(&self, _corners: &[[[f32; 4]; 3]; 3]) -> u8 {
        0
    }

    /// Takes up to eight triangles, as [`Visitor::triangle`] would one after the other.
    #[inline(always)]
    fn fours<Q: Quad>(&mut self, frame: &Placement, fours: &[Four; 2]) -> ControlFlow<()> {
        for four in fours {
            for k in 0..four.len {
                self.triangle(TriangleId(four.ids[k]), &four.world(frame, k))?;
            }
        }
        ControlFlow::Continue(())
    }

    /// Takes a triangle's world corners; `Break` ends the traversal.
    fn triangle(&mut self, id: TriangleId, corners: &Triangle) -> ControlFlow<()>;
}

/// A question about pairs of triangles of two deformed meshes.
pub(crate) trait PairVisitor {
    /// Farther apart, triangles are no answer (world units).
    fn tolerance(&self) -> f64;

    /// Told of the pairs of leaves whose spheres meet.
    fn meet(&mut self, _leaves: &[FrontSlot]) {}

    /// Takes the world corners of two triangles that may be an answer; `Break` ends the traversal.
    fn triangles(&mut self, ids: [TriangleId; 2], corners: [&Triangle; 2]) -> ControlFlow<()>;

    /// Where the first ends at spheres and the second at triangles: farther from a sphere, a triangle is no answer (world
    /// units, what rounding takes included).
    fn sphere_tolerance(&self) -> f64 {
        0.0
    }

    /// Takes a lane of the first and a triangle of the second that is near its sphere; `Break` ends the traversal.
    fn lane_triangle(&mut self, _: LaneId, _: TriangleId) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Triangles that wait for being tested together.
#[derive(Default)]
pub(crate) struct Four {
    pub(crate) ids: [u32; 4],
    /// Stored units: of each corner, of each coordinate, that of the four.
    pub(crate) corners: [[[f32; 4]; 3]; 3],
    /// How many there are.
    pub(crate) len: usize,
}

impl Four {
    /// Adds a triangle; there must be room.
    #[inline(always)]
    pub(super) fn push(&mut self, id: u32, corners: &[[f32; 3]; 3]) {
        let k = self.len & 3;
        self.ids[k] = id;
        for i in 0..3 {
            for axis in 0..3 {
                self.corners[i][axis][k] = corners[i][axis];
            }
        }
        self.len = k + 1;
    }

    /// The world corners of triangle `k`.
    #[inline(always)]
    pub(crate) fn world(&self, frame: &Placement, k: usize) -> Triangle {
        world(frame, &stored(&self.corners, k))
    }
}

/// The corners of the k-th of four triangles.
#[inline(always)]
fn stored(four: &[[[f32; 4]; 3]; 3], k: usize) -> [[f32; 3]; 3] {
    let mut corners = [[0.0; 3]; 3];
    for i in 0..3 {
        for axis in 0..3 {
            corners[i][axis] = four[i][axis][k & 3];
        }
    }
    corners
}

#[inline(always)]
pub(super) fn world(frame: &Placement, [a, b, c]: &[[f32; 3]; 3]) -> Triangle {
    [frame.world(*a), frame.world(*b), frame.world(*c)]
}

/// What a traversal did.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Walk {
    pub(crate) nodes_visited: u64,
    /// Of them, those whose spheres were evaluated.
    pub(crate) nodes_updated: u64,
    /// Triangles of visited leaves; walks of one tree that come to their end count them.
    pub(crate) triangles: u64,
    /// What the walk would have saved on a refined pose, preparing not counted, in what a triangle of a visited leaf saves: some
    /// 15 ns. Walks of one tree know it; of pairs, each side is told.
    pub(crate) gain: u64,
    /// [`Visitor::OF_SPHERES`], if it has asked boxes, else 0.
    pub(crate) of_spheres: u8,
    /// The visitor broke off.
    pub(crate) stopped: bool,
}

impl Walk {
    /// That of a visitor, with what it would have saved.
    #[inline(always)]
    pub(super) fn of<V: Visitor>(self) -> Self {
        let of_nodes = self.nodes_visited.saturating_mul(V::NODE_GAIN);
        let gain = of_nodes.saturating_add(self.triangles);
        Self { gain, ..self }
    }

    /// The same of one that has asked boxes.
    #[inline(always)]
    pub(super) fn of_boxes<V: Visitor>(self) -> Self {
        let walk = self.of::<V>();
        Self {
            of_spheres: V::OF_SPHERES,
            ..walk
        }
    }

    /// Adds another one, which came after.
    pub(crate) fn add(&mut self, other: &Self) {
        self.nodes_visited += other.nodes_visited;
        self.nodes_updated += other.nodes_updated;
        self.triangles += other.triangles;
        self.gain += other.gain;
        self.of_spheres = self.of_spheres.max(other.of_spheres);
        self.stopped |= other.stopped;
    }
}
