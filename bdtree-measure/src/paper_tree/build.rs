//! Building the paper's tree: longest axis, median, one triangle per leaf; wrapped spheres.

use bdtree_build::advise::works::at_rest;
use bdtree_runtime::{Asset, VertexId};

use super::{LEAF, Link, PaperTree};

impl PaperTree {
    /// The tree of an asset's stored positions and displacements, so that both trees bound the
    /// same numbers.
    pub fn build(asset: &Asset<'_>) -> Self {
        let mode_count = asset.mode_count();
        let mut corners = vec![[0_u32; 3]; asset.triangle_count()];
        for record in asset.triangles() {
            corners[record.id as usize] = record.corners;
        }
        let positions = asset.positions();
        // Where bones have them at rest: bind spaces of several meshes may lie over each other.
        let at_rest = at_rest(asset).expect("a sound asset");
        let centroids: Vec<[f32; 3]> = corners
            .iter()
            .map(|c| {
                let [a, b, c] = c.map(|v| at_rest[v as usize]);
                [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0)
            })
            .collect();
        let fields: Vec<[f32; 3]> = (0..positions.len() as u32)
            .flat_map(|i| {
                let own = asset.displacements(VertexId(i)).expect("a sound asset");
                (0..mode_count).map(move |j| own.of(j))
            })
            .collect();
        let node_count = 2 * corners.len() - 1;
        let mut builder = Builder {
            asset,
            centroids: &centroids,
            fields: &fields,
            seen: vec![u32::MAX; positions.len()],
            vertices: Vec::new(),
            tree: Self {
                mode_count,
                links: Vec::with_capacity(node_count),
                numbers: Vec::with_capacity(node_count * (1 + mode_count)),
                corners: Vec::new(),
                depth: 0,
            },
            corners: &corners,
        };
        let mut order: Vec<u32> = (0..corners.len() as u32).collect();
        builder.node(&mut order, 1);
        let mut tree = builder.tree;
        tree.corners = corners;
        tree
    }
}

struct Builder<'a, 'b> {
    asset: &'a Asset<'b>,
    corners: &'a [[u32; 3]],
    centroids: &'a [[f32; 3]],
    /// U_ij, vertex-major.
    fields: &'a [[f32; 3]],
    /// Node that last collected a vertex.
    seen: Vec<u32>,
    /// The vertices below the current node.
    vertices: Vec<u32>,
    tree: PaperTree,
}

impl Builder<'_, '_> {
    /// Appends the subtree over `triangles`, depth first; median splits keep it shallow.
    fn node(&mut self, triangles: &mut [u32], level: usize) {
        self.tree.depth = self.tree.depth.max(level);
        let index = self.tree.links.len();
        self.wrap(triangles, index as u32);
        if let [triangle] = *triangles {
            self.tree.links.push(Link(LEAF | triangle));
            return;
        }
        let axis = self.longest_axis(triangles);
        let middle = triangles.len() / 2;
        let centroids = self.centroids;
        triangles.select_nth_unstable_by(middle, |a, b| {
            let of = |t: &u32| centroids[*t as usize][axis];
            of(a).total_cmp(&of(b)).then(a.cmp(b))
        });
        let (left, right) = triangles.split_at_mut(middle);
        // Preorder: the left child is next, the right one behind the left subtree's 2n − 1 nodes.
        self.tree.links.push(Link((index + 2 * left.len()) as u32));
        self.node(left, level + 1);
        self.node(right, level + 1);
    }

    fn longest_axis(&self, triangles: &[u32]) -> usize {
        let mut low = [f32::INFINITY; 3];
        let mut high = [f32::NEG_INFINITY; 3];
        for t in triangles {
            for k in 0..3 {
                let x = self.centroids[*t as usize][k];
                low[k] = low[k].min(x);
                high[k] = high[k].max(x);
            }
        }
        let extent = [0, 1, 2].map(|k| high[k] - low[k]);
        (0..3)
            .max_by(|a, b| extent[*a].total_cmp(&extent[*b]))
            .unwrap_or(0)
    }

    /// Appends the node's numbers: c = middle of the vertices' box, R = max ‖p − c‖,
    /// Ū_j = mean of U_ij over the vertices below, ΔR_j = max ‖U_ij − Ū_j‖; f64, rounded up.
    fn wrap(&mut self, triangles: &[u32], stamp: u32) {
        self.vertices.clear();
        for t in triangles {
            for v in self.corners[*t as usize] {
                let seen = &mut self.seen[v as usize];
                if *seen != stamp {
                    *seen = stamp;
                    self.vertices.push(v);
                }
            }
        }
        let positions = self.asset.positions();
        let mut low = [f32::INFINITY; 3];
        let mut high = [f32::NEG_INFINITY; 3];
        for v in &self.vertices {
            for k in 0..3 {
                low[k] = low[k].min(positions[*v as usize][k]);
                high[k] = high[k].max(positions[*v as usize][k]);
            }
        }
        let center = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]));
        let radius = farthest(self.vertices.iter().map(|v| positions[*v as usize]), center);
        self.tree.numbers.push(with_radius(center, radius));

        let m = self.tree.mode_count;
        for j in 0..m {
            let field = |v: &u32| self.fields[*v as usize * m + j];
            let mut sum = [0.0_f64; 3];
            for v in &self.vertices {
                let u = field(v);
                for k in 0..3 {
                    sum[k] += f64::from(u[k]);
                }
            }
            let mean = sum.map(|s| (s / self.vertices.len() as f64) as f32);
            let growth = farthest(self.vertices.iter().map(field), mean);
            self.tree.numbers.push(with_radius(mean, growth));
        }
    }
}

fn with_radius([x, y, z]: [f32; 3], radius: f32) -> [f32; 4] {
    [x, y, z, radius]
}

/// max ‖x − center‖, rounded up to f32.
fn farthest(points: impl Iterator<Item = [f32; 3]>, center: [f32; 3]) -> f32 {
    let squared = points
        .map(|x| {
            (0..3)
                .map(|k| (f64::from(x[k]) - f64::from(center[k])).powi(2))
                .sum::<f64>()
        })
        .fold(0.0, f64::max);
    let exact = squared.sqrt() * (1.0 + 1e-12);
    let rounded = exact as f32;
    if f64::from(rounded) < exact {
        rounded.next_up()
    } else {
        rounded
    }
}
