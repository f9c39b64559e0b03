//! One leaf after the other trades with its neighbours.

use super::balls::{Ball, Vertices};
use super::leaf::{Leaf, Leaves, Place, Rest};
use super::{Scene, children};
use crate::vec3::{norm2, sub};

/// Nearest leaves that one deals with.
const NEIGHBOURS: usize = 8;

/// Nodes looked at to find them: enough unless the ball is that of a triangle with hundreds of smaller leaves in it,
/// or thousands of triangles lie in one place. Then some that are nearer may be missed.
const LOOKED_AT_MAX: usize = 256;

/// An exchange must lower the cost by this share: none for nothing.
const GAIN_MIN: f64 = 1e-6;

/// Share by which a lower bound of a cost may be too large: that of balls which are not quite the smallest.
const LEAST_SLACK: f64 = 1e-6;

/// Share of its squared radius by which a point on a ball's surface may seem to lie inside.
const TOUCHING: f64 = 1e-6;

/// Lanes that a node keeps: leaves are emptied only in nodes that have more.
pub(super) const LANES_MIN: u8 = 2;

/// The trade of two leaves: which triangle each gives, by its place; the number of triangles for none.
#[derive(Debug, Clone, Copy)]
struct Trade {
    given: [usize; 2],
    /// Of the leaves afterwards.
    balls: [Ball; 2],
}

/// Trades between leaves of some nodes.
pub(super) struct Dealer<'s> {
    scene: &'s Scene<'s>,
    /// Per node; empty for those that are not this one's to change.
    pub(super) leaves: Vec<Leaves>,
    vertices: Vertices,
    triangles: Vec<u32>,
    stack: Vec<u32>,
    found: Vec<(f64, Place)>,
}

impl<'s> Dealer<'s> {
    pub(super) fn new(scene: &'s Scene<'s>) -> Self {
        Self {
            scene,
            leaves: scene.nodes.iter().map(|_| Leaves::default()).collect(),
            vertices: Vertices::default(),
            triangles: Vec::new(),
            stack: Vec::new(),
            found: Vec::new(),
        }
    }

    fn leaf(&self, place: Place) -> &Leaf {
        &self.leaves[place.node as usize].list[place.leaf as usize]
    }

    fn leaf_mut(&mut self, place: Place) -> &mut Leaf {
        &mut self.leaves[place.node as usize].list[place.leaf as usize]
    }

    /// Lets the leaves of a node trade with their neighbours.
    pub(super) fn deal_node(&mut self, node: u32, pass: usize) {
        for leaf in 0..self.leaves[node as usize].list.len() as u32 {
            self.deal(Place { node, leaf }, pass);
        }
    }

    fn deal(&mut self, own: Place, pass: usize) {
        if self.leaf(own).triangles.is_empty() {
            return;
        }
        self.find_near(own);
        let found = std::mem::take(&mut self.found);
        for &(_, other) in found.iter().take(1 + NEIGHBOURS) {
            let [a, b] = [own, other].map(|place| self.leaf(place));
            let nothing_new = a.changed.max(b.changed) + 1 < pass
                || a.has_refused(other, b)
                || b.has_refused(own, a);
            if own == other || nothing_new || a.triangles.is_empty() || b.triangles.is_empty() {
                continue;
            }
            match self.best_trade(own, other) {
                Some(trade) => self.exchange(own, other, trade, pass),
                None => {
                    // It stays so: what a trade may do depends besides on the number of lanes, which only falls.
                    let changes = self.leaf(other).changes;
                    self.leaf_mut(own).refused.push((other, changes));
                }
            }
        }
        self.found = found;
    }

    fn exchange(&mut self, a: Place, b: Place, trade: Trade, pass: usize) {
        let [i, j] = trade.given;
        let mut after = [Vec::new(), Vec::new()];
        let [own, other] = [a, b].map(|place| self.leaf(place));
        own.put_after(i, other.triangles.get(j), &mut after[0]);
        other.put_after(j, own.triangles.get(i), &mut after[1]);
        for ((place, triangles), ball) in [a, b].into_iter().zip(after).zip(trade.balls) {
            self.leaves[place.node as usize].lanes -= u8::from(triangles.is_empty());
            self.leaf_mut(place).change(triangles, ball, pass);
        }
    }

    /// Finds the leaves nearest to one, itself included, among those whose balls meet its, nearest first.
    fn find_near(&mut self, own: Place) {
        let ball = self.leaf(own).ball;
        self.found.clear();
        self.stack.clear();
        self.stack.push(0);
        let mut looked_at = 0;
        while let Some(node) = self.stack.pop() {
            let record = &self.scene.tree.nodes[node as usize];
            for child in children(record) {
                if ball.meets(&self.scene.nodes[child as usize].ball) {
                    self.stack.push(child);
                }
            }
            for (leaf, other) in (0..).zip(&self.leaves[node as usize].list) {
                if !other.triangles.is_empty() && ball.meets(&other.ball) {
                    let apart = norm2(sub(ball.center, other.ball.center));
                    self.found.push((apart, Place { node, leaf }));
                }
            }
            looked_at += 1;
            if looked_at == LOOKED_AT_MAX {
                break;
            }
        }
        let order = |a: &(f64, Place), b: &(f64, Place)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        self.found.sort_unstable_by(order);
    }

    /// The best of: one triangle from a to b, one from b to a, one for one; none if nothing gains.
    fn best_trade(&mut self, a: Place, b: Place) -> Option<Trade> {
        self.find_rests(a);
        self.find_rests(b);
        let [none_a, none_b] = [a, b].map(|place| self.leaf(place).triangles.len());
        let before = self.leaf(a).rests[none_a].cost + self.leaf(b).rests[none_b].cost;
        let mut best = before * (1.0 - GAIN_MIN);
        let mut found = None;
        for i in 0..=none_a {
            for j in 0..=none_b {
                let [rest_a, rest_b] = [self.leaf(a).rests[i], self.leaf(b).rests[j]];
                // A triangle that enters makes no ball smaller.
                if rest_a.cost + rest_b.cost >= best {
                    continue;
                }
                let least_a = self.least_cost(rest_a, self.leaf(b).triangles.get(j));
                if least_a + rest_b.cost >= best {
                    continue;
                }
                let least_b = self.least_cost(rest_b, self.leaf(a).triangles.get(i));
                if least_a + least_b >= best
                    || !self.may_change(a, i, b, j)
                    || !self.may_change(b, j, a, i)
                {
                    continue;
                }
                let (ball_a, cost_a) = self.after(a, i, b, j);
                if cost_a + least_b * (1.0 - LEAST_SLACK) >= best {
                    continue;
                }
                let (ball_b, cost_b) = self.after(b, j, a, i);
                if cost_a + cost_b < best {
                    best = cost_a + cost_b;
                    found = Some(Trade {
                        given: [i, j],
                        balls: [ball_a, ball_b],
                    });
                }
            }
        }
        found
    }

    /// Whether a leaf may lose its triangle `out` and get `entering` of another; either number is that of
    /// the triangles where there is none.
    fn may_change(&self, place: Place, out: usize, from: Place, entering: usize) -> bool {
        let [own, other] = [place, from].map(|place| self.leaf(place));
        let loses = out < own.triangles.len();
        match other.triangles.get(entering) {
            Some(&triangle) => {
                let room = loses || own.triangles.len() < self.scene.leaf_size;
                room && (place.node == from.node || self.hold(place.node, triangle))
            }
            None => {
                let lanes = self.leaves[place.node as usize].lanes;
                !loses || own.triangles.len() > 1 || lanes > LANES_MIN
            }
        }
    }

    /// Whether a node and those above it hold a triangle in their balls.
    fn hold(&self, mut node: u32, triangle: u32) -> bool {
        let corners = self.scene.mesh.corners(triangle);
        loop {
            let super::Node { ball, above } = &self.scene.nodes[node as usize];
            if !corners.into_iter().all(|p| ball.holds(p)) {
                return false;
            }
            if node == 0 {
                return true;
            }
            node = *above;
        }
    }

    /// A lower bound of the cost of what is left of a leaf and a triangle that enters it.
    fn least_cost(&self, rest: Rest, entering: Option<&u32>) -> f64 {
        entering.map_or(rest.cost, |&new| {
            let new = &self.scene.balls[new as usize];
            self.scene.cost(rest.ball.least_of_both(new))
        })
    }

    /// The ball of a leaf that changes so, and its cost.
    fn after(&mut self, place: Place, out: usize, from: Place, entering: usize) -> (Ball, f64) {
        let mut triangles = std::mem::take(&mut self.triangles);
        let entering = self.leaf(from).triangles.get(entering);
        self.leaf(place).put_after(out, entering, &mut triangles);
        let rest = self.rest(&triangles);
        self.triangles = triangles;
        (rest.ball, rest.cost)
    }

    fn rest(&mut self, triangles: &[u32]) -> Rest {
        let ball = self.scene.mesh.ball(triangles, &mut self.vertices);
        let cost = if triangles.is_empty() {
            0.0
        } else {
            self.scene.cost(ball.square)
        };
        Rest { ball, cost }
    }

    fn find_rests(&mut self, place: Place) {
        if !self.leaf(place).rests.is_empty() {
            return;
        }
        let mut rests = std::mem::take(&mut self.leaf_mut(place).rests);
        let mut rest = std::mem::take(&mut self.triangles);
        let ball = self.leaf(place).ball;
        let whole = Rest {
            ball,
            cost: self.scene.cost(ball.square),
        };
        let inner = Ball {
            square: ball.square * (1.0 - TOUCHING),
            ..ball
        };
        for out in 0..self.leaf(place).triangles.len() {
            let corners = self.scene.mesh.corners(self.leaf(place).triangles[out]);
            // The ball does not rest on a triangle that it holds inside.
            if corners.into_iter().all(|p| inner.holds(p)) {
                rests.push(whole);
                continue;
            }
            self.leaf(place).put_after(out, None, &mut rest);
            rests.push(self.rest(&rest));
        }
        rests.push(whole);
        self.triangles = rest;
        self.leaf_mut(place).rests = rests;
    }
}
