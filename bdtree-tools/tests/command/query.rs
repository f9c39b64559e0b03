//! `query`: fields of every kind, and answers against brute force over what `deform` writes.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use crate::oracle::{
    Point, Triangle, dot, norm, placed, point_distance, ray_distance, sub, triangle_distance,
};
use crate::support::{Folder, ball_mesh};

/// Rounding of the oracles and of the runtime's own f64: far above both at coordinates below
/// 100, far below the mesh.
pub(crate) const EPSILON: f64 = 1e-10;

/// Distance beyond what a query looks for; at most 0: it reports the triangle.
pub(crate) type Signed = Box<dyn Fn(&Triangle) -> f64>;

/// A placed, deformed instance, as JSON and as triangles.
pub(crate) struct Instance {
    pub(crate) json: Value,
    pub(crate) triangles: Vec<Triangle>,
}

fn instance(folder: &Folder, name: &str, q: [f64; 3], at: ([f64; 4], Point, f64)) -> Instance {
    let q_text = q.map(|x| x.to_string()).join(",");
    let positions: Vec<Point> = folder
        .deformed("a.bdt", &q_text)
        .into_iter()
        .map(|x| placed(x, at.0, at.1, at.2))
        .collect();
    let corners = |t: &[u32; 3]| t.map(|i| positions[i as usize]);
    Instance {
        json: json!({"name": name, "asset": "a.bdt", "q": q, "rotation": at.0,
                     "translation": at.1, "scale": at.2}),
        triangles: ball_mesh().triangles.iter().map(corners).collect(),
    }
}

/// Two instances of the same asset that overlap.
pub(crate) fn two(folder: &Folder) -> [Instance; 2] {
    let turned = [0.1, -0.2, 0.3, 0.9273618495495704];
    [
        instance(
            folder,
            "a",
            [0.7, -0.4, 1.1],
            (turned, [-4.0, 3.0, 2.0], 1.5),
        ),
        instance(
            folder,
            "b",
            [-0.9, 0.6, 0.0],
            (turned, [-3.5, 3.4, 1.6], 1.4),
        ),
    ]
}

pub(crate) fn center(instance: &Instance) -> Point {
    let corners = instance.triangles.as_flattened();
    let sum = corners
        .iter()
        .fold([0.0; 3], |s, x| [s[0] + x[0], s[1] + x[1], s[2] + x[2]]);
    sum.map(|x| x / corners.len() as f64)
}

/// Even spread over directions: a lattice on the sphere.
pub(crate) fn directions(n: usize) -> impl Iterator<Item = Point> {
    (0..n).map(move |i| {
        let z = 1.0 - (2 * i + 1) as f64 / n as f64;
        let phi = i as f64 * 2.399_963_229_728_653;
        let r = (1.0 - z * z).sqrt();
        [r * phi.cos(), r * phi.sin(), z]
    })
}

pub(crate) fn away(from: Point, distance: f64, d: Point) -> Point {
    [0, 1, 2].map(|k| from[k] + distance * d[k])
}

pub(crate) fn ids(line: &Value) -> BTreeSet<usize> {
    let list: Vec<usize> = serde_json::from_value(line["triangles"].clone()).expect("ids");
    assert!(list.is_sorted_by(|a, b| a < b), "{list:?}");
    list.into_iter().collect()
}

pub(crate) fn vector(value: &Value) -> Point {
    serde_json::from_value(value.clone()).expect("three numbers")
}

pub(crate) fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// Everything surely within is there, everything surely outside is not.
pub(crate) fn assert_within(found: &BTreeSet<usize>, distances: impl Iterator<Item = f64>) {
    for (id, distance) in distances.enumerate() {
        if distance < -EPSILON {
            assert!(found.contains(&id), "{id} is missing: {distance}");
        }
        if distance > EPSILON {
            assert!(!found.contains(&id), "{id} is too much: {distance}");
        }
    }
}

/// The point that barycentric weights give.
pub(crate) fn weighted(t: &Triangle, weights: Point) -> Point {
    [0, 1, 2].map(|k| (0..3).map(|i| weights[i] * t[i][k]).sum())
}

#[test]
fn balls_and_planes_find_what_brute_force_finds() {
    let folder = Folder::new();
    let [a, b] = two(&folder);
    let middle = center(&a);
    let mut queries = Vec::new();
    let mut tests: Vec<Signed> = Vec::new();
    for (i, d) in directions(40).enumerate() {
        let (center, radius) = (away(middle, 1.4, d), 0.2 * (i % 7) as f64);
        queries.push(json!({"ball": {"instance": "a", "center": center, "radius": radius}}));
        tests.push(Box::new(move |t| point_distance(t, center) - radius));
        let offset = dot(d, middle) - 1.5 + 0.1 * i as f64;
        let normal = d.map(|x| 3.0 * x);
        queries.push(json!({"plane": {"instance": "a", "normal": normal, "offset": offset}}));
        tests.push(Box::new(move |t| {
            t.iter().map(|x| dot(d, *x)).fold(f64::INFINITY, f64::min) - offset
        }));
    }
    let scene = json!({"instances": [b.json, a.json], "queries": queries});
    let lines = folder.query(&scene, &[]);
    assert_eq!(lines.len(), tests.len());
    let mut contacts_seen = 0;
    for (i, (line, signed)) in lines.iter().zip(&tests).enumerate() {
        let kind = ["ball", "plane"][i % 2];
        assert_eq!((&line["query"], &line["kind"]), (&json!(i), &json!(kind)));
        assert_eq!(line.as_object().unwrap().len(), 4, "{line}");
        let found = ids(line);
        assert_within(&found, a.triangles.iter().map(signed));
        let contacts = line["contacts"].as_array().unwrap();
        let order: Vec<usize> = contacts
            .iter()
            .map(|c| c["triangle"].as_u64().unwrap() as usize)
            .collect();
        assert_eq!(order, found.into_iter().collect::<Vec<_>>());
        for contact in contacts {
            contacts_seen += 1;
            assert_eq!(contact.as_object().unwrap().len(), 5, "{contact}");
            let triangle = &a.triangles[contact["triangle"].as_u64().unwrap() as usize];
            let (dist, point) = (number(&contact["dist"]), vector(&contact["point"]));
            assert!(
                dist <= 0.0 && (dist - signed(triangle)).abs() < EPSILON,
                "{contact}"
            );
            let same = weighted(triangle, vector(&contact["barycentric"]));
            assert!(norm(sub(point, same)) < EPSILON, "{contact}");
            let normal = vector(&contact["normal"]);
            assert!((norm(normal) - 1.0).abs() < EPSILON, "{contact}");
            if kind == "ball" && dist + number(&queries[i]["ball"]["radius"]) > 1e-3 {
                let center = vector(&queries[i]["ball"]["center"]);
                let gap = dist + number(&queries[i]["ball"]["radius"]);
                assert!(
                    norm(sub(away(point, gap, normal), center)) < EPSILON,
                    "{contact}"
                );
            }
        }
    }
    assert!(
        contacts_seen > 500,
        "the scene tests little: {contacts_seen}"
    );
}

#[test]
fn nearest_points_and_first_hits_are_those_of_brute_force() {
    let folder = Folder::new();
    let [a, b] = two(&folder);
    let middle = center(&b);
    let mut queries = Vec::new();
    let mut expected = Vec::new();
    for (i, d) in directions(60).enumerate() {
        // No limit, one just beyond the answer, one just before it.
        let limit_for = |best: f64| match i % 3 {
            0 => None,
            1 => Some(1.05 * best),
            _ => Some(0.95 * best),
        };
        let point = away(middle, 3.0 * (i % 4) as f64, d);
        let distances = b.triangles.iter().map(|t| point_distance(t, point));
        let best = distances.fold(f64::INFINITY, f64::min);
        queries.push(json!({"closest": {"instance": "b", "point": point,
                                        "max_distance": limit_for(best)}}));
        expected.push((i % 3 != 2).then_some(best));
        let direction = away(middle, 0.7, [d[1], d[2], d[0]]);
        let direction = sub(direction, point).map(|x| 0.25 * x);
        let unit = direction.map(|x| x / norm(direction));
        let hits = b.triangles.iter();
        let hits = hits.filter_map(|t| ray_distance(t, point, unit, f64::INFINITY));
        let best = hits.reduce(f64::min);
        queries.push(
            json!({"ray": {"instance": "b", "origin": point, "direction": direction,
                                    "max_distance": best.and_then(limit_for)}}),
        );
        expected.push(best.filter(|_| i % 3 != 2));
    }
    let scene = json!({"instances": [a.json, b.json], "queries": queries});
    let lines = folder.query(&scene, &[]);
    assert_eq!(lines.len(), expected.len());
    let count = |found: bool| expected.iter().filter(|x| x.is_some() == found).count();
    assert!(
        count(true) > 40 && count(false) > 10,
        "the scene tests little"
    );
    for (i, (line, expected)) in lines.iter().zip(&expected).enumerate() {
        let fields = line.as_object().unwrap();
        assert_eq!(fields.len(), 6, "{line}");
        let Some(expected) = expected else {
            for field in ["triangle", "point", "distance", "barycentric"] {
                assert_eq!(fields.get(field), Some(&Value::Null), "{line}");
            }
            continue;
        };
        let distance = number(&line["distance"]);
        assert!((distance - expected).abs() < EPSILON, "{line}: {expected}");
        let point = vector(&line["point"]);
        let triangle = &b.triangles[line["triangle"].as_u64().unwrap() as usize];
        let same = weighted(triangle, vector(&line["barycentric"]));
        assert!(norm(sub(point, same)) < EPSILON, "{line}");
        let query = &queries[i];
        let from = [&query["closest"]["point"], &query["ray"]["origin"]][i % 2];
        assert!(
            (norm(sub(point, vector(from))) - distance).abs() < EPSILON,
            "{line}"
        );
    }
}

#[test]
fn many_rays_answer_as_rays_one_by_one() {
    let folder = Folder::new();
    let [a, _] = two(&folder);
    let middle = center(&a);
    let (mut origins, mut towards, mut expected) = (Vec::new(), Vec::new(), Vec::new());
    for (i, d) in directions(30).enumerate() {
        let origin = away(middle, if i % 3 == 0 { 0.0 } else { 3.0 }, d);
        let target = match i % 3 {
            1 => away(middle, 5.0, d), // away from it
            _ => away(middle, 0.9, [d[2], d[0], d[1]]),
        };
        let direction = sub(target, origin);
        let unit = direction.map(|x| x / norm(direction));
        let mut hits: Vec<f64> = a
            .triangles
            .iter()
            .filter_map(|t| ray_distance(t, origin, unit, 4.0))
            .collect();
        hits.sort_by(f64::total_cmp);
        origins.push(origin);
        towards.push(direction);
        expected.push(hits);
    }
    let rays = |mode: &str| {
        json!({"rays": {"instance": "a", "origins": origins, "directions": towards,
                        "mode": mode, "max_distance": 4.0}})
    };
    let one = |(origin, direction)| {
        json!({"ray": {"instance": "a", "origin": origin, "direction": direction,
                       "max_distance": 4.0}})
    };
    let mut queries: Vec<Value> = ["first", "all", "any"].map(rays).to_vec();
    queries.extend(origins.iter().zip(&towards).map(one));
    let lines = folder.query(&json!({"instances": [a.json], "queries": queries}), &[]);
    let hits: Vec<&Vec<Value>> = lines[..3]
        .iter()
        .map(|line| line["hits"].as_array().expect("a list"))
        .collect();
    let found = expected.iter().filter(|hits| !hits.is_empty()).count();
    assert!((10..30).contains(&found), "the scene tests little: {found}");
    for (i, expected) in expected.iter().enumerate() {
        let all = hits[1][i].as_array().expect("a list");
        assert_eq!(all.len(), expected.len(), "ray {i}");
        for (hit, distance) in all.iter().zip(expected) {
            assert!(
                (number(&hit["distance"]) - distance).abs() < EPSILON,
                "{hit}"
            );
        }
        assert_eq!(hits[2][i], json!(!expected.is_empty()));
        if let Some(first) = all.first() {
            assert_eq!(&hits[0][i], first);
        }
        for field in ["triangle", "point", "distance", "barycentric"] {
            assert_eq!(hits[0][i].get(field), lines[3 + i].get(field), "ray {i}");
        }
        assert_eq!(hits[0][i].as_object().map(|o| o.len()), Some(4));
    }
}

#[test]
fn pairs_are_those_of_brute_force() {
    let folder = Folder::new();
    let [a, b] = two(&folder);
    let tolerances = [0.0, 0.01, 0.05];
    let pair = |t: f64| json!({"pair": {"a": "a", "b": "b", "tolerance": t}});
    let mut queries: Vec<Value> = tolerances.map(pair).to_vec();
    queries.push(json!({"pair": {"a": "b", "b": "a"}}));
    let scene = json!({"instances": [a.json, b.json], "queries": queries});
    let lines = folder.query(&scene, &[]);
    let found: Vec<Vec<[usize; 2]>> = lines
        .iter()
        .map(|line| {
            assert_eq!(line.as_object().unwrap().len(), 3, "{line}");
            serde_json::from_value(line["triangles"].clone()).expect("pairs of ids")
        })
        .collect();
    assert!(found[0].len() > 20, "the scene tests little");
    for pairs in &found {
        assert!(pairs.is_sorted_by(|x, y| x < y));
    }
    let sets: Vec<BTreeSet<[usize; 2]>> =
        found.iter().map(|f| f.iter().copied().collect()).collect();
    for (i, x) in a.triangles.iter().enumerate() {
        for (j, y) in b.triangles.iter().enumerate() {
            let distance = triangle_distance(x, y);
            for (set, tolerance) in sets.iter().zip(tolerances) {
                if distance > tolerance + EPSILON {
                    assert!(!set.contains(&[i, j]), "{i} {j}: {distance}");
                } else if distance == 0.0 || distance < tolerance - EPSILON {
                    assert!(set.contains(&[i, j]), "{i} {j}: {distance}");
                }
            }
        }
    }
    let swapped: BTreeSet<[usize; 2]> = found[3].iter().map(|[x, y]| [*y, *x]).collect();
    assert_eq!(swapped, sets[0]);
}

/// Ids of a line's contacts, and whether its spheres hold a point.
fn of_line(line: &Value) -> (Vec<u64>, impl Fn([f64; 3]) -> bool) {
    let ids = serde_json::from_value(line["triangles"].clone()).expect("ids");
    let spheres: Vec<([f64; 3], f64)> = line["proxies"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|p| {
            assert_eq!(p.as_object().unwrap().len(), 2, "{p}");
            (vector(&p["center"]), p["radius"].as_f64().expect("radius"))
        })
        .collect();
    let holds = move |x| spheres.iter().any(|(c, r)| norm(sub(x, *c)) <= *r);
    (ids, holds)
}

#[test]
fn a_depth_adds_spheres_in_place_of_what_lies_deeper() {
    let folder = Folder::new();
    let [a, b] = two(&folder);
    let queries = json!([
        {"ball": {"instance": "a", "center": a.triangles[7][0], "radius": 0.5}},
        {"plane": {"instance": "a", "normal": [0, 0, 1], "offset": a.triangles[7][0][2]}},
        {"closest": {"instance": "a", "point": a.triangles[7][0]}},
        {"ray": {"instance": "a", "origin": [9, 9, 9], "direction": [0, 0, 1]}},
        {"pair": {"a": "a", "b": "b"}},
        {"pair": {"a": "a", "b": "b", "contacts": true}}]);
    let ask = |max_depth: Value| {
        let scene = json!({"instances": [a.json, b.json], "options": {"max_depth": max_depth},
            "queries": queries});
        folder.query(&scene, &[])
    };
    let exact = ask(Value::Null);
    assert!(exact.iter().all(|line| line.get("proxies").is_none()));
    let mut spheres = 0;
    for level in 0..3 {
        let lines = ask(json!(level));
        for (line, exact) in lines.iter().zip(&exact).take(2) {
            let (ids, holds) = of_line(line);
            for id in of_contacts(exact) {
                let corners = a.triangles[id as usize];
                let is_below = corners.into_iter().all(&holds);
                assert!(ids.contains(&id) || is_below, "{id} at level {level}");
            }
        }
        for line in &lines {
            spheres += line["proxies"].as_array().expect("a list").len();
        }
        // Regions of some of the pairs would be wrong ones.
        for key in ["triangles", "contacts"] {
            assert_eq!(lines[5][key], exact[5][key], "{key} at level {level}");
        }
        assert!(
            lines[5]["contacts"]
                .as_array()
                .is_some_and(|all| !all.is_empty())
        );
        let pair = lines[4]["proxies"].as_array().expect("a list");
        assert_eq!(pair.len() % 2, 0, "one of each");
        for both in pair.chunks(2) {
            let [c, d] = [0, 1].map(|i| vector(&both[i]["center"]));
            let [r, s] = [0, 1].map(|i| both[i]["radius"].as_f64().unwrap());
            assert!(norm(sub(c, d)) <= (r + s) * (1.0 + 1e-5), "they meet");
        }
    }
    assert!(spheres > 10, "{spheres}");
    let mut all = ask(json!(1000));
    for line in &mut all {
        let proxies = line.as_object_mut().unwrap().remove("proxies");
        assert_eq!(proxies, Some(json!([])));
    }
    assert_eq!(all, exact);
}

fn of_contacts(line: &Value) -> Vec<u64> {
    serde_json::from_value(line["triangles"].clone()).expect("ids")
}

#[test]
fn stats_add_one_field() {
    let folder = Folder::new();
    let scene = json!({
        "instances": [{"name": "a", "asset": "a.bdt"}, {"name": "r", "asset": "rigid.bdt", "q": []}],
        "options": {"max_depth": null},
        "queries": [{"ball": {"instance": "r", "center": [10, -2.5, 1.25], "radius": 0.2}},
                    {"closest": {"instance": "a", "point": [0, 0, 0]}},
                    {"pair": {"a": "a", "b": "r", "tolerance": 0.0}}]});
    let plain = folder.query(&scene, &[]);
    let mut stats = folder.query(&scene, &["--stats"]);
    for (line, plain) in stats.iter_mut().zip(&plain) {
        let nodes = line.as_object_mut().unwrap().remove("nodes_visited");
        assert!(nodes.and_then(|n| n.as_u64()) > Some(0));
        assert_eq!(line, plain);
    }
}

#[test]
fn paths_are_relative_to_the_scene() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("scenes")).unwrap();
    let scene = |path: &str| {
        json!({"instances": [{"name": "a", "asset": path}],
               "queries": [{"closest": {"instance": "a", "point": [10, -2.5, 5]}}]})
        .to_string()
    };
    folder.write("scenes/s.json", scene("../a.bdt"));
    let from_file = folder.run(&["query", "scenes/s.json"]);
    assert_eq!((from_file.code, from_file.err.as_str()), (0, ""));
    let from_stdin = folder.run_with(&["query", "-"], &scene("a.bdt"));
    assert_eq!((from_stdin.code, from_stdin.err.as_str()), (0, ""));
    assert_eq!(from_file.out, from_stdin.out);
    assert!(
        from_file
            .out
            .starts_with(r#"{"query":0,"kind":"closest","triangle":"#),
        "{}",
        from_file.out
    );
    // The whole scene as a file that lies elsewhere finds nothing.
    folder.write("scenes/t.json", scene("a.bdt"));
    assert_eq!(folder.run(&["query", "scenes/t.json"]).code, 1);
}

/// The page's scene is answered, query by query.
#[test]
fn the_readme_s_scene_is_answered() {
    let page = include_str!("../../../docs/reference/bdtree.md");
    let (_, rest) = page.split_once("```json\n").expect("a scene");
    let (scene, _) = rest.split_once("```").expect("its end");
    let folder = Folder::new();
    folder.write("scene.json", scene);
    let ran = folder.run(&["query", "scene.json"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    assert_eq!(ran.out.lines().count(), 10, "{}", ran.out);
}
