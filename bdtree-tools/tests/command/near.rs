//! Distances of two instances and answers within a number of visits, beside brute force.

use serde_json::{Value, json};

use crate::oracle::{norm, sub, triangle_distance};
use crate::query::{EPSILON, two, vector};
use crate::support::Folder;

#[test]
fn distances_are_those_of_brute_force() {
    let folder = Folder::new();
    let [a, b] = two(&folder);
    let mut far = b.json.clone();
    far["name"] = json!("far");
    far["translation"] = json!([1000, 0, 0]);
    let queries = json!([{"distance": {"a": "a", "b": "b"}},
        {"distance": {"a": "a", "b": "far"}},
        {"distance": {"a": "far", "b": "a", "max_distance": 1e4}},
        {"distance": {"a": "a", "b": "far", "max_distance": 10}}]);
    let scene = json!({"instances": [a.json, b.json, far], "queries": queries});
    let lines = folder.query(&scene, &[]);
    for line in &lines {
        let fields: Vec<&String> = line.as_object().unwrap().keys().collect();
        let mut expected = ["query", "kind", "distance", "point1", "point2", "triangles"];
        expected.sort_unstable();
        assert_eq!(fields, expected.iter().collect::<Vec<_>>());
        assert_eq!(line["kind"], "distance");
    }
    // They touch: the lowest of the pairs that do.
    let touching = (0..a.triangles.len())
        .flat_map(|i| (0..b.triangles.len()).map(move |j| (i, j)))
        .find(|(i, j)| triangle_distance(&a.triangles[*i], &b.triangles[*j]) == 0.0);
    let (i, j) = touching.expect("they touch");
    assert_eq!(lines[0]["distance"], 0.0);
    assert_eq!(lines[0]["point1"], lines[0]["point2"]);
    assert_eq!(lines[0]["triangles"], json!([i, j]));
    let gap = norm(sub(
        vector(&lines[1]["point1"]),
        vector(&lines[1]["point2"]),
    ));
    let distance = lines[1]["distance"].as_f64().unwrap();
    assert!((gap - distance).abs() < EPSILON && distance > 900.0);
    assert!((lines[2]["distance"].as_f64().unwrap() - distance).abs() < EPSILON);
    for key in ["distance", "point1", "point2", "triangles"] {
        assert_eq!(lines[3][key], Value::Null);
    }
}

#[test]
fn answers_within_a_number_of_visits_say_what_they_left_out() {
    let folder = Folder::new();
    let [a, b] = two(&folder);
    let mut far = b.json.clone();
    far["name"] = json!("far");
    far["translation"] = json!([9, 8, 7]);
    let queries = json!([{"closest": {"instance": "a", "point": [3, 2, 1]}},
        {"ray": {"instance": "a", "origin": [30, 20, 10], "direction": [-3, -2, -1]}},
        {"ball": {"instance": "a", "center": [0, 0, 0], "radius": 100}},
        {"distance": {"a": "a", "b": "far"}},
        {"ray": {"instance": "a", "origin": [30, 20, 10], "direction": [3, 2, 1]}},
        {"pair": {"a": "a", "b": "b"}}]);
    let ask = |max_visits: Value| {
        let instances = json!([a.json, b.json, far]);
        let options = json!({"max_visits": max_visits});
        folder.query(
            &json!({"instances": instances, "options": options, "queries": queries}),
            &[],
        )
    };
    let plain = ask(Value::Null);
    assert!(plain.iter().all(|line| line.get("complete").is_none()));
    let mut whole = ask(json!(1_000_000));
    let first = ask(json!(0));
    for (i, plain) in plain.iter().enumerate() {
        let fields = whole[i].as_object_mut().unwrap();
        if i == 5 {
            assert_eq!(&first[i], plain);
            continue;
        }
        assert_eq!(fields.remove("complete"), Some(json!(true)));
        let bound = fields.remove("at_least").expect("a bound");
        match i {
            2 => assert_eq!(
                (bound, fields.remove("unseen")),
                (json!(0.0), Some(json!(0)))
            ),
            _ => assert_eq!(bound, plain["distance"]),
        }
        assert_eq!(&whole[i], plain);
        if i == 4 {
            continue; // it leads away
        }
        assert_eq!(first[i]["complete"], false);
        let truth = if i == 2 {
            0.0
        } else {
            plain["distance"].as_f64().unwrap_or(f64::INFINITY)
        };
        assert!(first[i]["at_least"].as_f64().unwrap() < truth);
    }
    assert!(first[2]["unseen"].as_u64() > Some(0));
    for wrong in [json!(-1), json!(0.5), json!(1e300)] {
        let scene = json!({"instances": [a.json], "options": {"max_visits": wrong}, "queries": []});
        let ran = folder.run_with(&["query", "-"], &scene.to_string());
        assert_eq!(ran.code, 1);
        let expected = "stdin: options.max_visits: not a whole number from 0 to 2^53\n";
        assert_eq!(ran.err, expected);
    }
}

#[test]
fn contacts_come_when_asked_for() {
    let folder = Folder::new();
    let [a, b] = two(&folder);
    let pair = |contacts: Value| json!({"pair": {"a": "a", "b": "b", "contacts": contacts}});
    let queries = json!([pair(json!(false)), pair(json!(true))]);
    let scene = json!({"instances": [a.json, b.json], "queries": queries});
    let lines = folder.query(&scene, &[]);
    assert!(lines[0].get("contacts").is_none());
    assert_eq!(lines[0]["triangles"], lines[1]["triangles"]);
    let regions = lines[1]["contacts"].as_array().unwrap();
    assert!(!regions.is_empty());
    for region in regions {
        assert!((norm(vector(&region["normal"])) - 1.0).abs() < EPSILON);
        let points = region["points"].as_array().unwrap();
        let area: f64 = points.iter().map(|p| p["area"].as_f64().unwrap()).sum();
        assert!((area - region["area"].as_f64().unwrap()).abs() < EPSILON);
        assert!(points.len() == 1 || points.len() == 4);
    }
    let scene = json!({"instances": [a.json, b.json], "queries": [pair(json!(1))]});
    let ran = folder.run_with(&["query", "-"], &scene.to_string());
    let expected = "stdin: queries[0].pair.contacts: expected true or false, found a number\n";
    assert_eq!((ran.code, ran.err.as_str()), (1, expected));
}
