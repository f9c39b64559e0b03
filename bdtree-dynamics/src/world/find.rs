//! Which contact spheres touch: lists from the trees, and contacts from the lists.

use bdtree_runtime::{HalfSpace, LaneTriangle, Workspace};
use nalgebra::Vector3;

use super::contact::{Contact, NEAR, plane_of};
use super::groups::{Group, Place, Tally};
use super::pairs::{Candidate, Found, Pair, Part};
use super::solve::Warm;
use super::workers::{Clock, Worker, each};
use super::{StepReport, World};
use crate::body_model::ContactShape;
use crate::error::DynamicsError;

impl World {
    /// The contacts of the step, with the forces of the step before to begin with.
    pub(super) fn find(&mut self) -> Result<StepReport, DynamicsError> {
        self.find_pairs()?;
        self.group();
        let mut workers = core::mem::take(&mut self.workers);
        let mut groups = core::mem::take(&mut self.groups.all);
        let world = &*self;
        each(&mut workers, groups.iter_mut(), |worker, group| {
            group.begin();
            let clock = Clock::start();
            group.error = world.look_at_group(worker, group).err();
            let tally = &mut group.tally;
            tally.spheres_s = (clock.seconds() - tally.triangles_s).max(0.0);
        });
        (self.workers, self.groups.all) = (workers, groups);
        for body in &mut self.bodies {
            body.snapshot.is_new = false;
        }
        let mut report = StepReport {
            pairs: self.pairs.len() as u64,
            ..StepReport::default()
        };
        for group in &mut self.groups.all {
            if let Some(error) = group.error.take() {
                return Err(error);
            }
            report.candidates += group.tally.candidates;
            report.nodes_visited += group.tally.nodes_visited;
            report.nodes_updated += group.tally.nodes_updated;
            self.times.spheres_s += group.tally.spheres_s;
            self.times.triangles_s += group.tally.triangles_s;
        }
        self.note_found();
        self.memory.loose.clear();
        Ok(report)
    }

    fn look_at_group(&self, worker: &mut Worker, group: &mut Group) -> Result<(), DynamicsError> {
        for k in 0..group.pairs.len() {
            let index = group.pairs[k];
            let pair = &self.pairs[index as usize];
            let meets = self.meets(pair);
            let clock = match meets {
                Meets::Triangles { .. } | Meets::Regions => Some(Clock::start()),
                _ => None,
            };
            let start = group.near.len();
            let mut near = None;
            if pair.near.is_none() {
                match meets {
                    Meets::Plane(plane) => self.ask_plane(pair, plane, worker, group)?,
                    Meets::Spheres => self.ask_trees(pair, worker, group)?,
                    Meets::Triangles { is_swapped } => {
                        self.ask_triangles(pair, is_swapped, worker, group)?;
                    }
                    Meets::Regions | Meets::Vertices(_) => {}
                }
                // As contacts of the step before and after are sorted.
                group.near[start..].sort_unstable_by_key(|of| of.elements);
                if self.is_kept(pair) {
                    near = Some(Part::new(start, group.near.len()));
                }
            }
            let asked = core::mem::take(&mut group.near);
            let list = match pair.near {
                Some(kept) => kept.of(&self.memory.candidates),
                None => &asked[start..],
            };
            group.tally.candidates += list.len() as u64;
            let from = group.contacts.len();
            let warm = self.memory.warm_of(pair);
            match meets {
                Meets::Plane(plane) => {
                    self.look_at_plane(pair, plane, list, warm, &mut group.contacts);
                }
                Meets::Spheres => {
                    let base = group.clusters[0];
                    self.look_at_pair(pair, base, list, warm, &mut group.contacts);
                }
                Meets::Triangles { is_swapped } => {
                    let scratch = &mut worker.scratch;
                    self.look_at_surface(pair, is_swapped, list, warm, scratch, group)?;
                }
                Meets::Regions => self.look_at_regions(pair, warm, worker, group)?,
                Meets::Vertices(plane) => {
                    self.look_at_vertices(pair, plane, warm, worker, group)?
                }
            }
            group.near = asked;
            if let Some(clock) = clock {
                group.tally.triangles_s += clock.seconds();
            }
            let contacts = Part::new(from, group.contacts.len());
            if near.is_some() || contacts != Part::new(from, from) {
                group.found.push(Found {
                    pair: index,
                    near,
                    contacts,
                });
            }
        }
        Ok(())
    }

    /// Whether what trees say of a pair is kept for later steps.
    fn is_kept(&self, pair: &Pair) -> bool {
        let is_brief = |body: u32| {
            let body = self.bodies.get(body as usize);
            body.is_some_and(|body| body.snapshot.is_brief)
        };
        !is_brief(pair.first) && !is_brief(pair.second)
    }

    /// How far apart contact spheres at the snapshots may be: for as long as the answer is kept, or in this step.
    pub(super) fn prediction(&self, pair: &Pair) -> f64 {
        let is_kept = self.is_kept(pair);
        let far = |body: u32| match self.bodies.get(body as usize) {
            Some(body) if is_kept => body.snapshot.allowance,
            Some(body) => body.far,
            None => 0.0, // a plane
        };
        (far(pair.first) + far(pair.second)) * (1.0 + 1e-9)
    }

    fn meets(&self, pair: &Pair) -> Meets {
        use ContactShape::{Regions, Triangles};
        let shape = |body: u32| self.models[self.bodies[body as usize].model].contact;
        if let Some(plane) = plane_of(pair.second) {
            return match shape(pair.first) {
                Regions => Meets::Vertices(plane),
                _ => Meets::Plane(plane),
            };
        }
        match [pair.first, pair.second].map(shape) {
            [Regions, Regions] => Meets::Regions,
            [Triangles, Triangles] => Meets::Spheres,
            [_, Triangles] => Meets::Triangles { is_swapped: false },
            [Triangles, _] => Meets::Triangles { is_swapped: true },
            _ => Meets::Spheres,
        }
    }

    /// Adds pairs of a contact sphere and a triangle that may touch while both bodies are within their allowances.
    fn ask_triangles(
        &self,
        pair: &Pair,
        is_swapped: bool,
        worker: &mut Worker,
        group: &mut Group,
    ) -> Result<(), DynamicsError> {
        let mut both = [pair.first, pair.second].map(|index| index as usize);
        if is_swapped {
            both.swap(0, 1);
        }
        let a = &self.bodies[both[0]];
        let spheres = &self.models[a.model].spheres;
        let prediction = self.prediction(pair);
        let [pose_a, pose_b] = both.map(|index| self.instances[index].pose());
        let [mut cache_a, mut cache_b] = both.map(|index| self.caches[index].get());
        worker.lane_triangles.clear();
        let mut unused = Workspace::in_bytes(&mut []);
        let (mut query_a, mut query_b) = (
            pose_a.query(&mut worker.workspace),
            pose_b.query(&mut unused),
        );
        if let Some(cache) = &mut cache_a {
            query_a = query_a.cached(cache);
        }
        if let Some(cache) = &mut cache_b {
            query_b = query_b.cached(cache);
        }
        query_a.against(query_b).level_triangles(
            spheres.level,
            prediction,
            spheres.reach(),
            &mut worker.lane_triangles,
        )?;
        for LaneTriangle { lane, triangle } in &worker.lane_triangles {
            if let Some(sphere) = spheres.of(*lane) {
                let elements = [sphere as u32, triangle.0];
                group.near.push(Candidate::unknown(elements));
            }
        }
        group.tally.add(worker);
        Ok(())
    }

    /// Adds the pairs of contact spheres that may touch while both bodies are within their allowances.
    fn ask_trees(
        &self,
        pair: &Pair,
        worker: &mut Worker,
        group: &mut Group,
    ) -> Result<(), DynamicsError> {
        let both = [pair.first, pair.second].map(|index| index as usize);
        let [a, b] = both.map(|index| &self.bodies[index]);
        let [of_a, of_b] = [a, b].map(|body| &self.models[body.model].spheres);
        let prediction = self.prediction(pair);
        let [pose_a, pose_b] = both.map(|index| self.instances[index].pose());
        let [mut cache_a, mut cache_b] = both.map(|index| self.caches[index].get());
        worker.pairs.clear();
        let mut unused = Workspace::in_bytes(&mut []);
        let (mut query_a, mut query_b) = (
            pose_a.query(&mut worker.workspace),
            pose_b.query(&mut unused),
        );
        if let Some(cache) = &mut cache_a {
            query_a = query_a.cached(cache);
        }
        if let Some(cache) = &mut cache_b {
            query_b = query_b.cached(cache);
        }
        query_a.against(query_b).level_spheres(
            [of_a.level, of_b.level],
            prediction,
            of_a.reach() + of_b.reach(),
            &mut worker.pairs,
        )?;
        // Bounding spheres are larger than contact spheres.
        let [at_a, at_b] = both.map(|index| self.at_snapshot(index));
        for [lane_a, lane_b] in &worker.pairs {
            if let (Some(sphere_a), Some(sphere_b)) = (of_a.of(*lane_a), of_b.of(*lane_b)) {
                let reach = of_a.radius(sphere_a) + of_b.radius(sphere_b);
                let gap = (at_a.center(sphere_a) - at_b.center(sphere_b)).norm() - reach;
                if gap <= prediction {
                    let elements = [sphere_a as u32, sphere_b as u32];
                    group.near.push(Candidate::new(elements, gap, reach));
                }
            }
        }
        group.tally.add(worker);
        Ok(())
    }

    /// Adds the contact spheres that may touch a plane while the body is within its allowance.
    fn ask_plane(
        &self,
        pair: &Pair,
        plane: usize,
        worker: &mut Worker,
        group: &mut Group,
    ) -> Result<(), DynamicsError> {
        let index = pair.first as usize;
        let prediction = self.prediction(pair);
        let body = &self.bodies[index];
        let spheres = &self.models[body.model].spheres;
        let at = self.planes[plane];
        let raised = (spheres.reach() + prediction) * (1.0 + 1e-9);
        let pose = self.instances[index].pose();
        let mut cache = self.caches[index].get();
        worker.lanes.clear();
        let mut query = pose.query(&mut worker.workspace);
        if let Some(cache) = &mut cache {
            query = query.cached(cache);
        }
        query.level_spheres(
            spheres.level,
            HalfSpace::new(at.normal, at.offset + raised),
            &mut worker.lanes,
        )?;
        let posed = self.at_snapshot(index);
        let normal = Vector3::from(at.normal);
        for lane in &worker.lanes {
            if let Some(sphere) = spheres.of(*lane) {
                let height = normal.dot(&posed.center(sphere)) - at.offset;
                let radius = spheres.radius(sphere);
                if height - radius <= prediction {
                    let size = radius + at.offset.abs() + height.abs();
                    group
                        .near
                        .push(Candidate::new([sphere as u32, 0], height - radius, size));
                }
            }
        }
        group.tally.add(worker);
        Ok(())
    }

    /// Adds the contacts of two bodies.
    fn look_at_pair(
        &self,
        pair: &Pair,
        base: usize,
        list: &[Candidate],
        mut warm: &[Warm],
        out: &mut alloc::vec::Vec<Contact>,
    ) {
        let [a, b] = [pair.first, pair.second].map(|index| &self.bodies[index as usize]);
        // By how much their distance may become smaller within the step, and again as much for pairs that others push together.
        let near = 3.0 * ((a.way - b.way).norm() + a.swing + b.swing + a.ripple + b.ripple);
        let far = a.far + b.far;
        let is_near = |of: &&Candidate| of.may_be_within(near, far);
        let mut left = list.iter().filter(is_near).peekable();
        if left.peek().is_none() {
            return;
        }
        let (first, second) = (self.mover(pair.first), self.mover(pair.second));
        let slots =
            [pair.first, pair.second].map(|body| self.groups.places[body as usize].within(base));
        while let Some(next) = left.peek() {
            let sphere_a = next.elements[0];
            let start = first.start(sphere_a as usize);
            while let Some(next) = left.next_if(|next| next.elements[0] == sphere_a) {
                let both = next.elements.map(|sphere| sphere as usize);
                if let Some(mut contact) = self.touch([&first, &second], both, start, near) {
                    contact.slots = slots;
                    contact.begin_with(&mut warm);
                    out.push(contact);
                }
            }
        }
    }

    /// Adds the contacts of a body and a plane.
    fn look_at_plane(
        &self,
        pair: &Pair,
        plane: usize,
        list: &[Candidate],
        mut warm: &[Warm],
        out: &mut alloc::vec::Vec<Contact>,
    ) {
        let mover = self.mover(pair.first);
        let place = self.groups.places[pair.first as usize];
        let body = mover.body;
        // Within the step a sphere moves by no more than this.
        let way = 2.0 * (body.way.norm() + body.swing + body.ripple);
        for of in list {
            let sphere = of.elements[0] as usize;
            let near = NEAR * (way + 2e-3 * mover.spheres.radius(sphere));
            if !of.may_be_within(near, body.far) {
                continue;
            }
            if let Some(mut contact) = self.touch_plane(&mover, sphere, plane) {
                contact.slots = [place.within(place.cluster); 2];
                contact.begin_with(&mut warm);
                out.push(contact);
            }
        }
    }
}

/// What of two sides touch each other.
#[derive(Debug, Clone, Copy)]
enum Meets {
    Plane(usize),
    Spheres,
    /// Spheres of the first body and triangles of the second, or the other way round.
    Triangles {
        is_swapped: bool,
    },
    /// Surfaces, exactly, and vertices with a plane.
    Regions,
    Vertices(usize),
}

impl Group {
    fn begin(&mut self) {
        self.found.clear();
        self.near.clear();
        self.contacts.clear();
        self.fields.clear();
        self.tally = Tally::default();
    }
}

impl Tally {
    pub(super) fn add(&mut self, worker: &Worker) {
        let stats = worker.workspace.stats();
        self.nodes_visited += stats.nodes_visited;
        self.nodes_updated += stats.nodes_updated;
    }
}

/// A body in one of a group's two clusters: its slot, and in the highest bit whether it is the second one.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Slot(u32);

impl Slot {
    const SECOND: u32 = 1 << 31;

    /// Which of the clusters, and the slot there.
    #[inline]
    pub(super) fn split(self) -> (bool, usize) {
        (
            self.0 & Self::SECOND != 0,
            (self.0 & !Self::SECOND) as usize,
        )
    }
}

impl Place {
    /// In a group whose first cluster is `base`.
    pub(super) fn within(self, base: usize) -> Slot {
        let second = if self.cluster == base {
            0
        } else {
            Slot::SECOND
        };
        Slot(self.slot as u32 | second)
    }
}
