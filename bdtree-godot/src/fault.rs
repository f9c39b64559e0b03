//! Why a collider has no pose or no answer, and what of that is said.

use std::collections::HashSet;

use bdtree_runtime::{FormatError, PoseError, QueryError};
use thiserror::Error;

/// Why a collider has no pose or no answer.
#[derive(Debug, Error)]
pub(crate) enum Fault {
    #[error("no file is set")]
    NoFile,
    #[error("{path} cannot be read: {reason}")]
    Read { path: String, reason: String },
    #[error("{path}: {error}")]
    Format { path: String, error: FormatError },
    #[error("mesh_instance leads to no MeshInstance3D: {0}")]
    NoMesh(String),
    #[error(
        "the file has a skin, and there is no MeshInstance3D: set mesh_instance, or make the collider its child or sibling"
    )]
    SkinWithoutMesh,
    #[error("the MeshInstance3D has no Skeleton3D at its path {0:?}, and the file has a skin")]
    NoSkeleton(String),
    #[error("the MeshInstance3D has no Skin, whose binds use_skin_binds asks for")]
    NoSkin,
    #[error("the skeleton has no bone {0:?}, as a joint of the file is called")]
    NoBone(String),
    #[error("joint {0} of the file has no name, so no bone is known to be it")]
    UnnamedJoint(usize),
    #[error("joints {0:?} and {1:?} of the file are the same bone of the skeleton")]
    SameBone(String, String),
    #[error("the Skin has no bind of the bone {0:?}")]
    NoBind(String),
    #[error(
        "the joint {0:?} has several inverse bind matrices in the file: use_skin_binds cannot tell them apart"
    )]
    SeveralBinds(String),
    #[error("the file has no mode {0:?}, as a blend shape is called: its modes are {1}")]
    NoMode(String, String),
    #[error("blend shapes {0:?} and {1:?} are the same mode of the file")]
    SameMode(String, String),
    #[error("the mesh has {found} blend shapes, the file has {expected} modes without names")]
    ModeCount { expected: usize, found: usize },
    #[error("q has {found} numbers, the file has {expected} modes")]
    Length { expected: usize, found: usize },
    #[error(
        "the transform scales its axes differently, shears, mirrors or is not finite: a collider takes a rotation, one \
         positive scale and a translation"
    )]
    Transform,
    #[error("a box's axes must be at right angles, and not of length 0")]
    BoxAxes,
    #[error("the pose is refused: {0}")]
    Pose(#[from] PoseError),
    #[error("the query is refused: {0}")]
    Query(#[from] QueryError),
}

impl Fault {
    /// What scripts tell faults apart by.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Self::NoFile | Self::Read { .. } | Self::Format { .. } => "file",
            Self::NoMesh(_) | Self::SkinWithoutMesh => "mesh",
            Self::NoSkeleton(_) | Self::NoBone(_) | Self::UnnamedJoint(_) | Self::SameBone(..) => {
                "skeleton"
            }
            Self::NoSkin | Self::NoBind(_) | Self::SeveralBinds(_) => "skin",
            Self::NoMode(..) | Self::SameMode(..) | Self::ModeCount { .. } => "blend_shapes",
            Self::Length { .. } | Self::Pose(_) => "pose",
            Self::Transform => "transform",
            Self::BoxAxes | Self::Query(_) => "query",
        }
    }
}

/// What was said already: a fault that comes every frame is said once.
#[derive(Debug, Default)]
pub(crate) struct Told {
    kinds: HashSet<&'static str>,
    last: String,
}

impl Told {
    /// Whether a fault of this kind is the first one since [`Told::forget`].
    pub(crate) fn is_new(&mut self, fault: &Fault) -> bool {
        self.last = fault.to_string();
        self.kinds.insert(fault.kind())
    }

    /// The last fault in words; empty without one.
    pub(crate) fn last(&self) -> &str {
        &self.last
    }

    /// Says everything anew: the file or the nodes are others.
    pub(crate) fn forget(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kind_is_told_once_and_its_last_words_are_kept() {
        let mut told = Told::default();
        assert_eq!(told.last(), "");
        assert!(told.is_new(&Fault::NoBone("hand".into())));
        assert!(!told.is_new(&Fault::NoBone("foot".into())));
        assert!(told.last().contains("foot"), "{}", told.last());
        // Another kind is another thing to mend.
        assert!(told.is_new(&Fault::Transform));
        assert!(told.is_new(&Fault::Pose(PoseError::Scale)));
        assert!(!told.is_new(&Fault::Transform));
        told.forget();
        assert_eq!(told.last(), "");
        assert!(told.is_new(&Fault::Transform));
    }
}
