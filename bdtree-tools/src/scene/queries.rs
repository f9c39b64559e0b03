//! The scene's queries: kinds and arguments.

use bdtree_runtime::{Ball, Capsule, Cuboid, Frustum, HalfSpace, Ray, Shape, Transform};

use super::fields::{At, Fields, Problems};
use super::frustum::read_frustum;
use super::instances::{Found, Names};
use super::rays::{RaysMode, read_rays};

/// A question; instances by their index. Arguments are in the ranges that [`bdtree_runtime::Query`] and
/// [`bdtree_runtime::PairQuery`] take. World units.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Query {
    /// The triangles that a shape touches: ball, plane, capsule, box.
    Contacts {
        /// Which instance.
        instance: usize,
        /// The shape.
        shape: Shape,
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
        /// The ray, its direction of any length.
        ray: Ray,
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
    /// Whether the mesh is in sight.
    Frustum {
        /// Which instance.
        instance: usize,
        /// The planes, of normals of any length.
        frustum: Box<Frustum>,
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

impl Query {
    /// Its name in scenes and answers.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Contacts { shape, .. } => match shape {
                Shape::Ball(_) => "ball",
                Shape::Capsule(_) => "capsule",
                Shape::Cuboid(_) => "box",
                // A half-space: scenes have no other shapes.
                _ => "plane",
            },
            Self::Closest { .. } => "closest",
            Self::Ray { .. } => "ray",
            Self::Rays { .. } => "rays",
            Self::Frustum { .. } => "frustum",
            Self::Pair { .. } => "pair",
            Self::Distance { .. } => "distance",
        }
    }

    /// The instance that is asked, and the other one of a pair.
    pub fn instances(&self) -> (usize, Option<usize>) {
        match *self {
            Self::Contacts { instance, .. }
            | Self::Closest { instance, .. }
            | Self::Ray { instance, .. }
            | Self::Rays { instance, .. }
            | Self::Frustum { instance, .. } => (instance, None),
            Self::Pair { a, b, .. } | Self::Distance { a, b, .. } => (a, Some(b)),
        }
    }
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
            Some(Query::Contacts {
                instance: instance.index()?,
                shape: Ball::new(center?, radius?).into(),
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
                ray: Ray::new(origin?, direction?).with_max_distance(max_distance?),
            })
        }
        "rays" => {
            let known = ["instance", "origins", "directions", "mode", "max_distance"];
            let fields = at.fields(&known, problems)?;
            let instance = names.instance(&fields, "instance", problems);
            let (mode, rays) = read_rays(&fields, problems)?;
            Some(Query::Rays {
                instance: instance.index()?,
                mode,
                rays,
            })
        }
        "plane" => {
            let fields = at.fields(&["instance", "normal", "offset"], problems)?;
            let instance = names.instance(&fields, "instance", problems);
            let normal = fields.direction("normal", problems);
            let offset = fields.offset("offset", problems);
            Some(Query::Contacts {
                instance: instance.index()?,
                shape: HalfSpace::new(normal?, offset?).into(),
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
            Some(Query::Contacts {
                instance: instance.index()?,
                shape: Capsule::new(point1?, point2?, radius?).into(),
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
            let cuboid = Cuboid::new(center?, half_extents?).rotated(rotation?);
            Some(Query::Contacts {
                instance: instance.index()?,
                shape: cuboid.into(),
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
