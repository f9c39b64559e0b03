//! What is measured on: a mesh, generated or read, with smooth modes.

use std::collections::HashMap;
use std::error::Error;
use std::path::PathBuf;

use bdtree_build::basis::Basis;
use bdtree_build::basis::elastic::{ElasticOptions, elastic_basis};
use bdtree_build::input::{RawMesh, read_mesh};
use bdtree_build::pipeline::{BakeSettings, Baked, Provenance, bake_fields};
use bdtree_build::progress::Silent;
use bdtree_fixtures::bake::{bumpy_sphere, smooth_basis};
use clap::Args;

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
    pub(crate) fn load(&self) -> Result<(RawMesh, Basis), Box<dyn Error>> {
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
    pub(crate) fn bake(&self, mesh: &RawMesh, basis: &Basis) -> Result<Baked, Box<dyn Error>> {
        let settings = BakeSettings {
            leaf_size: self.leaf_size,
            threads: std::thread::available_parallelism().map_or(1, |n| n.get()),
            ..BakeSettings::default()
        };
        Ok(bake_fields(
            mesh,
            basis,
            &settings,
            &Provenance::default(),
            &Silent,
        )?)
    }
}
