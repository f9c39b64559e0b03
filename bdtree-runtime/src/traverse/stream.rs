//! Many questions at one refined pose: while one waits for memory, others go on.

use core::marker::PhantomData;

use super::StackEntry;
use super::leaves::Near;
use super::refined::{Mixed, RefinedTree, RefinedWalk, visit};
use super::unrefined::{Nothing, Rest};
use super::visitor::{Visitor, Walk};
use super::wide_stack::WideStack;
use crate::error::QueryError;
use crate::simd::{Lanes, Work};

/// Questions that are under way together: more hide no more of the waiting (docs/measured/benchmarks.md, refined poses).
pub(crate) const STREAM: usize = 8;

/// Who asks, and is told the answers.
pub(crate) trait Questions<V> {
    /// Makes the visitor that of the next question, and returns its number; `None` after the last.
    ///
    /// # Errors
    /// One that cannot be asked.
    fn next(&mut self, visitor: &mut V) -> Result<Option<usize>, QueryError>;

    /// This one has come to its end.
    fn answered(&mut self, number: usize, visitor: &V);
}

/// Answers all questions, in stacks for one or several; the visitor is ordered and takes triangles one by one. The first
/// error ends it, after the questions before it are answered.
pub(crate) fn stream<V: Visitor + Default, Q: Questions<V>>(
    Mixed { tree, rest }: Mixed<'_>,
    stack: &mut [StackEntry],
    questions: &mut Q,
) -> Result<Walk, QueryError> {
    let needed = tree.pose.asset.stack_len();
    let found = stack.len();
    if found < needed {
        return Err(QueryError::Memory { needed, found });
    }
    let kernel = tree.pose.asset.kernel;
    let of = PhantomData;
    let walk = match rest {
        None => kernel.run(Stream {
            tree,
            rest: &mut Nothing,
            stack,
            questions,
            of,
        }),
        Some(mut rest) => kernel.run(Stream {
            tree,
            rest: &mut rest,
            stack,
            questions,
            of,
        }),
    };
    walk.map(Walk::of_boxes::<V>)
}

struct Stream<'w, V, Q, R> {
    tree: RefinedTree<'w>,
    rest: &'w mut R,
    stack: &'w mut [StackEntry],
    questions: &'w mut Q,
    of: PhantomData<V>,
}

/// A question under way, or none yet.
struct UnderWay<'s, V> {
    number: Option<usize>,
    visitor: V,
    stack: WideStack<'s>,
    walk: Walk,
}

impl<V: Visitor + Default, Q: Questions<V>, R: Rest> Work for Stream<'_, V, Q, R> {
    type Output = Result<Walk, QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Self {
            tree,
            rest,
            stack,
            questions,
            ..
        } = self;
        let mut all = Walk::default();
        if L::IS_COMPACT {
            // One after the other, with the code of single ones.
            let mut visitor = V::default();
            while let Some(number) = questions.next(&mut visitor)? {
                let walk = RefinedWalk {
                    tree,
                    rest: &mut *rest,
                    stack: &mut *stack,
                    visitor: &mut visitor,
                };
                all.add(&walk.run::<L>()?);
                questions.answered(number, &visitor);
            }
            return Ok(all);
        }
        let mut stacks = stack.chunks_exact_mut(tree.pose.asset.stack_len());
        let mut count = stacks.len().min(STREAM);
        let mut under_way: [UnderWay<'_, V>; STREAM] = core::array::from_fn(|_| UnderWay {
            number: None,
            visitor: V::default(),
            stack: WideStack::new(stacks.next().unwrap_or_default()),
            walk: Walk::default(),
        });
        let mut error = None;
        let mut turn = 0;
        while count > 0 {
            if turn >= count {
                turn = 0;
            }
            let one = &mut under_way[turn & (STREAM - 1)];
            if one.number.is_some() && !go_on::<L, V, R>(tree, rest, one)? {
                turn += 1;
                continue;
            }
            if let Some(number) = one.number {
                all.add(&one.walk);
                questions.answered(number, &one.visitor);
            }
            // Here alone, so that it is compiled once.
            one.number = match &error {
                None => questions.next(&mut one.visitor).unwrap_or_else(|found| {
                    error = Some(found);
                    None
                }),
                Some(_) => None,
            };
            if one.number.is_some() {
                one.walk = Walk::default();
                one.stack.restart();
                turn += 1;
            } else {
                count -= 1;
                under_way.swap(turn & (STREAM - 1), count & (STREAM - 1));
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
fn go_on<L: Lanes, V: Visitor, R: Rest>(
    tree: RefinedTree<'_>,
    rest: &mut R,
    one: &mut UnderWay<'_, V>,
) -> Result<bool, QueryError> {
    let UnderWay {
        visitor,
        stack,
        walk,
        ..
    } = one;
    let Some(at) = stack.pop(|key| visitor.wanted(key)) else {
        return Ok(true);
    };
    let near = &mut Near::default();
    Ok(visit::<L, V, R>(tree, rest, at, stack, near, visitor, walk)?.is_break())
}
