//! Two bodies against each other: what a bound makes the traversal do.

use bdtree_runtime::narrow::{Triangle, triangles_intersect};
use nalgebra::Vector3;

use super::bound::box_of;
use super::overlap::Relation;
use super::posed::Posed;

/// What a pair query did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PairCounts {
    /// Nodes whose bounds were evaluated, of both bodies, each once.
    pub updates: u64,
    /// Tests of one lane against the eight of a node.
    pub wide_tests: u64,
    /// Tests of two lanes.
    pub lane_tests: u64,
    /// Pairs of leaf lanes that met.
    pub leaf_pairs: u64,
    /// Pairs of triangles in them.
    pub triangle_pairs: u64,
    /// Pairs of leaf lanes whose boxes, of the vertices as deformed, meet.
    pub boxed_leaf_pairs: u64,
    /// Pairs of triangles in those of which each meets the other's leaf box.
    pub boxed_triangle_pairs: u64,
    /// Pairs of triangles in those whose own boxes meet, too.
    pub near_triangle_pairs: u64,
    /// Vertices of the leaf lanes that were reached, of both bodies, each once.
    pub vertices: u64,
    /// Pairs of triangles that share a point.
    pub contacts: u64,
}

/// Nanoseconds that counts are weighed with.
#[derive(Debug, Clone, Copy)]
pub struct Weights {
    /// Updating a node.
    pub update: f64,
    /// Testing a lane against eight.
    pub test: f64,
    /// Testing two leaf lanes' boxes.
    pub leaf_pair: f64,
    /// Deforming a vertex.
    pub vertex: f64,
    /// Testing two triangles exactly.
    pub triangle_pair: f64,
}

impl PairCounts {
    /// Nanoseconds of updates and tests of nodes.
    pub fn node_ns(&self, weights: &Weights) -> f64 {
        self.updates as f64 * weights.update + self.wide_tests as f64 * weights.test
    }

    /// Nanoseconds of everything, leaf lanes' boxes before their triangles.
    pub fn all_ns(&self, weights: &Weights) -> f64 {
        self.node_ns(weights)
            + self.leaf_pairs as f64 * weights.leaf_pair
            + self.vertices as f64 * weights.vertex
            + self.near_triangle_pairs as f64 * weights.triangle_pair
    }
}

/// How node pairs are tested.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Filter {
    /// Every lane of one node against the eight of the other.
    None,
    /// First each node's lanes against the lane that led to the other node, then what is left.
    Parent,
}

/// Walks both trees from their roots; the second body stands in the frame of the first.
pub fn pair(
    a: &mut Posed<'_>,
    b: &mut Posed<'_>,
    relation: &Relation,
    filter: Filter,
) -> PairCounts {
    walk(a, b, relation, filter, &mut Vec::new())
}

/// Corners of the pairs of triangles whose boxes meet.
pub fn near_triangles(
    a: &mut Posed<'_>,
    b: &mut Posed<'_>,
    relation: &Relation,
) -> Vec<[Triangle; 2]> {
    let mut near = Vec::new();
    walk(a, b, relation, Filter::Parent, &mut near);
    near
}

fn walk(
    a: &mut Posed<'_>,
    b: &mut Posed<'_>,
    relation: &Relation,
    filter: Filter,
    near: &mut Vec<[Triangle; 2]>,
) -> PairCounts {
    let mut counts = PairCounts::default();
    // Lanes of both bodies whose shapes meet; at the start the roots, which no lane leads to.
    let mut stack = vec![(None, None)];
    while let Some((lane_a, lane_b)) = stack.pop() {
        let leaf = |posed: &Posed<'_>, lane: Option<usize>| lane.filter(|l| posed.is_leaf(*l));
        let node = |posed: &Posed<'_>, lane: Option<usize>| lane.map_or(0, |l| posed.body.child(l));
        match (leaf(a, lane_a), leaf(b, lane_b)) {
            (Some(leaf_a), Some(leaf_b)) => leaves((a, leaf_a), (b, leaf_b), near, &mut counts),
            (Some(leaf_a), None) => {
                let node_b = node(b, lane_b);
                b.visit(node_b);
                counts.wide_tests += 1;
                for lane in b.lanes(node_b) {
                    counts.lane_tests += 1;
                    if relation.meet(a.shape(leaf_a), b.shape(lane)) {
                        stack.push((Some(leaf_a), Some(lane)));
                    }
                }
            }
            (None, Some(leaf_b)) => {
                let node_a = node(a, lane_a);
                a.visit(node_a);
                counts.wide_tests += 1;
                for lane in a.lanes(node_a) {
                    counts.lane_tests += 1;
                    if relation.meet(a.shape(lane), b.shape(leaf_b)) {
                        stack.push((Some(lane), Some(leaf_b)));
                    }
                }
            }
            (None, None) => {
                let (node_a, node_b) = (node(a, lane_a), node(b, lane_b));
                a.visit(node_a);
                b.visit(node_b);
                let mut lanes_a: Vec<usize> = a.lanes(node_a).collect();
                let mut lanes_b: Vec<usize> = b.lanes(node_b).collect();
                if let (Filter::Parent, Some(lane_a), Some(lane_b)) = (filter, lane_a, lane_b) {
                    counts.wide_tests += 2;
                    counts.lane_tests += (lanes_a.len() + lanes_b.len()) as u64;
                    lanes_a.retain(|lane| relation.meet(a.shape(*lane), b.shape(lane_b)));
                    lanes_b.retain(|lane| relation.meet(a.shape(lane_a), b.shape(*lane)));
                    if lanes_b.is_empty() {
                        continue;
                    }
                }
                for own in lanes_a {
                    counts.wide_tests += 1;
                    for other in &lanes_b {
                        counts.lane_tests += 1;
                        if relation.meet(a.shape(own), b.shape(*other)) {
                            stack.push((Some(own), Some(*other)));
                        }
                    }
                }
            }
        }
    }
    counts.updates = a.updates + b.updates;
    counts.vertices = a.reached_count() + b.reached_count();
    counts
}

fn leaves(
    (a, leaf_a): (&mut Posed<'_>, usize),
    (b, leaf_b): (&mut Posed<'_>, usize),
    near: &mut Vec<[Triangle; 2]>,
    counts: &mut PairCounts,
) {
    a.reach(leaf_a);
    b.reach(leaf_b);
    let boxed = |posed: &Posed<'_>, leaf: usize| -> Vec<(Triangle, Ends)> {
        let all = posed.triangles(leaf).into_iter();
        all.map(|t| (t, ends(t.iter()))).collect()
    };
    let (all_a, all_b) = (boxed(a, leaf_a), boxed(b, leaf_b));
    counts.leaf_pairs += 1;
    counts.triangle_pairs += (all_a.len() * all_b.len()) as u64;
    let leaf_box = |all: &[(Triangle, Ends)]| ends(all.iter().flat_map(|(t, _)| t));
    let (box_a, box_b) = (leaf_box(&all_a), leaf_box(&all_b));
    if overlap(&box_a, &box_b) {
        counts.boxed_leaf_pairs += 1;
        let within = |all: &[(Triangle, Ends)], other: &Ends| {
            all.iter().filter(|(_, own)| overlap(own, other)).count() as u64
        };
        counts.boxed_triangle_pairs += within(&all_a, &box_b) * within(&all_b, &box_a);
    }
    for (ta, own) in &all_a {
        for (tb, _) in all_b.iter().filter(|(_, other)| overlap(own, other)) {
            counts.near_triangle_pairs += 1;
            counts.contacts += u64::from(triangles_intersect(ta, tb));
            near.push([*ta, *tb]);
        }
    }
}

type Ends = [Vector3<f64>; 2];

fn ends<'p>(points: impl Iterator<Item = &'p [f64; 3]>) -> Ends {
    let points: Vec<Vector3<f64>> = points.map(|p| Vector3::from(*p)).collect();
    let cuboid = box_of(&points);
    [cuboid.centre - cuboid.half, cuboid.centre + cuboid.half]
}

/// Whether two boxes meet, with room for the rounding of their ends.
fn overlap(a: &Ends, b: &Ends) -> bool {
    const ROOM: f64 = 1e-12;
    (0..3).all(|k| a[0][k] <= b[1][k] + ROOM && b[0][k] <= a[1][k] + ROOM)
}
