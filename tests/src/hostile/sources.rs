//! The sound files that damage is done to: small ones of every kind that the format has.

use std::fs;

use bdtree_build::basis::Basis;
use bdtree_build::input::{GroupKind, RawGroup, RawMesh};
use bdtree_build::pipeline::BakeSettings;
use bdtree_runtime::{AlignedBytes, Asset};

use crate::sections::with_all_displacements;
use crate::{bake, golden};

/// Sound files, small ones first.
#[derive(Debug)]
pub struct Sources {
    files: Vec<(&'static str, AlignedBytes)>,
    /// How many of them are small enough for the bulk of the cases.
    small: usize,
    /// What pair queries hold against a damaged file.
    pub partner: AlignedBytes,
}

fn sphere(n: u32) -> RawMesh {
    let mut mesh = bake::bumpy_sphere(n, 1);
    let group = |kind, name: &str, first_triangle, triangle_count| RawGroup {
        kind,
        name: name.to_string(),
        first_triangle,
        triangle_count,
    };
    mesh.groups = vec![
        group(GroupKind::Object, "sphere", 0, mesh.triangles.len() as u32),
        group(GroupKind::Material, "gläsern", 3, 7),
    ];
    mesh
}

/// Every field moves the vertices on one side only.
fn local_basis(mesh: &RawMesh, mode_count: usize) -> Basis {
    let mut basis = bake::smooth_basis(mesh, mode_count, 3);
    let count = mesh.positions.len();
    for (k, u) in basis.fields.iter_mut().enumerate() {
        let (j, p) = (k / count, mesh.positions[k % count]);
        let side = if j % 2 == 0 { 1.0 } else { -1.0 };
        if side * p[j % 3] < 0.3 {
            *u = [0.0; 3];
        }
    }
    basis
}

impl Sources {
    /// Bakes and reads them.
    ///
    /// # Panics
    /// When a bake fails or a golden file is missing.
    pub fn new() -> Self {
        let (mesh, tiny) = (sphere(4), bake::bumpy_sphere(2, 1));
        let moving = bake::with_frames(bake::smooth_basis(&tiny, 2, 1), 3, 1.0, 1);
        let nested = BakeSettings {
            nested: true,
            ..BakeSettings::default()
        };
        let two = bake::smooth_basis(&mesh, 2, 1);
        let listed = bake::baked(&mesh, &local_basis(&mesh, 10));
        assert!(
            !Asset::open(&listed)
                .expect("open")
                .vertex_modes()
                .is_empty()
        );
        let golden = |name: &str| {
            let path = golden::folder().join(name);
            AlignedBytes::copy_of(&fs::read(path).expect("a golden file"))
        };
        let large = sphere(9);
        let files = vec![
            ("rigid", bake::baked(&mesh, &bake::rigid(&mesh))),
            ("two modes", bake::baked(&mesh, &two)),
            ("nested", bake::baked_with(&mesh, &two, &nested)),
            ("all displacements", with_all_displacements(&listed)),
            ("listed modes", listed),
            ("frames", bake::baked(&tiny, &moving)),
            ("tetrahedron.bdt", golden("tetrahedron.bdt")),
            ("animated.bdt", golden("animated.bdt")),
            // From here on larger ones.
            ("foreign.bdt", golden("foreign.bdt")),
            ("sphere.bdt", golden("sphere.bdt")),
            ("sparse.bdt", golden("sparse.bdt")),
            (
                "many triangles",
                bake::baked(&large, &local_basis(&large, 6)),
            ),
        ];
        Self {
            files,
            small: 8,
            partner: bake::baked(&tiny, &bake::smooth_basis(&tiny, 1, 1)),
        }
    }

    /// All files with their names.
    pub fn all(&self) -> &[(&'static str, AlignedBytes)] {
        &self.files
    }

    /// Those that are small.
    pub fn small(&self) -> &[(&'static str, AlignedBytes)] {
        &self.files[..self.small]
    }

    /// Those that are not.
    pub fn larger(&self) -> &[(&'static str, AlignedBytes)] {
        &self.files[self.small..]
    }
}

impl Default for Sources {
    fn default() -> Self {
        Self::new()
    }
}
