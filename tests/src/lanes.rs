//! The bounds of a lane, recomputed from the vertices below it: what `verify` is held against. It
//! shares no code with it; tolerances are those of SPEC 5.8.

use std::collections::BTreeSet;
use std::fmt;

use bdtree_format::{PairRow, ROW_RADIUS, Row, pair_row};
use bdtree_runtime::{Asset, Displacements, NodeRows, VertexId};

fn power(e: i32) -> f64 {
    2_f64.powi(e)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vertices below a lane.
pub fn vertices(asset: &Asset<'_>, node: usize, lane: usize) -> BTreeSet<usize> {
    let record = &asset.nodes()[node];
    let bit = 1_u8 << lane;
    let mut found = BTreeSet::new();
    if record.leaf_mask & bit != 0 {
        let before: usize = record.leaf_counts[..lane]
            .iter()
            .map(|c| usize::from(*c))
            .sum();
        let start = record.first_slot as usize + before;
        for t in &asset.triangles()[start..start + usize::from(record.leaf_counts[lane])] {
            found.extend(t.corners.map(|c| c as usize));
        }
    } else if record.inner_mask & bit != 0 {
        let before = (record.inner_mask & (bit - 1)).count_ones();
        let child = (record.first_child + before) as usize;
        for lane in 0..8 {
            found.extend(vertices(asset, child, lane));
        }
    }
    found
}

/// The largest eigenvalue of U Uᵀ for a vertex's displacements: cyclic Jacobi.
fn step_square(fields: &[[f64; 3]]) -> f64 {
    let mut a = [[0.0; 3]; 3];
    for u in fields {
        for r in 0..3 {
            for c in 0..3 {
                a[r][c] += u[r] * u[c];
            }
        }
    }
    let nothing = 1e-30 * (a[0][0] + a[1][1] + a[2][2]);
    for _ in 0..30 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q].abs() <= nothing {
                continue;
            }
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            for k in 0..3 {
                let (x, y) = (a[k][p], a[k][q]);
                (a[k][p], a[k][q]) = (c * x - s * y, s * x + c * y);
            }
            for k in 0..3 {
                let (x, y) = (a[p][k], a[q][k]);
                (a[p][k], a[q][k]) = (c * x - s * y, s * x + c * y);
            }
        }
    }
    a[0][0].max(a[1][1]).max(a[2][2])
}

/// What a checker must say of a bound: too small, not too small, or too close to call.
pub type Verdict = Option<bool>;

fn compare(needed: f64, allowed: f64, doubt: f64) -> Verdict {
    if doubt == 0.0 {
        return Some(needed > allowed); // zeros, which are exact
    }
    ((needed - allowed).abs() > doubt).then_some(needed > allowed)
}

/// A number of a node's lane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Number {
    /// A coordinate of c, which bounds nothing itself.
    Centre(usize),
    /// R.
    Radius,
    /// A coordinate of Ū of the k-th active mode, which bounds nothing itself.
    Mean(usize, usize),
    /// ΔR of the k-th active mode.
    Growth(usize),
    /// b⁺ (0) or b⁻ (1) of the k-th active mode.
    Cross(usize, usize),
    /// δR, plain (0) or scaled (1).
    Step(usize),
}

/// Where a number of a lane (node and lane) stands in ROWS.
pub fn place(asset: &Asset<'_>, (node, lane): (usize, usize), number: Number) -> usize {
    let node = &asset.nodes()[node];
    let row = |row: usize| (node.row_start as usize + row) * size_of::<Row>();
    let of_mode = |k: usize, which: usize| {
        row(pair_row(k / 2)) + size_of::<PairRow>() * which + 4 * lane + 2 * (k % 2)
    };
    let pairs = usize::from(node.mode_count).div_ceil(2);
    match number {
        Number::Centre(axis) => row(axis) + 4 * lane,
        Number::Radius => row(ROW_RADIUS) + 4 * lane,
        Number::Mean(k, axis) => of_mode(k, axis),
        Number::Growth(k) => of_mode(k, 3),
        Number::Cross(k, which) => of_mode(k, 4 + which),
        Number::Step(which) => row(pair_row(pairs) + which) + 4 * lane,
    }
}

/// A lane of a sound tree, and the vertices below it.
pub struct Lane<'a> {
    asset: &'a Asset<'a>,
    node: usize,
    lane: usize,
    vertices: Vec<usize>,
}

impl fmt::Debug for Lane<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "node {}, lane {}", self.node, self.lane)
    }
}

impl<'a> Lane<'a> {
    /// # Panics
    /// Here and below, when the order of the nodes is not sound.
    pub fn new(asset: &'a Asset<'a>, node: usize, lane: usize) -> Self {
        Self {
            asset,
            node,
            lane,
            vertices: vertices(asset, node, lane).into_iter().collect(),
        }
    }

    /// All lanes of an asset that are not empty.
    pub fn all(asset: &'a Asset<'a>) -> impl Iterator<Item = Self> {
        let nodes = asset.nodes().iter().enumerate();
        nodes.flat_map(move |(i, node)| {
            let used = node.inner_mask | node.leaf_mask;
            let lanes = (0..8).filter(move |k| used >> k & 1 == 1);
            lanes.map(move |lane| Self::new(asset, i, lane))
        })
    }

    /// Every number that bounds.
    pub fn numbers(&self) -> impl Iterator<Item = Number> + use<> {
        let of_mode = |k| [Number::Growth(k), Number::Cross(k, 0), Number::Cross(k, 1)];
        let plain = [Number::Radius, Number::Step(0), Number::Step(1)];
        plain
            .into_iter()
            .chain((0..self.mode_count()).flat_map(of_mode))
    }

    /// Whether a mode that the node leaves out moves a vertex below the lane.
    pub fn misses_a_mode(&self) -> bool {
        let node = &self.asset.nodes()[self.node];
        let active = self.asset.node_modes(node).expect("list");
        let moves = |(mode, u): (usize, [f32; 3])| {
            u != [0.0; 3] && !active.iter().any(|j| usize::from(*j) == mode)
        };
        self.vertices
            .iter()
            .any(|i| self.displacements(*i).iter().any(moves))
    }

    /// The largest share of `field_norm_max` that Ū of an active mode takes, and of
    /// `position_norm_max` that c takes; 1 is all of it.
    pub fn centre_shares(&self) -> f64 {
        let share = |x: [f64; 3], limit: f64| match dot(x, x).sqrt() {
            0.0 => 0.0,
            norm => norm / limit,
        };
        let centre = [0, 1, 2].map(|axis| self.value(Number::Centre(axis)));
        let p = self.asset.header().position_norm_max.get();
        let mut largest = share(centre, f64::from(p));
        let node = &self.asset.nodes()[self.node];
        let active = self.asset.node_modes(node).expect("list");
        for (k, mode) in active.iter().enumerate() {
            let record = &self.asset.modes()[usize::from(*mode)];
            let limit = f64::from(record.q_limit.get());
            let mean = [0, 1, 2].map(|axis| self.value(Number::Mean(k, axis)) / limit);
            largest = largest.max(share(mean, f64::from(record.field_norm_max.get())));
        }
        largest
    }

    /// The node's rows.
    pub fn rows(&self) -> NodeRows<'_> {
        let node = &self.asset.nodes()[self.node];
        self.asset.node_rows(node).expect("rows")
    }

    /// Active modes of the node.
    pub fn mode_count(&self) -> usize {
        usize::from(self.asset.nodes()[self.node].mode_count)
    }

    /// The number for q at its limit, if it is a mode's, and in units of its row.
    pub fn units(&self, number: Number) -> (f64, f64) {
        let (rows, lane) = (self.rows(), self.lane);
        let [mean, growth, cross] = rows.units.map(f64::from);
        match number {
            Number::Centre(axis) => (f64::from(rows.leading[axis][lane]), 1.0),
            Number::Radius => (f64::from(rows.leading[ROW_RADIUS][lane]), 1.0),
            Number::Mean(k, axis) => (f64::from(rows.numbers(k, lane)[axis]), mean),
            Number::Growth(k) => (f64::from(rows.numbers(k, lane)[3]), growth),
            Number::Cross(k, which) => (f64::from(rows.numbers(k, lane)[4 + which]), cross),
            Number::Step(which) => (f64::from(rows.steps[which][lane]), 1.0),
        }
    }

    /// The number for q at its limit, in stored units or their square.
    pub fn value(&self, number: Number) -> f64 {
        let (units, unit) = self.units(number);
        units * unit
    }

    /// Where the number stands in ROWS.
    pub fn place(&self, number: Number) -> usize {
        place(self.asset, (self.node, self.lane), number)
    }

    fn arm(&self, i: usize) -> [f64; 3] {
        let (p, c) = (self.asset.positions()[i], self.rows().leading);
        [0, 1, 2].map(|k| f64::from(p[k]) - f64::from(c[k][self.lane]))
    }

    fn displacements(&self, i: usize) -> Displacements<'_> {
        let own = self.asset.displacements(VertexId(i as u32));
        own.expect("a vertex")
    }

    /// w_ij for q_j at its limit.
    fn field(&self, i: usize, k: usize) -> [f64; 3] {
        let node = &self.asset.nodes()[self.node];
        let mode = usize::from(self.asset.node_modes(node).expect("list")[k]);
        let u = self.displacements(i).of(mode);
        let limit = f64::from(self.asset.modes()[mode].q_limit.get());
        let (rows, unit) = (self.rows(), f64::from(self.rows().units[0]));
        let mean = rows.numbers(k, self.lane);
        [0, 1, 2].map(|a| f64::from(u[a]) * limit - f64::from(mean[a]) * unit)
    }

    fn largest(&self, f: impl Fn(usize) -> f64) -> f64 {
        self.vertices
            .iter()
            .map(|i| f(*i))
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// Whether a number would be too small with the value `lowered` (SPEC 5.8).
    pub fn verdict(&self, number: Number, lowered: f64) -> Verdict {
        let square = lowered * lowered;
        if number == Number::Radius {
            let needed = self.largest(|i| dot(self.arm(i), self.arm(i)));
            return compare(needed, square * (1.0 + power(-44)), square * power(-49));
        }
        if let Number::Step(which) = number {
            let scaled = which == 1;
            let count = self.asset.mode_count();
            let needed = self.largest(|i| {
                let fields: Vec<[f64; 3]> = (0..count)
                    .map(|j| {
                        let s = f64::from(self.asset.modes()[j].step_scale.get());
                        let u = self.displacements(i).of(j).map(f64::from);
                        u.map(|c| if scaled { c * s } else { c })
                    })
                    .collect();
                step_square(&fields)
            });
            return compare(needed, square, square * power(-39));
        }
        if let Number::Growth(k) = number {
            let needed = self.largest(|i| dot(self.field(i, k), self.field(i, k)));
            return compare(needed, square * (1.0 + power(-44)), square * power(-49));
        }
        let Number::Cross(k, which) = number else {
            return Some(false);
        };
        let sign = if which == 0 { 1.0 } else { -1.0 };
        let (r, growth) = (self.value(Number::Radius), self.value(Number::Growth(k)));
        let needed = self.largest(|i| {
            let (x, w) = (self.arm(i), self.field(i, k));
            let d = (r * r - dot(x, x)).max(0.0) + power(-48) * r * r;
            let e = (growth * growth - dot(w, w)).max(0.0) + power(-48) * growth * growth;
            sign * dot(x, w) - (d * e).sqrt() - power(-40) * r * growth
        });
        compare(needed, lowered, r * growth * power(-48))
    }
}
