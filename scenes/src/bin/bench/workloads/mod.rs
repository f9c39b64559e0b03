//! W1 to W5: the product beside those who deform all vertices and refit, the paper's lazy tree and
//! the layered hierarchy, in turns on the same inputs. All contenders run all frames as often as the rounds say (the
//! pile's half as often).

pub(crate) mod coherence;
mod libraries;
mod report;
mod works;

use bdtree_measure::turns::{Rounds, Turns};
use clap::{Args, ValueEnum};

use libraries::Libraries;

use crate::prelude::*;

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
    /// Characters
    W5,
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
    /// Who comes after whom: after each pass over the frames the next contender, or each does all its passes
    #[arg(long, value_name = "pass|contender", default_value = "contender")]
    turns: Turns,
}

/// W1: must and aim by size.
const BALL: [[f64; 2]; 3] = [[25.0, 40.0], [150.0, 250.0], [200.0, 350.0]];

/// W3: rays a frame with must and aim, by size.
const RAYS: [[(usize, [f64; 2]); 4]; 2] = [
    [
        (1, [120.0, 200.0]),
        (16, [8.0, 15.0]),
        (1024, [0.5, 1.0]),
        (100_000, [0.8, 0.8]),
    ],
    [
        (1, [2000.0, 4000.0]),
        (16, [80.0, 150.0]),
        (1024, [2.0, 4.0]),
        (100_000, [0.8, 0.8]),
    ],
];

/// W5: must and aim by size.
const CHARACTERS: [[f64; 2]; 2] = [[10.0, 20.0], [100.0, 200.0]];

/// W5: rays a frame with must and aim, by size.
const CHARACTER_RAYS: [&[(usize, [f64; 2])]; 2] = [
    &[],
    &[(16, [8.0, 15.0]), (1024, [0.5, 1.0]), (100_000, [0.8, 0.8])],
];

pub(crate) fn run(arguments: &Arguments, repeats: usize) -> Result<Vec<Table>> {
    let rounds = Rounds {
        repeats,
        turns: arguments.turns,
        with: &arguments.with,
    };
    let wanted = |which| arguments.only.is_empty() || arguments.only.contains(&which);
    let vectors = if cfg!(target_feature = "avx2") {
        "built for this processor"
    } else {
        "built for any processor of its kind"
    };
    let libraries = Libraries::find()?;
    let run = row! {
        "vectors" => vectors, "embree4" => libraries.embree(), "repetitions" => repeats,
        "turns" => format!("{:?}", arguments.turns).to_lowercase(),
    };
    let mut works = Vec::new();
    if wanted(Which::W1) {
        let sizes = if arguments.large { 3 } else { 2 };
        for (size, goals) in BALL.into_iter().enumerate().take(sizes) {
            works.push(works::ball(&libraries, (size, goals), rounds)?);
        }
    }
    if wanted(Which::W2) {
        works.push(works::pair(rounds)?);
    }
    if wanted(Which::W3) {
        for (size, goals) in RAYS.iter().enumerate() {
            works.extend(works::ray(&libraries, (size, goals), rounds)?);
        }
    }
    if wanted(Which::W4) {
        let repeats = repeats.div_ceil(2);
        works.push(works::pile(Rounds { repeats, ..rounds })?);
    }
    if wanted(Which::W5) {
        for (size, goals) in CHARACTERS.into_iter().enumerate() {
            let goals = (size, goals, CHARACTER_RAYS[size]);
            works.extend(works::character(&libraries, goals, rounds)?);
        }
    }
    let mut tables = vec![table("run", "The run", &[run])];
    tables.extend(report::tables(&works));
    Ok(tables)
}
