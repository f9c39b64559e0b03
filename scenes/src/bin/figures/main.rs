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
    let shares = arguments
        .q_of_range
        .iter()
        .copied()
        .chain(std::iter::repeat(0.0));
    let bent: Vec<f32> = asset
        .modes()
        .iter()
        .zip(shares)
        .map(|(mode, share)| share * mode.q_range.get())
        .collect();
    let hierarchies = Hierarchies::new(asset);
    print_table(&hierarchies, [("at rest", &rest), ("deformed", &bent)])?;

    let view = [0, 1].map(|k| arguments.view.get(k).copied().unwrap_or(0.0));
    let mut stage = Stage::new(asset, &[&rest, &bent], view, arguments.cell)?;
    let mut posed = [hierarchies.posed(&rest)?, hierarchies.posed(&bent)?];
    let mut rows = Vec::new();
    for kind in Kind::ALL {
        let mut cells = Vec::new();
        for level in LEVELS {
            let found = hierarchies.level(level)?.spheres(kind, &mut posed[0]);
            let title = format!("level {level}: {}", ratios(&found));
            cells.push(Cell {
                title,
                q: &rest,
                spheres: Some(found),
            });
        }
        rows.push((kind.name().to_string(), cells));
    }
    let title = "Figure 4: undeformed, by level of the binary tree; numbers: mean / largest ratio";
    stage.figure(title, &rows, &arguments.folder.join("figure-4.png"))?;

    let mut rows = Vec::new();
    let level = hierarchies.level(arguments.level)?;
    for ((name, q), posed) in [("at rest", &rest), ("deformed", &bent)]
        .into_iter()
        .zip(&mut posed)
    {
        let mut cells = vec![Cell {
            title: "geometry".to_string(),
            q,
            spheres: None,
        }];
        for kind in Kind::ALL.into_iter().rev() {
            let found = level.spheres(kind, posed);
            cells.push(Cell {
                title: format!("{} {}", kind.short(), ratios(&found)),
                q,
                spheres: Some(found),
            });
        }
        rows.push((name.to_string(), cells));
    }
    let count = hierarchies.count(arguments.level);
    let title = format!(
        "Figure 6: level {}, {count} spheres; numbers: mean / largest ratio",
        arguments.level
    );
    stage.figure(&title, &rows, &arguments.folder.join("figure-6.png"))?;
    Ok(())
}

/// Mean and largest ratio of some spheres.
fn ratios(found: &[Found]) -> String {
    let growths: Vec<f64> = found.iter().map(|s| s.growth).collect();
    match mean_and_max(&growths) {
        Some([mean, max]) => format!("{mean:.2} / {max:.2}"),
        None => "-".to_string(),
    }
}

/// Mean and largest ratio per level, of all hierarchies.
fn print_table(
    hierarchies: &Hierarchies<'_>,
    poses: [(&str, &Vec<f32>); 2],
) -> Result<(), Box<dyn Error>> {
    println!("radius over the undeformed wrapped sphere's of the paper's tree: mean / largest");
    for (name, q) in poses {
        println!("\n{name}, q = {q:?}\n");
        println!("| level | spheres | layered | BD-Tree (paper) | ours |");
        println!("|---|---|---|---|---|");
        let mut posed = hierarchies.posed(q)?;
        for level in 0..hierarchies.depth() {
            let nodes = hierarchies.level(level)?;
            let mut cells = Vec::new();
            for kind in Kind::ALL {
                let found = nodes.spheres(kind, &mut posed);
                let growths: Vec<f64> = found.iter().map(|s| s.growth).collect();
                cells.push(match mean_and_max(&growths) {
                    Some([mean, max]) => format!("{mean:.3} / {max:.3}"),
                    None => "-".to_string(),
                });
            }
            println!(
                "| {level} | {} | {} |",
                hierarchies.count(level),
                cells.join(" | ")
            );
        }
    }
    Ok(())
}
