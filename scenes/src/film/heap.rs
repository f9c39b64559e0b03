//! A heap of bodies that stand still: what the time of drawing is measured on.

use std::error::Error;

use bdtree_render::Body;
use bdtree_runtime::{Asset, Transform};

use super::look::colour;
use crate::workloads::random::Stream;

/// Bodies' reach as spheres, in shares of the largest radius: how near they lie.
const NEAR: f64 = 0.42;
/// Places that each body tries, of which it takes the lowest.
const TRIES: usize = 5;

/// Bodies of one asset, each with its q and its place.
#[derive(Debug, Clone)]
pub struct Heap {
    /// A number per mode, body behind body.
    q: Vec<f32>,
    places: Vec<Transform>,
    modes: usize,
    /// Its height above the floor, which is at 0.
    pub height: f64,
    /// How far it reaches from the middle, but for a few bodies beside it.
    pub radius: f64,
}

impl Heap {
    /// So many bodies, dropped one after the other where the heap is low; equal seeds give equal heaps.
    ///
    /// # Errors
    /// An asset that cannot be posed.
    pub fn new(asset: &Asset<'_>, count: usize, seed: u64) -> Result<Self, Box<dyn Error>> {
        let mut stream = Stream::new(seed);
        let modes = asset.mode_count();
        let mut memory = vec![0.0; asset.pose_len()];
        let mut heap = Self {
            q: Vec::with_capacity(count * modes),
            places: Vec::with_capacity(count),
            modes,
            height: 0.0,
            radius: 0.0,
        };
        let rest = vec![0.0; modes];
        let pose = asset.pose(&rest, Transform::IDENTITY, &mut memory)?;
        let size = pose.bounding_sphere()?.radius;
        let near = NEAR * size;
        // As wide as a heap is whose bodies fill its cone.
        let spread = 0.78 * near * (count as f64).cbrt();
        let mut balls: Vec<[f64; 3]> = Vec::with_capacity(count);
        for _ in 0..count {
            let ranges = asset.modes().iter().map(|mode| mode.q_range.get());
            let q: Vec<f32> = ranges
                .map(|range| (0.4 * stream.signed()) as f32 * range)
                .collect();
            let turned = Transform {
                rotation: stream.rotation(),
                ..Transform::IDENTITY
            };
            let pose = asset.pose(&q, turned, &mut memory)?;
            let (middle, lowest) = (pose.bounding_sphere()?.center, pose.exact_aabb()?.min[1]);
            let places = (0..TRIES).map(|_| {
                // Sums of few numbers lie in the middle more often.
                let mut aside = || (0..3).map(|_| stream.signed()).sum::<f64>() * spread;
                let (x, z) = (aside(), aside());
                let on_floor = middle[1] - lowest;
                [x, landed(&balls, x, z, on_floor, near), z]
            });
            let lower = |a: [f64; 3], b: [f64; 3]| if b[1] < a[1] { b } else { a };
            let place = places.reduce(lower).unwrap_or_default();
            balls.push(place);
            heap.height = heap.height.max(place[1] + near);
            heap.q.extend(q);
            heap.places.push(Transform {
                translation: [0, 1, 2].map(|k| place[k] - middle[k]),
                ..turned
            });
        }
        let mut away: Vec<f64> = balls.iter().map(|[x, _, z]| x.hypot(*z)).collect();
        away.sort_by(f64::total_cmp);
        heap.radius = away.get(away.len() * 9 / 10).map_or(size, |a| a + size);
        Ok(heap)
    }

    /// The bodies, to draw.
    pub fn bodies(&self) -> Vec<Body<'_>> {
        let of = |(number, place): (usize, &Transform)| {
            let q = &self.q[number * self.modes..][..self.modes];
            Body::new(0, q, *place, colour(number))
        };
        self.places.iter().enumerate().map(of).collect()
    }
}

/// How high a ball lies that falls onto others or onto the floor.
fn landed(balls: &[[f64; 3]], x: f64, z: f64, on_floor: f64, radius: f64) -> f64 {
    let reach = 4.0 * radius * radius;
    let heights = balls.iter().filter_map(|[a, y, b]| {
        let apart = (a - x) * (a - x) + (b - z) * (b - z);
        (apart < reach).then(|| y + (reach - apart).sqrt())
    });
    heights.fold(on_floor, f64::max)
}
