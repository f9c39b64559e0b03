//! Meshes, fields and a slow reader of the file's bytes for the tests of this crate.
#![allow(dead_code, reason = "each test binary uses its own part")]

use std::io::Read;

use bdtree_build::basis::{Basis, BasisMode};
use bdtree_build::input::RawMesh;
use bdtree_build::pipeline::{BakeSettings, Baked, Provenance, bake_fields};
use bdtree_build::progress::Silent;
use bdtree_format::{
    Header, ModePair, ModeRecord, NodeRecord, ROWS_LEADING, Row, SectionKind, SectionRecord,
    TriangleRecord, VertexModes, pair_count, pair_row,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use zerocopy::{FromBytes, IntoBytes};

/// Ū_x, Ū_y, Ū_z, ΔR, b⁺ and b⁻.
pub(crate) const NUMBERS_PER_MODE: usize = 6;

pub(crate) fn rng(seed: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed)
}

pub(crate) fn unit_vector(rng: &mut Pcg64Mcg) -> [f64; 3] {
    loop {
        let v: [f64; 3] = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
        let n2: f64 = v.iter().map(|x| x * x).sum();
        if n2 > 0.01 && n2 <= 1.0 {
            return v.map(|x| x / n2.sqrt());
        }
    }
}

/// A wavy height field over the unit square, 2 n² triangles.
pub(crate) fn grid(n: usize) -> RawMesh {
    let mut mesh = RawMesh {
        name: "grid.obj".to_string(),
        ..RawMesh::default()
    };
    for y in 0..=n {
        for x in 0..=n {
            let (u, v) = (x as f64 / n as f64, y as f64 / n as f64);
            let z = 0.05 * ((9.0 * u).sin() * (7.0 * v).cos());
            mesh.positions.push([u, v, z]);
        }
    }
    let at = |x: usize, y: usize| (y * (n + 1) + x) as u32;
    for y in 0..n {
        for x in 0..n {
            mesh.triangles.push([at(x, y), at(x + 1, y), at(x, y + 1)]);
            mesh.triangles
                .push([at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]);
        }
    }
    mesh
}

/// Triangles with random corners in a cube: no structure at all.
pub(crate) fn soup(count: usize, seed: u64) -> RawMesh {
    let mut rng = rng(seed);
    let mut mesh = RawMesh::default();
    for i in 0..count as u32 {
        let base: [f64; 3] = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
        for _ in 0..3 {
            let p = base.map(|b| b + rng.random_range(-0.05..0.05));
            mesh.positions.push(p);
        }
        mesh.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    mesh
}

/// Fields from a function of mode and position.
pub(crate) fn basis(
    mesh: &RawMesh,
    modes: usize,
    field: impl Fn(usize, [f64; 3]) -> [f64; 3],
) -> Basis {
    let mut basis = Basis {
        vertex_count: mesh.positions.len(),
        fields: Vec::new(),
        modes: vec![BasisMode::default(); modes],
        animation: None,
    };
    for j in 0..modes {
        basis
            .fields
            .extend(mesh.positions.iter().map(|&p| field(j, p)));
    }
    basis
}

/// Smooth waves of growing frequency.
pub(crate) fn waves(mesh: &RawMesh, modes: usize) -> Basis {
    basis(mesh, modes, |j, p| {
        let f = 1.5 + j as f64;
        let phase = j as f64 * 0.7;
        [
            (f * p[1] + phase).sin() * 0.3,
            (f * p[2] - phase).cos() * 0.2,
            (f * p[0] + 2.0 * phase).sin(),
        ]
    })
}

/// A file of the corpus, or `None` (with a line, or a failure when the corpus is required).
pub(crate) fn corpus(name: &str) -> Option<Vec<u8>> {
    let thread = std::thread::current();
    let path = bdtree_fixtures::corpus::path(thread.name().unwrap_or("tree"), name)?;
    Some(std::fs::read(path).expect("a file of the corpus"))
}

/// The `v` and `f` lines of an OBJ of the corpus, faces as fans.
pub(crate) fn corpus_mesh(name: &str) -> Option<RawMesh> {
    let bytes = corpus(name)?;
    let mut text = String::new();
    if name.ends_with(".gz") {
        flate2::read::MultiGzDecoder::new(&bytes[..])
            .read_to_string(&mut text)
            .ok()?;
    } else {
        text = String::from_utf8_lossy(&bytes).into_owned();
    }
    let mut mesh = RawMesh::default();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let mut p = [0.0; 3];
                for x in &mut p {
                    *x = words.next()?.parse().ok()?;
                }
                mesh.positions.push(p);
            }
            Some("f") => {
                let corners: Vec<u32> = words
                    .filter_map(|w| w.split('/').next()?.parse::<u32>().ok())
                    .map(|i| i - 1)
                    .collect();
                for k in 1..corners.len().saturating_sub(1) {
                    mesh.triangles
                        .push([corners[0], corners[k], corners[k + 1]]);
                }
            }
            _ => {}
        }
    }
    Some(mesh)
}

/// The bridge with the first `modes` of its real modes.
pub(crate) fn bridge(modes: usize) -> Option<(RawMesh, Basis)> {
    let mesh = corpus_mesh("modal/bridge_rest.obj.gz")?;
    let bytes = corpus("modal/bridge_modes_U.f32")?;
    let value = |i: usize| f32::from_le_bytes(bytes[8 + 4 * i..12 + 4 * i].try_into().unwrap());
    let n = mesh.positions.len();
    let mut fields = Vec::new();
    for j in 0..modes {
        for i in 0..n {
            fields.push(std::array::from_fn(|k| {
                f64::from(value(j * 3 * n + 3 * i + k))
            }));
        }
    }
    let basis = Basis {
        vertex_count: n,
        fields,
        modes: vec![BasisMode::default(); modes],
        animation: None,
    };
    Some((mesh, basis))
}
pub(crate) fn bake_with(mesh: &RawMesh, basis: &Basis, settings: &BakeSettings) -> Baked {
    bake_fields(mesh, basis, settings, &Provenance::default(), &Silent).unwrap()
}

pub(crate) fn bake_default(mesh: &RawMesh, basis: &Basis) -> Decoded {
    Decoded::new(&bake_with(mesh, basis, &BakeSettings::default()).bytes)
}

/// A file, copied out of its bytes.
pub(crate) struct Decoded {
    pub(crate) header: Header,
    pub(crate) modes: Vec<ModeRecord>,
    pub(crate) sections: Vec<SectionRecord>,
    pub(crate) nodes: Vec<NodeRecord>,
    pub(crate) rows: Vec<Row>,
    pub(crate) lists: Vec<u16>,
    pub(crate) triangles: Vec<TriangleRecord>,
    pub(crate) slots: Vec<u32>,
    pub(crate) positions: Vec<[f32; 3]>,
    /// U_ij of all vertices and modes, vertex-major, whichever layout holds them.
    pub(crate) displacements: Vec<[f32; 3]>,
    /// Empty in layout 1.
    pub(crate) vertex_modes: Vec<VertexModes>,
}

impl Decoded {
    pub(crate) fn new(bytes: &[u8]) -> Self {
        let (header, rest) = Header::read_from_prefix(bytes).unwrap();
        let mode_bytes = header.mode_count.get() as usize * size_of::<ModeRecord>();
        let modes: Vec<ModeRecord> = records(&rest[..mode_bytes]);
        let table = header.section_count.get() as usize * size_of::<SectionRecord>();
        let sections: Vec<SectionRecord> = records(&rest[mode_bytes..mode_bytes + table]);
        let section = |kind: SectionKind| -> &[u8] {
            let record = sections.iter().find(|s| s.kind == kind).unwrap();
            let start = record.offset.get() as usize;
            &bytes[start..start + record.length.get() as usize]
        };
        let lists: Vec<u16> = records(section(SectionKind::MODE_LISTS));
        let entries: Vec<[f32; 3]> = records(section(SectionKind::DISPLACEMENTS));
        let vertex_modes = match sections.iter().any(|s| s.kind == SectionKind::VERTEX_MODES) {
            true => records(section(SectionKind::VERTEX_MODES)),
            false => Vec::new(),
        };
        let displacements = match vertex_modes.is_empty() {
            true => entries,
            false => expanded(&entries, &vertex_modes, &lists, modes.len()),
        };
        Self {
            header,
            modes,
            nodes: records(section(SectionKind::NODES)),
            rows: records(section(SectionKind::ROWS)),
            lists,
            triangles: records(section(SectionKind::TRIANGLES)),
            slots: records(section(SectionKind::TRIANGLE_SLOTS)),
            positions: records(section(SectionKind::POSITIONS)),
            displacements,
            vertex_modes,
            sections: sections.clone(),
        }
    }

    pub(crate) fn mode_count(&self) -> usize {
        self.modes.len()
    }

    pub(crate) fn node_modes(&self, node: &NodeRecord) -> &[u16] {
        let start = node.mode_list_start as usize;
        &self.lists[start..start + usize::from(node.mode_count)]
    }

    /// The numbers of a node's lane, [`NUMBERS_PER_MODE`] for each mode between its four leading
    /// and its two last rows: per unit of q, exact unless beyond the range of f32.
    pub(crate) fn value(&self, node: &NodeRecord, number: usize, lane: usize) -> f32 {
        let rows = &self.rows[node.row_start as usize..];
        let Some(behind) = number.checked_sub(ROWS_LEADING) else {
            return rows[number][lane];
        };
        let (k, which) = (behind / NUMBERS_PER_MODE, behind % NUMBERS_PER_MODE);
        let modes = self.node_modes(node);
        let Some(&mode) = modes.get(k) else {
            return rows[pair_row(pair_count(modes.len())) + which][lane];
        };
        let bytes = rows[pair_row(k / 2)..pair_row(k / 2 + 1)].as_bytes();
        let own = ModePair::read_from_bytes(bytes).unwrap().numbers(k, lane);
        let exponent = node.scale_exponents[[0, 0, 0, 1, 2, 2][which]];
        let units = f64::from(own[which]);
        let limit = self.modes[usize::from(mode)].q_limit.get();
        (units * 2f64.powi(exponent.into()) / f64::from(limit)) as f32
    }

    /// One unit of Ū, ΔR and b± of a node, per share of a mode's limit.
    pub(crate) fn units(&self, node: &NodeRecord) -> [f64; 3] {
        node.scale_exponents.map(|e| 2f64.powi(e.into()))
    }

    /// Σ |q_j| over its limit.
    pub(crate) fn shares(&self, q: &[f32]) -> f64 {
        q.iter()
            .zip(&self.modes)
            .map(|(q, mode)| f64::from(q.abs()) / f64::from(mode.q_limit.get()))
            .sum()
    }

    /// Triangle slots below every lane of every node, by walking down from it.
    pub(crate) fn slots_below(&self, node: usize, lane: usize) -> Vec<usize> {
        let record = &self.nodes[node];
        let bit = 1u8 << lane;
        if record.leaf_mask & bit != 0 {
            let before: usize = record.leaf_counts[..lane]
                .iter()
                .map(|&c| usize::from(c))
                .sum();
            let start = record.first_slot as usize + before;
            return (start..start + usize::from(record.leaf_counts[lane])).collect();
        }
        if record.inner_mask & bit == 0 {
            return Vec::new();
        }
        let rank = (record.inner_mask & (bit - 1)).count_ones();
        let child = (record.first_child + rank) as usize;
        (0..8).flat_map(|k| self.slots_below(child, k)).collect()
    }

    pub(crate) fn vertices_below(&self, node: usize, lane: usize) -> Vec<usize> {
        let mut vertices: Vec<usize> = self
            .slots_below(node, lane)
            .into_iter()
            .flat_map(|slot| self.triangles[slot].corners)
            .map(|v| v as usize)
            .collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices
    }

    /// Every lane that is not empty.
    pub(crate) fn lanes(&self) -> Vec<(usize, usize)> {
        let used = |node: &NodeRecord, k: usize| (node.inner_mask | node.leaf_mask) >> k & 1 == 1;
        (0..self.nodes.len())
            .flat_map(|i| (0..8).map(move |k| (i, k)))
            .filter(|&(i, k)| used(&self.nodes[i], k))
            .collect()
    }

    /// c'(q), R'(q)² and T = R + s of a lane in f64.
    pub(crate) fn sphere(&self, node: usize, lane: usize, q: &[f32]) -> ([f64; 3], f64, f64) {
        let node = &self.nodes[node];
        let at = |row: usize| f64::from(self.value(node, row, lane));
        let mut center: [f64; 3] = std::array::from_fn(at);
        let radius = at(3);
        let (mut cross, mut growth) = (0.0, 0.0);
        for (k, &mode) in self.node_modes(node).iter().enumerate() {
            let q = f64::from(q[usize::from(mode)]);
            let row = ROWS_LEADING + NUMBERS_PER_MODE * k;
            for (axis, c) in center.iter_mut().enumerate() {
                *c += at(row + axis) * q;
            }
            growth += at(row + 3) * q.abs();
            cross += at(row + if q > 0.0 { 4 } else { 5 }) * q.abs();
        }
        (
            center,
            radius * radius + 2.0 * cross + growth * growth,
            radius + growth,
        )
    }

    /// Deformed vertices in f64.
    pub(crate) fn deform(&self, q: &[f32]) -> Vec<[f64; 3]> {
        let m = self.mode_count();
        (0..self.positions.len())
            .map(|i| {
                let mut p = self.positions[i].map(f64::from);
                for (j, &q) in q.iter().enumerate() {
                    for (x, u) in p.iter_mut().zip(self.displacements[i * m + j]) {
                        *x += f64::from(u) * f64::from(q);
                    }
                }
                p
            })
            .collect()
    }

    /// Random q: sparse, dense, tiny, typical and near the limit, all signs.
    pub(crate) fn random_q(&self, rng: &mut Pcg64Mcg) -> Vec<f32> {
        let sparse = rng.random_range(0.0..1.0) < 0.3;
        let kind = rng.random_range(0..4);
        self.modes
            .iter()
            .map(|mode| {
                let (range, limit) = (mode.q_range.get(), mode.q_limit.get());
                let size = match kind {
                    0 => range * 1e-4,
                    1 => range,
                    2 => (range * 20.0).min(limit),
                    _ => limit,
                };
                if sparse && rng.random_range(0.0..1.0) < 0.8 {
                    0.0
                } else {
                    size * rng.random_range(-1.0f32..=1.0)
                }
            })
            .collect()
    }
}

/// The displacements of all modes: zero where a vertex's list leaves one out (SPEC 7.6).
fn expanded(
    entries: &[[f32; 3]],
    vertex_modes: &[VertexModes],
    lists: &[u16],
    mode_count: usize,
) -> Vec<[f32; 3]> {
    let mut all = vec![[0.0; 3]; (vertex_modes.len() - 1) * mode_count];
    for (pair, row) in vertex_modes
        .windows(2)
        .zip(all.chunks_exact_mut(mode_count))
    {
        let own = &entries[pair[0].first_entry as usize..pair[1].first_entry as usize];
        let modes = &lists[pair[0].mode_list_start as usize..][..own.len()];
        for (u, j) in own.iter().zip(modes) {
            row[usize::from(*j)] = *u;
        }
    }
    all
}

fn records<T: FromBytes>(bytes: &[u8]) -> Vec<T> {
    bytes
        .chunks_exact(size_of::<T>())
        .map(|chunk| T::read_from_bytes(chunk).unwrap())
        .collect()
}
