//! What summaries, warnings and refusals say.

use super::{baked, fixture, refused, run, text};

/// What the summary says of animations and rigid meshes, and of faces that are bad.
#[test]
fn summaries_and_refusals_say_what_to_do() {
    let folder = tempfile::tempdir().expect("a folder");
    let wave = fixture("wave").display().to_string();
    let said = |arguments: &[&str]| {
        let ran = run(arguments, folder.path());
        assert!(ran.status.success(), "{}", text(&ran.stderr));
        (text(&ran.stdout), text(&ran.stderr))
    };
    let (summary, _) = said(&["--animation", &wave, "-o", "w.bdt", "--modes", "2"]);
    for part in [
        "animation: 6 frames, times unknown (give --fps)\n",
        "error of the basis: at most ",
        " % of the diagonal (vertex ",
        "sphere radius over the smallest possible, per level: ",
    ] {
        assert!(summary.contains(part), "no `{part}` in {summary}");
    }
    let (summary, _) = said(&["--animation", &wave, "-o", "w.bdt", "--fps", "10"]);
    assert!(
        summary.contains("animation: 6 frames, 0.5 s\n"),
        "{summary}"
    );
    let cube = fixture("cube.obj").display().to_string();
    let (summary, _) = said(&[&cube, "-o", "c.bdt", "--modes", "0"]);
    assert!(
        summary.contains("rigid: spheres do not grow\n"),
        "{summary}"
    );
    assert!(!summary.contains("smallest possible"), "{summary}");
    // Rounding is no size; a basis that leaves nothing has no error; an option is refused for one reason.
    let (summary, _) = said(&["--animation", &wave, "-o", "w.bdt"]);
    assert!(
        summary.contains("size: 1.6 x 1 x 0 mesh units"),
        "{summary}"
    );
    let tube = fixture("skinned_tube.glb").display().to_string();
    let (summary, warned) = said(&[&tube, "-o", "t.bdt", "--clip", "wave"]);
    assert!(summary.contains("error of the basis: none\n"), "{summary}");
    assert_eq!(warned.matches("--clip").count(), 1, "{warned}");
    let beam = fixture("beam.obj").display().to_string();
    let (summary, _) = said(&[&beam, "-o", "m.bdt", "--modes", "21", "--resolution", "8"]);
    assert!(
        summary.contains(" … (--json shows all)\nhighest mode"),
        "{summary}"
    );
    let bent = fixture("skinned_12.glb").display().to_string();
    let (summary, _) = said(&[&bent, "-o", "b.bdt"]);
    let bones = "spheres grow with the bones only: there are no modes\n";
    assert!(summary.contains(bones), "{summary}");

    let mut mesh = std::fs::read_to_string(fixture("cube.obj")).expect("a fixture");
    let line = mesh.lines().count() + 1;
    let vertices = mesh.lines().filter(|line| line.starts_with("v ")).count();
    mesh += "f 1 2 99999999\nf 1 1 2\nf 1 2 x\n";
    std::fs::create_dir(folder.path().join("in")).expect("a folder");
    std::fs::write(folder.path().join("in/bad.obj"), mesh).expect("written");
    let wrong = format!("corner 3 `99999999` is out of range: the file has {vertices} vertices");
    let arguments = ["in/bad.obj", "-o", "b.bdt", "--modes", "0"];
    let told = text(&run(&arguments, folder.path()).stderr);
    let all = format!(
        "bdtree-build: in/bad.obj:{line}: {wrong} (--skip-bad-faces leaves such faces out)\n"
    );
    assert!(told.contains(&all), "{told}");
    assert_eq!(told.matches("--skip-bad-faces").count(), 1, "{told}");
    let (_, told) = said(&[&arguments[..], &["--skip-bad-faces"]].concat());
    let told: Vec<&str> = told.lines().collect();
    let warning = "bdtree-build: warning: in/bad.obj";
    assert_eq!(told[0], format!("{warning}:{line}: skipped: {wrong}"));
    assert!(
        told[1].starts_with(&format!("{warning}:{}: triangle ", line + 1)),
        "{told:?}"
    );
    assert!(
        told[2].starts_with(&format!("{warning}:{}: skipped: corner 3", line + 2)),
        "{told:?}"
    );
    refused(&["."], 1, &["bdtree-build: "]);
    refused(
        &[&cube, "--modes", "0", "-o", "."],
        1,
        &["bdtree-build: . is a folder: name a file\n"],
    );
}

#[test]
fn bad_faces_are_grouped_or_skipped() {
    let folder = tempfile::tempdir().expect("a folder");
    // Skipping helps neither a file without vertices nor one whose faces are all bad.
    let points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (name, content, skips, why) in [
        ("none.obj", "f 1 2 3\n".to_string(), false, "no vertices"),
        (
            "one.obj",
            format!("{points}f 1 2 4\n"),
            true,
            "its only face is bad",
        ),
        (
            "two.obj",
            format!("{points}f 1 2 4\nf 1 2\n"),
            true,
            "all 2 faces are bad",
        ),
    ] {
        std::fs::write(folder.path().join(name), content).expect("written");
        let option: &[&str] = if skips { &["--skip-bad-faces"] } else { &[] };
        let ran = run(&[&[name, "--modes", "0"], option].concat(), folder.path());
        let told = text(&ran.stderr);
        assert_eq!(ran.status.code(), Some(1), "{told}");
        assert!(told.contains(why), "{told}");
        assert!(!told.contains("--skip-bad-faces"), "{told}");
    }
    let mut mesh =
        String::from_utf8(std::fs::read(fixture("cube.obj")).expect("a fixture")).expect("a text");
    for _ in 0..201 {
        mesh += "\nf 1 2";
    }
    std::fs::write(folder.path().join("many.obj"), mesh).expect("written");
    let ran = run(&["many.obj", "--modes", "0"], folder.path());
    let told = text(&ran.stderr);
    assert_eq!(
        (ran.status.code(), told.lines().count()),
        (Some(1), 2),
        "{told}"
    );
    assert!(
        told.contains("found 2 (and 99 problems like it, at line "),
        "{told}"
    );
    assert!(told.contains("101 more problems"), "{told}");
    let json = baked(
        &["many.obj", "--modes", "0", "--skip-bad-faces"],
        folder.path(),
    );
    let warnings = json["warnings"].as_array().expect("a list");
    assert_eq!(warnings.len(), 6);
    assert_eq!(
        warnings[5],
        "many.obj: skipped 201 bad faces: triangle ids count the others"
    );
}

/// The summary says how large the mesh is, and warns where its unit is probably not the meter.
#[test]
fn sizes_are_told_and_doubted() {
    let folder = tempfile::tempdir().expect("a folder");
    let cube = std::fs::read_to_string(fixture("cube.obj")).expect("a fixture");
    let large: String = cube
        .lines()
        .map(|line| match line.strip_prefix("v ") {
            Some(position) => {
                let grown = position.split_whitespace().map(|x| format!("{x}e3"));
                format!("v {}\n", grown.collect::<Vec<_>>().join(" "))
            }
            None => format!("{line}\n"),
        })
        .collect();
    std::fs::write(folder.path().join("large.obj"), large).expect("written");
    let bake = |options: &[&str]| {
        let arguments = [&["large.obj", "--modes", "2", "--resolution", "4"], options].concat();
        let ran = run(&arguments, folder.path());
        assert!(ran.status.success(), "{}", text(&ran.stderr));
        (text(&ran.stdout), text(&ran.stderr))
    };
    let (summary, warnings) = bake(&[]);
    assert!(summary.contains("1 mesh unit = 1 m (--scale)"), "{summary}");
    assert!(
        summary.contains("size: ") && summary.contains("bounds: spheres are "),
        "{summary}"
    );
    assert!(
        warnings.contains("give --scale (meters per mesh unit) if that is wrong"),
        "{warnings}"
    );
    let (summary, warnings) = bake(&["--scale", "0.001"]);
    assert!(
        summary.contains("1 mesh unit = 0.001 m (--scale)"),
        "{summary}"
    );
    assert_eq!(warnings, "");
}
