//! Brute force: deform everything, test everything, no tree.
//!
//! The same leaf predicates as the runtime decide here, so its answers must be equal to the last
//! bit; that the predicates themselves are right is tested against exact arithmetic elsewhere.

use bdtree_runtime::narrow::{self, Frustum, FrustumState, OrientedBox, Triangle};
use bdtree_runtime::{Asset, Pose, TriangleId, VertexId};

/// All deformed triangles in the world, by id.
///
/// # Panics
/// On a corrupt asset.
pub fn deformed_triangles(asset: &Asset<'_>, pose: &Pose<'_>) -> Vec<Triangle> {
    let vertices: Vec<[f64; 3]> = (0..asset.vertex_count() as u32)
        .map(|i| asset.deformed(pose, VertexId(i)).expect("vertex"))
        .collect();
    (0..asset.triangle_count() as u32)
        .map(|id| {
            let corners = asset.triangle(TriangleId(id)).expect("triangle");
            corners.map(|v| vertices[v.0 as usize])
        })
        .collect()
}

/// Ids of the triangles within a ball, and their distances to its centre.
pub fn ball(triangles: &[Triangle], center: [f64; 3], radius: f64) -> Vec<(u32, f64)> {
    (0..)
        .zip(triangles)
        .filter_map(|(id, t)| {
            let d = narrow::closest_point(center, t).distance;
            (d <= radius).then_some((id, d))
        })
        .collect()
}

/// Ids of the triangles within a radius of a segment, and their distances to it.
pub fn capsule(triangles: &[Triangle], ends: [[f64; 3]; 2], radius: f64) -> Vec<(u32, f64)> {
    (0..)
        .zip(triangles)
        .filter_map(|(id, t)| {
            let d = narrow::segment_triangle_distance(&ends, t).distance;
            (d <= radius).then_some((id, d))
        })
        .collect()
}

/// Ids of the triangles that touch a box, and how deep they reach into it.
pub fn cuboid(triangles: &[Triangle], shape: &OrientedBox) -> Vec<(u32, f64)> {
    (0..)
        .zip(triangles)
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
pub fn closest(triangles: &[Triangle], to: [f64; 3], max_distance: f64) -> Option<(u32, f64)> {
    (0..)
        .zip(triangles)
        .map(|(id, t)| (id, narrow::closest_point(to, t).distance))
        .filter(|(_, d)| *d <= max_distance)
        .min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)))
}

/// The first triangle along a ray and its distance, lowest id first. `direction` is unit.
pub fn ray(
    triangles: &[Triangle],
    origin: [f64; 3],
    direction: [f64; 3],
    max_distance: f64,
) -> Option<(u32, f64)> {
    ray_all(triangles, origin, direction, max_distance)
        .into_iter()
        .min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)))
}

/// All triangles along a ray and their distances, by id. `direction` is unit.
pub fn ray_all(
    triangles: &[Triangle],
    origin: [f64; 3],
    direction: [f64; 3],
    max_distance: f64,
) -> Vec<(u32, f64)> {
    let ray = narrow::Ray::new(origin, direction);
    (0..)
        .zip(triangles)
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
///
/// Sweeps along x, so that meshes of tens of thousands of triangles stay affordable; every pair
/// whose boxes come within the tolerance is tested.
pub fn pair(a: &[Triangle], b: &[Triangle], tolerance: f64) -> Vec<(u32, u32)> {
    let range = |t: &Triangle, k: usize| {
        let [x, y, z] = [t[0][k], t[1][k], t[2][k]];
        (x.min(y).min(z), x.max(y).max(z))
    };
    let mut order: Vec<u32> = (0..b.len() as u32).collect();
    order.sort_by(|i, j| {
        range(&b[*i as usize], 0)
            .0
            .total_cmp(&range(&b[*j as usize], 0).0)
    });
    let lows: Vec<f64> = order.iter().map(|i| range(&b[*i as usize], 0).0).collect();
    // Widest box of b, to know how far back to look.
    let width = b
        .iter()
        .map(|t| range(t, 0).1 - range(t, 0).0)
        .fold(0.0, f64::max);
    let margin = tolerance * (1.0 + 1e-9) + 1e-9 * width;
    let mut hits = Vec::new();
    for (i, ta) in (0..).zip(a) {
        let (low, high) = range(ta, 0);
        let start = lows.partition_point(|x| *x < low - width - 2.0 * margin);
        let end = lows.partition_point(|x| *x <= high + margin);
        for j in &order[start..end] {
            let tb = &b[*j as usize];
            let apart = (0..3).any(|k| {
                let ((l1, h1), (l2, h2)) = (range(ta, k), range(tb, k));
                l2 > h1 + margin || l1 > h2 + margin
            });
            if apart {
                continue;
            }
            let hit = if tolerance == 0.0 {
                narrow::triangles_intersect(ta, tb)
            } else {
                narrow::triangle_distance(ta, tb).distance <= tolerance
            };
            if hit {
                hits.push((i, *j));
            }
        }
    }
    hits.sort_unstable();
    hits
}
