//! What stopping a ball query at a level costs and how far its spheres are off.

use std::collections::BTreeSet;

use crate::MeasureError;
use crate::clock::Clock;
use crate::stats::median;
use crate::vector::{cross, distance, length, minus};
use bdtree_build::progress::Progress;
use bdtree_runtime::{
    Asset, Ball, Contact, FormatError, Pose, Proxy, Query, TriangleId, Workspace,
};

use super::content::{DepthRow, WholeQuery};
use super::{REPETITIONS, lanes};
use crate::sample::{HERE, Sample};

/// Queries without a level limit, and level by level; the last one is where answers are exact.
pub(super) fn depth(
    asset: &Asset<'_>,
    samples: &[Sample],
    diagonal: f64,
    progress: &dyn Progress,
) -> Result<(WholeQuery, Vec<DepthRow>), MeasureError> {
    let mut rows: Vec<DepthRow> = (0..asset.depth())
        .map(|level| DepthRow {
            level,
            ..DepthRow::default()
        })
        .collect();
    let mut whole = WholeQuery::default();
    // Area that is touched, of all samples.
    let mut touched = 0.0;
    let mut memory = vec![0.0; asset.pose_len()];
    let mut workspace = Workspace::new();
    progress.stage("measuring levels", Some(samples.len() as u64));
    for sample in samples {
        let pose = sample.pose(asset, HERE, &mut memory)?;
        let areas = areas(&pose)?;
        let truth = Answer::of(pose.query(&mut workspace), sample)?;
        whole.ball_visits += truth.visits as f64;
        whole.apart_rel += f64::from(u8::from(truth.contacts.is_empty()));
        whole.ball_micros += time(&pose, &mut workspace, sample, None)?;
        touched += area(&areas, &mut truth.triangles().iter());
        for row in &mut rows {
            add(row, &pose, &mut workspace, &areas, &truth, sample, diagonal)?;
        }
        progress.advance(1);
    }
    // Sums so far.
    let count = samples.len().max(1) as f64;
    for sum in [
        &mut whole.ball_visits,
        &mut whole.apart_rel,
        &mut whole.ball_micros,
    ] {
        *sum /= count;
    }
    for row in &mut rows {
        for sum in [
            &mut row.ball_micros,
            &mut row.ball_visits,
            &mut row.false_rel,
        ] {
            *sum /= count;
        }
        row.time_rel = row.ball_micros / whole.ball_micros;
        // Without anything touched nothing is missed or extra.
        for area in [&mut row.missed_area_rel, &mut row.extra_area_rel] {
            *area = if touched > 0.0 { *area / touched } else { 0.0 };
        }
    }
    Ok((whole, rows))
}

/// What a query says.
struct Answer {
    contacts: Vec<Contact>,
    visits: u64,
}

impl Answer {
    fn of(mut query: Query<'_, '_>, sample: &Sample) -> Result<Self, MeasureError> {
        let mut contacts: Vec<Contact> = Vec::new();
        let (center, radius) = sample.ball;
        query.contacts(Ball::new(center, radius), &mut contacts)?;
        Ok(Self {
            contacts,
            visits: query.stats().nodes_visited,
        })
    }

    /// How deep the ball reaches in.
    fn depth(&self) -> f64 {
        self.contacts
            .iter()
            .map(|c| -c.distance)
            .fold(0.0, f64::max)
    }

    fn triangles(&self) -> BTreeSet<u32> {
        self.contacts.iter().map(|c| c.triangle.0).collect()
    }
}

/// Areas of the deformed triangles, by id (mesh units squared).
fn areas(pose: &Pose<'_>) -> Result<Vec<f64>, FormatError> {
    let area = |id| {
        let [a, b, c] = pose.deformed_triangle(TriangleId(id))?;
        Ok(0.5 * length(cross(minus(b, a), minus(c, a))))
    };
    (0..pose.asset().triangle_count() as u32)
        .map(area)
        .collect()
}

/// Of some triangles.
fn area(areas: &[f64], ids: &mut dyn Iterator<Item = &u32>) -> f64 {
    ids.filter_map(|id| areas.get(*id as usize)).sum()
}

/// Adds a sample to the sums of a level; areas are not yet over what is touched.
fn add(
    row: &mut DepthRow,
    pose: &Pose<'_>,
    workspace: &mut Workspace<'_>,
    areas: &[f64],
    truth: &Answer,
    sample: &Sample,
    diagonal: f64,
) -> Result<(), MeasureError> {
    let asset = pose.asset();
    let mut proxies: Vec<Proxy> = Vec::new();
    let bounded = pose.query(workspace).max_level(row.level, &mut proxies);
    let answer = Answer::of(bounded, sample)?;
    row.ball_micros += time(pose, workspace, sample, Some(row.level))?;
    row.ball_visits += answer.visits as f64;

    let (center, radius) = sample.ball;
    let reached = |p: &Proxy| radius + p.radius - distance(p.center, center);
    let spheres = proxies.iter().map(reached).fold(0.0, f64::max);
    if truth.contacts.is_empty() {
        row.false_rel += f64::from(u8::from(!proxies.is_empty()));
        return Ok(());
    }
    let error = (answer.depth().max(spheres) - truth.depth()).abs() / diagonal;
    row.penetration_error_rel = row.penetration_error_rel.max(error);

    let (touched, mut covered) = (truth.triangles(), answer.triangles());
    for Proxy { lane, .. } in &proxies {
        for slot in lanes::slots(asset, lane.node as usize, usize::from(lane.lane)) {
            covered.extend(asset.triangles().get(slot).map(|triangle| triangle.id));
        }
    }
    row.missed_area_rel += area(areas, &mut touched.difference(&covered));
    row.extra_area_rel += area(areas, &mut covered.difference(&touched));
    Ok(())
}

/// Median of a query that stops at `level`, if there is one, µs.
fn time(
    pose: &Pose<'_>,
    workspace: &mut Workspace<'_>,
    sample: &Sample,
    level: Option<usize>,
) -> Result<f64, MeasureError> {
    let (mut contacts, mut proxies): (Vec<Contact>, Vec<Proxy>) = Default::default();
    let (center, radius) = sample.ball;
    let mut times = Vec::new();
    for _ in 0..REPETITIONS {
        contacts.clear();
        proxies.clear();
        let clock = Clock::start();
        let mut query = pose.query(workspace);
        if let Some(level) = level {
            query = query.max_level(level, &mut proxies);
        }
        query.contacts(Ball::new(center, radius), &mut contacts)?;
        times.push(clock.seconds() * 1e6);
    }
    Ok(median(&times))
}
