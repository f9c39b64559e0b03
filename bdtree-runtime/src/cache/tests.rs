//! Tests: spheres that are kept over steps, reported as proxies, or carried to another frame hold every
//! vertex below them, decided in exact arithmetic. (Spheres as evaluated: `bdtree verify --stress`.)

use std::vec::Vec;

use bdtree_format::LANES;
use num_rational::BigRational;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::bound::{Spheres, WideSpheres};
use crate::cache::{CacheSize, Kept, Posed, StepCache};
use crate::depth::proxy;
use crate::epoch::Drift;
use crate::error::FormatError;
use crate::pair_frame::PairFrame;
use crate::placement::Placement;
use crate::simd::{Compact, Lanes, Work};
use crate::view::Asset;
use crate::{Kernel, LaneId, Pose, Transform, VertexId};

/// Of the golden files: all modes, few modes per vertex, frames, a single triangle per lane.
const FILES: [&[u8]; 4] = [
    crate::include_bdt!("../../../fixtures/golden/sphere.bdt"),
    crate::include_bdt!("../../../fixtures/golden/sparse.bdt"),
    crate::include_bdt!("../../../fixtures/golden/animated.bdt"),
    crate::include_bdt!("../../../fixtures/golden/tetrahedron.bdt"),
];

/// Rounds per file and test.
const ROUNDS: usize = 60;

struct Random(Pcg64Mcg);

impl Random {
    fn sign(&mut self) -> f64 {
        if self.0.random() { 1.0 } else { -1.0 }
    }

    /// q of several kinds within the limits.
    fn q(&mut self, asset: &Asset<'_>, kind: usize) -> Vec<f32> {
        let size = 10_f64.powf(self.0.random_range(-5.0..1.0));
        let one = self.0.random_range(0..asset.mode_count().max(1));
        let of_mode = |(j, mode): (usize, &bdtree_format::ModeRecord)| {
            let (range, limit) = (f64::from(mode.q_range.get()), mode.q_limit.get());
            let q = match kind % 5 {
                0 => self.0.random_range(-1.0..1.0) * size * range,
                1 => self.sign() * f64::from(limit),
                2 => self.sign() * 1e-42,
                3 => f64::from(u8::from(j == one)) * self.sign() * size * range,
                _ => self.sign() * size * range,
            };
            (q as f32).clamp(-limit, limit)
        };
        asset.modes().iter().enumerate().map(of_mode).collect()
    }

    /// q, and one near it or anywhere.
    fn step(&mut self, asset: &Asset<'_>, round: usize) -> [Vec<f32>; 2] {
        let from = self.q(asset, round);
        let mut to = self.q(asset, round / 5);
        if round.is_multiple_of(2) {
            let share = 10_f64.powf(self.0.random_range(-7.0..-1.0)) as f32;
            for (to, from) in to.iter_mut().zip(&from) {
                *to = from + share * (*to - from);
            }
        }
        [from, to]
    }

    /// Near, turned, far away, small and large.
    fn place(&mut self) -> Transform {
        let mut any = || self.0.random_range(-1.0..1.0);
        let rotation: [f64; 4] = [any(), any(), any(), any()];
        let translation: [f64; 3] = [any(), any(), any()];
        let norm = rotation.iter().map(|x| x * x).sum::<f64>().sqrt();
        let far = [0.0, 1.0, 1e3, 1e8, 1e12][self.0.random_range(0..5)];
        Transform {
            rotation: rotation.map(|x| x / norm),
            translation: translation.map(|x| x * far),
            scale: [1.0, 1e-3, 0.37, 1e3][self.0.random_range(0..4)],
        }
    }
}

/// The vertices below lane `lane` of `node`.
fn below(asset: &Asset<'_>, node: u32, lane: usize, out: &mut Vec<VertexId>) {
    let record = &asset.nodes()[node as usize];
    let bit = 1_u8 << lane;
    if record.leaf_mask & bit != 0 {
        let counts = record.leaf_counts.map(usize::from);
        let start = record.first_slot as usize + counts[..lane].iter().sum::<usize>();
        let triangles = &asset.triangles()[start..start + counts[lane]];
        out.extend(triangles.iter().flat_map(|t| t.corners).map(VertexId));
    } else if record.inner_mask & bit != 0 {
        let child = record.first_child + (record.inner_mask & (bit - 1)).count_ones();
        for lane in 0..LANES {
            below(asset, child, lane, out);
        }
    }
}

fn exact(x: f64) -> BigRational {
    BigRational::from_float(x).expect("finite")
}

fn is_within(x: [BigRational; 3], center: [BigRational; 3], radius: BigRational) -> bool {
    let squares = x.into_iter().zip(center).map(|(x, c)| {
        let d = x - c;
        &d * &d
    });
    squares.sum::<BigRational>() <= &radius * &radius
}

/// Whether ‖x − center‖ ≤ radius.
fn holds(center: [f64; 3], radius: f64, x: [f64; 3]) -> bool {
    let square: f64 = (0..3)
        .map(|k| (x[k] - center[k]) * (x[k] - center[k]))
        .sum();
    // 5 · 2⁻⁵³ is what f64 may lose.
    square * (1.0 + 1e-15) < radius * radius
        || is_within(x.map(exact), center.map(exact), exact(radius))
}

fn kernels<'a>(asset: Asset<'a>) -> impl Iterator<Item = Asset<'a>> {
    Kernel::ALL
        .into_iter()
        .filter_map(move |kernel| asset.with_kernel(kernel))
}

/// The spheres that a traversal sees, carried to another frame if there is one.
struct Seen<'w, 's, 'a> {
    asset: &'w Asset<'a>,
    posed: Posed<'s>,
    node: u32,
    to: Option<&'w PairFrame>,
}

impl Work for Seen<'_, '_, '_> {
    type Output = Result<Spheres, FormatError>;

    #[inline(always)]
    fn run<L: Lanes>(mut self) -> Self::Output {
        let mut out = WideSpheres::<L>::empty();
        self.posed.spheres(self.asset, self.node, &mut out)?;
        let out = self.to.map_or(out, |frame| frame.carry(out));
        Ok(out.store())
    }
}

/// The spheres of a node, as [`Seen`] with the asset's kernel.
fn seen(asset: &Asset<'_>, posed: Posed<'_>, node: u32, to: Option<&PairFrame>) -> Spheres {
    let seen = Seen {
        asset,
        posed,
        node,
        to,
    };
    asset.kernel().run(seen).expect("a node")
}

/// A lane of [`Spheres`] in f64.
fn lane_sphere(spheres: &Spheres, lane: usize) -> ([f64; 3], f64) {
    let center = spheres.center.map(|row| f64::from(row[lane]));
    (center, f64::from(spheres.radius[lane]))
}

/// Calls `check` with node, lane and vertices of all lanes that have any.
fn for_lanes(asset: &Asset<'_>, mut check: impl FnMut(u32, usize, &[VertexId])) {
    let mut vertices = Vec::new();
    for node in 0..asset.node_count() as u32 {
        for lane in 0..LANES {
            vertices.clear();
            below(asset, node, lane, &mut vertices);
            if !vertices.is_empty() {
                check(node, lane, &vertices);
            }
        }
    }
}

/// Runs `check` with kernels, steps and placements, in turn for each file.
fn rounds(seed: u64, mut check: impl FnMut(&Asset<'_>, &mut Random, usize)) {
    for (bytes, seed) in FILES.into_iter().zip(seed..) {
        let asset = Asset::open(bytes).expect("a golden file");
        let mut random = Random(Pcg64Mcg::seed_from_u64(seed));
        for round in 0..ROUNDS {
            for asset in kernels(asset) {
                check(&asset, &mut random, round);
            }
        }
    }
}

/// The poses of a step, each in its placement: the reference and what follows it.
fn poses<'m>(
    asset: &'m Asset<'m>,
    q: &[Vec<f32>; 2],
    places: [Transform; 2],
    [first, second]: &'m mut [Vec<f32>; 2],
) -> [Pose<'m>; 2] {
    [(0, first), (1, second)].map(|(k, memory)| asset.pose(&q[k], places[k], memory).expect("pose"))
}

/// A pose with its cache.
fn kept<'s>(pose: &'s Pose<'s>, cache: &'s mut StepCache<'_>) -> Posed<'s> {
    Posed::new(pose, None, cache.slots(), None)
}

/// A pose of which nothing is kept.
fn alone<'s>(pose: &'s Pose<'s>) -> Posed<'s> {
    Posed::new(pose, None, Kept::nothing(), None)
}

/// A pose that follows another, with which the cache was started.
fn following<'s>(
    pose: &'s Pose<'s>,
    reference: &'s Pose<'s>,
    cache: &'s mut StepCache<'_>,
) -> Posed<'s> {
    let drift = Drift::new(reference, pose).expect("of one asset");
    let slots = cache.slots();
    Posed::new(pose, Some((reference, drift)), slots, None)
}

/// A cache of so many nodes.
fn cache(nodes: usize) -> StepCache<'static> {
    StepCache::new(CacheSize { nodes, leaves: 0 })
}

#[test]
fn spheres_kept_over_a_step() {
    let mut held = 0;
    rounds(1, |asset, random, round| {
        let q = random.step(asset, round);
        let place = random.place();
        let mut memory = [vec(asset), vec(asset)];
        let [reference, pose] = poses(asset, &q, [place; 2], &mut memory);
        let mut cache = cache(asset.node_count());
        for first in 0..2 {
            // Evaluated at the reference before it is left, and first visited afterwards.
            cache.start(&reference);
            for node in (first..asset.node_count() as u32).step_by(2) {
                seen(asset, kept(&reference, &mut cache), node, None);
            }
            assert!(cache.follow());
            for_lanes(asset, |node, lane, vertices| {
                let posed = following(&pose, &reference, &mut cache);
                let spheres = seen(asset, posed, node, None);
                let (center, radius) = lane_sphere(&spheres, lane);
                for v in vertices {
                    let x = pose.deformed_stored(*v).expect("a vertex").map(f64::from);
                    assert!(
                        holds(center, radius, x),
                        "node {node}, lane {lane}, {v:?}, {q:?}"
                    );
                    held += 1;
                }
            });
        }
    });
    assert!(held > 100_000);
}

#[test]
fn proxies_in_the_world() {
    let mut held = 0;
    rounds(2, |asset, random, round| {
        let q = random.step(asset, round);
        let place = random.place();
        let mut memory = [vec(asset), vec(asset)];
        let [reference, pose] = poses(asset, &q, [random.place(), place], &mut memory);
        let mut cache = cache(64);
        cache.start(&reference);
        assert!(cache.follow());
        for_lanes(asset, |node, lane, vertices| {
            let mut posed = if round % 3 == 0 {
                following(&pose, &reference, &mut cache)
            } else {
                alone(&pose)
            };
            let mut spheres = WideSpheres::<Compact>::empty();
            posed.spheres(asset, node, &mut spheres).expect("a node");
            let id = LaneId {
                node,
                lane: lane as u8,
            };
            let proxy = proxy(&pose, &spheres.store(), id);
            for v in vertices {
                let x = pose.deformed(*v).expect("a vertex");
                assert!(
                    holds(proxy.center, proxy.radius, x),
                    "node {node}, lane {lane}, {v:?}, {q:?}, {place:?}"
                );
                held += 1;
            }
        });
    });
    assert!(held > 100_000);
}

/// What [`Placement::world`] rounds, not rounded.
fn exactly_in_world(frame: &Placement, stored: [f64; 3]) -> [BigRational; 3] {
    let numbers = frame.numbers();
    let numbers = numbers.as_flattened().iter().copied();
    let n: Vec<BigRational> = numbers.map(exact).collect();
    let (rotation, translation, origin) = (&n[..9], &n[9..12], &n[12..15]);
    let (scale, unit) = (&n[15], &n[16]);
    let mesh = [0, 1, 2].map(|k| &origin[k] + unit * exact(stored[k]));
    [0, 1, 2].map(|i| {
        let turned: BigRational = (0..3).map(|k| &rotation[3 * i + k] * &mesh[k]).sum();
        &translation[i] + scale * turned
    })
}

#[test]
fn spheres_in_another_frame() {
    let mut held = 0;
    rounds(3, |asset, random, round| {
        let other =
            Asset::open(FILES[random.0.random_range(0..FILES.len())]).expect("a golden file");
        let q = random.step(asset, round);
        let near = random.q(&other, round + 1);
        let (mut memory, mut of_other) = ([vec(asset), vec(asset)], vec(&other));
        let place = random.place();
        let here = other
            .pose(&near, random.place(), &mut of_other)
            .expect("pose");
        // The second where the first is, far from the world's origin or not.
        let place = Transform {
            translation: here.placement.origin_in_world(),
            ..place
        };
        let [reference, pose] = poses(asset, &q, [place; 2], &mut memory);
        let mut cache = cache(64);
        cache.start(&reference);
        assert!(cache.follow());
        let posed = match round % 3 {
            0 => following(&pose, &reference, &mut cache),
            _ => alone(&pose),
        };
        let frame = PairFrame::new(&alone(&here), &posed, 0.0);
        let frame = frame.expect("one stands in the other");
        let per_stored = here.placement.world_per_stored();
        for_lanes(asset, |node, lane, vertices| {
            let posed = match round % 3 {
                0 => following(&pose, &reference, &mut cache),
                _ => alone(&pose),
            };
            let (center, radius) = lane_sphere(&seen(asset, posed, node, Some(&frame)), lane);
            let center = exactly_in_world(&here.placement, center);
            let radius = exact(radius) * exact(per_stored);
            for v in vertices.iter().step_by(7) {
                let x = pose.deformed(*v).expect("a vertex").map(exact);
                assert!(
                    is_within(x, center.clone(), radius.clone()),
                    "node {node}, lane {lane}, {v:?}, {q:?}, {place:?}"
                );
                held += 1;
            }
        });
    });
    assert!(held > 20_000, "{held}");
}

fn vec(asset: &Asset<'_>) -> Vec<f32> {
    std::vec![0.0; asset.pose_len()]
}
