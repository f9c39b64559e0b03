//! Brute force: deform everything, test everything that is not plainly far away, no tree.
//!
//! The same leaf predicates as the runtime decide here, so its answers must be equal to the last
//! bit; that the predicates themselves are right is tested against exact arithmetic elsewhere.

use bdtree_runtime::narrow::{self, Frustum, FrustumState, OrientedBox, Triangle};
use bdtree_runtime::{Asset, Pose, TriangleId, VertexId};

use crate::body::{Body, Bounds};

/// All deformed triangles in the world, by id.
///
/// # Panics
/// On a corrupt asset.
pub fn deformed_triangles(asset: &Asset<'_>, pose: &Pose<'_>) -> Body {
    let vertices: Vec<[f64; 3]> = (0..asset.vertex_count() as u32)
        .map(|i| asset.deformed(pose, VertexId(i)).expect("vertex"))
        .collect();
    let corners = |id| asset.triangle(TriangleId(id)).expect("triangle");
    let triangles = (0..asset.triangle_count() as u32)
        .map(|id| corners(id).map(|v| vertices[v.0 as usize]))
        .collect();
    Body::new(triangles)
}

/// Ids of the triangles within a ball, and their distances to its centre.
pub fn ball(body: &Body, center: [f64; 3], radius: f64) -> Vec<(u32, f64)> {
    body.near(Bounds::of(&[center]), radius)
        .filter_map(|(id, t)| {
            let d = narrow::closest_point(center, t).distance;
            (d <= radius).then_some((id, d))
        })
        .collect()
}

/// Ids of the triangles within a radius of a segment, and their distances to it.
pub fn capsule(body: &Body, ends: [[f64; 3]; 2], radius: f64) -> Vec<(u32, f64)> {
    body.about(ends, radius)
        .filter_map(|(id, t)| {
            let d = narrow::segment_triangle_distance(&ends, t).distance;
            (d <= radius).then_some((id, d))
        })
        .collect()
}

/// Ids of the triangles that touch a box, and how deep they reach into it.
pub fn cuboid(body: &Body, shape: &OrientedBox) -> Vec<(u32, f64)> {
    body.near(Bounds::of_box(shape), 0.0)
        .filter_map(|(id, t)| Some((id, shape.contact(t)?.depth)))
        .collect()
}

/// Where all the triangles lie; there must be one.
pub fn frustum(triangles: &[Triangle], shape: &Frustum) -> FrustumState {
    let mut whole = shape.triangle(&triangles[0]);
    for t in triangles {
        if whole == FrustumState::Intersects || shape.triangle(t) != whole {
            whole = FrustumState::Intersects;
            break;
        }
    }
    whole
}

/// The nearest triangle's id and distance, lowest id first.
pub fn closest(body: &Body, to: [f64; 3], max_distance: f64) -> Option<(u32, f64)> {
    let mut best: Option<(u32, f64)> = None;
    let point = Bounds::of(&[to]);
    for ((id, t), bounds) in (0..).zip(&**body).zip(body.bounds()) {
        if bounds.apart(&point) > best.map_or(max_distance, |b| b.1) {
            continue;
        }
        let d = narrow::closest_point(to, t).distance;
        if d <= max_distance && best.is_none_or(|b| d < b.1) {
            best = Some((id, d));
        }
    }
    best
}

/// The first triangle along a ray and its distance, lowest id first. `direction` is unit.
pub fn ray(
    body: &Body,
    origin: [f64; 3],
    direction: [f64; 3],
    max_distance: f64,
) -> Option<(u32, f64)> {
    ray_all(body, origin, direction, max_distance)
        .into_iter()
        .min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)))
}

/// All triangles along a ray and their distances, by id. `direction` is unit.
pub fn ray_all(
    body: &Body,
    origin: [f64; 3],
    direction: [f64; 3],
    max_distance: f64,
) -> Vec<(u32, f64)> {
    let ray = narrow::Ray::new(origin, direction);
    body.along(origin, direction, max_distance)
        .filter_map(|(id, t)| Some((id, narrow::ray_hit(&ray, t, max_distance)?.t)))
        .collect()
}

/// The unit vector along `v`, to the bit as the runtime normalises.
pub fn unit(v: [f64; 3]) -> [f64; 3] {
    let largest = v.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
    let v = v.map(|c| c / largest);
    let n = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    v.map(|c| c / n)
}

/// Ids of the triangles with a vertex where normal·x ≤ offset. `normal` is unit.
pub fn plane(triangles: &[Triangle], normal: [f64; 3], offset: f64) -> Vec<u32> {
    let height = |x: &[f64; 3]| normal[0] * x[0] + normal[1] * x[1] + normal[2] * x[2];
    (0..)
        .zip(triangles)
        .filter(|(_, t)| t.iter().any(|x| height(x) <= offset))
        .map(|(id, _)| id)
        .collect()
}

/// All pairs that share a point (tolerance 0) or are within the tolerance, ascending.
pub fn pair(a: &Body, b: &Body, tolerance: f64) -> Vec<(u32, u32)> {
    let [groups_a, groups_b] = [a.groups(), b.groups()];
    let mut hits = Vec::new();
    for (around_a, ids_a) in &groups_a {
        for (around_b, ids_b) in &groups_b {
            if around_a.apart(around_b) > tolerance {
                continue;
            }
            for i in ids_a.iter().map(|i| *i as usize) {
                if a.bounds()[i].apart(around_b) > tolerance {
                    continue;
                }
                for j in ids_b.iter().map(|j| *j as usize) {
                    let is_far = a.bounds()[i].apart(&b.bounds()[j]) > tolerance;
                    if !is_far && are_within(&a[i], &b[j], tolerance) {
                        hits.push((i as u32, j as u32));
                    }
                }
            }
        }
    }
    hits.sort_unstable();
    hits
}

/// Whether two triangles share a point (tolerance 0) or are within the tolerance.
fn are_within(a: &Triangle, b: &Triangle, tolerance: f64) -> bool {
    if tolerance == 0.0 {
        narrow::triangles_intersect(a, b)
    } else {
        narrow::triangle_distance(a, b).distance <= tolerance
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{bake, poses};
    use rand::RngExt;

    /// A sphere, larger triangles through it, some without area, at this place and of this size.
    fn body(place: f64, size: f64) -> Body {
        let mesh = bake::bumpy_sphere(7, 3);
        let p = |v: u32| mesh.positions[v as usize].map(|x| place + size * x);
        let mut triangles: Vec<Triangle> = mesh.triangles.iter().map(|t| t.map(p)).collect();
        triangles.extend((0..30).map(|v| [p(v), p(2 * v), p(80 - v)]));
        triangles.extend((0..9).flat_map(|v| [[p(v); 3], [p(v), p(v), p(60)]]));
        Body::new(triangles)
    }

    fn bodies() -> Vec<(Body, f64)> {
        let kinds = [
            (0.0, 1.0),
            (1e6, 1.0),
            (-3e9, 1.0),
            (0.0, 1e-7),
            (1.0, 1e12),
        ];
        kinds.map(|(place, size)| (body(place, size), size)).into()
    }

    /// Boxes rule out nothing that the predicates let pass, least of all at exactly their distance.
    #[test]
    fn passing_over_what_is_far_changes_no_answer() {
        let mut rng = poses::rng(6);
        let mut counts = [[0; 2]; 4];
        for (body, size) in bodies() {
            let ids = || (0..).zip(&*body);
            let mut count = |kind: usize, found: usize| {
                counts[kind][0] += found;
                counts[kind][1] += body.len() - found;
            };
            for round in 0..200 {
                let some = |rng: &mut rand_pcg::Pcg64Mcg| body[rng.random_range(0..body.len())];
                let (one, two) = (some(&mut rng), some(&mut rng));
                let away = size * [0.0, 1e-9, 0.3, 3.0, 1e6][round % 5];
                let p = one[0].map(|x| x + away * rng.random_range(-1.0..1.0));
                // Along an axis, towards a corner, of no length.
                let mut q = match round % 3 {
                    0 => two[1],
                    1 => one[0],
                    _ => p,
                };
                if round % 7 == 0 {
                    q = [p[0], q[1], p[2]];
                }
                let radius = narrow::closest_point(p, &two).distance;
                let all = ids().map(|(id, t)| (id, narrow::closest_point(p, t).distance));
                let within: Vec<_> = all.clone().filter(|x| x.1 <= radius).collect();
                count(0, within.len());
                assert_eq!(ball(&body, p, radius), within);
                let least = all.min_by(|a, b| a.1.total_cmp(&b.1));
                assert_eq!(closest(&body, p, f64::INFINITY), least);
                assert_eq!(closest(&body, p, least.map_or(0.0, |x| x.1)), least);

                let apart = |t| narrow::segment_triangle_distance(&[p, q], t).distance;
                let radius = apart(&two);
                let within = ids().map(|(id, t)| (id, apart(t)));
                let within: Vec<_> = within.filter(|x| x.1 <= radius).collect();
                count(1, within.len());
                assert_eq!(capsule(&body, [p, q], radius), within);

                let direction = [0, 1, 2].map(|k| q[k] - p[k]);
                if direction != [0.0; 3] {
                    let direction = unit(direction);
                    let ray = narrow::Ray::new(p, direction);
                    let hits = |limit| -> Vec<(u32, f64)> {
                        ids()
                            .filter_map(|(id, t)| Some((id, narrow::ray_hit(&ray, t, limit)?.t)))
                            .collect()
                    };
                    let all = hits(f64::INFINITY);
                    count(2, all.len());
                    assert_eq!(ray_all(&body, p, direction, f64::INFINITY), all);
                    for (_, limit) in all {
                        assert_eq!(ray_all(&body, p, direction, limit), hits(limit));
                    }
                }

                let half = [0; 3].map(|_| away * rng.random_range(0.0..1.0));
                let rotation = poses::random_transform(0.0, &mut rng).rotation;
                let rotation = [rotation, [0.0, 0.0, 0.0, 1.0]][round % 2];
                let shape = OrientedBox::new(p, rotation, half);
                let touched = ids().filter_map(|(id, t)| Some((id, shape.contact(t)?.depth)));
                let touched: Vec<_> = touched.collect();
                count(3, touched.len());
                assert_eq!(cuboid(&body, &shape), touched);
            }
        }
        let enough = counts.iter().flatten().all(|n| *n > 1000);
        assert!(enough, "found, not found: {counts:?}");
    }

    #[test]
    fn passing_over_far_pairs_changes_no_answer() {
        for (a, size) in bodies() {
            let moved = |t: &Triangle| t.map(|x| [x[0] + 1.3 * size, x[1], x[2] + 0.7 * size]);
            let b = Body::new(a.iter().map(moved).collect());
            // Two triangles are exactly within.
            let exact = narrow::triangle_distance(&a[0], &b[50]).distance;
            for tolerance in [0.0, 1e-3 * size, exact] {
                let mut expected = Vec::new();
                for (i, ta) in (0..).zip(&*a) {
                    let with_a = (0..).zip(&*b).filter(|x| are_within(ta, x.1, tolerance));
                    expected.extend(with_a.map(|(j, _)| (i, j)));
                }
                assert_eq!(pair(&a, &b, tolerance), expected, "{tolerance}");
                assert!(!expected.is_empty() && expected.len() < a.len() * b.len());
            }
        }
    }
}
