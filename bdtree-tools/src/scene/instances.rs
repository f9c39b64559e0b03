//! The scene's instances: names, assets, q and placements.

use std::collections::BTreeMap;

use bdtree_runtime::Transform;

use super::assets::Assets;
use super::fields::{At, Fields, Problems};
use super::shown::read_shown;

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

/// The names that queries may use.
#[derive(Debug, Default)]
pub(super) struct Names {
    /// Place in the list by name, for instances without problems.
    index: BTreeMap<String, Option<usize>>,
}

impl Names {
    /// Names of sound instances, in order.
    #[cfg(test)]
    pub(super) fn of(names: &[&str]) -> Self {
        let entry = |(i, name): (usize, &&str)| (name.to_string(), Some(i));
        Self {
            index: names.iter().enumerate().map(entry).collect(),
        }
    }

    /// The instance that a field names.
    pub(super) fn instance(
        &self,
        fields: &Fields<'_>,
        key: &str,
        problems: &mut Problems,
    ) -> Found {
        let Some(name) = fields.text(key, problems) else {
            return Found::No;
        };
        match self.index.get(name) {
            Some(Some(index)) => Found::Sound(*index),
            Some(None) => Found::Broken,
            None => {
                problems.add(
                    &fields.place(key),
                    format_args!("unknown instance {name:?}"),
                );
                Found::No
            }
        }
    }
}

/// What a name leads to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Found {
    /// An instance, by its index.
    Sound(usize),
    /// An instance whose problems are already noted.
    Broken,
    /// Nothing; the problem is noted.
    No,
}

impl Found {
    /// The index, if the instance is sound.
    pub(super) fn index(self) -> Option<usize> {
        match self {
            Self::Sound(index) => Some(index),
            Self::Broken | Self::No => None,
        }
    }
}

/// Reads the instances and opens their assets.
pub(super) fn read_instances(
    at: &At<'_>,
    assets: &mut Assets,
    problems: &mut Problems,
) -> (Vec<Placed>, Names) {
    let mut instances = Vec::new();
    let mut names = Names::default();
    for item in at.items(problems).unwrap_or_default() {
        let known = [
            "name",
            "asset",
            "q",
            "frame",
            "rotation",
            "translation",
            "scale",
        ];
        let Some(fields) = item.fields(&known, problems) else {
            continue;
        };
        let name = fields.text("name", problems);
        let duplicate = name.is_some_and(|name| names.index.contains_key(name));
        if let Some(name) = name
            && duplicate
        {
            problems.add(
                &fields.place("name"),
                format_args!("a second instance {name:?}"),
            );
        }
        let instance = read_instance(&fields, name.unwrap_or_default(), assets, problems);
        if let Some(name) = name
            && !duplicate
        {
            let index = instance.as_ref().map(|_| instances.len());
            names.index.insert(name.to_string(), index);
        }
        instances.extend(instance);
    }
    (instances, names)
}

fn read_instance(
    fields: &Fields<'_>,
    name: &str,
    assets: &mut Assets,
    problems: &mut Problems,
) -> Option<Placed> {
    let path = fields.text("asset", problems);
    let asset = path.and_then(|path| assets.open(path, &fields.place("asset"), problems));
    let shown = read_shown(fields, asset.zip(path), assets, problems);
    let place = read_transform(fields, problems);
    let (asset, shown, mut transform) = (asset?, shown?, place?);
    if let Some((_, motion)) = shown.frame {
        match transform.after(motion) {
            Ok(both) => transform = both,
            Err(error) => {
                problems.add(&fields.place("frame"), error);
                return None;
            }
        }
    }
    Some(Placed {
        name: name.to_string(),
        file: asset,
        q: shown.q,
        frame: shown.frame.map(|(number, _)| number),
        transform,
    })
}

/// The placement, by the rules of [`Transform`].
fn read_transform(fields: &Fields<'_>, problems: &mut Problems) -> Option<Transform> {
    const TRANSLATION_MAX: f64 = (1_u128 << 80) as f64;
    const SCALE_MAX: f64 = (1_u64 << 60) as f64;
    let before = problems.count();
    let mut transform = Transform::IDENTITY;
    if fields.optional("rotation").is_some()
        && let Some(rotation) = fields.quaternion("rotation", problems)
    {
        transform.rotation = rotation;
    }
    if fields.optional("translation").is_some()
        && let Some(translation) = fields.array::<3>("translation", problems)
    {
        transform.translation = translation;
        if let Some(axis) = translation.iter().position(|x| x.abs() > TRANSLATION_MAX) {
            let place = format!("{}[{axis}]", fields.place("translation"));
            problems.add(&place, "beyond 2^80");
        }
    }
    if let Some(at) = fields.optional("scale")
        && let Some(scale) = at.number(problems)
    {
        transform.scale = scale;
        if scale <= 0.0 {
            problems.add(&at.place, "not positive");
        } else if !(1.0 / SCALE_MAX..=SCALE_MAX).contains(&scale) {
            problems.add(&at.place, "not within 2^-60 to 2^60");
        }
    }
    (problems.count() == before).then_some(transform)
}
