//! Files with skins, with clips and without.

use std::mem::{offset_of, size_of};

use bdtree_build::advise::Subject;
use bdtree_build::pipeline::bake_skinned;
use bdtree_build::progress::Silent;
use bdtree_fixtures::mutate::{get_u32, put};
use bdtree_fixtures::sections::{put_together, take_apart};
use bdtree_format::{ChannelRecord, ClipRecord, SectionKind};
use bdtree_runtime::Model;
use serde_json::Value;

use super::figures::{
    exact_levels, list, names_are_documented, number, numbers_are_the_figures,
    standing_is_that_of_the_points, without_times,
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
    assert_eq!(parts, [24.0, 24.0, 8.0, 4.0]);

    // One morph target, of which nothing is left out.
    let modes = list(&report, "modes");
    assert_eq!(modes.len(), 1);
    assert_eq!(number(&modes[0], "error_max"), 0.0);
    assert_eq!(number(&modes[0], "time_rel"), 1.0);
    assert!(!page.contains("<figcaption>Error / box diagonal"));
    assert!(page.contains("size with the bones at rest <b>"));
    let over = report["modes_over"].as_str().expect("words");
    assert!(over.ends_with("before bones carry the vertices"), "{over}");
    assert!(page.contains("Modes kept</h2>") && page.contains(over));
    assert!(report["made"]["is_as_advised"].is_boolean());

    // Each section has its own words.
    let sections = list(&report, "sections");
    let mut purposes: Vec<String> = sections.iter().map(|s| s["purpose"].to_string()).collect();
    purposes.sort();
    purposes.dedup();
    assert_eq!(purposes.len(), sections.len(), "{purposes:#?}");
    assert!(page.contains("<th>spheres measured</th>"));

    // What is not measured is said.
    let missing = list(&report, "missing");
    let text = missing[0].as_str().expect("words");
    assert!(
        text.contains("do not exist for meshes with bones") && page.contains(text),
        "{missing:?}"
    );

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
    let verdict = list(&report, "verdict").iter().filter_map(Value::as_str);
    let mut tight = verdict.filter(|text| text.starts_with("Sphere radii"));
    let at = ", at 8 of 24 poses of the 3 clips.";
    assert!(tight.next().is_some_and(|text| text.ends_with(at)));
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
    names_are_documented(&report);
    for text in list(&report, "verdict").iter().filter_map(Value::as_str) {
        assert!(page.contains(text), "{text}");
    }
    let (again, _) = folder.report("tube.bdt");
    assert_eq!(without_times(&report), without_times(&again));
}

/// A file with one more morph target than the tube's, half of it and turned, and the same skin.
fn two_targets() -> Vec<u8> {
    let model = Model::from_bytes(&character("skinned_tube.glb")).expect("a file");
    let mut subject = Subject::of_asset(model.asset()).expect("a subject");
    let basis = &mut subject.basis;
    let half = basis.field(0).to_vec();
    let half = half
        .into_iter()
        .map(|[x, y, z]| [0.5 * y, 0.5 * z, 0.5 * x]);
    basis.fields.extend(half);
    basis.modes.push(basis.modes[0].clone());
    let skin = subject.skin.as_ref().expect("a skin");
    let (settings, provenance) = (&subject.settings, &subject.provenance);
    let baked = bake_skinned(
        &subject.mesh,
        &subject.basis,
        skin,
        settings,
        provenance,
        &Silent,
    );
    baked.expect("bakes").bytes
}

#[test]
fn characters_are_baked_again_with_fewer_targets() {
    let folder = Folder::new();
    folder.write("two.bdt", two_targets());
    let (report, page) = folder.report("two.bdt");
    let modes = list(&report, "modes");
    let of = |name: &str| {
        modes
            .iter()
            .map(|row| number(row, name))
            .collect::<Vec<_>>()
    };
    assert_eq!(of("modes"), [1.0, 2.0]);
    assert!(of("error_max")[0] > 0.0 && of("error_max")[1] == 0.0);
    assert!(of("bytes")[0] < of("bytes")[1]);
    // As large as the file itself but for what the source says: the skin is in it.
    let skins = list(&report, "sections")
        .iter()
        .filter(|s| s["kind"] != "META");
    let skins: f64 = skins.map(|s| number(s, "bytes")).sum();
    assert!(of("bytes")[1] > skins);
    let visits = number(&report["depth_whole"], "ball_visits");
    assert!(of("ball_visits")[1] > 0.5 * visits && of("ball_visits")[1] < 2.0 * visits);
    numbers_are_the_figures(&page, &report);
}

/// Channels may share keys, as here thousands do; a bake would copy them all. The rest is reported.
#[test]
fn what_no_bake_makes_is_said() {
    let folder = Folder::new();
    let sound = character("skinned_tube.glb");
    let mut parts = take_apart(&sound);
    let mut body = |kind: SectionKind, change: &dyn Fn(&mut Vec<u8>)| {
        let part = parts.iter_mut().find(|part| part.kind() == kind);
        change(&mut part.expect("a section").body);
    };
    const MORE: u32 = 5000;
    body(SectionKind::CHANNELS, &|channels| {
        let keys = |record: &&[u8]| get_u32(record, offset_of!(ChannelRecord, key_count));
        let records = channels.chunks_exact(size_of::<ChannelRecord>());
        let longest = records.max_by_key(keys).expect("channels").to_vec();
        channels.extend(longest.repeat(MORE as usize));
    });
    body(SectionKind::CLIPS, &|clips| {
        let at = clips.len() - size_of::<ClipRecord>() + offset_of!(ClipRecord, channel_count);
        let count = get_u32(clips, at) + MORE;
        put(clips, at, &count.to_le_bytes());
    });
    folder.write("shared.bdt", put_together(&sound, parts));
    let (report, page) = folder.report("shared.bdt");
    let missing = list(&report, "missing").iter();
    let text = missing.filter_map(Value::as_str);
    let mut text = text.filter(|text| text.starts_with("Fewer modes and other leaves are not"));
    let text = text.next().expect("a line");
    assert!(
        text.contains("share their keys") && page.contains(&text[..40]),
        "{text}"
    );
    assert!(list(&report, "modes").is_empty() && !list(&report, "depth").is_empty());
    assert_eq!(report["made"]["is_as_advised"], Value::Null);
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
    assert!(page.contains("<dt>basis</dt><dd>bones, no modes</dd>"));
    assert!(page.contains("<td class=\"text\">triangles, vertices</td>"));
    // Nothing to choose from, and no heading over nothing; leaves are tried all the same.
    assert!(list(&report, "modes").is_empty() && !page.contains("Modes kept</h2>"));
    assert_eq!(report["modes_over"], Value::Null);
    assert_eq!(number(&report["samples"]["of_parts"], "modes"), 24.0);
    let advice = list(&report, "advice");
    let says = |text: &str| {
        let texts = advice.iter().filter_map(|a| a["text"].as_str());
        texts.filter(|own| own.contains(text)).count()
    };
    assert_eq!(says("no modes to choose from"), 1);
    assert_eq!(
        says("leaf size") + says("Leaves of at most"),
        1,
        "{advice:?}"
    );
    assert!(!list(&report, "tightness").is_empty());
    for row in list(&report, "tightness") {
        assert!(number(&row["bdtree"], "mean") > 1.0 - 1e-6, "{row}");
    }
    assert_eq!(report["margin"]["violations"], 0);
    numbers_are_the_figures(&page, &report);
}
