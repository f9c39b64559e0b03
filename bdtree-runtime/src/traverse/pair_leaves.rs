//! Pairs of leaves: four triangles against four.

use core::ops::ControlFlow;

use super::pair_side::{KeptFour, Side};
use super::pair_stack::FrontSlot;
use super::visitor::PairVisitor;
use crate::cache::CHUNK;
use crate::contact::TriangleId;
use crate::error::QueryError;
use crate::simd::{Lanes, Work};

/// [`leaves`] as work of its own.
struct LeavesWork<'l, 's> {
    a: &'l mut Side<'s>,
    b: &'l mut Side<'s>,
    pairs: &'l [FrontSlot],
    tests_left: &'l mut u64,
    visitor: &'l mut (dyn PairVisitor + 'l),
}

impl Work for LeavesWork<'_, '_> {
    type Output = Result<ControlFlow<()>, QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        leaves::<L>(self.a, self.b, self.pairs, self.tests_left, self.visitor)
    }
}

#[inline(always)]
pub(super) fn run_leaves<'s>(
    a: &mut Side<'s>,
    b: &mut Side<'s>,
    pairs: &[FrontSlot],
    tests_left: &mut u64,
    visitor: &mut dyn PairVisitor,
) -> Result<ControlFlow<()>, QueryError> {
    let kernel = a.asset.kernel;
    kernel.run(LeavesWork {
        a,
        b,
        pairs,
        tests_left,
        visitor,
    })
}

/// Tests the triangles of pairs of leaf lanes, as long as `tests_left` lasts.
#[inline(always)]
fn leaves<L: Lanes>(
    a: &mut Side<'_>,
    b: &mut Side<'_>,
    pairs: &[FrontSlot],
    tests_left: &mut u64,
    visitor: &mut dyn PairVisitor,
) -> Result<ControlFlow<()>, QueryError> {
    let tolerance = visitor.tolerance();
    for FrontSlot {
        a: leaf_a,
        b: leaf_b,
    } in pairs
    {
        let tests = u64::from(leaf_a.triangles) * u64::from(leaf_b.triangles);
        let Some(fewer) = tests_left.checked_sub(tests) else {
            return Err(a.asset.endless(*tests_left).into());
        };
        *tests_left = fewer;
        let mut rest_a = a.asset.leaf(*leaf_a)?;
        let mut start_a = leaf_a.start as usize;
        while !rest_a.is_empty() {
            let four_a = a.four::<L>(start_a, rest_a)?;
            let mut rest_b = b.asset.leaf(*leaf_b)?;
            let mut start_b = leaf_b.start as usize;
            while !rest_b.is_empty() {
                let four_b = b.four::<L>(start_b, rest_b)?;
                if test_fours::<L>(four_a, four_b, tolerance, visitor).is_break() {
                    return Ok(ControlFlow::Break(()));
                }
                start_b += CHUNK;
                rest_b = rest_b.get(CHUNK..).unwrap_or_default();
            }
            start_a += CHUNK;
            rest_a = rest_a.get(CHUNK..).unwrap_or_default();
        }
    }
    Ok(ControlFlow::Continue(()))
}

/// Hands on those of four times four pairs that may be an answer.
#[inline(always)]
fn test_fours<L: Lanes>(
    a: &KeptFour,
    b: &KeptFour,
    tolerance: f64,
    visitor: &mut dyn PairVisitor,
) -> ControlFlow<()> {
    let (mut rows, mut used_b) = (!(u8::MAX << a.len), !(u8::MAX << b.len));
    if tolerance == 0.0 {
        used_b &= b.world.meeting::<L::Quad>(&a.world);
        if used_b == 0 {
            return ControlFlow::Continue(());
        }
        rows &= a.world.meeting::<L::Quad>(&b.world);
    }
    while rows != 0 {
        let i = rows.trailing_zeros() as usize & (CHUNK - 1);
        rows &= rows - 1;
        let mut left = used_b
            & if tolerance > 0.0 {
                a.world.near::<L::Quad>(i, &b.world, tolerance)
            } else {
                a.world.touching::<L::Quad>(i, &b.world)
            };
        if left == 0 {
            continue;
        }
        let corners_a = a.world.triangle(i);
        while left != 0 {
            let j = left.trailing_zeros() as usize & (CHUNK - 1);
            left &= left - 1;
            let ids = [TriangleId(a.ids[i]), TriangleId(b.ids[j])];
            visitor.triangles(ids, [&corners_a, &b.world.triangle(j)])?;
        }
    }
    ControlFlow::Continue(())
}
