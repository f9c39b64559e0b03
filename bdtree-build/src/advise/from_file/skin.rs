//! The skin of an opened file.

use bdtree_format::{channel_path, interpolation};
use bdtree_runtime::{Asset, Channel, Clip, LocalTransform, Skeleton, SkeletonError, VertexId};

use super::AdviceError;
use crate::error::{BakeError, Place};
use crate::input::{
    Animated, KeyInterpolation, Local, RawBone, RawChannel, RawInfluences, RawSkeletonNode,
    RawSkin, RawSkinClip,
};

/// The skin as a bake takes it, which with [`Weights::AsStored`](crate::skin::Weights) makes the same sections of it.
///
/// # Errors
/// Records that break the format's rules; channels with more keys than the file has numbers.
pub(super) fn skin(asset: &Asset<'_>) -> Result<Option<RawSkin>, AdviceError> {
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
    // Channels may share keys, as often as a file of their size says: copies need not fit into memory.
    let mut room = asset.bytes().len() / size_of::<f32>();
    let mut clips = Vec::with_capacity(skeleton.clip_count());
    for clip in skeleton.clips() {
        clips.push(raw_clip(&clip, &mut room)?);
    }
    Ok(Some(RawSkin {
        influences: influences(asset)?,
        bones: bones.collect(),
        joints: joints.collect(),
        skeleton: nodes(&skeleton)?,
        clips,
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

/// Takes the numbers of its keys from `room`.
fn raw_clip(clip: &Clip<'_>, room: &mut usize) -> Result<RawSkinClip, AdviceError> {
    let mut channels = Vec::new();
    for k in 0..clip.channel_count() {
        let channel = clip.channel(k)?;
        let numbers = channel.times_s().len() + channel.values().len();
        *room = room.checked_sub(numbers).ok_or_else(|| {
            let message = format!("channels of clip {:?} share their keys", clip.name());
            BakeError::one("skin", Place::NOWHERE, message)
        })?;
        channels.push(raw_channel(&channel));
    }
    Ok(RawSkinClip {
        name: clip.name().to_string(),
        channels,
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

#[cfg(test)]
mod tests {
    use bdtree_runtime::Model;

    use super::*;

    #[test]
    fn more_keys_than_the_file_has_are_not_copied() {
        let bytes = include_bytes!("../../../../fixtures/golden/skinned.bdt");
        let model = Model::from_bytes(bytes).expect("a golden file");
        let skeleton = model.asset().skeleton().expect("a skeleton");
        let clip = skeleton.clip(0).expect("a clip");
        let mut room = bytes.len() / size_of::<f32>();
        let all = raw_clip(&clip, &mut room).expect("keys of its own");
        let numbers = |channel: &RawChannel| channel.times_s.len() + channel.values.len();
        let mut fewer = all.channels.iter().map(numbers).sum::<usize>() - 1;
        let error = raw_clip(&clip, &mut fewer).expect_err("one number too many");
        let text = error.to_string();
        assert!(text.contains("share their keys"), "{text}");
    }
}
