//! A tree of boxes: which of them contain a point, and which thing inside them is nearest.

/// A box along the axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Aabb {
    pub(super) low: [f64; 3],
    pub(super) high: [f64; 3],
}

impl Aabb {
    /// Around nothing.
    pub(super) const EMPTY: Self = Self {
        low: [f64::INFINITY; 3],
        high: [f64::NEG_INFINITY; 3],
    };

    /// The smallest box around `points`.
    pub(super) fn around(points: impl Iterator<Item = [f64; 3]>) -> Self {
        points.fold(Self::EMPTY, |all, p| all.with(&Self { low: p, high: p }))
    }

    /// The smallest box around both.
    pub(super) fn with(mut self, other: &Self) -> Self {
        for a in 0..3 {
            self.low[a] = self.low[a].min(other.low[a]);
            self.high[a] = self.high[a].max(other.high[a]);
        }
        self
    }

    fn contains(&self, p: [f64; 3], slack: f64) -> bool {
        (0..3).all(|a| p[a] >= self.low[a] - slack && p[a] <= self.high[a] + slack)
    }

    /// Square of the distance to `p`; 0 inside.
    fn square_distance(&self, p: [f64; 3]) -> f64 {
        (0..3)
            .map(|a| (self.low[a] - p[a]).max(p[a] - self.high[a]).max(0.0))
            .map(|d| d * d)
            .sum()
    }
}

/// Items in a leaf, at most.
const LEAF: usize = 4;

/// A binary tree, cut at the median along the longest side.
#[derive(Debug)]
pub(super) struct BoxTree {
    nodes: Vec<Node>,
    items: Vec<(u32, Aabb)>,
}

#[derive(Debug)]
struct Node {
    bounds: Aabb,
    /// Items below.
    start: u32,
    end: u32,
    /// The second child; the first is the next node. 0 in leaves.
    second: u32,
}

impl BoxTree {
    pub(super) fn new(boxes: &[Aabb]) -> Self {
        let mut tree = Self {
            nodes: Vec::new(),
            items: (0..).zip(boxes.iter().copied()).collect(),
        };
        if !boxes.is_empty() {
            tree.build(0, boxes.len());
        }
        tree
    }

    /// Depth is the logarithm of the number of items.
    fn build(&mut self, start: usize, end: usize) {
        let items = &mut self.items[start..end];
        let bounds = items
            .iter()
            .fold(Aabb::EMPTY, |all, (_, item)| all.with(item));
        let node = self.nodes.len();
        self.nodes.push(Node {
            bounds,
            start: start as u32,
            end: end as u32,
            second: 0,
        });
        if items.len() <= LEAF {
            return;
        }
        let side = |a: usize| bounds.high[a] - bounds.low[a];
        let axis = (0..3).fold(0, |best, a| if side(a) > side(best) { a } else { best });
        let middle = items.len() / 2;
        items.select_nth_unstable_by(middle, |(i, x), (j, y)| {
            let center = |b: &Aabb| 0.5 * b.low[axis] + 0.5 * b.high[axis];
            center(x).total_cmp(&center(y)).then(i.cmp(j))
        });
        self.build(start, start + middle);
        self.nodes[node].second = self.nodes.len() as u32;
        self.build(start + middle, end);
    }

    /// Hands every item to `visit` whose box, widened by `slack`, contains `p`.
    pub(super) fn containing(&self, p: [f64; 3], slack: f64, mut visit: impl FnMut(u32)) {
        let mut node = 0;
        let mut later = Vec::new();
        while let Some(here) = self.nodes.get(node) {
            let is_inside = here.bounds.contains(p, slack);
            if is_inside && here.second != 0 {
                later.push(here.second as usize);
                node += 1;
                continue;
            }
            if is_inside {
                for (item, bounds) in &self.items[here.start as usize..here.end as usize] {
                    if bounds.contains(p, slack) {
                        visit(*item);
                    }
                }
            }
            match later.pop() {
                Some(next) => node = next,
                None => return,
            }
        }
    }

    /// The item of the smallest `square` distance, and that; the lowest item of equal ones. `square`
    /// is nowhere less than the box of its item has it.
    pub(super) fn nearest(
        &self,
        p: [f64; 3],
        mut square: impl FnMut(u32) -> f64,
    ) -> Option<(u32, f64)> {
        let mut best: Option<(u32, f64)> = None;
        let mut later = Vec::new();
        if let Some(root) = self.nodes.first() {
            later.push((root.bounds.square_distance(p), 0));
        }
        while let Some((bound, node)) = later.pop() {
            if best.is_some_and(|(_, least)| bound > least) {
                continue;
            }
            let here: &Node = &self.nodes[node];
            if here.second == 0 {
                for &(item, bounds) in &self.items[here.start as usize..here.end as usize] {
                    let bound = bounds.square_distance(p);
                    if best.is_some_and(|(_, least)| bound > least) {
                        continue;
                    }
                    let found = square(item);
                    let is_better = best.is_none_or(|(lowest, least)| {
                        found < least || (found == least && item < lowest)
                    });
                    if is_better {
                        best = Some((item, found));
                    }
                }
                continue;
            }
            let children = [node + 1, here.second as usize];
            let [first, second] =
                children.map(|child| (self.nodes[child].bounds.square_distance(p), child));
            // The nearer one is looked at first.
            if first.0 <= second.0 {
                later.extend([second, first]);
            } else {
                later.extend([first, second]);
            }
        }
        best
    }
}
