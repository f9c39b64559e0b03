//! The corpus's exact lists of intersecting triangle pairs (`collisions/pairs`).

use std::collections::HashSet;
use std::io::Read;
use std::path::{Path, PathBuf};

use bdtree_runtime::narrow::Triangle;
use serde_json::Value;

/// One case: two placed, perhaps deformed meshes.
#[derive(Debug, Clone)]
pub(crate) struct Case {
    folder: PathBuf,
    value: Value,
}

/// One side of a case as the corpus gives it.
#[derive(Debug, Clone)]
pub(crate) struct Side {
    /// The mesh, relative to the corpus.
    pub mesh: String,
    /// q and the fields, field after field, x y z per vertex; empty when it is not deformed.
    pub q: Vec<f64>,
    /// 3N numbers per field.
    pub fields: Vec<Vec<f32>>,
    /// Row-major 4 × 4, column vectors.
    pub matrix: Vec<f64>,
}

/// All cases of the corpus at `folder`.
///
/// # Panics
/// When the corpus is damaged.
pub(crate) fn cases(folder: &Path) -> Vec<Case> {
    let text = read(&folder.join("collisions/pairs/cases.json"));
    let list: Vec<Value> = serde_json::from_slice(&text).expect("JSON");
    list.into_iter()
        .map(|value| Case {
            folder: folder.to_path_buf(),
            value,
        })
        .collect()
}

impl Case {
    /// Its name.
    pub(crate) fn id(&self) -> &str {
        self.value["id"].as_str().unwrap_or_default()
    }

    /// Side `a` or `b`.
    ///
    /// # Panics
    /// When the corpus is damaged.
    pub(crate) fn side(&self, name: &str) -> Side {
        let side = &self.value[name];
        let mut fields = Vec::new();
        let mut q = Vec::new();
        if let Some(modes) = side["modes"].as_str() {
            q = numbers(&side["q"]);
            let bytes = read(&self.folder.join(modes));
            let words: Vec<[u8; 4]> = bytes.as_chunks().0.to_vec();
            let rows = i32::from_le_bytes(words[0]) as usize;
            fields = words[2..]
                .chunks_exact(rows)
                .map(|c| c.iter().map(|w| f32::from_le_bytes(*w)).collect())
                .collect();
            fields.truncate(q.len());
        }
        Side {
            mesh: side["mesh"].as_str().expect("mesh").to_string(),
            q,
            fields,
            matrix: numbers(&side["matrix_row_major"]),
        }
    }

    /// The triangles of a side in f64, placed as the corpus' README says.
    ///
    /// # Panics
    /// When the corpus is damaged.
    pub(crate) fn triangles(&self, name: &str) -> Vec<Triangle> {
        let side = self.side(name);
        let (mut points, faces) = obj(&self.folder.join(&side.mesh));
        let mut offsets = vec![0.0; 3 * points.len()];
        for (field, q) in side.fields.iter().zip(&side.q) {
            for (x, u) in offsets.iter_mut().zip(field) {
                *x += q * f64::from(*u);
            }
        }
        let m = &side.matrix;
        for (p, d) in points.iter_mut().zip(offsets.chunks_exact(3)) {
            *p = [p[0] + d[0], p[1] + d[1], p[2] + d[2]];
            *p = [0, 4, 8].map(|r| p[0] * m[r] + p[1] * m[r + 1] + p[2] * m[r + 2] + m[r + 3]);
        }
        let triangles: Vec<Triangle> = faces.iter().map(|f| f.map(|i| points[i])).collect();
        let counted = self.value[format!("triangles_{name}")].as_u64();
        assert_eq!(counted, Some(triangles.len() as u64));
        triangles
    }

    /// The pairs that share a point, decided exactly.
    ///
    /// # Panics
    /// When the corpus is damaged.
    pub(crate) fn listed(&self) -> HashSet<(u32, u32)> {
        let Some(file) = self.value["pairs_file"].as_str() else {
            return HashSet::new();
        };
        let text = read(&self.folder.join("collisions").join(file));
        String::from_utf8_lossy(&text)
            .lines()
            .map(|line| {
                let mut pair = line.split_whitespace().map(|w| w.parse().expect("index"));
                (pair.next().expect("a"), pair.next().expect("b"))
            })
            .collect()
    }
}

/// A file's bytes, unpacked where its name ends in `.gz`.
fn read(path: &Path) -> Vec<u8> {
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    if path.extension().is_none_or(|e| e != "gz") {
        return bytes;
    }
    let mut out = Vec::new();
    flate2::read::MultiGzDecoder::new(&bytes[..])
        .read_to_end(&mut out)
        .expect("gzip");
    out
}

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().expect("a list");
    list.iter().map(|x| x.as_f64().expect("a number")).collect()
}

/// Points and fan triangles of an OBJ file, read without the product's reader.
fn obj(path: &Path) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let text = read(path);
    let text = String::from_utf8_lossy(&text).replace("\\\n", " ");
    let mut points: Vec<[f64; 3]> = Vec::new();
    let mut faces: Vec<[usize; 3]> = Vec::new();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let mut next = || words.next().and_then(|w| w.parse().ok()).expect("number");
                points.push([next(), next(), next()]);
            }
            Some("f") => {
                let corner = |w: &str| {
                    let i: i64 = w.split('/').next().expect("index").parse().expect("index");
                    let count = points.len() as i64;
                    (if i > 0 { i - 1 } else { count + i }) as usize
                };
                let face: Vec<usize> = words.map(corner).collect();
                faces.extend(face[1..].windows(2).map(|w| [face[0], w[0], w[1]]));
            }
            _ => {}
        }
    }
    (points, faces)
}
