//! Ours: a pose, then queries, with a cache of the step's nodes where many are asked.

use bdtree_runtime::{Asset, PairContact, Workspace};

use super::{Cost, Sample, timed};
use crate::MeasureError;
use crate::ours::{Answer, Ours};

/// A step of so many balls.
pub(super) fn balls(
    asset: &Asset<'_>,
    ours: &mut Ours<'_>,
    sample: &Sample,
    amount: usize,
) -> Result<Cost, MeasureError> {
    let balls: Vec<_> = sample.balls(amount).collect();
    step(asset, || ours.balls(&sample.q, balls.iter().copied()))
}

/// A step of so many rays.
pub(super) fn rays(
    asset: &Asset<'_>,
    ours: &mut Ours<'_>,
    sample: &Sample,
    amount: usize,
) -> Result<Cost, MeasureError> {
    let rays = sample.rays(amount).map(|(from, along)| [from, along]);
    let rays: Vec<_> = rays.collect();
    step(asset, || ours.rays(&sample.q, rays.iter().copied()))
}

fn step(
    asset: &Asset<'_>,
    mut ask: impl FnMut() -> Result<Answer, MeasureError>,
) -> Result<Cost, MeasureError> {
    timed(|| {
        Ok(Cost {
            visited: ask()?.nodes.visited as f64 / asset.node_count().max(1) as f64,
            ..Cost::default()
        })
    })
}

/// Two instances, one at a place of the sample's.
pub(super) fn pair(asset: &Asset<'_>, sample: &Sample, which: usize) -> Result<Cost, MeasureError> {
    let mut memory = [(); 2].map(|()| vec![0.0; asset.pose_len()]);
    let mut workspace = Workspace::new();
    let mut found: Vec<PairContact> = Vec::new();
    timed(|| {
        found.clear();
        let [a, b] = &mut memory;
        let a = sample.pose(asset, a)?;
        let b = sample.pose_at(asset, sample.places[which], b)?;
        let mut query = a.against(&b, &mut workspace);
        query.contacts(0.0, &mut found)?;
        let visits = query.stats().nodes_visited;
        Ok(Cost {
            visited: visits as f64 / asset.node_count().max(1) as f64,
            amount: found.len() as f64,
            micros: 0.0,
        })
    })
}
