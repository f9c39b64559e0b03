//! The answers of golden files, which programs in Rust, C, C++ and C# give as well, from `bdtree query`.

use std::fs;

use bdtree_fixtures::golden;
use bdtree_runtime::Model;
use serde_json::{Value, json};

use crate::support::Folder;

/// An answer of the command as golden files have it.
fn answer(line: &Value) -> Value {
    let hit = |of: &Value| {
        if of["triangle"].is_null() {
            return Value::Null;
        }
        json!([
            of["triangle"],
            of["point"],
            of["distance"],
            of["barycentric"]
        ])
    };
    let contact = |of: &Value| {
        let mut normal: [f64; 3] = serde_json::from_value(of["normal"].clone()).expect("a normal");
        // The command gives the plane's own, the library that from the mesh to the region.
        if line["kind"] == "plane" {
            normal = normal.map(|x| -x);
        }
        let (triangle, point) = (&of["triangle"], &of["point"]);
        json!([triangle, point, normal, of["dist"], of["barycentric"]])
    };
    let all = |name: &str| line[name].as_array().expect("a list");
    match line["kind"].as_str().expect("a kind") {
        "ball" | "plane" => all("contacts").iter().map(contact).collect(),
        "closest" | "ray" => hit(line),
        "pair" => {
            let first: Vec<_> = all("triangles").iter().take(golden::PAIRS).collect();
            json!([all("triangles").len(), first])
        }
        kind => panic!("{kind}"),
    }
}

#[test]
fn golden_answers_are_those_of_the_command() {
    let folder = Folder::new();
    let mut count = 0;
    for name in fs::read_dir(golden::folder()).expect("golden files") {
        let path = name.expect("an entry").path();
        if path.extension().is_none_or(|end| end != "bdt") {
            continue;
        }
        folder.write("golden.bdt", fs::read(&path).expect("read"));
        let model = Model::read(&path).expect("a model");
        let mut lines = String::new();
        for (step, scene) in golden::scenes(&model, "golden.bdt").iter().enumerate() {
            folder.write("golden.json", scene.to_string());
            let ran = folder.run(&["query", "golden.json"]);
            assert_eq!(ran.code, 0, "{}", ran.err);
            for line in ran.out.lines() {
                let line: Value = serde_json::from_str(line).expect("JSON");
                let told = json!({"step": step, "kind": line["kind"], "answer": answer(&line)});
                lines.push_str(&told.to_string());
                lines.push('\n');
            }
        }
        let expected = fs::read_to_string(path.with_extension("jsonl")).expect("answers");
        for (own, golden) in lines.lines().zip(expected.lines()) {
            assert_eq!(own, golden, "{}", path.display());
        }
        assert_eq!(lines.len(), expected.len());
        count += 1;
    }
    assert!(count >= 6, "{count} golden files");
}
