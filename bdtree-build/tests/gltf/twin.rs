//! A second, plain reading of glTF straight from its JSON, for sound files only: recursion, dense
//! arrays, quaternion products. What the builder's reader is compared with.

use std::path::Path;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::Value;

use bdtree_fixtures::models::math::V3;

/// What a glTF file holds.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Twin {
    /// World positions; of skinned meshes, their own.
    pub positions: Vec<V3>,
    /// What the joints do to each vertex at rest: the identity without a skin.
    pub carried: Vec<Matrix>,
    /// Corner indices.
    pub triangles: Vec<[u32; 3]>,
    /// Per morph target of each mesh node the world displacement of every vertex.
    pub fields: Vec<Vec<V3>>,
    /// Default weight per morph target.
    pub weights: Vec<f64>,
    /// First target of each node that has some.
    pub first_target: Vec<(usize, usize)>,
}

/// The numbers of a sampler of weights.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Sampler {
    /// The first target that it moves.
    pub first_target: usize,
    /// `LINEAR`, `STEP` or `CUBICSPLINE`.
    pub interpolation: String,
    /// Seconds of the keys.
    pub times: Vec<f64>,
    /// The accessor's numbers.
    pub values: Vec<f64>,
}

/// A sound glTF file, taken apart.
pub(crate) struct File {
    json: Value,
    buffers: Vec<Vec<u8>>,
}

/// A node's placement: columns of a 4 × 4 matrix.
pub(crate) type Matrix = [[f64; 4]; 4];

pub(crate) const IDENTITY: Matrix = [
    [1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
    [0.0, 0.0, 0.0, 1.0],
];

impl File {
    /// The file at `path`.
    ///
    /// # Panics
    /// If the file is not sound.
    pub(crate) fn open(path: &Path) -> Self {
        let bytes = std::fs::read(path).expect("a file");
        Self::new(&bytes, path.parent().expect("a folder"))
    }

    /// The file of `bytes` with its buffers in `folder`.
    ///
    /// # Panics
    /// If the file is not sound.
    pub(crate) fn new(bytes: &[u8], folder: &Path) -> Self {
        let word =
            |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("4")) as usize;
        let (json, chunk) = if bytes.starts_with(b"glTF") {
            let end = 20 + word(12);
            let chunk = bytes.get(end + 8..).map_or(Vec::new(), <[u8]>::to_vec);
            (bytes[20..end].to_vec(), chunk)
        } else {
            (bytes.to_vec(), Vec::new())
        };
        let json: Value = serde_json::from_slice(&json).expect("JSON");
        let buffers = list(&json["buffers"])
            .iter()
            .map(|buffer| match buffer["uri"].as_str() {
                None => chunk.clone(),
                Some(uri) => match uri.split_once(";base64,") {
                    Some((_, data)) => BASE64_STANDARD.decode(data).expect("base64"),
                    None => std::fs::read(folder.join(uri)).expect("a buffer"),
                },
            });
        let buffers = buffers.collect();
        Self { json, buffers }
    }

    /// The whole scene.
    pub(crate) fn scene(&self) -> Twin {
        let mut twin = Twin::default();
        let scene = &self.json["scenes"][index(&self.json["scene"])];
        let mut worlds = vec![IDENTITY; list(&self.json["nodes"]).len()];
        for node in list(&scene["nodes"]) {
            self.place(index(node), &IDENTITY, &mut worlds);
        }
        for node in list(&scene["nodes"]) {
            self.node(index(node), &worlds, &mut twin);
        }
        for field in &mut twin.fields {
            field.resize(twin.positions.len(), [0.0; 3]);
        }
        twin
    }

    /// The samplers of an animation that move weights of nodes in `twin`.
    pub(crate) fn samplers(&self, animation: usize, twin: &Twin) -> Vec<Sampler> {
        let animation = &self.json["animations"][animation];
        let moves = |channel: &&Value| channel["target"]["path"] == "weights";
        let channels = list(&animation["channels"]).iter().filter(moves);
        channels
            .filter_map(|channel| {
                let node = index(&channel["target"]["node"]);
                let sampler = &animation["samplers"][index(&channel["sampler"])];
                let flat = |key: &str| self.accessor(index(&sampler[key])).concat();
                Some(Sampler {
                    first_target: twin.first_target.iter().find(|(n, _)| *n == node)?.1,
                    interpolation: sampler["interpolation"].as_str().unwrap_or("LINEAR").into(),
                    times: flat("input"),
                    values: flat("output"),
                })
            })
            .collect()
    }

    /// The times of the first channel of an animation.
    pub(crate) fn times(&self, animation: usize) -> Vec<f64> {
        let animation = &self.json["animations"][animation];
        let sampler = index(&animation["channels"][0]["sampler"]);
        self.accessor(index(&animation["samplers"][sampler]["input"]))
            .concat()
    }

    /// Puts the nodes and the weights where an animation has them at a time (glTF 2.0, appendix C).
    pub(crate) fn play(&mut self, animation: usize, time: f64) {
        let animation = self.json["animations"][animation].clone();
        for channel in list(&animation["channels"]) {
            let sampler = &animation["samplers"][index(&channel["sampler"])];
            let times = self.accessor(index(&sampler["input"])).concat();
            let values = self.accessor(index(&sampler["output"])).concat();
            let path = channel["target"]["path"].as_str().expect("a path");
            let kind = sampler["interpolation"].as_str().unwrap_or("LINEAR");
            let value = interpolated(&times, &values, kind, path == "rotation", time);
            let node = index(&channel["target"]["node"]);
            self.json["nodes"][node][path] = value.into();
        }
    }

    /// Where a node and all below it stand in the scene.
    fn place(&self, at: usize, outer: &Matrix, worlds: &mut [Matrix]) {
        let node = &self.json["nodes"][at];
        worlds[at] = product(outer, &placement(node));
        let world = worlds[at];
        for child in list(&node["children"]) {
            self.place(index(child), &world, worlds);
        }
    }

    /// Joint matrix times inverse bind matrix of each joint of the node's skin, at rest.
    fn joints(&self, node: &Value, worlds: &[Matrix]) -> Option<Vec<Matrix>> {
        let skin = &self.json["skins"][node["skin"].as_u64()? as usize];
        let binds = skin["inverseBindMatrices"]
            .as_u64()
            .map(|accessor| self.accessor(accessor as usize));
        let bind = |j: usize| match &binds {
            Some(binds) => [0, 1, 2, 3].map(|c| [0, 1, 2, 3].map(|r| binds[j][4 * c + r])),
            None => IDENTITY,
        };
        let joints = list(&skin["joints"]).iter().enumerate();
        Some(
            joints
                .map(|(j, joint)| product(&worlds[index(joint)], &bind(j)))
                .collect(),
        )
    }

    fn node(&self, at: usize, worlds: &[Matrix], twin: &mut Twin) {
        let node = &self.json["nodes"][at];
        let joints = self.joints(node, worlds);
        // Joints say where a skinned mesh stands.
        let own = match joints {
            Some(_) => &IDENTITY,
            None => &worlds[at],
        };
        if let Some(mesh) = node["mesh"].as_u64() {
            let mesh = &self.json["meshes"][mesh as usize];
            let count = list(&mesh["primitives"][0]["targets"]).len();
            let first = twin.fields.len();
            if count > 0 {
                twin.first_target.push((at, first));
            }
            twin.fields.resize(first + count, Vec::new());
            let weights = [&node["weights"], &mesh["weights"]];
            let weights = weights.into_iter().find(|w| w.is_array());
            twin.weights
                .extend((0..count).map(|k| weights.map_or(0.0, |w| number(&w[k]))));
            for primitive in list(&mesh["primitives"]) {
                self.primitive(primitive, own, first, twin);
                let carried = match &joints {
                    Some(joints) => self.carried(primitive, joints),
                    None => Vec::new(),
                };
                twin.carried.extend(carried);
                twin.carried.resize(twin.positions.len(), IDENTITY);
            }
        }
        for child in list(&node["children"]) {
            self.node(index(child), worlds, twin);
        }
    }

    /// The joints' matrices, blended for each vertex by its weights over their sum.
    fn carried(&self, primitive: &Value, joints: &[Matrix]) -> Vec<Matrix> {
        let sets = (0..).map_while(|set| {
            let accessor = |name: &str| {
                let at = &primitive["attributes"][format!("{name}_{set}")];
                Some(self.accessor(at.as_u64()? as usize))
            };
            Some((accessor("JOINTS")?, accessor("WEIGHTS")?))
        });
        let sets: Vec<_> = sets.collect();
        let mut carried = Vec::new();
        for i in 0..sets[0].0.len() {
            let entries = sets.iter().flat_map(|(j, w)| j[i].iter().zip(&w[i]));
            let mut sum = [[0.0; 4]; 4];
            for (joint, weight) in entries {
                let joint = &joints[*joint as usize];
                for (sum, x) in sum.as_flattened_mut().iter_mut().zip(joint.as_flattened()) {
                    *sum += weight * x;
                }
            }
            // The matrices' last entries are 1.
            let whole = sum[3][3];
            carried.push(sum.map(|column| column.map(|x| x / whole)));
        }
        carried
    }

    fn primitive(&self, primitive: &Value, world: &Matrix, first: usize, twin: &mut Twin) {
        let mode = primitive["mode"].as_u64().unwrap_or(4);
        if mode < 4 {
            return;
        }
        let base = twin.positions.len() as u32;
        let vertices = self.accessor(index(&primitive["attributes"]["POSITION"]));
        twin.positions
            .extend(vertices.iter().map(|p| apply(world, p, 1.0)));
        let corners: Vec<u32> = match primitive["indices"].as_u64() {
            Some(indices) => self
                .accessor(indices as usize)
                .concat()
                .iter()
                .map(|i| *i as u32)
                .collect(),
            None => (0..vertices.len() as u32).collect(),
        };
        let corner = |i: usize| base + corners[i];
        let n = corners.len();
        // The formulas of glTF 2.0, 3.7.2.1.
        twin.triangles.extend(match mode {
            4 => (0..n / 3)
                .map(|i| [3 * i, 3 * i + 1, 3 * i + 2].map(corner))
                .collect::<Vec<_>>(),
            5 => (0..n - 2)
                .map(|i| [i, i + (1 + i % 2), i + (2 - i % 2)].map(corner))
                .collect(),
            _ => (0..n - 2).map(|i| [i + 1, i + 2, 0].map(corner)).collect(),
        });
        for (k, target) in list(&primitive["targets"]).iter().enumerate() {
            let field = &mut twin.fields[first + k];
            field.resize(base as usize, [0.0; 3]);
            if let Some(accessor) = target["POSITION"].as_u64() {
                let moves = self.accessor(accessor as usize);
                field.extend(moves.iter().map(|u| apply(world, u, 0.0)));
            }
        }
    }

    /// All elements of an accessor.
    fn accessor(&self, at: usize) -> Vec<Vec<f64>> {
        let accessor = &self.json["accessors"][at];
        let count = index(&accessor["count"]);
        let width = match accessor["type"].as_str() {
            Some("SCALAR") => 1,
            Some("VEC3") => 3,
            Some("VEC4") => 4,
            Some("MAT4") => 16,
            other => panic!("type {other:?}"),
        };
        let component = index(&accessor["componentType"]);
        let mut all = match accessor["bufferView"].is_u64() {
            true => self.elements(accessor, component, count, width),
            false => vec![vec![0.0; width]; count],
        };
        let sparse = &accessor["sparse"];
        if sparse.is_object() {
            let changed = index(&sparse["count"]);
            let kind = index(&sparse["indices"]["componentType"]);
            let places = self.elements(&sparse["indices"], kind, changed, 1);
            let values = self.elements(&sparse["values"], component, changed, width);
            for (place, value) in places.iter().zip(values) {
                all[place[0] as usize] = value;
            }
        }
        if accessor["normalized"] == true {
            let largest = [127.0, 255.0, 32767.0, 65535.0][component - 5120];
            for x in all.iter_mut().flatten() {
                *x = (*x / largest).max(-1.0);
            }
        }
        all
    }

    fn elements(
        &self,
        place: &Value,
        component: usize,
        count: usize,
        width: usize,
    ) -> Vec<Vec<f64>> {
        let view = &self.json["bufferViews"][index(&place["bufferView"])];
        let size = [1, 1, 2, 2, 0, 4, 4][component - 5120];
        let start = index(&view["byteOffset"]) + index(&place["byteOffset"]);
        let stride = view["byteStride"]
            .as_u64()
            .map_or(size * width, |s| s as usize);
        let bytes = &self.buffers[index(&view["buffer"])][start..];
        let read = |i: usize, k: usize| {
            let at = &bytes[i * stride + k * size..][..size];
            let word = at
                .iter()
                .rev()
                .fold(0_u32, |word, b| word << 8 | u32::from(*b));
            match component {
                5120 => f64::from(word as u8 as i8),
                5122 => f64::from(word as u16 as i16),
                5126 => f64::from(f32::from_bits(word)),
                _ => f64::from(word),
            }
        };
        (0..count)
            .map(|i| (0..width).map(|k| read(i, k)).collect())
            .collect()
    }
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

/// An index; 0 where there is none.
fn index(value: &Value) -> usize {
    value.as_u64().unwrap_or(0) as usize
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// The value of a sampler at a time.
fn interpolated(times: &[f64], values: &[f64], kind: &str, turns: bool, time: f64) -> Vec<f64> {
    let cubic = kind == "CUBICSPLINE";
    let width = values.len() / times.len();
    let key = |k: usize| &values[k * width..(k + 1) * width];
    // Of a spline: the tangent before, the value, the tangent after.
    let part = |k: usize, which: usize| match cubic {
        true => &key(k)[which * width / 3..(which + 1) * width / 3],
        false => key(k),
    };
    let after = times.partition_point(|t| *t <= time);
    if after == 0 || after == times.len() || kind == "STEP" {
        return part(after.saturating_sub(1), 1).to_vec();
    }
    let (k, l) = (after - 1, after);
    let span = times[l] - times[k];
    let s = (time - times[k]) / span;
    let (a, b) = (part(k, 1), part(l, 1));
    let mixed =
        |x: f64, y: f64| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| x * a + y * b).collect() };
    if cubic {
        let (out, into) = (part(k, 2), part(l, 0));
        let (s2, s3) = (s * s, s * s * s);
        let mut value = mixed(2.0 * s3 - 3.0 * s2 + 1.0, 3.0 * s2 - 2.0 * s3);
        for (i, x) in value.iter_mut().enumerate() {
            *x += span * ((s3 - 2.0 * s2 + s) * out[i] + (s3 - s2) * into[i]);
        }
        return value; // `placement` divides by the length
    }
    if turns {
        let cosine: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
        let angle = cosine.abs().min(1.0).acos();
        if angle > 1e-6 {
            let [x, y] = [1.0 - s, s].map(|s| (s * angle).sin() / angle.sin());
            return mixed(x, y * cosine.signum());
        }
        return mixed(1.0 - s, s * cosine.signum());
    }
    mixed(1.0 - s, s)
}

/// Columns of a node's matrix.
pub(crate) fn placement(node: &Value) -> Matrix {
    if node["matrix"].is_array() {
        return [0, 1, 2, 3].map(|c| [0, 1, 2, 3].map(|r| number(&node["matrix"][4 * c + r])));
    }
    let part = |key: &str, k: usize, default: f64| node[key][k].as_f64().unwrap_or(default);
    let mut columns = [[0.0; 4]; 4];
    for axis in 0..3 {
        // q e q⁻¹ by two products of quaternions.
        let q: [f64; 4] = [0, 1, 2, 3].map(|k| part("rotation", k, [0.0, 0.0, 0.0, 1.0][k]));
        let length2: f64 = q.iter().map(|x| x * x).sum();
        let mut unit = [0.0; 4];
        unit[axis] = part("scale", axis, 1.0) / length2;
        let conjugate = [-q[0], -q[1], -q[2], q[3]];
        columns[axis] = quaternion_product(quaternion_product(q, unit), conjugate);
        columns[axis][3] = 0.0;
    }
    columns[3] = [
        part("translation", 0, 0.0),
        part("translation", 1, 0.0),
        part("translation", 2, 0.0),
        1.0,
    ];
    columns
}

fn quaternion_product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [
        a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1],
        a[3] * b[1] + a[1] * b[3] + a[2] * b[0] - a[0] * b[2],
        a[3] * b[2] + a[2] * b[3] + a[0] * b[1] - a[1] * b[0],
        a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2],
    ]
}

pub(crate) fn product(a: &Matrix, b: &Matrix) -> Matrix {
    b.map(|column| [0, 1, 2, 3].map(|row| (0..4).map(|k| a[k][row] * column[k]).sum()))
}

/// The matrix times (v, w), without its last entry.
pub(crate) fn apply(matrix: &Matrix, v: &[f64], w: f64) -> V3 {
    let v = [v[0], v[1], v[2], w];
    [0, 1, 2].map(|row| (0..4).map(|k| matrix[k][row] * v[k]).sum())
}
