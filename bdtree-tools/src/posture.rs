//! What `--q`, `--frame`, `--clip` and `--joints` ask for.

use std::path::PathBuf;

use bdtree_runtime::{BoneMatrices, JointMatrix, Transform};
use clap::Args;

use crate::AssetFile;
use crate::error::ToolError;
use crate::frames::frame_of;
use crate::joints;
use crate::q::{QProblem, QText, checked_q};

/// How the mesh is posed: q, a frame of its animation, a clip of its skeleton, or joints.
#[derive(Debug, Clone, Default, Args)]
pub struct PostureArguments {
    /// One number per mode, separated by commas, each at most the mode's q_limit in magnitude
    /// (`info` shows it). For elastic modes, 1 moves the vertex that the mode moves most by one mesh unit
    /// [default: zeros; with --clip: what the clip shows]
    #[arg(long, allow_hyphen_values = true, value_name = "Q1,Q2,…")]
    pub q: Option<QText>,
    /// Frame of the file's animation, counted from 0, instead of --q (`info` shows how many there
    /// are)
    #[arg(long, value_name = "T", conflicts_with = "q", value_parser = crate::frames::frame_number)]
    pub frame: Option<u64>,
    /// Clip of the file's skeleton (`info` lists them)
    #[arg(long, value_name = "NAME", conflicts_with_all = ["frame", "joints"])]
    pub clip: Option<String>,
    /// Time of the clip in seconds; before its first and after its last key it stands still
    #[arg(
        long,
        value_name = "SECONDS",
        default_value = "0",
        requires = "clip",
        value_parser = seconds,
        allow_hyphen_values = true
    )]
    pub time: f64,
    /// Joint matrices without inverse bind matrices: an array of shape (joints, 3, 4) in mesh units, in the order in which
    /// `info --json` lists the joints [default: at rest]
    #[arg(long, value_name = "FILE.npy", conflicts_with = "frame")]
    pub joints: Option<PathBuf>,
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(time) if time.is_finite() => Ok(time),
        _ => Err("not a number of seconds".to_string()),
    }
}

impl PostureArguments {
    /// True if any of them is given.
    pub fn is_given(&self) -> bool {
        self.q.is_some() || self.frame.is_some() || self.clip.is_some() || self.joints.is_some()
    }
}

/// q, joints and placement of an asset.
#[derive(Debug, Clone, PartialEq)]
pub struct Posture {
    /// One number per mode.
    pub q: Vec<f32>,
    /// One matrix per joint; `None`: at rest, or no skin.
    pub joints: Option<Vec<JointMatrix>>,
    /// A frame's rigid motion, else the identity.
    pub transform: Transform,
}

impl Posture {
    /// q where the mesh stands, bones at rest.
    pub fn of_q(q: Vec<f32>) -> Self {
        Self {
            q,
            joints: None,
            transform: Transform::IDENTITY,
        }
    }

    /// The joints as poses take them.
    pub fn bones(&self) -> BoneMatrices<'_> {
        bones(self.joints.as_deref())
    }
}

/// Joints as poses take them.
pub(crate) fn bones(joints: Option<&[JointMatrix]>) -> BoneMatrices<'_> {
    joints.map_or(BoneMatrices::Rest, BoneMatrices::Joints)
}

/// The posture that the options ask for: that of a frame with its rigid motion, that of a clip, or q (zeros if there is
/// none) and joints where the mesh stands.
///
/// # Errors
/// A frame or clip that is not there, q or joints that do not fit the asset: every problem.
pub fn posture(file: &AssetFile, asked: &PostureArguments) -> Result<Posture, ToolError> {
    let asset = file.asset();
    let name = file.path().display().to_string();
    if let Some(index) = asked.frame {
        let frame = frame_of(asset, &name, index)
            .map_err(|message| ToolError::input("--frame", message))?;
        return Ok(Posture {
            q: frame.q().to_vec(),
            joints: None,
            transform: frame.transform(),
        });
    }
    let played = match &asked.clip {
        Some(clip) => {
            let played = joints::played(file.model(), &name, clip, asked.time);
            Some(played.map_err(|message| ToolError::input("--clip", message))?)
        }
        None => None,
    };
    let given = match &asked.joints {
        Some(path) => {
            let fit = |matrices: Vec<JointMatrix>| {
                joints::check_count(asset, &name, matrices.len())?;
                Ok(matrices)
            };
            let read = joints::read(path).and_then(fit);
            Some(read.map_err(|message| ToolError::input("--joints", message))?)
        }
        None => None,
    };
    let (of_clip, joints) = match played {
        Some((q, joints)) => (Some(q), Some(joints)),
        None => (None, given),
    };
    let q = match (of_clip, &asked.q) {
        (Some(q), None) => q,
        (_, q) => {
            let q = q.as_ref().map(|q| q.0.as_slice());
            checked_q(q, asset, &name).map_err(|problems| {
                let line = |(mode, message): QProblem| match mode {
                    Some(mode) => format!("--q: q[{mode}]: {message}"),
                    None => format!("--q: {message}"),
                };
                ToolError::Input(problems.into_iter().map(line).collect())
            })?
        }
    };
    Ok(Posture {
        q,
        joints,
        transform: Transform::IDENTITY,
    })
}
