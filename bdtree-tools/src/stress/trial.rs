//! One worker: poses, deforms, and holds vertices against spheres.

use bdtree_format::LANES;
use bdtree_runtime::bound::Spheres;
use bdtree_runtime::{
    Asset, BoneMatrices, FormatError, JointMatrix, Kernel, Pose, Transform, VertexId,
};

use super::below::Below;
use super::exact::{certainly_within, squared_distance, within};
use super::report::{Report, Tight};

/// Vertices of a lane that a search watches.
pub(super) const WATCHED: usize = 16;

/// A lane, and some of the vertices below it.
pub(super) struct Target {
    pub(super) node: u32,
    pub(super) lane: usize,
    pub(super) watched: Vec<u32>,
}

/// An asset with the memory that its poses take.
pub(super) struct Trial<'t, 'a> {
    pub(super) asset: Asset<'a>,
    pub(super) below: &'t Below,
    /// Skinning matrices; none: bones at rest, or no skin.
    bones: Vec<JointMatrix>,
    memory: Vec<f32>,
    vertices: Vec<[f32; 3]>,
}

impl<'t, 'a> Trial<'t, 'a> {
    pub(super) fn new(asset: Asset<'a>, below: &'t Below) -> Self {
        Self {
            asset,
            below,
            bones: Vec::new(),
            memory: vec![0.0; asset.pose_len()],
            vertices: vec![[0.0; 3]; asset.vertex_count()],
        }
    }

    /// Uses another kernel, which must be available.
    pub(super) fn use_kernel(&mut self, kernel: Kernel) {
        self.asset = self.asset.with_kernel(kernel).unwrap_or(self.asset);
    }

    /// Moves the bones: one skinning matrix each; none for bones at rest.
    pub(super) fn set_bones(&mut self, bones: Vec<JointMatrix>) {
        self.bones = bones;
    }

    /// Holds `nodes` at q against all vertices below them. q must be within the limits.
    pub(super) fn sweep(
        &mut self,
        q: &[f32],
        nodes: impl Iterator<Item = usize>,
        report: &mut Report,
    ) -> Result<(), FormatError> {
        let bones = match self.bones.as_slice() {
            [] => BoneMatrices::Rest,
            bones => BoneMatrices::Skinning(bones),
        };
        let here = Transform::IDENTITY;
        let Ok(pose) = (self.asset).pose_with_bones(q, bones, here, &mut self.memory) else {
            return Ok(()); // only q beyond the limits is refused
        };
        for (i, vertex) in (0..).zip(&mut self.vertices) {
            *vertex = pose.deformed_stored(VertexId(i))?;
        }
        report.poses += 1;
        for node in nodes {
            let spheres = pose.node_spheres(node as u32)?;
            report.cases += 1;
            for lane in 0..LANES {
                let below = self.below.lane(node, lane);
                let at = (node as u32, lane);
                let Some(sphere) = Sphere::tried(&pose, q, &spheres, at, below, report) else {
                    continue;
                };
                let (mut farthest, mut square) = (below[0], -1.0);
                for &v in below {
                    let found = squared_distance(self.vertices[v as usize], sphere.center);
                    // Not ">": what is not a number lies outside, farther than anything else.
                    if !(found <= square) {
                        farthest = v;
                        square = if found.is_nan() { f64::INFINITY } else { found };
                    }
                }
                report.margin(sphere.margin(square), || sphere.tight(farthest, square));
                if certainly_within(square, sphere.radius) {
                    continue;
                }
                for &v in below {
                    let vertex = self.vertices[v as usize];
                    if !within(vertex, sphere.center, sphere.radius) {
                        let square = squared_distance(vertex, sphere.center);
                        report.violation(sphere.tight(v, square));
                    }
                }
            }
        }
        Ok(())
    }

    /// How far the farthest watched vertex is from the sphere's surface, inwards, over what rounding
    /// is given: what a search makes as small as it can. The case counts in `report`.
    pub(super) fn margin(
        &mut self,
        q: &[f32],
        target: &Target,
        report: &mut Report,
    ) -> Result<f64, FormatError> {
        let watched = &target.watched;
        let mut least = f64::INFINITY;
        let bones = match self.bones.as_slice() {
            [] => BoneMatrices::Rest,
            bones => BoneMatrices::Skinning(bones),
        };
        let here = Transform::IDENTITY;
        let Ok(pose) = (self.asset).pose_with_bones(q, bones, here, &mut self.memory) else {
            return Ok(least); // as above
        };
        let spheres = pose.node_spheres(target.node)?;
        report.poses += 1;
        report.cases += 1;
        let at = (target.node, target.lane);
        let Some(sphere) = Sphere::tried(&pose, q, &spheres, at, watched, report) else {
            return Ok(least);
        };
        for &v in watched {
            let vertex = pose.deformed_stored(VertexId(v))?;
            let square = squared_distance(vertex, sphere.center);
            let tight = || sphere.tight(v, square);
            let is_certain = certainly_within(square, sphere.radius);
            if !is_certain && !within(vertex, sphere.center, sphere.radius) {
                report.violation(tight());
            }
            let margin = sphere.margin(square);
            report.margin(margin, tight);
            least = least.min(margin);
        }
        Ok(least)
    }
}

/// A lane's sphere at a q, in stored units.
struct Sphere<'q> {
    kernel: Kernel,
    q: &'q [f32],
    node: u32,
    lane: usize,
    center: [f32; 3],
    radius: f32,
    slack: f64,
}

impl<'q> Sphere<'q> {
    /// A sphere that some vertices are held against, if there are any and it has a radius; counted in `report`.
    fn tried(
        pose: &Pose<'_>,
        q: &'q [f32],
        spheres: &Spheres,
        (node, lane): (u32, usize),
        vertices: &[u32],
        report: &mut Report,
    ) -> Option<Self> {
        let radius = spheres.radius[lane];
        if vertices.is_empty() {
            return None;
        }
        if radius.is_nan() {
            report.unbounded += 1; // every test reads it as "visit"
            return None;
        }
        report.vertices += vertices.len() as u64;
        Some(Self {
            kernel: pose.asset().kernel(),
            q,
            node,
            lane,
            center: [0, 1, 2].map(|k| spheres.center[k][lane]),
            radius,
            slack: pose.slack() / pose.asset().unit(),
        })
    }

    /// How far a vertex at this squared distance is inside, in slacks. What is not a number is as bad as can be.
    fn margin(&self, square: f64) -> f64 {
        let margin = (f64::from(self.radius) - square.sqrt()) / self.slack;
        if margin.is_nan() {
            f64::NEG_INFINITY
        } else {
            margin
        }
    }

    fn tight(&self, vertex: u32, square: f64) -> Tight {
        Tight {
            margin_slacks: self.margin(square),
            kernel: format!("{:?}", self.kernel),
            node: self.node,
            lane: self.lane,
            vertex,
            radius: f64::from(self.radius),
            distance: square.sqrt(),
            slack: self.slack,
            q: self.q.to_vec(),
        }
    }
}
