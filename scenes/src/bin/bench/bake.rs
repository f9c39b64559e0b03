//! Seconds per stage of a bake, and memory.

use crate::prelude::*;

pub(crate) fn run(scene: &Scene) -> Result<Vec<Table>> {
    let start = Instant::now();
    let (mesh, basis) = scene.load()?;
    let load = start.elapsed().as_secs_f64();
    let resident_mb = || machine::status_bytes("VmHWM").unwrap_or(0) as f64 / 1e6;
    let before = resident_mb();
    let start = Instant::now();
    let baked = scene.bake(&mesh, &basis, false)?;
    let all = start.elapsed().as_secs_f64();
    let report = &baked.report;
    let bake = row! {
        "mesh" => mesh.name, "vertices" => report.vertices, "triangles" => report.triangles,
        "modes" => report.modes, "file, MB" => report.bytes as f64 / 1e6,
        "resident set at most, MB" => resident_mb(), "before the bake, MB" => before,
    };
    let stages = report.stages.iter().map(|(name, s)| (name.as_str(), *s));
    let stages = [("mesh and modes, before", load), ("bake, all stages", all)]
        .into_iter()
        .chain(stages);
    let stages: Vec<Row> = stages
        .map(|(stage, seconds)| row! {"stage" => stage, "seconds" => seconds})
        .collect();
    Ok(vec![
        table("bake", "A bake", &[bake]),
        table("stages", "Its stages", &stages),
    ])
}
