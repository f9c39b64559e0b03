//! Where to divide a set of triangles in two.

use bdtree_format::LANES;

use super::Split;

/// Sets up to this size are swept exactly; larger ones are binned.
const SWEEP_MAX: usize = 1024;

/// Leaf lanes of the lowest nodes that the count of triangles fills: one of eight is left for cuts
/// that follow the shape (docs/decisions/tree-split-and-leaf-size.md).
const LANES_MEANT: usize = LANES - 1;

/// Diameter of a typical query over the diagonal of everything.
const QUERY_REL: f64 = 0.02;

/// Keeps sums of costs finite when a position is not.
const COST_MAX: f64 = 1e200;

/// Bins per axis.
const BINS: usize = 32;

/// A triangle as the splitter sees it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Item {
    pub(super) bounds: Bounds,
    pub(super) id: u32,
}

impl Item {
    /// Twice the center of the triangle's box on one axis: the key that sets are cut by.
    fn key(&self, axis: usize) -> f64 {
        f64::from(self.bounds.low[axis]) + f64::from(self.bounds.high[axis])
    }
}

/// An axis-aligned box in stored units.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    low: [f32; 3],
    high: [f32; 3],
}

impl Bounds {
    pub(super) const EMPTY: Self = Self {
        low: [f32::INFINITY; 3],
        high: [f32::NEG_INFINITY; 3],
    };

    fn add_point(&mut self, p: [f32; 3]) {
        for (axis, x) in p.into_iter().enumerate() {
            self.low[axis] = self.low[axis].min(x);
            self.high[axis] = self.high[axis].max(x);
        }
    }

    fn add(&mut self, other: &Self) {
        for axis in 0..3 {
            self.low[axis] = self.low[axis].min(other.low[axis]);
            self.high[axis] = self.high[axis].max(other.high[axis]);
        }
    }

    fn extent(&self) -> [f64; 3] {
        std::array::from_fn(|axis| f64::from(self.high[axis]) - f64::from(self.low[axis]))
    }

    /// How likely a query is to visit a sphere around the box, up to a factor: the squared
    /// diagonal (a sphere's area), 0 for an empty box.
    pub(super) fn cost(&self) -> f64 {
        if self.low[0] > self.high[0] {
            return 0.0;
        }
        let square: f64 = self.extent().iter().map(|e| e * e).sum();
        square.min(COST_MAX)
    }
}

/// The triangles as items, in the order of ids.
pub(super) fn items(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<Item> {
    (0u32..)
        .zip(triangles)
        .map(|(id, corners)| {
            let mut bounds = Bounds::EMPTY;
            for &corner in corners {
                if let Some(&p) = positions.get(corner as usize) {
                    bounds.add_point(p);
                }
            }
            Item { bounds, id }
        })
        .collect()
}

/// The box around a set.
pub(super) fn bounds_of(items: &[Item]) -> Bounds {
    let mut bounds = Bounds::EMPTY;
    for item in items {
        bounds.add(&item.bounds);
    }
    bounds
}

/// A rule for dividing sets.
#[derive(Debug, Clone, Copy)]
pub(super) struct Splitter {
    pub(super) split: Split,
    pub(super) leaf_size: usize,
    /// Diagonal of the box around all triangles.
    pub(super) diagonal: f64,
}

/// Where to cut: the first `left` items along `axis`.
#[derive(Debug, Clone, Copy)]
struct Cut {
    axis: usize,
    left: usize,
}

/// The cheapest cut so far; of equally cheap ones the most even, so that coincident triangles
/// make flat trees.
#[derive(Debug)]
struct Best {
    cost: f64,
    unevenness: usize,
    cut: Cut,
}

impl Best {
    /// Halves on the first axis, which any real cut beats.
    fn new(count: usize) -> Self {
        Self {
            cost: f64::INFINITY,
            unevenness: 0,
            cut: Cut {
                axis: 0,
                left: count / 2,
            },
        }
    }

    fn offer(&mut self, cost: f64, cut: Cut, count: usize) {
        let unevenness = cut.left.abs_diff(count - cut.left);
        if cost < self.cost || (cost == self.cost && unevenness < self.unevenness) {
            *self = Self {
                cost,
                unevenness,
                cut,
            };
        }
    }
}

impl Splitter {
    /// How often a wide node with this box is visited, up to a factor, by queries of a typical
    /// size.
    pub(super) fn visits(&self, bounds: &Bounds) -> f64 {
        (bounds.cost().sqrt() + self.query()).powi(2)
    }

    /// Diameter of a typical query.
    pub(super) fn query(&self) -> f64 {
        QUERY_REL * self.diagonal
    }

    /// Divides `items` (at least two) in place and returns the size of the first part, which is
    /// at least one and below the whole. With `balanced` the parts have half the items each.
    pub(super) fn divide(
        &self,
        items: &mut [Item],
        bounds: &Bounds,
        lanes: Option<usize>,
        balanced: bool,
    ) -> usize {
        let count = items.len();
        let cut = if balanced {
            Cut {
                axis: longest_axis(bounds),
                left: count / 2,
            }
        } else {
            match self.split {
                Split::Quinlan => quinlan(items, bounds),
                Split::Cost if count <= SWEEP_MAX || lanes.is_some() => self.sweep(items, lanes),
                Split::Cost => self.bin(items),
            }
        };
        let left = cut.left.clamp(1, count - 1);
        // Ids make the keys unique, so that the parts are sets that no sorting detail decides.
        items.select_nth_unstable_by(left, |a, b| compare(a, b, cut.axis));
        left
    }

    /// Triangles that the lowest nodes are meant to hold.
    fn node_size(&self) -> usize {
        self.leaf_size * LANES_MEANT
    }

    /// Whether a set becomes the leaves of one node.
    pub(super) fn fits_node(&self, count: usize) -> bool {
        self.split == Split::Cost && count <= self.leaf_size * LANES
    }

    /// How the lanes of a node are shared between two sets: what each needs, and what is left in
    /// proportion to their sizes.
    pub(super) fn share_lanes(
        &self,
        left: usize,
        right: usize,
        lanes: Option<usize>,
    ) -> [Option<usize>; 2] {
        let Some(lanes) = lanes else {
            return [None; 2];
        };
        let needed = [left, right].map(|count| count.div_ceil(self.leaf_size));
        let spare = lanes.saturating_sub(needed[0] + needed[1]);
        let first = spare * left / (left + right);
        [Some(needed[0] + first), Some(needed[1] + spare - first)]
    }

    /// Whether a set may be cut here: above a node's worth at whole nodes, so that few lanes are
    /// left empty; below it wherever the lanes suffice.
    fn may_cut(&self, left: usize, count: usize, lanes: Option<usize>) -> bool {
        let right = count - left;
        match lanes {
            Some(lanes) => left.div_ceil(self.leaf_size) + right.div_ceil(self.leaf_size) <= lanes,
            None => {
                let node = self.node_size();
                left.is_multiple_of(node) || right.is_multiple_of(node)
            }
        }
    }

    fn leaves(&self, count: usize) -> f64 {
        count.div_ceil(self.leaf_size) as f64
    }

    /// The cheapest allowed cut on all axes.
    fn sweep(&self, items: &mut [Item], lanes: Option<usize>) -> Cut {
        let count = items.len();
        let weight = |count: usize| match lanes {
            Some(_) => count as f64,
            None => self.leaves(count),
        };
        let mut best = Best::new(count);
        let mut right_cost = vec![0.0; count];
        let mut sorter = Sorter::default();
        for axis in 0..3 {
            sorter.sort(items, axis);
            let mut bounds = Bounds::EMPTY;
            for (i, item) in items.iter().enumerate().rev() {
                bounds.add(&item.bounds);
                right_cost[i] = bounds.cost();
            }
            bounds = Bounds::EMPTY;
            for left in 1..count {
                bounds.add(&items[left - 1].bounds);
                if !self.may_cut(left, count, lanes) {
                    continue;
                }
                let cost = bounds.cost() * weight(left) + right_cost[left] * weight(count - left);
                best.offer(cost, Cut { axis, left }, count);
            }
        }
        best.cut
    }

    /// The cheapest plane between bins on all axes, moved to the nearest whole node.
    fn bin(&self, items: &[Item]) -> Cut {
        let count = items.len();
        let mut best = Best::new(count);
        for axis in 0..3 {
            let (low, high) = items
                .iter()
                .map(|item| item.key(axis))
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), k| {
                    (l.min(k), h.max(k))
                });
            let scale = BINS as f64 / (high - low);
            if !scale.is_finite() {
                continue;
            }
            let mut bins = [(0usize, Bounds::EMPTY); BINS];
            for item in items {
                let bin = (((item.key(axis) - low) * scale) as usize).min(BINS - 1);
                bins[bin].0 += 1;
                bins[bin].1.add(&item.bounds);
            }
            let mut right_cost = [0.0; BINS];
            let mut bounds = Bounds::EMPTY;
            for (i, bin) in bins.iter().enumerate().rev() {
                bounds.add(&bin.1);
                right_cost[i] = bounds.cost();
            }
            bounds = Bounds::EMPTY;
            let mut left = 0;
            for i in 1..BINS {
                bounds.add(&bins[i - 1].1);
                left += bins[i - 1].0;
                if left == 0 || left == count {
                    continue;
                }
                let cost =
                    bounds.cost() * self.leaves(left) + right_cost[i] * self.leaves(count - left);
                best.offer(cost, Cut { axis, left }, count);
            }
        }
        let cut = best.cut;
        let step = self.node_size();
        let left = ((cut.left + step / 2) / step * step).clamp(step, (count - 1) / step * step);
        Cut { left, ..cut }
    }
}

/// Where the keys pass the middle of the longest axis of the box.
fn quinlan(items: &[Item], bounds: &Bounds) -> Cut {
    let axis = longest_axis(bounds);
    let middle = f64::from(bounds.low[axis]) + f64::from(bounds.high[axis]);
    let left = items.iter().filter(|item| item.key(axis) < middle).count();
    if left == 0 || left == items.len() {
        // All keys are on one side: halves keep the tree flat.
        return Cut {
            axis,
            left: items.len() / 2,
        };
    }
    Cut { axis, left }
}

fn longest_axis(bounds: &Bounds) -> usize {
    let extent = bounds.extent();
    (1..3).fold(0, |best, axis| {
        if extent[axis] > extent[best] {
            axis
        } else {
            best
        }
    })
}

/// Memory for sorting.
#[derive(Debug, Default)]
struct Sorter {
    keys: Vec<u128>,
    sorted: Vec<Item>,
}

impl Sorter {
    /// Puts items in the order of [`compare`]: key, id and place as one number each, which sorts several times
    /// quicker than the items.
    fn sort(&mut self, items: &mut [Item], axis: usize) {
        self.keys.clear();
        self.keys.extend((0u32..).zip(&*items).map(|(place, item)| {
            u128::from(order_bits(item.key(axis))) << 64
                | u128::from(item.id) << 32
                | u128::from(place)
        }));
        self.keys.sort_unstable();
        self.sorted.clear();
        let places = self.keys.iter().map(|&key| key as u32 as usize);
        self.sorted.extend(places.map(|place| items[place]));
        items.copy_from_slice(&self.sorted);
    }
}

/// A number that orders as `f64::total_cmp` does.
fn order_bits(x: f64) -> u64 {
    let bits = x.to_bits();
    let flipped = if x.is_sign_negative() {
        u64::MAX
    } else {
        1 << 63
    };
    bits ^ flipped
}

fn compare(a: &Item, b: &Item, axis: usize) -> std::cmp::Ordering {
    a.key(axis).total_cmp(&b.key(axis)).then(a.id.cmp(&b.id))
}
