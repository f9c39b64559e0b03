//! The scene's queries: kinds and arguments.

use bdtree_runtime::Transform;
use bdtree_runtime::narrow::Frustum;
use bdtree_runtime::query::Ray;

use super::fields::{At, Fields, Problems};
use super::frustum::read_frustum;
use super::instances::{Found, Names};
use super::rays::read_rays;

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
    /// Many rays.
    Rays {
        /// Which instance.
        instance: usize,
        /// Which of their hits are asked for.
        mode: RaysMode,
        /// Directions of any length.
        rays: Vec<Ray>,
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
    /// Whether the mesh is in sight.
    Frustum {
        /// Which instance.
        instance: usize,
        /// The planes, of normals of any length.
        frustum: Box<Frustum>,
    },
    /// The triangles within a capsule.
    Capsule {
        /// Which instance.
        instance: usize,
        /// One end of its segment.
        point1: [f64; 3],
        /// The other.
        point2: [f64; 3],
        /// Not negative.
        radius: f64,
    },
    /// The triangles that touch an oriented box.
    Box {
        /// Which instance.
        instance: usize,
        /// Centre.
        center: [f64; 3],
        /// Quaternion (x, y, z, w) within 1e-3 of unit length.
        rotation: [f64; 4],
        /// Not negative.
        half_extents: [f64; 3],
    },
    /// The pairs of triangles that touch or are near.
    Pair {
        /// First instance.
        a: usize,
        /// Another instance.
        b: usize,
        /// Not negative.
        tolerance: f64,
        /// Regions of contact are wanted.
        contacts: bool,
    },
    /// The nearest two points.
    Distance {
        /// First instance.
        a: usize,
        /// Another instance.
        b: usize,
        /// Not negative, infinite without limit.
        max_distance: f64,
    },
}

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

/// Kinds that are answered.
const KINDS: [&str; 10] = [
    "ball", "closest", "ray", "plane", "frustum", "pair", "distance", "capsule", "box", "rays",
];

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
        "rays" => {
            let known = ["instance", "origins", "directions", "mode", "max_distance"];
            read_rays(&at.fields(&known, problems)?, names, problems)
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
        "frustum" => {
            let fields = at.fields(&["instance", "planes"], problems)?;
            let instance = names.instance(&fields, "instance", problems);
            let frustum = read_frustum(&fields, problems);
            Some(Query::Frustum {
                instance: instance.index()?,
                frustum: Box::new(frustum?),
            })
        }
        "capsule" => {
            let fields = at.fields(&["instance", "point1", "point2", "radius"], problems)?;
            let instance = names.instance(&fields, "instance", problems);
            let point1 = fields.point("point1", problems);
            let point2 = fields.point("point2", problems);
            let radius = fields.length("radius", problems);
            Some(Query::Capsule {
                instance: instance.index()?,
                point1: point1?,
                point2: point2?,
                radius: radius?,
            })
        }
        "box" => {
            let known = ["instance", "center", "rotation", "half_extents"];
            let fields = at.fields(&known, problems)?;
            let instance = names.instance(&fields, "instance", problems);
            let center = fields.point("center", problems);
            let rotation = match fields.optional("rotation") {
                None => Some(Transform::IDENTITY.rotation),
                Some(_) => fields.quaternion("rotation", problems),
            };
            let half_extents = fields.lengths("half_extents", problems);
            Some(Query::Box {
                instance: instance.index()?,
                center: center?,
                rotation: rotation?,
                half_extents: half_extents?,
            })
        }
        "pair" => read_pair(
            &at.fields(&["a", "b", "tolerance", "contacts"], problems)?,
            names,
            problems,
        ),
        "distance" => read_distance(
            &at.fields(&["a", "b", "max_distance"], problems)?,
            names,
            problems,
        ),
        _ => {
            problems.add(
                &at.place,
                format_args!("unknown query kind (known: {})", KINDS.join(", ")),
            );
            None
        }
    }
}

/// An absent tolerance is 0, and contacts are not wanted.
fn read_pair(fields: &Fields<'_>, names: &Names, problems: &mut Problems) -> Option<Query> {
    let two = read_two(fields, names, problems);
    let tolerance = match fields.optional("tolerance") {
        None => Some(0.0),
        Some(_) => fields.length("tolerance", problems),
    };
    let contacts = fields.flag("contacts", problems);
    let ((a, b), tolerance, contacts) = (two?, tolerance?, contacts?);
    Some(Query::Pair {
        a,
        b,
        tolerance,
        contacts,
    })
}

fn read_distance(fields: &Fields<'_>, names: &Names, problems: &mut Problems) -> Option<Query> {
    let two = read_two(fields, names, problems);
    let max_distance = fields.limit("max_distance", problems);
    let ((a, b), max_distance) = (two?, max_distance?);
    Some(Query::Distance { a, b, max_distance })
}

/// Two different instances.
fn read_two(fields: &Fields<'_>, names: &Names, problems: &mut Problems) -> Option<(usize, usize)> {
    let a = names.instance(fields, "a", problems);
    let b = names.instance(fields, "b", problems);
    let same = match (fields.optional("a"), fields.optional("b")) {
        (Some(x), Some(y)) => x.json == y.json && a != Found::No,
        _ => false,
    };
    if same {
        problems.add(&fields.place("b"), "the same instance as a");
    }
    let (a, b) = (a.index()?, b.index()?);
    (!same).then_some((a, b))
}
