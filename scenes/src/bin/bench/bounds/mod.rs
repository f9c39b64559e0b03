//! Which bounds a node wants: visits and tests of each bound in the same scenes.

mod contact;
mod cost;
mod loops;
mod radii;
mod single;
mod table;
mod trees;

use std::error::Error;

use bdtree_baselines::machine;
use bdtree_scenes::bounds::bound::Bound;
use clap::Args;
use serde_json::json;

use cost::{TestCosts, update_ns, vertex_ns};
use table::Table;

#[derive(Args)]
pub(crate) struct Arguments {
    /// Poses per scene
    #[arg(long, default_value_t = 8)]
    poses: usize,
    /// Cuts of the bumpy sphere's eight faces: 8 times their square are its triangles
    #[arg(long, default_value_t = 66)]
    cuts: i32,
    /// Seed of modes, poses and places
    #[arg(long, default_value_t = 2004)]
    seed: u64,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Largest displacements over the diagonal; `None`: amplitudes 0.8/√(1 + j) as in W2.
const DISPLACEMENTS: [Option<f64>; 5] = [Some(0.0), Some(0.05), Some(0.1), Some(0.2), None];

fn displacement_name(displacement: Option<f64>) -> String {
    match displacement {
        Some(share) => format!("displacement {} %", 100.0 * share),
        None => "amplitudes 0.8/√(1 + j)".to_string(),
    }
}

/// Nanoseconds that all scenes weigh with.
struct Costs {
    tests: TestCosts,
    /// One row of eight numbers per mode, with 10 modes.
    row: f64,
    /// A vertex with 10 modes.
    vertex: f64,
}

impl Costs {
    /// Nanoseconds of a node's update with `modes` modes.
    fn update(&self, bound: Bound, modes: usize) -> f64 {
        let rows = bound.rows_per_mode() * modes as f64 + bound.operations() as f64;
        self.row * rows / 10.0
    }
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let costs = Costs {
        tests: TestCosts::measure(),
        row: update_ns::<5>(10) / 5.0,
        vertex: vertex_ns(10),
    };
    let mut tables = vec![cost_table(&costs)];
    let bodies = contact::Bodies::new(arguments);
    for displacement in DISPLACEMENTS {
        let frames = bodies.frames(displacement, arguments);
        let title = displacement_name(displacement);
        tables.push(bodies.table(&format!("two bodies, {title}"), &frames, &costs));
        tables.push(radii::table(&bodies, &title, &frames));
        if displacement.is_none_or(|share| share == 0.2) {
            tables.push(trees::table(&bodies, &title, &frames, arguments, &costs));
        }
    }
    for displacement in DISPLACEMENTS {
        tables.push(single::balls(displacement, arguments, &costs));
        tables.push(single::rays(&bodies, displacement, arguments, &costs));
    }
    if arguments.json {
        let tables: Vec<_> = tables.iter().map(Table::to_json).collect();
        let value = json!({
            "machine": machine::processor(), "poses": arguments.poses, "seed": arguments.seed,
            "tables": tables,
        });
        println!("{value:#}");
        return Ok(());
    }
    println!("machine {}", machine::processor());
    for table in &tables {
        println!("\n{table}");
    }
    Ok(())
}

fn cost_table(costs: &Costs) -> Table {
    let mut table = Table::new("costs", &["ns"]);
    let tests = &costs.tests;
    for (name, ns) in [
        ("row of eight per mode, 10 modes", costs.row),
        ("vertex, 10 modes", costs.vertex),
        ("1 × 8 balls", tests.ball),
        ("1 × 8 balls, slabs against balls", tests.slab_and_ball),
        ("1 × 8 balls, slabs against slabs", tests.slab_and_slab),
        ("1 × 8 boxes, one frame", tests.three),
        ("1 × 8 boxes, two frames", tests.six),
        ("1 × 8 7-dops, two frames", tests.fourteen),
        ("1 × 8 13-dops, two frames", tests.twenty_six),
        ("1 × 8 oriented boxes, 6 axes", tests.faces),
        ("1 × 8 oriented boxes, 15 axes", tests.full),
    ] {
        table.push(name, vec![ns]);
    }
    table
}
