//! The skeleton of a skinned asset and its clips (SPEC 7.8, 7.9): from a clip and a time to the matrices of joints that
//! an instance takes.
//!
//! Everything works in the caller's memory: [`Skeleton::rest`] and [`Clip::sample`] fill local transforms,
//! [`blend`] mixes them, [`Skeleton::model_space`] follows the hierarchy, and [`Skeleton::joints`] picks the joints.
//! With the feature `alloc`, [`SkeletonPose`] owns that memory. All of it is f64.

mod clip;
mod error;
mod local;
mod model_space;
#[cfg(feature = "alloc")]
mod pose;
mod rotation;
#[cfg(test)]
mod tests;
mod track;

pub use clip::{Channel, Clip};
pub use error::SkeletonError;
pub use local::{LocalTransform, blend, blend_q};
use model_space::ModelSpace;
#[cfg(feature = "alloc")]
pub use pose::SkeletonPose;
pub(crate) use track::Track;

use bdtree_format::{NO_PARENT, SectionKind, SkeletonNode, local_kind};
use core::mem::{offset_of, size_of};

use crate::error::{Datum, FormatError};
use crate::joint::JointMatrix;
use crate::verify::{JOINTS, KINDS, PARENTS};
use crate::view::{Asset, Skin};
use error::same_length;

/// The skeleton of an asset: nodes, parents before their children; some of them are joints, which move the vertices.
#[derive(Debug, Clone, Copy)]
pub struct Skeleton<'a> {
    asset: Asset<'a>,
    skin: Skin<'a>,
}

impl<'a> Asset<'a> {
    /// The skeleton and its clips; `None` without a skin.
    pub fn skeleton(&self) -> Option<Skeleton<'a>> {
        let skin = self.skin?;
        Some(Skeleton { asset: *self, skin })
    }
}

impl<'a> Skeleton<'a> {
    /// Number of joints: the length of what [`Instance::set_joints`](crate::Instance::set_joints) takes.
    pub fn joint_count(&self) -> usize {
        self.skin.joints.len()
    }

    /// Number of nodes, joints among them: the length of local transforms.
    pub fn node_count(&self) -> usize {
        self.skin.skeleton.len()
    }

    /// The source's name of a node; `None` when there is no such node, empty when it has none.
    pub fn node_name(&self, node: usize) -> Option<&'a str> {
        let record = self.skin.skeleton.get(node)?;
        Some(self.skin.name(record.name_start, record.name_bytes))
    }

    /// The node that a node hangs on; `None` for roots, and when there is no such node.
    pub fn node_parent(&self, node: usize) -> Option<usize> {
        let parent = self.skin.skeleton.get(node)?.parent;
        // Parents stand before their children: a walk upwards ends in damaged files too.
        (parent != NO_PARENT && (parent as usize) < node).then_some(parent as usize)
    }

    /// The node of a joint; `None` when there is no such joint.
    pub fn joint_node(&self, joint: usize) -> Option<usize> {
        let node = *self.skin.joints.get(joint)? as usize;
        (node < self.node_count()).then_some(node)
    }

    /// The source's name of a joint; `None` when there is no such joint, empty when it has none.
    pub fn joint_name(&self, joint: usize) -> Option<&'a str> {
        self.node_name(self.joint_node(joint)?)
    }

    /// The nearest joint above a joint; `None` where there is none.
    pub fn joint_parent(&self, joint: usize) -> Option<usize> {
        let mut node = self.joint_node(joint)?;
        loop {
            node = self.node_parent(node)?;
            let above = self.skin.joints.iter().position(|n| *n as usize == node);
            if above.is_some() {
                return above;
            }
        }
    }

    /// The first joint with this name; `None` where there is none.
    pub fn joint_index(&self, name: &str) -> Option<usize> {
        (0..self.joint_count()).find(|joint| self.joint_name(*joint) == Some(name))
    }

    /// Number of clips.
    pub fn clip_count(&self) -> usize {
        self.skin.clips.len()
    }

    /// A clip, counted from 0; `None` when there is no such clip.
    pub fn clip(&self, index: usize) -> Option<Clip<'a>> {
        let record = self.skin.clips.get(index)?;
        Some(Clip::new(*self, record))
    }

    /// All clips.
    pub fn clips(&self) -> impl ExactSizeIterator<Item = Clip<'a>> + use<'a> {
        let skeleton = *self;
        let records = self.skin.clips.iter();
        records.map(move |record| Clip::new(skeleton, record))
    }

    /// The first clip with this name, counted from 0; `None` where there is none.
    pub fn clip_index(&self, name: &str) -> Option<usize> {
        self.clips().position(|clip| clip.name() == name)
    }

    /// The transforms of all nodes at rest.
    ///
    /// # Errors
    /// `locals` of another length than [`Skeleton::node_count`]; a node of unknown kind.
    pub fn rest(&self, locals: &mut [LocalTransform]) -> Result<(), SkeletonError> {
        same_length("local transforms", self.node_count(), locals.len())?;
        for (i, (local, node)) in locals.iter_mut().zip(self.skin.skeleton).enumerate() {
            *local = self.rest_of(i, node)?;
        }
        Ok(())
    }

    fn rest_of(&self, i: usize, node: &SkeletonNode) -> Result<LocalTransform, FormatError> {
        // Spelled out: `array::map` is left as calls.
        let at = |k: usize| f64::from(node.local[k]);
        match node.kind {
            local_kind::PARTS => Ok(LocalTransform::Parts {
                translation: [at(0), at(1), at(2)],
                rotation: [at(3), at(4), at(5), at(6)],
                scale: [at(7), at(8), at(9)],
            }),
            local_kind::MATRIX => {
                let row = |r: usize| [at(4 * r), at(4 * r + 1), at(4 * r + 2), at(4 * r + 3)];
                Ok(LocalTransform::Matrix([row(0), row(1), row(2)]))
            }
            kind => Err(self
                .node_place(i, offset_of!(SkeletonNode, kind))
                .rule(KINDS)
                .broken(local_kind::MATRIX, kind)),
        }
    }

    /// Where a field of a node stands in the file.
    fn node_place(&self, node: usize, offset: usize) -> crate::error::Check {
        let at = node * size_of::<SkeletonNode>() + offset;
        self.asset.at(SectionKind::SKELETON, at)
    }

    /// From the space of each node to the model's (mesh units): parents' matrices times local ones.
    ///
    /// # Errors
    /// `locals` or `nodes` of another length than [`Skeleton::node_count`]; a parent that stands behind its child.
    pub fn model_space(
        &self,
        locals: &[LocalTransform],
        nodes: &mut [JointMatrix],
    ) -> Result<(), SkeletonError> {
        same_length("local transforms", self.node_count(), locals.len())?;
        same_length("matrices of nodes", self.node_count(), nodes.len())?;
        let work = ModelSpace {
            records: self.skin.skeleton,
            locals,
            nodes,
        };
        self.asset.kernel.run(work).map_err(|node| {
            let place = self.node_place(node, offset_of!(SkeletonNode, parent));
            let found = self.skin.skeleton[node].parent;
            let place = place.rule(PARENTS);
            place.broken(Datum::Below(node as u64), found).into()
        })
    }

    /// The matrices of the joints among those of all nodes: what
    /// [`Instance::set_joints`](crate::Instance::set_joints) takes.
    ///
    /// # Errors
    /// `nodes` of another length than [`Skeleton::node_count`], `joints` of another than [`Skeleton::joint_count`]; a
    /// joint that is no node of the file.
    pub fn joints(
        &self,
        nodes: &[JointMatrix],
        joints: &mut [JointMatrix],
    ) -> Result<(), SkeletonError> {
        same_length("matrices of nodes", self.node_count(), nodes.len())?;
        same_length("matrices of joints", self.joint_count(), joints.len())?;
        for (j, (joint, node)) in joints.iter_mut().zip(self.skin.joints).enumerate() {
            let Some(matrix) = nodes.get(*node as usize) else {
                let place = self.asset.at(SectionKind::JOINTS, size_of::<u32>() * j);
                return Err(place
                    .rule(JOINTS)
                    .broken(Datum::Below(nodes.len() as u64), *node)
                    .into());
            };
            *joint = *matrix;
        }
        Ok(())
    }
}
