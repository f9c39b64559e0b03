//! Where to divide a set of triangles in two.

use bdtree_format::LANES;

use super::Split;

/// Sets up to this size are swept exactly; larger ones are binned.
const SWEEP_MAX: usize = 1024;

/// Leaf lanes of the lowest nodes that the count of triangles fills: one of eight is left for cuts
/// that follow the shape (docs/design/decisions/tree-split-and-leaf-size.md).
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

    /// Offers the cuts between neighbouring parts of `count` items along an axis: of each its size and box.
    /// `weights` are what the costs of both sides of a cut count, if the first may have so many items.
    fn offer_all<'b>(
        &mut self,
        axis: usize,
        parts: impl DoubleEndedIterator<Item = (usize, &'b Bounds)> + Clone,
        count: usize,
        right_costs: &mut Vec<f64>,
        weights: impl Fn(usize) -> Option<[f64; 2]>,
    ) {
        // Of the last part, the last two and so on.
        right_costs.clear();
        let mut bounds = Bounds::EMPTY;
        right_costs.extend(parts.clone().rev().map(|(_, part)| {
            bounds.add(part);
            bounds.cost()
        }));
        bounds = Bounds::EMPTY;
        let mut left = 0;
        for ((size, part), right_cost) in parts.zip(right_costs.iter().rev().skip(1)) {
            bounds.add(part);
            left += size;
            if let Some([first, second]) = weights(left) {
                let cost = bounds.cost() * first + right_cost * second;
                self.offer(cost, Cut { axis, left }, count);
            }
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
        let mut best = Best::new(count);
        let mut sorter = Sorter::default();
        let mut right_costs = Vec::with_capacity(count);
        for axis in 0..3 {
            sorter.sort(items, axis);
            let parts = items.iter().map(|item| (1, &item.bounds));
            best.offer_all(axis, parts, count, &mut right_costs, |left| {
                let right = count - left;
                self.may_cut(left, count, lanes).then(|| match lanes {
                    Some(_) => [left as f64, right as f64],
                    None => [self.leaves(left), self.leaves(right)],
                })
            });
        }
        best.cut
    }

    /// The cheapest plane between bins on all axes, moved to the nearest whole node.
    fn bin(&self, items: &[Item]) -> Cut {
        let count = items.len();
        let mut best = Best::new(count);
        let mut right_costs = Vec::with_capacity(BINS);
        for axis in 0..3 {
            let keys = items.iter().map(|item| item.key(axis));
            let low = keys.clone().fold(f64::INFINITY, f64::min);
            let high = keys.fold(f64::NEG_INFINITY, f64::max);
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
            let parts = bins.iter().map(|(size, bounds)| (*size, bounds));
            best.offer_all(axis, parts, count, &mut right_costs, |left| {
                let right = count - left;
                (left > 0 && right > 0).then(|| [self.leaves(left), self.leaves(right)])
            });
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
    let below = items.iter().filter(|item| item.key(axis) < middle).count();
    // With all keys on one side, halves keep the tree flat.
    let one_side = below == 0 || below == items.len();
    let left = if one_side { items.len() / 2 } else { below };
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
    // All bits of negative numbers are turned round, of others the sign.
    bits ^ ((bits as i64 >> 63) as u64 | 1 << 63)
}

fn compare(a: &Item, b: &Item, axis: usize) -> std::cmp::Ordering {
    a.key(axis).total_cmp(&b.key(axis)).then(a.id.cmp(&b.id))
}
