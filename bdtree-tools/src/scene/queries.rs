//! The scene's queries: kinds and arguments.

use bdtree_runtime::narrow::frustum_triangle::FRUSTUM_PLANES_MAX;
use bdtree_runtime::{Ball, Capsule, Cuboid, Frustum, HalfSpace, Ray, Shape, Transform};

use super::fields::{At, Fields};
use super::instances::Names;

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

/// A query; instances by their index. Arguments are in the ranges that [`bdtree_runtime::Query`] and
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

/// Kinds that are answered, and their fields.
const KINDS: [(&str, &str); 10] = [
    ("ball", "instance, center, radius"),
    ("closest", "instance, point, max_distance"),
    ("ray", "instance, origin, direction, max_distance"),
    ("plane", "instance, normal, offset"),
    ("frustum", "instance, planes"),
    ("pair", "a, b, tolerance, contacts"),
    ("distance", "a, b, max_distance"),
    ("capsule", "instance, point1, point2, radius"),
    ("box", "instance, center, rotation, half_extents"),
    ("rays", "instance, origins, directions, mode, max_distance"),
];

/// Reads the queries; shorter than the list when there are problems.
pub(super) fn read_queries(at: &At<'_>, names: &Names) -> Vec<Query> {
    let items = at.items().unwrap_or_default();
    let read = |item: &At<'_>| read_query(item, names);
    items.iter().filter_map(read).collect()
}

fn read_query(item: &At<'_>, names: &Names) -> Option<Query> {
    let object = item.entries()?;
    let mut entries = object.iter();
    let (Some((kind, json)), None) = (entries.next(), entries.next()) else {
        let found: Vec<&str> = object.keys().map(String::as_str).collect();
        let found = if found.is_empty() {
            "none".to_string()
        } else {
            found.join(", ")
        };
        return item.fail(format_args!("expected one query kind, found {found}"));
    };
    let at = item.entry(kind, json);
    let Some((_, known)) = KINDS.iter().find(|(name, _)| name == kind) else {
        let known = KINDS.map(|(name, _)| name).join(", ");
        return at.fail(format_args!("unknown query kind (known: {known})"));
    };
    let fields = at.fields(known)?;
    // All fields are read before any of them is missed: every problem is told.
    if matches!(kind.as_str(), "pair" | "distance") {
        return read_pair(kind, &fields, names);
    }
    let instance = names.instance(&fields, "instance").flatten();
    let touched = |shape: Shape| {
        let instance = instance?;
        Some(Query::Contacts { instance, shape })
    };
    match kind.as_str() {
        "ball" => {
            let center = fields.get("center", At::point);
            let radius = fields.get("radius", At::length);
            touched(Ball::new(center?, radius?).into())
        }
        "plane" => {
            let normal = fields.get("normal", At::direction);
            let offset = fields.get("offset", At::offset);
            touched(HalfSpace::new(normal?, offset?).into())
        }
        "capsule" => {
            let point1 = fields.get("point1", At::point);
            let point2 = fields.get("point2", At::point);
            let radius = fields.get("radius", At::length);
            touched(Capsule::new(point1?, point2?, radius?).into())
        }
        "box" => {
            let center = fields.get("center", At::point);
            let unturned = Transform::IDENTITY.rotation;
            let rotation = fields.get_or("rotation", unturned, At::quaternion);
            let half_extents = fields.get("half_extents", At::lengths);
            let cuboid = Cuboid::new(center?, half_extents?).rotated(rotation?);
            touched(cuboid.into())
        }
        "closest" => {
            let point = fields.get("point", At::point);
            let max_distance = fields.limit("max_distance");
            Some(Query::Closest {
                instance: instance?,
                point: point?,
                max_distance: max_distance?,
            })
        }
        "ray" => {
            let origin = fields.get("origin", At::point);
            let direction = fields.get("direction", At::direction);
            let max_distance = fields.limit("max_distance");
            Some(Query::Ray {
                instance: instance?,
                ray: Ray::new(origin?, direction?).with_max_distance(max_distance?),
            })
        }
        "frustum" => {
            let frustum = fields.get("planes", read_frustum);
            Some(Query::Frustum {
                instance: instance?,
                frustum: Box::new(frustum?),
            })
        }
        _ => {
            let (mode, rays) = read_rays(&fields)?;
            Some(Query::Rays {
                instance: instance?,
                mode,
                rays,
            })
        }
    }
}

/// Of two different instances; an absent tolerance is 0, and contacts are not wanted.
fn read_pair(kind: &str, fields: &Fields<'_>, names: &Names) -> Option<Query> {
    let a = names.instance(fields, "a");
    let b = names.instance(fields, "b");
    // A name that leads nowhere has its own problem.
    let same = a.is_some() && fields.at("a").json == fields.at("b").json;
    let differ = fields.at("b").ensure(!same, "the same instance as a");
    let two = differ.and(a.flatten().zip(b.flatten()));
    if kind == "distance" {
        let max_distance = fields.limit("max_distance");
        let ((a, b), max_distance) = (two?, max_distance?);
        return Some(Query::Distance { a, b, max_distance });
    }
    let tolerance = fields.get_or("tolerance", 0.0, At::length);
    let contacts = fields.get_or("contacts", false, At::flag);
    let ((a, b), tolerance, contacts) = (two?, tolerance?, contacts?);
    Some(Query::Pair {
        a,
        b,
        tolerance,
        contacts,
    })
}

/// The rays and what is asked of them; an absent mode is `first`.
fn read_rays(fields: &Fields<'_>) -> Option<(RaysMode, Vec<Ray>)> {
    let origins = fields.get("origins", |at| at.all(At::point));
    let directions = fields.get("directions", |at| at.all(At::direction));
    let mode = fields.get_or("mode", RaysMode::First, |at| match at.text()? {
        "first" => Some(RaysMode::First),
        "all" => Some(RaysMode::All),
        "any" => Some(RaysMode::Any),
        mode => at.fail(format_args!(
            "unknown mode {mode:?} (known: first, all, any)"
        )),
    });
    let max_distance = fields.limit("max_distance");
    let (origins, directions) = (origins?, directions?);
    let (expected, found) = (origins.len(), directions.len());
    let message = format_args!("expected {expected}, one for each of origins, found {found}");
    fields.at("directions").ensure(expected == found, message)?;
    let max_distance = max_distance?;
    let rays = origins.into_iter().zip(directions);
    let ray = |(origin, direction)| Ray::new(origin, direction).with_max_distance(max_distance);
    Some((mode?, rays.map(ray).collect()))
}

/// Planes `[n_x, n_y, n_z, d]`, from 1 to [`FRUSTUM_PLANES_MAX`].
fn read_frustum(at: &At<'_>) -> Option<Frustum> {
    let found = at.items()?.len();
    let message = format_args!("expected 1 to {FRUSTUM_PLANES_MAX} planes, found {found}");
    at.ensure((1..=FRUSTUM_PLANES_MAX).contains(&found), message)?;
    let planes = at.all(|item| {
        let plane: [f64; 4] = item.array()?;
        item.ensure(plane[..3] != [0.0; 3], "zero vector")?;
        let is_near = Frustum::new(&[plane]).is_some();
        item.ensure(is_near, "farther than 2^100 from the origin")?;
        Some(plane)
    });
    Frustum::new(&planes?)
}
