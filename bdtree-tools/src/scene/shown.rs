//! What an instance shows: q as the scene writes it, or a frame of its asset's animation.

use bdtree_runtime::Transform;

use super::assets::Assets;
use super::fields::{At, Fields, Problems};
use crate::frames::frame_of;
use crate::q::checked_q;

/// Frame numbers beyond this may have been others in the JSON's text: 2^53.
const FRAME_MAX: f64 = (1_u64 << 53) as f64;

/// q, and where it is from.
pub(super) struct Shown {
    /// One number per mode.
    pub(super) q: Vec<f32>,
    /// The frame's number and its rigid motion.
    pub(super) frame: Option<(u64, Transform)>,
}

/// Reads `q` or `frame` of an instance whose asset is the one with this index and path.
pub(super) fn read_shown(
    fields: &Fields<'_>,
    asset: Option<(usize, &str)>,
    assets: &Assets,
    problems: &mut Problems,
) -> Option<Shown> {
    match fields.optional("frame") {
        Some(at) if fields.optional("q").is_some() => {
            problems.add(&at.place, "an instance has either q or a frame");
            None
        }
        Some(at) => read_frame(&at, asset, assets, problems),
        None => read_q(fields, asset, assets, problems),
    }
}

fn read_frame(
    at: &At<'_>,
    asset: Option<(usize, &str)>,
    assets: &Assets,
    problems: &mut Problems,
) -> Option<Shown> {
    let number = at.number(problems)?;
    if !(number.fract() == 0.0 && (0.0..=FRAME_MAX).contains(&number)) {
        problems.add(&at.place, "not a whole number from 0 on");
        return None;
    }
    let (index, path) = asset?;
    match frame_of(assets.file(index).asset(), path, number as u64) {
        Ok(frame) => Some(Shown {
            q: frame.q().to_vec(),
            frame: Some((number as u64, frame.transform())),
        }),
        Err(message) => {
            problems.add(&at.place, message);
            None
        }
    }
}

fn read_q(
    fields: &Fields<'_>,
    asset: Option<(usize, &str)>,
    assets: &Assets,
    problems: &mut Problems,
) -> Option<Shown> {
    let q = match fields.optional("q") {
        Some(at) => Some(at.numbers(problems)?),
        None => None,
    };
    let (index, path) = asset?;
    match checked_q(q.as_deref(), assets.file(index).asset(), path) {
        Ok(q) => Some(Shown { q, frame: None }),
        Err(found) => {
            let place = fields.place("q");
            for problem in found {
                match problem.mode {
                    Some(mode) => problems.add(&format!("{place}[{mode}]"), problem.message),
                    None => problems.add(&place, problem.message),
                }
            }
            None
        }
    }
}
