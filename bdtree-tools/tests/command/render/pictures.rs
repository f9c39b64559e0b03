//! What is in a picture of a mesh and its spheres, and where.

use std::fs;

use serde_json::{Value, json};

use crate::drawn::{Picture, WHITE, numbers, spheres_hold};
use crate::support::{Folder, baked, ball_mesh};

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
    // Where none is drawn it takes no room: the picture is that without it.
    for view in ["0,-30", "60,-20", "0,-90"] {
        let below = ["a.bdt", "--no-legend", "--view", view];
        let shaded = folder.picture(&[&below[..], &["--shadow"]].concat());
        assert_eq!(shaded.share(is_shadow), 0.0, "{view}");
        assert!(shaded.pixels == folder.picture(&below).pixels, "{view}");
    }
    // With another axis up it lies elsewhere.
    let turned = folder.picture(&[&view[..], &["--shadow", "--up", "-y"]].concat());
    assert!(turned.share(is_shadow) > 0.03);
    // The sides of a cube stand straight: it throws one to the right.
    let side = |axis: usize, at: f64| {
        let corner = |a: f64, b: f64| {
            let mut p = [at; 3];
            (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (a, b);
            p
        };
        [
            corner(0.0, 0.0),
            corner(1.0, 0.0),
            corner(1.0, 1.0),
            corner(0.0, 1.0),
        ]
    };
    let sides = (0..3).flat_map(|axis| [0.0, 1.0].map(|at| side(axis, at)));
    let mut mesh = ball_mesh();
    mesh.groups.clear();
    mesh.positions = sides.flatten().collect();
    mesh.triangles = (0..6)
        .flat_map(|k| [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|v| 4 * k + v)))
        .collect();
    let rigid = bdtree_build::basis::Basis {
        vertex_count: mesh.positions.len(),
        ..Default::default()
    };
    folder.write("cube.bdt", baked(&mesh, &rigid));
    let cube = folder.picture(&["cube.bdt", "--no-legend", "--view", "30,20", "--shadow"]);
    assert!(cube.share(is_shadow) > 0.02, "{}", cube.share(is_shadow));
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
    // A longer scale has its last color for greater growth only.
    let longer = draw(&["--no-legend", "--scale-max", "9"]);
    assert_eq!(longer.share(is_red), 0.0);
    let all_colors = draw(&["--scale-max", "9"]);
    assert!(all_colors.share(is_red) > 0.0, "the legend's bar has all");
    let spheres = ["--spheres", "1"];
    for wrong in [
        &["--scale", "jet"][..],
        &["--scale-max", "2"],
        &[&spheres[..], &["--scale-max", "1"]].concat(),
        &[&spheres[..], &["--scale-max", "nan"]].concat(),
    ] {
        let ran = folder.run(&[&["render", "a.bdt", "-o", "none.png"], wrong].concat());
        assert_eq!(ran.code, 2, "{wrong:?}: {}", ran.err);
    }
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
    let vertices = folder.deformed("a.bdt", "1.5,1,-2");
    spheres_hold(spheres, &vertices[..=used as usize]);
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

/// Leaves above it are drawn with a level: without them the spheres would leave some of the mesh bare.
#[test]
fn spheres_of_every_level_hold_the_mesh() {
    let folder = Folder::new();
    let mut vertices = folder.deformed("a.bdt", "1.5,1,-2");
    // The last one is of no triangle.
    vertices.pop();
    let mut count_before = 0;
    for level in ["0", "1", "2"] {
        let asked = ["a.bdt", "--q=1.5,1,-2", "--spheres", level];
        let (_, report) = folder.reported(&asked);
        let spheres = report["spheres"].as_array().expect("a list");
        spheres_hold(spheres, &vertices);
        assert!(spheres.len() > count_before, "{level}");
        count_before = spheres.len();
    }
    let written = folder.render(&["a.bdt", "--spheres", "2", "-o", "out.png"]);
    assert!(written.contains(" leaves above it"), "{written}");
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
