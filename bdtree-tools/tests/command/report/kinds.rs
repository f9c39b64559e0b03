//! Assets that lack something: an animation, modes, order, more than one triangle.

use bdtree_build::basis::Basis;
use bdtree_build::input::RawMesh;
use serde_json::{Value, json};

use super::figures::{cells, list, number, standing_is_that_of_the_points, without_times};
use crate::support::{Folder, baked, ball_mesh};

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
        assert!(page.contains("At the rest pose. Lengths are mesh units."));
        for nonsense in ["0 % of the diagonal;", "1 samples", "displacements"] {
            assert!(!page.contains(nonsense), "{name} {nonsense}");
        }
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
    let (report, page) = folder.report("still.bdt");
    let advice = list(&report, "advice").iter();
    let modes: Vec<_> = advice
        .filter(|advice| advice["topic"] == "modes")
        .filter_map(|advice| advice["text"].as_str())
        .collect();
    assert!(
        modes
            .iter()
            .any(|text| text.contains("2 of 3 modes (numbers 1, 2 \"wave\") ")),
        "{modes:?}"
    );
    // The plots are of the first modes, which are others.
    assert_eq!(report["modes_advised"]["modes"], json!([1, 2]));
    assert!(number(&report["modes_advised"], "error_max_rel") < 1e-6);
    assert!(
        page.contains("The advised modes (1, 2) are not the first 2: they leave an error below ")
    );
    let missing = list(&report, "missing").iter();
    let mut missing = missing.filter_map(Value::as_str);
    assert!(missing.any(|text| text.starts_with("Mode 0 is zero everywhere: ")));
    let (report, _) = folder.report("a.bdt");
    assert_eq!(report["modes_advised"], Value::Null);
}
