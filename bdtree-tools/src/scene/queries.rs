//! The scene's queries: kinds and arguments.

use super::fields::{At, Fields, Problems};
use super::instances::{Found, Names};

/// A question; instances by their index. Arguments are in the ranges that
/// [`bdtree_runtime::query`] takes. World units.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Query {
    /// The triangles within a ball.
    Ball {
        /// Which instance.
        instance: usize,
        /// Centre.
        center: [f64; 3],
        /// Not negative.
        radius: f64,
    },
    /// The nearest point.
    Closest {
        /// Which instance.
        instance: usize,
        /// Nearest to this.
        point: [f64; 3],
        /// Not negative, infinite without limit.
        max_distance: f64,
    },
    /// The first hit.
    Ray {
        /// Which instance.
        instance: usize,
        /// Where it starts.
        origin: [f64; 3],
        /// Not zero, of any length.
        direction: [f64; 3],
        /// Not negative, infinite without limit.
        max_distance: f64,
    },
    /// The triangles that reach below a plane.
    Plane {
        /// Which instance.
        instance: usize,
        /// Not zero, of any length.
        normal: [f64; 3],
        /// normal·x of the plane's points, for the normalised normal.
        offset: f64,
    },
    /// The pairs of triangles that touch or are near.
    Pair {
        /// First instance.
        a: usize,
        /// Another instance.
        b: usize,
        /// Not negative.
        tolerance: f64,
    },
}

/// Kinds that are answered.
const KINDS: [&str; 5] = ["ball", "closest", "ray", "plane", "pair"];

/// Kinds that are defined but not answered yet.
const LATER: [&str; 5] = ["frustum", "distance", "capsule", "box", "rays"];

/// Reads the queries; shorter than the list when there are problems.
pub(super) fn read_queries(at: &At<'_>, names: &Names, problems: &mut Problems) -> Vec<Query> {
    let items = at.items(problems).unwrap_or_default();
    items
        .iter()
        .filter_map(|item| read_query(item, names, problems))
        .collect()
}

fn read_query(item: &At<'_>, names: &Names, problems: &mut Problems) -> Option<Query> {
    let object = item.entries(problems)?;
    let mut entries = object.iter();
    let (Some((kind, json)), None) = (entries.next(), entries.next()) else {
        let found: Vec<&str> = object.keys().map(String::as_str).collect();
        let found = if found.is_empty() {
            "none".to_string()
        } else {
            found.join(", ")
        };
        problems.add(
            &item.place,
            format_args!("expected one query kind, found {found}"),
        );
        return None;
    };
    let at = item.entry(kind, json);
    match kind.as_str() {
        "ball" => {
            let fields = at.fields(&["instance", "center", "radius"], problems)?;
            let instance = names.instance(&fields, "instance", problems);
            let center = fields.point("center", problems);
            let radius = fields.length("radius", problems);
            Some(Query::Ball {
                instance: instance.index()?,
                center: center?,
                radius: radius?,
            })
        }
        "closest" => {
            let fields = at.fields(&["instance", "point", "max_distance"], problems)?;
            let instance = names.instance(&fields, "instance", problems);
            let point = fields.point("point", problems);
            let max_distance = fields.limit("max_distance", problems);
            Some(Query::Closest {
                instance: instance.index()?,
                point: point?,
                max_distance: max_distance?,
            })
        }
        "ray" => {
            let known = ["instance", "origin", "direction", "max_distance"];
            let fields = at.fields(&known, problems)?;
            let instance = names.instance(&fields, "instance", problems);
            let origin = fields.point("origin", problems);
            let direction = fields.direction("direction", problems);
            let max_distance = fields.limit("max_distance", problems);
            Some(Query::Ray {
                instance: instance.index()?,
                origin: origin?,
                direction: direction?,
                max_distance: max_distance?,
            })
        }
        "plane" => {
            let fields = at.fields(&["instance", "normal", "offset"], problems)?;
            let instance = names.instance(&fields, "instance", problems);
            let normal = fields.direction("normal", problems);
            let offset = fields.offset("offset", problems);
            Some(Query::Plane {
                instance: instance.index()?,
                normal: normal?,
                offset: offset?,
            })
        }
        "pair" => read_pair(
            &at.fields(&["a", "b", "tolerance"], problems)?,
            names,
            problems,
        ),
        later if LATER.contains(&later) => {
            problems.add(&at.place, "not supported yet");
            None
        }
        _ => {
            problems.add(
                &at.place,
                format_args!("unknown query kind (known: {})", KINDS.join(", ")),
            );
            None
        }
    }
}

/// An absent tolerance is 0.
fn read_pair(fields: &Fields<'_>, names: &Names, problems: &mut Problems) -> Option<Query> {
    let a = names.instance(fields, "a", problems);
    let b = names.instance(fields, "b", problems);
    let same = match (fields.optional("a"), fields.optional("b")) {
        (Some(x), Some(y)) => x.json == y.json && a != Found::No,
        _ => false,
    };
    if same {
        problems.add(&fields.place("b"), "the same instance as a");
    }
    let tolerance = match fields.optional("tolerance") {
        None => Some(0.0),
        Some(_) => fields.length("tolerance", problems),
    };
    let (a, b, tolerance) = (a.index()?, b.index()?, tolerance?);
    (!same).then_some(Query::Pair { a, b, tolerance })
}
