//! What queries are about, as shapes to draw.

use bdtree_runtime::{Ball, Capsule, Cuboid, Ray, Shape as Touched};
use glam::{DQuat, DVec3};

use super::body::Content;
use crate::scene::{Query, Scene};

/// A shape (world).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Shape {
    /// A ball.
    Ball {
        /// Its center.
        center: [f64; 3],
        /// Its radius.
        radius: f64,
    },
    /// A point, drawn as a cross.
    Point([f64; 3]),
    /// A capsule.
    Capsule {
        /// The middles of its ends.
        ends: [[f64; 3]; 2],
        /// Its radius.
        radius: f64,
    },
    /// An edge of a box, from one point to another.
    Edge([[f64; 3]; 2]),
    /// A ray, cut off behind the body.
    Ray([[f64; 3]; 2]),
}

/// The shapes of a scene's queries that have one: balls, points, rays, capsules and boxes. Planes and
/// frusta have no end, and of pairs and distances both bodies are seen.
pub(super) fn shapes(scene: &Scene, content: &[Content<'_>]) -> Vec<Shape> {
    let mut shapes = Vec::new();
    for query in &scene.queries {
        match query {
            Query::Contacts { shape, .. } => match *shape {
                Touched::Ball(Ball { center, radius }) => {
                    shapes.push(Shape::Ball { center, radius })
                }
                Touched::Capsule(Capsule { a, b, radius }) => shapes.push(Shape::Capsule {
                    ends: [a, b],
                    radius,
                }),
                Touched::Cuboid(cuboid) => shapes.extend(edges(cuboid)),
                _ => {}
            },
            Query::Closest { point, .. } => shapes.push(Shape::Point(*point)),
            Query::Ray { instance, ray } => shapes.push(line(ray, &content[*instance])),
            Query::Rays { instance, rays, .. } => {
                shapes.extend(rays.iter().map(|ray| line(ray, &content[*instance])));
            }
            Query::Frustum { .. } | Query::Pair { .. } | Query::Distance { .. } => {}
        }
    }
    shapes
}

/// What shapes look like, each kind once; `None` of none.
pub(super) fn key(shapes: &[Shape]) -> Option<String> {
    type Is = fn(&Shape) -> bool;
    let kinds: [(&str, Is); 5] = [
        ("ball (ring)", |s| matches!(s, Shape::Ball { .. })),
        ("capsule (outline)", |s| matches!(s, Shape::Capsule { .. })),
        ("box (edges)", |s| matches!(s, Shape::Edge(_))),
        ("point (cross)", |s| matches!(s, Shape::Point(_))),
        ("ray (line)", |s| matches!(s, Shape::Ray(_))),
    ];
    let drawn = kinds.iter().filter(|(_, is)| shapes.iter().any(is));
    let names: Vec<&str> = drawn.map(|(name, _)| *name).collect();
    (!names.is_empty()).then(|| format!("asked about: {}", names.join(", ")))
}

/// The diagonal of a body's box.
fn size(content: &Content<'_>) -> f64 {
    let [low, high] = content.body.bounds.map(DVec3::from);
    low.distance(high)
}

/// A ray as far as it goes, or to where it has passed the body.
fn line(ray: &Ray, content: &Content<'_>) -> Shape {
    let (origin, direction) = (DVec3::from(ray.origin), DVec3::from(ray.direction));
    let [low, high] = content.body.bounds.map(DVec3::from);
    let far = origin.distance(low.midpoint(high)) + size(content);
    let length = ray.max_distance.min(far) / direction.length();
    Shape::Ray([ray.origin, (origin + length * direction).into()])
}

/// The twelve edges of a box.
fn edges(cuboid: Cuboid) -> impl Iterator<Item = Shape> {
    let turn = DQuat::from_array(cuboid.rotation).normalize();
    let half = DVec3::from(cuboid.half_extents);
    let corner = move |i: usize| {
        let sign = DVec3::from([0, 1, 2].map(|k| if i >> k & 1 == 0 { -1.0 } else { 1.0 }));
        (DVec3::from(cuboid.center) + turn * (sign * half)).to_array()
    };
    (0..8_usize).flat_map(move |i| {
        let others = (0..3).map(move |k| i | 1 << k).filter(move |j| *j != i);
        others.map(move |j| Shape::Edge([corner(i), corner(j)]))
    })
}

#[cfg(test)]
mod tests {
    use super::{Shape, key};

    #[test]
    fn a_key_names_each_kind_that_is_drawn() {
        let ray = Shape::Ray([[0.0; 3], [1.0; 3]]);
        let ball = Shape::Ball {
            center: [0.0; 3],
            radius: 1.0,
        };
        let point = Shape::Point([0.0; 3]);
        assert_eq!(key(&[]), None);
        assert_eq!(key(&[ray, ray]).as_deref(), Some("asked about: ray (line)"));
        let all = "asked about: ball (ring), point (cross), ray (line)";
        assert_eq!(key(&[ray, ball, point]).as_deref(), Some(all));
    }
}
