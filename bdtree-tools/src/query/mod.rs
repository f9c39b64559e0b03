//! `bdtree query`: a scene's questions answered, one JSON line each.

mod lines;

pub use lines::{Answer, ContactLine, Line};

use std::io::Write;

use bdtree_runtime::{Asset, PairStackEntry, Pose, QueryError, StackEntry, query};

use crate::DONE;
pub use crate::cli::QueryArguments as Arguments;
use crate::error::ToolError;
use crate::scene::{Query, Scene};

/// Answers the queries of a scene in order; the whole scene is checked before the first line.
///
/// # Errors
/// Every problem of the scene, a corrupt asset, an output stream that fails.
pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<u8, ToolError> {
    let scene = Scene::load(&arguments.scene, !arguments.no_verify)?;
    let mut memory: Vec<Vec<f32>> = scene
        .instances
        .iter()
        .map(|instance| vec![0.0; 2 * instance.q.len()])
        .collect();
    let mut placed = Vec::with_capacity(scene.instances.len());
    for (i, memory) in memory.iter_mut().enumerate() {
        let asset = scene.files[scene.instances[i].asset].asset()?;
        placed.push((asset, scene.pose(i, memory)?));
    }
    let mut solver = Solver {
        placed: &placed,
        stack: Vec::new(),
        pair_stack: Vec::new(),
    };
    for (i, query) in scene.queries.iter().enumerate() {
        let place = || format!("{}: queries[{i}]", scene.source);
        let (kind, answer, nodes_visited) = solver
            .solve(query)
            .map_err(|error| ToolError::input(place(), told(&scene, query, error)))?;
        if !answer.is_finite() {
            let message = "the answer is not finite: corrupt asset, run bdtree verify";
            return Err(ToolError::input(place(), message));
        }
        let line = Line {
            query: i,
            kind,
            answer,
            nodes_visited: arguments.stats.then_some(nodes_visited),
        };
        serde_json::to_writer(&mut *out, &line).map_err(|e| ToolError::Stdout(e.into()))?;
        writeln!(out).map_err(ToolError::Stdout)?;
    }
    Ok(DONE)
}

/// A query's error with the files that it may be about.
fn told(scene: &Scene, query: &Query, error: QueryError) -> String {
    let QueryError::Corrupt(_) = error else {
        return error.to_string();
    };
    let path = |instance: usize| {
        let file = &scene.files[scene.instances[instance].asset];
        file.path().display().to_string()
    };
    let files = match query {
        Query::Pair { a, b, .. } => {
            let (a, b) = (path(*a), path(*b));
            if a == b { a } else { format!("{a} or {b}") }
        }
        Query::Ball { instance, .. }
        | Query::Closest { instance, .. }
        | Query::Ray { instance, .. }
        | Query::Plane { instance, .. } => path(*instance),
    };
    format!("{files}: {error}")
}

/// The instances and the memory that traversals share.
struct Solver<'s> {
    placed: &'s [(Asset<'s>, Pose<'s>)],
    stack: Vec<StackEntry>,
    pair_stack: Vec<PairStackEntry>,
}

impl Solver<'_> {
    /// Kind, answer and nodes visited.
    fn solve(&mut self, query: &Query) -> Result<(&'static str, Answer, u64), QueryError> {
        match *query {
            Query::Ball {
                instance,
                center,
                radius,
            } => {
                let (asset, pose) = &self.placed[instance];
                let stack = stack_for(asset, &mut self.stack);
                let mut contacts = Vec::new();
                let outcome = query::ball(asset, pose, center, radius, stack, &mut contacts)?;
                Ok(("ball", Answer::contacts(contacts), outcome.nodes_visited))
            }
            Query::Plane {
                instance,
                normal,
                offset,
            } => {
                let (asset, pose) = &self.placed[instance];
                let stack = stack_for(asset, &mut self.stack);
                let mut contacts = Vec::new();
                let outcome = query::plane(asset, pose, normal, offset, stack, &mut contacts)?;
                Ok(("plane", Answer::contacts(contacts), outcome.nodes_visited))
            }
            Query::Closest {
                instance,
                point,
                max_distance,
            } => {
                let (asset, pose) = &self.placed[instance];
                let stack = stack_for(asset, &mut self.stack);
                let nearest = query::closest(asset, pose, point, max_distance, stack)?;
                Ok(("closest", nearest.hit.into(), nearest.nodes_visited))
            }
            Query::Ray {
                instance,
                origin,
                direction,
                max_distance,
            } => {
                let (asset, pose) = &self.placed[instance];
                let stack = stack_for(asset, &mut self.stack);
                let nearest = query::ray(asset, pose, origin, direction, max_distance, stack)?;
                Ok(("ray", nearest.hit.into(), nearest.nodes_visited))
            }
            Query::Pair { a, b, tolerance } => {
                let ((asset_a, pose_a), (asset_b, pose_b)) = (&self.placed[a], &self.placed[b]);
                let needed = asset_a.pair_stack_len(asset_b);
                if self.pair_stack.len() < needed {
                    self.pair_stack.resize(needed, PairStackEntry::default());
                }
                let mut pairs = Vec::new();
                let outcome = query::pair(
                    (asset_a, pose_a),
                    (asset_b, pose_b),
                    tolerance,
                    &mut self.pair_stack,
                    &mut pairs,
                )?;
                Ok(("pair", Answer::pairs(&pairs), outcome.nodes_visited))
            }
        }
    }
}

/// Enough of a stack for an asset.
fn stack_for<'s>(asset: &Asset<'_>, stack: &'s mut Vec<StackEntry>) -> &'s mut [StackEntry] {
    if stack.len() < asset.stack_len() {
        stack.resize(asset.stack_len(), StackEntry::default());
    }
    stack
}
