//! Skins as NumPy arrays beside a mesh of any format: weights, joints, inverse bind matrices.

use std::path::{Path, PathBuf};

use bdtree_format::{BONE_COUNT_MAX, INFLUENCES_MAX};
use bdtree_npy::{NpyArray, NpyError};

use super::read_file::read_file;
use super::{Local, RawBone, RawInfluences, RawSkeletonNode, RawSkin, Rows};
use crate::error::{BakeError, Part, Place};

/// Last rows of matrices that are off by more are none of an affine map.
const LAST_ROW_TOLERANCE: f64 = 1e-5;

/// Where the arrays of a skin lie.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SkinArrays {
    /// (N, I): the weights of each vertex, not negative.
    pub weights: PathBuf,
    /// (N, I) whole numbers: the joint of each weight.
    pub joints: PathBuf,
    /// (B, 4, 4) or (B, 3, 4): from the mesh's coordinates to each joint's space.
    pub inverse_bind: PathBuf,
}

impl SkinArrays {
    /// The files.
    pub fn files(&self) -> [&Path; 3] {
        [&self.weights, &self.joints, &self.inverse_bind]
    }

    /// The skin of a mesh of `vertex_count` vertices. Joints are called `joint 0` and so on, hang from nothing and rest
    /// where they are bound. The joint of a weight of 0 does not matter.
    ///
    /// # Errors
    /// Files that cannot be read, shapes that do not fit, numbers that are none: the first of each kind.
    pub fn read(&self, vertex_count: usize) -> Result<RawSkin, BakeError> {
        let matrices = matrices(&self.inverse_bind)?;
        let weights = parsed(&self.weights, bdtree_npy::parse)?;
        let joints = parsed(&self.joints, bdtree_npy::parse_integers)?;
        let influences = influences(self, &weights, &joints, vertex_count, matrices.len())?;
        let mut skin = RawSkin {
            influences,
            ..RawSkin::default()
        };
        for (j, (inverse_bind, rest)) in (0..).zip(matrices) {
            skin.bones.push(RawBone {
                joint: j,
                inverse_bind,
            });
            skin.joints.push(j);
            skin.skeleton.push(RawSkeletonNode {
                name: format!("joint {j}"),
                parent: None,
                local: Local::Matrix(rest),
            });
        }
        Ok(skin)
    }
}

/// The array of a file of this stage.
fn parsed<T>(
    path: &Path,
    parse: fn(&[u8]) -> Result<NpyArray<T>, NpyError>,
) -> Result<NpyArray<T>, BakeError> {
    let fail = |message: String| BakeError::one("input", path, message);
    let bytes = read_file(path).map_err(|e| fail(format!("cannot be read: {e}")))?;
    parse(&bytes).map_err(|e| fail(e.to_string()))
}

/// Each inverse bind matrix with what undoes it.
fn matrices(path: &Path) -> Result<Vec<(Rows, Rows)>, BakeError> {
    let array = parsed(path, bdtree_npy::parse)?;
    let fail = |message: String| Err(BakeError::one("input", path, message));
    let (count, rows) = match array.shape[..] {
        [count, rows @ (3 | 4), 4] => (count, rows),
        _ => {
            let shape = &array.shape;
            return fail(format!("shape {shape:?}: needs (B, 4, 4) or (B, 3, 4)"));
        }
    };
    if !(1..=BONE_COUNT_MAX).contains(&count) {
        return fail(format!(
            "{count} matrices: a skin has 1 to {BONE_COUNT_MAX}"
        ));
    }
    let mut out = Vec::with_capacity(count);
    for b in 0..count {
        let at = |i: usize, k: usize| array.get(&[b, i, k]).unwrap_or(f64::NAN);
        let fail = |message: &str| {
            let place = Place::from(path).at(Part::Entry(b));
            Err(BakeError::one("input", place, message))
        };
        let matrix: Rows = std::array::from_fn(|i| std::array::from_fn(|k| at(i, k)));
        if !matrix.as_flattened().iter().all(|x| x.is_finite()) {
            return fail("the matrix is not finite");
        }
        if rows == 4 {
            let last: [f64; 4] = std::array::from_fn(|k| at(3, k) - f64::from(u8::from(k == 3)));
            if !last.iter().all(|x| x.abs() <= LAST_ROW_TOLERANCE) {
                return fail("the last row is not 0, 0, 0, 1");
            }
        }
        match super::gltf::inverse(&matrix) {
            Some(rest) => out.push((matrix, rest)),
            None => return fail("the matrix has no inverse, which is where the joint rests"),
        }
    }
    Ok(out)
}

/// The bones of the vertices.
fn influences(
    arrays: &SkinArrays,
    weights: &NpyArray<f64>,
    joints: &NpyArray<i64>,
    vertex_count: usize,
    bone_count: usize,
) -> Result<RawInfluences, BakeError> {
    for (path, shape) in [
        (&arrays.weights, &weights.shape),
        (&arrays.joints, &joints.shape),
    ] {
        if shape.len() != 2 || shape[0] != vertex_count || *shape != weights.shape {
            let message = match (shape[..].len(), shape.first()) {
                (2, Some(&rows)) if rows == vertex_count => format!(
                    "shape {shape:?}, but that of the weights is {:?}: one joint for each weight",
                    weights.shape
                ),
                _ => format!("shape {shape:?} is not (N, I) with N = {vertex_count} vertices"),
            };
            return Err(BakeError::one("input", path.as_path(), message));
        }
    }
    let width = weights.shape.get(1).copied().unwrap_or(0);
    let mut out = RawInfluences {
        file: Some(arrays.weights.display().to_string()),
        ..RawInfluences::default()
    };
    out.starts.push(0);
    let mut own: Vec<(u16, f64)> = Vec::new();
    for vertex in 0..vertex_count {
        let fail = |path: &Path, message: String| {
            let place = Place::from(path).at(Part::Vertex(vertex));
            Err(BakeError::one("input", place, message))
        };
        own.clear();
        for k in 0..width {
            let weight = weights.get(&[vertex, k]).unwrap_or(f64::NAN);
            if !(weight >= 0.0 && weight.is_finite()) {
                let message = format!("weight {k} is {weight}, not a number of at least 0");
                return fail(&arrays.weights, message);
            }
            if weight == 0.0 {
                continue;
            }
            let joint = joints.get(&[vertex, k]).unwrap_or(-1);
            match u16::try_from(joint)
                .ok()
                .filter(|&joint| usize::from(joint) < bone_count)
            {
                Some(joint) => own.push((joint, weight)),
                None => {
                    let message =
                        format!("joint {k} is {joint}, but there are {bone_count} matrices");
                    return fail(&arrays.joints, message);
                }
            }
        }
        super::gltf::add_equal(&mut own);
        if own.len() > INFLUENCES_MAX {
            let message = format!(
                "{} joints; at most {INFLUENCES_MAX} move a vertex",
                own.len()
            );
            return fail(&arrays.joints, message);
        }
        out.list.extend_from_slice(&own);
        let Ok(end) = u32::try_from(out.list.len()) else {
            return fail(
                &arrays.weights,
                "more weights than 32 bits count".to_string(),
            );
        };
        out.starts.push(end);
    }
    Ok(out)
}
