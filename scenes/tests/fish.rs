//! Fish on a small bridge: the same motion for any number of threads and after a break, nothing goes through the deck, and
//! what is written.

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use bdtree_build::basis::elastic::{ElasticOptions, elastic_basis};
use bdtree_build::input::read_mesh;
use bdtree_build::mass::Body;
use bdtree_build::pipeline::{BakeSettings, Provenance, bake_fields};
use bdtree_build::progress::Silent;
use bdtree_fixtures::{bake, models};
use bdtree_runtime::Model;
use bdtree_scenes::contenders::assets::baked_mesh;
use bdtree_scenes::fish::{Arguments, columns, run};
use bdtree_scenes::report::without_times;
use clap::Parser;
use serde_json::Value;

/// A folder of assets: a beam of 0.3 m with three modes for a fish, a deck that sways for a bridge.
fn assets() -> &'static Path {
    static ASSETS: OnceLock<tempfile::TempDir> = OnceLock::new();
    let folder = ASSETS.get_or_init(|| {
        let mut mesh = read_mesh(&models::path("beam")).expect("the fixture");
        for x in mesh.positions.iter_mut().flatten() {
            *x *= 0.3;
        }
        let options = ElasticOptions {
            mode_count: 3,
            resolution: Some(24),
            young_pa: 1e7,
            scale_m: 2.5,
            ..ElasticOptions::default()
        };
        let (basis, _) =
            elastic_basis(&mesh, &options, &Silent, &mut Vec::new()).expect("vibration modes");
        let folder = tempfile::tempdir().expect("a folder");
        let keep = |name: &str, model: Model| {
            fs::write(folder.path().join(name), model.asset().bytes()).expect("written");
        };
        let settings = BakeSettings {
            body: Body {
                scale_m: 2.5,
                ..Body::default()
            },
            ..BakeSettings::default()
        };
        let baked = bake_fields(&mesh, &basis, &settings, &Provenance::default(), &Silent);
        let bytes = baked.expect("bakes").bytes;
        keep("fish.bdt", Model::from_bytes(&bytes).expect("an asset"));
        let (mesh, basis) = bake::swaying_deck();
        keep("bridge.bdt", baked_mesh(&mesh, &basis).expect("bakes"));
        folder
    });
    folder.path()
}

fn arguments(options: &str) -> Result<Arguments, clap::Error> {
    let words = ["fish"].into_iter().chain(options.split_whitespace());
    let mut arguments = Arguments::try_parse_from(words)?;
    arguments.assets = Some(assets().to_path_buf());
    Ok(arguments)
}

/// Runs in a folder, where the checkpoint and all that is written lie.
fn fall(options: &str, folder: &Path) -> Result<Value, String> {
    let mut arguments = arguments(options).expect("options");
    arguments.options.out = Some(folder.to_path_buf());
    arguments.options.checkpoint = Some(folder.join("state"));
    let report = run(arguments).map_err(|error| error.to_string())?;
    report.write(folder).expect("written");
    Ok(report.value)
}

/// The lines of the steps' file, without those that say what made them.
fn table(folder: &Path) -> Vec<String> {
    let text = fs::read_to_string(folder.join("fish-steps.csv")).expect("the steps");
    let is_row = |line: &&str| !line.starts_with("# part: from step ");
    text.lines().filter(is_row).map(str::to_string).collect()
}

/// A column of the steps' file.
fn column(folder: &Path, name: &str) -> Vec<f64> {
    let table = table(folder);
    let at = columns().iter().position(|own| *own == name).expect(name);
    let cells = table.iter().skip(1).map(|line| line.split(',').nth(at));
    let number = |cell: Option<&str>| cell.and_then(|cell| cell.parse().ok()).expect("a number");
    cells.map(number).collect()
}

#[test]
fn motion_is_the_same_with_two_threads_and_after_a_break() {
    let folders = [(); 3].map(|()| tempfile::tempdir().expect("a folder"));
    let [one, two, broken] = folders.each_ref().map(tempfile::TempDir::path);
    let common = "--bodies 20 --steps 1000 --seed 3 --check-every 40 --checkpoint-every 100";
    let whole = fall(common, one).expect("a run");
    let other = fall(&format!("{common} --threads 2"), two).expect("a run");
    assert_eq!(without_times(&whole), without_times(&other));
    let state = |folder: &Path| fs::read(folder.join("state")).expect("a checkpoint");
    assert!(state(one) == state(two));
    // Fish have met the bridge and each other, they lie on it, and none went through.
    let number = |at: &str| whole.pointer(at).and_then(Value::as_f64).expect(at);
    for at in ["fish_contacts/sum", "bridge_contacts/sum"] {
        assert!(number(&format!("/totals/{at}")) > 100.0, "{whole}");
    }
    assert_eq!(
        [number("/totals/passed"), number("/totals/extra")],
        [0.0; 2]
    );
    assert!(number("/totals/checked") > 10.0, "{whole}");
    let most = |name: &str| column(one, name).into_iter().fold(0.0, f64::max);
    assert!(
        most("touching") > 15.0 && most("in_water") == 0.0,
        "{whole}"
    );
    // The bridge sways as its animation says, and again after two seconds.
    let sway = column(one, "sway_m");
    assert!((number("/totals/sway_m") - 0.3).abs() < 1e-3, "{whole}");
    assert!((sway[10] - sway[970]).abs() < 1e-6 && (sway[10] - sway[490]).abs() > 0.2);

    let first = "--bodies 20 --steps 430 --seed 3 --check-every 40";
    fall(first, broken).expect("a run");
    let mut rest = arguments(&format!("{common} --threads 2")).expect("options");
    rest.options.resume = Some(broken.join("state"));
    rest.options.checkpoint = Some(broken.join("state"));
    rest.options.out = Some(broken.to_path_buf());
    let report = run(rest).expect("goes on");
    assert!(state(one) == state(broken));
    assert_eq!(without_times(&whole), without_times(&report.value));
    // Not onto another bridge.
    let moved = tempfile::tempdir().expect("a folder");
    fs::copy(assets().join("fish.bdt"), moved.path().join("fish.bdt")).expect("copied");
    let (mut mesh, basis) = bake::swaying_deck();
    mesh.positions[0][1] -= 0.01;
    let other = baked_mesh(&mesh, &basis).expect("bakes");
    fs::write(moved.path().join("bridge.bdt"), other.asset().bytes()).expect("written");
    let mut rest = arguments(common).expect("options");
    rest.options.resume = Some(broken.join("state"));
    rest.assets = Some(moved.path().to_path_buf());
    let error = run(rest).expect_err("another bridge").to_string();
    assert!(error.contains("is of another run"), "{error}");
}

#[test]
fn what_is_asked_for_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = folder.path();
    let mut given = arguments("--bodies 3 --steps 17 --size 96x54 --whole").expect("options");
    given.options.out = Some(place.join("out"));
    given.options.frames = Some(place.join("film"));
    given.options.picture = Some(place.join("end.png"));
    let report = run(given).expect("a run");
    report.write(&place.join("out")).expect("written");
    for name in ["film/frame-00000.png", "film/frame-00001.png", "end.png"] {
        let bytes = fs::read(place.join(name)).expect(name);
        assert!(bytes.starts_with(b"\x89PNG"), "{name}");
        assert_eq!(bytes[16..24], [0, 0, 0, 96, 0, 0, 0, 54], "{name}");
    }
    let table = table(&place.join("out"));
    assert_eq!(table[0], columns().join(","));
    assert_eq!(table.len(), 18);
    let number = |at: &str| report.value.pointer(at).and_then(Value::as_f64).expect(at);
    // Three pictures of three fish and the bridge.
    assert_eq!(number("/pictures/pictures"), 3.0);
    let seen = number("/pictures/bodies") + number("/pictures/left_out_by_sphere");
    assert!((seen + number("/pictures/left_out_by_tree") - 4.0).abs() < 1e-9);
    assert_eq!(number("/settings/bridge/period_s"), 2.0);
    // A beam of 0.75 m and 37.5 mm, as heavy as water.
    assert!((number("/settings/fish_kg") - 1.0546875).abs() < 1e-6);
}
