//! Two trees of tinybvh against each other: both children of both nodes at once.

use bdtree_runtime::PairContact;

use super::TinyBvh;
use crate::leaf;
use crate::peers::PairPeer;

impl PairPeer for TinyBvh {
    fn pair(&mut self, other: &mut Self, found: &mut Vec<PairContact>) {
        self.pairs.clear();
        self.pairs.push((0, 0));
        while let Some((i, j)) = self.pairs.pop() {
            let (a, b) = (self.nodes[i as usize], other.nodes[j as usize]);
            if !a.meets(b.low(), b.high()) {
                continue;
            }
            let (first_a, first_b) = (a.first() as u32, b.first() as u32);
            match (a.count(), b.count()) {
                (0, 0) => {
                    for k in 0..4 {
                        self.pairs.push((first_a + (k >> 1), first_b + (k & 1)));
                    }
                }
                (0, _) => self.pairs.extend([(first_a, j), (first_a + 1, j)]),
                (_, 0) => self.pairs.extend([(i, first_b), (i, first_b + 1)]),
                (count_a, count_b) => {
                    for k in a.first()..a.first() + count_a {
                        let one = self.vertices.exact(self.corners[k]);
                        for l in b.first()..b.first() + count_b {
                            let two = other.vertices.exact(other.corners[l]);
                            leaf::pair((self.ids[k], &one), (other.ids[l], &two), found);
                        }
                    }
                }
            }
        }
    }
}
