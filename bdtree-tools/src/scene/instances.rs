//! The scene's instances: names, assets, q and placements.

use std::collections::BTreeMap;

use bdtree_runtime::Transform;

use super::assets::Assets;
use super::fields::{At, Fields};
use crate::frames::frame_of;
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
        let known = "name, asset, q, frame, rotation, translation, scale";
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
    let (file, (q, frame), mut transform) = (file?, shown?, place?);
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
        transform,
    })
}

/// A frame's number and its rigid motion.
type Moment = (u64, Transform);

/// q as the scene writes it, or that of a frame of the asset's animation with its number and rigid motion. The
/// asset is the one with this index and path.
fn read_shown(
    fields: &Fields<'_>,
    asset: Option<(usize, &str)>,
    assets: &Assets,
) -> Option<(Vec<f32>, Option<Moment>)> {
    /// Frame numbers beyond this may have been others in the JSON's text: 2^53.
    const FRAME_MAX: f64 = (1_u64 << 53) as f64;
    if let Some(at) = fields.optional("frame") {
        let has_q = fields.optional("q").is_some();
        at.ensure(!has_q, "an instance has either q or a frame")?;
        let number = at.whole(FRAME_MAX, "not a whole number from 0 on")? as u64;
        let (index, path) = asset?;
        return match frame_of(assets.file(index).asset(), path, number) {
            Ok(frame) => Some((frame.q().to_vec(), Some((number, frame.transform())))),
            Err(message) => at.fail(message),
        };
    }
    let q = fields.get_or("q", None, |at| at.all(At::number).map(Some))?;
    let (index, path) = asset?;
    let checked = checked_q(q.as_deref(), assets.file(index).asset(), path);
    let told = |problems: Vec<(Option<usize>, String)>| {
        let at = fields.at("q");
        for (mode, message) in problems {
            let place = mode.map_or(at.clone(), |mode| at.item(mode, at.json));
            place.fail::<()>(message);
        }
    };
    Some((checked.map_err(told).ok()?, None))
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
