//! `report`: its page and its figures, on assets of every kind.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use bdtree_build::basis::Basis;
use bdtree_build::input::RawMesh;
use bdtree_build::progress::Silent;
use bdtree_build::recipe::{Motion, Recipe};
use bdtree_fixtures::models;
use serde_json::Value;

use crate::drawn::Picture;
use crate::support::{Folder, animated, baked, ball_mesh};

impl Folder {
    /// The figures and the page of an asset; of each picture its first letters only, for any word may be in it.
    fn report(&self, name: &str) -> (Value, String) {
        let ran = self.run(&["report", name, "--json", "-o", "out.html"]);
        assert_eq!(ran.code, 0, "{name}: {}", ran.err);
        assert!(tells_parts(&ran.err), "{name}: {}", ran.err);
        let figures = serde_json::from_str(&ran.out).expect("one JSON object");
        let page = String::from_utf8(self.read("out.html")).expect("UTF-8");
        let mut parts = page.split("base64,");
        let mut short = parts.next().expect("a page").to_string();
        for part in parts {
            let (picture, rest) = part.split_once('"').expect("an end");
            short += &format!("base64,{:.5}\"{rest}", picture);
        }
        (figures, short)
    }

    /// The first picture of the page of an asset without modes.
    fn portrait(&self, options: &[&str]) -> Picture {
        let ran = self.run(&[&["report", "rigid.bdt", "-o", "out.html"], options].concat());
        assert_eq!(ran.code, 0, "{options:?}: {}", ran.err);
        let page = String::from_utf8(self.read("out.html")).expect("UTF-8");
        let picture = page
            .split("base64,")
            .nth(1)
            .and_then(|p| p.split('"').next());
        let picture = STANDARD.decode(picture.expect("a picture"));
        self.write("out.png", picture.expect("base 64"));
        Picture::read(&self.path("out.png"))
    }
}

/// Whether there is a line for each part that was begun, and nothing else.
fn tells_parts(err: &str) -> bool {
    let mut lines = err.lines();
    lines.next() == Some("measuring levels") && lines.all(|line| line.starts_with("measuring "))
}

fn list<'v>(value: &'v Value, name: &str) -> &'v [Value] {
    value[name].as_array().expect("a list")
}

fn number(value: &Value, name: &str) -> f64 {
    let number = value[name].as_f64();
    number.unwrap_or_else(|| panic!("{name} of {value} is no number"))
}

/// The figures without what differs between runs: times and what follows from them.
fn without_times(value: &Value) -> Value {
    match value {
        Value::Object(map) => {
            const STANDING: [&str; 6] = ["ahead", "below", "above", "from", "to", "break_even"];
            let is_timed = |key: &str| {
                key.contains("micros")
                    || ["seconds", "ratio", "time_rel", "advice", "date", "verdict"].contains(&key)
                    || STANDING.contains(&key)
            };
            let kept = map.iter().filter(|(key, _)| !is_timed(key));
            kept.map(|(key, value)| (key.clone(), without_times(value)))
                .collect()
        }
        Value::Array(all) => all.iter().map(without_times).collect(),
        other => other.clone(),
    }
}

/// What a curve says of itself follows from its points: ratios from 0.9 to 1.1 are noise, equal amounts one.
fn standing_is_that_of_the_points(curve: &Value) {
    let mut points: Vec<(f64, Vec<f64>)> = Vec::new();
    for point in list(curve, "points") {
        let (amount, log) = (number(point, "amount"), number(point, "ratio").ln());
        match points.last_mut() {
            Some((last, logs)) if *last == amount => logs.push(log),
            Some((last, _)) => {
                assert!(*last < amount, "{curve}");
                points.push((amount, vec![log]));
            }
            None => points.push((amount, vec![log])),
        }
    }
    let sides: Vec<(f64, Value)> = points
        .iter()
        .map(|(amount, logs)| {
            let ratio = (logs.iter().sum::<f64>() / logs.len() as f64).exp();
            let side = match ratio {
                r if r > 1.1 => "bdtree".into(),
                r if r < 0.9 => "refit".into(),
                _ => Value::Null,
            };
            (*amount, side)
        })
        .collect();
    let (first, last) = (&sides[0], &sides[sides.len() - 1]);
    assert_eq!(
        (&curve["below"], &curve["above"]),
        (&first.1, &last.1),
        "{curve}"
    );
    let ahead = curve["ahead"].as_str().expect("a word");
    let (from, to) = (curve["from"].as_f64(), curve["to"].as_f64());
    match ahead {
        "bdtree" | "refit" => {
            assert!(sides.iter().all(|s| s.1 == *ahead), "{curve}");
            assert_eq!((from, to), (None, None));
        }
        "crosses" | "close" => {
            let (from, to) = (from.expect("an end"), to.expect("an end"));
            assert!(first.0 <= from && from <= to && to <= last.0, "{curve}");
            for (amount, side) in &sides {
                assert!(*amount > from || from == first.0 || *side == first.1);
                assert!(*amount < to || to == last.0 || *side == last.1);
            }
            let is_noise = |s: &(f64, Value)| s.0 <= from || s.0 >= to || s.1.is_null();
            let crosses = !first.1.is_null()
                && !last.1.is_null()
                && first.1 != last.1
                && sides.iter().all(is_noise);
            assert_eq!(crosses, ahead == "crosses", "{curve}");
        }
        other => panic!("{other}"),
    }
    let even = curve["break_even"].as_f64();
    assert_eq!(even.is_some(), ahead == "crosses", "{curve}");
    if let (Some(at), Some(from), Some(to)) = (even, from, to) {
        // Two digits: rounded by up to a twentieth.
        assert!((0.95 * from..=1.05 * to).contains(&at), "{curve}");
        assert_eq!(format!("{at:.1e}").parse(), Ok(at));
    }
}

/// Number of cells of all tables.
fn cells(page: &str) -> usize {
    page.matches("<td").count()
}

/// All numbers of a value.
fn numbers(value: &Value, found: &mut Vec<f64>) {
    match value {
        Value::Object(map) => map.values().for_each(|value| numbers(value, found)),
        Value::Array(all) => all.iter().for_each(|value| numbers(value, found)),
        other => found.extend(other.as_f64()),
    }
}

/// The numbers in the number cells of a page's tables, with the digits that are shown.
fn shown(page: &str) -> Vec<f64> {
    let cells = page.split("<td>").skip(1);
    let cells = cells.filter_map(|rest| rest.split("</td>").next());
    let parts = cells.flat_map(|cell| cell.split('/'));
    let numbers = parts.filter_map(|part| {
        let text = part.replace([' ', '\u{202f}', '%'], "");
        text.replace('\u{2212}', "-").parse().ok()
    });
    numbers.collect()
}

#[test]
fn an_animated_asset_has_every_part() {
    let folder = Folder::new();
    let mesh = ball_mesh();
    folder.write("moves.bdt", baked(&mesh, &animated(&mesh)));
    let (report, page) = folder.report("moves.bdt");
    assert_eq!(report["file"], "moves.bdt");
    assert_eq!(report["asset"]["frames"], 3);
    assert_eq!(report["samples"]["count"], 3);

    // Fewer modes: errors fall to 0, which all have; bytes rise.
    let modes = list(&report, "modes");
    assert_eq!(modes.last().expect("rows")["modes"], 3);
    for pair in modes.windows(2) {
        assert!(number(&pair[0], "error_max") >= number(&pair[1], "error_max"));
        assert!(number(&pair[0], "bytes") <= number(&pair[1], "bytes"));
        assert!(number(&pair[0], "error_rms_rel") <= number(&pair[0], "error_max_rel"));
    }
    assert_eq!(number(modes.last().expect("rows"), "error_max"), 0.0);
    assert!(number(&modes[0], "error_max") > 0.0);

    // Levels: nothing is missed anywhere, and at the last all is exact.
    let depth = list(&report, "depth");
    assert_eq!(
        depth.len() as u64,
        report["asset"]["depth"].as_u64().expect("a number")
    );
    assert!(
        depth
            .iter()
            .all(|row| number(row, "missed_area_rel") == 0.0)
    );
    let last = depth.last().expect("levels");
    for name in ["extra_area_rel", "penetration_error_rel", "false_rel"] {
        assert_eq!(number(last, name), 0.0, "{name}");
    }
    assert!(number(&depth[0], "extra_area_rel") > 0.0);
    assert!(number(&depth[0], "penetration_error_rel") > 0.0);
    // A walk that stops nowhere visits what one without a level visits.
    let whole = &report["depth_whole"];
    assert_eq!(number(last, "ball_visits"), number(whole, "ball_visits"));
    for row in depth {
        let ratio = number(row, "ball_micros") / number(whole, "ball_micros");
        assert!((number(row, "time_rel") / ratio - 1.0).abs() < 1e-9);
    }

    // Tightness: nothing is tighter than possible, ours not looser than the paper's but for rounding.
    let tightness = list(&report, "tightness");
    assert!(tightness.len() >= 4);
    for row in tightness {
        let mean = |name: &str| number(&row[name], "mean");
        assert!(mean("bdtree") > 1.0 - 1e-6 && number(&row["bdtree"], "max") >= mean("bdtree"));
        assert!(
            mean("bdtree") <= mean("smallest_ball") * (1.0 + 1e-3),
            "{row}"
        );
        assert!(
            mean("smallest_ball") <= mean("paper") * (1.0 + 1e-9),
            "{row}"
        );
    }
    assert_eq!(report["margin"]["violations"], 0);
    assert!(number(&report["margin"], "least") > 0.0);

    let curves = list(&report["refit"], "curves");
    let asked: Vec<_> = curves.iter().map(|c| c["question"].as_str()).collect();
    assert_eq!(asked, [Some("ball"), Some("ray"), Some("pair")]);
    for curve in curves {
        for point in list(curve, "points") {
            let ratio = number(point, "refit_micros") / number(point, "bdtree_micros");
            assert!((number(point, "ratio") / ratio - 1.0).abs() < 1e-9);
        }
        standing_is_that_of_the_points(curve);
        let unit = curve["unit"].as_str().expect("a unit");
        let title = match curve["ahead"].as_str() {
            Some("bdtree") => "bdtree is ahead at every amount tried",
            Some("refit") => "deform + refit is ahead at every amount tried",
            Some("crosses") => "is ahead from about",
            _ => "neither is safely ahead",
        };
        let of_plot = page.split("<figcaption>").find(|f| f.starts_with(unit));
        let caption = of_plot.and_then(|f| f.split("</figcaption>").next());
        assert!(caption.is_some_and(|c| c.contains(title)), "{caption:?}");
        let mark = ["break-even\n", "neither safely ahead\n"];
        let marks = match curve["ahead"].as_str() {
            Some("crosses") => [true, false],
            Some("close") => [false, true],
            _ => [false, false],
        };
        assert_eq!(mark.map(|m| of_plot.is_some_and(|f| f.contains(m))), marks);
    }
    for sentence in list(&report, "verdict") {
        let text = sentence.as_str().expect("text");
        assert!(page.contains(text), "{text}");
    }
    assert_eq!(list(&report, "verdict").len(), 5);
    assert_eq!(page.matches("src=\"data:image/png;base64,iVBOR").count(), 2);
    for caption in ["At rest", "Frame 1"] {
        assert!(page.contains(&format!("<figcaption>{caption}</figcaption>")));
    }
    let date = report["date"].as_str().expect("a date");
    assert!(date.len() == 10 && date.starts_with("20"), "{date}");
    let sections = list(&report, "sections");
    let bytes: f64 = sections.iter().map(|s| number(s, "bytes")).sum();
    assert_eq!(bytes, number(&report["asset"], "bytes"));
    assert!(!list(&report, "advice").is_empty());

    // One file that fetches nothing, whose plots and tables are filled.
    assert!(page.starts_with("<!DOCTYPE html>") && page.trim_end().ends_with("</html>"));
    for other in ["http://", "https://", "src=", "<script", "@import", "url("] {
        let allowed = "http://www.w3.org/2000/svg";
        let page = page
            .replace(allowed, "")
            .replace("src=\"data:image/png;base64,", "");
        assert!(!page.contains(other), "{other}");
    }
    assert!(page.matches("<svg").count() >= 8 && page.contains("prefers-color-scheme:dark"));
    assert!(cells(&page) > 100 && !page.contains("NaN"));
    assert!(page.contains("viewport"));
    // Tables of more columns are wider than a phone; those of numbers lie side by side, as many as plots above them.
    let columns = |table: &str| {
        let head = table.split("</thead>").next();
        head.map_or(0, |head| head.matches("<th").count() - 1)
    };
    let tables: Vec<usize> = page.split("<table>").skip(1).map(columns).collect();
    assert!(
        tables.len() >= 8 && tables.iter().all(|n| *n <= 6),
        "{tables:?}"
    );
    assert_eq!(page.matches("\"small table\"").count(), 8, "{tables:?}");
    numbers_are_the_figures(&page, &report);
    for advice in list(&report, "advice") {
        let text = advice["text"].as_str().expect("text");
        assert!(page.contains(&text.replace('"', "&quot;")), "{text}");
    }
}

/// Every number of the page's tables is one of the figures, or a hundred times one (per cent), to the digits shown.
fn numbers_are_the_figures(page: &str, report: &Value) {
    let mut figures = Vec::new();
    numbers(report, &mut figures);
    let shown = shown(page);
    assert!(shown.len() > 100);
    for number in shown {
        let is_it = |figure: &f64| (figure - number).abs() <= 6e-3 * number.abs();
        let is_one = figures.iter().any(|x| is_it(x) || is_it(&(100.0 * x)));
        assert!(is_one, "{number} is on the page alone");
    }
}

/// A fixture's morph targets, if it has some, and its skin.
fn character(name: &str) -> Vec<u8> {
    let motion = Motion::MorphsElseSkin(Default::default(), Default::default());
    let recipe = Recipe::of_surface(models::path(name), motion);
    bdtree_build::bake(&recipe, &Silent).expect("bakes").bytes
}

#[test]
fn characters_are_measured_in_the_poses_of_their_clips() {
    let folder = Folder::new();
    folder.write("tube.bdt", character("skinned_tube.glb"));
    let (report, page) = folder.report("tube.bdt");
    let skin = &report["asset"]["skin"];
    let counts = ["joints", "bones", "clips", "influences_max"].map(|name| number(skin, name));
    assert_eq!(counts, [4.0, 4.0, 3.0, 4.0]);
    let samples = &report["samples"];
    assert_eq!(samples["source"], "24 poses of the 3 clips");
    assert!(number(samples, "displacement_max_rel") > 0.1);
    let parts = &samples["of_parts"];
    let parts = ["modes", "depth", "tightness", "refit"].map(|name| number(parts, name));
    assert_eq!(parts, [0.0, 24.0, 8.0, 4.0]);

    // What is not measured is said, and leaves no heading over nothing.
    assert!(list(&report, "modes").is_empty() && !page.contains("Modes kept</h2>"));
    assert_eq!(report["made"]["is_as_advised"], Value::Null);
    let missing: Vec<_> = list(&report, "missing")
        .iter()
        .filter_map(Value::as_str)
        .collect();
    for (text, says) in missing
        .iter()
        .zip(["know no bones", "Fewer modes are not measured"])
    {
        assert!(text.contains(says) && page.contains(text), "{missing:?}");
    }

    // Levels: nothing is missed anywhere, and at the last all is exact.
    let depth = list(&report, "depth");
    assert_eq!(depth.len() as f64, number(&report["asset"], "depth"));
    assert!(
        depth
            .iter()
            .all(|row| number(row, "missed_area_rel") == 0.0)
    );
    let last = depth.last().expect("levels");
    for name in ["extra_area_rel", "penetration_error_rel", "false_rel"] {
        assert_eq!(number(last, name), 0.0, "{name}");
    }

    // Tightness: per level once, no sphere smaller than possible, the other bounds unknown.
    let tightness = list(&report, "tightness");
    assert_eq!(tightness.len(), depth.len());
    for (level, row) in tightness.iter().enumerate() {
        assert_eq!(number(row, "level"), level as f64);
        for other in ["displacement_rel", "paper", "smallest_ball"] {
            assert_eq!(row[other], Value::Null);
        }
        let [mean, max] = ["mean", "max"].map(|name| number(&row["bdtree"], name));
        assert!((1.0 - 1e-6..=max).contains(&mean), "{row}");
        assert!(page.contains(&format!("<td>{mean:.3} / {max:.3}</td>")));
    }
    assert_eq!(report["margin"]["violations"], 0);

    let refit = &report["refit"];
    for name in ["deform_micros", "refit_micros", "pose_micros"] {
        assert!(number(refit, name) > 0.0, "{name}");
    }
    let curves = list(refit, "curves");
    assert_eq!(curves.len(), 3);
    curves.iter().for_each(standing_is_that_of_the_points);
    // Some pairs touch: bodies stand beside each other where their bones carried them.
    let deepest = list(&curves[2], "points").last().expect("points");
    assert!(number(deepest, "amount") > 0.0);
    assert!(page.contains("deforms all vertices and carries them by their bones"));
    assert!(page.contains("<figcaption>Clip wave at 0.75 s</figcaption>"));
    for fact in ["joints <b>4<", "bones <b>4<", "clips <b>3<"] {
        assert!(page.contains(fact), "{fact}");
    }
    let sections = list(&report, "sections");
    assert!(
        sections
            .iter()
            .all(|s| s["purpose"] != "not known to this version")
    );
    assert!(!page.contains("NaN"));
    numbers_are_the_figures(&page, &report);
    for text in list(&report, "verdict").iter().filter_map(Value::as_str) {
        assert!(page.contains(text), "{text}");
    }
    let (again, _) = folder.report("tube.bdt");
    assert_eq!(without_times(&report), without_times(&again));
}

/// Without clips and modes: joints are turned.
#[test]
fn characters_without_clips_have_their_joints_turned() {
    let folder = Folder::new();
    folder.write("twelve.bdt", character("skinned_12.glb"));
    let (report, page) = folder.report("twelve.bdt");
    let source = "24 poses with joints turned by up to 20°";
    assert_eq!(report["samples"]["source"], source);
    assert_eq!(number(&report["asset"]["skin"], "influences_max"), 12.0);
    assert!(page.contains(source) && page.contains("The asset has no clips"));
    assert!(!page.contains("The asset is rigid") && !page.contains("NaN"));
    assert!(!list(&report, "tightness").is_empty());
    for row in list(&report, "tightness") {
        assert!(number(&row["bdtree"], "mean") > 1.0 - 1e-6, "{row}");
    }
    assert_eq!(report["margin"]["violations"], 0);
    numbers_are_the_figures(&page, &report);
}

#[test]
fn two_runs_count_the_same() {
    let folder = Folder::new();
    let (first, _) = folder.report("a.bdt");
    let (second, _) = folder.report("a.bdt");
    assert_eq!(without_times(&first), without_times(&second));
    assert!(without_times(&first)["modes"][0].get("error_max").is_some());
}

#[test]
fn ranges_stand_in_for_an_animation_and_it_says_so() {
    let folder = Folder::new();
    let (report, page) = folder.report("a.bdt");
    assert_eq!(report["asset"]["frames"], Value::Null);
    let missing = list(&report, "missing");
    let says = |text: &str| {
        missing
            .iter()
            .any(|m| m.as_str().is_some_and(|m| m.contains(text)))
    };
    assert!(says("no animation"), "{missing:?}");
    assert!(page.contains("no animation"));
}

#[test]
fn what_an_asset_has_not_is_said() {
    let folder = Folder::new();
    let triangle = RawMesh {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        ..RawMesh::default()
    };
    let rigid = Basis {
        vertex_count: 3,
        ..Basis::default()
    };
    folder.write("one.bdt", baked(&triangle, &rigid));
    for name in ["rigid.bdt", "one.bdt"] {
        let (report, page) = folder.report(name);
        for part in ["modes", "tightness"] {
            assert!(list(&report, part).is_empty(), "{name} {part}");
        }
        assert_eq!(
            (&report["refit"], &report["margin"]),
            (&Value::Null, &Value::Null)
        );
        assert!(page.contains("The asset is rigid") && !page.contains("NaN"));
        // No empty plot, and no heading over nothing.
        assert!(!page.contains("Tightness</h2>") && !page.contains("Modes kept</h2>"));
        assert!(cells(&page) > 10);
    }
    // A triangle that moves, and one of no area at all.
    for flat in [false, true] {
        let mut mesh = triangle.clone();
        if flat {
            mesh.positions = vec![[1.0, 2.0, 3.0]; 3];
        }
        let moving = crate::support::basis(&mesh);
        folder.write("one.bdt", baked(&mesh, &moving));
        let (report, page) = folder.report("one.bdt");
        assert!(!page.contains("NaN"), "{report}");
        // A step of one triangle takes either side a fraction of a microsecond: what a clock's own reading
        // would add to one of them is more.
        for curve in list(&report["refit"], "curves") {
            standing_is_that_of_the_points(curve);
            let few = &list(curve, "points")[0];
            assert!(number(few, "bdtree_micros") > 0.0 && number(few, "refit_micros") > 0.0);
            assert!(number(few, "ratio") < 2.0, "{curve}");
        }
    }
}

/// Balls that touch nothing are among the samples; only for them can spheres be reported though nothing touches.
#[test]
fn balls_that_touch_nothing_are_asked_too() {
    let folder = Folder::new();
    // Centers lie in a cube about a point of the surface: beside a slanted one they get farthest away.
    let slanted = RawMesh {
        positions: vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        triangles: vec![[0, 1, 2]],
        ..RawMesh::default()
    };
    let moving = crate::support::basis(&slanted);
    folder.write("slanted.bdt", baked(&slanted, &moving));
    let (report, page) = folder.report("slanted.bdt");
    let apart = number(&report["depth_whole"], "apart_rel");
    assert!(apart > 0.0 && apart < 1.0, "{apart}");
    for row in list(&report, "depth") {
        assert!(number(row, "false_rel") <= apart, "{row} of {apart}");
    }
    let parts = &report["samples"]["of_parts"];
    for part in ["modes", "depth", "tightness", "refit"] {
        assert!(number(parts, part) >= 1.0, "{parts}");
    }
    assert!(page.contains("as an upper bound"));
}

/// Of fields without an order those that move nothing go first.
#[test]
fn fields_that_move_nothing_are_advised_away() {
    let folder = Folder::new();
    let mesh = ball_mesh();
    let mut basis = crate::support::basis(&mesh);
    let count = mesh.positions.len();
    basis.fields[..count].fill([0.0; 3]);
    folder.write("still.bdt", baked(&mesh, &basis));
    let (report, _) = folder.report("still.bdt");
    let advice = list(&report, "advice").iter();
    let modes: Vec<_> = advice
        .filter(|advice| advice["topic"] == "modes")
        .filter_map(|advice| advice["text"].as_str())
        .collect();
    assert!(
        modes
            .iter()
            .any(|text| text.contains("(not the first ones)")),
        "{modes:?}"
    );
}

#[test]
fn what_is_wrong_is_told() {
    let folder = Folder::new();
    let mut broken = folder.read("a.bdt");
    *broken.last_mut().expect("bytes") ^= 1;
    folder.write("broken.bdt", broken);
    for (arguments, expected) in [
        (&["none.bdt"][..], "cannot read none.bdt: No such file"),
        (&["broken.bdt"], "broken.bdt: damaged .bdt file: section "),
        (
            &["a.bdt", "-o", "none/out.html"],
            "none/out.html: cannot write: ",
        ),
    ] {
        let ran = folder.run(&[&["report"], arguments].concat());
        assert_eq!((ran.code, ran.out.as_str()), (1, ""), "{arguments:?}");
        assert!(
            ran.err.starts_with(expected) && ran.err.lines().count() == 1,
            "{}",
            ran.err
        );
        assert!(!folder.path("out.html").exists());
    }
    let ran = folder.run(&["report", "a.bdt", "-o", "out.txt"]);
    let text = "out.txt: unknown extension: .html can be written\n";
    assert_eq!((ran.code, ran.err.as_str()), (2, text));
    folder.write("a.html", folder.read("a.bdt"));
    let ran = folder.run(&["report", "a.html"]);
    assert_eq!(ran.code, 1);
    assert!(
        ran.err.contains("is the input: it would be overwritten"),
        "{}",
        ran.err
    );
}

#[test]
fn pictures_of_the_page_stand_as_those_of_render() {
    let folder = Folder::new();
    for up in ["y", "z", "-x"] {
        let found = folder.portrait(&["--up", up]);
        let fixed = ["--no-legend", "--shadow", "-o", "out.png", "--up", up];
        folder.render_at("720x540", &[&["rigid.bdt"], &fixed[..]].concat());
        let expected = Picture::read(&folder.path("out.png"));
        assert_eq!(found.size, expected.size);
        assert!(found.pixels == expected.pixels, "{up}");
        let default = folder.portrait(&[]);
        assert_eq!(found.pixels == default.pixels, up == "y", "{up}");
    }
    let ran = folder.run(&["report", "rigid.bdt", "--up", "w"]);
    assert_eq!(ran.code, 2, "{}", ran.err);
}

#[test]
fn the_page_lies_beside_the_file() {
    let folder = Folder::new();
    let ran = folder.run(&["report", "rigid.bdt"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, "measuring levels\n"));
    assert!(ran.out.ends_with("wrote rigid.html\n"), "{}", ran.out);
    assert!(folder.path("rigid.html").exists());
    let ran = folder.run(&["report", "rigid.bdt", "--json"]);
    assert!(ran.out.starts_with('{') && ran.code == 0);
}
