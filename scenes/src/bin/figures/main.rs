//! The paper's Figures 4 and 6 with our own mesh: the layered hierarchy, the paper's BD-Tree and our
//! bound over the same binary tree, as pictures and as a table.
//!
//!     cargo run --release -p bdtree-scenes --bin figures -- target/chair.bdt docs/images
//!
//! Colours and ratios are the paper's: a sphere's radius over that of the undeformed wrapped sphere of
//! the same node in the paper's tree (which ours may be below).

mod montage;

use std::error::Error;
use std::path::PathBuf;

use bdtree_render::tightness::mean_and_max;
use bdtree_runtime::Model;
use bdtree_scenes::hierarchies::{Found, Hierarchies, Kind};
use bdtree_scenes::report::{Table, table};
use bdtree_scenes::row;
use clap::Parser;

use montage::{Cell, Stage};

#[derive(Parser)]
#[command(about = "Draws the paper's Figures 4 and 6 and prints their numbers")]
struct Arguments {
    /// An asset
    file: PathBuf,
    /// Folder for figure-4.png and figure-6.png
    folder: PathBuf,
    /// The deformation of figure 6: q over the modes' q_range, the first modes first, the others 0
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "1.5,-1.2,1,1",
        allow_hyphen_values = true
    )]
    q_of_range: Vec<f32>,
    /// The level of figure 6 (the paper's: 64 spheres)
    #[arg(long, default_value_t = 6)]
    level: usize,
    /// Degrees around y and from above
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "30,15",
        allow_hyphen_values = true
    )]
    view: Vec<f32>,
    /// Width and height of each picture of a figure, in pixels
    #[arg(long, default_value_t = 290)]
    cell: u32,
}

/// The levels of figure 4.
const LEVELS: [usize; 4] = [0, 2, 4, 6];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let model = Model::load(&arguments.file)?;
    let asset = *model.asset();
    let rest = vec![0.0; asset.mode_count()];
    let mut bent = rest.clone();
    let ranges = asset.modes().iter().map(|mode| mode.q_range.get());
    for ((q, range), share) in bent.iter_mut().zip(ranges).zip(&arguments.q_of_range) {
        *q = share * range;
    }
    let hierarchies = Hierarchies::new(asset);
    let poses = [("at rest", &rest), ("deformed", &bent)];
    for (name, q) in poses {
        println!("{}", ratio_table(&hierarchies, name, q)?.markdown());
    }

    let view = [0, 1].map(|k| arguments.view.get(k).copied().unwrap_or(0.0));
    let mut stage = Stage::new(asset, &[&rest, &bent], view, arguments.cell)?;
    let mut posed = [hierarchies.posed(&rest)?, hierarchies.posed(&bent)?];
    let mut rows = Vec::new();
    for kind in Kind::ALL {
        let mut cells = Vec::new();
        for level in LEVELS {
            let found = hierarchies.level(level)?.spheres(kind, &mut posed[0]);
            let title = format!("level {level}: {}", ratios(&found, 2));
            cells.push(Cell::of(title, &rest, Some(found)));
        }
        rows.push((kind.name().to_string(), cells));
    }
    let title = "Figure 4: undeformed, by level of the binary tree; numbers: mean / largest ratio";
    stage.figure(title, &rows, &arguments.folder.join("figure-4.png"))?;

    let mut rows = Vec::new();
    let level = hierarchies.level(arguments.level)?;
    for ((name, q), posed) in poses.into_iter().zip(&mut posed) {
        let mut cells = vec![Cell::of("geometry".to_string(), q, None)];
        for kind in Kind::ALL.into_iter().rev() {
            let found = level.spheres(kind, posed);
            let title = format!("{} {}", kind.short(), ratios(&found, 2));
            cells.push(Cell::of(title, q, Some(found)));
        }
        rows.push((name.to_string(), cells));
    }
    let count = hierarchies.count(arguments.level);
    let title = format!(
        "Figure 6: level {}, {count} spheres; numbers: mean / largest ratio",
        arguments.level
    );
    stage.figure(&title, &rows, &arguments.folder.join("figure-6.png"))
}

/// Mean and largest ratio of some spheres, to so many digits.
fn ratios(found: &[Found], digits: usize) -> String {
    let growths: Vec<f64> = found.iter().map(|s| s.growth).collect();
    mean_and_max(&growths).map_or("-".to_string(), |[mean, max]| {
        format!("{mean:.digits$} / {max:.digits$}")
    })
}

/// Mean and largest ratio per level, of all hierarchies.
fn ratio_table(
    hierarchies: &Hierarchies<'_>,
    name: &str,
    q: &[f32],
) -> Result<Table, Box<dyn Error>> {
    let mut posed = hierarchies.posed(q)?;
    let mut rows = Vec::new();
    for level in 0..hierarchies.depth() {
        let nodes = hierarchies.level(level)?;
        let mut row = row! {"level" => level, "spheres" => hierarchies.count(level)};
        for kind in Kind::ALL {
            row.extend(row! {kind.name() => ratios(&nodes.spheres(kind, &mut posed), 3)});
        }
        rows.push(row);
    }
    let title = format!(
        "Radius over the undeformed wrapped sphere's of the paper's tree, mean / largest: {name}, q = {q:?}"
    );
    Ok(table("", title, &rows))
}
