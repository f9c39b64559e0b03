//! `query`: capsules, oriented boxes and frustums against brute force over what `deform` writes.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use crate::oracle::{Point, Triangle, dot, norm, placed, sub, triangle_distance};
use crate::query::{
    EPSILON, Signed, assert_within, away, center, directions, ids, number, two, vector, weighted,
};
use crate::support::Folder;

/// A point of a box from its axes to the world, and back.
type Box3 = (Point, [f64; 4], Point);

fn from_axes((center, rotation, _): Box3, y: Point) -> Point {
    placed(y, rotation, center, 1.0)
}

fn in_axes((center, rotation, _): Box3, x: Point) -> Point {
    let [a, b, c, w] = rotation;
    placed(sub(x, center), [-a, -b, -c, w], [0.0; 3], 1.0)
}

/// Distance of a point to the nearest face, negative outside.
fn depth(shape: Box3, x: Point) -> f64 {
    let y = in_axes(shape, x);
    (0..3)
        .map(|k| shape.2[k] - y[k].abs())
        .fold(f64::INFINITY, f64::min)
}

/// Distance of a triangle and a box, 0 where they touch: to its twelve face triangles, or a
/// corner inside.
fn box_distance(shape: Box3, t: &Triangle) -> f64 {
    if t.iter().any(|x| depth(shape, *x) >= 0.0) {
        return 0.0;
    }
    let mut best = f64::INFINITY;
    for axis in 0..3 {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [-1.0, 1.0] {
            let corner = |u: f64, v: f64| {
                let mut y = shape.2;
                y[axis] *= side;
                y[i] *= u;
                y[j] *= v;
                from_axes(shape, y)
            };
            let [a, b, c, d] =
                [(-1., -1.), (1., -1.), (1., 1.), (-1., 1.)].map(|(u, v)| corner(u, v));
            best = best
                .min(triangle_distance(t, &[a, b, c]))
                .min(triangle_distance(t, &[a, c, d]));
        }
    }
    best
}

/// Negative for triangles that surely touch: those that touch a box a little smaller.
fn box_signed(shape: Box3, t: &Triangle) -> f64 {
    let smaller = shape.2.map(|h| h - 1e-9);
    if box_distance((shape.0, shape.1, smaller), t) == 0.0 {
        return -1.0;
    }
    box_distance(shape, t)
}

/// The contacts of a line, in the order of its triangles, each on its triangle.
fn contacts<'l>(line: &'l Value, triangles: &[Triangle]) -> Vec<(&'l Value, Triangle)> {
    assert_eq!(line.as_object().unwrap().len(), 4, "{line}");
    let contacts = line["contacts"].as_array().unwrap();
    let order: Vec<usize> = contacts
        .iter()
        .map(|c| c["triangle"].as_u64().unwrap() as usize)
        .collect();
    assert_eq!(order, ids(line).into_iter().collect::<Vec<_>>());
    let with_triangle = contacts.iter().zip(order).map(|(contact, id)| {
        assert_eq!(contact.as_object().unwrap().len(), 5, "{contact}");
        let triangle = triangles[id];
        let same = weighted(&triangle, vector(&contact["barycentric"]));
        let gap = norm(sub(vector(&contact["point"]), same));
        assert!(gap < EPSILON, "{contact}");
        let length = norm(vector(&contact["normal"]));
        assert!((length - 1.0).abs() < EPSILON, "{contact}");
        assert!(number(&contact["dist"]) <= 0.0, "{contact}");
        (contact, triangle)
    });
    with_triangle.collect()
}

#[test]
fn capsules_find_what_brute_force_finds() {
    let folder = Folder::new();
    let [a, b] = two(&folder);
    let middle = center(&a);
    let mut queries = Vec::new();
    let mut tests: Vec<Signed> = Vec::new();
    for (i, d) in directions(40).enumerate() {
        let across = away(middle, 2.0, [d[1], d[2], d[0]]);
        let point2 = away(middle, 1.4, d);
        // Through the body, a ball, beside it.
        let point1 = [across, point2, away(point2, 5.0, [-d[2], d[0], d[1]])][i % 3];
        let radius = 0.1 * (i % 5) as f64;
        queries.push(
            json!({"capsule": {"instance": "a", "point1": point1, "point2": point2,
                                        "radius": radius}}),
        );
        tests.push(Box::new(move |t| {
            triangle_distance(t, &[point1, point2, point2]) - radius
        }));
    }
    let scene = json!({"instances": [b.json, a.json], "queries": queries});
    let lines = folder.query(&scene, &[]);
    let (mut seen, mut pierced) = (0, 0);
    for (i, (line, signed)) in lines.iter().zip(&tests).enumerate() {
        assert_eq!(
            (&line["query"], &line["kind"]),
            (&json!(i), &json!("capsule"))
        );
        // A distance of 0 is decided exactly, the oracle's is not.
        let radius = number(&queries[i]["capsule"]["radius"]);
        if radius > 0.0 {
            assert_within(&ids(line), a.triangles.iter().map(signed));
        }
        for (contact, triangle) in contacts(line, &a.triangles) {
            seen += 1;
            let dist = number(&contact["dist"]);
            let (normal, point) = (vector(&contact["normal"]), vector(&contact["point"]));
            assert!((dist - signed(&triangle)).abs() < EPSILON, "{contact}");
            let gap = dist + radius;
            if gap > 1e-3 {
                // The segment's nearest point: as near as that to the segment.
                let near = away(point, gap, normal);
                let capsule = &queries[i]["capsule"];
                let ends = [vector(&capsule["point1"]), vector(&capsule["point2"])];
                let off = triangle_distance(&[near; 3], &[ends[0], ends[1], ends[1]]);
                assert!(off < EPSILON, "{contact}: {off}");
            } else {
                pierced += 1;
            }
        }
    }
    assert!(
        seen > 250 && pierced > 5,
        "the scene tests little: {seen} {pierced}"
    );
}

#[test]
fn boxes_find_what_brute_force_finds() {
    let folder = Folder::new();
    let [a, b] = two(&folder);
    let middle = center(&a);
    let mut queries = Vec::new();
    let mut shapes: Vec<Box3> = Vec::new();
    for (i, d) in directions(40).enumerate() {
        let rotation = [[0.0, 0.0, 0.0, 1.0], [0.1, -0.2, 0.3, 0.9273618495495704]][i % 2];
        let half = [0.2, 0.05 * (i % 5) as f64 + 0.01, 0.5];
        let shape: Box3 = (away(middle, 1.4, d), rotation, half);
        let mut query = json!({"instance": "a", "center": shape.0, "half_extents": half});
        if i % 2 == 1 {
            query["rotation"] = json!(rotation);
        }
        queries.push(json!({"box": query}));
        shapes.push(shape);
    }
    let scene = json!({"instances": [b.json, a.json], "queries": queries});
    let lines = folder.query(&scene, &[]);
    let mut seen = 0;
    for (i, (line, &shape)) in lines.iter().zip(&shapes).enumerate() {
        assert_eq!((&line["query"], &line["kind"]), (&json!(i), &json!("box")));
        let found = ids(line);
        assert_within(&found, a.triangles.iter().map(|t| box_signed(shape, t)));
        for (contact, triangle) in contacts(line, &a.triangles) {
            seen += 1;
            let (point, deep) = (vector(&contact["point"]), -number(&contact["dist"]));
            assert!((depth(shape, point) - deep).abs() < EPSILON, "{contact}");
            // No point of the triangle is deeper.
            for u in 0..=12 {
                for v in 0..=12 - u {
                    let weights = [u, v, 12 - u - v].map(|w| f64::from(w) / 12.0);
                    let other = depth(shape, weighted(&triangle, weights));
                    assert!(other <= deep + EPSILON, "{contact}: {weights:?}");
                }
            }
            // Against the normal by the depth: on a face.
            let normal = vector(&contact["normal"]);
            let on_face = depth(shape, away(point, -deep, normal));
            assert!(on_face.abs() < EPSILON, "{contact}");
            assert!(
                depth(shape, away(point, 1e-3, normal)) > deep - 1.1e-3,
                "{contact}"
            );
        }
    }
    assert!(seen > 200, "the scene tests little: {seen}");
}

#[test]
fn frustums_say_where_the_mesh_is() {
    let folder = Folder::new();
    let [a, b] = two(&folder);
    let middle = center(&b);
    let mut queries = Vec::new();
    let mut heights: Vec<Vec<[f64; 3]>> = Vec::new();
    for (i, d) in directions(60).enumerate() {
        // A wedge that looks at the body, past it or away from it, from inside or outside.
        let eye = away(middle, [0.3, 2.0, 6.0][i % 3], d);
        let side = [d[1], d[2], d[0]];
        let spread = [0.2, 0.5, 1.5][i / 3 % 3];
        let looks = [-1.0, 1.0, -0.9][i / 9 % 3];
        let planes: Vec<[f64; 4]> = [1.0, -1.0]
            .map(|s| {
                let n = away(d.map(|x| spread * looks * x), s, side);
                [n[0], n[1], n[2], -dot(n, eye)].map(|x| 7.0 * x)
            })
            .to_vec();
        let above = |t: &Triangle, p: &[f64; 4]| t.map(|x| dot([p[0], p[1], p[2]], x) + p[3]);
        for t in &b.triangles {
            heights.push(planes.iter().map(|p| above(t, p)).collect());
        }
        queries.push(json!({"frustum": {"instance": "b", "planes": planes}}));
    }
    let scene = json!({"instances": [a.json, b.json], "queries": queries});
    let lines = folder.query(&scene, &["--stats"]);
    let mut seen = BTreeSet::new();
    for (i, line) in lines.iter().enumerate() {
        assert_eq!(
            (&line["query"], &line["kind"]),
            (&json!(i), &json!("frustum"))
        );
        assert_eq!(line.as_object().unwrap().len(), 4, "{line}");
        assert!(line["nodes_visited"].as_u64().unwrap() > 0);
        let count = b.triangles.len();
        let triangles = &heights[i * count..(i + 1) * count];
        let corners = || {
            triangles
                .iter()
                .flat_map(|t| (0..3).map(move |k| t.iter().map(move |h| h[k])))
        };
        let all_inside = corners().all(|mut h| h.all(|h| h > EPSILON));
        let one_inside = corners().any(|mut h| h.all(|h| h > EPSILON));
        let one_outside = corners().any(|mut h| h.any(|h| h < -EPSILON));
        let beyond = |t: &Vec<[f64; 3]>| t.iter().any(|h| h.iter().all(|h| *h < -EPSILON));
        let all_beyond = triangles.iter().all(beyond);
        let state = line["state"].as_str().unwrap();
        match state {
            "inside" => assert!(!one_outside, "{line}"),
            "outside" => assert!(!one_inside, "{line}"),
            _ => assert!(
                state == "intersects" && !all_inside && !all_beyond,
                "{line}"
            ),
        }
        seen.insert(state);
    }
    assert_eq!(seen.len(), 3, "the scene tests little: {seen:?}");
}
