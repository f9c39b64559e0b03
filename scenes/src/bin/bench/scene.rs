//! What is measured on: a mesh, generated or read, with smooth modes.

use std::collections::HashMap;
use std::path::PathBuf;

use bdtree_build::basis::Basis;
use bdtree_build::basis::elastic::{ElasticOptions, elastic_basis};
use bdtree_build::input::{RawMesh, read_mesh};
use bdtree_build::pipeline::{BakeSettings, Baked, Provenance, bake_fields};
use bdtree_build::progress::Silent;
use bdtree_fixtures::bake::{bumpy_sphere, smooth_basis};
use bdtree_measure::MeasureError;
use bdtree_runtime::TriangleId;

use crate::prelude::*;

/// Mesh and modes.
#[derive(Args)]
pub(crate) struct Scene {
    /// OBJ mesh; without it a bumpy sphere is generated
    #[arg(long)]
    mesh: Option<PathBuf>,
    /// Rings of the generated sphere: about 4 times their square are its triangles
    #[arg(long, default_value_t = 132)]
    rings: u32,
    /// Split each triangle in four this many times
    #[arg(long, default_value_t = 0)]
    subdivide: u32,
    /// Vibration modes of the body, as bdtree-build computes them, instead of smooth waves
    #[arg(long)]
    elastic: bool,
    /// Number of modes
    #[arg(long, default_value_t = 10)]
    pub(crate) modes: usize,
    /// Seed of modes, poses and positions
    #[arg(long, default_value_t = 2004)]
    pub(crate) seed: u64,
    /// Most triangles in a leaf lane
    #[arg(long)]
    pub(crate) leaf_size: Option<usize>,
}

/// Splits each triangle in four at the middles of its sides.
fn subdivide(mesh: &mut RawMesh) {
    let mut middles = HashMap::new();
    let positions = &mut mesh.positions;
    let mut middle = |a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            let (p, q) = (positions[a as usize], positions[b as usize]);
            positions.push([0, 1, 2].map(|k| 0.5 * (p[k] + q[k])));
            positions.len() as u32 - 1
        })
    };
    mesh.triangles = mesh
        .triangles
        .iter()
        .flat_map(|&[a, b, c]| {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        })
        .collect();
    mesh.groups.clear();
}

impl Scene {
    /// The mesh and its modes.
    pub(crate) fn load(&self) -> Result<(RawMesh, Basis)> {
        let mut mesh = match &self.mesh {
            Some(path) => read_mesh(path)?,
            None => bumpy_sphere(self.rings, self.seed),
        };
        for _ in 0..self.subdivide {
            subdivide(&mut mesh);
        }
        let basis = if self.elastic {
            let options = ElasticOptions {
                mode_count: self.modes,
                ..ElasticOptions::default()
            };
            elastic_basis(&mesh, &options, &Silent, &mut Vec::new())?.0
        } else {
            smooth_basis(&mesh, self.modes, self.seed)
        };
        Ok((mesh, basis))
    }

    /// The baked file of mesh and modes.
    pub(crate) fn bake(&self, mesh: &RawMesh, basis: &Basis, nested: bool) -> Result<Baked> {
        let settings = BakeSettings {
            leaf_size: self.leaf_size,
            nested,
            threads: std::thread::available_parallelism().map_or(1, |n| n.get()),
            ..BakeSettings::default()
        };
        let provenance = Provenance::default();
        Ok(bake_fields(mesh, basis, &settings, &provenance, &Silent)?)
    }

    /// The file, opened.
    pub(crate) fn model(&self) -> Result<Model> {
        let (mesh, basis) = self.load()?;
        Ok(Model::from_bytes(&self.bake(&mesh, &basis, false)?.bytes)?)
    }
}

/// q and a ball: what a contender is asked.
pub(crate) struct Case {
    pub(crate) q: Vec<f32>,
    pub(crate) ball: ([f64; 3], f64),
}

impl Case {
    /// Asks the product.
    pub(crate) fn ask(&self, ours: &mut Ours<'_>) -> Result<Answer, MeasureError> {
        ours.balls(&self.q, [self.ball].into_iter())
    }
}

/// Balls about the first corners of deformed triangles. `next` gives q, and how many radii a ball may be from there.
pub(crate) fn cases<R: RngExt>(
    asset: &Asset<'_>,
    (count, radius_rel): (usize, f64),
    mut rng: R,
    mut next: impl FnMut(usize, &mut R) -> (Vec<f32>, f64),
) -> Result<Vec<Case>> {
    let mut memory = vec![0.0; asset.pose_len()];
    let radius = radius_rel * poses::diagonal(asset) * asset.unit();
    let case = |i: usize| {
        let (q, spread) = next(i, &mut rng);
        let pose = asset.pose(&q, Transform::IDENTITY, &mut memory)?;
        let id = TriangleId(rng.random_range(0..asset.triangle_count() as u32));
        let far = spread * radius / 3.0_f64.sqrt();
        let center = pose.deformed(asset.triangle(id)?[0])?;
        let center = center.map(|c| c + far * rng.random_range(-1.0..1.0));
        let ball = (center, radius);
        Ok(Case { q, ball })
    };
    (0..count).map(case).collect()
}
