//! Three hierarchies of spheres over the same binary tree.

use std::error::Error;

use bdtree_baselines::Place;
use bdtree_baselines::paper_tree::{Layered, PaperTree, Spheres, Step};
use bdtree_render::tightness::growth;
use bdtree_runtime::{Asset, Pose, Transform, VertexId};
use bdtree_scenes::bounds::sphere::{Growth, Sphere};
use nalgebra::Vector3;

/// What holds the triangles of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A sphere around its children's spheres, made anew from the deformed vertices.
    Layered,
    /// The paper's wrapped sphere, moved and grown by eqs. 5 and 7.
    Paper,
    /// The smallest ball, moved and grown by our second-order bound.
    Ours,
}

impl Kind {
    pub(crate) const ALL: [Self; 3] = [Self::Layered, Self::Paper, Self::Ours];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Layered => "layered hierarchy",
            Self::Paper => "BD-Tree as in the paper",
            Self::Ours => "BD-Tree with our bound",
        }
    }

    pub(crate) fn short(self) -> &'static str {
        match self {
            Self::Layered => "layered",
            Self::Paper => "paper",
            Self::Ours => "ours",
        }
    }
}

/// A sphere of a hierarchy (stored units).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Found {
    pub(crate) centre: [f64; 3],
    pub(crate) radius: f64,
    /// Its radius over that of the paper's wrapped sphere at rest.
    pub(crate) growth: f64,
}

/// The paper's tree of an asset, with its levels.
pub(crate) struct Hierarchies<'a> {
    asset: Asset<'a>,
    tree: PaperTree,
    /// Level and triangles of every node.
    nodes: Vec<(usize, Vec<u32>)>,
}

impl<'a> Hierarchies<'a> {
    pub(crate) fn new(asset: Asset<'a>) -> Self {
        let tree = PaperTree::build(&asset);
        let nodes = tree.nodes();
        Self { asset, tree, nodes }
    }

    /// Number of levels.
    pub(crate) fn depth(&self) -> usize {
        self.tree.depth()
    }

    /// Number of nodes of a level.
    pub(crate) fn count(&self, level: usize) -> usize {
        self.nodes.iter().filter(|(l, _)| *l == level).count()
    }

    /// The spheres of a level at q.
    pub(crate) fn spheres(
        &self,
        kind: Kind,
        level: usize,
        q: &[f32],
    ) -> Result<Vec<Found>, Box<dyn Error>> {
        let asset = &self.asset;
        let mut memory = vec![0.0; asset.pose_len()];
        let pose = Pose::new(asset, q, Transform::IDENTITY, &mut memory)?;
        let mut step = Step::default();
        step.prepare(asset, &pose);
        let layered = match kind {
            Kind::Layered => Some(self.layered(&pose)?),
            _ => None,
        };
        let at_level = self
            .nodes
            .iter()
            .enumerate()
            .filter(|(_, (l, _))| *l == level);
        let found = at_level.map(|(node, (_, triangles))| {
            let [x, y, z, radius] = match (kind, &layered) {
                (Kind::Layered, Some(layered)) => {
                    layered.clone().sphere(&self.tree, node).map(f64::from)
                }
                (Kind::Ours, _) => self.ours(triangles, q)?,
                _ => self.tree.sphere(&step, node).map(f64::from),
            };
            let [_, _, _, rest] = self.tree.numbers(node)[0];
            Ok(Found {
                centre: [x, y, z],
                radius,
                growth: growth(radius, f64::from(rest)),
            })
        });
        found.collect()
    }

    fn layered(&self, pose: &Pose<'_>) -> Result<Layered, Box<dyn Error>> {
        let count = self.asset.vertex_count();
        let mut layered = Layered::new(&self.tree, 3 * count);
        for (v, out) in (0..).zip(layered.vertices.as_chunks_mut::<3>().0) {
            *out = self.asset.deformed_stored(pose, VertexId(v))?;
        }
        layered.refit(&self.tree, &Place::IDENTITY);
        Ok(layered)
    }

    /// Our bound of the vertices of some triangles, in exact numbers (f64), without slack.
    fn ours(&self, triangles: &[u32], q: &[f32]) -> Result<[f64; 4], Box<dyn Error>> {
        let corners = self.tree.corners();
        let mut vertices: Vec<u32> = triangles
            .iter()
            .flat_map(|t| corners[*t as usize])
            .collect();
        vertices.sort_unstable();
        vertices.dedup();
        let wide = |[x, y, z]: [f32; 3]| Vector3::new(x, y, z).map(f64::from);
        let positions = self.asset.positions();
        let points: Vec<_> = vertices
            .iter()
            .map(|v| wide(positions[*v as usize]))
            .collect();
        let own = vertices
            .iter()
            .map(|v| self.asset.displacements(VertexId(*v)));
        let own = own.collect::<Result<Vec<_>, _>>()?;
        let fields = (0..self.asset.mode_count()).map(|j| {
            own.iter()
                .map(|field| wide(field.of(j)))
                .collect::<Vec<_>>()
        });
        let q: Vec<f64> = q.iter().map(|q| f64::from(*q)).collect();
        let ball = Sphere::around(&points, fields, Growth::SecondOrder).at(&q);
        Ok([ball.centre.x, ball.centre.y, ball.centre.z, ball.radius])
    }
}
