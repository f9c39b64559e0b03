//! Many rays of a scene: origins, directions and what is asked of them.

use bdtree_runtime::Ray;

use super::fields::{At, Fields, Problems};

/// Which hits of a ray are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RaysMode {
    /// The first one.
    First,
    /// All.
    All,
    /// Whether there is one.
    Any,
}

/// The rays and what is asked of them; an absent mode is `first`.
pub(super) fn read_rays(
    fields: &Fields<'_>,
    problems: &mut Problems,
) -> Option<(RaysMode, Vec<Ray>)> {
    let origins = read_all(fields, "origins", At::point, problems);
    let directions = read_all(fields, "directions", At::direction, problems);
    let mode = match fields.optional("mode") {
        None => Some(RaysMode::First),
        Some(at) => match fields.text("mode", problems) {
            None => None,
            Some("first") => Some(RaysMode::First),
            Some("all") => Some(RaysMode::All),
            Some("any") => Some(RaysMode::Any),
            Some(mode) => {
                let message = format!("unknown mode {mode:?} (known: first, all, any)");
                problems.add(&at.place, message);
                None
            }
        },
    };
    let max_distance = fields.limit("max_distance", problems);
    let (origins, directions) = (origins?, directions?);
    if origins.len() != directions.len() {
        let (expected, found) = (origins.len(), directions.len());
        problems.add(
            &fields.place("directions"),
            format_args!("expected {expected}, one for each of origins, found {found}"),
        );
        return None;
    }
    let (mode, max_distance) = (mode?, max_distance?);
    let rays = origins.into_iter().zip(directions);
    let ray = |(origin, direction)| Ray::new(origin, direction).with_max_distance(max_distance);
    Some((mode, rays.map(ray).collect()))
}

/// The items of a list that must be there, when all of them are sound.
fn read_all<'j>(
    fields: &Fields<'j>,
    key: &str,
    read: impl Fn(&At<'j>, &mut Problems) -> Option<[f64; 3]>,
    problems: &mut Problems,
) -> Option<Vec<[f64; 3]>> {
    let items = fields.required(key, problems)?.items(problems)?;
    let sound: Vec<[f64; 3]> = items.iter().filter_map(|at| read(at, problems)).collect();
    (sound.len() == items.len()).then_some(sound)
}
