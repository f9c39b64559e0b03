//! `bdtree query`: a scene's queries answered, one JSON line each.

mod budgeted;
mod lines;

use std::io::Write;

use bdtree_runtime::{
    CacheSize, Instance, PairContact, PairQuery, Proxy, Query as SingleQuery, QueryError, Ray,
    RayIntersection, Shape, Workspace,
};

use crate::DONE;
pub use crate::cli::QueryArguments as Arguments;
use crate::error::ToolError;
use crate::output::write_json;
use crate::scene::{Query, RaysMode, Scene};
use lines::{Answer, Hits, Line, ProxyLine};

/// Nodes that rays of an instance share, at most.
const NODES_MAX: usize = 1 << 16;

/// Answers the queries of a scene in order; the whole scene is checked before the first line.
///
/// # Errors
/// Every problem of the scene, a corrupt asset, an output stream that fails.
pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<u8, ToolError> {
    let scene = Scene::load(&arguments.scene, !arguments.no_verify)?;
    let mut bodies = scene.bodies(|index| kept(&scene, index))?;
    solve_all(&scene, &mut bodies, |mut line, nodes_visited| {
        line.nodes_visited = arguments.stats.then_some(nodes_visited);
        write_json(out, &line)
    })?;
    Ok(DONE)
}

/// Many rays visit the same nodes; other queries come one after the other, and nothing is worth keeping.
fn kept(scene: &Scene, index: usize) -> CacheSize {
    let is_rays =
        |query: &Query| matches!(query, Query::Rays { instance, .. } if *instance == index);
    if !scene.queries.iter().any(is_rays) {
        return CacheSize::NONE;
    }
    let asset = scene.files[scene.instances[index].file].asset();
    CacheSize {
        nodes: asset.node_count().min(NODES_MAX),
        leaves: 0,
    }
}

/// Answers the queries of a scene in order: `take` gets each line and the number of nodes visited.
///
/// # Errors
/// A corrupt asset; those of `take`.
pub(crate) fn solve_all(
    scene: &Scene,
    bodies: &mut [Instance],
    mut take: impl FnMut(Line, u64) -> Result<(), ToolError>,
) -> Result<(), ToolError> {
    let mut solver = Solver {
        bodies,
        workspace: Workspace::new(),
        max_depth: scene.options.max_depth,
        proxies: Default::default(),
    };
    for (i, query) in scene.queries.iter().enumerate() {
        let place = || format!("{}: queries[{i}]", scene.source);
        let corrupt = |error| ToolError::input(place(), told(scene, query, error));
        let within = match scene.options.max_visits {
            Some(n) => solver.solve_within(query, n).map_err(corrupt)?,
            None => None,
        };
        let (answer, certificate) = match within {
            Some((answer, certificate)) => (answer, Some(certificate)),
            None => (solver.solve(query).map_err(corrupt)?, None),
        };
        let line = Line {
            query: i,
            kind: query.kind(),
            answer,
            proxies: scene.options.max_depth.map(|_| solver.take_proxies()),
            certificate,
            nodes_visited: None,
        };
        if !line.is_finite() {
            let message = "the answer is not finite: damaged .bdt file, run bdtree verify";
            return Err(ToolError::input(place(), message));
        }
        take(line, solver.workspace.stats().nodes_visited)?;
    }
    Ok(())
}

/// A query's error with the files that it may be about.
fn told(scene: &Scene, query: &Query, error: QueryError) -> String {
    let QueryError::Corrupt(_) = error else {
        return error.to_string();
    };
    let path = |instance: usize| {
        let file = &scene.files[scene.instances[instance].file];
        file.path().display().to_string()
    };
    let (a, b) = query.instances();
    let (a, b) = (path(a), b.map(path));
    let files = match b {
        Some(b) if b != a => format!("{a} or {b}"),
        _ => a,
    };
    format!("{files}: {error}")
}

/// The instances, and the memory that queries work in.
struct Solver<'s> {
    bodies: &'s mut [Instance],
    workspace: Workspace<'static>,
    max_depth: Option<usize>,
    /// Of the query's instance, or of both, where the k-th of one belongs to the k-th of the other.
    proxies: [Vec<Proxy>; 2],
}

impl Solver<'_> {
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

    fn solve(&mut self, query: &Query) -> Result<Answer, QueryError> {
        Ok(match *query {
            Query::Contacts { instance, shape } => {
                let mut contacts = Vec::new();
                self.limited(instance).contacts(shape, &mut contacts)?;
                if let Shape::HalfSpace(_) = shape {
                    // The plane's own normal, as the scene has it.
                    for contact in &mut contacts {
                        contact.normal = contact.normal.map(|n| -n);
                    }
                }
                Answer::contacts(contacts)
            }
            Query::Closest {
                instance,
                point,
                max_distance,
            } => {
                let nearest = self.limited(instance).project_point(point, max_distance)?;
                Answer::Nearest(nearest.into())
            }
            Query::Ray { instance, ref ray } => {
                Answer::Nearest(self.limited(instance).cast_ray(ray)?.into())
            }
            Query::Rays {
                instance,
                mode,
                ref rays,
            } => cast(&mut self.limited(instance), mode, rays)?,
            // The root's sphere decides most of them, and spheres at a level decide nothing.
            Query::Frustum {
                instance,
                ref frustum,
            } => self.whole(instance).frustum_state(frustum)?.into(),
            Query::Pair {
                a,
                b,
                tolerance,
                contacts,
            } => {
                let [a, b] = two(self.bodies, [a, b])?;
                let mut both = a.against(b, &mut self.workspace);
                // Regions need all pairs of triangles.
                if let (Some(level), false) = (self.max_depth, contacts) {
                    let [of_a, of_b] = &mut self.proxies;
                    both = both.max_level1(level, of_a).max_level2(level, of_b);
                }
                let mut pairs: Vec<PairContact> = Vec::new();
                both.contacts(tolerance, &mut pairs)?;
                let mut regions = contacts.then(Vec::new);
                if let Some(regions) = &mut regions {
                    both.condense(&mut pairs, regions)?;
                }
                Answer::pairs(&pairs, regions)
            }
            Query::Distance { a, b, max_distance } => {
                Answer::distance(self.whole_pair([a, b])?.closest_points(max_distance)?)
            }
        })
    }

    /// An instance, looked into all the way.
    fn whole(&mut self, instance: usize) -> SingleQuery<'_, 'static> {
        self.bodies[instance].query(&mut self.workspace)
    }

    /// An instance, not looked into below the scene's depth.
    fn limited(&mut self, instance: usize) -> SingleQuery<'_, 'static> {
        let query = self.bodies[instance].query(&mut self.workspace);
        match self.max_depth {
            Some(level) => query.max_level(level, &mut self.proxies[0]),
            None => query,
        }
    }

    /// Two instances, looked into all the way.
    fn whole_pair(
        &mut self,
        pair: [usize; 2],
    ) -> Result<PairQuery<'_, 'static, 'static>, QueryError> {
        let [a, b] = two(self.bodies, pair)?;
        Ok(a.against(b, &mut self.workspace))
    }
}

/// Two instances, which the scene has made sure are different.
fn two(bodies: &mut [Instance], pair: [usize; 2]) -> Result<[&mut Instance; 2], QueryError> {
    let same = |_| QueryError::Argument("b: the same instance as a");
    bodies.get_disjoint_mut(pair).map_err(same)
}

/// What many rays meet.
fn cast(
    query: &mut SingleQuery<'_, '_>,
    mode: RaysMode,
    rays: &[Ray],
) -> Result<Answer, QueryError> {
    let hits = match mode {
        RaysMode::First => {
            let mut hits = vec![None; rays.len()];
            query.cast_rays(rays, &mut hits)?;
            hits.into_iter()
                .map(|hit| Hits::First(hit.into()))
                .collect()
        }
        RaysMode::Any => {
            let mut hits = vec![false; rays.len()];
            query.intersects_rays(rays, &mut hits)?;
            hits.into_iter().map(Hits::Any).collect()
        }
        RaysMode::All => {
            let mut found: Vec<(usize, RayIntersection)> = Vec::new();
            query.cast_rays_all(rays, &mut found)?;
            found.sort_by(|(i, a), (j, b)| {
                let by_distance = a.distance.total_cmp(&b.distance);
                i.cmp(j).then(by_distance).then(a.triangle.cmp(&b.triangle))
            });
            let mut hits: Vec<Vec<_>> = rays.iter().map(|_| Vec::new()).collect();
            for (i, hit) in found {
                hits[i].push(Some(hit).into());
            }
            hits.into_iter().map(Hits::All).collect()
        }
    };
    Ok(Answer::Rays { hits })
}
