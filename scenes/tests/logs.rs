//! Logs of small runs: of one that went on after a break, of deformable bodies beside rigid ones, of pictures.

use std::fs;
use std::path::Path;

use bdtree_scenes::chairs;
use bdtree_scenes::logs::{Arguments, run};
use clap::Parser;
use serde_json::Value;

use crate::chairs::beam;

/// Beams that fall, with a checkpoint and all that is written in a folder.
fn fall(options: &str, resume: bool, folder: &Path) {
    let state = folder.join("state").display().to_string();
    let own = ["chairs", "--checkpoint", &state];
    let words = own.into_iter().chain(options.split_whitespace());
    let mut arguments = chairs::Arguments::try_parse_from(words).expect("options");
    arguments.asset = Some(beam().to_path_buf());
    arguments.options.out = Some(folder.to_path_buf());
    arguments.options.resume = resume.then(|| folder.join("state"));
    let report = chairs::run(arguments).expect("a run");
    report.write(folder).expect("written");
}

/// Makes a log.
fn log(what: &str, options: &str, paths: &[&Path]) -> Result<(), String> {
    let words = ["logs", what]
        .into_iter()
        .chain(options.split_whitespace())
        .map(str::to_string);
    let paths = paths.iter().map(|path| path.display().to_string());
    let arguments = Arguments::try_parse_from(words.chain(paths)).map_err(|e| e.to_string())?;
    run(&arguments).map_err(|error| error.to_string())
}

/// What it says of itself, then columns and rows.
fn parts(path: &Path) -> (Vec<String>, Vec<String>, Vec<Vec<f64>>) {
    let text = fs::read_to_string(path).expect("a log");
    let mut about = Vec::new();
    let mut lines = Vec::new();
    for line in text.lines() {
        match line.strip_prefix("# ") {
            Some(said) => about.push(said.to_string()),
            None => lines.push(line),
        }
    }
    let columns = lines[0].split(',').map(str::to_string).collect();
    let number = |cell: &str| {
        if cell.is_empty() {
            f64::NAN
        } else {
            cell.parse().expect("a number")
        }
    };
    let rows = lines[1..]
        .iter()
        .map(|line| line.split(',').map(number).collect())
        .collect();
    (about, columns, rows)
}

#[test]
fn a_run_is_kept_with_what_made_its_parts() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let file = folder.path().join("log.csv");
    fall("--bodies 3 --steps 40", false, &out);
    fall("--bodies 3 --steps 60 --threads 2", true, &out);
    log("keep", "", &[&out, &file]).expect("a log");
    let (about, columns, rows) = parts(&file);
    assert_eq!(columns, chairs::columns());
    assert_eq!(rows.len(), 60);
    let said = |begin: &str| -> Vec<&String> {
        about
            .iter()
            .filter(|said| said.starts_with(begin))
            .collect()
    };
    assert_eq!(said("program: "), ["program: chairs"]);
    let command = "command: chairs --bodies 3 --steps 60 --seed 1 --threads 2";
    assert_eq!(said("command: "), [command]);
    let of_parts = said("part: ");
    assert_eq!(of_parts.len(), 2);
    for (part, (from, threads)) in of_parts.iter().zip([(1, 1), (41, 2)]) {
        assert!(
            part.starts_with(&format!("part: from step {from}: commit ")),
            "{part}"
        );
        assert!(part.contains(&format!(", threads {threads}, ")), "{part}");
        assert!(part.ends_with(" cores"), "{part}");
    }
    // Those of the table to six digits, whole ones exactly.
    let (_, _, exact) = parts(&out.join("chairs-steps.csv"));
    for (row, exact) in rows.iter().flatten().zip(exact.iter().flatten()) {
        let is_near = (row - exact).abs() <= 5e-6 * exact.abs();
        assert!(is_near || row.is_nan() && exact.is_nan(), "{row} {exact}");
        assert!(exact.fract() != 0.0 || row == exact, "{row} {exact}");
    }
    // A compressed one has the same lines.
    let packed = folder.path().join("log.csv.gz");
    log("keep", "", &[&out, &packed]).expect("a log");
    let [packed, plain] = [packed, file].map(|path| fs::read(path).expect("bytes"));
    assert!(packed.starts_with(&[0x1f, 0x8b]) && packed.len() < plain.len() / 2);
}

#[test]
fn runs_that_have_not_ended_are_not_kept() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let file = folder.path().join("log.csv");
    let refused = |says: &str| {
        let error = log("keep", "", &[&out, &file]).expect_err(says);
        assert!(error.contains(says), "{error}");
        assert!(!file.exists());
    };
    refused("name the --out folder of one run that has ended");
    fall("--bodies 2 --steps 9", false, &out);
    let place = out.join("chairs.json");
    let text = fs::read_to_string(&place).expect("the report");
    let mut report: Value = serde_json::from_str(&text).expect("JSON");
    report["results"]["failure"] = "step 10: too deep".into();
    fs::write(&place, report.to_string()).expect("written");
    refused("chairs-steps.csv: the run failed: step 10: too deep");
    fs::write(&place, &text[..text.len() / 2]).expect("written");
    refused("chairs.json: ");
    fs::write(&place, text).expect("written");
    let place = out.join("chairs-steps.csv");
    let steps = fs::read_to_string(&place).expect("the steps");
    let lines: Vec<&str> = steps.lines().collect();
    fs::write(&place, lines[..lines.len() - 1].join("\n")).expect("written");
    refused("chairs-steps.csv: does not have the steps from 1 to 9");
    let cut = steps.len() - lines[lines.len() - 1].len() / 2;
    fs::write(&place, &steps[..cut]).expect("written");
    refused("chairs-steps.csv, line 11: is no row of ");
}

/// Redundant updates move nothing, and every repetition is the same but for its time.
#[test]
fn rigid_bodies_are_measured_beside_deformable_ones() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = folder.path();
    let [soft, hard] = ["soft", "hard"].map(|name| place.join(name));
    let common = "--bodies 16 --steps 180 --check-every 0 --checkpoint-every 140 --keep-all";
    fall(common, false, &soft);
    fall(&format!("{common} --rigid"), false, &hard);
    let file = place.join("ratios.csv");
    let measure = |deformable: &[&str], rigid: &[&str]| {
        let paths = |folder: &Path, names: &[&str]| -> String {
            let paths = names
                .iter()
                .map(|name| folder.join(name).display().to_string());
            paths.collect::<Vec<_>>().join(" ")
        };
        let options = format!(
            "--asset {} --steps 20 --before 10 --threads 2 --deformable {} --rigid {}",
            beam().display(),
            paths(&soft, deformable),
            paths(&hard, rigid),
        );
        log("ratios", &format!("{} {options}", file.display()), &[])
    };
    let both = ["state-140", "state-180"];
    measure(&both, &both).expect("a table");
    let (about, columns, rows) = parts(&file);
    assert!(about.contains(&"program: logs ratios".to_string()));
    assert!(about.contains(&"threads: 2".to_string()));
    let begin = ["step", "repeat", "deformable_s", "deformable_events"];
    assert_eq!(columns[..4], begin);
    let places: Vec<&[f64]> = rows.iter().map(|row| &row[..2]).collect();
    assert_eq!(
        places,
        [[150.0, 1.0], [190.0, 1.0], [150.0, 2.0], [190.0, 2.0]]
    );
    for (row, first) in rows.iter().zip([0, 1, 0, 1]) {
        assert!([2, 4, 6].iter().all(|at| row[*at] > 0.0), "{row:?}");
        assert!(row[3] > 5.0 && row[5] > 5.0, "{row:?}");
        assert_eq!([row[3], row[5]], [rows[first][3], rows[first][5]]);
        assert_eq!(row[5], row[7]);
    }
    // The last checkpoint is that of the end.
    let bytes = |name: &str| fs::read(soft.join(name)).expect(name);
    assert!(bytes("state") == bytes("state-180"));
    // What cannot be compared.
    let table = fs::read(&file).expect("the table");
    let refused = |deformable: &[&str], rigid: &[&str], says: &str| {
        let error = measure(deformable, rigid).expect_err(says);
        assert!(error.contains(says), "{error}");
        assert!(fs::read(&file).expect("the table") == table);
    };
    refused(
        &both,
        &both[..1],
        "--deformable has 2 checkpoints, --rigid 1",
    );
    refused(&both[..1], &both[1..], "are not after as many steps");
    refused(
        &["../hard/state"],
        &["state"],
        "is of rigid chairs: name one of chairs that deform",
    );
    refused(
        &["state"],
        &["../soft/state"],
        "is of chairs that deform: name one of rigid chairs",
    );
    fs::write(soft.join("state"), b"something else\n").expect("written");
    refused(
        &["state"],
        &["state"],
        "state: is not a checkpoint of falling chairs",
    );
}

#[test]
fn pictures_are_timed() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("pictures.csv");
    fall("--bodies 5 --steps 400", false, folder.path());
    let options = format!("--asset {} --size 96x54 --repeat 3", beam().display());
    let state = folder.path().join("state");
    log("pictures", &options, &[&file, &state]).expect("a table");
    let (about, columns, rows) = parts(&file);
    assert!(
        about.iter().any(|said| said.starts_with("adapter: ")),
        "{about:?}"
    );
    assert!(about.contains(&"size: 96 x 54".to_string()));
    assert_eq!(columns[..4], ["step", "repeat", "contacts", "bodies"]);
    assert_eq!(rows.len(), 3);
    for row in &rows {
        assert_eq!(row[0], 401.0);
        assert!(row[2] > 0.0, "they lie on the ground: {row:?}");
        assert_eq!(row[3] + row[4] + row[5], 5.0, "{row:?}");
        assert!(row[8] > 0.0, "{row:?}");
    }
    let error = log("pictures", "--size 7", &[&file, &state]).expect_err("no size");
    assert!(error.contains("--size"), "{error}");
}
