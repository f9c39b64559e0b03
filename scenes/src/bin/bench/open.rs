//! Opening a large file by mapping it: time and resident memory.

use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use bdtree_build::basis::{Basis, BasisMode};
use bdtree_build::file::write_atomically;
use bdtree_build::input::RawMesh;
use bdtree_fixtures::resident::mapped_bytes;
use bdtree_measure::{machine, stats};
use bdtree_runtime::Model;
use bdtree_scenes::contenders::assets::baked_mesh;
use clap::Args;
use serde_json::json;

#[derive(Args)]
pub(crate) struct Arguments {
    /// The file; without it target/bench-open.bdt is baked from a grid of a million triangles
    #[arg(long)]
    file: Option<PathBuf>,
    /// How often to open it
    #[arg(long, default_value_t = 200)]
    repetitions: usize,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let Some(path) = &arguments.file else {
        let path = PathBuf::from("target/bench-open.bdt");
        if !path.exists() {
            write_atomically(&path, large_file()?.asset().bytes())?;
        }
        // A fresh process, whose memory the bake has not filled.
        let mut command = std::process::Command::new(std::env::current_exe()?);
        command.arg("open").arg("--file").arg(path);
        command.args(["--repetitions", &arguments.repetitions.to_string()]);
        if arguments.json {
            command.arg("--json");
        }
        let status = command.status()?;
        return if status.success() {
            Ok(())
        } else {
            Err("opening failed".into())
        };
    };
    // A small file first: code that runs for the first time is read too, and is not what is measured.
    let small = std::env::temp_dir().join(format!("bench-open-{}.bdt", std::process::id()));
    std::fs::write(
        &small,
        include_bytes!("../../../../fixtures/golden/tetrahedron.bdt"),
    )?;
    std::hint::black_box(Model::load(&small)?.asset().node_count());
    std::fs::remove_file(&small)?;
    let mut times = Vec::with_capacity(arguments.repetitions);
    let start = Instant::now();
    let model = Model::load(path)?;
    let first = start.elapsed().as_secs_f64();
    let resident = mapped_bytes(&path.canonicalize()?).unwrap_or(0);
    let huge = machine::mapped_huge_bytes();
    let bytes = model.asset().bytes().len();
    for _ in 0..arguments.repetitions {
        let start = Instant::now();
        let again = Model::load(path)?;
        times.push(start.elapsed().as_secs_f64());
        std::hint::black_box(again.asset().node_count());
    }
    let typical = stats::median(&times);
    if arguments.json {
        let value = json!({
            "machine": machine::processor(), "file_bytes": bytes, "first_s": first,
            "median_s": typical, "resident_bytes": resident,
            "file_huge_page_bytes": huge,
        });
        println!("{value:#}");
    } else {
        println!("machine       {}", machine::processor());
        println!("file          {:.1} MB", bytes as f64 / 1e6);
        println!(
            "open          {:.1} µs the first time, {:.1} µs median",
            first * 1e6,
            typical * 1e6
        );
        println!(
            "resident      {} KiB of the file, {} KiB of them in huge pages",
            resident / 1024,
            huge / 1024
        );
    }
    Ok(())
}

/// A waving grid of 1.15 million triangles with eight modes.
fn large_file() -> Result<Model, Box<dyn Error>> {
    const SIDE: u32 = 760;
    let place = |i: u32| f64::from(i) / f64::from(SIDE - 1);
    let mut mesh = RawMesh {
        name: "grid".into(),
        ..RawMesh::default()
    };
    let mut fields: [Vec<[f64; 3]>; 8] = std::array::from_fn(|_| Vec::new());
    for i in 0..SIDE {
        for j in 0..SIDE {
            let (x, y) = (place(i), place(j));
            mesh.positions.push([x, y, 0.05 * (20.0 * x).sin()]);
            for (j, field) in fields.iter_mut().enumerate() {
                let j = j as f64;
                field.push([0.0, 0.0, 0.1 * ((2.0 + j) * x + (6.0 - j) * y).sin()]);
            }
        }
    }
    for i in 0..SIDE - 1 {
        for j in 0..SIDE - 1 {
            let at = i * SIDE + j;
            mesh.triangles.push([at, at + SIDE, at + SIDE + 1]);
            mesh.triangles.push([at, at + SIDE + 1, at + 1]);
        }
    }
    let basis = Basis {
        vertex_count: mesh.positions.len(),
        fields: fields.concat(),
        modes: vec![BasisMode::default(); 8],
        animation: None,
    };
    baked_mesh(&mesh, &basis)
}
