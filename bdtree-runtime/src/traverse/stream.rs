//! Many questions at one refined pose: while one waits for memory, others go on.

use core::marker::PhantomData;

use super::StackEntry;
use super::leaves::Near;
use super::refined::{RefinedTree, RefinedWalk, visit};
use super::visitor::{Visitor, Walk};
use crate::error::QueryError;
use crate::simd::{Lanes, Work};

/// Questions that are under way together: more hide no more of the waiting (docs/measured/benchmarks.md, refined poses).
pub(crate) const STREAM: usize = 8;

/// Who asks, and is told the answers.
pub(crate) trait Questions<V> {
    /// The next one and its number; `None` after the last.
    ///
    /// # Errors
    /// One that cannot be asked.
    fn next(&mut self) -> Result<Option<(usize, V)>, QueryError>;

    /// This one has come to its end.
    fn answered(&mut self, number: usize, visitor: &V);
}

/// Answers all questions, in stacks for one or several; the visitor is ordered and takes triangles one by one. The first
/// error ends it, after the questions before it are answered.
pub(crate) fn stream<V: Visitor, Q: Questions<V>>(
    tree: RefinedTree<'_>,
    stack: &mut [StackEntry],
    questions: &mut Q,
) -> Result<Walk, QueryError> {
    let needed = tree.pose.asset.stack_len();
    let found = stack.len();
    if found < needed {
        return Err(QueryError::Memory { needed, found });
    }
    tree.pose.asset.kernel.run(Stream {
        tree,
        stack,
        questions,
        of: PhantomData,
    })
}

struct Stream<'w, V, Q> {
    tree: RefinedTree<'w>,
    stack: &'w mut [StackEntry],
    questions: &'w mut Q,
    of: PhantomData<V>,
}

/// A question under way.
struct UnderWay<V> {
    number: usize,
    visitor: V,
    /// Entries of its stack.
    len: usize,
    walk: Walk,
}

impl<V> UnderWay<V> {
    #[inline(always)]
    fn new((number, visitor): (usize, V), stack: &mut [StackEntry]) -> Self {
        stack[0] = StackEntry {
            key: f32::NEG_INFINITY,
            ..StackEntry::default()
        };
        Self {
            number,
            visitor,
            len: 1,
            walk: Walk::default(),
        }
    }
}

impl<V: Visitor, Q: Questions<V>> Work for Stream<'_, V, Q> {
    type Output = Result<Walk, QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Self {
            tree,
            stack,
            questions,
            ..
        } = self;
        let mut all = Walk::default();
        if L::IS_COMPACT {
            // One after the other, with the code of single ones.
            while let Some((number, mut visitor)) = questions.next()? {
                let walk = RefinedWalk {
                    tree,
                    stack: &mut *stack,
                    visitor: &mut visitor,
                };
                all.add(&walk.run::<L>()?);
                questions.answered(number, &visitor);
            }
            return Ok(all);
        }
        let mut error = None;
        let mut next = |questions: &mut Q| {
            if error.is_some() {
                return None;
            }
            match questions.next() {
                Ok(next) => next,
                Err(found) => {
                    error = Some(found);
                    None
                }
            }
        };
        let each = tree.pose.asset.stack_len();
        let mut stacks = stack.chunks_exact_mut(each);
        let mut under_way: [Option<(UnderWay<V>, &mut [StackEntry])>; STREAM] =
            [const { None }; STREAM];
        let mut count = 0;
        for slot in &mut under_way {
            let Some(stack) = stacks.next() else {
                break;
            };
            let Some(question) = next(questions) else {
                break;
            };
            *slot = Some((UnderWay::new(question, stack), stack));
            count += 1;
        }
        let mut turn = 0;
        while count > 0 {
            if turn >= count {
                turn = 0;
            }
            let Some((one, stack)) = &mut under_way[turn & (STREAM - 1)] else {
                break; // the first `count` are there
            };
            if !go_on::<L, V>(tree, one, stack)? {
                turn += 1;
                continue;
            }
            all.add(&one.walk);
            questions.answered(one.number, &one.visitor);
            match next(questions) {
                Some(question) => {
                    *one = UnderWay::new(question, stack);
                    turn += 1;
                }
                None => {
                    count -= 1;
                    under_way.swap(turn, count);
                }
            }
        }
        match error {
            Some(error) => Err(error),
            None => Ok(all),
        }
    }
}

/// One visit of a question; whether it has come to its end.
#[inline(always)]
fn go_on<L: Lanes, V: Visitor>(
    tree: RefinedTree<'_>,
    one: &mut UnderWay<V>,
    stack: &mut [StackEntry],
) -> Result<bool, QueryError> {
    let UnderWay {
        visitor, len, walk, ..
    } = one;
    while *len > 0 {
        *len -= 1;
        let StackEntry { at, key } = stack[*len];
        if !visitor.wanted(key) {
            continue;
        }
        let near = &mut Near::default();
        let flow = visit::<L, V>(tree, at, stack, len, near, visitor, walk)?;
        return Ok(flow.is_break() || *len == 0);
    }
    Ok(true)
}
