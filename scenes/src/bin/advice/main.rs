//! How right `--advise` is: on real assets, the advised setting beside the best of all that keep the same error.
//!
//! Every number of modes that meets the goal is baked with every leaf size and timed in turn with the asset as it
//! is; the fastest few and the advised setting are then timed once more, all in turn, since the least of many times
//! is less than what it stands for. docs/advice.md holds the figures.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use bdtree_build::advise::curve::{Bench, Point};
use bdtree_build::advise::subject::kept_fields;
use bdtree_build::advise::{Advice, Goal, Subject, advise};
use bdtree_build::basis::dropped::Keep;
use bdtree_build::basis::given::Layout;
use bdtree_build::basis::pca::{Modes, PcaOptions};
use bdtree_build::progress::Silent;
use bdtree_build::recipe::{Elastic, Frames, Given, Morphs, Motion, Recipe, Source};
use bdtree_fixtures::models::fields::npy_with;
use bdtree_scenes::report::{Report, Row, table};
use bdtree_scenes::row;
use clap::Parser;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

#[derive(Parser)]
#[command(about = "The advised setting beside the best of an exhaustive sweep")]
struct Arguments {
    /// Folder of the test data [default: what BDTREE_CORPUS names]
    #[arg(long)]
    corpus: Option<PathBuf>,
    /// Only the assets whose names contain this
    #[arg(long, default_value = "")]
    only: String,
    /// Seconds that timing one setting beside others may take
    #[arg(long, default_value_t = 1.0)]
    seconds: f64,
}

/// Real assets of different kinds: what their modes are, and the largest error over the diagonal that is allowed.
const ASSETS: [(&str, &str, f64); 6] = [
    ("curtain_large", "32 components of 50 frames", 0.01),
    ("curtain_wind", "32 components of 100 frames", 0.01),
    ("bridge", "20 given fields", 0.2),
    ("turtle", "20 vibration modes", 0.2),
    ("AnimatedMorphSphere", "2 morph targets", 0.01),
    ("RobotExpressive", "3 morph targets", 0.05),
];

/// An asset of the test data by its name.
fn source(name: &str, corpus: &Path) -> Result<Source> {
    let (path, motion) = match name {
        "curtain_large" => return Ok(components(corpus, name, "rest")),
        "curtain_wind" => return Ok(components(corpus, name, "000")),
        "bridge" => ("modal/bridge_rest.obj.gz", bridge(corpus)?),
        "turtle" => {
            let mut elastic = Elastic::default();
            elastic.options.mode_count = 20;
            ("meshes/turtle.obj", Motion::Elastic(elastic))
        }
        "RobotExpressive" => ("characters/RobotExpressive.glb", morphs()),
        _ => {
            let path = "characters/AnimatedMorphSphere/AnimatedMorphSphere.gltf";
            (path, morphs())
        }
    };
    Ok(Recipe::of_surface(corpus.join(path), motion).source)
}

fn morphs() -> Motion {
    Motion::Morphs(Morphs::default())
}

/// An animation whose surface is the mesh with this ending.
fn components(corpus: &Path, name: &str, surface: &str) -> Source {
    let folder = corpus.join("animations").join(name);
    Source::Frames(Frames {
        path: folder.join(format!("{name}.pc2")),
        surface: Some(folder.join(format!("{name}_{surface}.obj"))),
        fps: None,
        options: PcaOptions {
            modes: Modes::Count(32),
            ..PcaOptions::default()
        },
    })
}

/// The bridge's own modes, of a file of VegaFEM: counts of numbers and fields as i32, then field after field.
fn bridge(corpus: &Path) -> Result<Motion> {
    const FIELDS: usize = 20;
    let bytes = fs::read(corpus.join("modal/bridge_modes_U.f32"))?;
    let numbers = bytes.get(8..).unwrap_or_default();
    let extents = format!("{FIELDS},{},3,", numbers.len() / (12 * FIELDS));
    let array = npy_with("<f4", false, &extents, numbers.iter().copied());
    let path = PathBuf::from("target/advice-bridge.npy");
    fs::write(&path, array)?;
    Ok(Motion::Given(Given {
        path,
        layout: Some(Layout::MN3),
        frequencies: None,
        keep: Keep::All,
        range_rel: None,
    }))
}

/// Leaf sizes of the sweep.
const LEAF_SIZES: [usize; 6] = [1, 2, 3, 4, 6, 8];

/// Settings that are timed again.
const FINALISTS: usize = 4;

/// Takes the advice, then tries everything.
fn sweep(name: &str, words: &str, max_error_rel: f64, arguments: &Arguments) -> Result<Row> {
    let corpus = std::env::var_os("BDTREE_CORPUS").map(PathBuf::from);
    let corpus = arguments.corpus.clone().or(corpus);
    let corpus = corpus.ok_or("no test data: --corpus FOLDER")?;
    let mut recipe = Recipe::new(source(name, &corpus)?);
    recipe.settings.threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    let subject = &Subject::of_recipe(&recipe, None, &Silent)?;
    let kind = &subject.provenance.kind;
    let goal = Goal {
        max_error_rel,
        subset: kept_fields(kind, &subject.mesh, &subject.basis, max_error_rel),
        seconds: arguments.seconds,
        ..Goal::default()
    };
    let advice = advise(subject, &goal, &Silent)?;
    let chosen = &advice.chosen;
    let bench = Bench::new(subject, goal.samples, goal.seconds, &Silent)?;
    let mut all = Vec::new();
    for modes in good_enough(subject, &goal, &advice) {
        let settings = LEAF_SIZES.map(|size| (&modes[..], size));
        all.extend(bench.points(&settings, &Silent)?.1);
        eprintln!("{} modes of {} timed", modes.len(), subject.mesh.name);
    }
    all.sort_by(|a, b| a.time_rel.total_cmp(&b.time_rel));
    let finalists = all.iter().take(FINALISTS).chain([chosen]);
    let finalists: Vec<_> = finalists
        .map(|point| (&point.modes[..], point.leaf_size))
        .collect();
    let (_, again) = bench.points(&finalists, &Silent)?;
    let advised = again.last().ok_or("no setting was measured")?;
    let best = again
        .iter()
        .min_by(|a, b| a.time_rel.total_cmp(&b.time_rel));
    let best = best.unwrap_or(advised);
    let setting = |point: &Point| {
        let (kept, count) = (point.modes.len(), subject.basis.mode_count());
        format!("{kept} of {count} modes, leaves of {}", point.leaf_size)
    };
    let saved = |share: f64| 100.0 * (1.0 - share);
    Ok(row! {
        "asset" => name, "source" => words, "triangles" => subject.mesh.triangles.len(),
        "goal, %" => 100.0 * max_error_rel, "advised" => setting(chosen),
        "saves of all modes' bytes, %" => saved(chosen.bytes as f64 / advice.all.bytes as f64),
        "time, %" => saved(chosen.time_rel),
        "best of the sweep" => setting(best), "settings" => all.len(),
        "advised / best" => advised.measured.time_over(&best.measured),
    })
}

/// Modes that keep to the goal: of the first ones every number that does, and what an error limit chooses.
/// Where nothing does, what is advised.
fn good_enough(subject: &Subject, goal: &Goal, advice: &Advice) -> Vec<Vec<usize>> {
    let is_good = |count: &usize| {
        let bound = subject.errors.bound_rel(*count);
        bound.is_some_and(|bound| bound <= goal.max_error_rel)
    };
    let counts = (0..=subject.basis.mode_count()).filter(is_good);
    let mut good: Vec<Vec<usize>> = counts.map(|count| (0..count).collect()).collect();
    good.extend(goal.subset.iter().map(|(modes, _)| modes.clone()));
    good.push(advice.chosen.modes.clone());
    good.sort();
    good.dedup();
    good
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let mut rows = Vec::new();
    for (name, words, goal) in ASSETS {
        if name.contains(&arguments.only) {
            rows.push(sweep(name, words, goal, &arguments)?);
        }
    }
    let title = "Advised settings beside the best of all that keep to the goal";
    Report::of_tables("advice", vec![table("assets", title, &rows)]).show(None)
}
