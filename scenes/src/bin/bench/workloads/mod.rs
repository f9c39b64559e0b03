//! W1 to W4: the product beside those who deform all vertices and refit, the paper's lazy tree and
//! the layered hierarchy, in turns on the same inputs.

pub(crate) mod coherence;
mod libraries;
mod report;
mod works;

use std::error::Error;
use std::path::PathBuf;

use bdtree_measure::machine;
use bdtree_measure::turns::{Rounds, Turns};
use clap::{Args, ValueEnum};
use libraries::Libraries;
use serde_json::json;

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Which {
    /// A ball through a curtain
    W1,
    /// Two bodies
    W2,
    /// Rays
    W3,
    /// A pile of bodies
    W4,
}

#[derive(Args)]
pub(crate) struct Arguments {
    /// Only these
    #[arg(long, value_enum, value_delimiter = ',')]
    only: Vec<Which>,
    /// The curtain of 2 million triangles too
    #[arg(long)]
    large: bool,
    /// Only the product and these contenders ("none": it alone)
    #[arg(long, value_delimiter = ',')]
    with: Vec<String>,
    /// Write all figures there
    #[arg(long)]
    json: Option<PathBuf>,
    /// How often every contender runs all frames (the pile: half as often)
    #[arg(long, default_value_t = 15)]
    repeat: usize,
    /// Who comes after whom: after each pass over the frames the next contender, or each does all its passes
    #[arg(long, value_name = "pass|contender", default_value = "contender")]
    turns: Turns,
}

/// W1: must and aim by size.
const BALL: [[f64; 2]; 3] = [[25.0, 40.0], [150.0, 250.0], [200.0, 350.0]];

/// W3: rays a frame with must and aim, by size.
const RAYS: [[(usize, [f64; 2]); 3]; 2] = [
    [(1, [120.0, 200.0]), (16, [8.0, 15.0]), (1024, [0.5, 1.0])],
    [
        (1, [2000.0, 4000.0]),
        (16, [80.0, 150.0]),
        (1024, [2.0, 4.0]),
    ],
];

pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let repeats = arguments.repeat.max(1);
    let turns = arguments.turns;
    let with = &arguments.with;
    let rounds = Rounds {
        repeats,
        turns,
        with,
    };
    let wanted = |which| arguments.only.is_empty() || arguments.only.contains(&which);
    let vectors = if cfg!(target_feature = "avx2") {
        "built for this processor"
    } else {
        "built for any processor of its kind"
    };
    println!("{}, {vectors}", machine::processor());
    let libraries = Libraries::find()?;
    println!("embree4: {}", libraries.embree());
    println!("medians over {repeats} repetitions, floors in brackets");
    let mut all = Vec::new();
    let mut show = |works: Vec<report::Work>| {
        for work in works {
            work.print();
            all.push(work.json());
        }
    };
    if wanted(Which::W1) {
        for (size, goals) in BALL.into_iter().enumerate() {
            if size < 2 || arguments.large {
                show(vec![works::ball(&libraries, (size, goals), rounds)?]);
            }
        }
    }
    if wanted(Which::W2) {
        show(vec![works::pair(rounds)?]);
    }
    if wanted(Which::W3) {
        for (size, goals) in RAYS.iter().enumerate() {
            show(works::ray(&libraries, (size, goals), rounds)?);
        }
    }
    if wanted(Which::W4) {
        show(vec![works::pile(Rounds {
            repeats: repeats.div_ceil(2),
            ..rounds
        })?]);
    }
    if let Some(path) = &arguments.json {
        let value = json!({"machine": machine::processor(), "vectors": vectors,
            "embree4": libraries.embree(), "repeats": repeats,
            "turns": format!("{turns:?}").to_lowercase(), "works": all});
        std::fs::write(path, format!("{value:#}\n"))?;
    }
    Ok(())
}
