//! Falling bodies at a small size: the same motion for any number of threads and after a break, and what is written.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use bdtree_build::basis::elastic::{ElasticOptions, elastic_basis};
use bdtree_build::input::read_mesh;
use bdtree_build::progress::Silent;
use bdtree_fixtures::{bake, models};
use bdtree_scenes::chairs::{Arguments, columns, run};
use bdtree_scenes::contenders::assets::baked_mesh;
use bdtree_scenes::report::without_times;
use clap::Parser;
use serde_json::Value;

/// A beam of one metre with four modes, which stands for a chair.
pub(crate) fn beam() -> &'static Path {
    static BEAM: OnceLock<(tempfile::TempDir, PathBuf)> = OnceLock::new();
    let (_, path) = BEAM.get_or_init(|| {
        let mesh = read_mesh(&models::path("beam")).expect("the fixture");
        let options = ElasticOptions {
            mode_count: 4,
            resolution: Some(24),
            ..ElasticOptions::default()
        };
        let (basis, _) =
            elastic_basis(&mesh, &options, &Silent, &mut Vec::new()).expect("vibration modes");
        let model = baked_mesh(&mesh, &basis).expect("bakes");
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("beam.bdt");
        fs::write(&path, model.asset().bytes()).expect("written");
        (folder, path)
    });
    path
}

fn arguments(options: &str) -> Result<Arguments, clap::Error> {
    let words = ["chairs"].into_iter().chain(options.split_whitespace());
    let mut arguments = Arguments::try_parse_from(words)?;
    arguments.asset = Some(beam().to_path_buf());
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
    let text = fs::read_to_string(folder.join("chairs-steps.csv")).expect("the steps");
    let is_row = |line: &&str| !line.starts_with("# part: from step ");
    text.lines().filter(is_row).map(str::to_string).collect()
}

/// The columns of the steps' file, without the clock's and what depends on the threads.
fn steps(folder: &Path) -> Vec<String> {
    let columns = columns();
    let kept = |column: usize| {
        let name = columns[column];
        !name.contains("updated") && name != "seconds"
    };
    let line = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells.len(), columns.len());
        let own = (0..cells.len()).filter(|column| kept(*column));
        own.map(|column| cells[column])
            .collect::<Vec<_>>()
            .join(",")
    };
    table(folder).iter().map(|own| line(own)).collect()
}

#[test]
fn motion_is_the_same_with_two_threads_and_after_a_break() {
    let folders = [(); 3].map(|()| tempfile::tempdir().expect("a folder"));
    let [one, two, broken] = folders.each_ref().map(tempfile::TempDir::path);
    let common = "--bodies 11 --steps 230 --seed 5 --check-every 10 --checkpoint-every 70";
    let whole = fall(common, one).expect("a run");
    let other = fall(&format!("{common} --threads 2"), two).expect("a run");
    assert_eq!(without_times(&whole), without_times(&other));
    assert_eq!(steps(one), steps(two));
    let state = |folder: &Path| fs::read(folder.join("state")).expect("a checkpoint");
    assert!(state(one) == state(two));
    // They have fallen, met the ground and each other, and contacts are those of brute force.
    let number = |at: &str| whole.pointer(at).and_then(Value::as_f64).expect(at);
    assert!(number("/totals/events/sum") > 1000.0, "{whole}");
    assert!(
        number("/totals/checked") > 10.0 && number("/totals/overlaps") > 0.0,
        "{whole}"
    );
    assert_eq!([number("/totals/extra"), number("/totals/below")], [0.0; 2]);
    assert!(
        number("/totals/missed") <= 0.01 * number("/totals/overlaps"),
        "{whole}"
    );
    for (threads, stop) in [(1, 90), (2, 140)] {
        let first = format!("--bodies 11 --steps {stop} --seed 5 --check-every 10");
        fall(&first, broken).expect("a run");
        let mut rest = arguments(&format!("{common} --threads {threads}")).expect("options");
        rest.options.resume = Some(broken.join("state"));
        rest.options.checkpoint = Some(broken.join("state"));
        rest.options.out = Some(broken.to_path_buf());
        let report = run(rest).expect("goes on");
        assert!(state(one) == state(broken), "{threads} threads from {stop}");
        assert_eq!(steps(one), steps(broken));
        assert_eq!(without_times(&whole), without_times(&report.value));
    }
}

/// A second wave begins to fall within the run; a break before it and one after it.
#[test]
fn waves_go_on_after_a_break() {
    let folders = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
    let [whole, broken] = folders.each_ref().map(tempfile::TempDir::path);
    let end = "--bodies 172 --rigid --steps 155 --check-every 0";
    let value = fall(end, whole).expect("a run");
    assert_eq!(value.pointer("/totals/bodies"), Some(&Value::from(172.0)));
    let bytes = fs::read(whole.join("state")).expect("a checkpoint");
    for stop in [150, 152] {
        let first = format!("--bodies 172 --rigid --steps {stop} --check-every 0");
        fall(&first, broken).expect("a run");
        let mut rest = arguments(end).expect("options");
        rest.options.resume = Some(broken.join("state"));
        rest.options.checkpoint = Some(broken.join("state"));
        run(rest).expect("goes on");
        assert!(bytes == fs::read(broken.join("state")).expect("a checkpoint"));
    }
}

#[test]
fn redundant_updates_change_no_motion() {
    let folders = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
    let [plain, redundant] = folders.each_ref().map(tempfile::TempDir::path);
    let rigid = "--bodies 4 --rigid --steps 120";
    let values = [
        fall(rigid, plain).expect("a run"),
        fall(&format!("{rigid} --redundant-updates"), redundant).expect("a run"),
    ];
    for at in ["/totals/events", "/totals/penetration_m", "/totals/sweeps"] {
        assert_eq!(values[0].pointer(at), values[1].pointer(at), "{at}");
    }
    let modal = |folder: &Path| {
        let column = columns()
            .iter()
            .position(|name| *name == "modal_J")
            .expect("there");
        let table = table(folder);
        let energies = (table.iter().skip(1)).map(|line| line.split(',').nth(column) == Some("0"));
        energies.filter(|is_zero| *is_zero).count()
    };
    assert_eq!([modal(plain), modal(redundant)], [120; 2]);
}

#[test]
fn what_is_asked_for_is_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = folder.path();
    let mut given = arguments("--bodies 3 --steps 12 --size 96x54").expect("options");
    given.options.out = Some(place.join("out"));
    given.options.frames = Some(place.join("film"));
    given.options.picture = Some(place.join("end.png"));
    given.updated = Some(place.join("updated.png"));
    let report = run(given).expect("a run");
    report.write(&place.join("out")).expect("written");
    for name in [
        "film/frame-00000.png",
        "film/frame-00002.png",
        "end.png",
        "updated.png",
    ] {
        let bytes = fs::read(place.join(name)).expect(name);
        assert!(bytes.starts_with(b"\x89PNG"), "{name}");
        assert_eq!(bytes[16..24], [0, 0, 0, 96, 0, 0, 0, 54], "{name}");
    }
    assert!(!place.join("film/frame-00003.png").exists());
    let table = table(&place.join("out"));
    assert_eq!(table[0], columns().join(","));
    assert_eq!(table.len(), 13);
    let json = fs::read_to_string(place.join("out/chairs.json")).expect("the report");
    let json: Value = serde_json::from_str(&json).expect("JSON");
    let number = |at: &str| json.pointer(at).and_then(Value::as_f64).expect(at);
    assert_eq!(number("/results/totals/steps"), 12.0);
    assert!(number("/results/spheres/mean_radius_m") > 0.0);
    assert!(number("/results/times/steps/seconds") > 0.0);
    assert!(number("/results/updated_picture/nodes_of_all_trees") > 3.0);
}

/// While a chair falls onto another in every step, the picture has at least what the step updated.
#[test]
fn updated_spheres_are_drawn() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut most = 0.0_f64;
    for steps in [60, 80, 100] {
        let options = format!("--bodies 5 --steps {steps} --size 96x54 --check-every 0");
        let mut given = arguments(&options).expect("options");
        given.updated = Some(folder.path().join("updated.png"));
        let report = run(given).expect("a run");
        let number = |of: &str| {
            let value = report.value.pointer(&format!("/updated_picture/{of}"));
            value.and_then(Value::as_f64).expect("a number")
        };
        assert!(number("nodes") >= number("counted_by_the_step"));
        assert!(number("nodes_of_all_trees") > number("nodes"));
        most = most.max(number("counted_by_the_step"));
    }
    assert!(most > 0.0);
}

#[test]
fn what_cannot_be_is_refused() {
    for wrong in [
        "--bodies 0",
        "--threads 0",
        "--redundant-updates",
        "--checkpoint-every 0",
        "--steps -1",
        "--size 7xa",
    ] {
        arguments(wrong).expect_err(wrong);
    }
    let folder = tempfile::tempdir().expect("a folder");
    let place = folder.path();
    let refused = |given: Arguments| run(given).expect_err("refused").to_string();
    let mut given = arguments("--bodies 2 --steps 1 --size 7").expect("options");
    assert!(refused(given.clone()).contains("--size"));
    given = arguments("--bodies 2 --steps 1 --level 99").expect("options");
    assert!(refused(given).contains("level 99"));
    fall("--bodies 2 --steps 8", place).expect("a run");
    let resumed = |options: &str| {
        let mut given = arguments(options).expect("options");
        given.options.resume = Some(place.join("state"));
        given
    };
    for other in [
        "--bodies 3",
        "--bodies 2 --seed 2",
        "--bodies 2 --rigid",
        "--bodies 2 --level 1",
    ] {
        assert!(
            refused(resumed(other)).contains("is of another run"),
            "{other}"
        );
    }
    let bytes = fs::read(place.join("state")).expect("a checkpoint");
    for len in [0, 10, 60, bytes.len() - 1] {
        fs::write(place.join("state"), &bytes[..len]).expect("written");
        assert!(refused(resumed("--bodies 2")).contains("state: "), "{len}");
    }
}

/// Bodies of a centimetre are too small for steps in which they fall by three.
#[test]
fn a_step_that_fails_ends_the_run_with_what_there_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = folder.path();
    let mut mesh = read_mesh(&models::path("icosphere")).expect("the fixture");
    for x in mesh.positions.iter_mut().flatten() {
        *x *= 0.005;
    }
    let model = baked_mesh(&mesh, &bake::rigid(&mesh)).expect("bakes");
    fs::write(place.join("small.bdt"), model.asset().bytes()).expect("written");
    let mut given = arguments("--bodies 9 --steps 400 --rigid --level 0").expect("options");
    given.asset = Some(place.join("small.bdt"));
    given.options.out = Some(place.to_path_buf());
    given.options.checkpoint = Some(place.join("state"));
    let error = run(given).expect_err("too deep").to_string();
    assert!(
        error.starts_with("step ") && error.contains("overlap by"),
        "{error}"
    );
    let text = fs::read_to_string(place.join("chairs-steps.csv")).expect("the steps");
    let last = text.lines().last().and_then(|line| line.split(',').next());
    let last: usize = last.and_then(|step| step.parse().ok()).expect("a step");
    assert!(error.starts_with(&format!("step {}:", last + 1)), "{error}");
    let json = fs::read_to_string(place.join("chairs.json")).expect("the report");
    let json: Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(json.pointer("/results/failure"), Some(&Value::from(error)));
    assert!(!place.join("state").exists(), "nobody goes on from there");
}
