//! Clips of the skeleton: which one is shown, and when.

use bdtree_runtime::{Asset, JointMatrix, LocalTransform, Skeleton, SkeletonError};
use bdtree_tools::printable;

use super::clock::Clock;

/// A clip, as it is listed.
#[derive(Debug, Clone, PartialEq)]
pub struct ClipName {
    /// The source's name, or its number.
    pub name: String,
    /// Its length in seconds.
    pub duration_s: f64,
}

/// The clips of an asset and the moment of the chosen one.
#[derive(Debug, Clone)]
pub struct Clips {
    /// All of them, in the file's order.
    pub names: Vec<ClipName>,
    /// The one that is shown; `None`: the skeleton is at rest, or as joints were given.
    pub chosen: Option<usize>,
    /// Its moment.
    pub clock: Clock,
    /// Why the moment is not shown.
    pub problem: Option<String>,
}

impl Clips {
    /// At rest; none of an asset without a skin.
    pub fn new(asset: &Asset<'_>) -> Self {
        let clips = asset.skeleton().into_iter().flat_map(|s| s.clips());
        let named = |(i, clip): (usize, bdtree_runtime::Clip<'_>)| ClipName {
            name: match clip.name() {
                "" => format!("clip {i}"),
                name => printable(name),
            },
            duration_s: clip.duration_s(),
        };
        Self {
            names: clips.enumerate().map(named).collect(),
            chosen: None,
            clock: Clock::new(),
            problem: None,
        }
    }

    /// Goes to the beginning of a clip, or to rest.
    pub fn choose(&mut self, clip: Option<usize>) {
        self.chosen = clip;
        self.clock.time_s = 0.0;
        self.clock.is_playing &= clip.is_some();
    }

    /// Length of the chosen clip in seconds; 0 at rest.
    pub fn duration_s(&self) -> f64 {
        let chosen = self.chosen.and_then(|clip| self.names.get(clip));
        // In a file that nobody has verified it may be anything.
        chosen
            .map(|clip| clip.duration_s)
            .filter(|duration| duration.is_finite())
            .map_or(0.0, |duration| duration.max(0.0))
    }

    /// Lets `dt_s` seconds pass, if it is playing. Returns whether another moment is shown.
    pub fn advance(&mut self, dt_s: f64) -> bool {
        self.clock.advance(dt_s, self.duration_s())
    }

    /// The joints of the moment, none at rest; and in `q` what the clip says of modes, the others as they are.
    ///
    /// # Errors
    /// A corrupt asset.
    pub fn moment(
        &self,
        asset: &Asset<'_>,
        q: &mut [f32],
    ) -> Result<Vec<JointMatrix>, SkeletonError> {
        let Some((skeleton, clip)) = asset.skeleton().zip(self.chosen) else {
            return Ok(Vec::new());
        };
        let Some(clip) = skeleton.clip(clip) else {
            return Ok(Vec::new());
        };
        let mut locals = vec![LocalTransform::IDENTITY; skeleton.node_count()];
        skeleton.rest(&mut locals)?;
        clip.sample_over(self.clock.time_s, &mut locals, q)?;
        joints(&skeleton, &locals)
    }
}

/// The matrices of all joints.
fn joints(
    skeleton: &Skeleton<'_>,
    locals: &[LocalTransform],
) -> Result<Vec<JointMatrix>, SkeletonError> {
    let identity = bdtree_runtime::joint::IDENTITY;
    let mut nodes = vec![identity; skeleton.node_count()];
    let mut joints = vec![identity; skeleton.joint_count()];
    skeleton.model_space(locals, &mut nodes)?;
    skeleton.joints(&nodes, &mut joints)?;
    Ok(joints)
}

/// Lines from each joint to the nearest one above it (model space, mesh units), where the joints stand at `posed`; at rest
/// where that is empty.
///
/// # Errors
/// A corrupt asset.
pub(super) fn bone_lines(
    asset: &Asset<'_>,
    posed: &[JointMatrix],
) -> Result<Vec<[[f64; 3]; 2]>, SkeletonError> {
    let Some(skeleton) = asset.skeleton() else {
        return Ok(Vec::new());
    };
    let at_rest;
    let posed = if posed.is_empty() {
        let mut locals = vec![LocalTransform::IDENTITY; skeleton.node_count()];
        skeleton.rest(&mut locals)?;
        at_rest = joints(&skeleton, &locals)?;
        &at_rest
    } else {
        posed
    };
    let place = |joint: usize| Some(posed.get(joint)?.map(|row| row[3]));
    let line = |joint| Some([place(joint)?, place(skeleton.joint_parent(joint)?)?]);
    Ok((0..skeleton.joint_count()).filter_map(line).collect())
}

#[cfg(test)]
mod tests {
    use bdtree_fixtures::skin::{bar, bar_skin, skinned_bar, with_skin};
    use bdtree_runtime::Model;

    use super::*;

    #[test]
    fn clips_are_listed_and_played() {
        let model = Model::from_bytes(&skinned_bar()).expect("a bar");
        let asset = model.asset();
        let mut clips = Clips::new(asset);
        let names: Vec<_> = clips.names.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["bend", "stretch"]);
        let mut q = [0.25];
        assert_eq!(clips.moment(asset, &mut q), Ok(Vec::new()), "at rest");
        assert!(!clips.advance(1.0), "nothing is chosen");
        clips.choose(Some(0));
        clips.clock.is_playing = true;
        assert!(clips.advance(1.25));
        assert_eq!(
            clips.clock.time_s, 0.25,
            "after the end comes the beginning"
        );
        let joints = clips.moment(asset, &mut q).expect("a moment");
        assert_eq!((joints.len(), q), (3, [0.5]), "the clip moves the mode");
        clips.choose(Some(1));
        q = [0.75];
        clips.moment(asset, &mut q).expect("a moment");
        assert_eq!(q, [0.75], "this one does not");
        clips.choose(None);
        assert!(!clips.clock.is_playing && clips.duration_s() == 0.0);
    }

    #[test]
    fn bones_go_from_joints_to_their_parents() {
        let model = Model::from_bytes(&skinned_bar()).expect("a bar");
        let lines = bone_lines(model.asset(), &[]).expect("lines");
        let expected = [
            [[2.5, 2.0, 3.0], [1.0, 2.0, 3.0]],
            [[4.0, 2.0, 3.0], [2.5, 2.0, 3.0]],
        ];
        assert_eq!(lines.len(), 2);
        for (a, b) in lines.as_flattened().iter().zip(expected.as_flattened()) {
            assert!((0..3).all(|k| (a[k] - b[k]).abs() < 1e-6), "{lines:?}");
        }
        let mut source = bar_skin();
        source.clips[0].name.clear();
        let model = Model::from_bytes(&with_skin(&bar(), &source)).expect("a bar");
        assert_eq!(Clips::new(model.asset()).names[0].name, "clip 0");
    }
}
