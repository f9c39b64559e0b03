//! Golden files: small assets and the answers of fixed queries. Only `+ − × ÷ √` go into them, so
//! they have the same bytes on every processor.

use std::collections::HashMap;
use std::mem::offset_of;
use std::path::{Path, PathBuf};

use bdtree_build::basis::{Animation, Basis, BasisError, BasisMode, RigidMotion};
use bdtree_build::input::{GroupKind, RawGroup, RawMesh};
use bdtree_build::pipeline::{BakeSettings, Provenance, bake_fields};
use bdtree_build::progress::Silent;
use bdtree_format::{GroupRecord, Header, SectionKind, SectionRecord};
use bdtree_runtime::{
    AlignedBytes, Asset, Contact, PairContact, PairStackEntry, Pose, StackEntry, Transform, query,
};
use serde_json::{Value, json};

use crate::mutate;
use crate::sections::{self, Part};

/// Where the golden files lie.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/golden")
}

/// All golden files: name and content, made anew.
///
/// # Panics
/// When a bake fails.
pub fn files() -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    for (name, bytes) in [
        ("tetrahedron", made(&tetrahedron(), &rigid(4), "rigid")),
        ("sphere", sphere_with_groups()),
        ("sparse", sparse()),
        ("foreign", foreign()),
        ("animated", animated()),
    ] {
        let answers = answers(&AlignedBytes::copy_of(&bytes));
        files.push((format!("{name}.bdt"), bytes));
        files.push((format!("{name}.jsonl"), answers.into_bytes()));
    }
    files
}

fn made(mesh: &RawMesh, basis: &Basis, kind: &str) -> Vec<u8> {
    let provenance = Provenance {
        kind: kind.to_string(),
        ..Provenance::default()
    };
    bake_fields(mesh, basis, &BakeSettings::default(), &provenance, &Silent)
        .expect("bake")
        .bytes
}

fn rigid(vertex_count: usize) -> Basis {
    Basis {
        vertex_count,
        ..Basis::default()
    }
}

fn tetrahedron() -> RawMesh {
    RawMesh {
        name: "tetrahedron".to_string(),
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        ..RawMesh::default()
    }
}

/// A cube's faces, n × n squares each, pushed onto the unit sphere: 12 n² triangles.
fn cube_sphere(n: i32) -> RawMesh {
    let mut mesh = RawMesh {
        name: format!("cube_sphere_{n}"),
        ..RawMesh::default()
    };
    let mut known = HashMap::new();
    for face in 0..6 {
        let (axis, side) = (face / 2, if face % 2 == 0 { n } else { -n });
        let mut corner = |i: i32, j: i32| {
            let mut at = [0; 3];
            at[axis] = side;
            // Seen from outside, i and j turn the same way on every face.
            let (u, v) = if side > 0 { (1, 2) } else { (2, 1) };
            at[(axis + u) % 3] = 2 * i - n;
            at[(axis + v) % 3] = 2 * j - n;
            *known.entry(at).or_insert_with(|| {
                let p = at.map(f64::from);
                let norm = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
                mesh.positions.push(p.map(|c| c / norm));
                mesh.positions.len() as u32 - 1
            })
        };
        for i in 0..n {
            for j in 0..n {
                let [a, b, c, d] =
                    [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| corner(i, j));
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    mesh
}

fn basis(mesh: &RawMesh, fields: &[&dyn Fn([f64; 3]) -> [f64; 3]]) -> Basis {
    Basis {
        vertex_count: mesh.positions.len(),
        fields: fields
            .iter()
            .flat_map(|field| mesh.positions.iter().map(|p| field(*p)))
            .collect(),
        modes: (0..fields.len())
            .map(|j| BasisMode {
                name: Some(format!("field {j}")),
                omega_rad_s: (j == 1).then_some(12.5),
                modal_mass_kg: (j == 1).then_some(0.25),
                q_range: Some(0.5),
                default_q: None,
            })
            .collect(),
        animation: None,
    }
}

fn sphere_with_groups() -> Vec<u8> {
    let mut mesh = cube_sphere(4);
    let group = |kind, name: &str, first_triangle, triangle_count| RawGroup {
        kind,
        name: name.to_string(),
        first_triangle,
        triangle_count,
    };
    mesh.groups = vec![
        group(GroupKind::Object, "sphere", 0, 192),
        group(GroupKind::Material, "Glas ü", 0, 64),
        group(GroupKind::Group, "", 64, 0),
        group(GroupKind::Material, "metal", 64, 128),
    ];
    let basis = basis(
        &mesh,
        &[
            &|[x, y, _]| [y, -x, 0.0],
            &|[x, y, z]| [0.2 * x, 0.2 * y, -0.4 * z],
            &|[x, y, z]| [0.3 * y * z, 0.3 * z * x, 0.3 * x * y],
        ],
    );
    made(&mesh, &basis, "given")
}

/// Eight local fields: each moves the vertices around one of the cube's corners.
fn sparse() -> Vec<u8> {
    let mesh = cube_sphere(6);
    let bump = |corner: usize| {
        move |p: [f64; 3]| {
            let sign = [0, 1, 2].map(|k| if corner >> k & 1 == 0 { 0.6 } else { -0.6 });
            let square: f64 = (0..3).map(|k| (p[k] - sign[k]) * (p[k] - sign[k])).sum();
            let height = (1.0 - 2.0 * square).max(0.0);
            sign.map(|c| c * height * height)
        }
    };
    let bumps = [0, 1, 2, 3, 4, 5, 6, 7].map(bump);
    let fields: Vec<&dyn Fn([f64; 3]) -> [f64; 3]> = bumps
        .iter()
        .map(|f| f as &dyn Fn([f64; 3]) -> [f64; 3])
        .collect();
    made(&mesh, &basis(&mesh, &fields), "given")
}

/// Four frames of two fields, turned and moved, with times, default weights and a stated error.
fn animated() -> Vec<u8> {
    let mesh = cube_sphere(2);
    let mut basis = basis(
        &mesh,
        &[&|[x, _, z]| [z, 0.0, 0.5 * x], &|[x, y, z]| {
            [0.2 * x * x, 0.2 * y * y, 0.2 * z * z]
        }],
    );
    basis.modes[0].default_q = Some(0.125);
    let motion = |rotation, translation| RigidMotion {
        rotation,
        translation,
    };
    basis.animation = Some(Animation {
        frame_count: 4,
        times_s: Some(vec![0.0, 0.25, 0.5, 2.0]),
        // 300 is beyond the limit that the field alone would give.
        q: vec![0.0, 0.0, 0.3, -0.7, -1.25, 1e-40, 300.0, 0.5],
        motions: vec![
            RigidMotion::IDENTITY,
            motion([0.6, 0.0, 0.0, 0.8], [0.5, 0.0, 0.0]),
            motion([0.5, -0.5, 0.5, 0.5], [0.0, -2.0, 0.25]),
            motion([0.0, 0.48, 0.64, -0.6], [1e3, 0.0, -0.1]),
        ],
    });
    let provenance = Provenance {
        error: Some(BasisError {
            max_rel: 0.0625,
            rms_rel: 0.01,
            frame: Some(2),
            vertex: 5,
        }),
        ..Provenance::default()
    };
    bake_fields(
        &mesh,
        &basis,
        &BakeSettings::default(),
        &provenance,
        &Silent,
    )
    .expect("bake")
    .bytes
}

/// A file that the encoder never writes: an unknown optional section before all others, unknown
/// optional features, a group of unknown kind, no metadata, bounds in the header larger than
/// needed, negative zeros.
fn foreign() -> Vec<u8> {
    let source = sphere_with_groups();
    let mut unknown = vec![0; size_of::<SectionRecord>()];
    unknown[..8].copy_from_slice(b"XTRA\x2a\0\0\0");
    let mut parts = vec![Part {
        record: unknown,
        body: b"what a later version adds".to_vec(),
    }];
    parts.extend(sections::take_apart(&source));
    parts.retain(|part| part.kind() != SectionKind::METADATA);
    let mut bytes = sections::put_together(&source, parts);
    for (at, value) in [
        (
            offset_of!(Header, features_optional),
            &0x8000_0001_u32.to_le_bytes()[..],
        ),
        (
            offset_of!(Header, leaf_triangles_max),
            &255_u32.to_le_bytes(),
        ),
        (
            offset_of!(Header, position_norm_max),
            &1.5_f32.to_le_bytes(),
        ),
    ] {
        mutate::put(&mut bytes, at, value);
    }
    let groups = mutate::section(&bytes, SectionKind::GROUPS).start;
    let second = groups + size_of::<GroupRecord>() + offset_of!(GroupRecord, kind);
    mutate::put(&mut bytes, second, &77_u32.to_le_bytes());
    for kind in [SectionKind::POSITIONS, SectionKind::DISPLACEMENTS] {
        for at in mutate::section(&bytes, kind).step_by(8) {
            if mutate::get_u32(&bytes, at) == 0 {
                mutate::put(&mut bytes, at, &(-0.0_f32).to_le_bytes());
            }
        }
    }
    mutate::repair(&mut bytes);
    bytes
}

/// Three steps with a q and a placement each, then the frames, as they are and placed.
fn steps(asset: &Asset<'_>) -> Vec<(Vec<f32>, Transform)> {
    let mut steps = Vec::new();
    for step in 0..3_i32 {
        let q: Vec<f32> = (0..asset.mode_count())
            .map(|j| step as f32 * if j % 2 == 0 { 0.25 } else { -0.125 })
            .collect();
        let place = Transform {
            rotation: [[0.0, 0.0, 0.0, 1.0], [0.6, 0.0, 0.8, 0.0], [0.5; 4]][step as usize],
            translation: [f64::from(step), 0.0, -0.5],
            scale: 1.0 + 0.5 * f64::from(step),
        };
        steps.push((q, place));
    }
    let place = steps[1].1;
    for frame in (0..asset.frame_count()).filter_map(|k| asset.frame(k)) {
        let placed = place.after(frame.transform()).expect("a placement");
        steps.push((frame.q().to_vec(), frame.transform()));
        steps.push((frame.q().to_vec(), placed));
    }
    steps
}

/// One JSON line per query; `f64` as the shortest decimals that read back equal.
fn answers(bytes: &AlignedBytes) -> String {
    let asset = Asset::open(bytes).expect("open");
    let mut lines = String::new();
    let mut stack = vec![StackEntry::default(); asset.stack_len()];
    let mut pair_stack = vec![PairStackEntry::default(); asset.pair_stack_len(&asset)];
    for (step, (q, place)) in steps(&asset).into_iter().enumerate() {
        let mut memory = vec![0.0; asset.pose_len()];
        let mut memory2 = vec![0.0; asset.pose_len()];
        let pose = Pose::new(&asset, &q, place, &mut memory).expect("pose");
        let rest = vec![0.0; asset.mode_count()];
        let pose2 = Pose::new(&asset, &rest, Transform::IDENTITY, &mut memory2).expect("pose");
        let mut line = |kind: &str, answer: Value| {
            lines.push_str(&json!({"step": step, "kind": kind, "answer": answer}).to_string());
            lines.push('\n');
        };
        let point = [0.75, 0.5, 0.25];

        let mut found: Vec<Contact> = Vec::new();
        query::ball(&asset, &pose, point, 0.5, &mut stack, &mut found).expect("ball");
        line("ball", contacts(found));
        let mut found: Vec<Contact> = Vec::new();
        let normal = [0.0, 3.0, 4.0];
        query::plane(&asset, &pose, normal, -0.75, &mut stack, &mut found).expect("plane");
        line("plane", contacts(found));
        let near = query::closest(&asset, &pose, point, f64::INFINITY, &mut stack)
            .expect("closest")
            .hit
            .map(|h| json!([h.triangle.0, h.point, h.distance, h.barycentric]));
        line("closest", json!(near));
        let toward = [-1.0, -0.5, -0.25];
        let hit = query::ray(&asset, &pose, [3.0, 1.5, 0.5], toward, 100.0, &mut stack)
            .expect("ray")
            .hit
            .map(|h| json!([h.triangle.0, h.point, h.distance, h.barycentric]));
        line("ray", json!(hit));
        let mut found: Vec<PairContact> = Vec::new();
        let (one, two) = ((&asset, &pose), (&asset, &pose2));
        query::pair(one, two, 0.0, &mut pair_stack, &mut found).expect("pair");
        let mut ids: Vec<[u32; 2]> = found
            .iter()
            .map(|c| [c.triangle1.0, c.triangle2.0])
            .collect();
        ids.sort_unstable();
        // The whole list would be long where two spheres are the same.
        line(
            "pair",
            json!([ids.len(), ids.iter().take(40).collect::<Vec<_>>()]),
        );
    }
    lines
}

fn contacts(mut found: Vec<Contact>) -> Value {
    found.sort_by_key(|c| c.triangle);
    found
        .iter()
        .map(|c| json!([c.triangle.0, c.point, c.normal, c.dist, c.barycentric]))
        .collect()
}
