//! Visitors behind a table of functions: where lanes are compact ([`Lanes::IS_COMPACT`]), all walks of one tree share one
//! copy of their code. Answers are the same to the bit.

use bdtree_format::Row;
use core::ops::ControlFlow;

use super::visitor::Visitor;
use crate::bound::{Spheres, WideSpheres};
use crate::contact::TriangleId;
use crate::narrow::Triangle;
use crate::refined::Boxes;
use crate::simd::{Compact, Lanes, Quad};

/// What a walk asks a visitor.
pub(super) trait Asked {
    fn lanes(&self, spheres: &Spheres, keys: &mut Row) -> u8;
    fn boxes(&self, boxes: &Boxes, keys: &mut Row) -> u8;
    fn bound(&self) -> f32;
    fn misses(&self, corners: &[[f32; 3]; 3]) -> bool;
    fn misses_four(&self, corners: &[[[f32; 4]; 3]; 3]) -> u8;
    fn triangle(&mut self, id: TriangleId, corners: &Triangle) -> ControlFlow<()>;
}

impl<V: Visitor> Asked for V {
    fn lanes(&self, spheres: &Spheres, keys: &mut Row) -> u8 {
        Visitor::lanes(self, WideSpheres::<Compact>::load(spheres), keys)
    }

    fn boxes(&self, boxes: &Boxes, keys: &mut Row) -> u8 {
        Visitor::boxes::<Compact>(self, boxes, keys)
    }

    fn bound(&self) -> f32 {
        Visitor::bound(self)
    }

    fn misses(&self, corners: &[[f32; 3]; 3]) -> bool {
        Visitor::misses(self, corners)
    }

    fn misses_four(&self, corners: &[[[f32; 4]; 3]; 3]) -> u8 {
        Visitor::misses_four::<<Compact as Lanes>::Quad>(self, corners)
    }

    fn triangle(&mut self, id: TriangleId, corners: &Triangle) -> ControlFlow<()> {
        Visitor::triangle(self, id, corners)
    }
}

/// Any visitor, ordered or not. It takes triangles one by one.
pub(super) struct Shared<'v, const ORDERED: bool>(pub(super) &'v mut (dyn Asked + 'v));

impl<const ORDERED: bool> Visitor for Shared<'_, ORDERED> {
    const ORDERED: bool = ORDERED;
    const IS_SHARED: bool = true;

    #[inline(always)]
    fn lanes<L: Lanes>(&self, spheres: WideSpheres<L>, keys: &mut Row) -> u8 {
        self.0.lanes(&spheres.store(), keys)
    }

    #[inline(always)]
    fn boxes<L: Lanes>(&self, boxes: &Boxes, keys: &mut Row) -> u8 {
        self.0.boxes(boxes, keys)
    }

    #[inline(always)]
    fn bound(&self) -> f32 {
        self.0.bound()
    }

    #[inline(always)]
    fn misses(&self, corners: &[[f32; 3]; 3]) -> bool {
        self.0.misses(corners)
    }

    #[inline(always)]
    fn misses_four<Q: Quad>(&self, corners: &[[[f32; 4]; 3]; 3]) -> u8 {
        self.0.misses_four(corners)
    }

    #[inline(always)]
    fn triangle(&mut self, id: TriangleId, corners: &Triangle) -> ControlFlow<()> {
        self.0.triangle(id, corners)
    }
}
