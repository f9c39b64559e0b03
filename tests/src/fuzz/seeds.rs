//! The files that mutations begin with: small fixtures, volumes of the generator, and, where there
//! is one, small files of the corpus.

use std::fs;
use std::path::Path;

use super::{Format, scenes};
use bdtree_build::input::{RawMesh, read_mesh};
use bdtree_fixtures::models::gltf::unpack;
use bdtree_fixtures::models::volume::{self, Volume, hex_block, tet_block};
use bdtree_fixtures::models::{self, fields};
use bdtree_fixtures::{corpus, poses};
use rand::RngExt;

/// Larger files are mutated too slowly.
const SIZE_MAX: usize = 24 << 10;

/// Vertices of the mesh that fields and point caches are for: `wave/wave_00.obj`.
pub(super) const WAVE_VERTICES: usize = 54;

/// Fields in the seeds of [`Format::Basis`].
pub(super) const FIELDS: usize = 4;

/// Seed files per format.
#[derive(Debug)]
pub struct Seeds(Vec<Vec<Vec<u8>>>);

impl Seeds {
    /// Those that are the same everywhere.
    ///
    /// # Panics
    /// When a fixture cannot be read.
    pub fn fixtures() -> Self {
        Self(Format::ALL.map(of_fixtures).into())
    }

    /// Those, and the small files of the corpus in [`corpus::path`]. `None` without one.
    ///
    /// # Panics
    /// When a file cannot be read.
    pub fn with_corpus(user: &str) -> Option<Self> {
        let mut seeds = Self::fixtures();
        for folder in ["messy", "modal"] {
            add_folder(&mut seeds, &corpus::path(user, folder)?);
        }
        Some(seeds)
    }

    /// The seeds of a format: at least one.
    pub(super) fn of(&self, format: Format) -> &[Vec<u8>] {
        &self.0[format as usize]
    }

    /// How many there are.
    pub fn count(&self, format: Format) -> usize {
        self.of(format).len()
    }
}

fn add_folder(seeds: &mut Seeds, folder: &Path) {
    let entries = fs::read_dir(folder).expect("folder");
    let mut paths: Vec<_> = entries.map(|e| e.expect("entry").path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            add_folder(seeds, &path);
            continue;
        }
        let bytes = fs::read(&path).expect("file");
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        let formats: &[Format] = match &*extension {
            "obj" => &[Format::Obj, Format::ObjGz, Format::Frames],
            // GLB files are taken apart: only sound ones can be.
            "gltf" => &[Format::Gltf],
            "veg" => &[Format::Veg],
            "vtk" => &[Format::Vtk],
            "msh" => &[Format::Msh],
            _ => &[],
        };
        if bytes.len() <= SIZE_MAX {
            for format in formats {
                seeds.0[*format as usize].push(bytes.clone());
            }
        }
    }
}

fn of_fixtures(format: Format) -> Vec<Vec<u8>> {
    // Broken ones among OBJ files only: changed once more, binary ones are refused at once.
    let with = |extension: &str| -> Vec<Vec<u8>> {
        let small = models::all().iter().filter(|f| !f.is_large);
        small
            .filter(|f| !f.is_broken || extension == "obj")
            .map(models::place)
            .filter(|path| path.extension().is_some_and(|e| e == extension))
            .map(|path| fs::read(path).expect("fixture"))
            .filter(|bytes| !bytes.is_empty() && bytes.len() <= SIZE_MAX)
            .collect()
    };
    match format {
        Format::Obj | Format::ObjGz => with("obj"),
        Format::Frames => wave_frames(),
        Format::Glb => with("glb"),
        Format::Gltf => {
            let mut all = with("gltf");
            all.extend(with("glb").iter().map(|bytes| as_text(bytes)));
            all
        }
        Format::Pc2 => with("pc2"),
        Format::Mdd => with("mdd"),
        Format::Npy => with("npy"),
        Format::Basis => bases(),
        Format::Frequencies => vec![
            b"1 2.5\n3, 4\n".to_vec(),
            b"0; 1e3 # Hz\n7\t9\r\n".to_vec(),
            fields::npy(&[FIELDS], [1.0, 2.0, 3.0, 4.0]),
        ],
        Format::List => vec![b"1, 2, 3,\n4\n".to_vec(), b"# a list\n2 5\n\n1\n".to_vec()],
        Format::Veg => volumes(".veg", with("veg")),
        Format::Vtk => volumes(".vtk", with("vtk")),
        Format::Msh => volumes(".msh", with("msh")),
        Format::Scene => scenes::seeds(),
        Format::Ply => vec![ply(false), ply(true)],
        Format::Stl => vec![stl(false), stl(true)],
    }
}

/// A small mesh as PLY, as text or binary.
fn ply(is_binary: bool) -> Vec<u8> {
    let mesh = small_mesh();
    let encoding = if is_binary {
        "binary_little_endian"
    } else {
        "ascii"
    };
    let mut bytes = format!(
        "ply\nformat {encoding} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.triangles.len()
    )
    .into_bytes();
    for p in &mesh.positions {
        match is_binary {
            true => bytes.extend(p.iter().flat_map(|x| (*x as f32).to_le_bytes())),
            false => bytes.extend(format!("{} {} {}\n", p[0], p[1], p[2]).bytes()),
        }
    }
    for t in &mesh.triangles {
        match is_binary {
            true => {
                bytes.push(3);
                bytes.extend(t.iter().flat_map(|corner| corner.to_le_bytes()));
            }
            false => bytes.extend(format!("3 {} {} {}\n", t[0], t[1], t[2]).bytes()),
        }
    }
    bytes
}

/// A small mesh as STL, as text or binary.
fn stl(is_binary: bool) -> Vec<u8> {
    let mesh = small_mesh();
    let corners = |t: &[u32; 3]| t.map(|corner| mesh.positions[corner as usize]);
    if !is_binary {
        let mut text = "solid wave\n".to_string();
        for t in &mesh.triangles {
            text += "facet normal 0 0 1\nouter loop\n";
            for [x, y, z] in corners(t) {
                text += &format!("vertex {x} {y} {z}\n");
            }
            text += "endloop\nendfacet\n";
        }
        return (text + "endsolid wave\n").into_bytes();
    }
    let mut bytes = vec![0; 80];
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for t in &mesh.triangles {
        bytes.extend([0; 12]);
        let corners = corners(t);
        let numbers = corners.as_flattened().iter();
        bytes.extend(numbers.flat_map(|x| (*x as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn small_mesh() -> RawMesh {
    read_mesh(&models::folder().join("cube.obj")).expect("a fixture")
}

/// A GLB file as text, its buffer inside.
fn as_text(glb: &[u8]) -> Vec<u8> {
    let (mut document, binary) = unpack(glb);
    let data: String = binary.iter().map(|byte| format!("%{byte:02x}")).collect();
    document["buffers"][0]["uri"] = format!("data:application/octet-stream,{data}").into();
    document.to_string().into_bytes()
}

/// The frames of the waving sheet.
fn wave_frames() -> Vec<Vec<u8>> {
    let path = |k| models::folder().join(format!("wave/wave_{k:02}.obj"));
    (0..6).map(|k| fs::read(path(k)).expect("frame")).collect()
}

/// Fields for the waving sheet in all layouts.
fn bases() -> Vec<Vec<u8>> {
    const N: usize = WAVE_VERTICES;
    let mut rng = poses::rng(1);
    let values: Vec<f64> = (0..3 * N * FIELDS)
        .map(|_| rng.random_range(-1.0..1.0))
        .collect();
    let single = values.iter().flat_map(|x| (*x as f32).to_be_bytes());
    vec![
        fields::npy(&[N, 3, FIELDS], values.clone()),
        fields::npy(&[3 * N, FIELDS], values.clone()),
        fields::npy(&[FIELDS, N, 3], values.clone()),
        fields::npy_with(">f4", true, &format!("{N}, 3, {FIELDS}"), single),
    ]
}

/// Volumes small enough for their modes to be computed often, and the fixtures.
fn volumes(extension: &str, mut seeds: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
    let tets = Volume::of_tetrahedra(tet_block(2, 1, 1, [1.0, 0.5, 0.5])).rounded();
    let hexes = Volume::of_hexahedra(hex_block(2, 1, 1, [1.0, 0.5, 0.5])).rounded();
    for format in volume::Format::ALL {
        if format.extension() == extension {
            seeds.extend([tets.to_file(format), hexes.to_file(format)]);
        }
    }
    seeds
}
