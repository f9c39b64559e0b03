//! `render`: pictures by their content, sequences, what queries visit, and what is refused.

use std::fs;
use std::process::Command;

use serde_json::{Value, json};

use crate::drawn::{Picture, WHITE, numbers};
use crate::support::{FRAME_Q, Folder, animated, baked, ball_mesh};

#[test]
fn a_mesh_stands_in_the_middle_and_the_legend_in_its_corner() {
    let folder = Folder::new();
    let plain = folder.picture(&["a.bdt", "--no-legend"]);
    assert_eq!(plain.size, [320, 240]);
    let covered = plain.covered();
    assert!((0.3..0.8).contains(&covered), "{covered} of the picture");
    assert_ne!(plain.at(160.0, 120.0), WHITE);
    for [x, y] in [[0.0, 0.0], [319.0, 0.0], [0.0, 239.0], [319.0, 239.0]] {
        assert_eq!(plain.at(x, y), WHITE);
    }
    let is_grey = |[r, g, b]: [u8; 3]| r.abs_diff(g) < 30 && g.abs_diff(b) < 30;
    assert_eq!(
        plain.share(is_grey),
        1.0,
        "nothing is coloured without spheres"
    );

    let first = folder.read("out.png");
    folder.picture(&["a.bdt", "--no-legend"]);
    assert_eq!(
        first,
        folder.read("out.png"),
        "the same picture has the same bytes"
    );

    // Two lines of text above, and below them the same picture with so many rows less.
    let with_text = folder.picture(&["a.bdt"]);
    let rows = 12 + 2 * 18;
    folder.render_at("320x192", &["a.bdt", "--no-legend", "-o", "out.png"]);
    let (text, shown) = with_text.pixels.split_at(320 * rows);
    assert!(text.iter().filter(|p| **p != WHITE).count() > 100);
    assert!(Picture::read(&folder.path("out.png")).pixels == shown);
    let files = fs::read_dir(folder.root()).expect("a folder").count();
    assert_eq!(files, 3, "a.bdt, rigid.bdt and the picture");
}

/// The shadow lies on the ground below the mesh, is drawn behind it, and is not seen from below.
#[test]
fn a_shadow_lies_below_the_mesh() {
    let folder = Folder::new();
    let is_shadow = |p: [u8; 3]| p == [222, 225, 230];
    let view = ["a.bdt", "--no-legend", "--view", "0,30"];
    let plain = folder.picture(&view);
    assert_eq!(plain.share(is_shadow), 0.0);
    let shaded = folder.picture(&[&view[..], &["--shadow"]].concat());
    assert!(
        shaded.share(is_shadow) > 0.03,
        "{}",
        shaded.share(is_shadow)
    );
    let rows = |is: &dyn Fn([u8; 3]) -> bool| {
        let found = shaded.pixels.iter().enumerate().filter(|(_, p)| is(**p));
        let rows: Vec<usize> = found.map(|(i, _)| i / shaded.size[0]).collect();
        rows.iter().sum::<usize>() as f64 / rows.len() as f64
    };
    let mesh = |p: [u8; 3]| p != WHITE && !is_shadow(p);
    assert!(rows(&is_shadow) > rows(&mesh) + 20.0);
    // All of it is in the picture.
    let [left, top, right, bottom] = shaded.drawn_box();
    assert!(left > 0.0 && top > 0.0 && right < 320.0 && bottom < 240.0);
    let below = ["a.bdt", "--no-legend", "--view", "0,-30", "--shadow"];
    assert_eq!(folder.picture(&below).share(is_shadow), 0.0);
    // With another axis up it lies elsewhere.
    let turned = folder.picture(&[&view[..], &["--shadow", "--up", "-y"]].concat());
    assert!(turned.share(is_shadow) > 0.03);
}

#[test]
fn the_scale_colors_spheres_and_legend() {
    let folder = Folder::new();
    let bent = ["a.bdt", "--q=1.5,1,-2", "--spheres", "1", "--opacity", "1"];
    let draw = |more: &[&str]| folder.picture(&[&bent[..], more].concat());
    let default = draw(&[]);
    let paper = draw(&["--scale", "paper"]);
    assert!(default.pixels == paper.pixels);
    let viridis = draw(&["--scale", "viridis"]);
    // Only the paper's scale has red, in spheres and legend; only viridis has its purple and its green.
    let is_red = |[r, g, b]: [u8; 3]| r > 110 && g < 70 && b < 70;
    let is_purple = |[r, g, b]: [u8; 3]| r.abs_diff(70) < 4 && g < 40 && (80..130).contains(&b);
    let is_green =
        |[r, g, b]: [u8; 3]| g > r.saturating_add(40) && g > b.saturating_add(20) && b > 60;
    assert!(paper.share(is_red) > 0.002 && viridis.share(is_red) == 0.0);
    assert!(paper.share(is_purple) == 0.0 && viridis.share(is_purple) > 0.0);
    assert!(
        viridis.share(is_green) > 0.002,
        "{}",
        viridis.share(is_green)
    );
    let plain = draw(&["--scale", "viridis", "--no-legend"]);
    assert!(
        plain.share(is_purple) < viridis.share(is_purple),
        "the legend's bar is viridis too"
    );
    let ran = folder.run(&["render", "a.bdt", "-o", "none.png", "--scale", "jet"]);
    assert_eq!(ran.code, 2, "{}", ran.err);
}

#[test]
fn what_is_drawn_fills_the_picture_and_is_whole() {
    let folder = Folder::new();
    let query = json!({"ball": {"instance": "r", "center": [11, -1, 0], "radius": 0.4}});
    let scene = json!({
        "instances": [{"name": "r", "asset": "rigid.bdt"}],
        "queries": [query],
    });
    folder.write("scene.json", scene.to_string());
    let contents = [
        &["rigid.bdt"][..],
        &["a.bdt", "--q=1.5,1,-2", "--spheres", "1"],
        &["rigid.bdt", "--query", "scene.json"],
    ];
    let views = ["--view=0,0", "--view=30,20", "--view=90,-50", "--view=0,90"];
    for content in contents {
        for view in views {
            for (size, width, height) in [
                ("320x240", 320.0, 240.0),
                ("120x300", 120.0, 300.0),
                ("400x100", 400.0, 100.0),
            ] {
                let fixed = [view, "--up", "z", "--no-legend", "-o", "out.png"];
                folder.render_at(size, &[content, &fixed].concat());
                let picture = Picture::read(&folder.path("out.png"));
                let [left, top, right, bottom] = picture.drawn_box();
                let (fill_x, fill_y) = ((right - left) / width, (bottom - top) / height);
                let is_full = fill_x >= 0.85 || fill_y >= 0.85;
                assert!(is_full, "{content:?} {view} {size}: {fill_x} {fill_y}");
                let is_whole = left > 0.0 && top > 0.0 && right < width && bottom < height;
                assert!(is_whole, "{content:?} {view} {size}");
            }
        }
    }
}

#[test]
fn the_up_axis_points_up() {
    let folder = Folder::new();
    let expected = folder.picture(&["rigid.bdt", "--no-legend"]);
    // The same body as programs write it that take z, −y or −x for up.
    type Turn = fn([f64; 3]) -> [f64; 3];
    let turns: [(&str, Turn); 3] = [
        ("z", |[x, y, z]| [x, -z, y]),
        ("-y", |[x, y, z]| [-x, -y, z]),
        ("-x", |[x, y, z]| [-y, x, z]),
    ];
    for (axis, turn) in turns {
        let mut mesh = ball_mesh();
        for p in &mut mesh.positions {
            *p = turn(*p);
        }
        let rigid = bdtree_build::basis::Basis {
            vertex_count: mesh.positions.len(),
            ..Default::default()
        };
        folder.write("turned.bdt", baked(&mesh, &rigid));
        let differing = |found: &Picture| {
            let pairs = found.pixels.iter().zip(&expected.pixels);
            let differ = pairs.filter(|(a, b)| (0..3).any(|k| a[k].abs_diff(b[k]) > 8));
            differ.count() as f64 / expected.pixels.len() as f64
        };
        let up = folder.picture(&["turned.bdt", "--no-legend", "--up", axis]);
        assert!(differing(&up) < 0.002, "{axis}: {}", differing(&up));
        let not_up = folder.picture(&["turned.bdt", "--no-legend"]);
        assert!(differing(&not_up) > 0.01, "{axis}: {}", differing(&not_up));
    }
    let ran = folder.run(&["render", "a.bdt", "-o", "none.png", "--up", "w"]);
    assert_eq!(ran.code, 2, "{}", ran.err);
}

#[test]
fn spheres_of_a_level_hold_the_mesh_and_wear_their_growth() {
    let folder = Folder::new();
    let draw = |q: &str, more: &[&str]| {
        let q = format!("--q={q}");
        let fixed = [
            "a.bdt",
            &q,
            "--spheres",
            "0",
            "--opacity",
            "1",
            "--no-legend",
        ];
        folder.reported(&[&fixed, more].concat())
    };
    let (rest, report) = draw("0,0,0", &[]);
    assert_eq!(report["level"], 0);
    assert_eq!(report["nodes_visited"], Value::Null);
    // Dark blue, wherever there is a sphere: R' is R but for the slack.
    let growth = |report: &Value| {
        [&report["growth"]["mean"], &report["growth"]["max"]].map(|x| x.as_f64().expect("a number"))
    };
    let [mean, max] = growth(&report);
    assert!(
        (1.0..1.0001).contains(&mean) && max < 1.0001,
        "{mean} {max}"
    );
    let blue = rest.share(|[r, g, b]| b > r.saturating_add(20) && g < 140);
    let covered = rest.covered();
    assert!(
        covered > 0.25 && blue > 0.85 * covered,
        "{blue} of {covered}"
    );

    let (bent, report) = draw("1.5,1,-2", &[]);
    let [mean, max] = growth(&report);
    assert!(mean > 1.1 && max > 1.2, "{mean} {max}");
    let warm = bent.share(|[r, _, b]| r > b.saturating_add(60));
    assert!(
        warm > 0.01 && rest.share(|[r, _, b]| r > b.saturating_add(60)) == 0.0,
        "{warm}"
    );

    let spheres = report["spheres"].as_array().expect("a list");
    assert!(!spheres.is_empty());
    for sphere in spheres {
        let [x, y] = numbers(&sphere["pixel"])[..] else {
            panic!("two numbers")
        };
        assert_ne!(bent.at(x, y), WHITE, "{sphere}");
    }
    // Every vertex that a triangle uses lies in one of them.
    let used = ball_mesh()
        .triangles
        .into_iter()
        .flatten()
        .max()
        .expect("triangles");
    for p in &folder.deformed("a.bdt", "1.5,1,-2")[..=used as usize] {
        let holds = |sphere: &Value| {
            let c = numbers(&sphere["center"]);
            let square: f64 = (0..3).map(|k| (p[k] - c[k]).powi(2)).sum();
            square.sqrt() <= sphere["radius"].as_f64().expect("a number") * (1.0 + 1e-9)
        };
        assert!(spheres.iter().any(holds), "{p:?}");
    }
    // No sphere is smaller than the smallest ball, and the smallest is larger than at rest here.
    let (_, tight) = draw("1.5,1,-2", &["--against", "deformed"]);
    for sphere in tight["spheres"].as_array().expect("a list") {
        assert!(
            sphere["growth"].as_f64().expect("a number") > 1.0 - 1e-6,
            "{sphere}"
        );
    }
    assert!(growth(&tight)[0] < mean);
}

#[test]
fn frames_are_drawn_one_by_one_by_the_same_camera() {
    let folder = Folder::new();
    let mesh = ball_mesh();
    folder.write("moves.bdt", baked(&mesh, &animated(&mesh)));
    let out = folder.render(&[
        "moves.bdt",
        "--frames",
        "0..2",
        "-o",
        "f_%03d.png",
        "--json",
    ]);
    let reports: Vec<Value> = out
        .lines()
        .map(|l| serde_json::from_str(l).expect("JSON"))
        .collect();
    let pictures: Vec<_> = (0..3)
        .map(|i| {
            assert_eq!(reports[i]["frame"], i);
            assert_eq!(reports[i]["output"], format!("f_00{i}.png"));
            folder.read(&format!("f_00{i}.png"))
        })
        .collect();
    assert_ne!(pictures[0], pictures[1]);
    assert_ne!(pictures[1], pictures[2]);
    assert_eq!(
        fs::read_dir(folder.root()).expect("a folder").count(),
        3 + 3
    );
    // Frame 1 is turned about x, which the same q alone is not.
    let turned = folder.plain(&["moves.bdt", "--frame", "1"]);
    assert!(turned != folder.plain(&["moves.bdt", "--q", "0.5,-0.25,1"]));
    // Frame 0 is at rest.
    let first = folder.plain(&["moves.bdt", "--frame", "0"]);
    assert!(first == folder.plain(&["moves.bdt"]));
}

#[test]
fn a_line_says_what_was_written() {
    let folder = Folder::new();
    let mesh = ball_mesh();
    folder.write("moves.bdt", baked(&mesh, &animated(&mesh)));
    let scene = json!({
        "instances": [{"name": "a", "asset": "a.bdt"}],
        "queries": [{"closest": {"instance": "a", "point": [10, -1, 2]}}],
    });
    let (_, report) = folder.asked("a.bdt", &scene, &[]);
    let visited = &report["nodes_visited"];
    let ends = report["spheres"].as_array().expect("a list").len();
    let (_, level) = folder.reported(&["a.bdt", "--spheres", "1"]);
    let of_level = level["spheres"].as_array().expect("a list").len();
    for (arguments, expected) in [
        (
            &["a.bdt", "-o", "out.png"][..],
            "wrote out.png: 320 x 240 pixels\n".to_string(),
        ),
        (
            &["a.bdt", "-o", "out.png", "--spheres", "1"],
            format!("wrote out.png: 320 x 240 pixels, level 1, {of_level} spheres\n"),
        ),
        (
            &["a.bdt", "-o", "out.png", "--query", "scene.json"],
            format!("wrote out.png: 320 x 240 pixels, {visited} nodes visited, {ends} spheres\n"),
        ),
        (
            &["moves.bdt", "-o", "%d.png", "--frames", "0..1"],
            "wrote 0.png: 320 x 240 pixels, frame 0\nwrote 1.png: 320 x 240 pixels, frame 1\n"
                .to_string(),
        ),
    ] {
        assert_eq!(folder.render(arguments), expected, "{arguments:?}");
    }
}

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
        let dark = count(|p| p.iter().all(|c| *c < 60));
        let light = count(|p| p.iter().all(|c| *c > 235));
        assert!(dark > 10 && light > 5, "{query}: {dark} {light}");
    }
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
        let (_, report) = folder.asked("moves.bdt", &scene, more);
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

#[test]
fn what_does_not_fit_is_told() {
    let folder = Folder::new();
    let scene = json!({"instances": [{"name": "r", "asset": "rigid.bdt"}], "queries": []});
    folder.write("other.json", scene.to_string());
    let mut broken = folder.read("a.bdt");
    *broken.last_mut().expect("bytes") ^= 1;
    folder.write("broken.bdt", broken);
    for (arguments, expected) in [
        (
            &["none.bdt", "-o", "out.png"][..],
            "cannot read none.bdt: No such file or directory (os error 2)",
        ),
        (
            &["a.bdt", "-o", "none/out.png"],
            "none/out.png: cannot write: No such file or directory (os error 2)",
        ),
        (
            &["a.bdt", "-o", "out.png", "--q", "1"],
            "--q: q has 1 number, asset a.bdt has 3 modes",
        ),
        (
            &["a.bdt", "-o", "out.png", "--q", "0,nan,0"],
            "--q: q[1]: not a finite number",
        ),
        (
            &["a.bdt", "-o", "out.png", "--frame", "0"],
            "--frame: asset a.bdt has no animation",
        ),
        (
            &["a.bdt", "-o", "out.png", "--frames", "0..1"],
            "out.png: has no place for the frame's number: write it as %d or %04d",
        ),
        (
            &["a.bdt", "-o", "%d.png", "--frames", "0..1"],
            "--frames: asset a.bdt has no animation",
        ),
        (
            &["a.bdt", "-o", "%d.png", "--frames", "0..99999999999"],
            "--frames: asset a.bdt has no animation",
        ),
        (
            &["a.bdt", "-o", "out.png", "--spheres", "9"],
            "--spheres: 9 is out of range: asset a.bdt has 3 levels, numbered from 0",
        ),
        (
            &["a.bdt", "-o", "out.png", "--query", "other.json"],
            "other.json: no instance of a.bdt",
        ),
        (
            &["a.bdt", "-o", "out.png", "--query", "none.json"],
            "cannot read none.json: No such file or directory (os error 2)",
        ),
        (
            &["a.bdt", "-o", "out.png", "--size", "100000x2"],
            "width of the picture: 100000 pixels, the graphics device takes at most ",
        ),
    ] {
        let said = folder.refusal(arguments);
        let is_said = if expected.ends_with(' ') {
            said.starts_with(expected)
        } else {
            said == expected
        };
        assert!(is_said, "{arguments:?}: {said}");
        assert!(!folder.path("out.png").exists());
    }
    let ran = folder.run(&["render", "a.bdt", "-o", "out.jpg"]);
    let text = "out.jpg: unknown extension: .png can be written\n";
    assert_eq!((ran.code, ran.err.as_str()), (2, text));
    let said = folder.refusal(&["broken.bdt", "-o", "out.png"]);
    assert!(
        said.starts_with("broken.bdt: damaged .bdt file: section "),
        "{said}"
    );
    folder.write("a.png", folder.read("a.bdt"));
    assert_eq!(
        folder.refusal(&["a.png", "-o", "a.png"]),
        "a.png: is the input: it would be overwritten"
    );
    assert_eq!(folder.read("a.png"), folder.read("a.bdt"));
}

#[test]
fn without_an_adapter_there_is_one_clear_line() {
    let folder = Folder::new();
    let output = Command::new(env!("CARGO_BIN_EXE_bdtree"))
        .args(["render", "a.bdt", "-o", "out.png"])
        .current_dir(folder.root())
        // The Vulkan loader finds no driver there, by either of its names for the list.
        .env("VK_DRIVER_FILES", "none.json")
        .env("VK_ICD_FILENAMES", "none.json")
        .output()
        .expect("bdtree starts");
    let said = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(1), "{said}");
    let mut lines = said
        .lines()
        .filter(|line| line.starts_with("no graphics adapter for Vulkan"));
    assert!(
        lines
            .next()
            .is_some_and(|line| line.contains("mesa-vulkan-drivers")),
        "{said}"
    );
    assert!(!said.contains("panicked"), "{said}");
}

#[test]
fn shapes_of_any_size_and_place_fill_the_picture() {
    let folder = Folder::new();
    for (factor, away) in [(1e-12, 0.0), (1e12, 0.0), (1.0, 1e6)] {
        let mut mesh = ball_mesh();
        for p in &mut mesh.positions {
            *p = p.map(|x| factor * x + away);
        }
        let rigid = bdtree_build::basis::Basis {
            vertex_count: mesh.positions.len(),
            ..Default::default()
        };
        folder.write("odd.bdt", baked(&mesh, &rigid));
        let picture = folder.picture(&["odd.bdt", "--no-legend", "--spheres", "1"]);
        let covered = picture.covered();
        assert!((0.3..0.8).contains(&covered), "{factor} {away}: {covered}");
    }
}
