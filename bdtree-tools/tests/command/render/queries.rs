//! Pictures of what a scene's queries visit.

use serde_json::{Value, json};

use crate::drawn::{Picture, numbers};
use crate::support::{FRAME_Q, Folder, animated, baked, ball_mesh};

#[test]
fn visited_nodes_are_those_that_queries_count() {
    let folder = Folder::new();
    let queries = [
        json!({"ball": {"instance": "a", "center": [11, -2.5, 0.25], "radius": 0.1}}),
        json!({"closest": {"instance": "a", "point": [10, -1, 2]}}),
        json!({"ray": {"instance": "a", "origin": [10.1, -2.4, 5], "direction": [0, 0, -1]}}),
        json!({"rays": {"instance": "a", "origins": [[10.1, -2.4, 5]], "directions": [[0, 0, -1]]}}),
        json!({"plane": {"instance": "a", "normal": [0, 0, 1], "offset": -0.6}}),
        json!({"capsule": {"instance": "a", "point1": [11, -2.5, 0], "point2": [11, -2.5, 1], "radius": 0.05}}),
        json!({"box": {"instance": "a", "center": [11, -2.5, 0], "half_extents": [0.1, 0.1, 0.1]}}),
        json!({"frustum": {"instance": "a", "planes": [[0, 0, 1, -0.25]]}}),
    ];
    for options in [json!({}), json!({"max_depth": 1}), json!({"max_visits": 5})] {
        for query in &queries {
            let scene = json!({
                "instances": [{"name": "a", "asset": "a.bdt", "q": [0.5, 0.1, -0.2]}],
                "options": options,
                "queries": [query],
            });
            let lines = folder.query(&scene, &["--stats"]);
            let (_, report) = folder.asked("a.bdt", &scene, &[]);
            // A frustum looks at the root once more, before it descends.
            let twice = u64::from(query.get("frustum").is_some());
            let counted = lines[0]["nodes_visited"].as_u64().expect("a number");
            assert_eq!(
                report["nodes_visited"],
                counted - twice,
                "{options} {query}"
            );
            assert!(
                !report["spheres"].as_array().expect("a list").is_empty(),
                "{query}"
            );
        }
    }
}

#[test]
fn a_scene_shows_where_queries_ended_and_who_stands_beside() {
    let folder = Folder::new();
    let scene = |x: f64| {
        json!({
            "instances": [
                {"name": "a", "asset": "a.bdt"},
                {"name": "b", "asset": "rigid.bdt", "translation": [x, 0, 0]},
            ],
            "queries": [{"pair": {"a": "a", "b": "b"}}],
        })
    };
    folder.write("near.json", scene(1.9).to_string());
    folder.write("far.json", scene(2.5).to_string());
    let (_, far) = folder.reported(&["a.bdt", "--query", "far.json"]);
    let (near_picture, near) = folder.reported(&["a.bdt", "--query", "near.json", "--no-legend"]);
    let count = |report: &Value| report["nodes_visited"].as_u64().expect("a number");
    assert!(
        count(&near) > count(&far),
        "{} {}",
        count(&near),
        count(&far)
    );
    // Where queries end, every triangle is in one of the spheres, and no sphere leads to another's node.
    let q: Vec<f64> = numbers(&near["q"]);
    assert_eq!(q, [0.0; 3]);
    let covered = near_picture.covered();
    assert!(covered > 0.15, "{covered}");
    // Of the other body's spheres none are drawn; asked the other way round, only they are.
    let (_, other) = folder.reported(&["rigid.bdt", "--query", "near.json"]);
    let middle = |report: &Value| {
        let spheres = report["spheres"].as_array().expect("a list");
        let sum: f64 = spheres.iter().map(|s| numbers(&s["center"])[0]).sum();
        sum / spheres.len() as f64
    };
    assert!(middle(&near) < 11.0 && middle(&other) > 11.0);
    let (_, level) = folder.reported(&["a.bdt", "--query", "near.json", "--spheres", "0"]);
    let all = level["spheres"].as_array().expect("a list");
    assert!(all.iter().all(|sphere| sphere["node"] == 0));
}

#[test]
fn what_is_asked_about_is_in_the_picture_and_rays_run_out_of_it() {
    let folder = Folder::new();
    let away = |query: Value| {
        let scene = json!({
            "instances": [{"name": "r", "asset": "rigid.bdt"}],
            "queries": [query],
        });
        let (picture, _) = folder.asked("rigid.bdt", &scene, &["--no-legend"]);
        picture.covered()
    };
    let alone = folder.picture(&["rigid.bdt", "--no-legend"]).covered();
    // As far away as several bodies: the body becomes small.
    for query in [
        json!({"ball": {"instance": "r", "center": [20, -2, 0], "radius": 0.1}}),
        json!({"capsule": {"instance": "r", "point1": [20, -2, 0], "point2": [21, -2, 0], "radius": 0.1}}),
        json!({"box": {"instance": "r", "center": [20, -2, 0], "half_extents": [0.1, 0.1, 0.1]}}),
    ] {
        let covered = away(query.clone());
        assert!(
            covered > 0.0 && covered < 0.3 * alone,
            "{query}: {covered} {alone}"
        );
    }
    let ray = json!({"ray": {"instance": "r", "origin": [200, -2, 0], "direction": [-1, 0, 0]}});
    assert!(away(ray) > 0.7 * alone);
}

#[test]
fn what_is_asked_about_has_an_outline_before_the_mesh() {
    let folder = Folder::new();
    // Before the middle of a body that fills the picture, as seen from +z.
    for query in [
        json!({"ball": {"instance": "r", "center": [10, -2, 1.2], "radius": 0.15}}),
        json!({"closest": {"instance": "r", "point": [10, -2.4, 1.6]}}),
        json!({"capsule": {"instance": "r", "point1": [9.8, -2, 1.2], "point2": [10.2, -2, 1.2], "radius": 0.1}}),
        json!({"box": {"instance": "r", "center": [10, -2, 1.2], "half_extents": [0.2, 0.1, 0.1]}}),
        json!({"ray": {"instance": "r", "origin": [9.8, -2.1, 1.2], "direction": [1, 0.5, 0], "max_distance": 0.5}}),
    ] {
        let scene = json!({"instances": [{"name": "r", "asset": "rigid.bdt"}], "queries": [query]});
        let options = ["--no-legend", "--view=0,0", "--opacity", "0"];
        let (picture, _) = folder.asked("rigid.bdt", &scene, &options);
        // A dark line and a white one beside it, both within the mesh, which is neither.
        let [left, top, right, bottom] = picture.drawn_box();
        let inner = |x: f64, y: f64| {
            let [a, b] = [
                (x - left) / (right - left) - 0.5,
                (y - top) / (bottom - top) - 0.5,
            ];
            a.hypot(b) < 0.35
        };
        let count = |is: fn([u8; 3]) -> bool| {
            let all = picture.pixels.iter().enumerate();
            let of = all.filter(|(i, p)| {
                let [x, y] = [i % picture.size[0], i / picture.size[0]].map(|n| n as f64);
                inner(x, y) && is(**p)
            });
            of.count()
        };
        let dark = count(|p| p.iter().all(|c| *c < 80));
        let light = count(|p| p.iter().all(|c| *c > 235));
        assert!(dark > 10 && light > 5, "{query}: {dark} {light}");
    }
}

/// A point is a cross as large in every picture, whose middle is dark: a ball's ring is not.
#[test]
fn a_point_is_a_cross_and_a_ball_a_ring() {
    let folder = Folder::new();
    let dark = |query: Value, size: &str| {
        let scene = json!({"instances": [{"name": "r", "asset": "rigid.bdt"}], "queries": [query]});
        folder.write("scene.json", scene.to_string());
        let fixed = [
            "rigid.bdt",
            "--query",
            "scene.json",
            "--no-legend",
            "--view=0,0",
        ];
        let options = ["--opacity", "0", "-o", "out.png"];
        folder.render_at(size, &[&fixed[..], &options].concat());
        let picture = Picture::read(&folder.path("out.png"));
        let all = picture.pixels.iter().enumerate();
        let dark = all.filter(|(_, p)| p.iter().all(|c| *c < 80));
        let places: Vec<[f64; 2]> = dark
            .map(|(i, _)| [i % picture.size[0], i / picture.size[0]].map(|n| n as f64))
            .collect();
        let count = places.len() as f64;
        let middle = [0, 1].map(|k| places.iter().map(|p| p[k]).sum::<f64>() / count);
        let far = |p: &[f64; 2]| (p[0] - middle[0]).hypot(p[1] - middle[1]);
        let nearest = places.iter().map(far).fold(f64::INFINITY, f64::min);
        let farthest = places.iter().map(far).fold(0.0, f64::max);
        [nearest, farthest]
    };
    let point = |z: f64| json!({"closest": {"instance": "r", "point": [10, -2, z]}});
    for z in [1.5, 2.5] {
        let [nearest, farthest] = dark(point(z), "320x240");
        assert!(
            nearest < 1.5 && (5.0..10.0).contains(&farthest),
            "{z}: {nearest} {farthest}"
        );
        let [_, farthest] = dark(point(z), "1280x960");
        assert!((9.0..16.0).contains(&farthest), "{z}: {farthest}");
    }
    let ball = json!({"ball": {"instance": "r", "center": [10, -2, 1.2], "radius": 0.15}});
    let [nearest, _] = dark(ball, "320x240");
    assert!(nearest > 5.0, "{nearest}");
}

#[test]
fn a_scene_is_drawn_at_another_q_or_frame() {
    let folder = Folder::new();
    let mesh = ball_mesh();
    folder.write("moves.bdt", baked(&mesh, &animated(&mesh)));
    let scene = |q: [f64; 3], more: Value| {
        let mut instance = json!({"name": "a", "asset": "moves.bdt", "q": q});
        for (key, value) in more.as_object().expect("an object") {
            instance[key] = value.clone();
        }
        json!({
            "instances": [instance, {"name": "r", "asset": "rigid.bdt", "translation": [1.9, 0, 0]}],
            "queries": [{"pair": {"a": "a", "b": "r"}}],
        })
    };
    let moved = json!({"translation": [0.05, 0.1, 0], "scale": 1.1});
    let draw = |scene: Value, more: &[&str]| {
        // Without text, which names a pose that replaces the scene's.
        let more = [more, &["--no-legend"]].concat();
        let (_, report) = folder.asked("moves.bdt", &scene, &more);
        (folder.read("out.png"), report)
    };
    // --q in place of the scene's.
    let (expected, _) = draw(scene([0.5, -0.25, 1.0], moved.clone()), &[]);
    let (found, report) = draw(scene([0.0; 3], moved.clone()), &["--q=0.5,-0.25,1"]);
    assert_eq!(numbers(&report["q"]), [0.5, -0.25, 1.0]);
    assert!(found == expected, "pictures differ");
    let (rest, _) = draw(scene([0.0; 3], moved.clone()), &[]);
    assert!(rest != expected);
    // A frame: its q, and its motion before the scene's placement.
    let (_, found) = draw(scene([0.0; 3], moved.clone()), &["--frame", "1"]);
    let mut turned = moved;
    turned["rotation"] = json!([0.6, 0, 0, 0.8]);
    let (_, expected) = draw(scene(FRAME_Q[1], turned), &[]);
    assert_eq!(found["q"], expected["q"]);
    assert_eq!(found["nodes_visited"], expected["nodes_visited"]);
    let spheres = |report: &Value| -> Vec<(Value, Vec<f64>)> {
        let all = report["spheres"].as_array().expect("a list").iter();
        all.map(|s| (s["node"].clone(), numbers(&s["center"])))
            .collect()
    };
    let both = spheres(&found).into_iter().zip(spheres(&expected));
    for ((node, at), (expected_node, expected_at)) in both {
        assert_eq!(node, expected_node);
        for k in 0..3 {
            assert!(
                (at[k] - expected_at[k]).abs() < 1e-5,
                "{at:?} {expected_at:?}"
            );
        }
    }
    let arguments = ["moves.bdt", "--query", "scene.json", "--frame", "9"];
    let said = folder.refusal(&[&arguments[..], &["-o", "out.png"]].concat());
    assert!(said.starts_with("--frame: "), "{said}");
}
