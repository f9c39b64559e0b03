//! Files with skins, with clips and without.

use serde_json::Value;

use super::figures::{
    exact_levels, list, number, numbers_are_the_figures, standing_is_that_of_the_points,
    without_times,
};
use crate::support::{Folder, character};

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

    let depth = exact_levels(&report);

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
