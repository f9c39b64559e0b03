//! Morph targets as fields: q is the weight.

use bdtree_format::MODE_COUNT_MAX;

use super::dropped::{Keep, Kept, keep_fields};
use super::{Animation, Basis, BasisError, BasisMode};
use crate::error::{BakeError, Place};
use crate::input::{RawMesh, RawMorphs, RawTarget};

/// A basis of morph targets.
#[derive(Debug, Clone, PartialEq)]
pub struct MorphBasis {
    /// One field per target that is kept, with the clip's weights as its animation.
    pub basis: Basis,
    /// The number of each field's target, ascending.
    pub targets: Vec<usize>,
    /// The weight that the source gives each field where nothing is animated.
    pub default_weights: Vec<f64>,
    /// How far it is from all targets ([`Kept::error`]).
    pub error: BasisError,
}

/// The fields of `morphs`, those that `keep` says: p' = p + Σ weight × displacement.
///
/// The range of a weight is the largest of 1, |default| and its values over the clip, or over those of a skin. Targets that
/// move nothing are kept with a warning (by `Auto` they are dropped).
///
/// # Errors
/// See [`keep_fields`]; a target of a vertex that is not there; more targets to keep than a file
/// holds; fields that need more memory than the limit, before they are made: a source lists only
/// what moves, the fields have a displacement for every vertex.
pub fn morph_basis(
    mesh: &RawMesh,
    morphs: &RawMorphs,
    keep: Keep,
    memory_limit_bytes: u64,
    warnings: &mut Vec<String>,
) -> Result<MorphBasis, BakeError> {
    let (n, count) = (mesh.positions.len(), morphs.targets.len());
    check_size(mesh, count, keep, memory_limit_bytes)?;
    let mut basis = Basis {
        vertex_count: n,
        fields: vec![[0.0; 3]; n * count],
        modes: Vec::with_capacity(count),
        animation: None,
    };
    for (j, target) in morphs.targets.iter().enumerate() {
        let field = &mut basis.fields[j * n..(j + 1) * n];
        for &(vertex, u) in &target.displacements {
            let Some(place) = field.get_mut(vertex as usize) else {
                let message = format!("target {j} moves vertex {vertex} of {n}");
                return Err(BakeError::one("basis", Place::file(&mesh.name), message));
            };
            *place = u;
        }
        basis.modes.push(BasisMode {
            name: target.name.clone(),
            q_range: Some(range(morphs, j)),
            ..BasisMode::default()
        });
    }
    if let Some(clip) = &morphs.clip {
        basis.animation = Some(Animation {
            frame_count: clip.times_s.len(),
            times_s: Some(clip.times_s.clone()),
            q: clip.weights.clone(),
            motions: Vec::new(),
        });
    }
    warnings.extend(keep.warning(&mesh.name, count));
    let Kept {
        basis,
        fields,
        error,
    } = keep_fields(mesh, basis, keep)?;
    let is_zero = |j: usize| basis.field(j).iter().all(|u| *u == [0.0; 3]);
    let moves = |target: &RawTarget| target.displacements.iter().any(|(_, u)| *u != [0.0; 3]);
    if !fields.is_empty() && (0..fields.len()).all(is_zero) && morphs.targets.iter().any(moves) {
        warnings.push(format!(
            "{}: all kept targets are zero; use --max-error-rel E",
            mesh.name
        ));
    }
    for (j, mode) in basis.modes.iter().enumerate() {
        if is_zero(j) {
            let name = mode
                .name
                .as_deref()
                .map_or(String::new(), |name| format!(" {name:?}"));
            warnings.push(format!("{}: mode {j}{name} is zero everywhere", mesh.name));
        }
    }
    Ok(MorphBasis {
        default_weights: fields
            .iter()
            .map(|&j| morphs.targets[j].default_weight)
            .collect(),
        targets: fields,
        basis,
        error,
    })
}

/// Refuses fields that no file holds, or that need more than the limit.
fn check_size(mesh: &RawMesh, count: usize, keep: Keep, limit: u64) -> Result<(), BakeError> {
    let fail = |message| Err(BakeError::one("basis", Place::file(&mesh.name), message));
    // Bytes of the kept displacements: in f32, and where fields are left out once more in f64.
    let (kept, each) = match keep {
        Keep::All => (count, 12),
        Keep::First(wanted) => (wanted.min(count), 36),
        Keep::Auto { .. } => (count.min(MODE_COUNT_MAX), 36),
    };
    if kept > MODE_COUNT_MAX {
        return fail(format!(
            "{kept} morph targets are to be kept, a file holds at most {MODE_COUNT_MAX} \
             (--modes keeps fewer)"
        ));
    }
    let vertices = mesh.positions.len();
    let per_vertex = (count as u64)
        .saturating_mul(24)
        .saturating_add(kept as u64 * each);
    let need = (vertices as u64).saturating_mul(per_vertex);
    if need > limit {
        return fail(format!(
            "{count} morph targets of {vertices} vertices need about {} MiB, the limit is {} MiB \
             (--memory-limit)",
            need >> 20,
            limit >> 20
        ));
    }
    Ok(())
}

/// Typical largest |weight| of target `j`.
fn range(morphs: &RawMorphs, j: usize) -> f64 {
    let count = morphs.targets.len();
    let target = &morphs.targets[j];
    let default = target.default_weight.abs().max(target.largest_weight);
    let clip = morphs
        .clip
        .iter()
        .flat_map(|clip| clip.weights.iter().skip(j).step_by(count));
    clip.fold(default.max(1.0), |m, w| m.max(w.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kept_targets_that_are_all_zero_are_told() {
        let mesh = RawMesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            name: "m.glb".to_string(),
            ..RawMesh::default()
        };
        let target = |displacements| RawTarget {
            displacements,
            ..RawTarget::default()
        };
        let morphs = RawMorphs {
            targets: vec![target(Vec::new()), target(vec![(1, [0.0, 0.0, 1.0])])],
            ..RawMorphs::default()
        };
        let warnings = |keep| {
            let mut warnings = Vec::new();
            morph_basis(&mesh, &morphs, keep, 1 << 30, &mut warnings).expect("a basis");
            warnings
        };
        let text = "m.glb: all kept targets are zero; use --max-error-rel E";
        assert_eq!(warnings(Keep::First(1))[0], text);
        for keep in [Keep::First(0), Keep::First(2), Keep::All] {
            assert!(warnings(keep).iter().all(|warning| warning != text));
        }
    }
}
