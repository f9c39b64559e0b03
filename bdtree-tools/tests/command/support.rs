//! Small assets in a temporary folder, and the binary run there.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use bdtree_build::basis::{Animation, Basis, BasisError, BasisMode, RigidMotion};
use bdtree_build::input::{GroupKind, RawGroup, RawMesh};
use bdtree_build::pipeline::{BakeSettings, Provenance, bake_fields};
use bdtree_build::progress::Silent;
use bdtree_build::recipe::{Motion, Recipe};
use bdtree_fixtures::models;
use serde_json::Value;
use tempfile::TempDir;

/// What a run of the binary left.
#[derive(Debug)]
pub(crate) struct Ran {
    pub(crate) code: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

/// A temporary folder with `a.bdt` (three modes), `rigid.bdt`, and whatever a test writes.
pub(crate) struct Folder(TempDir);

/// What the command wrote on its error stream, without what Mesa writes where no desktop runs.
fn own_lines(bytes: &[u8]) -> String {
    let text = std::str::from_utf8(bytes).expect("UTF-8");
    let lines = text.split_inclusive('\n');
    lines
        .filter(|line| !line.contains("XDG_RUNTIME_DIR"))
        .collect()
}

impl Folder {
    pub(crate) fn new() -> Self {
        let folder = Self(tempfile::tempdir().expect("a temporary folder"));
        folder.write("a.bdt", baked(&ball_mesh(), &basis(&ball_mesh())));
        let rigid = Basis {
            vertex_count: ball_mesh().positions.len(),
            ..Basis::default()
        };
        folder.write("rigid.bdt", baked(&ball_mesh(), &rigid));
        folder
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn root(&self) -> &Path {
        self.0.path()
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).expect("written");
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).expect("read")
    }

    /// Runs `bdtree` in the folder.
    pub(crate) fn run(&self, arguments: &[&str]) -> Ran {
        self.run_with(arguments, "")
    }

    /// Runs `bdtree` in the folder with a text on its standard input.
    pub(crate) fn run_with(&self, arguments: &[&str], input: &str) -> Ran {
        let mut child = Command::new(env!("CARGO_BIN_EXE_bdtree"))
            .args(arguments)
            .current_dir(self.root())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("bdtree starts");
        let mut stdin = child.stdin.take().expect("piped");
        let _ = stdin.write_all(input.as_bytes()); // a command that does not read may be gone
        drop(stdin);
        let output = child.wait_with_output().expect("bdtree ends");
        Ran {
            code: output.status.code().expect("no signal"),
            out: String::from_utf8(output.stdout).expect("UTF-8"),
            err: own_lines(&output.stderr),
        }
    }

    /// Runs a command that must succeed and prints one JSON object.
    pub(crate) fn json(&self, arguments: &[&str]) -> Value {
        let ran = self.run(arguments);
        assert_eq!((ran.code, ran.err.as_str()), (0, ""), "{}", ran.out);
        serde_json::from_str(&ran.out).expect("one JSON object")
    }

    /// Writes a scene and runs its queries, which must succeed: one value per line.
    pub(crate) fn query(&self, scene: &Value, options: &[&str]) -> Vec<Value> {
        self.write("scene.json", scene.to_string());
        let ran = self.run(&[&["query", "scene.json"], options].concat());
        assert_eq!((ran.code, ran.err.as_str()), (0, ""));
        let lines = ran.out.lines();
        lines
            .map(|line| serde_json::from_str(line).expect("JSON"))
            .collect()
    }

    /// Positions of `deform`, read back from its .npy.
    pub(crate) fn deformed(&self, asset: &str, q: &str) -> Vec<[f64; 3]> {
        let ran = self.run(&["deform", asset, "--q", q, "-o", "deformed.npy"]);
        assert_eq!((ran.code, ran.err.as_str()), (0, ""));
        positions_of_npy(&self.read("deformed.npy"))
    }
}

/// The rows of an (N, 3) array.
pub(crate) fn positions_of_npy(bytes: &[u8]) -> Vec<[f64; 3]> {
    let file = npyz::NpyFile::new(bytes).expect("npy");
    assert_eq!(file.shape().len(), 2);
    assert_eq!(file.shape()[1], 3);
    assert_eq!(file.order(), npyz::Order::C);
    assert_eq!(file.dtype().descr(), "'<f8'");
    let numbers: Vec<f64> = file.into_vec().expect("f64");
    let rows = numbers.chunks_exact(3);
    rows.map(|r| [r[0], r[1], r[2]]).collect()
}

pub(crate) fn baked(mesh: &RawMesh, basis: &Basis) -> Vec<u8> {
    baked_with(mesh, basis, &[])
}

pub(crate) fn baked_with_error(
    mesh: &RawMesh,
    basis: &Basis,
    basis_error: Option<BasisError>,
) -> Vec<u8> {
    baked_from(mesh, basis, &[], basis_error)
}

/// With these settings beside the number of modes.
pub(crate) fn baked_with(mesh: &RawMesh, basis: &Basis, settings: &[(&str, &str)]) -> Vec<u8> {
    baked_from(mesh, basis, settings, None)
}

fn baked_from(
    mesh: &RawMesh,
    basis: &Basis,
    stated: &[(&str, &str)],
    error: Option<BasisError>,
) -> Vec<u8> {
    let settings = BakeSettings {
        leaf_size: Some(4),
        ..BakeSettings::default()
    };
    let stated = [&[("modes", "3")], stated].concat();
    let stated = stated
        .into_iter()
        .map(|(name, value)| (name.to_string(), value.to_string()));
    let provenance = Provenance {
        error,
        settings: stated.collect(),
        warnings: vec!["odd".to_string()],
        ..Provenance::default()
    };
    let baked = bake_fields(mesh, basis, &settings, &provenance, &Silent);
    baked.expect("a sound mesh").bytes
}

/// A dented ball away from zero, in two groups, with one vertex that no triangle uses.
pub(crate) fn ball_mesh() -> RawMesh {
    const RINGS: u32 = 9;
    const SEGMENTS: u32 = 14;
    let center = [10.0, -2.5, 0.25];
    let mut positions = Vec::new();
    for ring in 0..=RINGS {
        let theta = std::f64::consts::PI * f64::from(ring) / f64::from(RINGS);
        for segment in 0..SEGMENTS {
            let phi = std::f64::consts::TAU * f64::from(segment) / f64::from(SEGMENTS);
            let radius = 1.0 + 0.15 * (3.0 * phi).sin() * theta.sin();
            positions.push([
                center[0] + radius * theta.sin() * phi.cos(),
                center[1] + radius * theta.sin() * phi.sin(),
                center[2] + radius * theta.cos(),
            ]);
        }
    }
    positions.push([9.0, -2.0, 3.0]);
    let mut triangles = Vec::new();
    for ring in 0..RINGS {
        for segment in 0..SEGMENTS {
            let next = (segment + 1) % SEGMENTS;
            let [a, b] = [ring, ring + 1].map(|r| [r * SEGMENTS + segment, r * SEGMENTS + next]);
            triangles.push([a[0], b[0], b[1]]);
            triangles.push([a[0], b[1], a[1]]);
        }
    }
    let half = triangles.len() as u32 / 2;
    let group = |kind, name: &str, first_triangle, triangle_count| RawGroup {
        kind,
        name: name.to_string(),
        first_triangle,
        triangle_count,
    };
    RawMesh {
        name: "ball.obj".to_string(),
        hash: [0xab; 32],
        positions,
        groups: vec![
            group(GroupKind::Object, "ball", 0, 2 * half),
            group(GroupKind::Group, "top", 0, half),
            group(GroupKind::Material, "shiny", 0, half),
            group(GroupKind::Group, "bottom half", half, half),
        ],
        triangles,
        warnings: Vec::new(),
    }
}

/// A stretch, a twist and a wave; the first with frequency and mass.
pub(crate) fn basis(mesh: &RawMesh) -> Basis {
    let fields: [fn([f64; 3]) -> [f64; 3]; 3] = [
        |[x, _, _]| [0.3 * (x - 10.0), 0.0, 0.0],
        |[x, y, z]| [-(y + 2.5) * z * 0.4, (x - 10.0) * z * 0.4, 0.0],
        |[x, _, _]| [0.0, 0.0, 0.2 * (5.0 * x).sin()],
    ];
    let mode = |name: Option<&str>, omega_rad_s, modal_mass_kg| BasisMode {
        name: name.map(str::to_string),
        omega_rad_s,
        modal_mass_kg,
        momentum: None,
        q_range: Some(2.0),
        default_q: None,
    };
    Basis {
        vertex_count: mesh.positions.len(),
        fields: fields
            .iter()
            .flat_map(|field| mesh.positions.iter().map(|x| field(*x)))
            .collect(),
        modes: vec![
            mode(Some("stretch"), Some(12.5), Some(3.25)),
            mode(None, None, None),
            mode(Some("wave"), None, None),
        ],
        animation: None,
    }
}

/// q of [`animated`]'s frames.
pub(crate) const FRAME_Q: [[f64; 3]; 3] = [[0.0; 3], [0.5, -0.25, 1.0], [-1.5, 0.75, 0.125]];

/// [`basis`] in three frames: at rest, turned about x, turned about all axes and moved.
pub(crate) fn animated(mesh: &RawMesh) -> Basis {
    let motion = |rotation, translation| RigidMotion {
        rotation,
        translation,
    };
    let mut basis = basis(mesh);
    basis.modes[2].default_q = Some(0.75);
    basis.animation = Some(Animation {
        frame_count: 3,
        times_s: Some(vec![0.5, 0.75, 2.5]),
        q: FRAME_Q.as_flattened().to_vec(),
        motions: vec![
            RigidMotion::IDENTITY,
            motion([0.6, 0.0, 0.0, 0.8], [0.0; 3]),
            motion([0.5, -0.5, 0.5, 0.5], [3.0, -1.0, 0.25]),
        ],
    });
    basis
}

/// The box around the corners of all triangles.
pub(crate) fn bounds(mesh: &RawMesh) -> [[f64; 3]; 2] {
    let corners = mesh.triangles.iter().flatten();
    let positions = corners.map(|&corner| mesh.positions[corner as usize]);
    positions.fold(
        [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]],
        |[low, high], p| {
            let pick = |q: [f64; 3], by: fn(f64, f64) -> f64| [0, 1, 2].map(|k| by(q[k], p[k]));
            [pick(low, f64::min), pick(high, f64::max)]
        },
    )
}

/// A fixture's morph targets, if it has some, and its skin.
pub(crate) fn character(name: &str) -> Vec<u8> {
    let motion = Motion::MorphsElseSkin(Default::default(), Default::default());
    baked_surface(models::path(name), motion)
}

pub(crate) fn baked_surface(path: PathBuf, motion: Motion) -> Vec<u8> {
    let recipe = Recipe::of_surface(path, motion);
    bdtree_build::bake(&recipe, &Silent).expect("bakes").bytes
}
