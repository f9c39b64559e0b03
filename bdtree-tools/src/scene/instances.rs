//! The scene's instances: names, assets, q and placements.

use std::collections::BTreeMap;

use bdtree_runtime::{JointMatrix, Transform};

use super::assets::Assets;
use super::fields::{At, Fields};
use crate::frames::frame_of;
use crate::joints;
use crate::q::checked_q;

/// A deformed asset and where it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    /// Its name in the scene.
    pub name: String,
    /// Index of its asset among the scene's files.
    pub file: usize,
    /// One number per mode.
    pub q: Vec<f32>,
    /// The frame of the asset's animation that q is of, if it is one.
    pub frame: Option<u64>,
    /// One matrix per joint; `None`: at rest, or no skin.
    pub joints: Option<Vec<JointMatrix>>,
    /// Where it stands; a frame's rigid motion is part of it.
    pub transform: Transform,
}

/// The names that queries may use: each leads to a place in the list, or to `None` where the instance
/// has problems.
#[derive(Debug, Default)]
pub(super) struct Names(pub(super) BTreeMap<String, Option<usize>>);

impl Names {
    /// The instance that a field names. `None`: the problem is noted now; `Some(None)`: those of the
    /// instance were before.
    pub(super) fn instance(&self, fields: &Fields<'_>, key: &str) -> Option<Option<usize>> {
        let name = fields.get(key, At::text)?;
        let unknown = || {
            let message = format_args!("unknown instance {name:?}");
            fields.at(key).fail(message)
        };
        self.0.get(name).copied().or_else(unknown)
    }
}

/// Reads the instances and opens their assets.
pub(super) fn read_instances(at: &At<'_>, assets: &mut Assets) -> (Vec<Placed>, Names) {
    let mut instances = Vec::new();
    let mut names = Names::default();
    for item in at.items().unwrap_or_default() {
        let known = "name, asset, q, frame, joints, clip, time, rotation, translation, scale";
        let Some(fields) = item.fields(known) else {
            continue;
        };
        // Only the first of a name is the one that queries mean.
        let own_name = fields.get("name", At::text).filter(|name| {
            let is_new = !names.0.contains_key(*name);
            let message = format_args!("a second instance {name:?}");
            fields.at("name").ensure(is_new, message).is_some()
        });
        let instance = read_instance(&fields, own_name.unwrap_or_default(), assets);
        if let Some(name) = own_name {
            let index = instance.as_ref().map(|_| instances.len());
            names.0.insert(name.to_string(), index);
        }
        instances.extend(instance);
    }
    (instances, names)
}

fn read_instance(fields: &Fields<'_>, name: &str, assets: &mut Assets) -> Option<Placed> {
    let path = fields.get("asset", At::text);
    let file = path.and_then(|path| assets.open(path, &fields.at("asset")));
    let shown = read_shown(fields, file.zip(path), assets);
    let place = read_transform(fields);
    let (file, shown, mut transform) = (file?, shown?, place?);
    let Shown { q, frame, joints } = shown;
    if let Some((_, motion)) = frame {
        transform = match transform.after(motion) {
            Ok(both) => both,
            Err(error) => return fields.at("frame").fail(error),
        };
    }
    Some(Placed {
        name: name.to_string(),
        file,
        q,
        frame: frame.map(|(number, _)| number),
        joints,
        transform,
    })
}

/// A frame's number and its rigid motion.
type Moment = (u64, Transform);

/// One matrix per joint, if the scene says anything of them.
type Joints = Option<Vec<JointMatrix>>;

/// How an instance is shown.
struct Shown {
    q: Vec<f32>,
    frame: Option<Moment>,
    joints: Option<Vec<JointMatrix>>,
}

/// q and joints as the scene writes them, those of a clip at a time, or q of a frame of the asset's animation with its
/// number and rigid motion. The asset is the one with this index and path.
fn read_shown(fields: &Fields<'_>, asset: Option<(usize, &str)>, assets: &Assets) -> Option<Shown> {
    /// Frame numbers beyond this may have been others in the JSON's text: 2^53.
    const FRAME_MAX: f64 = (1_u64 << 53) as f64;
    if let Some(at) = fields.optional("time") {
        let has_clip = fields.optional("clip").is_some();
        at.ensure(has_clip, "a time is that of a clip, which is missing")?;
    }
    if let Some(at) = fields.optional("frame") {
        let has_q = fields.optional("q").is_some();
        at.ensure(!has_q, "an instance has either q or a frame")?;
        let bones = [
            ("joints", "an instance has either a frame or joints"),
            ("clip", "an instance has either a frame or a clip"),
        ];
        for (key, rule) in bones {
            at.ensure(fields.optional(key).is_none(), rule)?;
        }
        let number = at.whole(FRAME_MAX, "not a whole number from 0 on")? as u64;
        let (index, path) = asset?;
        return match frame_of(assets.file(index).asset(), path, number) {
            Ok(frame) => Some(Shown {
                q: frame.q().to_vec(),
                frame: Some((number, frame.transform())),
                joints: None,
            }),
            Err(message) => at.fail(message),
        };
    }
    let (of_clip, joints) = read_joints(fields, asset, assets)?;
    let q = fields.get_or("q", None, |at| at.all(At::number).map(Some))?;
    let (index, path) = asset?;
    if let (None, Some(q)) = (&q, of_clip) {
        return Some(Shown {
            q,
            frame: None,
            joints,
        });
    }
    let checked = checked_q(q.as_deref(), assets.file(index).asset(), path);
    let told = |problems: Vec<(Option<usize>, String)>| {
        let at = fields.at("q");
        for (mode, message) in problems {
            let place = mode.map_or(at.clone(), |mode| at.item(mode, at.json));
            place.fail::<()>(message);
        }
    };
    Some(Shown {
        q: checked.map_err(told).ok()?,
        frame: None,
        joints,
    })
}

/// q and joints of a clip at a time, or joints as the scene writes them; neither where it says nothing of them.
fn read_joints(
    fields: &Fields<'_>,
    asset: Option<(usize, &str)>,
    assets: &Assets,
) -> Option<(Option<Vec<f32>>, Joints)> {
    let (clip, joints) = (fields.optional("clip"), fields.optional("joints"));
    if let Some(at) = clip {
        at.ensure(joints.is_none(), "an instance has either joints or a clip")?;
        let (name, time) = (at.text(), fields.get_or("time", 0.0, At::number));
        let (index, path) = asset?;
        let played = joints::played(assets.file(index).model(), path, name?, time?);
        return match played {
            Ok((q, joints)) => Some((Some(q), Some(joints))),
            Err(message) => at.fail(message),
        };
    }
    let Some(at) = joints else {
        return Some((None, None));
    };
    let matrices = at.all(At::array::<12>)?;
    let (index, path) = asset?;
    if let Err(message) = joints::check_count(assets.file(index).asset(), path, matrices.len()) {
        return at.fail(message);
    }
    let rows =
        |m: [f64; 12]| [0, 1, 2].map(|r| [m[4 * r], m[4 * r + 1], m[4 * r + 2], m[4 * r + 3]]);
    Some((None, Some(matrices.into_iter().map(rows).collect())))
}

/// The placement, by the rules of [`Transform`].
fn read_transform(fields: &Fields<'_>) -> Option<Transform> {
    const TRANSLATION_MAX: f64 = (1_u128 << 80) as f64;
    const SCALE_MAX: f64 = (1_u64 << 60) as f64;
    let none = Transform::IDENTITY;
    let rotation = fields.get_or("rotation", none.rotation, At::quaternion);
    let translation = fields.get_or("translation", none.translation, |at| {
        at.ensure_all(at.array()?, |x| x.abs() <= TRANSLATION_MAX, "beyond 2^80")
    });
    let scale = fields.get_or("scale", none.scale, |at| {
        let scale = at.number()?;
        at.ensure(scale > 0.0, "not positive")?;
        let is_within = (1.0 / SCALE_MAX..=SCALE_MAX).contains(&scale);
        at.ensure(is_within, "not within 2^-60 to 2^60")?;
        Some(scale)
    });
    Some(Transform {
        rotation: rotation?,
        translation: translation?,
        scale: scale?,
    })
}
