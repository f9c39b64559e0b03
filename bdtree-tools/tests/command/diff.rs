//! `diff`: same, differ, unreadable; structure exactly, numbers within a tolerance.

use bdtree_build::recipe::Motion;
use bdtree_fixtures::models;

use crate::support::{
    Folder, baked, baked_surface, baked_with, ball_mesh, basis, bounds, character,
};

#[test]
fn equal_files_are_the_same() {
    let folder = Folder::new();
    folder.write("b.bdt", folder.read("a.bdt"));
    let ran = folder.run(&["diff", "a.bdt", "b.bdt"]);
    assert_eq!(
        (ran.code, ran.out.as_str(), ran.err.as_str()),
        (0, "same\n", "")
    );
}

#[test]
fn numbers_are_compared_within_the_tolerance() {
    let folder = Folder::new();
    let mesh = ball_mesh();
    let mut moved = basis(&mesh);
    for u in &mut moved.fields[..mesh.positions.len()] {
        u[0] *= 1.0 + 1e-5;
    }
    folder.write("b.bdt", baked(&mesh, &moved));
    let ran = folder.run(&["diff", "a.bdt", "b.bdt"]);
    assert_eq!((ran.code, ran.err.as_str()), (1, ""));
    for text in [
        "section DISP: displacements of mode 0: ",
        "section ROWS: mean displacement and growth of mode 0: ",
        "    vertex ",
        "    node 0 row ",
        "    …",
    ] {
        assert!(ran.out.contains(text), "{text}: {}", ran.out);
    }
    for text in ["VERT", "of mode 1", "NODE", "TRIS"] {
        assert!(!ran.out.contains(text), "{text}: {}", ran.out);
    }
    let ran = folder.run(&["diff", "a.bdt", "b.bdt", "--tolerance-rel", "1e-4"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""), "{}", ran.out);
    assert!(ran.out.starts_with("same: numbers differ by at most "));
    let ran = folder.run(&["diff", "a.bdt", "b.bdt", "--tolerance-rel", "1e-7"]);
    assert_eq!(ran.code, 1, "{}", ran.out);
}

/// Files whose vertices list their modes, against each other and against one with all modes.
#[test]
fn local_fields_are_compared_too() {
    let folder = Folder::new();
    let mesh = ball_mesh();
    let mut local = basis(&mesh);
    let n = mesh.positions.len();
    for (k, u) in local.fields.iter_mut().enumerate() {
        if mesh.positions[k % n][2] < 0.4 * (k / n) as f64 {
            *u = [0.0; 3];
        }
    }
    folder.write("local.bdt", baked(&mesh, &local));
    let ran = folder.run(&["diff", "local.bdt", "local.bdt"]);
    assert_eq!((ran.code, ran.out.as_str()), (0, "same\n"));
    let moved = (0..n).rfind(|i| local.fields[*i][0].abs() > 0.1);
    let moved = moved.expect("a vertex that moves");
    local.fields[moved][0] *= 1.0 + 1e-5;
    folder.write("number.bdt", baked(&mesh, &local));
    let ran = folder.run(&["diff", "local.bdt", "number.bdt"]);
    assert_eq!((ran.code, ran.err.as_str()), (1, ""));
    assert!(
        ran.out
            .contains("section DISP: displacements of mode 0: 1 of ")
    );
    assert!(ran.out.contains(&format!("    vertex {moved} x: ")));
    assert!(!ran.out.contains("of mode 1") && !ran.out.contains("VMOD"));
    let ran = folder.run(&["diff", "local.bdt", "number.bdt", "--tolerance-rel", "1e-4"]);
    assert_eq!(ran.code, 0, "{}", ran.out);

    local.fields[moved] = [0.0; 3];
    folder.write("fewer.bdt", baked(&mesh, &local));
    for (file, texts) in [
        ("fewer.bdt", &["section VMOD: modes of vertices: "][..]),
        (
            "a.bdt",
            &[
                "section table (kind, layout, required) differs",
                "DISP: layout ",
            ],
        ),
    ] {
        let ran = folder.run(&["diff", "local.bdt", file, "--tolerance-rel", "1e-4"]);
        assert_eq!((ran.code, ran.err.as_str()), (1, ""), "{file}");
        for text in texts
            .iter()
            .chain(&["section DISP: displacements of mode 0: "])
        {
            assert!(ran.out.contains(text), "{file}: {text}: {}", ran.out);
        }
    }
}

#[test]
fn structure_is_compared_exactly() {
    let folder = Folder::new();
    let mesh = ball_mesh();
    let mut other = mesh.clone();
    other.triangles.swap(0, 100);
    folder.write("ids.bdt", baked(&other, &basis(&mesh)));
    let mut other = mesh.clone();
    other.groups[1].name = "upper".to_string();
    folder.write("group.bdt", baked(&other, &basis(&mesh)));
    let mut named = basis(&mesh);
    named.modes[1].name = Some("twist".to_string());
    named.modes[1].modal_mass_kg = Some(2.0);
    folder.write("mode.bdt", baked(&mesh, &named));
    let mut other = mesh.clone();
    other.positions.pop();
    let fields = basis(&other);
    folder.write("vertex.bdt", baked(&other, &fields));
    for (file, texts) in [
        (
            "rigid.bdt",
            &[
                "header: mode_count differs: 3 modes and 0 modes\n",
                "\nnot compared, since the structure differs: ranges and displacements of modes, spheres of the tree\n",
            ][..],
        ),
        (
            "ids.bdt",
            &[
                "section TRIS: triangles in leaf order: ",
                " of 252 differ\n    slot ",
                ": triangle ",
                "section SLOT: triangle slots: ",
            ],
        ),
        (
            "group.bdt",
            &["section GRPS: groups: 1 of 4 differ\n    group 1: name top and upper\n"],
        ),
        (
            "mode.bdt",
            &[
                "section META: modes differ: mode 1: name unknown and twist\n",
                "mode table: modal_mass_kg: known or not, mode 1 differs: unknown and 2\n",
            ],
        ),
        (
            "vertex.bdt",
            &["header: vertex_count differs: 141 and 140\n"],
        ),
    ] {
        let ran = folder.run(&["diff", "a.bdt", file, "--tolerance-rel", "10"]);
        assert_eq!((ran.code, ran.err.as_str()), (1, ""), "{file}: {}", ran.out);
        for text in texts {
            assert!(ran.out.contains(text), "{file}: {text}: {}", ran.out);
        }
        // The number of modes is told once, not with every node.
        let nodes = ran.out.contains("NODE") || ran.out.contains("LIST");
        assert!(file != "rigid.bdt" || !nodes, "{}", ran.out);
        for debug in ["Some(", " { ", "[(", "[\""] {
            assert!(!ran.out.contains(debug), "{file}: {debug}: {}", ran.out);
        }
    }
}

/// The name of what was baked is told, and counts neither by itself nor in warnings.
#[test]
fn a_renamed_source_is_the_same() {
    let folder = Folder::new();
    let mut mesh = ball_mesh();
    mesh.warnings = vec![format!("{}:7: triangle 3 has zero area", mesh.name)];
    folder.write("first.bdt", baked(&mesh, &basis(&mesh)));
    mesh.name = "boule.obj".to_string();
    mesh.warnings = vec!["boule.obj:7: triangle 3 has zero area".to_string()];
    folder.write("renamed.bdt", baked(&mesh, &basis(&mesh)));
    let ran = folder.run(&["diff", "first.bdt", "renamed.bdt"]);
    let text = "name of the source (does not count): ball.obj and boule.obj\nsame\n";
    assert_eq!((ran.code, ran.out.as_str()), (0, text));
    mesh.warnings = vec!["boule.obj:8: triangle 3 has zero area".to_string()];
    folder.write("other.bdt", baked(&mesh, &basis(&mesh)));
    let ran = folder.run(&["diff", "first.bdt", "other.bdt"]);
    assert_eq!(ran.code, 1);
    let told = "section META: warnings differ\n    \
                only the first file: ball.obj:7: triangle 3 has zero area\n    \
                only the second file: boule.obj:8: triangle 3 has zero area\n";
    assert!(ran.out.contains(told), "{}", ran.out);
    // A name that is a word of the warning, and inputs beside the mesh.
    let with = |name: &str, folder_name: &str, list: &str| {
        let mut mesh = ball_mesh();
        mesh.name = name.to_string();
        mesh.warnings = vec![
            format!("{name}: the 6 frames have 4 components"),
            format!("{folder_name}/0.obj:2: odd"),
        ];
        let settings = [
            ("animation", folder_name),
            ("skin-weights", list),
            ("fix", list),
        ];
        baked_with(&mesh, &basis(&mesh), &settings)
    };
    folder.write("first.bdt", with("wave", "wave", "xyz:@w.txt"));
    folder.write("renamed.bdt", with("frames", "frames", "xyz:@v.txt"));
    let ran = folder.run(&["diff", "first.bdt", "renamed.bdt"]);
    assert_eq!(ran.code, 0, "{}", ran.out);
    folder.write("other.bdt", with("wave", "wave", "xy:@w.txt"));
    let ran = folder.run(&["diff", "first.bdt", "other.bdt"]);
    assert!(
        ran.out.contains("setting fix: xyz:@ and xy:@"),
        "{}",
        ran.out
    );
}

/// How far the farthest vertex lies apart, against what was changed.
#[test]
fn effects_are_distances_of_vertices() {
    let folder = Folder::new();
    let mesh = ball_mesh();
    let mut changed = mesh.clone();
    changed.positions[17][1] += 0.25;
    let mut fields = basis(&mesh);
    fields.fields[mesh.positions.len() + 40][2] += 0.5; // mode 1, whose q_range is 2
    folder.write("b.bdt", baked(&changed, &fields));
    let json: serde_json::Value = {
        let ran = folder.run(&["diff", "a.bdt", "b.bdt", "--json"]);
        assert_eq!((ran.code, ran.err.as_str()), (1, ""));
        serde_json::from_str(&ran.out).expect("one JSON object")
    };
    assert_eq!(json["same"], false);
    let effects = json["effects"].as_array().expect("a list");
    let [low, high] = bounds(&mesh);
    let squares = [0, 1, 2].map(|k| (high[k] - low[k]).powi(2));
    let diagonal = squares.iter().sum::<f64>().sqrt();
    for (effect, (what, vertex, distance)) in effects
        .iter()
        .zip([("rest positions", 17, 0.25), ("mode 1", 40, 1.0)])
    {
        assert_eq!(
            (effect["what"].as_str(), effect["vertex"].as_u64()),
            (Some(what), Some(vertex))
        );
        let found = effect["distance"].as_f64().expect("a number");
        assert!((found - distance).abs() < 1e-6, "{effect}");
        let relative = effect["distance_rel"].as_f64().expect("a number");
        assert!((relative - distance / diagonal).abs() < 1e-6, "{effect}");
    }
    assert_eq!(effects.len(), 2);
    let ran = folder.run(&["diff", "a.bdt", "b.bdt"]);
    for text in [
        "rest positions: vertex 17 lies farthest apart, by 0.25 mesh units (",
        "mode 1: vertex 40 lies farthest apart, by 1 mesh units (",
        "% of the diagonal), at q = 2 (its q_range)\n",
    ] {
        assert!(ran.out.contains(text), "{text}: {}", ran.out);
    }
    // With a tolerance above one of the two, that one is marked.
    let ran = folder.run(&["diff", "a.bdt", "b.bdt", "--tolerance-rel", "0.3"]);
    assert_eq!(ran.code, 1, "{}", ran.out);
    let lines: Vec<&str> = ran.out.lines().filter(|l| l.contains("farthest")).collect();
    assert!(lines[0].ends_with(" (tolerated)"), "{}", ran.out);
    assert!(!lines[1].ends_with(" (tolerated)"), "{}", ran.out);
    // Where only the metadata differ beyond it, both are.
    let settings = [("leaf-size", "5")];
    folder.write("c.bdt", baked_with(&changed, &fields, &settings));
    let ran = folder.run(&["diff", "a.bdt", "c.bdt", "--tolerance-rel", "2"]);
    assert_eq!(ran.code, 1, "{}", ran.out);
    let marked = ran.out.lines().filter(|l| l.ends_with(" (tolerated)"));
    assert_eq!(marked.count(), 2, "{}", ran.out);
    let json = folder.json(&["diff", "a.bdt", "a.bdt", "--json"]);
    assert_eq!(json["same"], true);
    assert_eq!(json["effects"], serde_json::json!([]));
}

/// The sign of a mode is arbitrary: it says so instead of only that vertices lie far apart.
#[test]
fn negated_modes_are_told() {
    let folder = Folder::new();
    let mesh = ball_mesh();
    let mut fields = basis(&mesh);
    for u in &mut fields.fields[mesh.positions.len()..] {
        *u = u.map(|u| -u);
    }
    folder.write("negated.bdt", baked(&mesh, &fields));
    let ran = folder.run(&["diff", "a.bdt", "negated.bdt"]);
    assert_eq!(ran.code, 1);
    let line = "(its q_range); the mode is negated: -q leaves nothing\n";
    assert!(ran.out.contains(line), "{}", ran.out);
    let last = fields.fields.len() - 1;
    fields.fields[last][0] += 1e-3; // q_range is 2
    folder.write("nearly.bdt", baked(&mesh, &fields));
    let ran = folder.run(&["diff", "a.bdt", "nearly.bdt", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&ran.out).expect("one JSON object");
    let left = json["effects"][1]["negated_distance"].as_f64();
    assert!((left.expect("a distance") - 2e-3).abs() < 1e-6, "{json}");
}

/// An artist knows clips by their names, not by bytes of a section.
#[test]
fn clips_that_differ_are_named() {
    let folder = Folder::new();
    folder.write("tube.bdt", character("skinned_tube.glb"));
    let source = std::fs::read(models::path("skinned_tube.glb")).expect("read");
    // As long as before, so that the binary chunk's place stays.
    let replaced = |old: &str, new: &str| {
        let at = source.windows(old.len()).position(|w| w == old.as_bytes());
        let at = at.unwrap_or_else(|| panic!("no {old}"));
        let mut bytes = source.clone();
        bytes[at..at + new.len()].copy_from_slice(new.as_bytes());
        let path = folder.path("tube.glb");
        std::fs::write(&path, bytes).expect("written");
        let motion = Motion::MorphsElseSkin(Default::default(), Default::default());
        baked_surface(path, motion)
    };
    for (old, new, told) in [
        (
            "\"name\":\"slide\"",
            "\"name\":\"glide\"",
            "section CLIP: clips differ: clip 1: \"slide\", 1.5 s and \"glide\", 1.5 s\n",
        ),
        (
            "\"node\":1,\"path\":\"translation\"",
            "\"node\":4,\"path\":\"translation\"",
            "section CHAN: channels of clips differ: first in \"slide\"\n",
        ),
    ] {
        folder.write("other.bdt", replaced(old, new));
        let ran = folder.run(&["diff", "tube.bdt", "other.bdt"]);
        assert_eq!((ran.code, ran.err.as_str()), (1, ""), "{}", ran.out);
        assert!(ran.out.contains(told), "{}", ran.out);
    }
}

#[test]
fn unreadable_files_are_2() {
    let folder = Folder::new();
    folder.write("text.bdt", "not a tree");
    for (a, b, text) in [
        ("a.bdt", "no.bdt", "no.bdt: cannot be read: "),
        ("text.bdt", "a.bdt", "text.bdt: not a .bdt file (SPEC 9.1"),
    ] {
        let ran = folder.run(&["diff", a, b]);
        assert_eq!((ran.code, ran.out.as_str()), (2, ""));
        assert!(ran.err.starts_with(text), "{}", ran.err);
    }
}

/// A copy with one bit changed anywhere, padding included, is not the same, whatever the tolerance.
#[test]
fn damaged_copies_are_2() {
    let folder = Folder::new();
    let sound = folder.read("a.bdt");
    for at in (0..sound.len()).step_by(sound.len() / 60) {
        let mut damaged = sound.clone();
        damaged[at] ^= 1;
        folder.write("b.bdt", &damaged);
        for (a, b) in [("a.bdt", "b.bdt"), ("b.bdt", "a.bdt")] {
            let ran = folder.run(&["diff", a, b, "--tolerance-rel", "10"]);
            assert_eq!((ran.code, ran.out.as_str()), (2, ""), "byte {at}");
            assert!(ran.err.contains("b.bdt"), "byte {at}: {}", ran.err);
        }
    }
}
