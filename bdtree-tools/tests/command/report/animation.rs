//! An asset with modes and an animation, of which every part can be measured.

use super::figures::{
    cells, exact_levels, list, names_are_documented, number, numbers_are_the_figures,
    standing_is_that_of_the_points,
};
use crate::support::{Folder, animated, baked, ball_mesh};

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

    let depth = exact_levels(&report);
    let last = depth.last().expect("levels");
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
    let moved = |row: &&serde_json::Value| row["displacement_rel"].is_null();
    assert_eq!(tightness.iter().filter(moved).count(), depth.len());
    assert_eq!(tightness.len(), 5 * depth.len());
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
        let ends = ["from", "to"].map(|end| curve[end].as_f64());
        let title = match (curve["ahead"].as_str(), ends) {
            (Some("bdtree"), _) => "bdtree is faster at every amount tried".to_string(),
            (Some("refit"), _) => "bdtree is slower at every amount tried".to_string(),
            (Some("crosses"), [Some(from), Some(to)]) if from > 0.0 => {
                format!("unsure between {from} and {to}, ")
            }
            (Some("close"), _) => " at every amount tried".to_string(),
            _ => "unsure ".to_string(),
        };
        let of_plot = page.split("<figcaption>").find(|f| f.starts_with(unit));
        let caption = of_plot.and_then(|f| f.split("</figcaption>").next());
        assert!(caption.is_some_and(|c| c.contains(&title)), "{caption:?}");
        // The gray stretch is told in the legend, not in the plot.
        let is_marked = of_plot.is_some_and(|f| f.contains("<i class=\"stretch\"></i>unsure<"));
        assert_eq!(is_marked, ends[0] < ends[1], "{curve}");
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
    assert!(page.contains("false positives: samples where spheres are reported though"));
    // On a phone tables scroll; lines of figures are not broken.
    assert!(page.contains("td:not(.text){white-space:nowrap}"));
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
    names_are_documented(&report);
    for advice in list(&report, "advice") {
        let text = advice["text"].as_str().expect("text");
        assert!(page.contains(&text.replace('"', "&quot;")), "{text}");
    }
}
