//! Problems and their places; happy paths need assets and stand in `tests/`.

use super::instances::Names;
use super::*;

/// The problems of a list of queries with two sound instances, a and b.
fn problems_of_queries(queries: &str) -> Vec<String> {
    let json = Json::parse(queries.as_bytes()).expect("JSON");
    let problems = Problems::new("s");
    let at = At {
        json: &json,
        place: "queries".to_string(),
        problems: &problems,
    };
    let names = [("a", 0), ("b", 1)].map(|(name, index)| (name.to_string(), Some(index)));
    read_queries(&at, &Names(names.into()));
    drop(at);
    problems.into_lines()
}

/// The problems of a scene's text.
fn problems_of(text: &str) -> Vec<String> {
    match Scene::parse(text.as_bytes(), "s", Path::new("no such folder"), true) {
        Ok(_) => Vec::new(),
        Err(ToolError::Input(lines)) => lines,
        Err(error) => vec![error.to_string()],
    }
}

#[test]
fn queries_have_no_problems() {
    let text = r#"[{"ball": {"instance": "a", "center": [0, -1.5, 1e30], "radius": 0}},
        {"closest": {"instance": "b", "point": [0, 0, 0]}},
        {"closest": {"instance": "b", "point": [0, 0, 0], "max_distance": null}},
        {"ray": {"instance": "a", "origin": [0, 0, 0], "direction": [1e-300, 0, 0],
                 "max_distance": 2}},
        {"rays": {"instance": "a", "origins": [], "directions": []}},
        {"rays": {"instance": "b", "origins": [[0, 0, 0]], "directions": [[0, 0, 2]],
                  "mode": "any", "max_distance": null}},
        {"plane": {"instance": "a", "normal": [0, 0, 2], "offset": -3}},
        {"pair": {"a": "a", "b": "b"}}, {"distance": {"a": "a", "b": "b"}},
        {"distance": {"a": "b", "b": "a", "max_distance": 0}}, {"pair": {"a": "b", "b": "a", "tolerance": 0.5}}]"#;
    assert_eq!(problems_of_queries(text), [""; 0]);
}

#[test]
fn every_problem_has_its_place() {
    for (query, expected) in [
        (
            r#"{"ball": {"instance": "a", "center": [0, 0, 0], "radius": -1}}"#,
            "queries[0].ball.radius: negative",
        ),
        (
            r#"{"ball": {"instance": "a", "center": [0, 0], "radius": 1}}"#,
            "queries[0].ball.center: expected 3 numbers, found 2",
        ),
        (
            r#"{"ball": {"instance": "a", "center": [0, "x", 0], "radius": 1}}"#,
            "queries[0].ball.center[1]: expected a number, found a string",
        ),
        (
            r#"{"ball": {"instance": "a", "center": [0, 0, 2e30], "radius": 1}}"#,
            "queries[0].ball.center[2]: beyond 2^100",
        ),
        (
            r#"{"ball": {"instance": "c", "center": [0, 0, 0], "radius": 1}}"#,
            "queries[0].ball.instance: unknown instance \"c\"",
        ),
        (
            r#"{"ball": {"instance": 1, "center": [0, 0, 0], "radius": 1}}"#,
            "queries[0].ball.instance: expected a string, found a number",
        ),
        (
            r#"{"ball": {"instance": "a", "center": [0, 0, 0]}}"#,
            "queries[0].ball.radius: missing",
        ),
        (
            r#"{"ball": {"instance": "a", "centre": 1, "center": [0, 0, 0], "radius": 1}}"#,
            "queries[0].ball.centre: unknown field (known: instance, center, radius)",
        ),
        (
            r#"{"closest": {"instance": "a", "point": [0, 0, 0], "max_distance": -0.5}}"#,
            "queries[0].closest.max_distance: negative",
        ),
        (
            r#"{"ray": {"instance": "a", "origin": [0, 0, 0], "direction": [0, 0, -0.0]}}"#,
            "queries[0].ray.direction: zero vector",
        ),
        (
            r#"{"plane": {"instance": "a", "normal": [0, 0, 0], "offset": 0}}"#,
            "queries[0].plane.normal: zero vector",
        ),
        (
            r#"{"plane": {"instance": "a", "normal": [0, 0, 1], "offset": -1e31}}"#,
            "queries[0].plane.offset: beyond 2^100",
        ),
        (
            r#"{"pair": {"a": "a", "b": "a", "tolerance": 0}}"#,
            "queries[0].pair.b: the same instance as a",
        ),
        (
            r#"{"distance": {"a": "a", "b": "a", "max_distance": 0}}"#,
            "queries[0].distance.b: the same instance as a",
        ),
        (
            r#"{"distance": {"a": "a", "b": "b", "max_distance": -1}}"#,
            "queries[0].distance.max_distance: negative",
        ),
        (
            r#"{"distance": {"a": "a", "max_distance": null}}"#,
            "queries[0].distance.b: missing",
        ),
        (
            r#"{"pair": {"a": "a", "b": "b", "tolerance": -1}}"#,
            "queries[0].pair.tolerance: negative",
        ),
        (
            r#"{"capsule": {"instance": "a", "point1": [0, 0, 0], "point2": [0, 0], "radius": 1}}"#,
            "queries[0].capsule.point2: expected 3 numbers, found 2",
        ),
        (
            r#"{"capsule": {"instance": "a", "point1": [0, 0, 0], "point2": [0, 0, 1], "radius": -1}}"#,
            "queries[0].capsule.radius: negative",
        ),
        (
            r#"{"box": {"instance": "a", "center": [0, 0, 0], "half_extents": [0, 1, -0.5]}}"#,
            "queries[0].box.half_extents[2]: negative",
        ),
        (
            r#"{"box": {"instance": "a", "center": [0, 0, 0], "rotation": [0, 0, 0.5, 0],
                "half_extents": [0, 1, 1]}}"#,
            "queries[0].box.rotation: a quaternion of length 0.5, not within 1e-3 of 1",
        ),
        (
            r#"{"box": {"instance": "a", "center": [0, 1e31, 0], "half_extents": [0, 1, 1]}}"#,
            "queries[0].box.center[1]: beyond 2^100",
        ),
        (
            r#"{"frustum": {"instance": "a"}}"#,
            "queries[0].frustum.planes: missing",
        ),
        (
            r#"{"frustum": {"instance": "a", "planes": []}}"#,
            "queries[0].frustum.planes: expected 1 to 64 planes, found 0",
        ),
        (
            r#"{"frustum": {"instance": "a", "planes": [[0, 0, 1, 0], [0, 0, 0, 1]]}}"#,
            "queries[0].frustum.planes[1]: zero vector",
        ),
        (
            r#"{"frustum": {"instance": "a", "planes": [[0, 0, 1]]}}"#,
            "queries[0].frustum.planes[0]: expected 4 numbers, found 3",
        ),
        (
            r#"{"frustum": {"instance": "a", "planes": [[0, 0, 1e-9, 1e30]]}}"#,
            "queries[0].frustum.planes[0]: farther than 2^100 from the origin",
        ),
        (
            r#"{"frustum": {"instance": "a", "planes": [[0, "0", 1, 0]]}}"#,
            "queries[0].frustum.planes[0][1]: expected a number, found a string",
        ),
        (
            r#"{"rays": {"instance": "a", "origins": [[0, 0, 0]], "directions": []}}"#,
            "queries[0].rays.directions: expected 1, one for each of origins, found 0",
        ),
        (
            r#"{"rays": {"instance": "a", "origins": [], "directions": [], "mode": "last"}}"#,
            "queries[0].rays.mode: unknown mode \"last\" (known: first, all, any)",
        ),
        (
            r#"{"rays": {"instance": "a", "origins": [[0, 0, 0], [0, 0, 0]],
                "directions": [[0, 1, 0], [0, 0, 0]]}}"#,
            "queries[0].rays.directions[1]: zero vector",
        ),
        (
            r#"{"rays": {"instance": "a", "origins": [[0, 2e30, 0]], "directions": [[0, 1, 0]]}}"#,
            "queries[0].rays.origins[0][1]: beyond 2^100",
        ),
        (
            r#"{"rays": {"instance": "a", "origins": 3, "directions": []}}"#,
            "queries[0].rays.origins: expected a list, found a number",
        ),
        (
            r#"{"bal": {}}"#,
            "queries[0].bal: unknown query kind (known: ball, closest, ray, plane, frustum, pair, distance, capsule, box, rays)",
        ),
        (
            r#"{"ball": {}, "ray": {}}"#,
            "queries[0]: expected one query kind, found ball, ray",
        ),
        (r#"{}"#, "queries[0]: expected one query kind, found none"),
        (r#"7"#, "queries[0]: expected an object, found a number"),
        (
            r#"{"ball": []}"#,
            "queries[0].ball: expected an object, found a list",
        ),
    ] {
        assert_eq!(
            problems_of_queries(&format!("[{query}]")),
            [format!("s: {expected}")],
            "{query}"
        );
    }
}

#[test]
fn of_many_problems_a_hundred_are_listed() {
    let lines = problems_of_queries(&format!("[{}1]", "1, ".repeat(149)));
    assert_eq!(lines.len(), 101);
    assert_eq!(
        lines[99],
        "s: queries[99]: expected an object, found a number"
    );
    assert_eq!(lines[100], "s: 50 more problems");
}

#[test]
fn all_problems_are_told() {
    let text = r#"{"instances": [{"name": "a", "asset": "no.bdt", "rotation": [0, 0, 0, 1.1],
            "translation": [0, 1e30, 0], "scale": 0, "colour": "red"}, {"asset": 3, "q": [[]]}],
        "options": {"max_depth": 2.5, "depth": 1},
        "queries": [{"ball": {"instance": "a", "center": [], "radius": -1}},
                    {"pair": {"a": "a", "b": "a"}}], "query": 1}"#;
    let lines = problems_of(text);
    let places: Vec<&str> = lines
        .iter()
        .map(|line| line.split(": ").nth(1).unwrap())
        .collect();
    assert_eq!(
        places,
        [
            "query",
            "instances[0].colour",
            "instances[0].asset",
            "instances[0].rotation",
            "instances[0].translation[1]",
            "instances[0].scale",
            "instances[1].name",
            "instances[1].asset",
            "instances[1].q[0]",
            "options.depth",
            "options.max_depth",
            "queries[0].ball.center",
            "queries[0].ball.radius",
            "queries[1].pair.b",
        ],
        "{lines:#?}"
    );
}

#[test]
fn a_depth_is_a_whole_number() {
    let problems = |depth: &str| {
        let options = format!(r#"{{"max_depth": {depth}}}"#);
        problems_of(&format!(
            r#"{{"instances": [], "queries": [], "options": {options}}}"#
        ))
    };
    for depth in ["null", "0", "7", "1e300"] {
        assert!(problems(depth).is_empty(), "{depth}");
    }
    for depth in ["-1", "0.5"] {
        let expected = "s: options.max_depth: not a whole number of at least 0";
        assert_eq!(problems(depth), [expected]);
    }
    let expected = "s: options.max_depth: expected a number, found a string";
    assert_eq!(problems("\"3\""), [expected]);
}

#[test]
fn a_scene_is_an_object_with_both_lists() {
    assert_eq!(problems_of("[]"), ["s: expected an object, found a list"]);
    assert_eq!(
        problems_of("{}"),
        ["s: instances: missing", "s: queries: missing"]
    );
    assert_eq!(
        problems_of(r#"{"instances": {}, "queries": null}"#),
        [
            "s: instances: expected a list, found an object",
            "s: queries: expected a list, found null"
        ]
    );
    assert_eq!(problems_of("{").len(), 1);
    assert!(problems_of("{").concat().contains("line 1 column 1"));
    assert!(problems_of(r#"{"instances": [], "queries": []}"#).is_empty());
}
