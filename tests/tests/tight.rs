//! `verify` finds bounds that are too small, under valid checksums. What is guaranteed, per SPEC
//! 5.8: R, ΔR and δR that the vertices below a lane exceed by 2⁻⁴⁰ of them, far less than the step
//! to the next f32 or to the next unit; b± that is below its recomputed value by more than the
//! guards, of which 2⁻²¹ R ΔR is always enough. So one step less (the next f32, or a unit of 16-bit
//! rows) is found wherever the recomputed bound lies above it, which this test decides on its own,
//! lane by lane.

use std::collections::BTreeSet;
use std::ops::ControlFlow;

use bdtree_format::{PairRow, ROW_RADIUS, Row, SectionKind, pair_row};
use bdtree_runtime::{AlignedBytes, Asset, Displacements, NodeRows, VertexId};
use bdtree_tests::mutate::{get_f32, put, repair, section};
use bdtree_tests::{bake, golden};

fn power(e: i32) -> f64 {
    2_f64.powi(e)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vertices below a lane.
fn vertices(asset: &Asset<'_>, node: usize, lane: usize) -> BTreeSet<usize> {
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
    for _ in 0..30 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q] == 0.0 {
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

/// What verify must say of a lowered bound: found, not found, or too close to call.
type Verdict = Option<bool>;

fn compare(needed: f64, allowed: f64, doubt: f64) -> Verdict {
    ((needed - allowed).abs() > doubt).then_some(needed > allowed)
}

/// A number of a node's lane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Number {
    Radius,
    /// ΔR of the k-th active mode.
    Growth(usize),
    /// b⁺ (0) or b⁻ (1) of the k-th active mode.
    Cross(usize, usize),
    /// δR, plain (0) or scaled (1).
    Step(usize),
}

struct Lane<'a> {
    asset: &'a Asset<'a>,
    node: usize,
    lane: usize,
    vertices: Vec<usize>,
}

impl Lane<'_> {
    fn rows(&self) -> NodeRows<'_> {
        let node = &self.asset.nodes()[self.node];
        self.asset.node_rows(node).expect("rows")
    }

    fn mode_count(&self) -> usize {
        usize::from(self.asset.nodes()[self.node].mode_count)
    }

    /// The number for q at its limit, if it is a mode's, and in units of its row.
    fn units(&self, number: Number) -> (f64, f64) {
        let (rows, lane) = (self.rows(), self.lane);
        let [_, growth, cross] = rows.units.map(f64::from);
        match number {
            Number::Radius => (f64::from(rows.leading[ROW_RADIUS][lane]), 1.0),
            Number::Growth(k) => (f64::from(rows.numbers(k, lane)[3]), growth),
            Number::Cross(k, which) => (f64::from(rows.numbers(k, lane)[4 + which]), cross),
            Number::Step(which) => (f64::from(rows.steps[which][lane]), 1.0),
        }
    }

    fn value(&self, number: Number) -> f64 {
        let (units, unit) = self.units(number);
        units * unit
    }

    /// Where the number stands in ROWS.
    fn place(&self, number: Number) -> usize {
        let first = self.asset.nodes()[self.node].row_start as usize;
        let row = |row: usize| (first + row) * size_of::<Row>();
        let of_mode = |k: usize, which: usize| {
            row(pair_row(k / 2)) + size_of::<PairRow>() * which + 4 * self.lane + 2 * (k % 2)
        };
        match number {
            Number::Radius => row(ROW_RADIUS) + 4 * self.lane,
            Number::Growth(k) => of_mode(k, 3),
            Number::Cross(k, which) => of_mode(k, 4 + which),
            Number::Step(which) => row(pair_row(self.rows().pairs.len()) + which) + 4 * self.lane,
        }
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

    /// SPEC 5.8 for a number at the value `lowered`.
    fn verdict(&self, number: Number, lowered: f64) -> Verdict {
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
            unreachable!("all others are done");
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

/// The least number of 16 bits.
const LEAST: f64 = i16::MIN as f64;

/// The places in ROWS that verify reports.
fn reported(bytes: &[u8]) -> BTreeSet<usize> {
    let bytes = AlignedBytes::copy_of(bytes);
    let asset = Asset::open(&bytes).expect("open");
    let mut places = BTreeSet::new();
    asset.verify(&mut |error| {
        assert_eq!(error.section, SectionKind::ROWS, "{error}");
        places.insert(error.byte as usize);
        ControlFlow::Continue(())
    });
    places
}

/// `irregular`: no norm is itself an f32, where writers go one step further than they need.
fn check(bytes: &AlignedBytes, irregular: bool) {
    let asset = Asset::open(bytes).expect("open");
    assert!(reported(bytes).is_empty());
    let rows = section(bytes, SectionKind::ROWS).start;
    let mut changed = bytes.to_vec();
    // Steps found and steps tried: R, ΔR, b±, δR.
    let mut counts = [[0; 2]; 4];
    for (i, node) in asset.nodes().iter().enumerate() {
        for lane in (0..8).filter(|k| (node.inner_mask | node.leaf_mask) >> k & 1 == 1) {
            let lane = Lane {
                asset: &asset,
                node: i,
                lane,
                vertices: vertices(&asset, i, lane).into_iter().collect(),
            };
            let of_mode = |k| [Number::Growth(k), Number::Cross(k, 0), Number::Cross(k, 1)];
            let plain = [Number::Radius, Number::Step(0), Number::Step(1)];
            for number in plain
                .into_iter()
                .chain((0..lane.mode_count()).flat_map(of_mode))
            {
                let at = rows + lane.place(number);
                let (units, unit) = lane.units(number);
                // Writes a number of the kind that is stored.
                let mut lower = |to: f64| {
                    let stored: Vec<u8> = bytes[at..at + 4].to_vec();
                    match number {
                        Number::Growth(_) | Number::Cross(..) => {
                            put(&mut changed, at, &(to as i16).to_le_bytes())
                        }
                        _ => put(&mut changed, at, &(to as f32).to_le_bytes()),
                    }
                    repair(&mut changed);
                    let found = reported(&changed).contains(&at);
                    put(&mut changed, at, &stored);
                    found
                };
                let (kind, lowered) = match number {
                    Number::Radius => (0, f64::from(get_f32(bytes, at).next_down())),
                    Number::Step(_) => (3, f64::from(get_f32(bytes, at).next_down())),
                    Number::Growth(_) => (1, units - 1.0),
                    Number::Cross(..) => (2, units - 1.0),
                };
                let storable = match kind {
                    1 => lowered >= 0.0,
                    2 => lowered >= LEAST,
                    _ => (lowered as f32).is_normal(),
                };
                if !storable {
                    continue;
                }
                let found = lower(lowered);
                let verdict = lane.verdict(number, lowered * unit);
                assert!(
                    verdict.is_none_or(|expected| expected == found),
                    "node {i}, lane {}, {number:?}: {units} lowered, found: {found}",
                    lane.lane
                );
                counts[kind][0] += usize::from(found);
                counts[kind][1] += 1;
                if let Number::Cross(k, _) = number {
                    let product = lane.value(Number::Radius) * lane.value(Number::Growth(k));
                    let lower_still = units - 1.0 - (power(-21) * product / unit).ceil();
                    assert!(
                        lower_still < LEAST || lower(lower_still),
                        "node {i}, {number:?}"
                    );
                }
            }
        }
    }
    println!(
        "found of tried: R {:?}, ΔR {:?}, b± {:?}, δR {:?}",
        counts[0], counts[1], counts[2], counts[3]
    );
    for kind in [0, 1, 3] {
        let [found, tried] = counts[kind];
        assert!(
            !irregular || 100 * found >= 98 * tried,
            "bounds are as small as their rows allow"
        );
    }
    assert!(counts[0][1] > 0);
}

#[test]
fn bounds_one_step_too_small_are_found() {
    let mesh = bake::bumpy_sphere(5, 1);
    check(&bake::baked(&mesh, &bake::rigid(&mesh)), true);
    check(&bake::baked(&mesh, &bake::smooth_basis(&mesh, 2, 1)), true);
    check(&bake::baked(&mesh, &bake::smooth_basis(&mesh, 10, 1)), true);
    let golden = AlignedBytes::read(golden::folder().join("sphere.bdt")).expect("read");
    check(&golden, false);
}
