//! `verify` finds bounds that are too small, under valid checksums. What is guaranteed, per SPEC
//! 5.8: R, ΔR and δR that the vertices below a lane exceed by 2⁻⁴⁰ of them, far less than the step
//! to the next f32; b± that is below its recomputed value by more than the guards, of which
//! 2⁻²¹ R ΔR is always enough. So one f32 step less is found wherever the recomputed bound lies
//! above it, which this test decides on its own, lane by lane.

use std::collections::BTreeSet;
use std::ops::ControlFlow;

use bdtree_format::{ROW_RADIUS, SectionKind, mode_row};
use bdtree_runtime::{AlignedBytes, Asset};
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

struct Lane<'a> {
    asset: &'a Asset<'a>,
    node: usize,
    lane: usize,
    vertices: Vec<usize>,
}

impl Lane<'_> {
    fn value(&self, row: usize) -> f64 {
        let node = &self.asset.nodes()[self.node];
        f64::from(self.asset.node_rows(node).expect("rows")[row][self.lane])
    }

    fn vector(&self, row: usize) -> [f64; 3] {
        [self.value(row), self.value(row + 1), self.value(row + 2)]
    }

    fn arm(&self, i: usize) -> [f64; 3] {
        let (p, c) = (self.asset.positions()[i], self.vector(0));
        [0, 1, 2].map(|k| f64::from(p[k]) - c[k])
    }

    fn field(&self, i: usize, k: usize) -> [f64; 3] {
        let node = &self.asset.nodes()[self.node];
        let mode = self.asset.node_modes(node).expect("list")[k];
        let u = self.asset.displacements()[i * self.asset.mode_count() + usize::from(mode)];
        let mean = self.vector(mode_row(k));
        [0, 1, 2].map(|a| f64::from(u[a]) - mean[a])
    }

    fn largest(&self, f: impl Fn(usize) -> f64) -> f64 {
        self.vertices
            .iter()
            .map(|i| f(*i))
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// SPEC 5.8 for row `row` at the value `lowered`.
    fn verdict(&self, row: usize, lowered: f64) -> Verdict {
        let m = usize::from(self.asset.nodes()[self.node].mode_count);
        let square = lowered * lowered;
        if row == ROW_RADIUS {
            let needed = self.largest(|i| dot(self.arm(i), self.arm(i)));
            return compare(needed, square * (1.0 + power(-44)), square * power(-49));
        }
        if row >= mode_row(m) {
            let scaled = row > mode_row(m);
            let count = self.asset.mode_count();
            let needed = self.largest(|i| {
                let fields: Vec<[f64; 3]> = (0..count)
                    .map(|j| {
                        let s = f64::from(self.asset.modes()[j].step_scale.get());
                        let u = self.asset.displacements()[i * count + j].map(f64::from);
                        u.map(|c| if scaled { c * s } else { c })
                    })
                    .collect();
                step_square(&fields)
            });
            return compare(needed, square, square * power(-39));
        }
        let (k, which) = ((row - mode_row(0)) / 6, (row - mode_row(0)) % 6);
        if which == 3 {
            let needed = self.largest(|i| dot(self.field(i, k), self.field(i, k)));
            return compare(needed, square * (1.0 + power(-44)), square * power(-49));
        }
        let sign = if which == 4 { 1.0 } else { -1.0 };
        let (r, growth) = (self.value(ROW_RADIUS), self.value(mode_row(k) + 3));
        let needed = self.largest(|i| {
            let (x, w) = (self.arm(i), self.field(i, k));
            let d = (r * r - dot(x, x)).max(0.0) + power(-48) * r * r;
            let e = (growth * growth - dot(w, w)).max(0.0) + power(-48) * growth * growth;
            sign * dot(x, w) - (d * e).sqrt() - power(-40) * r * growth
        });
        compare(needed, lowered, r * growth * power(-48))
    }
}

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
            let m = usize::from(node.mode_count);
            let lane = Lane {
                asset: &asset,
                node: i,
                lane,
                vertices: vertices(&asset, i, lane).into_iter().collect(),
            };
            let bounds = (0..m).flat_map(|k| mode_row(k) + 3..mode_row(k) + 6);
            for row in [ROW_RADIUS]
                .into_iter()
                .chain(bounds)
                .chain(mode_row(m)..mode_row(m) + 2)
            {
                let at = rows + 32 * (node.row_start as usize + row) + 4 * lane.lane;
                let stored = get_f32(bytes, at);
                let mut lower = |value: f32| {
                    put(&mut changed, at, &value.to_le_bytes());
                    repair(&mut changed);
                    let found = reported(&changed).contains(&at);
                    put(&mut changed, at, &stored.to_le_bytes());
                    found
                };
                let lowered = stored.next_down();
                if !lowered.is_normal() {
                    continue;
                }
                let found = lower(lowered);
                let verdict = lane.verdict(row, f64::from(lowered));
                assert!(
                    verdict.is_none_or(|expected| expected == found),
                    "node {i}, lane {}, row {row}: {stored} lowered, found: {found}",
                    lane.lane
                );
                let kind = match row {
                    ROW_RADIUS => 0,
                    _ if row >= mode_row(m) => 3,
                    _ if (row - mode_row(0)) % 6 == 3 => 1,
                    _ => 2,
                };
                counts[kind][0] += usize::from(found);
                counts[kind][1] += 1;
                if kind == 2 {
                    let mode = (row - mode_row(0)) / 6;
                    let product = lane.value(ROW_RADIUS) * lane.value(mode_row(mode) + 3);
                    let lower_still = (f64::from(stored) - power(-21) * product) as f32;
                    assert!(lower(lower_still.next_down()), "node {i}, row {row}");
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
            "bounds are as small as f32 allows"
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
