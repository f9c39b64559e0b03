//! The contact spheres of a body: those of one level of its tree, fixed to the material.
//!
//! A contact sphere has the radius R of its wrapped sphere at rest and the center `c + Ū q` of the bound (paper, eqs.
//! 5 and 6), which moves with the modes as the mean of what it wraps. So the overlap of two spheres is a smooth function
//! of where bodies are and how they are deformed, and its gradient is what forces are applied along: `Ūᵀ f` on q.
//!
//! The tree finds pairs of *bounding* spheres, which need not lie in those above them; [`LevelSpheres::reach`] is by how
//! much a contact sphere sticks out of any sphere that a traversal tests on the way to it, at rest. Queries that far apart
//! miss no pair of contact spheres of undeformed bodies. Deformation enlarges bounds more than it moves spheres out of
//! them, but not everywhere: a pair that is found late begins without force (`world::contact`).

use alloc::vec::Vec;

use bdtree_runtime::format::{LANES, NodeRecord, ROW_CENTER_X, ROW_RADIUS};
use bdtree_runtime::{Asset, FormatError, LaneId};
use nalgebra::Vector3;

use crate::field::{Field, PAD};

/// Spheres of a level in the frame of the principal axes, relative to the center of mass, world units.
#[derive(Debug, Clone)]
pub struct LevelSpheres {
    /// The level of the tree; leaf lanes above it have their spheres too.
    pub level: usize,
    centers: Vec<[f64; 3]>,
    radii: Vec<f64>,
    /// Ū of each sphere: x of all modes (padded), y, z.
    fields: Vec<f64>,
    modes: usize,
    stride: usize,
    /// Of each lane of each node down to the level, the sphere, or `u32::MAX`.
    of_lane: Vec<u32>,
    reach: f64,
    /// Largest spectral norm of any sphere's Ū: no center moves farther than this times the length of q.
    field_norm: f64,
    /// The mean Ū of each eight spheres in a row, which hang on one node or its neighbors, as `fields`, and the largest
    /// spectral norm of what any of them differs from it by.
    group_fields: Vec<f64>,
    group_norms: Vec<f64>,
    /// Largest distance of a center from the center of mass at rest.
    pub(crate) extent: f64,
    pub(crate) radius_max: f64,
    pub(crate) radius_mean: f64,
}

/// Spheres whose motion is bounded together.
const GROUP: usize = 8;

/// A lane at rest.
#[derive(Clone, Copy)]
struct Lane {
    center: Vector3<f64>,
    radius: f64,
}

/// The level whose number of spheres is nearest to a thousand, by ratio: what the paper's level 10 of a binary tree has.
pub fn usual_level(asset: &Asset<'_>) -> usize {
    let mut best = (f64::INFINITY, 0);
    for level in 0..asset.depth() {
        let ratio = sphere_count(asset, level) as f64 / 1000.0;
        let off = libm::fabs(libm::log(ratio));
        if off < best.0 {
            best = (off, level);
        }
    }
    best.1
}

/// Number of spheres at a level: its lanes, and the leaf lanes above it.
fn sphere_count(asset: &Asset<'_>, level: usize) -> usize {
    let of = |node: &NodeRecord| {
        let is_last = usize::from(node.level) == level;
        let mask = if is_last {
            node.leaf_mask | node.inner_mask
        } else {
            node.leaf_mask
        };
        mask.count_ones() as usize
    };
    let nodes = &asset.nodes()[..asset.node_count_to(level)];
    nodes.iter().map(of).sum()
}

impl LevelSpheres {
    /// The spheres of `level`. `place` maps a point of the mesh to the body's frame, `turn` a displacement (both in world
    /// units); without `has_modes` the spheres do not move.
    ///
    /// # Errors
    /// A damaged asset.
    pub(crate) fn new(
        asset: &Asset<'_>,
        level: usize,
        has_modes: bool,
        scale: f64,
        place: impl Fn(Vector3<f64>) -> Vector3<f64>,
        turn: impl Fn(Vector3<f64>) -> Vector3<f64>,
    ) -> Result<Self, FormatError> {
        let modes = if has_modes { asset.mode_count() } else { 0 };
        let stride = modes.div_ceil(PAD) * PAD;
        let node_count = asset.node_count_to(level);
        let mut found = Self {
            level,
            centers: Vec::new(),
            radii: Vec::new(),
            fields: Vec::new(),
            modes,
            stride,
            of_lane: alloc::vec![u32::MAX; node_count * LANES],
            reach: 0.0,
            field_norm: 0.0,
            group_fields: Vec::new(),
            group_norms: Vec::new(),
            extent: 0.0,
            radius_max: 0.0,
            radius_mean: 0.0,
        };
        // The lane that each node hangs on.
        let mut parents: Vec<Option<(usize, usize)>> = alloc::vec![None; node_count];
        let mut lanes: Vec<Option<Lane>> = Vec::new();
        for (index, node) in asset.nodes()[..node_count].iter().enumerate() {
            let rows = asset.node_rows(node)?;
            let active = if has_modes {
                asset.node_modes(node)?
            } else {
                &[]
            };
            for lane in 0..LANES {
                let used = (node.leaf_mask | node.inner_mask) >> lane & 1 != 0;
                lanes.push(None);
                if !used {
                    continue;
                }
                let stored = [0, 1, 2].map(|k| f64::from(rows.leading[ROW_CENTER_X + k][lane]));
                let origin = Vector3::from(asset.origin());
                let center = place(origin + Vector3::from(stored) * asset.unit());
                let size = asset.unit() * scale;
                let mut fields = alloc::vec![Vector3::zeros(); modes];
                for (k, mode) in active.iter().enumerate() {
                    let mode = usize::from(*mode);
                    let Some(record) = asset.modes().get(mode) else {
                        continue;
                    };
                    let q_limit = f64::from(record.q_limit.get());
                    let [x, y, z, ..] = rows.numbers(k, lane);
                    let unit = f64::from(rows.units[0]) / q_limit;
                    let field = Vector3::new(f64::from(x), f64::from(y), f64::from(z)) * unit;
                    fields[mode] = turn(field * asset.unit());
                }
                let own = Lane {
                    center,
                    radius: f64::from(rows.leading[ROW_RADIUS][lane]) * size,
                };
                // In a corrupt file a child may be one of its own ancestors.
                if let Some(child) = node.child(lane)
                    && child as usize > index
                    && let Some(parent) = parents.get_mut(child as usize)
                {
                    *parent = Some((index, lane));
                }
                if usize::from(node.level) == level || node.leaf_mask >> lane & 1 != 0 {
                    found.of_lane[index * LANES + lane] = found.radii.len() as u32;
                    found.add(&own, &fields);
                    let mut above = parents[index];
                    while let Some((node, lane)) = above {
                        if let Some(Some(outer)) = lanes.get(node * LANES + lane) {
                            let apart = (own.center - outer.center).norm();
                            found.reach = found.reach.max(apart + own.radius - outer.radius);
                        }
                        above = parents[node];
                    }
                }
                if let Some(last) = lanes.last_mut() {
                    *last = Some(own);
                }
            }
        }
        found.radius_mean = found.radii.iter().sum::<f64>() / found.radii.len().max(1) as f64;
        found.find_groups();
        Ok(found)
    }

    fn add(&mut self, lane: &Lane, fields: &[Vector3<f64>]) {
        self.centers.push(lane.center.into());
        self.radii.push(lane.radius);
        for axis in 0..3 {
            let start = self.fields.len();
            self.fields.extend(fields.iter().map(|field| field[axis]));
            self.fields.resize(start + self.stride, 0.0);
        }
        self.extent = self.extent.max(lane.center.norm());
        self.radius_max = self.radius_max.max(lane.radius);
    }

    /// What says how far spheres move.
    fn find_groups(&mut self) {
        let each = 3 * self.stride;
        if each == 0 {
            return;
        }
        for group in self.fields.chunks(GROUP * each) {
            let count = (group.len() / each) as f64;
            let start = self.group_fields.len();
            self.group_fields.resize(start + each, 0.0);
            let mean = &mut self.group_fields[start..];
            for own in group.chunks(each) {
                for (mean, x) in mean.iter_mut().zip(own) {
                    *mean += x / count;
                }
            }
            let mut norm = 0.0_f64;
            for own in group.chunks(each) {
                self.field_norm = self.field_norm.max(Field(own).norm(None));
                norm = norm.max(Field(own).norm(Some(Field(mean))));
            }
            self.group_norms.push(norm * (1.0 + 1e-9));
        }
        self.field_norm *= 1.0 + 1e-9;
    }

    /// Number of spheres.
    pub fn len(&self) -> usize {
        self.radii.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.radii.is_empty()
    }

    /// Number of modes that move them; 0 for a rigid body.
    pub fn mode_count(&self) -> usize {
        self.modes
    }

    /// Modes with padding: the length of the coefficient slices that other functions take.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// The sphere of a lane, if it has one at this level.
    pub fn of(&self, lane: LaneId) -> Option<usize> {
        let at = lane.node as usize * LANES + usize::from(lane.lane);
        let index = *self.of_lane.get(at)?;
        (index != u32::MAX).then_some(index as usize)
    }

    /// Radius of a sphere, world units.
    pub fn radius(&self, sphere: usize) -> f64 {
        self.radii[sphere]
    }

    /// All radii.
    pub fn radii(&self) -> &[f64] {
        &self.radii
    }

    /// By how much a contact sphere sticks out of the bounding spheres above it, at rest.
    pub fn reach(&self) -> f64 {
        // The runtime's own spheres are rounded outwards; ours, in f64, are not.
        self.reach.max(0.0) * (1.0 + 1e-9) + 1e-6 * self.radius_max
    }

    /// No center is farther from its place at rest for any q of length `size`.
    pub fn moved_within(&self, size: f64) -> f64 {
        self.field_norm * size
    }

    /// How far centers move at most when q changes by `change`, of [`LevelSpheres::stride`] numbers.
    pub fn moved(&self, change: &[f64]) -> f64 {
        let size = libm::sqrt(change.iter().map(|x| x * x).sum());
        let mut most = 0.0_f64;
        if size > 0.0 {
            let groups = self.group_fields.chunks(3 * self.stride);
            for (fields, norm) in groups.zip(&self.group_norms) {
                most = most.max(Field(fields).displacement(change).norm() + norm * size);
            }
        }
        most
    }

    /// c in the body's frame.
    pub fn rest_center(&self, sphere: usize) -> Vector3<f64> {
        self.centers[sphere].into()
    }

    /// `c + Ū q` in the body's frame; `q` has [`LevelSpheres::stride`] numbers.
    #[inline]
    pub fn center(&self, sphere: usize, q: &[f64]) -> Vector3<f64> {
        Vector3::from(self.centers[sphere]) + self.field(sphere).displacement(q)
    }

    /// Ū of a sphere, in the body's frame.
    #[inline]
    pub fn field(&self, sphere: usize) -> Field<'_> {
        let start = 3 * self.stride * sphere;
        Field(&self.fields[start..start + 3 * self.stride])
    }
}
