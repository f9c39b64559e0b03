//! Nodes of the skeleton as stored, and where they stand at rest.

use bdtree_format::{NO_PARENT, SkeletonNode, local_kind};
use bdtree_runtime::math::rotation_matrix;

use super::names::Names;
use crate::error::{BakeError, Part};
use crate::input::{Local, RawSkin, Rows};
use crate::wrap::round::round_nearest;

/// The nodes of a skin.
///
/// # Errors
/// A placement that f32 cannot hold.
pub(super) fn store(skin: &RawSkin, names: &mut Names) -> Result<Vec<SkeletonNode>, BakeError> {
    let mut nodes = Vec::with_capacity(skin.skeleton.len());
    for node in &skin.skeleton {
        let [name_start, name_bytes] = names.add(&node.name)?;
        let (kind, local) = match node.local {
            Local::Parts {
                translation: [x, y, z],
                rotation: [a, b, c, d],
                scale: [u, v, w],
            } => (local_kind::PARTS, [x, y, z, a, b, c, d, u, v, w, 0.0, 0.0]),
            Local::Matrix([[a, b, c, d], [e, f, g, h], [i, j, k, l]]) => {
                (local_kind::MATRIX, [a, b, c, d, e, f, g, h, i, j, k, l])
            }
        };
        let local = local.map(round_nearest);
        if !local.iter().all(|x| x.is_finite()) {
            let message = "its placement is not finite or too large for f32";
            let place = Part::JsonPath(format!("node {:?} of the skeleton", node.name));
            return Err(BakeError::one("skin", place, message));
        }
        nodes.push(SkeletonNode {
            parent: node.parent.unwrap_or(NO_PARENT),
            name_start,
            name_bytes,
            kind,
            local,
        });
    }
    Ok(nodes)
}

/// From the space of each node to the model's at rest, in f64 from what is stored.
pub(super) fn rest(nodes: &[SkeletonNode]) -> Vec<Rows> {
    let mut rest: Vec<Rows> = Vec::with_capacity(nodes.len());
    for node in nodes {
        let local = local_rows(node);
        rest.push(match rest.get(node.parent as usize) {
            Some(parent) => product(parent, &local),
            None => local,
        });
    }
    rest
}

/// From a node's space to its parent's.
fn local_rows(node: &SkeletonNode) -> Rows {
    let x = node.local.map(f64::from);
    if node.kind == local_kind::MATRIX {
        return [
            [x[0], x[1], x[2], x[3]],
            [x[4], x[5], x[6], x[7]],
            [x[8], x[9], x[10], x[11]],
        ];
    }
    let q = [x[3], x[4], x[5], x[6]];
    let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    let turn = rotation_matrix(q.map(|x| x / length));
    std::array::from_fn(|i| {
        [
            turn[i][0] * x[7],
            turn[i][1] * x[8],
            turn[i][2] * x[9],
            x[i],
        ]
    })
}

/// First `b`, then `a`.
pub(super) fn product(a: &Rows, b: &Rows) -> Rows {
    a.map(|[x, y, z, t]| {
        let [r, s, u] = b;
        let sum = |k: usize| x * r[k] + y * s[k] + z * u[k];
        [sum(0), sum(1), sum(2), sum(3) + t]
    })
}
