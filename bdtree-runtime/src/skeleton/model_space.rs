//! From transforms of nodes to their parents to matrices in the model's space.

use bdtree_format::{NO_PARENT, SkeletonNode};

use super::LocalTransform;
use super::rotation::{rows, side_by_side};
use crate::joint::JointMatrix;
use crate::simd::{Lanes, Quad, Work, four_of};

/// Sets `nodes` to parents' matrices times local ones. The first node whose parent stands behind it is an error.
///
/// The same bits as [`LocalTransform::to_matrix`] and [`joint::compose`](crate::joint::compose).
pub(super) struct ModelSpace<'a> {
    pub(super) records: &'a [SkeletonNode],
    pub(super) locals: &'a [LocalTransform],
    pub(super) nodes: &'a mut [JointMatrix],
}

impl Work for ModelSpace<'_> {
    type Output = Result<(), usize>;

    /// The matrices of four nodes are made side by side; of products the elements of a row are.
    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let mut first = 0;
        let count = self.records.len().min(self.locals.len());
        while let Some(four) = four_of(count, first) {
            let turns = turns::<L::Quad>(self.locals, four);
            for (k, turn) in turns.into_iter().enumerate().take(count - first) {
                let i = first + k;
                let own = match &self.locals[i] {
                    LocalTransform::Matrix(rows) => loaded(rows),
                    LocalTransform::Parts {
                        translation: t,
                        scale: [x, y, z],
                        ..
                    } => {
                        let scale = L::Quad::load(&[*x, *y, *z, 0.0]);
                        [
                            turn[0].mul(scale).with_last(t[0]),
                            turn[1].mul(scale).with_last(t[1]),
                            turn[2].mul(scale).with_last(t[2]),
                        ]
                    }
                };
                let parent = self.records[i].parent;
                let (before, rest) = self.nodes.split_at_mut(i);
                let Some(placed) = rest.first_mut() else {
                    return Ok(()); // lengths have been compared
                };
                if parent == NO_PARENT {
                    store(own, placed);
                } else {
                    let Some(parent) = before.get(parent as usize) else {
                        return Err(i);
                    };
                    store(composed(parent, own), placed);
                }
            }
            first += 4;
        }
        Ok(())
    }
}

/// Rows of the rotations of four nodes, of each row three elements and 0.
#[inline(always)]
fn turns<Q: Quad>(locals: &[LocalTransform], four: [usize; 4]) -> [[Q; 3]; 4] {
    let mut quaternions = [[0.0, 0.0, 0.0, 1.0]; 4];
    for k in 0..4 {
        if let LocalTransform::Parts { rotation, .. } = &locals[four[k]] {
            quaternions[k] = *rotation;
        }
    }
    let rows = rows(side_by_side::<Q>(&quaternions));
    let mut turns = [[Q::splat(0.0); 3]; 4];
    for r in 0..3 {
        let [x, y, z] = rows[r];
        let of_node = Q::transposed([x, y, z, Q::splat(0.0)]);
        for k in 0..4 {
            turns[k][r] = of_node[k];
        }
    }
    turns
}

/// [`joint::compose`](crate::joint::compose).
#[inline(always)]
fn composed<Q: Quad>(outer: &JointMatrix, [a, b, c]: [Q; 3]) -> [Q; 3] {
    let mut product = [a; 3];
    for r in 0..3 {
        let [x, y, z, shift] = outer[r];
        let row = Q::splat(x).mul(a).add(Q::splat(y).mul(b));
        let row = row.add(Q::splat(z).mul(c));
        // Adding −0 changes no bit.
        product[r] = row.add(Q::splat(-0.0).with_last(shift));
    }
    product
}

#[inline(always)]
fn loaded<Q: Quad>(rows: &JointMatrix) -> [Q; 3] {
    [Q::load(&rows[0]), Q::load(&rows[1]), Q::load(&rows[2])]
}

#[inline(always)]
fn store<Q: Quad>(rows: [Q; 3], out: &mut JointMatrix) {
    for r in 0..3 {
        out[r] = rows[r].store();
    }
}
