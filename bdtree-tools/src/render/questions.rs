//! What queries ask about, as shapes to draw.

use bdtree_runtime::{Ball, Capsule, Cuboid, Ray, Shape as Touched};

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
    /// A line from one point to another.
    Line([[f64; 3]; 2]),
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
                Touched::Capsule(Capsule { a, b, radius }) => {
                    shapes.extend([a, b].map(|center| Shape::Ball { center, radius }));
                    shapes.push(Shape::Line([a, b]));
                }
                Touched::Cuboid(cuboid) => shapes.extend(edges(cuboid)),
                _ => {}
            },
            Query::Closest {
                instance, point, ..
            } => shapes.push(Shape::Ball {
                center: *point,
                radius: 0.01 * size(&content[*instance]),
            }),
            Query::Ray { instance, ray } => shapes.push(line(ray, &content[*instance])),
            Query::Rays { instance, rays, .. } => {
                shapes.extend(rays.iter().map(|ray| line(ray, &content[*instance])));
            }
            Query::Frustum { .. } | Query::Pair { .. } | Query::Distance { .. } => {}
        }
    }
    shapes
}

/// The diagonal of a body's box.
fn size(content: &Content<'_>) -> f64 {
    let [low, high] = content.body.bounds;
    (0..3)
        .map(|k| (high[k] - low[k]).powi(2))
        .sum::<f64>()
        .sqrt()
}

/// A ray as far as it goes, or to where it has passed the body.
fn line(ray: &Ray, content: &Content<'_>) -> Shape {
    let Ray {
        origin,
        direction,
        max_distance,
    } = *ray;
    let [low, high] = content.body.bounds;
    let to_middle = (0..3).map(|k| (0.5 * (low[k] + high[k]) - origin[k]).powi(2));
    let far = to_middle.sum::<f64>().sqrt() + size(content);
    let n = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
    let length = max_distance.min(far) / n;
    Shape::Ray([origin, [0, 1, 2].map(|k| origin[k] + length * direction[k])])
}

/// The twelve edges of a box.
fn edges(cuboid: Cuboid) -> impl Iterator<Item = Shape> {
    let Cuboid {
        center,
        rotation: [x, y, z, w],
        half_extents: half,
    } = cuboid;
    let n = x * x + y * y + z * z + w * w;
    let s = 2.0 / n;
    let rows = [
        [
            1.0 - s * (y * y + z * z),
            s * (x * y - z * w),
            s * (x * z + y * w),
        ],
        [
            s * (x * y + z * w),
            1.0 - s * (x * x + z * z),
            s * (y * z - x * w),
        ],
        [
            s * (x * z - y * w),
            s * (y * z + x * w),
            1.0 - s * (x * x + y * y),
        ],
    ];
    let corner = move |i: usize| {
        let local = [0, 1, 2].map(|k| if i >> k & 1 == 0 { -half[k] } else { half[k] });
        [0, 1, 2].map(|i| center[i] + (0..3).map(|k| rows[i][k] * local[k]).sum::<f64>())
    };
    (0..8_usize).flat_map(move |i| {
        let others = (0..3).map(move |k| i | 1 << k).filter(move |j| *j != i);
        others.map(move |j| Shape::Line([corner(i), corner(j)]))
    })
}
