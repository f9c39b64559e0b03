//! Deformed triangles with their boxes, so that brute force passes over what is plainly far away.
//!
//! Boxes only ever rule triangles out, by a margin of 10⁻¹² of the largest coordinate difference
//! between the two things compared: more than 70 times the rounding that `narrow` states for any of
//! its distances and rays.

use std::ops::Deref;

use bdtree_runtime::narrow::{OrientedBox, Triangle};

const ROUNDING: f64 = 1e-12;
/// Triangles per group of [`Body::groups`].
const GROUP: usize = 32;

/// An axis-aligned box.
#[derive(Debug, Clone, Copy)]
pub struct Bounds {
    low: [f64; 3],
    high: [f64; 3],
}

impl Bounds {
    /// The box around some points.
    pub fn of(points: &[[f64; 3]]) -> Self {
        let mut all = Self::NOTHING;
        for x in points {
            all.add(&Self { low: *x, high: *x });
        }
        all
    }

    /// The box around an oriented box.
    pub fn of_box(shape: &OrientedBox) -> Self {
        let (c, half, axes) = (shape.center(), shape.half_extents(), shape.axes());
        let reach = |k: usize| (0..3).map(|i| axes[i][k].abs() * half[i]).sum::<f64>();
        Self {
            low: [0, 1, 2].map(|k| c[k] - reach(k)),
            high: [0, 1, 2].map(|k| c[k] + reach(k)),
        }
    }

    const NOTHING: Self = Self {
        low: [f64::INFINITY; 3],
        high: [f64::NEG_INFINITY; 3],
    };

    fn add(&mut self, other: &Self) {
        for k in 0..3 {
            self.low[k] = self.low[k].min(other.low[k]);
            self.high[k] = self.high[k].max(other.high[k]);
        }
    }

    /// No computed distance of what two boxes hold is below this.
    pub fn apart(&self, other: &Self) -> f64 {
        let (mut squared, mut reach) = (0.0, 0.0_f64);
        for k in 0..3 {
            let [below, above] = [self.low[k] - other.high[k], other.low[k] - self.high[k]];
            let gap = below.max(above).max(0.0);
            squared += gap * gap;
            reach = reach.max(-below).max(-above).max(gap);
        }
        squared.sqrt() - ROUNDING * reach
    }

    /// Whether `origin + t · direction` leaves out the box widened by `radius`, for all t from 0 to
    /// `limit`; not said where rounding could decide.
    fn is_missed(&self, line: &Line, radius: f64) -> bool {
        let Line {
            origin, inverse, ..
        } = line;
        let reach = (0..3).fold(0.0_f64, |m, k| {
            let [from, to] = line.ends[k];
            m.max(self.high[k] - from).max(to - self.low[k])
        });
        let room = radius + ROUNDING * reach;
        let (mut first, mut last) = (0.0_f64, line.limit);
        for k in 0..3 {
            // 0 · ∞ is no number, which min and max pass over.
            let s = (self.low[k] - origin[k] - room) * inverse[k];
            let t = (self.high[k] - origin[k] + room) * inverse[k];
            if s.is_nan() || t.is_nan() {
                continue;
            }
            first = first.max(s.min(t));
            last = last.min(s.max(t));
        }
        first > last
    }
}

/// A part of a line.
struct Line {
    origin: [f64; 3],
    inverse: [f64; 3],
    limit: f64,
    /// Of the points that count for rounding, the least and the largest of each coordinate.
    ends: [[f64; 2]; 3],
}

/// All triangles of a deformed mesh, by id.
#[derive(Debug, Clone)]
pub struct Body {
    triangles: Vec<Triangle>,
    bounds: Vec<Bounds>,
}

impl Deref for Body {
    type Target = [Triangle];

    fn deref(&self) -> &[Triangle] {
        &self.triangles
    }
}

impl Body {
    /// The body of these triangles.
    pub fn new(triangles: Vec<Triangle>) -> Self {
        let bounds = triangles.iter().map(|t| Bounds::of(t)).collect();
        Self { triangles, bounds }
    }

    /// The box of each triangle.
    pub fn bounds(&self) -> &[Bounds] {
        &self.bounds
    }

    /// The triangles, by id, but for those plainly farther than `distance` from what `shape` holds.
    pub fn near(&self, shape: Bounds, distance: f64) -> impl Iterator<Item = (u32, &Triangle)> {
        self.but_for(move |b| b.apart(&shape) > distance)
    }

    /// The triangles, by id, but for those plainly missed by a ray.
    pub fn along(
        &self,
        origin: [f64; 3],
        direction: [f64; 3],
        limit: f64,
    ) -> impl Iterator<Item = (u32, &Triangle)> {
        let line = Line {
            origin,
            inverse: direction.map(|d| 1.0 / d),
            limit,
            ends: origin.map(|x| [x, x]),
        };
        self.but_for(move |b| b.is_missed(&line, 0.0))
    }

    /// The triangles, by id, but for those plainly farther than `radius` from a segment.
    pub fn about(
        &self,
        [p, q]: [[f64; 3]; 2],
        radius: f64,
    ) -> impl Iterator<Item = (u32, &Triangle)> {
        let line = Line {
            origin: p,
            inverse: [0, 1, 2].map(|k| 1.0 / (q[k] - p[k])),
            limit: 1.0,
            ends: [0, 1, 2].map(|k| [p[k].min(q[k]), p[k].max(q[k])]),
        };
        self.but_for(move |b| b.is_missed(&line, radius))
    }

    fn but_for(&self, is_far: impl Fn(&Bounds) -> bool) -> impl Iterator<Item = (u32, &Triangle)> {
        (0..)
            .zip(&self.triangles)
            .zip(&self.bounds)
            .filter(move |(_, b)| !is_far(b))
            .map(|(t, _)| t)
    }

    /// All ids, in groups of few triangles that lie near each other, each with the box around them.
    pub fn groups(&self) -> Vec<(Bounds, Vec<u32>)> {
        let mut groups = Vec::new();
        let mut todo = vec![(0..self.len() as u32).collect::<Vec<u32>>()];
        while let Some(mut ids) = todo.pop() {
            let mut around = Bounds::NOTHING;
            for id in &ids {
                around.add(&self.bounds[*id as usize]);
            }
            if ids.len() <= GROUP {
                groups.push((around, ids));
                continue;
            }
            let width = |k: &usize| around.high[*k] - around.low[*k];
            let widest = (0..3).max_by(|i, j| width(i).total_cmp(&width(j)));
            let k = widest.expect("three axes");
            let middle = |id: &u32| {
                let b = &self.bounds[*id as usize];
                b.low[k] + b.high[k]
            };
            let half = ids.len() / 2;
            ids.select_nth_unstable_by(half, |i, j| middle(i).total_cmp(&middle(j)));
            let rest = ids.split_off(half);
            todo.extend([ids, rest]);
        }
        groups
    }
}
