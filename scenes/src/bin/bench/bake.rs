//! Seconds per stage of a bake, and memory.

use std::error::Error;
use std::time::Instant;

use bdtree_measure::machine;
use clap::Args;
use serde_json::json;

use crate::scene::Scene;

#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    scene: Scene,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let start = Instant::now();
    let (mesh, basis) = arguments.scene.load()?;
    let load = start.elapsed().as_secs_f64();
    let before = machine::status_bytes("VmHWM").unwrap_or(0);
    let start = Instant::now();
    let baked = arguments.scene.bake(&mesh, &basis)?;
    let total = start.elapsed().as_secs_f64();
    let peak = machine::status_bytes("VmHWM").unwrap_or(0);
    let report = &baked.report;
    if arguments.json {
        let value = json!({
            "machine": machine::processor(), "mesh": mesh.name, "report": report,
            "load_s": load, "bake_s": total, "peak_bytes": peak, "peak_before_bytes": before,
        });
        println!("{value:#}");
        return Ok(());
    }
    println!("machine       {}", machine::processor());
    println!(
        "mesh          {}: {} vertices, {} triangles, {} modes",
        mesh.name, report.vertices, report.triangles, report.modes
    );
    println!("mesh, modes   {load:.3} s, read and computed");
    for (stage, seconds) in &report.stages {
        println!("{stage:<13} {seconds:.3} s");
    }
    println!("bake          {total:.3} s, all stages");
    let mb = |bytes: u64| bytes as f64 / 1e6;
    println!(
        "resident set  {:.0} MB at most, {:.0} MB before the bake; file {:.1} MB",
        mb(peak),
        mb(before),
        mb(report.bytes as u64)
    );
    Ok(())
}
