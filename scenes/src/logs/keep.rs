//! The log of a run of `chairs` or `fish` that has ended: its steps, and what its report says beside sums over them.

use std::error::Error;
use std::fs;
use std::path::Path;

use serde_json::Value;

use super::file::LogFile;

/// Programs of falling bodies.
const PROGRAMS: [&str; 2] = ["chairs", "fish"];

/// Of the report, what the steps do not have.
const PARTS: [&str; 3] = ["settings", "spheres", "pictures"];

/// # Errors
/// A folder that has not the report and the steps of one run, a run that failed or whose first steps are not there.
pub(super) fn keep(folder: &Path, file: &Path) -> Result<(), Box<dyn Error>> {
    let report = |name: &&str| folder.join(format!("{name}.json"));
    let there: Vec<&str> = (PROGRAMS.into_iter())
        .filter(|name| report(name).is_file())
        .collect();
    let [program] = there[..] else {
        let why = "name the --out folder of one run that has ended, with chairs.json or fish.json";
        return Err(format!("{}: {why}", folder.display()).into());
    };
    let path = report(&program);
    let text = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    let all: Value = serde_json::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))?;
    let path = folder.join(format!("{program}-steps.csv"));
    let mut log = LogFile::read(&path)?;
    complete(&all["results"], &log).map_err(|why| format!("{}: {why}", path.display()))?;
    log.about = about(program, &all, &log);
    log.round();
    log.write(file)
}

/// Why steps are not all of a run.
fn complete(results: &Value, log: &LogFile) -> Result<(), String> {
    if let Some(failure) = results["failure"].as_str() {
        return Err(format!("the run failed: {failure}"));
    }
    let end = results["end"].as_u64().ok_or("the report has no end")?;
    let steps = log.column("step").ok_or("has no column `step`")?;
    let expected = (1..=end).map(|step| step as f64);
    if !steps.iter().copied().eq(expected) {
        return Err(format!(
            "does not have the steps from 1 to {end}, each once"
        ));
    }
    Ok(())
}

/// What the log is of.
fn about(program: &str, all: &Value, steps: &LogFile) -> Vec<(String, String)> {
    let (results, times) = (&all["results"], &all["results"]["times"]);
    let text = |value: &Value| match value {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    let settings = &results["settings"];
    let mut command = program.to_string();
    for option in ["bodies", "steps", "seed"] {
        command += &format!(" --{option} {}", settings[option]);
    }
    for option in ["rigid", "redundant_updates"] {
        if settings[option] == true {
            command += &format!(" --{}", option.replace('_', "-"));
        }
    }
    command += &format!(" --threads {}", times["threads"]);
    let mut log = LogFile::default();
    log.say("program", program);
    log.say("command", command);
    let parts: Vec<&str> = steps.said("part").collect();
    for part in &parts {
        log.say("part", part);
    }
    // Of a run whose steps do not say what made them.
    if parts.is_empty() {
        let [commit, machine] = ["commit", "machine"].map(|key| text(&all[key]));
        let threads = &times["threads"];
        let part = format!("from step 1: commit {commit}, threads {threads}, {machine}");
        log.say("part", part);
    }
    let loads = times["load"].as_array().into_iter().flatten().map(text);
    let loads: Vec<String> = loads.collect();
    log.say("load at begin and end", loads.join("; "));
    let memory = &times["memory_bytes"];
    if memory.is_u64() {
        log.say("memory after the last step, bytes", memory);
    }
    log.say("numbers", "six digits of those that are not whole");
    for part in PARTS.iter().filter(|part| !results[**part].is_null()) {
        log.say(part, &results[*part]);
    }
    log.about
}
