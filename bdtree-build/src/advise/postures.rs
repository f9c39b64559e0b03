//! Where the bones of a skinned asset are judged: at times of its clips, or turned about its joints.

use bdtree_runtime::{
    Asset, Clip, JointMatrix, LocalTransform, Skeleton, SkeletonError, joint, math,
};
use serde::Serialize;

use super::samples::evenly;
use crate::report::random::Random;

/// Joints that no clip moves are turned by unit quaternions along (x, y, z, 1) with x, y and z anywhere within ± this:
/// by up to 20°.
const TURN: f64 = 0.1;

/// Where the bones of samples come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Bones {
    /// Times of the asset's clips.
    Clips,
    /// No clips: the rest pose, and every joint turned about itself by up to 20°, the same in every run.
    Turns,
}

/// Poses of a skeleton.
pub(super) struct Postures {
    pub(super) bones: Bones,
    /// `q[s * M + j]` is what the clip of posture s shows of mode j; 0 without clips.
    pub(super) q: Vec<f32>,
    /// One matrix per joint, posture after posture.
    pub(super) joints: Vec<JointMatrix>,
}

/// So many (at least 1) postures of a skeleton: as many of each clip as of any other, or one of each of evenly chosen
/// clips where there are more, in the middles of equal parts of its time.
///
/// # Errors
/// A file that breaks the format's rules.
pub(super) fn postures(
    asset: &Asset<'_>,
    skeleton: &Skeleton<'_>,
    count: usize,
) -> Result<Postures, SkeletonError> {
    let mut memory = Memory::new(asset, skeleton);
    let clips: Vec<Clip<'_>> = evenly(skeleton.clip_count(), count)
        .into_iter()
        .filter_map(|index| skeleton.clip(index))
        .collect();
    let mut random = Random::new();
    for sample in 0..count {
        if clips.is_empty() {
            skeleton.rest(&mut memory.locals)?;
            if sample > 0 {
                turn(skeleton, &mut memory.locals, &mut random);
            }
        } else {
            let which = sample * clips.len() / count;
            let first = (which * count).div_ceil(clips.len());
            let end = ((which + 1) * count).div_ceil(clips.len());
            let share = ((sample - first) as f64 + 0.5) / (end - first) as f64;
            let clip = &clips[which];
            clip.sample(
                share * clip.duration_s(),
                &mut memory.locals,
                &mut memory.q_of_clip,
            )?;
        }
        memory.keep(skeleton)?;
    }
    Ok(Postures {
        bones: if clips.is_empty() {
            Bones::Turns
        } else {
            Bones::Clips
        },
        q: memory.q,
        joints: memory.joints,
    })
}

/// Turns each joint about itself; what hangs from it follows.
fn turn(skeleton: &Skeleton<'_>, locals: &mut [LocalTransform], random: &mut Random) {
    let nodes = (0..skeleton.joint_count()).filter_map(|joint| skeleton.joint_node(joint));
    for node in nodes {
        let mut turn = [0.0, 0.0, 0.0, 1.0];
        for x in &mut turn[..3] {
            *x = TURN * (2.0 * random.unit() - 1.0);
        }
        let length = turn.iter().map(|x| x * x).sum::<f64>().sqrt();
        let rows = math::rotation_matrix(turn.map(|x| x / length));
        let rows = rows.map(|[x, y, z]| [x, y, z, 0.0]);
        if let Some(local) = locals.get_mut(node) {
            *local = LocalTransform::Matrix(joint::compose(&local.to_matrix(), &rows));
        }
    }
}

/// Postures so far, and what one is made in.
struct Memory {
    locals: Vec<LocalTransform>,
    q_of_clip: Vec<f32>,
    nodes: Vec<JointMatrix>,
    q: Vec<f32>,
    joints: Vec<JointMatrix>,
}

impl Memory {
    fn new(asset: &Asset<'_>, skeleton: &Skeleton<'_>) -> Self {
        let nodes = skeleton.node_count();
        Self {
            locals: vec![LocalTransform::IDENTITY; nodes],
            q_of_clip: vec![0.0; asset.mode_count()],
            nodes: vec![joint::IDENTITY; nodes],
            q: Vec::new(),
            joints: Vec::new(),
        }
    }

    /// Adds the posture of the local transforms.
    fn keep(&mut self, skeleton: &Skeleton<'_>) -> Result<(), SkeletonError> {
        skeleton.model_space(&self.locals, &mut self.nodes)?;
        let first = self.joints.len();
        let end = first + skeleton.joint_count();
        self.joints.resize(end, joint::IDENTITY);
        skeleton.joints(&self.nodes, &mut self.joints[first..])?;
        self.q.extend_from_slice(&self.q_of_clip);
        Ok(())
    }
}
