//! Deformable chairs beside rigid ones, and beside rigid ones whose trees are updated as if they deformed (P45, P46).
//!
//! As in the paper, deformable and rigid chairs are two simulations that begin alike. Parts of both are repeated from their
//! checkpoints, one after the other: whatever else the machine does, it does to both.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use super::Ratios;
use crate::chairs::{Chairs, Kind};
use crate::falling::Scene;

pub(crate) const VARIANTS: [&str; 3] = ["deformable", "rigid", "redundant"];

/// Steps before those that are measured, repetition, then seconds and events per step of each variant.
const COLUMNS: [&str; 8] = [
    "step",
    "repeat",
    "deformable_s",
    "deformable_events",
    "rigid_s",
    "rigid_events",
    "redundant_s",
    "redundant_events",
];

pub(super) fn measure(of: &Ratios) -> Result<(), Box<dyn Error>> {
    let begin = &of.begin;
    bdtree_output::check_writable(&of.file)?;
    let model = begin.model()?;
    let mut table = begin.table("logs ratios", &COLUMNS);
    table.say("steps of a window", of.steps);
    table.say("steps before it that do not count", of.before);
    if of.deformable.len() != of.rigid.len() {
        let counts = [&of.deformable, &of.rigid].map(|all| all.len());
        let why = format!(
            "--deformable has {} checkpoints, --rigid {}",
            counts[0], counts[1]
        );
        return Err(format!("{why}: name one of each").into());
    }
    for repeat in 1..=begin.repeat {
        for (deformable, rigid) in of.deformable.iter().zip(&of.rigid) {
            let mut row = Vec::new();
            for (variant, name) in VARIANTS.into_iter().enumerate() {
                let (path, kind): (&Path, Kind) = match variant {
                    0 => (deformable, Kind::Deformable),
                    1 => (rigid, Kind::Rigid),
                    _ => (rigid, Kind::Redundant),
                };
                let mut scene = Chairs::of_checkpoint(path, kind, &model, begin.threads)?;
                let failed = |error| format!("{}, {name}: {error}", path.display());
                steps(&mut scene, of.before).map_err(failed)?;
                let first = scene.world().steps() as f64;
                match row.first() {
                    None => row.extend([first, f64::from(repeat)]),
                    Some(expected) if *expected == first => {}
                    Some(_) => {
                        let [a, b] = [deformable, rigid].map(|path| path.display());
                        return Err(format!("{a} and {b} are not after as many steps").into());
                    }
                }
                let [seconds, events] = steps(&mut scene, of.steps).map_err(failed)?;
                let [seconds, events] = [seconds, events].map(|sum| sum / f64::from(of.steps));
                row.extend([seconds, events]);
                let ms = 1e3 * seconds;
                eprintln!("from step {first}, {name}: {ms:.1} ms and {events:.0} events a step");
            }
            table.rows.push(row);
            // Hours of measurements are not lost with a break.
            table.write(&of.file)?;
        }
    }
    Ok(())
}

/// Seconds and events of so many steps.
fn steps(scene: &mut Chairs, count: u32) -> Result<[f64; 2], Box<dyn Error>> {
    let (mut seconds, mut events) = (0.0, 0);
    for _ in 0..count {
        scene.add_due()?;
        let start = Instant::now();
        let report = scene.world_mut().step();
        seconds += start.elapsed().as_secs_f64();
        events += report?.events;
    }
    Ok([seconds, events as f64])
}
