//! Modes left out of node bounds: answers stay, visits and time change.

use crate::MeasureError;
use crate::clock::Clock;
use crate::stats::median;
use bdtree_runtime::studies::pose_within;
use bdtree_runtime::{Asset, Ball, Contact, Ray, Workspace};

use super::REPETITIONS;
use super::content::ToleranceRow;
use super::sample::{HERE, Sample};

/// Over the diagonal.
const TOLERANCES: [f64; 7] = [0.0, 1e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2];

/// Questions of each kind at a sample.
const QUESTIONS: usize = 16;

/// Row by row; samples and rows take turns, so that what slows the machine down meets all of them.
pub(super) fn tolerance(
    asset: &Asset<'_>,
    samples: &[Sample],
    diagonal: f64,
) -> Result<Vec<ToleranceRow>, MeasureError> {
    let mut rows = TOLERANCES.map(|tolerance_rel| ToleranceRow {
        tolerance_rel,
        active_modes: 0.0,
        visits: 0.0,
        micros: 0.0,
    });
    let mut workspace = Workspace::new();
    let share = 1.0 / samples.len().max(1) as f64;
    for sample in samples {
        let mut times = vec![Vec::new(); rows.len()];
        for _ in 0..REPETITIONS {
            for (row, times) in rows.iter_mut().zip(&mut times) {
                let tolerance = row.tolerance_rel * diagonal;
                let (modes, visits, micros) = ask(asset, sample, tolerance, &mut workspace)?;
                if times.is_empty() {
                    row.active_modes += share * modes as f64;
                    row.visits += share * visits as f64;
                }
                times.push(micros);
            }
        }
        for (row, times) in rows.iter_mut().zip(&times) {
            row.micros += share * median(times);
        }
    }
    Ok(rows.to_vec())
}

/// Modes left, nodes visited, and the time, µs.
fn ask(
    asset: &Asset<'_>,
    sample: &Sample,
    tolerance: f64,
    workspace: &mut Workspace<'_>,
) -> Result<(usize, u64, f64), MeasureError> {
    let mut memory = vec![0.0; asset.pose_len()];
    let mut found: Vec<Contact> = Vec::new();
    let mut visits = 0;
    let clock = Clock::start();
    let pose = pose_within(asset, &sample.q, HERE, tolerance, &mut memory)?;
    let mut query = pose.query(workspace);
    for (center, radius) in sample.balls(QUESTIONS) {
        found.clear();
        query.contacts(Ball::new(center, radius), &mut found)?;
        visits += query.stats().nodes_visited;
    }
    for [origin, direction] in sample.rays(QUESTIONS) {
        query.cast_ray(&Ray::new(origin, direction))?;
        visits += query.stats().nodes_visited;
    }
    let micros = clock.seconds() * 1e6;
    Ok((pose.active_modes(), visits, micros))
}
