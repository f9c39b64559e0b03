//! Skins: which bones carry the vertices, the skeleton that moves them, and its clips, as a source has them.

/// Three rows of four: x ↦ L x + t.
pub type Rows = [[f64; 4]; 3];

/// What carries the vertices of a mesh after its fields have moved them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawSkin {
    /// The bones of each vertex.
    pub influences: RawInfluences,
    /// Distinct pairs of a joint and an inverse bind matrix.
    pub bones: Vec<RawBone>,
    /// The node of each joint in `skeleton`, none twice.
    pub joints: Vec<u32>,
    /// The joints and what they hang from, parents before children.
    pub skeleton: Vec<RawSkeletonNode>,
    /// What its animations do, in source order.
    pub clips: Vec<RawSkinClip>,
}

/// The weights of all vertices as the source has them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawInfluences {
    /// First influence of each vertex, and the end of the last one's: N + 1 entries.
    pub starts: Vec<u32>,
    /// Bone and weight, vertex by vertex; bones of a vertex ascend, weights are finite and positive.
    pub list: Vec<(u16, f64)>,
    /// Where the weights of a run of vertices stand in the source: the first vertex and the place, ascending.
    pub places: Vec<(u32, String)>,
    /// The weights' file, where it is not the mesh's.
    pub file: Option<String>,
}

/// A bone: p ↦ joint matrix × inverse bind matrix × p.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RawBone {
    /// Index of the joint.
    pub joint: u32,
    /// From mesh coordinates to the joint's space.
    pub inverse_bind: Rows,
}

/// A node of the skeleton.
#[derive(Debug, Clone, PartialEq)]
pub struct RawSkeletonNode {
    /// Name for people.
    pub name: String,
    /// Index of the parent, below the node's own.
    pub parent: Option<u32>,
    /// From the node's space to its parent's at rest.
    pub local: Local,
}

/// The placement of a node in its parent's space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Local {
    /// Scale, then rotation (a unit quaternion x, y, z, w), then translation: what clips may animate.
    Parts {
        /// Translation.
        translation: [f64; 3],
        /// Rotation.
        rotation: [f64; 4],
        /// Scale.
        scale: [f64; 3],
    },
    /// A matrix, which nothing animates.
    Matrix(Rows),
}

/// An animation of the skeleton and of weights of morph targets.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RawSkinClip {
    /// Name in the source.
    pub name: String,
    /// What moves.
    pub channels: Vec<RawChannel>,
}

/// One animated thing with its keys.
#[derive(Debug, Clone, PartialEq)]
pub struct RawChannel {
    /// What moves.
    pub animated: Animated,
    /// How values between keys are found.
    pub interpolation: KeyInterpolation,
    /// Seconds of the keys, strictly ascending, not negative.
    pub times_s: Vec<f32>,
    /// Key after key; with tangents the one before, the value, the one after.
    pub values: Vec<f32>,
}

/// What a channel animates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Animated {
    /// The translation of a node of the skeleton.
    Translation(u32),
    /// The rotation of a node of the skeleton.
    Rotation(u32),
    /// The scale of a node of the skeleton.
    Scale(u32),
    /// The weights of fields.
    Fields {
        /// The first of them.
        first: u32,
        /// How many.
        count: u32,
    },
}

impl Animated {
    /// Numbers of one value.
    pub fn width(self) -> usize {
        match self {
            Self::Translation(_) | Self::Scale(_) => 3,
            Self::Rotation(_) => 4,
            Self::Fields { count, .. } => count as usize,
        }
    }
}

/// How values between keys are found (glTF 2.0, appendix C).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KeyInterpolation {
    /// In proportion; rotations along the shorter arc.
    Linear,
    /// The key before.
    Step,
    /// A cubic spline.
    Cubic,
}

impl KeyInterpolation {
    /// Values of one key.
    pub fn values_per_key(self) -> usize {
        match self {
            Self::Linear | Self::Step => 1,
            Self::Cubic => 3,
        }
    }
}

impl RawInfluences {
    /// The influences of a vertex; none where there is no such vertex.
    pub fn of(&self, vertex: usize) -> &[(u16, f64)] {
        let ends = self
            .starts
            .get(vertex..)
            .and_then(<[u32]>::first_chunk::<2>);
        let run = ends.and_then(|&[start, end]| self.list.get(start as usize..end as usize));
        run.unwrap_or_default()
    }

    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }
}

impl RawSkin {
    /// With clips that move modes instead of morph targets: mode k is target `targets[k]`, ascending. Channels of
    /// targets that are no modes go, and clips without channels with them.
    pub(crate) fn keep_targets(&mut self, targets: &[usize]) {
        for clip in &mut self.clips {
            clip.channels
                .retain_mut(|channel| keep_in_channel(channel, targets));
        }
        self.clips.retain(|clip| !clip.channels.is_empty());
    }

    /// The largest |weight| that a key of a clip gives each of `count` fields.
    pub(crate) fn largest_weights(&self, count: usize) -> Vec<f64> {
        let mut largest = vec![0.0_f64; count];
        for channel in self.clips.iter().flat_map(|clip| &clip.channels) {
            let Animated::Fields { first, .. } = channel.animated else {
                continue;
            };
            let (width, per_key) = (
                channel.animated.width(),
                channel.interpolation.values_per_key(),
            );
            // Of three values the middle one is the weight.
            let values = channel.values.chunks_exact(width.max(1));
            for value in values.skip(per_key / 2).step_by(per_key) {
                let own = largest.iter_mut().skip(first as usize);
                for (most, weight) in own.zip(value) {
                    *most = most.max(f64::from(weight.abs()));
                }
            }
        }
        largest
    }
}

/// False if nothing that the channel moves is kept.
fn keep_in_channel(channel: &mut RawChannel, targets: &[usize]) -> bool {
    let Animated::Fields { first, count } = channel.animated else {
        return true;
    };
    let (from, to) = (first as usize, first as usize + count as usize);
    let modes = targets.partition_point(|&t| t < from)..targets.partition_point(|&t| t < to);
    if modes.is_empty() {
        return false;
    }
    if modes.len() < count as usize {
        let kept = &targets[modes.clone()];
        let values = channel.values.chunks_exact(count as usize);
        channel.values = values
            .flat_map(|value| kept.iter().map(|&target| value[target - from]))
            .collect();
    }
    // No loss: a file has at most 512 modes.
    channel.animated = Animated::Fields {
        first: modes.start as u32,
        count: modes.len() as u32,
    };
    true
}
