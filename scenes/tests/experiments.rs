//! The paper's experiments at small sizes: what must hold holds, and two runs agree.

use std::sync::OnceLock;

use bdtree_scenes::report::without_times;
use bdtree_scenes::{curtain, growth, tables};
use clap::Parser;
use serde_json::Value;

/// The tables of three fixtures, measured once for all tests.
fn mesh(name: &str) -> &'static Value {
    static MESHES: OnceLock<Value> = OnceLock::new();
    let options = [
        "--meshes",
        "chair,fish,curtain",
        "--poses",
        "1",
        "--pair-vertices",
        "300",
    ];
    let all = MESHES.get_or_init(|| {
        let words = ["tables"].into_iter().chain(options);
        let arguments = tables::Arguments::try_parse_from(words).expect("options");
        tables::run(&arguments).expect("tables").value
    });
    let meshes = all["meshes"].as_array().expect("meshes");
    let own = meshes.iter().find(|mesh| mesh["mesh"] == name);
    own.unwrap_or_else(|| panic!("no mesh {name}"))
}

fn number(value: &Value, pointer: &str) -> f64 {
    let number = value.pointer(pointer).and_then(Value::as_f64);
    number.unwrap_or_else(|| panic!("no number at {pointer}"))
}

/// P08, P09.
#[test]
fn layered_spheres_are_larger_than_wrapped_ones() {
    for name in ["chair", "fish", "curtain"] {
        let own = mesh(name);
        let least = number(own, "/ratios/least_layered_over_wrapped_of_inner_levels");
        assert!(least > 1.0, "{name}: {least}");
        let mean = number(own, "/ratios/levels/6/ratios/0/layered/mean");
        // The paper's bridge: 1.31; the curtain is flatter and thinner (1.51).
        assert!((1.2..1.6).contains(&mean), "{name}: {mean}");
    }
}

/// P10, on figure 6's level: where the paper's bound was at best as tight as the layered hierarchy. The
/// curtain is bent more than others are by modes that reach as far: beyond some 8 % of its diagonal the layered
/// spheres are the smaller ones (docs/design/decisions/large-deformations.md).
#[test]
fn ours_is_tighter_than_layered_up_to_the_stated_amplitudes() {
    for (name, up_to) in [("chair", 0.2), ("fish", 0.2), ("curtain", 0.05)] {
        let own = mesh(name);
        let all = own
            .pointer("/ratios/levels/6/ratios")
            .and_then(Value::as_array);
        let mut count = 0;
        for case in all.into_iter().flatten() {
            if number(case, "/amplitude") <= up_to {
                let [layered, ours] = ["/layered/mean", "/ours/mean"].map(|who| number(case, who));
                assert!(ours < layered, "{name}: {case}");
                count += 1;
            }
        }
        // At rest, and two kinds of deformations at four or two amplitudes.
        assert_eq!(count, if up_to == 0.2 { 9 } else { 5 });
    }
}

/// P10: where the paper's bound is as loose as in its own figure 6.
#[test]
fn ours_is_tighter_where_the_papers_bound_is_as_in_its_figure() {
    let mut count = 0;
    for name in ["chair", "fish", "curtain"] {
        let crossings = mesh(name)["crossings"].as_array();
        for crossing in crossings.into_iter().flatten() {
            let there = &crossing["paper_as_in_its_figure"];
            if there.is_null() {
                continue; // never so loose
            }
            let [layered, paper, ours] =
                ["/layered", "/paper", "/ours"].map(|who| number(there, who));
            assert!((1.249..1.26).contains(&paper), "{name}: {crossing}");
            assert!(ours < 0.85 * layered, "{name}: {crossing}");
            count += 1;
        }
    }
    assert!(count >= 4, "{count} of 6");
}

/// Where our spheres get as large as the layered ones, both are as large, and the curtain's do before 20 %.
#[test]
fn crossings_are_where_both_are_as_large() {
    for crossing in mesh("curtain")["crossings"].as_array().expect("crossings") {
        let met = &crossing["ours_as_large_as_layered"];
        let [amplitude, layered, ours] =
            ["/amplitude", "/layered", "/ours"].map(|who| number(met, who));
        assert!((0.05..0.2).contains(&amplitude), "{crossing}");
        assert!((ours / layered - 1.0).abs() < 1e-3, "{crossing}");
    }
}

/// Figure 6 of a file at hand is that of the fixture it was baked from.
///
/// Tests begin in the order of their names. This one's comes first, so that it bakes and measures its own meshes while
/// another one measures those of [`mesh`]: whichever asks for these second waits.
#[test]
fn a_file_has_figure_6_of_its_fixture() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("chair.bdt");
    let chair = tables::chair().expect("a bake");
    std::fs::write(&path, chair.asset().bytes()).expect("written");
    let run = |path: &std::path::Path| {
        let path = path.to_str().expect("a path");
        let words = [
            "tables",
            "--meshes",
            "curtain",
            "--amplitudes",
            "0.05",
            "--poses",
            "1",
        ];
        let words = words
            .into_iter()
            .chain(["--pair-vertices", "64", "--files", path]);
        tables::run(&tables::Arguments::try_parse_from(words).expect("options"))
    };
    let value = run(&path).expect("tables").value;
    let own = &value["files"][0];
    assert_eq!(
        (&own["file"], &own["triangles"]),
        (&"chair".into(), &17_914.into())
    );
    let at_rest = "/ratios/levels/6/ratios/0";
    assert_eq!(own.pointer(at_rest), mesh("chair").pointer(at_rest));
    let missing = folder.path().join("none.bdt");
    let error = run(&missing).expect_err("no file").to_string();
    assert!(error.contains("none.bdt: "), "{error}");
}

/// P21: monotone, and at level 10 within three times the paper's row.
#[test]
fn growth_decays_as_in_the_paper() {
    let own = mesh("chair");
    for who in ["paper", "ours"] {
        let decay = &own["decay"][who];
        assert_eq!(decay["falls"], true, "{who}: {decay}");
        let over = number(decay, "/level_10_over_the_papers");
        assert!((1.0 / 3.0..3.0).contains(&over), "{who}: {over}");
    }
}

/// P22.
#[test]
fn appendix_a_holds() {
    for name in ["chair", "curtain"] {
        let own = mesh(name);
        for (k, least) in [(0, 0.9), (1, 0.9)] {
            let pairs = &own["appendix_a"][k];
            assert!(number(pairs, "/nodes_times_modes") > 1e4);
            assert_eq!(number(pairs, "/violations"), 0.0, "{name}: {pairs}");
            assert_eq!(number(pairs, "/rising_constants"), 0.0, "{name}: {pairs}");
            // Not true for want of a case that comes near.
            assert!(number(pairs, "/largest") > least, "{name}: {pairs}");
        }
    }
}

/// P38: counts and radii, and that nobody answers differently (which is an error of the program).
#[test]
fn curtain_counts_are_the_same_in_every_run() {
    let words = [
        "curtain",
        "--triangles",
        "1500",
        "--frames",
        "50",
        "--repeat",
        "1",
    ];
    let run = || {
        let arguments = curtain::Arguments::try_parse_from(words).expect("options");
        curtain::run(&arguments).expect("a run").value
    };
    let (one, two) = (run(), run());
    assert_eq!(without_times(&one), without_times(&two));
    assert!(number(&one, "/contacts") > 0.0, "the ball misses: {one}");
    let tests = |k: usize| number(&one, &format!("/contenders/{k}/tests"));
    // Every frame tests a root at least; the same tree is walked plainly and with care.
    assert!(tests(1) >= 50.0 && tests(1) == tests(2));
    let ours = number(&one, "/growth_of_all_spheres/ours");
    let paper = number(&one, "/growth_of_all_spheres/paper");
    assert!(1.0 < paper && ours < paper, "{ours} {paper}");
}

/// P28, and that counts do not depend on the run.
#[test]
fn visits_hardly_grow_with_the_mesh() {
    let words = [
        "growth",
        "--triangles",
        "2000,8000,32000",
        "--contacts",
        "30",
        "--body-triangles",
        "320",
        "--repeat",
        "1",
    ];
    let run = || {
        let arguments = growth::Arguments::try_parse_from(words).expect("options");
        growth::run(&arguments).expect("a run").value
    };
    let (one, two) = (run(), run());
    assert_eq!(without_times(&one), without_times(&two));
    let exponent = number(&one, "/size/exponent_nodes");
    assert!(exponent < 0.3, "{exponent}");
}

/// Files of a report: JSON, a CSV per table, an SVG per picture.
#[test]
fn reports_are_written() {
    let words = [
        "curtain",
        "--triangles",
        "400",
        "--frames",
        "3",
        "--repeat",
        "1",
        "--modes",
        "4",
    ];
    let arguments = curtain::Arguments::try_parse_from(words).expect("options");
    let report = curtain::run(&arguments).expect("a run");
    let folder = tempfile::tempdir().expect("a folder");
    report.write(folder.path()).expect("written");
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect(name);
    let value: Value = serde_json::from_str(&read("curtain.json")).expect("JSON");
    assert_eq!(value["program"], "curtain");
    assert_eq!(value["results"], report.value);
    // A head, five contenders, two rows of the paper.
    assert_eq!(read("curtain.csv").lines().count(), 8);
    assert!(read("curtain.svg").starts_with("<svg"));
}

#[test]
fn bad_options_are_refused() {
    for (program, option, value) in [
        ("tables", "--amplitudes", "0"),
        ("tables", "--amplitudes", "nan"),
        ("tables", "--meshes", "teapot"),
        ("curtain", "--radius", "-1"),
        ("curtain", "--frames", "111"),
        ("growth", "--triangles", "1"),
    ] {
        let words = [program, option, value];
        let is_refused = match program {
            "tables" => tables::Arguments::try_parse_from(words).is_err(),
            "curtain" => curtain::Arguments::try_parse_from(words).is_err(),
            _ => growth::Arguments::try_parse_from(words).is_err(),
        };
        assert!(is_refused, "{words:?}");
    }
    let one =
        growth::Arguments::try_parse_from(["growth", "--triangles", "2000"]).expect("options");
    assert!(growth::run(&one).is_err());
}
