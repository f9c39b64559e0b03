//! What stopping a ball query at a level costs and how far its spheres are off.

use std::collections::BTreeSet;

use crate::MeasureError;
use crate::clock::Clock;
use crate::stats::median;
use bdtree_runtime::{
    Asset, Ball, Contact, FormatError, Pose, Proxy, Query, TriangleId, Workspace,
};

use super::content::{DepthRow, WholeQuery};
use super::sample::Sample;
use super::{REPETITIONS, lanes};

/// Queries that look into everything, and level by level; the last one is where answers are exact.
pub(super) fn depth(
    asset: &Asset<'_>,
    samples: &[Sample],
    diagonal: f64,
) -> Result<(WholeQuery, Vec<DepthRow>), MeasureError> {
    let mut rows: Vec<Row> = (0..asset.depth()).map(Row::new).collect();
    let mut whole = WholeQuery::default();
    let mut memory = vec![0.0; asset.pose_len()];
    let mut workspace = Workspace::new();
    for sample in samples {
        let pose = sample.pose(asset, &mut memory)?;
        let body = Deformed::new(&pose)?;
        let truth = Answer::of(pose.query(&mut workspace), sample)?;
        whole.ball_visits += truth.visits as f64;
        whole.apart_rel += f64::from(u8::from(truth.contacts.is_empty()));
        whole.ball_micros += time(&pose, &mut workspace, sample, None)?;
        for row in &mut rows {
            row.add(&pose, &mut workspace, &body, &truth, sample, diagonal)?;
        }
    }
    let count = samples.len().max(1) as f64;
    for sum in [
        &mut whole.ball_visits,
        &mut whole.apart_rel,
        &mut whole.ball_micros,
    ] {
        *sum /= count;
    }
    let finished = rows
        .into_iter()
        .map(|row| row.finish(samples.len(), whole.ball_micros));
    Ok((whole.clone(), finished.collect()))
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
}

/// Areas of the deformed triangles, by place in leaf order (mesh units squared).
struct Deformed {
    areas: Vec<f64>,
}

impl Deformed {
    fn new(pose: &Pose<'_>) -> Result<Self, FormatError> {
        let area = |triangle: &bdtree_format::TriangleRecord| {
            let [a, b, c] = pose.deformed_triangle(TriangleId(triangle.id))?;
            let [e, f] = [b, c].map(|p| [0, 1, 2].map(|k| p[k] - a[k]));
            let cross = [
                e[1] * f[2] - e[2] * f[1],
                e[2] * f[0] - e[0] * f[2],
                e[0] * f[1] - e[1] * f[0],
            ];
            Ok(0.5 * cross.iter().map(|x| x * x).sum::<f64>().sqrt())
        };
        let areas = pose.asset().triangles().iter().map(area);
        Ok(Self {
            areas: areas.collect::<Result<_, FormatError>>()?,
        })
    }

    fn of_triangle(&self, asset: &Asset<'_>, id: TriangleId) -> f64 {
        let slot = asset.triangle_slots().get(id.0 as usize);
        slot.and_then(|slot| self.areas.get(*slot as usize))
            .copied()
            .unwrap_or(0.0)
    }
}

/// Sums over samples.
struct Row {
    level: usize,
    micros: f64,
    visits: f64,
    /// Areas: touched, missed, extra.
    areas: [f64; 3],
    penetration: f64,
    false_count: usize,
}

impl Row {
    fn new(level: usize) -> Self {
        Self {
            level,
            micros: 0.0,
            visits: 0.0,
            areas: [0.0; 3],
            penetration: 0.0,
            false_count: 0,
        }
    }

    fn add(
        &mut self,
        pose: &Pose<'_>,
        workspace: &mut Workspace<'_>,
        body: &Deformed,
        truth: &Answer,
        sample: &Sample,
        diagonal: f64,
    ) -> Result<(), MeasureError> {
        let asset = pose.asset();
        let mut proxies: Vec<Proxy> = Vec::new();
        let bounded = pose.query(workspace).max_level(self.level, &mut proxies);
        let answer = Answer::of(bounded, sample)?;
        self.micros += time(pose, workspace, sample, Some(self.level))?;
        self.visits += answer.visits as f64;

        let (center, radius) = sample.ball;
        let reached = |p: &Proxy| radius + p.radius - distance(p.center, center);
        let spheres = proxies.iter().map(reached).fold(0.0, f64::max);
        if truth.contacts.is_empty() {
            self.false_count += usize::from(!proxies.is_empty());
            return Ok(());
        }
        let error = (answer.depth().max(spheres) - truth.depth()).abs() / diagonal;
        self.penetration = self.penetration.max(error);

        let touched: BTreeSet<u32> = truth.contacts.iter().map(|c| c.triangle.0).collect();
        let said = answer.contacts.iter().map(|c| c.triangle.0);
        let mut covered: BTreeSet<u32> = said.collect();
        for slot in reported(pose, self.level, &proxies)? {
            if let Some(triangle) = asset.triangles().get(slot) {
                covered.insert(triangle.id);
            }
        }
        let area = |ids: &mut dyn Iterator<Item = &u32>| {
            ids.map(|id| body.of_triangle(asset, TriangleId(*id)))
                .sum::<f64>()
        };
        self.areas[0] += area(&mut touched.iter());
        self.areas[1] += area(&mut touched.difference(&covered));
        self.areas[2] += area(&mut covered.difference(&touched));
        Ok(())
    }

    fn finish(self, samples: usize, whole_micros: f64) -> DepthRow {
        let count = samples.max(1) as f64;
        let [touched, missed, extra] = self.areas;
        let over = |area: f64| if touched > 0.0 { area / touched } else { 0.0 };
        DepthRow {
            level: self.level,
            ball_micros: self.micros / count,
            time_rel: self.micros / count / whole_micros,
            ball_visits: self.visits / count,
            missed_area_rel: over(missed),
            extra_area_rel: over(extra),
            penetration_error_rel: self.penetration,
            false_rel: self.false_count as f64 / count,
        }
    }
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

/// The triangles (places in leaf order) below the lanes whose spheres were reported: a sphere is told by
/// where it is, to rounding, since queries say no more of it.
fn reported(pose: &Pose<'_>, level: usize, proxies: &[Proxy]) -> Result<Vec<usize>, FormatError> {
    let mut found = Vec::new();
    if proxies.is_empty() {
        return Ok(found);
    }
    let mut by_x: Vec<&Proxy> = proxies.iter().collect();
    by_x.sort_by(|a, b| a.center[0].total_cmp(&b.center[0]));
    let asset = pose.asset();
    let unit = asset.unit();
    let mut last = None;
    for (node, lane) in lanes::of_level(asset, level) {
        let spheres = match last {
            Some((of, spheres)) if of == node => spheres,
            _ => pose.node_spheres(node as u32)?,
        };
        last = Some((node, spheres));
        let radius = f64::from(spheres.radius[lane]) * unit;
        let origin = asset.origin();
        let center = [0, 1, 2].map(|k| origin[k] + f64::from(spheres.center[k][lane]) * unit);
        let near = 1e-4 * radius + 1e-9 * (center.iter().map(|c| c.abs()).sum::<f64>());
        let first = by_x.partition_point(|p| p.center[0] < center[0] - near);
        let is_it =
            |p: &&&Proxy| distance(p.center, center) <= near && (p.radius - radius).abs() <= near;
        let mut close = by_x[first..]
            .iter()
            .take_while(|p| p.center[0] <= center[0] + near);
        if close.any(|p| is_it(&p)) {
            found.extend(lanes::slots(asset, node, lane));
        }
    }
    Ok(found)
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}
