//! Our OBJ reader against tobj, on every mesh that tobj takes.
//!
//! tobj renumbers vertices by first use, so triangles are compared by their corners' positions, in
//! file order. It reads f32: positions may differ by one rounding.

use std::io::{Cursor, Read};
use std::path::Path;

use bdtree_build::input::{RawMesh, read_mesh};
use bdtree_fixtures::{corpus, models};

/// Files that tobj reads in another way, on purpose or not: points and lines among faces (it gives
/// the faces twice), lone CR as line ends (it finds one comment), a weight w (it divides by it; we
/// leave it to curves, as the format does).
const TOBJ_DIFFERS: [&str; 3] = [
    "/testmixed.obj",
    "/spot_cr_only.obj",
    "/cube-vertex-w-component.obj",
];

type Corners = [[f32; 3]; 3];

/// tobj's triangles in file order; `None` if it refuses the text.
fn oracle(text: &[u8]) -> Option<Vec<Corners>> {
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..Default::default()
    };
    let no_material = |_: &Path| tobj::load_mtl_buf(&mut Cursor::new(b""));
    let (models, _) = tobj::load_obj_buf(&mut Cursor::new(text), &options, no_material).ok()?;
    let mut triangles = Vec::new();
    for model in models {
        let mesh = model.mesh;
        let at = |i: u32| [0, 1, 2].map(|k| mesh.positions[3 * i as usize + k]);
        triangles.extend(
            mesh.indices
                .chunks_exact(3)
                .map(|t| [at(t[0]), at(t[1]), at(t[2])]),
        );
    }
    Some(triangles)
}

fn close(a: f32, b: f64) -> bool {
    (f64::from(a) - b).abs()
        <= 2.0 * f64::from(f32::EPSILON) * b.abs().max(f64::from(f32::MIN_POSITIVE))
}

fn compare(name: &str, mesh: &RawMesh, oracle: &[Corners]) {
    assert_eq!(
        mesh.triangles.len(),
        oracle.len(),
        "{name}: number of triangles"
    );
    for (id, (t, wanted)) in mesh.triangles.iter().zip(oracle).enumerate() {
        for (corner, w) in t.iter().zip(wanted) {
            let p = mesh.positions[*corner as usize];
            let same = (0..3).all(|k| close(w[k], p[k]));
            assert!(same, "{name}: triangle {id}: {p:?} is not {w:?}");
        }
    }
}

fn text(path: &Path) -> Vec<u8> {
    let bytes = std::fs::read(path).expect("the file is there");
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        return bytes;
    }
    let mut text = Vec::new();
    let mut gz = flate2::read::MultiGzDecoder::new(&bytes[..]);
    gz.read_to_end(&mut text).expect("the file is sound gzip");
    text
}

fn check(path: &Path) -> bool {
    let name = path.display().to_string();
    let Ok(mesh) = read_mesh(path) else {
        return false;
    };
    match oracle(&text(path)) {
        Some(triangles) => {
            compare(&name, &mesh, &triangles);
            true
        }
        None => {
            println!("{name}: tobj refuses it");
            false
        }
    }
}

#[test]
fn fixtures_agree() {
    let mut count = 0;
    for fixture in models::meshes().filter(|f| !f.is_broken) {
        let path = models::ensure(fixture).expect("fixtures can be written");
        count += usize::from(check(&path));
    }
    assert!(count >= 18, "only {count} compared");
}

#[test]
fn corpus_agrees() {
    let Some(root) = corpus::path("obj_corpus_agrees", "") else {
        return;
    };
    let mut count = 0;
    for folder in ["meshes", "messy"] {
        let entries = std::fs::read_dir(root.join(folder)).expect("a corpus folder can be listed");
        for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
            let name = path.display().to_string();
            if TOBJ_DIFFERS.iter().any(|other| name.ends_with(other)) {
                continue;
            }
            if name.ends_with(".obj") || name.ends_with(".obj.gz") {
                count += usize::from(check(&path));
            }
        }
    }
    println!("{count} compared");
    assert!(count >= 50, "only {count} compared");
}
