//! Three hierarchies of spheres over the same binary tree: the layered one, the paper's and ours.

mod sphere;

use std::error::Error;

use bdtree_measure::Place;
use bdtree_measure::paper_tree::{Layered, PaperTree, Spheres, Step};
use bdtree_render::tightness::growth;
use bdtree_runtime::{Asset, Transform, VertexId};
use nalgebra::Vector3;
use serde::Serialize;

use sphere::Sphere;

/// What holds the triangles of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A sphere around its children's spheres, made anew from the deformed vertices.
    Layered,
    /// The paper's wrapped sphere, moved and grown by eqs. 5 and 7.
    Paper,
    /// The smallest ball, moved and grown by our second-order bound.
    Ours,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Layered, Self::Paper, Self::Ours];

    /// For headings.
    pub fn name(self) -> &'static str {
        match self {
            Self::Layered => "layered hierarchy",
            Self::Paper => "BD-Tree as in the paper",
            Self::Ours => "BD-Tree with our bound",
        }
    }

    /// For columns.
    pub fn short(self) -> &'static str {
        match self {
            Self::Layered => "layered",
            Self::Paper => "paper",
            Self::Ours => "ours",
        }
    }
}

/// One of each kind.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ByKind<T> {
    /// [`Kind::Layered`].
    pub layered: T,
    /// [`Kind::Paper`].
    pub paper: T,
    /// [`Kind::Ours`].
    pub ours: T,
}

impl<T> From<[T; 3]> for ByKind<T> {
    /// In the order of [`Kind::ALL`].
    fn from([layered, paper, ours]: [T; 3]) -> Self {
        Self {
            layered,
            paper,
            ours,
        }
    }
}

/// A sphere of a hierarchy (stored units).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// c'.
    pub center: [f64; 3],
    /// R'.
    pub radius: f64,
    /// Its radius over that of the paper's wrapped sphere at rest.
    pub growth: f64,
}

/// The paper's tree of an asset, with its levels.
pub struct Hierarchies<'a> {
    asset: Asset<'a>,
    /// The binary tree.
    pub tree: PaperTree,
    /// Level and triangles of every node, in storage order.
    pub nodes: Vec<(usize, Vec<u32>)>,
}

/// What depends on q alone.
pub struct Posed {
    q: Vec<f64>,
    step: Step,
    layered: Layered,
}

/// The nodes of a level, with the numbers of our bound, which hold for every q.
pub struct Level<'h> {
    tree: &'h PaperTree,
    /// Node and our sphere.
    nodes: Vec<(usize, Sphere)>,
}

impl<'a> Hierarchies<'a> {
    /// Of an asset.
    pub fn new(asset: Asset<'a>) -> Self {
        let tree = PaperTree::build(&asset);
        let nodes = tree.nodes();
        Self { asset, tree, nodes }
    }

    /// Number of levels.
    pub fn depth(&self) -> usize {
        self.tree.depth
    }

    /// Number of nodes of a level.
    pub fn count(&self, level: usize) -> usize {
        self.nodes.iter().filter(|(l, _)| *l == level).count()
    }

    /// The tree at q.
    ///
    /// # Errors
    /// q beyond its limits, records that break the format's rules.
    pub fn posed(&self, q: &[f32]) -> Result<Posed, Box<dyn Error>> {
        let asset = &self.asset;
        let mut memory = vec![0.0; asset.pose_len()];
        let pose = asset.pose(q, Transform::IDENTITY, &mut memory)?;
        let mut step = Step::default();
        step.prepare(&pose);
        let mut layered = Layered::new(&self.tree, 3 * asset.vertex_count());
        for (v, out) in (0..).zip(layered.vertices.as_chunks_mut::<3>().0) {
            *out = pose.deformed_stored(VertexId(v))?;
        }
        layered.refit(&self.tree, &Place::IDENTITY);
        Ok(Posed {
            q: q.iter().map(|q| f64::from(*q)).collect(),
            step,
            layered,
        })
    }

    /// The nodes of a level.
    ///
    /// # Errors
    /// Records that break the format's rules.
    pub fn level(&self, level: usize) -> Result<Level<'_>, Box<dyn Error>> {
        let all = self.nodes.iter().enumerate();
        let nodes = all
            .filter(|(_, (l, _))| *l == level)
            .map(|(node, (_, triangles))| Ok((node, self.ours(triangles)?)));
        Ok(Level {
            tree: &self.tree,
            nodes: nodes.collect::<Result<_, Box<dyn Error>>>()?,
        })
    }

    /// The vertices of some triangles, each once, ascending.
    pub fn vertices(&self, triangles: &[u32]) -> Vec<u32> {
        let corners = &self.tree.corners;
        let mut vertices: Vec<u32> = triangles
            .iter()
            .flat_map(|t| corners[*t as usize])
            .collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices
    }

    /// Our bound of the vertices of some triangles, in exact numbers (f64), without slack.
    ///
    /// # Errors
    /// Records that break the format's rules.
    pub fn ours(&self, triangles: &[u32]) -> Result<Sphere, Box<dyn Error>> {
        let vertices = self.vertices(triangles);
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
        Ok(Sphere::around(&points, fields))
    }
}

impl Level<'_> {
    /// ‖ΔR‖₂ of our spheres, in storage order.
    pub fn growth_norms(&self) -> Vec<f64> {
        self.nodes
            .iter()
            .map(|(_, ours)| ours.growth_norm())
            .collect()
    }

    /// The level's spheres in storage order.
    pub fn spheres(&self, kind: Kind, posed: &mut Posed) -> Vec<Found> {
        let spheres = self.nodes.iter().map(|(node, ours)| {
            let wide = |[x, y, z, radius]: [f32; 4]| ([x, y, z].map(f64::from), f64::from(radius));
            let (center, radius) = match kind {
                Kind::Layered => wide(posed.layered.sphere(self.tree, *node)),
                Kind::Paper => wide(self.tree.sphere(&posed.step, *node)),
                Kind::Ours => ours.at(&posed.q),
            };
            let [_, _, _, rest] = self.tree.numbers(*node)[0];
            Found {
                center,
                radius,
                growth: growth(radius, f64::from(rest)),
            }
        });
        spheres.collect()
    }
}
