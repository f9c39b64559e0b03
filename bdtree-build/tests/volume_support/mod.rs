//! Volume meshes for tests: blocks of cells, and a reader of the two statements of a `.veg` file
//! that they need.
#![allow(dead_code)] // each test uses its part

use std::path::Path;

use bdtree_build::basis::volume::{VolumeModes, VolumeOptions, VolumeReport, volume_modes};
use bdtree_build::error::BakeError;
use bdtree_build::input::RawMesh;
use bdtree_build::input::volume::{RawMaterial, RawVolume};
use bdtree_build::progress::Silent;

pub(crate) type V3 = [f64; 3];

/// Corners of the cell at the origin, in VTK's order.
const CORNERS: [[usize; 3]; 8] = [
    [0, 0, 0],
    [1, 0, 0],
    [1, 1, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 0, 1],
    [1, 1, 1],
    [0, 1, 1],
];

/// n × m × k hexahedra; `at` maps the unit cube to the body.
pub(crate) fn hexahedra(n: [usize; 3], at: impl Fn(V3) -> V3) -> RawVolume {
    let index = |c: [usize; 3]| ((c[2] * (n[1] + 1) + c[1]) * (n[0] + 1) + c[0]) as u32;
    let mut volume = RawVolume {
        name: "block".to_owned(),
        ..RawVolume::default()
    };
    for z in 0..=n[2] {
        for y in 0..=n[1] {
            for x in 0..=n[0] {
                let c = [x, y, z];
                volume
                    .nodes
                    .push(at(std::array::from_fn(|a| c[a] as f64 / n[a] as f64)));
            }
        }
    }
    for z in 0..n[2] {
        for y in 0..n[1] {
            for x in 0..n[0] {
                let corner = |c: [usize; 3]| index([x + c[0], y + c[1], z + c[2]]);
                volume.hexahedra.push(CORNERS.map(corner));
            }
        }
    }
    volume
}

/// A box of hexahedra.
pub(crate) fn block(n: [usize; 3], size: V3) -> RawVolume {
    hexahedra(n, |p| std::array::from_fn(|a| p[a] * size[a]))
}

/// The same body of tetrahedra: five per hexahedron, alternating so that faces match.
pub(crate) fn five_tetrahedra(mut volume: RawVolume, n: [usize; 3]) -> RawVolume {
    let even = [
        [0, 1, 3, 4],
        [1, 2, 3, 6],
        [1, 4, 5, 6],
        [3, 4, 6, 7],
        [1, 3, 4, 6],
    ];
    let odd = [
        [0, 1, 2, 5],
        [0, 2, 3, 7],
        [0, 5, 7, 4],
        [2, 5, 6, 7],
        [0, 2, 7, 5],
    ];
    for (i, cell) in std::mem::take(&mut volume.hexahedra).iter().enumerate() {
        let parity = i % n[0] + i / n[0] % n[1] + i / (n[0] * n[1]);
        let split = if parity.is_multiple_of(2) { even } else { odd };
        volume
            .tetrahedra
            .extend(split.map(|t| t.map(|c: usize| cell[c])));
    }
    volume
}

/// The surface of a body of hexahedra: two triangles per quad that only one of them has.
pub(crate) fn surface(volume: &RawVolume) -> RawMesh {
    let quads = [
        [0, 3, 2, 1],
        [4, 5, 6, 7],
        [0, 1, 5, 4],
        [1, 2, 6, 5],
        [2, 3, 7, 6],
        [3, 0, 4, 7],
    ];
    let mut faces: Vec<([u32; 4], [u32; 4])> = Vec::new();
    for cell in &volume.hexahedra {
        for quad in quads.map(|q| q.map(|c: usize| cell[c])) {
            let mut key = quad;
            key.sort_unstable();
            faces.push((key, quad));
        }
    }
    faces.sort_unstable();
    let outer = faces.chunk_by(|a, b| a.0 == b.0).filter(|f| f.len() == 1);
    let triangles = outer.flat_map(|f| {
        let [a, b, c, d] = f[0].1;
        [[a, b, c], [a, c, d]]
    });
    RawMesh {
        name: "block.obj".to_owned(),
        positions: volume.nodes.clone(),
        triangles: triangles.collect(),
        ..RawMesh::default()
    }
}

/// Puts two volumes side by side.
pub(crate) fn join(mut a: RawVolume, b: &RawVolume) -> RawVolume {
    let n = a.nodes.len() as u32;
    a.nodes.extend(&b.nodes);
    a.tetrahedra
        .extend(b.tetrahedra.iter().map(|t| t.map(|c| c + n)));
    a.hexahedra
        .extend(b.hexahedra.iter().map(|t| t.map(|c| c + n)));
    a
}

/// Cells of [`bar`].
pub(crate) const BAR: [usize; 3] = [8, 2, 2];

/// A bar of 4 × 1 × 1.
pub(crate) fn bar() -> RawVolume {
    block(BAR, [4.0, 1.0, 1.0])
}

/// Steel.
pub(crate) fn steel(modes: usize) -> VolumeOptions {
    of(2e11, 0.3, 7800.0, modes)
}

/// One material for all.
pub(crate) fn of(young_pa: f64, poisson: f64, density_kg_m3: f64, modes: usize) -> VolumeOptions {
    VolumeOptions {
        mode_count: modes,
        young_pa: Some(young_pa),
        poisson: Some(poisson),
        density_kg_m3: Some(density_kg_m3),
        ..VolumeOptions::default()
    }
}

/// The modes, or a panic; checks what every solution promises.
pub(crate) fn solve(volume: &RawVolume, options: &VolumeOptions) -> (VolumeModes, VolumeReport) {
    let (modes, report) = volume_modes(volume, options, &Silent, &mut Vec::new()).expect("modes");
    assert!(report.residual_max <= 1e-6, "{report:?}");
    for mode in &modes.modes {
        assert_eq!(mode.field.len(), volume.nodes.len());
        assert!(mode.field.iter().flatten().all(|x| x.is_finite()));
    }
    (modes, report)
}

/// Frequencies in Hz, or why there are none.
pub(crate) fn run(volume: &RawVolume, options: &VolumeOptions) -> Result<Vec<f64>, BakeError> {
    let (modes, _) = volume_modes(volume, options, &Silent, &mut Vec::new())?;
    assert!(modes.modes.iter().all(|m| m.omega_rad_s.is_finite()));
    let fields = modes.modes.iter().flat_map(|m| &m.field);
    assert!(fields.flatten().all(|x| x.is_finite()));
    Ok(hertz(&modes))
}

/// Frequencies in Hz.
pub(crate) fn hertz(modes: &VolumeModes) -> Vec<f64> {
    let omegas = modes.modes.iter().map(|m| m.omega_rad_s);
    omegas.map(|w| w / std::f64::consts::TAU).collect()
}

/// A `.veg` file with one material, of elements of one kind.
pub(crate) fn read_veg(path: &Path) -> RawVolume {
    let text = std::fs::read_to_string(path).expect("a file");
    let mut volume = RawVolume {
        name: path.file_name().unwrap().to_string_lossy().into_owned(),
        ..RawVolume::default()
    };
    let mut section = "";
    for line in text.lines().map(str::trim) {
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        if line.starts_with('*') {
            section = line;
            continue;
        }
        let numbers: Vec<f64> = line
            .split([' ', ',', '\t'])
            .filter_map(|w| w.parse().ok())
            .collect();
        let corners = |k: usize| numbers[1 + k] as u32 - 1;
        match (section.split(' ').next(), numbers.len()) {
            (Some("*VERTICES"), 4) if !(numbers[1] == 3.0 && volume.nodes.is_empty()) => {
                volume.nodes.push([numbers[1], numbers[2], numbers[3]]);
            }
            (Some("*ELEMENTS"), 5) => volume.tetrahedra.push(std::array::from_fn(corners)),
            (Some("*ELEMENTS"), 9) => volume.hexahedra.push(std::array::from_fn(corners)),
            (Some("*MATERIAL"), 3) => volume.materials.push(RawMaterial {
                name: None,
                density_kg_m3: numbers[0],
                young_pa: numbers[1],
                poisson: numbers[2],
            }),
            _ => {}
        }
    }
    volume
}
