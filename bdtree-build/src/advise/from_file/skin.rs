//! The skin of an opened file.

use bdtree_format::{channel_path, interpolation};
use bdtree_runtime::{Asset, Channel, Clip, LocalTransform, Skeleton, SkeletonError, VertexId};

use crate::input::{
    Animated, KeyInterpolation, Local, RawBone, RawChannel, RawInfluences, RawSkeletonNode,
    RawSkin, RawSkinClip,
};

/// The skin as a bake takes it, which with [`Weights::AsStored`](crate::skin::Weights) makes the same sections of it.
///
/// # Errors
/// Records that break the format's rules.
pub(super) fn skin(asset: &Asset<'_>) -> Result<Option<RawSkin>, SkeletonError> {
    let Some(skeleton) = asset.skeleton() else {
        return Ok(None);
    };
    let bones = asset.bones().iter().map(|bone| RawBone {
        joint: bone.joint.get(),
        inverse_bind: bone.inverse_bind.map(|row| row.map(|x| x.get())),
    });
    // A joint without a node is the bake's to refuse.
    let joints = (0..skeleton.joint_count())
        .map(|joint| skeleton.joint_node(joint).map_or(u32::MAX, |n| n as u32));
    let clips = skeleton.clips().map(|clip| raw_clip(&clip));
    Ok(Some(RawSkin {
        influences: influences(asset)?,
        bones: bones.collect(),
        joints: joints.collect(),
        skeleton: nodes(&skeleton)?,
        clips: clips.collect::<Result<_, _>>()?,
    }))
}

fn influences(asset: &Asset<'_>) -> Result<RawInfluences, SkeletonError> {
    let mut influences = RawInfluences {
        starts: vec![0],
        ..RawInfluences::default()
    };
    for vertex in (0..asset.vertex_count() as u32).map(VertexId) {
        let own = asset.influences(vertex)?.iter();
        let own = own.map(|influence| (influence.bone, f64::from(influence.weight)));
        influences.list.extend(own);
        influences.starts.push(influences.list.len() as u32);
    }
    Ok(influences)
}

fn nodes(skeleton: &Skeleton<'_>) -> Result<Vec<RawSkeletonNode>, SkeletonError> {
    let mut rest = vec![LocalTransform::IDENTITY; skeleton.node_count()];
    skeleton.rest(&mut rest)?;
    let node = |(i, local): (usize, &LocalTransform)| RawSkeletonNode {
        name: skeleton.node_name(i).unwrap_or_default().to_string(),
        parent: skeleton.node_parent(i).map(|parent| parent as u32),
        local: match *local {
            LocalTransform::Parts {
                translation,
                rotation,
                scale,
            } => Local::Parts {
                translation,
                rotation,
                scale,
            },
            LocalTransform::Matrix(matrix) => Local::Matrix(matrix),
        },
    };
    Ok(rest.iter().enumerate().map(node).collect())
}

fn raw_clip(clip: &Clip<'_>) -> Result<RawSkinClip, SkeletonError> {
    let channels = (0..clip.channel_count()).map(|k| Ok(raw_channel(&clip.channel(k)?)));
    Ok(RawSkinClip {
        name: clip.name().to_string(),
        channels: channels.collect::<Result<_, SkeletonError>>()?,
    })
}

/// [`Clip::channel`] refuses paths and interpolations that are unknown.
fn raw_channel(channel: &Channel<'_>) -> RawChannel {
    let record = channel.record();
    RawChannel {
        animated: match record.path {
            channel_path::TRANSLATION => Animated::Translation(record.target),
            channel_path::ROTATION => Animated::Rotation(record.target),
            channel_path::SCALE => Animated::Scale(record.target),
            _ => Animated::Fields {
                first: record.target,
                count: record.target_count,
            },
        },
        interpolation: match record.interpolation {
            interpolation::LINEAR => KeyInterpolation::Linear,
            interpolation::STEP => KeyInterpolation::Step,
            _ => KeyInterpolation::Cubic,
        },
        times_s: channel.times_s().to_vec(),
        values: channel.values().to_vec(),
    }
}
