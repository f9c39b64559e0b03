//! One worker: poses, deforms, and holds vertices against spheres.

use bdtree_format::LANES;
use bdtree_runtime::bound::Spheres;
use bdtree_runtime::{Asset, FormatError, Kernel, Transform, VertexId};

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
    memory: Vec<f32>,
    vertices: Vec<[f32; 3]>,
}

impl<'t, 'a> Trial<'t, 'a> {
    pub(super) fn new(asset: Asset<'a>, below: &'t Below) -> Self {
        Self {
            asset,
            below,
            memory: vec![0.0; asset.pose_len()],
            vertices: vec![[0.0; 3]; asset.vertex_count()],
        }
    }

    /// Uses another kernel, which must be available.
    pub(super) fn use_kernel(&mut self, kernel: Kernel) {
        self.asset = self.asset.with_kernel(kernel).unwrap_or(self.asset);
    }

    /// Holds `nodes` at q against all vertices below them. q must be within the limits.
    pub(super) fn sweep(
        &mut self,
        q: &[f32],
        nodes: impl Iterator<Item = usize>,
        report: &mut Report,
    ) -> Result<(), FormatError> {
        let Ok(pose) = self.asset.pose(q, Transform::IDENTITY, &mut self.memory) else {
            return Ok(()); // only q beyond the limits is refused
        };
        for (i, vertex) in (0..).zip(&mut self.vertices) {
            *vertex = pose.deformed_stored(VertexId(i))?;
        }
        let slack = pose.slack() / self.asset.unit();
        report.poses += 1;
        for node in nodes {
            let spheres = pose.node_spheres(node as u32)?;
            report.cases += 1;
            for lane in 0..LANES {
                let below = self.below.lane(node, lane);
                if below.is_empty() {
                    continue;
                }
                let (center, radius) = sphere(&spheres, lane);
                if radius.is_nan() {
                    report.unbounded += 1; // every test reads it as "visit"
                    continue;
                }
                report.vertices += below.len() as u64;
                let (mut farthest, mut square) = (below[0], -1.0);
                for &v in below {
                    let found = squared_distance(self.vertices[v as usize], center);
                    // Not ">": what is not a number lies outside, farther than anything else.
                    if !(found <= square) {
                        farthest = v;
                        square = if found.is_nan() { f64::INFINITY } else { found };
                    }
                }
                let tight = || Tight {
                    kernel: self.asset.kernel(),
                    node: node as u32,
                    lane,
                    vertex: farthest,
                    q: q.to_vec(),
                    radius: f64::from(radius),
                    distance: square.sqrt(),
                    slack,
                };
                report.margin((f64::from(radius) - square.sqrt()) / slack, tight);
                if certainly_within(square, radius) {
                    continue;
                }
                for &v in below {
                    let vertex = self.vertices[v as usize];
                    if !within(vertex, center, radius) {
                        report.violation(Tight {
                            vertex: v,
                            distance: squared_distance(vertex, center).sqrt(),
                            ..tight()
                        });
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
        let Ok(pose) = self.asset.pose(q, Transform::IDENTITY, &mut self.memory) else {
            return Ok(f64::INFINITY); // as above
        };
        let spheres = pose.node_spheres(target.node)?;
        let (center, radius) = sphere(&spheres, target.lane);
        let slack = pose.slack() / self.asset.unit();
        report.poses += 1;
        report.cases += 1;
        if radius.is_nan() {
            report.unbounded += 1;
            return Ok(f64::INFINITY);
        }
        report.vertices += target.watched.len() as u64;
        let mut least = f64::INFINITY;
        for &v in &target.watched {
            let vertex = pose.deformed_stored(VertexId(v))?;
            let square = squared_distance(vertex, center);
            let margin = (f64::from(radius) - square.sqrt()) / slack;
            let tight = || Tight {
                kernel: self.asset.kernel(),
                node: target.node,
                lane: target.lane,
                vertex: v,
                q: q.to_vec(),
                radius: f64::from(radius),
                distance: square.sqrt(),
                slack,
            };
            if !certainly_within(square, radius) && !within(vertex, center, radius) {
                report.violation(tight());
            }
            report.margin(margin, tight);
            least = least.min(margin);
        }
        Ok(least)
    }
}

fn sphere(spheres: &Spheres, lane: usize) -> ([f32; 3], f32) {
    let [x, y, z] = &spheres.center;
    ([x[lane], y[lane], z[lane]], spheres.radius[lane])
}
