//! What the scene knows of the bridge: its motion over time, how high it is, whether anything went through it.

use std::error::Error;

use bdtree_format::Metadata;
use bdtree_runtime::{Asset, Instance, Model, Ray, Transform, VertexId, Workspace};
use serde_json::{Value, json};

use crate::falling::waves::Heights;

/// The last frame is the first one again, to this share of each mode's range.
const CLOSED: f64 = 1e-3;

/// Frames are equally far apart in time, to this share.
const EVEN: f64 = 1e-6;

/// Parts along the bridge of which the highest points are known.
const PARTS: usize = 24;

/// A bridge that moves as its animation says, over and over.
pub(super) struct Bridge {
    pub(super) model: Model,
    /// Of each frame but the last, which is the first one again.
    q: Vec<Vec<f64>>,
    frame_s: f64,
    instance: Instance,
    workspace: Workspace<'static>,
    /// A vertex of its underside in the middle.
    middle: VertexId,
}

impl Bridge {
    /// # Errors
    /// An asset without an animation, or with one that cannot be repeated.
    pub(super) fn new(model: Model) -> Result<Self, Box<dyn Error>> {
        let asset = model.asset();
        let wrong = |what: &str| format!("the bridge: {what}");
        let count = asset.frame_count();
        if count < 4 {
            return Err(wrong("its animation has fewer than four frames").into());
        }
        let duration = asset.duration_s().filter(|duration| *duration > 0.0);
        let duration = duration.ok_or_else(|| wrong("its frames have no times"))?;
        let frame_s = duration / (count - 1) as f64;
        let mut q = Vec::with_capacity(count);
        for index in 0..count {
            let frame = asset.frame(index).ok_or_else(|| wrong("no frame"))?;
            let off = frame.time_s().unwrap_or(f64::NAN) - index as f64 * frame_s;
            if !(off.abs() <= EVEN * duration) {
                return Err(wrong("its frames are not equally far apart in time").into());
            }
            if frame.transform() != Transform::IDENTITY {
                return Err(wrong("moves as a whole: bake it without --align").into());
            }
            q.push(frame.q().iter().copied().map(f64::from).collect::<Vec<_>>());
        }
        let last = q.pop().unwrap_or_default();
        let ranges = asset
            .modes()
            .iter()
            .map(|mode| f64::from(mode.q_range.get()));
        let mut ends = last.iter().zip(&q[0]).zip(ranges);
        if !ends.all(|((last, first), range)| (last - first).abs() <= CLOSED * range) {
            return Err(wrong("its last frame is not the first one again").into());
        }
        let middle = middle(asset);
        Ok(Self {
            instance: Instance::new(&model)?,
            model,
            q,
            frame_s,
            workspace: Workspace::new(),
            middle,
        })
    }

    /// Seconds after which it moves as before.
    pub(super) fn period_s(&self) -> f64 {
        self.q.len() as f64 * self.frame_s
    }

    /// q at a time: a smooth curve through the frames (Catmull and Rom), so that its speed does not jump at them.
    pub(super) fn q(&self, time_s: f64) -> Vec<f64> {
        let at = time_s / self.frame_s;
        let share = at - at.floor();
        let count = self.q.len() as i64;
        let frame = |off: i64| &self.q[(at.floor() as i64 + off).rem_euclid(count) as usize];
        let [before, a, b, after] = [-1, 0, 1, 2].map(frame);
        let mode = |j: usize| {
            let [p, a, b, n] = [before[j], a[j], b[j], after[j]];
            let linear = 0.5 * (b - p);
            let square = p - 2.5 * a + 2.0 * b - 0.5 * n;
            let cube = 1.5 * (a - b) + 0.5 * (n - p);
            a + share * (linear + share * (square + share * cube))
        };
        (0..a.len()).map(mode).collect()
    }

    /// Where the middle of its underside is, relative to its rest, m.
    pub(super) fn sway(&mut self, time_s: f64) -> Result<[f64; 3], Box<dyn Error>> {
        self.place(time_s)?;
        let asset = self.model.asset();
        let now = self.instance.pose().deformed(self.middle)?;
        let rest = position(asset, self.middle.0 as usize);
        Ok([0, 1, 2].map(|k| now[k] - rest[k]))
    }

    fn place(&mut self, time_s: f64) -> Result<(), Box<dyn Error>> {
        let q: Vec<f32> = self.q(time_s).into_iter().map(|q| q as f32).collect();
        Ok(self.instance.set_pose(&q, Transform::IDENTITY)?)
    }

    /// How many of these ways meet a triangle of the bridge as it is at a time.
    pub(super) fn crossed(
        &mut self,
        time_s: f64,
        ways: impl Iterator<Item = [[f64; 3]; 2]>,
    ) -> Result<u64, Box<dyn Error>> {
        self.place(time_s)?;
        let bounds = self.instance.aabb()?;
        let mut rays = Vec::new();
        for [from, to] in ways {
            let direction = [0, 1, 2].map(|k| to[k] - from[k]);
            let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
            let ray = Ray {
                max_distance: length,
                ..Ray::new(from, direction)
            };
            if length > 0.0 && bounds.intersects_ray(&ray) {
                rays.push(ray);
            }
        }
        let mut hits = vec![false; rays.len()];
        let mut query = self.instance.query(&mut self.workspace);
        query.intersects_rays(&rays, &mut hits)?;
        Ok(hits.iter().filter(|hit| **hit).count() as u64)
    }

    /// Least and largest coordinates at rest.
    pub(super) fn bounds(&self) -> [[f64; 3]; 2] {
        let asset = self.model.asset();
        let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        for p in (0..asset.vertex_count()).map(|vertex| position(asset, vertex)) {
            for k in 0..3 {
                bounds[0][k] = bounds[0][k].min(p[k]);
                bounds[1][k] = bounds[1][k].max(p[k]);
            }
        }
        bounds
    }

    /// How high it is along x at rest.
    pub(super) fn heights(&self) -> Heights {
        let asset = self.model.asset();
        let [low, high] = self.bounds();
        let part = (high[0] - low[0]) / PARTS as f64;
        let mut tops = vec![low[1]; PARTS];
        for p in (0..asset.vertex_count()).map(|vertex| position(asset, vertex)) {
            // A beam between two points of different parts is as high in both.
            let at = (p[0] - low[0]) / part;
            for at in [at - 0.5, at + 0.5] {
                let top = &mut tops[(at.max(0.0) as usize).min(PARTS - 1)];
                *top = top.max(p[1]);
            }
        }
        Heights {
            from: low[0],
            part,
            tops,
        }
    }

    /// How well its components keep the motion that they were made of.
    pub(super) fn told(&self) -> Result<Value, Box<dyn Error>> {
        let asset = self.model.asset();
        let [low, high] = self.bounds();
        let diagonal = (0..3).map(|k| (high[k] - low[k]).powi(2)).sum::<f64>();
        let mut told = json!({"vertices": asset.vertex_count(), "triangles": asset.triangle_count(),
            "modes": asset.mode_count(), "frames": self.q.len(), "period_s": self.period_s()});
        let error = match asset.metadata() {
            [] => None,
            bytes => Metadata::from_bytes(bytes)?.basis_error_rel,
        };
        if let (Value::Object(told), Some(error)) = (&mut told, error) {
            // Components are orthonormal: the mean square of what they move vertices by.
            let squares = self.q.iter().flatten().map(|q| q * q).sum::<f64>();
            let moved = squares / (self.q.len() * asset.vertex_count()) as f64;
            let lost = error.rms * error.rms * diagonal;
            told.extend([
                ("error_max_m".into(), json!(error.max * diagonal.sqrt())),
                ("error_rms_m".into(), json!(lost.sqrt())),
                ("motion_rms_m".into(), json!(moved.sqrt())),
                ("share_lost".into(), json!(lost / (lost + moved))),
            ]);
        }
        Ok(told)
    }
}

/// Where a vertex is at rest.
fn position(asset: &Asset<'_>, vertex: usize) -> [f64; 3] {
    let stored = asset.positions()[vertex];
    [0, 1, 2].map(|k| asset.origin()[k] + f64::from(stored[k]) * asset.unit())
}

/// A vertex that is low and near the middle of the length.
fn middle(asset: &Asset<'_>) -> VertexId {
    let all = (0..asset.vertex_count()).map(|vertex| (vertex, position(asset, vertex)));
    let [low, high] = all
        .clone()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], (_, p)| {
            [low.min(p[0]), high.max(p[0])]
        });
    let off = |p: [f64; 3]| p[1] + (p[0] - 0.5 * (low + high)).abs();
    let lowest = all.min_by(|(_, a), (_, b)| off(*a).total_cmp(&off(*b)));
    VertexId(lowest.map_or(0, |(vertex, _)| vertex as u32))
}

#[cfg(test)]
mod tests {
    use bdtree_build::basis::Basis;
    use bdtree_build::input::RawMesh;
    use bdtree_fixtures::bake::{baked, swaying_deck};

    use super::*;

    fn deck() -> Bridge {
        let (mesh, basis) = swaying_deck();
        Bridge::new(baked(&mesh, &basis)).expect("a bridge")
    }

    /// Through its frames, without jumps, again and again: the curve is that of the sines that the frames are of.
    #[test]
    fn it_moves_as_its_frames_say() {
        let deck = deck();
        assert!((deck.period_s() - 2.0).abs() < 1e-12);
        for n in 0..1000 {
            let time = f64::from(n) * 0.0123;
            let turn = std::f64::consts::PI * time;
            let q = deck.q(time);
            for (q, expected) in q.iter().zip([turn.sin(), turn.cos()]) {
                assert!((q - expected).abs() < 2e-4, "{time}: {q} {expected}");
            }
        }
        let frame = deck.q(0.15);
        let stored = deck.model.asset().frame(3).expect("a frame").q();
        assert!((frame[0] - f64::from(stored[0])).abs() < 1e-9);
    }

    #[test]
    fn ways_through_it_are_seen() {
        let mut deck = deck();
        // At rest upwards at the beginning, 0.3 m across.
        let [_, heave, sway] = deck.sway(0.0).expect("a place");
        assert!(heave.abs() < 1e-6 && (sway - 0.3).abs() < 1e-6);
        let through = |at: [f64; 3]| [at.map(|x| x + 0.02), at.map(|x| x - 0.02)];
        let mut crossed =
            |at: [f64; 3]| deck.crossed(0.0, [through(at)].into_iter()).expect("asked");
        assert_eq!(crossed([1.0, 0.0, 0.0]), 1);
        assert_eq!(crossed([1.0, -0.2, 0.0]), 1);
        assert_eq!(crossed([1.0, 0.1, 0.0]), 0);
        assert_eq!(crossed([1.0, 0.0, 2.0]), 0);
        // Where its edge has gone to.
        assert_eq!(crossed([0.0, -0.1, 1.8]), 1);
        assert_eq!(crossed([0.0, -0.1, -1.5]), 0);
        // A way that is none.
        assert_eq!(
            deck.crossed(0.0, [[[1.0, 0.0, 0.0]; 2]].into_iter())
                .expect("asked"),
            0
        );
        // In half a second it is 0.3 m higher.
        assert_eq!(
            deck.crossed(0.5, [through([0.0, 0.3, 0.0])].into_iter())
                .expect("asked"),
            1
        );
    }

    #[test]
    fn motion_that_cannot_go_on_is_refused() {
        let refused = |change: fn(&mut RawMesh, &mut Basis)| {
            let (mut mesh, mut basis) = swaying_deck();
            change(&mut mesh, &mut basis);
            match Bridge::new(baked(&mesh, &basis)) {
                Ok(_) => String::new(),
                Err(error) => error.to_string(),
            }
        };
        assert_eq!(refused(|_, _| ()), "");
        let none = refused(|_, basis| basis.animation = None);
        assert!(none.contains("fewer than four frames"), "{none}");
        let open = refused(|_, basis| {
            if let Some(animation) = &mut basis.animation {
                animation.q[0] += 0.01;
            }
        });
        assert!(open.contains("is not the first one again"), "{open}");
        let timeless = refused(|_, basis| {
            if let Some(animation) = &mut basis.animation {
                animation.times_s = None;
            }
        });
        assert!(timeless.contains("no times"), "{timeless}");
        let uneven = refused(|_, basis| {
            if let Some(times) = basis.animation.as_mut().and_then(|a| a.times_s.as_mut()) {
                times[7] += 0.01;
            }
        });
        assert!(uneven.contains("not equally far apart"), "{uneven}");
    }
}
