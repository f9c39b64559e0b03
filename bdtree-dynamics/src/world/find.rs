//! Which contact spheres may touch: pairs of bodies from their root spheres, pairs of spheres from their trees.

use bdtree_runtime::{BoundingSphere, HalfSpace, StepCache, Workspace, broad};
use nalgebra::Vector3;

use super::contact::{Side, plane_of};
use super::solve::order;
use super::workers::{Own, Worker, share};
use super::{Frame, StepReport, World};
use crate::error::DynamicsError;

/// Trees are asked for what bodies cover by falling and turning within the step and this many times as much: contacts elsewhere
/// may push them on. What modes move is taken once.
const FAR: f64 = 2.0;

/// Two bodies, or a body and a plane, that are near each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Task {
    first: u32,
    /// A body, or a plane counted from the end of the numbers.
    second: u32,
}

type Caches<'c> = Own<'c, StepCache<'static>>;

impl World {
    /// The contacts of the step, sorted by bodies and spheres, with the forces of the step before to begin with.
    pub(super) fn find(&mut self) -> Result<StepReport, DynamicsError> {
        self.find_tasks()?;
        let mut workers = core::mem::take(&mut self.workers);
        let mut caches = core::mem::take(&mut self.caches);
        let tasks = core::mem::take(&mut self.tasks);
        let world = &*self;
        let first = |task: &Task| task.first as usize;
        share(
            &mut workers,
            &tasks,
            &mut caches,
            first,
            |worker, tasks, mut caches| {
                worker.begin();
                for task in tasks {
                    if let Err(error) = world.look(*task, worker, &mut caches) {
                        worker.error.get_or_insert(error);
                        return;
                    }
                }
            },
        );
        let mut report = StepReport {
            pairs: tasks.len() as u64,
            ..StepReport::default()
        };
        self.contacts.clear();
        let mut error = None;
        for worker in &mut workers {
            error = error.or(worker.error.take());
            if self.contacts.is_empty() {
                core::mem::swap(&mut self.contacts, &mut worker.contacts);
            } else {
                self.contacts.append(&mut worker.contacts);
            }
            report.candidates += worker.candidates;
            report.nodes_visited += worker.nodes_visited;
            report.nodes_updated += worker.nodes_updated;
        }
        (self.workers, self.tasks, self.caches) = (workers, tasks, caches);
        if let Some(error) = error {
            return Err(error);
        }
        self.begin_with_forces_of_before();
        Ok(report)
    }

    fn find_tasks(&mut self) -> Result<(), DynamicsError> {
        self.tasks.clear();
        for (index, body) in self.bodies.iter().enumerate() {
            let BoundingSphere { center, radius } = self.instances[index].bounding_sphere()?;
            let reach = self.models[body.model].spheres.reach();
            let way = FAR * (body.swing + body.way.norm()) + body.ripple;
            let radius = (radius + reach + way) * (1.0 + 1e-9);
            self.spheres[index] = BoundingSphere { center, radius };
            if !body.moves(!self.models[body.model].modes.is_empty()) || body.frame == Frame::Driven
            {
                continue; // no plane moves it
            }
            for (k, plane) in self.planes.iter().enumerate() {
                let height = Vector3::from(plane.normal).dot(&Vector3::from(center)) - plane.offset;
                if height <= radius {
                    self.tasks.push(Task {
                        first: index as u32,
                        second: Side::plane(k).body,
                    });
                }
            }
        }
        self.near.clear();
        broad::pairs(&self.spheres, 0.0, &mut self.workspace, &mut self.near)?;
        for [first, second] in &self.near {
            let both = [*first, *second];
            let moves = |index: usize| {
                let body = &self.bodies[index];
                body.moves(!self.models[body.model].modes.is_empty())
            };
            if !both.into_iter().any(moves) {
                continue;
            }
            self.tasks.push(Task {
                first: *first as u32,
                second: *second as u32,
            });
        }
        self.tasks.sort_unstable();
        Ok(())
    }

    /// Adds the contacts of a pair.
    fn look(
        &self,
        task: Task,
        worker: &mut Worker,
        caches: &mut Caches<'_>,
    ) -> Result<(), DynamicsError> {
        let found = worker.contacts.len();
        match plane_of(task.second) {
            Some(plane) => self.look_at_plane(task.first, plane, worker, caches)?,
            None => self.look_at_pair(task, worker, caches)?,
        }
        let stats = worker.workspace.stats();
        worker.nodes_visited += stats.nodes_visited;
        worker.nodes_updated += stats.nodes_updated;
        worker.contacts[found..].sort_unstable_by_key(|contact| order(&contact.sides));
        Ok(())
    }

    fn look_at_pair(
        &self,
        task: Task,
        worker: &mut Worker,
        caches: &mut Caches<'_>,
    ) -> Result<(), DynamicsError> {
        let [a, b] = [task.first, task.second].map(|index| index as usize);
        let (first, second) = (self.mover(task.first), self.mover(task.second));
        let (of_a, of_b) = (first.spheres, second.spheres);
        let way = (first.body.way - second.body.way).norm();
        let (swing, ripple) = (
            first.body.swing + second.body.swing,
            first.body.ripple + second.body.ripple,
        );
        let prediction = (FAR * (way + swing) + ripple) * (1.0 + 1e-9);
        // Within the step, and again as much for pairs that others push together.
        let near = 3.0 * (way + swing + ripple);
        let [pose_a, pose_b] = [a, b].map(|index| self.instances[index].pose());
        worker.pairs.clear();
        let mut unused = Workspace::in_bytes(&mut []);
        let (mut query_a, mut query_b) = (
            pose_a.query(&mut worker.workspace),
            pose_b.query(&mut unused),
        );
        let [cache_a, cache_b] = caches.both([a, b]);
        if let Some(cache) = cache_a {
            query_a = query_a.cached(cache);
        }
        if let Some(cache) = cache_b {
            query_b = query_b.cached(cache);
        }
        query_a.against(query_b).level_spheres(
            [of_a.level, of_b.level],
            prediction,
            of_a.reach() + of_b.reach(),
            &mut worker.pairs,
        )?;
        worker.candidates += worker.pairs.len() as u64;
        for [lane_a, lane_b] in &worker.pairs {
            if let (Some(sphere_a), Some(sphere_b)) = (of_a.of(*lane_a), of_b.of(*lane_b)) {
                let touch = self.touch([&first, &second], [sphere_a, sphere_b], near);
                worker.contacts.extend(touch);
            }
        }
        Ok(())
    }

    fn look_at_plane(
        &self,
        index: u32,
        plane: usize,
        worker: &mut Worker,
        caches: &mut Caches<'_>,
    ) -> Result<(), DynamicsError> {
        let mover = self.mover(index);
        let (body, spheres) = (mover.body, mover.spheres);
        let at = self.planes[plane];
        let way = Vector3::from(at.normal).dot(&body.way).abs();
        let raised = (spheres.reach() + FAR * (body.swing + way) + body.ripple) * (1.0 + 1e-9);
        let pose = self.instances[index as usize].pose();
        worker.lanes.clear();
        let mut query = pose.query(&mut worker.workspace);
        if let [Some(cache), _] = caches.both([index as usize, usize::MAX]) {
            query = query.cached(cache);
        }
        query.level_spheres(
            spheres.level,
            HalfSpace::new(at.normal, at.offset + raised),
            &mut worker.lanes,
        )?;
        worker.candidates += worker.lanes.len() as u64;
        for lane in &worker.lanes {
            if let Some(sphere) = spheres.of(*lane) {
                (worker.contacts).extend(self.touch_plane(&mover, sphere, plane));
            }
        }
        Ok(())
    }
}

impl Worker {
    fn begin(&mut self) {
        self.contacts.clear();
        (self.candidates, self.nodes_visited, self.nodes_updated) = (0, 0, 0);
        self.error = None;
    }
}
