//! `bdtree query`: a scene's questions answered, one JSON line each.

mod budgeted;
mod contacts;
mod lines;
mod rays;

pub use budgeted::Certificate;
pub use contacts::{PointLine, RegionLine};
pub use lines::{Answer, ContactLine, Line, NearestLine, ProxyLine};

use std::io::Write;

use bdtree_runtime::{
    Asset, CachedPose, LeafSlot, NodeSlot, PairStackEntry, Pose, Posed, Proxy, QueryError,
    SearchEntry, StackEntry, StepCache, query,
};

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
    let mut memory = PoseMemory::of(&scene)?;
    let poses = memory.poses(&scene)?;
    // One query after the other: nothing is kept between them.
    let mut caches: Vec<_> = poses.iter().map(|_| StepCache::new([], [])).collect();
    let placed = poses.iter().zip(&mut caches);
    let mut placed: Vec<_> = placed
        .map(
            |((asset, pose), cache): (_, &mut StepCache<[NodeSlot; 0], [LeafSlot; 0]>)| {
                (*asset, cache.start(pose))
            },
        )
        .collect();
    solve_all(&scene, &mut placed, false, |mut line, nodes_visited| {
        line.nodes_visited = arguments.stats.then_some(nodes_visited);
        serde_json::to_writer(&mut *out, &line).map_err(|e| ToolError::Stdout(e.into()))?;
        writeln!(out).map_err(ToolError::Stdout)
    })?;
    Ok(DONE)
}

/// Memory for the poses of a scene's instances.
pub(crate) struct PoseMemory(Vec<Vec<f32>>);

impl PoseMemory {
    /// Enough for a scene.
    pub(crate) fn of(scene: &Scene) -> Result<Self, ToolError> {
        let memory = scene.instances.iter().map(|instance| {
            let asset = scene.files[instance.asset].asset()?;
            Ok(vec![0.0_f32; asset.pose_len()])
        });
        memory.collect::<Result<_, ToolError>>().map(Self)
    }

    /// The instances' assets and poses, in the order of the scene.
    pub(crate) fn poses<'s>(
        &'s mut self,
        scene: &'s Scene,
    ) -> Result<Vec<(Asset<'s>, Pose<'s>)>, ToolError> {
        let poses = self.0.iter_mut().enumerate().map(|(i, memory)| {
            let asset = scene.files[scene.instances[i].asset].asset()?;
            Ok((asset, scene.pose(i, memory)?))
        });
        poses.collect()
    }
}

/// Answers the queries of a scene in order: `take` gets each line and the number of nodes visited.
/// What `placed`, the instances, have room for is kept between queries if `keep`.
///
/// # Errors
/// A corrupt asset; those of `take`.
pub(crate) fn solve_all<'a>(
    scene: &Scene,
    placed: &mut [(Asset<'a>, CachedPose<'a>)],
    keep: bool,
    mut take: impl FnMut(Line, u64) -> Result<(), ToolError>,
) -> Result<(), ToolError> {
    let mut solver = Solver {
        placed,
        keep,
        max_depth: scene.options.max_depth,
        proxies: Default::default(),
        stack: Vec::new(),
        pair_stack: Vec::new(),
        distance_stack: Vec::new(),
    };
    for (i, query) in scene.queries.iter().enumerate() {
        let place = || format!("{}: queries[{i}]", scene.source);
        let corrupt = |error| ToolError::input(place(), told(scene, query, error));
        let within = match scene.options.max_visits {
            Some(n) => solver.solve_within(query, n).map_err(corrupt)?,
            None => None,
        };
        let (kind, answer, nodes_visited, certificate) = match within {
            Some((kind, answer, visits, certificate)) => (kind, answer, visits, Some(certificate)),
            None => {
                let (kind, answer, visits) = solver.solve(query).map_err(corrupt)?;
                (kind, answer, visits, None)
            }
        };
        let proxies = scene.options.max_depth.map(|_| solver.take_proxies());
        let is_finite = proxies.iter().flatten().all(ProxyLine::is_finite);
        if !answer.is_finite() || !is_finite {
            let message = "the answer is not finite: corrupt asset, run bdtree verify";
            return Err(ToolError::input(place(), message));
        }
        let line = Line {
            query: i,
            kind,
            answer,
            proxies,
            certificate,
            nodes_visited: None,
        };
        take(line, nodes_visited)?;
    }
    Ok(())
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
        Query::Pair { a, b, .. } | Query::Distance { a, b, .. } => {
            let (a, b) = (path(*a), path(*b));
            if a == b { a } else { format!("{a} or {b}") }
        }
        Query::Ball { instance, .. }
        | Query::Closest { instance, .. }
        | Query::Ray { instance, .. }
        | Query::Rays { instance, .. }
        | Query::Plane { instance, .. }
        | Query::Frustum { instance, .. }
        | Query::Capsule { instance, .. }
        | Query::Box { instance, .. } => path(*instance),
    };
    format!("{files}: {error}")
}

/// The instances and the memory that traversals share.
struct Solver<'s, 'a> {
    placed: &'s mut [(Asset<'a>, CachedPose<'a>)],
    /// What queries compute is kept with the instances.
    keep: bool,
    max_depth: Option<usize>,
    /// Of the query's instance, or of both, where the k-th of one belongs to the k-th of the other.
    proxies: [Vec<Proxy>; 2],
    stack: Vec<StackEntry>,
    pair_stack: Vec<PairStackEntry>,
    distance_stack: Vec<SearchEntry>,
}

/// A pose that is not looked into below the scene's depth.
fn posed<'p>(
    pose: impl Into<Posed<'p>>,
    max_depth: Option<usize>,
    proxies: &'p mut Vec<Proxy>,
) -> Posed<'p> {
    match max_depth {
        Some(level) => pose.into().bounded(level, proxies),
        None => pose.into(),
    }
}

impl Solver<'_, '_> {
    /// What the last query left in place of what lies deeper: of a pair, a's and b's in turn.
    fn take_proxies(&mut self) -> Vec<ProxyLine> {
        let [a, b] = &mut self.proxies;
        let mut lines = Vec::with_capacity(a.len() + b.len());
        for (i, proxy) in a.iter().enumerate() {
            lines.push(proxy.into());
            lines.extend(b.get(i).map(ProxyLine::from));
        }
        a.clear();
        b.clear();
        lines
    }

    /// Kind, answer and nodes visited.
    fn solve(&mut self, query: &Query) -> Result<(&'static str, Answer, u64), QueryError> {
        let [proxies, proxies_b] = &mut self.proxies;
        match *query {
            Query::Ball {
                instance,
                center,
                radius,
            } => {
                let (asset, pose) = &mut self.placed[instance];
                let stack = stack_for(asset, &mut self.stack);
                let mut contacts = Vec::new();
                let outcome = query::ball(
                    asset,
                    posed(pose, self.max_depth, proxies),
                    center,
                    radius,
                    stack,
                    &mut contacts,
                )?;
                Ok(("ball", Answer::contacts(contacts), outcome.nodes_visited))
            }
            Query::Plane {
                instance,
                normal,
                offset,
            } => {
                let (asset, pose) = &mut self.placed[instance];
                let stack = stack_for(asset, &mut self.stack);
                let mut contacts = Vec::new();
                let outcome = query::plane(
                    asset,
                    posed(pose, self.max_depth, proxies),
                    normal,
                    offset,
                    stack,
                    &mut contacts,
                )?;
                Ok(("plane", Answer::contacts(contacts), outcome.nodes_visited))
            }
            Query::Closest {
                instance,
                point,
                max_distance,
            } => {
                let (asset, pose) = &mut self.placed[instance];
                let stack = stack_for(asset, &mut self.stack);
                let nearest = query::closest(
                    asset,
                    posed(pose, self.max_depth, proxies),
                    point,
                    max_distance,
                    stack,
                )?;
                let answer = Answer::Nearest(nearest.hit.into());
                Ok(("closest", answer, nearest.nodes_visited))
            }
            Query::Ray {
                instance,
                origin,
                direction,
                max_distance,
            } => {
                let (asset, pose) = &mut self.placed[instance];
                let stack = stack_for(asset, &mut self.stack);
                let nearest = query::ray(
                    asset,
                    posed(pose, self.max_depth, proxies),
                    origin,
                    direction,
                    max_distance,
                    stack,
                )?;
                let answer = Answer::Nearest(nearest.hit.into());
                Ok(("ray", answer, nearest.nodes_visited))
            }
            Query::Rays {
                instance,
                mode,
                ref rays,
            } => {
                let (asset, pose) = &mut self.placed[instance];
                let stack = stack_for(asset, &mut self.stack);
                let mut cache = rays::cache(asset);
                let mut own = cache.start(pose.pose());
                let pose: Posed<'_> = match self.keep {
                    true => pose.into(),
                    false => (&mut own).into(),
                };
                let posed = posed(pose, self.max_depth, proxies);
                let (answer, nodes_visited) = rays::solve(asset, posed, mode, rays, stack)?;
                Ok(("rays", answer, nodes_visited))
            }
            Query::Frustum {
                instance,
                ref frustum,
            } => {
                let (asset, pose) = &mut self.placed[instance];
                let stack = stack_for(asset, &mut self.stack);
                let outcome = query::frustum(asset, pose, frustum, stack)?;
                Ok(("frustum", outcome.state.into(), outcome.nodes_visited))
            }
            Query::Capsule {
                instance,
                point1,
                point2,
                radius,
            } => {
                let (asset, pose) = &mut self.placed[instance];
                let stack = stack_for(asset, &mut self.stack);
                let mut contacts = Vec::new();
                let pose = posed(pose, self.max_depth, proxies);
                let outcome =
                    query::capsule(asset, pose, point1, point2, radius, stack, &mut contacts)?;
                Ok(("capsule", Answer::contacts(contacts), outcome.nodes_visited))
            }
            Query::Box {
                instance,
                center,
                rotation,
                half_extents,
            } => {
                let (asset, pose) = &mut self.placed[instance];
                let stack = stack_for(asset, &mut self.stack);
                let mut contacts = Vec::new();
                let pose = posed(pose, self.max_depth, proxies);
                let outcome = query::cuboid(
                    asset,
                    pose,
                    center,
                    rotation,
                    half_extents,
                    stack,
                    &mut contacts,
                )?;
                Ok(("box", Answer::contacts(contacts), outcome.nodes_visited))
            }
            Query::Pair {
                a,
                b,
                tolerance,
                contacts,
            } => {
                let [(asset_a, pose_a), (asset_b, pose_b)] = two(self.placed, a, b)?;
                let needed = asset_a.pair_stack_len(asset_b);
                if self.pair_stack.len() < needed {
                    self.pair_stack.resize(needed, PairStackEntry::default());
                }
                let mut pairs = Vec::new();
                let outcome = query::pair(
                    (asset_a, posed(pose_a, self.max_depth, proxies)),
                    (asset_b, posed(pose_b, self.max_depth, proxies_b)),
                    tolerance,
                    &mut self.pair_stack,
                    &mut pairs,
                )?;
                let regions = match contacts {
                    true => Some(self.regions(a, b, &mut pairs)?),
                    false => None,
                };
                let answer = Answer::pairs(&pairs, regions);
                Ok(("pair", answer, outcome.nodes_visited))
            }
            Query::Distance { a, b, max_distance } => {
                let [(asset_a, pose_a), (asset_b, pose_b)] = two(self.placed, a, b)?;
                let needed = asset_a.distance_stack_len(asset_b);
                if self.distance_stack.len() < needed {
                    self.distance_stack.resize(needed, SearchEntry::default());
                }
                let nearest = query::distance(
                    (asset_a, pose_a),
                    (asset_b, pose_b),
                    max_distance,
                    &mut self.distance_stack,
                )?;
                let answer = Answer::distance(nearest.hit);
                Ok(("distance", answer, nearest.nodes_visited))
            }
        }
    }
}

/// Two instances, which the scene has made sure are different.
fn two<T>(placed: &mut [T], a: usize, b: usize) -> Result<[&mut T; 2], QueryError> {
    let same = QueryError::Argument("b: the same instance as a");
    placed.get_disjoint_mut([a, b]).map_err(|_| same)
}

/// Enough of a stack for an asset.
fn stack_for<'s>(asset: &Asset<'_>, stack: &'s mut Vec<StackEntry>) -> &'s mut [StackEntry] {
    if stack.len() < asset.stack_len() {
        stack.resize(asset.stack_len(), StackEntry::default());
    }
    stack
}
