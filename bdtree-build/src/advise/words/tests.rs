//! What advice says in each case.

use super::*;

#[test]
fn shares_are_rounded_up_to_three_digits() {
    assert_eq!(percent(0.0), "0 %");
    assert_eq!(percent(0.01), "1 %");
    assert_eq!(percent(0.010_001), "1.01 %");
    assert_eq!(percent(0.3), "30 %");
    assert_eq!(percent(0.004_211), "0.422 %");
    assert_eq!(percent(1.23), "123 %");
    assert_eq!(percent(1.2e-7), "1.20e-5 %");
}

#[test]
fn modes_are_named_where_that_is_known() {
    let names = ["Angry", "Sad\u{1b}"].map(|name| Some(name.to_string()));
    assert_eq!(named(&[0, 1], &names), r#"0 "Angry", 1 "Sad\u{1b}""#);
    assert_eq!(named(&[0, 2], &names), r#"0 "Angry", 2"#);
    assert_eq!(named(&[2, 3, 4, 6], &names), "2 to 4, 6");
}

#[test]
fn savings_and_times_are_short() {
    assert_eq!(saving(0.309), "30 %");
    assert_eq!(time(1.234_5e-6), "1.23 µs");
    assert_eq!(time(0.012_345), "12.3 ms");
    assert_eq!(time(123.4), "123 s");
}
#[test]
fn sentences_claim_what_was_measured() {
    use super::super::works::Measured;
    let point = |modes: usize, leaf_size: usize, nodes_visited: u64, time_rel: f64| {
        let work = Work {
            questions: 1,
            nodes_visited,
            seconds: time_rel,
            ..Work::default()
        };
        Point {
            modes: (0..modes).collect(),
            leaf_size,
            error: None,
            bytes: 100 * (1 + modes),
            nodes: 10,
            measured: Measured {
                ball: work,
                ray: work,
                pair: work,
            },
            time_rel,
        }
    };
    let mut advice = Advice {
        max_error_rel: 0.01,
        is_met: true,
        error_rel: 0.0071,
        error_of_fewer_rel: Some(0.26),
        are_bounds: true,
        over: Over::Source,
        samples: (Source::Frames, 20),
        bones: None,
        frames: 20,
        available: Some(19),
        all: point(12, 4, 9, 1.0),
        chosen: point(5, 4, 7, 0.5),
        takes_first: true,
        leaves: [2, 4, 8].map(|size| point(5, size, 7, 0.5)).to_vec(),
        default_leaf_size: 4,
        has_default_leaves: true,
        mode_names: Vec::new(),
        curve: Vec::new(),
        refining: None,
        missing: Vec::new(),
    };
    let said = advice.sentences();
    let first = "The first 5 of 12 modes (19 available) keep every vertex within 0.71 %";
    assert!(said[0].starts_with(first), "{said:?}");
    let last = "; with one mode fewer the error can reach 26 %.";
    assert!(said[0].ends_with(last), "{said:?}");
    assert!(said[1].starts_with("Against 12 modes that saves 53.9 % of the bytes"));
    assert!(said[1].contains("and 50 % of the time: "), "{said:?}");
    let leaves =
        "Keep the default leaf size of 4 triangles: sizes 2 and 8 are not more than 5 % faster.";
    assert_eq!(said[2], leaves);
    // Leaves that are not the default, and modes that are not the first.
    advice.has_default_leaves = false;
    let leaves = "Keep the leaf size of 4 triangles: sizes 2 and 8 are not more than 5 % faster.";
    assert_eq!(advice.sentences()[2], leaves);
    let mut other = advice.clone();
    other.chosen.leaf_size = 2;
    let leaves = "Leaves of at most 2 triangles save 0 % of the time against 4, as it is now (";
    assert!(
        other.sentences()[2].starts_with(leaves),
        "{:?}",
        other.sentences()
    );
    (other.takes_first, other.available) = (false, None);
    let first = "5 of 12 modes (numbers 0 to 4) keep every vertex within 0.71 %";
    assert!(
        other.sentences()[0].starts_with(first),
        "{:?}",
        other.sentences()
    );
    other.chosen.modes = vec![7];
    other.mode_names = vec![None; 7];
    other.mode_names.push(Some("Surprised".to_string()));
    let first = "1 of 12 modes (number 7 \"Surprised\") keeps every vertex within 0.71 %";
    assert!(
        other.sentences()[0].starts_with(first),
        "{:?}",
        other.sentences()
    );
    other.takes_first = true;
    other.chosen.modes.clear();
    let first = "No mode is needed to keep every vertex within 0.71 %";
    assert!(
        other.sentences()[0].starts_with(first),
        "{:?}",
        other.sentences()
    );
    // "Within 0 %" would read as a bound that nothing can keep.
    other.error_rel = 0.0;
    for (over, place) in [
        (Over::Source, "where the source has it, measured"),
        (Over::Ranges, "where all modes put it, for"),
    ] {
        other.over = over;
        let first = format!("No mode is needed to keep every vertex {place}");
        assert!(
            other.sentences()[0].starts_with(&first),
            "{:?}",
            other.sentences()
        );
    }
    (other.all, other.chosen) = (point(2, 4, 9, 1.0), point(2, 4, 9, 1.0));
    assert!(
        other.sentences()[0].starts_with("Both modes "),
        "{:?}",
        other.sentences()
    );
    // As many nodes, or a gain that is noise.
    for (nodes, time_rel) in [(7, 0.5), (9, 0.98)] {
        advice.all = point(12, 4, nodes, 1.0);
        advice.chosen.time_rel = time_rel;
        let said = advice.sentences();
        assert!(said[1].ends_with("; no measurable difference in time."));
    }
    advice.chosen = point(12, 4, 7, 1.0);
    let first = "12 modes of the 19 available keep every vertex within 0.71 %";
    assert!(advice.sentences()[0].starts_with(first));
    (advice.is_met, advice.are_bounds) = (false, false);
    (advice.chosen, advice.error_rel) = (point(5, 4, 7, 1.0), 0.05);
    assert_eq!(
        advice.sentences()[0],
        "5 modes leave an error of 5 % (goal: 1 %). Allow more with --modes."
    );
}

#[test]
fn memory_is_granted_only_where_it_pays() {
    use super::super::works::{Gain, Nearby, Refining};
    let gain = |refined_seconds: f64, pays_from: Option<f64>| Gain {
        seconds: 2e-6,
        refined_seconds,
        pays_from,
    };
    let mut refining = Refining {
        bytes: 2_352_104,
        prepare_seconds: 3.4e-4,
        ball: gain(1.2e-6, Some(425.0)),
        ray: gain(5e-7, Some(226.7)),
        nearby: None,
    };
    assert_eq!(
        super::refining(&refining),
        "Grant 2352104 bytes for a refined pose (StepCache::refining, which decides by itself) if steps ask more than \
         430 balls or 230 rays: preparing takes 340 µs, then a ball takes 1.20 µs instead of 2.00 µs and a ray takes \
         500 ns instead of 2.00 µs."
            .replace("500 ns", "0.50 µs")
    );
    refining.ball.pays_from = None;
    let said = super::refining(&refining);
    assert!(
        said.contains(" more than 230 rays: ") && !said.contains("ball"),
        "{said}"
    );
    refining.ray.pays_from = None;
    assert_eq!(
        super::refining(&refining),
        "Grant no memory for refined poses: preparing one takes 340 µs, and no question is faster by 5 % then."
    );
    refining.nearby = Some(Nearby {
        bytes: 120_000,
        rays: 1024,
        share: 0.01,
        seconds: 1.5e-6,
        refined_seconds: 4.4e-7,
    });
    assert_eq!(
        super::refining(&refining),
        "Grant no memory for refined poses all over the mesh: preparing one takes 340 µs, and no question is faster by 5 % then. \
         Where steps ask in one place, 120000 bytes are enough: each of 1024 rays at 1 % of the triangles takes 0.44 µs \
         instead of 1.50 µs, refining included."
    );
    assert_eq!(
        [0.4, 7.2, 99.1, 426.7, 1203.0].map(round_up),
        [1, 8, 100, 430, 1300]
    );
}
