//! What bounds cost: nanoseconds of updating a node and of testing one lane against a node's eight, in
//! plain loops over eight lanes. They use what this program is compiled for: `cargo rustc --release -p
//! bdtree-scenes --bin bench -- -C target-cpu=x86-64-v3` gives AVX2.

use std::hint::black_box;
use std::time::Instant;

use bdtree_baselines::stats::median;
use bdtree_scenes::bounds::bound::Bound;
use bdtree_scenes::bounds::contenders::Contender;
use bdtree_scenes::bounds::overlap::BoxTest;

use super::loops::{
    Balls, Cuboids, Ends, LANES, Row, Slabs, ball_test, cuboid_test, ends_test, slab_test,
};

/// Nodes that the loops go through: their shapes stay in the nearest cache.
const NODES: usize = 16;

/// Nanoseconds of each kind of test.
#[derive(Debug, Clone, Copy)]
pub(super) struct TestCosts {
    /// Balls.
    pub(super) ball: f64,
    /// Balls, and each slab against the other's ball.
    pub(super) slab_and_ball: f64,
    /// Those, and slabs against slabs.
    pub(super) slab_and_slab: f64,
    /// Intervals along three directions: boxes in one frame.
    pub(super) three: f64,
    /// Along six: boxes in two frames, hulls made with the update.
    pub(super) six: f64,
    /// 7-DOPs in two frames.
    pub(super) fourteen: f64,
    /// 13-DOPs in two frames.
    pub(super) twenty_six: f64,
    /// Boxes with their own axes, their faces' axes.
    pub(super) faces: f64,
    /// The same and all products of edges.
    pub(super) full: f64,
}

impl TestCosts {
    /// Nanoseconds of testing one lane against a node's eight; of mixtures, the dearer kind.
    pub(super) fn of(&self, contender: &Contender) -> f64 {
        let boxes = match (contender.bound, contender.boxes) {
            (_, BoxTest::Hull) => self.three,
            (
                Bound::Aabb | Bound::BallAndAabb | Bound::LeafAabb | Bound::InnerAabb,
                BoxTest::Faces,
            ) => self.six,
            (_, BoxTest::Faces) => self.faces,
            (_, BoxTest::Full) => self.full,
        };
        match contender.bound {
            Bound::Ball(_)
            | Bound::Affine(_)
            | Bound::BestOf(_)
            | Bound::Wrapped
            | Bound::LeafWrapped
            | Bound::Smallest => self.ball,
            Bound::BallAndAabb | Bound::BallAndObb => self.ball + boxes,
            Bound::Dop(7) => self.fourteen,
            Bound::Dop(_) => self.twenty_six,
            Bound::Disc | Bound::TurningDisc | Bound::LeafTurningDisc => match contender.boxes {
                BoxTest::Full => self.slab_and_slab,
                _ => self.slab_and_ball,
            },
            _ => boxes,
        }
    }

    /// Measures them, medians of rounds taken in turns.
    pub(super) fn measure() -> Self {
        let balls = fill::<Balls, 4>();
        let slabs: Vec<(Balls, Slabs)> = balls.iter().copied().zip(fill::<Slabs, 7>()).collect();
        let three = fill_ends::<3>();
        let six = fill_ends::<6>();
        let fourteen = fill_ends::<14>();
        let twenty_six = fill_ends::<26>();
        let cuboids = fill::<Cuboids, 15>();
        let mut rounds: [Vec<f64>; 9] = Default::default();
        for _ in 0..31 {
            rounds[0].push(per_test(&balls, ball_test));
            rounds[1].push(per_test(&slabs, slab_test::<false>));
            rounds[2].push(per_test(&slabs, slab_test::<true>));
            rounds[3].push(per_test(&three, ends_test));
            rounds[4].push(per_test(&six, ends_test));
            rounds[5].push(per_test(&fourteen, ends_test));
            rounds[6].push(per_test(&twenty_six, ends_test));
            rounds[7].push(per_test(&cuboids, cuboid_test::<false>));
            rounds[8].push(per_test(&cuboids, cuboid_test::<true>));
        }
        let [
            ball,
            slab_and_ball,
            slab_and_slab,
            three,
            six,
            fourteen,
            twenty_six,
            faces,
            full,
        ] = rounds.map(|round| median(&round));
        Self {
            ball,
            slab_and_ball,
            slab_and_slab,
            three,
            six,
            fourteen,
            twenty_six,
            faces,
            full,
        }
    }
}

/// Nanoseconds of an update with `N` multiply-add rows per mode and `modes` modes.
pub(super) fn update_ns<const N: usize>(modes: usize) -> f64 {
    let rows: Vec<[Row; N]> = (0..NODES * modes).map(|k| [row(k as u32); N]).collect();
    let q: Vec<f32> = (0..modes).map(|j| 0.01 * (j as f32 + 1.0)).collect();
    let mut rounds = Vec::new();
    for _ in 0..31 {
        let start = Instant::now();
        let passes = 200;
        for _ in 0..passes {
            for node in black_box(&rows).chunks_exact(modes) {
                black_box(sums(node, &q));
            }
        }
        rounds.push(start.elapsed().as_secs_f64() * 1e9 / (passes * NODES) as f64);
    }
    median(&rounds)
}

#[inline(never)]
fn sums<const N: usize>(node: &[[Row; N]], q: &[f32]) -> [Row; N] {
    let mut sums = [[0.0; LANES]; N];
    for (mode, q) in node.iter().zip(q) {
        for i in 0..N {
            for k in 0..LANES {
                sums[i][k] += mode[i][k] * *q;
            }
        }
    }
    sums
}

/// Nanoseconds of deforming a vertex with `modes` modes.
pub(super) fn vertex_ns(modes: usize) -> f64 {
    let fields: Vec<[f32; 3]> = (0..NODES * LANES * modes)
        .map(|k| [row(k as u32)[0]; 3])
        .collect();
    let q: Vec<f32> = (0..modes).map(|j| 0.01 * (j as f32 + 1.0)).collect();
    let mut rounds = Vec::new();
    for _ in 0..31 {
        let start = Instant::now();
        let passes = 200;
        for _ in 0..passes {
            for vertex in black_box(&fields).chunks_exact(modes) {
                let mut sum = [0.0_f32; 3];
                for (u, q) in vertex.iter().zip(&q) {
                    for k in 0..3 {
                        sum[k] += u[k] * q;
                    }
                }
                black_box(sum);
            }
        }
        rounds.push(start.elapsed().as_secs_f64() * 1e9 / (passes * NODES * LANES) as f64);
    }
    median(&rounds)
}

/// Nanoseconds of testing one lane of a node against all eight of another.
fn per_test<T>(nodes: &[T], test: impl Fn(&T, usize, &T) -> [bool; LANES]) -> f64 {
    let start = Instant::now();
    let mut met = 0;
    let passes = 4;
    for _ in 0..passes {
        let nodes = black_box(nodes);
        for a in nodes {
            for b in nodes {
                for lane in 0..LANES {
                    let mask = test(a, lane, b);
                    let mut bits = 0_u32;
                    for k in 0..LANES {
                        bits |= u32::from(mask[k]) << k;
                    }
                    met ^= bits;
                }
            }
        }
    }
    black_box(met);
    start.elapsed().as_secs_f64() * 1e9 / (passes * NODES * NODES * LANES) as f64
}

fn row(seed: u32) -> Row {
    let mut x = seed.wrapping_mul(0x9E37_79B9) | 1;
    [0; LANES].map(|_| {
        x = x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (x >> 8) as f32 / (1 << 24) as f32
    })
}

fn fill<T: From<[Row; N]>, const N: usize>() -> Vec<T> {
    let node = |n: usize| T::from(std::array::from_fn(|i| row((n * N + i) as u32)));
    (0..NODES).map(node).collect()
}

fn fill_ends<const K: usize>() -> Vec<Ends<K>> {
    let node = |n: usize| {
        std::array::from_fn(|i| {
            let low = row((n * K + i) as u32);
            [low, low.map(|x| x + 0.3)]
        })
    };
    (0..NODES).map(node).collect()
}
