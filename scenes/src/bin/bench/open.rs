//! Opening a large file by mapping it: time and resident memory.

use std::path::PathBuf;
use std::process::Command;

use bdtree_build::input::RawMesh;
use bdtree_fixtures::bake::smooth_basis;
use bdtree_fixtures::models::mesh::Mesh;
use bdtree_fixtures::resident::mapped_bytes;
use bdtree_measure::stats;
use bdtree_output::write_whole;
use bdtree_scenes::contenders::assets::baked_mesh;

use crate::prelude::*;

#[derive(Args)]
pub(crate) struct Arguments {
    /// The file; without it target/bench-open.bdt is baked from a grid of a million triangles
    #[arg(long)]
    file: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments, rounds: usize) -> Result<Vec<Table>> {
    let Some(path) = &arguments.file else {
        let path = PathBuf::from("target/bench-open.bdt");
        if !path.exists() {
            let file = large_file()?;
            write_whole(&path, |w| w.write_all(file.asset().bytes()))?;
        }
        // A fresh process, whose memory the bake has not filled, with the same options.
        let mut command = Command::new(std::env::current_exe()?);
        command.args(std::env::args_os().skip(1)).arg("--file");
        let status = command.arg(path).status()?;
        std::process::exit(status.code().unwrap_or(1));
    };
    // A small file first: code that runs for the first time is read too, and is not what is measured.
    let small = std::env::temp_dir().join(format!("bench-open-{}.bdt", std::process::id()));
    std::fs::write(
        &small,
        include_bytes!("../../../../fixtures/golden/tetrahedron.bdt"),
    )?;
    std::hint::black_box(Model::load(&small)?.asset().node_count());
    std::fs::remove_file(&small)?;
    let start = Instant::now();
    let model = Model::load(path)?;
    let first = start.elapsed().as_secs_f64();
    let resident = mapped_bytes(&path.canonicalize()?).unwrap_or(0);
    let huge = machine::mapped_huge_bytes();
    let mut times = Vec::with_capacity(rounds);
    for _ in 0..rounds {
        let start = Instant::now();
        let again = Model::load(path)?;
        times.push(start.elapsed().as_secs_f64());
        std::hint::black_box(again.asset().node_count());
    }
    let open = row! {
        "file, bytes" => model.asset().bytes().len(),
        "first time, µs" => first * 1e6, "median, µs" => stats::median(&times) * 1e6,
        "resident of the file, bytes" => resident, "in huge pages, bytes" => huge,
    };
    Ok(vec![table("open", "Opening a file", &[open])])
}

/// A waving grid of 1.15 million triangles with eight modes.
fn large_file() -> Result<Model> {
    const SIDE: usize = 759;
    let mut grid = Mesh::default();
    let at = |i: usize, j: usize| {
        let [x, y] = [i, j].map(|c| c as f64 / SIDE as f64);
        [x, y, 0.05 * (20.0 * x).sin()]
    };
    grid.grid(SIDE, SIDE, at, |_, _| true);
    let mesh = RawMesh {
        positions: grid.positions,
        triangles: grid.triangles,
        ..RawMesh::default()
    };
    baked_mesh(&mesh, &smooth_basis(&mesh, 8, 2004))
}
