//! What is asked of an asset in one pose: the same questions in every run.

use crate::MeasureError;
use crate::comparison::MOST;
use crate::leaf::unit;
use crate::ours::Posture;
use crate::vector::{length, minus};
use bdtree_build::advise::samples::Samples;
use bdtree_build::advise::works::{BALL_RADIUS_REL, at_rest};
use bdtree_runtime::{
    Asset, BoneMap, BoneMatrices, JointMatrix, Pose, PoseError, Transform, TriangleId, VertexId,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// The placement of samples: world coordinates are the mesh's.
pub const HERE: Transform = Transform::IDENTITY;

/// Surface points per sample that rays aim at: more rays come to them from elsewhere.
const POINTS: usize = 512;

/// Radius of the balls of [`Sample::balls`] over that of [`Sample::ball`].
pub const SMALL_BALL: f64 = 0.2;

/// Sets the stream of small balls apart from that of the other questions.
const BALLS_STREAM: u64 = 0xba11;

/// How far apart two instances stand, over the body's longest extent: from beside each other to deep inside.
const APART: [f64; 8] = [1.1, 0.98, 0.9, 0.8, 0.65, 0.5, 0.3, 0.1];

/// A pose of an asset, and what is asked about it (world coordinates are the mesh's).
#[derive(Debug)]
pub struct Sample {
    /// One number per mode.
    pub q: Vec<f32>,
    /// One matrix per joint; `None` without a skin.
    joints: Option<Vec<JointMatrix>>,
    /// The same as those who deform all vertices take it.
    pub maps: Vec<BoneMap>,
    /// Center and radius of the ball that levels are compared with.
    pub ball: ([f64; 3], f64),
    /// Where a second instance stands, nearer each time.
    pub places: Vec<Transform>,
    /// Points of the deformed surface.
    points: Vec<[f64; 3]>,
    /// Where rays come from, one for each point.
    origins: Vec<[f64; 3]>,
    /// Other points of it, about which small balls are: no two the same, so that none is answered by what a
    /// cache holds of itself.
    centers: Vec<[f64; 3]>,
}

impl Sample {
    /// One for every pose of `samples`; `bounds` is the box of the mesh at rest ([`bounds_at_rest`]).
    ///
    /// # Errors
    /// A corrupt asset.
    pub fn all(
        asset: &Asset<'_>,
        samples: &Samples,
        bounds: [[f64; 3]; 2],
    ) -> Result<Vec<Self>, MeasureError> {
        let mut memory = vec![0.0; asset.pose_len()];
        (0..samples.count)
            .map(|k| Self::new(asset, samples, k, bounds, &mut memory))
            .collect()
    }

    fn new(
        asset: &Asset<'_>,
        samples: &Samples,
        which: usize,
        bounds: [[f64; 3]; 2],
        memory: &mut [f32],
    ) -> Result<Self, MeasureError> {
        let (q, bones) = (samples.q(which), samples.joints(which));
        let pose = asset.pose_with_bones(q, bones, HERE, memory)?;
        let seed = which as u64;
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        // Fields move a body about the place where it rests; bones may carry it elsewhere.
        let [low, high] = match asset.has_skin() {
            true => box_of(&pose)?,
            false => bounds,
        };
        let extent = minus(high, low);
        let middle = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]));
        let diagonal = length(extent);
        let count = asset.triangle_count() as u32;
        let mut points = Vec::with_capacity(POINTS);
        let mut origins = Vec::with_capacity(POINTS);
        for _ in 0..POINTS {
            let corners = pose.deformed_triangle(TriangleId(random.random_range(0..count)))?;
            let mut point = [0.0; 3];
            for p in corners {
                point = [0, 1, 2].map(|k| point[k] + p[k] / 3.0);
            }
            points.push(point);
            let mut direction = [0.0; 3];
            let mut size = 0.0;
            // Evenly over all directions: those in the ball are, by rejection.
            while !(1e-3..=1.0).contains(&size) {
                direction = [0; 3].map(|_| random.random_range(-1.0..1.0));
                size = direction.iter().map(|x: &f64| x * x).sum();
            }
            let far = diagonal.max(f64::MIN_POSITIVE) / size.sqrt();
            origins.push([0, 1, 2].map(|k| middle[k] + far * direction[k]));
        }
        let radius = BALL_RADIUS_REL * length(minus(bounds[1], bounds[0]));
        let first = points.first().copied().unwrap_or(middle);
        // Up to 1.7 radii off a point of the surface: deep inside, barely touching, or apart.
        let center = [0, 1, 2].map(|k| first[k] + radius * random.random_range(-1.0..1.0));
        let mut random = Pcg64Mcg::seed_from_u64(seed ^ BALLS_STREAM);
        let mut centers = Vec::with_capacity(MOST);
        for _ in 0..MOST {
            let corners = pose.deformed_triangle(TriangleId(random.random_range(0..count)))?;
            centers.push(within(
                corners,
                [0; 2].map(|_| random.random_range(0.0..1.0)),
            ));
        }
        Ok(Self {
            q: q.to_vec(),
            joints: match bones {
                BoneMatrices::Joints(joints) => Some(joints.to_vec()),
                _ => None,
            },
            maps: pose.bone_maps().to_vec(),
            ball: (center, radius),
            places: places(middle, extent),
            points,
            origins,
            centers,
        })
    }

    /// What the asset is posed by.
    pub fn posture(&self) -> Posture<'_> {
        let joints = self.joints.as_deref();
        Posture {
            q: &self.q,
            bones: joints.map_or(BoneMatrices::Rest, BoneMatrices::Joints),
        }
    }

    /// The asset in this pose, at a placement.
    ///
    /// # Errors
    /// Memory that is too short; samples of another asset.
    pub fn pose<'p>(
        &self,
        asset: &'p Asset<'p>,
        at: Transform,
        memory: &'p mut [f32],
    ) -> Result<Pose<'p>, PoseError> {
        let Posture { q, bones } = self.posture();
        asset.pose_with_bones(q, bones, at, memory)
    }

    /// So many balls about points of the surface, [`MOST`] at most, [`SMALL_BALL`] as large as the one.
    pub fn balls(&self, amount: usize) -> impl Iterator<Item = ([f64; 3], f64)> {
        let radius = SMALL_BALL * self.ball.1;
        self.centers.iter().take(amount).map(move |p| (*p, radius))
    }

    /// So many rays, origin and unit direction, from around the body to points of its surface.
    pub fn rays(&self, amount: usize) -> impl Iterator<Item = [[f64; 3]; 2]> {
        self.lines(amount)
            .map(|[from, to]| [from, unit(minus(to, from))])
    }

    /// So many points off the surface, `away` of the way to where rays come from.
    pub fn points(&self, amount: usize, away: f64) -> impl Iterator<Item = [f64; 3]> {
        self.lines(amount)
            .map(move |[from, to]| [0, 1, 2].map(|k| to[k] + away * (from[k] - to[k])))
    }

    /// From where and to where rays go.
    fn lines(&self, amount: usize) -> impl Iterator<Item = [[f64; 3]; 2]> {
        // Past the last point, other origins meet other points.
        let shift = |i: usize| (i + i / POINTS) % POINTS;
        (0..amount).map(move |i| [self.origins[shift(i)], self.points[i % POINTS]])
    }
}

/// The box of the vertices that triangles use, at rest (mesh units).
///
/// # Errors
/// A corrupt asset.
pub fn bounds_at_rest(asset: &Asset<'_>) -> Result<[[f64; 3]; 2], MeasureError> {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    let corners = asset.triangles().iter().flat_map(|t| t.corners);
    let at_rest = at_rest(asset)?;
    for p in corners.filter_map(|v| at_rest.get(v as usize)) {
        for k in 0..3 {
            let x = asset.origin()[k] + asset.unit() * f64::from(p[k]);
            low[k] = low[k].min(x);
            high[k] = high[k].max(x);
        }
    }
    Ok([low, high])
}

/// The box of the vertices that triangles use (mesh units).
fn box_of(pose: &Pose<'_>) -> Result<[[f64; 3]; 2], MeasureError> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for corner in pose.asset().triangles().iter().flat_map(|t| t.corners) {
        let p = pose.deformed(VertexId(corner))?;
        low = [0, 1, 2].map(|k| low[k].min(p[k]));
        high = [0, 1, 2].map(|k| high[k].max(p[k]));
    }
    Ok([low, high])
}

/// The point of a triangle at two shares from 0 to 1: evenly spread where those are.
fn within([a, b, c]: [[f64; 3]; 3], [s, t]: [f64; 2]) -> [f64; 3] {
    // Half of the parallelogram is folded onto the other.
    let [s, t] = if s + t > 1.0 {
        [1.0 - s, 1.0 - t]
    } else {
        [s, t]
    };
    [0, 1, 2].map(|k| a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k]))
}

/// Beside the body along its longest extent, turned a little about its own middle.
fn places(middle: [f64; 3], extent: [f64; 3]) -> Vec<Transform> {
    let axis = (0..3).fold(0, |a, b| if extent[b] > extent[a] { b } else { a });
    // About 7 degrees around a slanted axis.
    let rotation = [0.03, 0.04, 0.035, 1.0];
    let norm = rotation.iter().map(|x: &f64| x * x).sum::<f64>().sqrt();
    let rotation = rotation.map(|x| x / norm);
    let rows = crate::place::matrix(rotation);
    let turned = rows.map(|row| (0..3).map(|k| row[k] * middle[k]).sum::<f64>());
    let place = |apart: &f64| {
        let mut translation = [0, 1, 2].map(|k| middle[k] - turned[k]);
        translation[axis] += apart * extent[axis];
        Transform {
            rotation,
            translation,
            scale: 1.0,
        }
    };
    APART.iter().map(place).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use crate::comparison::MOST;
    use bdtree_build::advise::samples::{SAMPLES, Samples};
    use bdtree_build::basis::{Basis, BasisMode};
    use bdtree_build::input::RawMesh;
    use bdtree_build::pipeline::{BakeSettings, Provenance, bake_fields};
    use bdtree_build::progress::Silent;
    use bdtree_runtime::Model;

    use super::{POINTS, Sample, within};

    /// Samples of a triangle that stretches along x.
    fn samples() -> Vec<Sample> {
        let mesh = RawMesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            ..RawMesh::default()
        };
        let basis = Basis {
            vertex_count: 3,
            fields: vec![[0.0; 3], [0.1, 0.0, 0.0], [0.0; 3]],
            modes: vec![BasisMode {
                q_range: Some(1.0),
                ..BasisMode::default()
            }],
            animation: None,
        };
        let baked = bake_fields(
            &mesh,
            &basis,
            &BakeSettings::default(),
            &Provenance::default(),
            &Silent,
        );
        let model = Model::from_bytes(&baked.expect("a sound mesh").bytes).expect("a sound file");
        let samples = Samples::of(model.asset(), SAMPLES).expect("samples");
        Sample::all(model.asset(), &samples, [[0.0; 3], [1.0, 1.0, 0.0]]).expect("samples")
    }

    #[test]
    fn questions_of_a_step_differ_and_are_the_same_in_every_run() {
        let (one, two) = (samples(), samples());
        assert!(!one.is_empty());
        let bits = |v: [f64; 3]| v.map(f64::to_bits);
        for (one, two) in one.iter().zip(&two) {
            let balls: Vec<_> = one.balls(MOST).map(|(c, _)| bits(c)).collect();
            assert_eq!(balls.iter().collect::<BTreeSet<_>>().len(), MOST);
            assert!(two.balls(MOST).map(|(c, _)| bits(c)).eq(balls));
            let rays: BTreeSet<_> = one.rays(MOST).map(|ray| ray.map(bits)).collect();
            // All aim at the middle of the one triangle here, from so many places.
            assert_eq!(rays.len(), POINTS);
        }
    }

    #[test]
    fn balls_are_on_the_surface() {
        for sample in samples() {
            for ([x, y, z], radius) in sample.balls(MOST) {
                assert!(radius > 0.0 && z == 0.0);
                assert!(x >= 0.0 && y >= 0.0 && x / 1.1 + y < 1.0 + 1e-6, "{x} {y}");
            }
        }
        let corners = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for (shares, point) in [
            ([0.0, 0.0], [1.0, 0.0, 0.0]),
            ([0.25, 0.5], [0.25, 0.25, 0.5]),
            ([0.75, 0.5], [0.25, 0.25, 0.5]),
        ] {
            assert_eq!(within(corners, shares), point);
        }
    }
}
