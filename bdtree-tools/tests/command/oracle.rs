//! Slow twins in plain f64: every triangle is tested, by other formulas than the runtime's.

pub(crate) type Point = [f64; 3];
pub(crate) type Triangle = [Point; 3];

pub(crate) fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn norm(a: Point) -> f64 {
    dot(a, a).sqrt()
}

fn cross(a: Point, b: Point) -> Point {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn along(a: Point, t: f64, d: Point) -> Point {
    [a[0] + t * d[0], a[1] + t * d[1], a[2] + t * d[2]]
}

/// rotation·(scale·x) + translation, by the quaternion product.
pub(crate) fn placed(x: Point, rotation: [f64; 4], translation: Point, scale: f64) -> Point {
    let length = rotation.iter().map(|c| c * c).sum::<f64>().sqrt();
    let [qx, qy, qz, w] = rotation.map(|c| c / length);
    let v = [qx, qy, qz];
    let x = x.map(|c| c * scale);
    let twice = cross(v, x).map(|c| 2.0 * c);
    let turned = cross(v, twice);
    std::array::from_fn(|k| x[k] + w * twice[k] + turned[k] + translation[k])
}

fn segment_point(a: Point, b: Point, x: Point) -> f64 {
    let d = sub(b, a);
    let square = dot(d, d);
    let t = if square > 0.0 {
        (dot(sub(x, a), d) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    norm(sub(x, along(a, t, d)))
}

/// Distance of a point: to the inside where it projects there, else to the edges.
pub(crate) fn point_distance(t: &Triangle, x: Point) -> f64 {
    let edges = [(0, 1), (1, 2), (2, 0)].map(|(i, j)| segment_point(t[i], t[j], x));
    let nearest_edge = edges.into_iter().fold(f64::INFINITY, f64::min);
    let n = cross(sub(t[1], t[0]), sub(t[2], t[0]));
    let area = norm(n);
    let inside = |(i, j): (usize, usize)| dot(cross(sub(t[j], t[i]), sub(x, t[i])), n) >= 0.0;
    if area > 0.0 && [(0, 1), (1, 2), (2, 0)].into_iter().all(inside) {
        (dot(sub(x, t[0]), n) / area).abs()
    } else {
        nearest_edge
    }
}

/// Where a segment or ray from `a` along `d` (t in 0..=end) meets a triangle (Möller, Trumbore).
pub(crate) fn ray_distance(t: &Triangle, a: Point, d: Point, end: f64) -> Option<f64> {
    let (e1, e2) = (sub(t[1], t[0]), sub(t[2], t[0]));
    let p = cross(d, e2);
    let det = dot(e1, p);
    if det == 0.0 {
        return None;
    }
    let s = sub(a, t[0]);
    let u = dot(s, p) / det;
    let q = cross(s, e1);
    let v = dot(d, q) / det;
    let at = dot(e2, q) / det;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && (0.0..=end).contains(&at)).then_some(at)
}

fn segments(a: Point, b: Point, c: Point, d: Point) -> f64 {
    // The squared distance is convex in both parameters: nested golden sections would do, but
    // alternating projections from the four ends and the common perpendicular are exact enough.
    let ends = [
        segment_point(c, d, a),
        segment_point(c, d, b),
        segment_point(a, b, c),
        segment_point(a, b, d),
    ];
    let mut best = ends.into_iter().fold(f64::INFINITY, f64::min);
    let (u, v, w) = (sub(b, a), sub(d, c), sub(a, c));
    let det = dot(u, u) * dot(v, v) - dot(u, v) * dot(u, v);
    if det > 0.0 {
        let s = (dot(u, v) * dot(v, w) - dot(v, v) * dot(u, w)) / det;
        let t = (dot(u, u) * dot(v, w) - dot(u, v) * dot(u, w)) / det;
        if (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t) {
            best = best.min(norm(sub(along(a, s, u), along(c, t, v))));
        }
    }
    best
}

/// Distance of two triangles; 0 when an edge of one pierces the other.
pub(crate) fn triangle_distance(a: &Triangle, b: &Triangle) -> f64 {
    const EDGES: [(usize, usize); 3] = [(0, 1), (1, 2), (2, 0)];
    for (x, y) in [(a, b), (b, a)] {
        for (i, j) in EDGES {
            if ray_distance(y, x[i], sub(x[j], x[i]), 1.0).is_some() {
                return 0.0;
            }
        }
    }
    let mut best = f64::INFINITY;
    for k in 0..3 {
        best = best
            .min(point_distance(a, b[k]))
            .min(point_distance(b, a[k]));
    }
    for (i, j) in EDGES {
        for (k, l) in EDGES {
            best = best.min(segments(a[i], a[j], b[k], b[l]));
        }
    }
    best
}
