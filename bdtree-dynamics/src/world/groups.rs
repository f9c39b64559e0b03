//! Bodies in clusters, and pairs of bodies in groups of two clusters: what threads may work on at the same time.
//!
//! A force changes two bodies, so two groups without a common cluster do not disturb each other. Groups are worked on in
//! *rounds* of such groups: the result is that of one thread that takes round after round, whatever the number of threads.

use alloc::vec::Vec;

use nalgebra::{Matrix3, Vector3};

use super::World;
use super::contact::{Contact, plane_of};
use super::pairs::{Candidate, Found};
use crate::error::DynamicsError;

/// Most clusters; a power of two.
const CLUSTERS: usize = 16;

/// Fewer bodies are not worth a cluster of their own.
const BODIES_LEAST: usize = 24;

/// What the solver has of a body.
#[derive(Debug, Clone)]
pub(super) struct Motion {
    /// What contacts have done to it: displacement and turn.
    pub(super) moved: Vector3<f64>,
    pub(super) turned: Vector3<f64>,
    pub(super) rotation: Matrix3<f64>,
    pub(super) per_force: f64,
    pub(super) per_torque: Matrix3<f64>,
    pub(super) model: usize,
    /// Where its numbers begin in the cluster's.
    pub(super) start: usize,
}

/// Bodies near each other.
#[derive(Debug, Default)]
pub(super) struct Cluster {
    pub(super) bodies: Vec<u32>,
    pub(super) motions: Vec<Motion>,
    /// What forces do to q, and what contacts have done to it.
    pub(super) per_force: Vec<f64>,
    pub(super) moved: Vec<f64>,
}

/// Pairs of bodies of two clusters, or of one.
#[derive(Debug, Default)]
pub(super) struct Group {
    /// Both the same for pairs within a cluster.
    pub(super) clusters: [usize; 2],
    /// Pairs of [`World::pairs`](World), ascending.
    pub(super) pairs: Vec<u32>,
    /// Those of them that have contacts or a new list.
    pub(super) found: Vec<Found>,
    /// New lists of what may touch, one behind the other.
    pub(super) near: Vec<Candidate>,
    pub(super) contacts: Vec<Contact>,
    /// Those of points of triangles, one behind the other.
    pub(super) fields: Vec<f64>,
    pub(super) tally: Tally,
    /// Of the last sweep: the sum of normal forces, and of how much they have changed.
    pub(super) sum: f64,
    pub(super) changed: f64,
    pub(super) error: Option<DynamicsError>,
}

/// What queries have cost.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Tally {
    pub(super) candidates: u64,
    pub(super) nodes_visited: u64,
    pub(super) nodes_updated: u64,
    /// Seconds that contacts of spheres with spheres and planes took to find, and those of spheres with triangles.
    pub(super) spheres_s: f64,
    pub(super) triangles_s: f64,
}

/// Where a body is.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Place {
    pub(super) cluster: usize,
    pub(super) slot: usize,
}

/// Clusters, groups and when to work on them; kept, so that later steps allocate nothing.
#[derive(Debug, Default)]
pub(super) struct Groups {
    pub(super) clusters: Vec<Cluster>,
    /// Of clusters i ≤ j at j (j + 1) / 2 + i.
    pub(super) all: Vec<Group>,
    /// Of each body.
    pub(super) places: Vec<Place>,
    /// Groups that have pairs, round by round.
    pub(super) order: Vec<u32>,
    /// Where each round ends in it.
    pub(super) ends: Vec<usize>,
    bodies: Vec<u32>,
    by_size: Vec<u32>,
}

impl Groups {
    /// Number of the group of two clusters, the same for any number of clusters.
    fn index([i, j]: [usize; 2]) -> usize {
        let (low, high) = (i.min(j), i.max(j));
        high * (high + 1) / 2 + low
    }

    /// Puts bodies into clusters.
    fn cluster(&mut self, positions: impl Fn(u32) -> Vector3<f64>, count: usize) {
        let mut clusters = 1;
        while clusters < CLUSTERS && count / (2 * clusters) >= BODIES_LEAST {
            clusters *= 2;
        }
        self.clusters.resize_with(clusters, Cluster::default);
        let groups = clusters * (clusters + 1) / 2;
        self.all.resize_with(groups, Group::default);
        for high in 0..clusters {
            for low in 0..=high {
                self.all[Self::index([low, high])].clusters = [low, high];
            }
        }
        self.bodies.clear();
        self.bodies.extend(0..count as u32);
        halve(&mut self.bodies, &mut self.clusters, &positions);
        self.places.clear();
        self.places.resize(count, Place::default());
        for (cluster, of) in self.clusters.iter().enumerate() {
            for (slot, body) in of.bodies.iter().enumerate() {
                self.places[*body as usize] = Place { cluster, slot };
            }
        }
    }

    /// Sorts groups into rounds without a common cluster, large ones first, so that those of a round are about as large.
    fn plan(&mut self) {
        self.by_size.clear();
        let has_pairs = |index: &u32| !self.all[*index as usize].pairs.is_empty();
        let filled = (0..self.all.len() as u32).filter(has_pairs);
        self.by_size.extend(filled);
        let all = &self.all;
        (self.by_size)
            .sort_unstable_by_key(|index| (usize::MAX - all[*index as usize].pairs.len(), *index));
        self.order.clear();
        self.ends.clear();
        loop {
            // A bit for each cluster that the round has.
            let mut round = 0_u32;
            for index in &mut self.by_size {
                if *index == u32::MAX {
                    continue; // has its round
                }
                let [i, j] = all[*index as usize].clusters;
                let bits = 1 << i | 1 << j;
                if round & bits == 0 {
                    round |= bits;
                    self.order.push(core::mem::replace(index, u32::MAX));
                }
            }
            if round == 0 {
                return;
            }
            self.ends.push(self.order.len());
        }
    }
}

/// Gives each cluster its share of the bodies, by halves along the longest axis.
fn halve(bodies: &mut [u32], clusters: &mut [Cluster], at: &impl Fn(u32) -> Vector3<f64>) {
    if let [cluster] = clusters {
        cluster.bodies.clear();
        bodies.sort_unstable();
        cluster.bodies.extend_from_slice(bodies);
        return;
    }
    let (mut low, mut high) = (
        Vector3::repeat(f64::INFINITY),
        Vector3::repeat(f64::NEG_INFINITY),
    );
    for body in &*bodies {
        (low, high) = (low.inf(&at(*body)), high.sup(&at(*body)));
    }
    let axis = (high - low).imax();
    let middle = bodies.len() / 2;
    bodies.select_nth_unstable_by(middle, |a, b| {
        at(*a)[axis].total_cmp(&at(*b)[axis]).then(a.cmp(b))
    });
    let (first, second) = bodies.split_at_mut(middle);
    let (of_first, of_second) = clusters.split_at_mut(clusters.len() / 2);
    halve(first, of_first, at);
    halve(second, of_second, at);
}

impl World {
    /// Puts bodies into clusters and pairs into groups, and says which groups are worked on together.
    pub(super) fn group(&mut self) {
        let (bodies, groups) = (&self.bodies, &mut self.groups);
        groups.cluster(
            |body| bodies[body as usize].state.position,
            self.bodies.len(),
        );
        for group in &mut groups.all {
            group.pairs.clear();
        }
        for (index, pair) in self.pairs.iter().enumerate() {
            let first = groups.places[pair.first as usize].cluster;
            let second = match plane_of(pair.second) {
                Some(_) => first,
                None => groups.places[pair.second as usize].cluster,
            };
            let group = Groups::index([first, second]);
            groups.all[group].pairs.push(index as u32);
        }
        groups.plan();
    }

    /// Gives clusters what the solver needs of their bodies.
    pub(super) fn fill_clusters(&mut self) {
        for cluster in &mut self.groups.clusters {
            cluster.motions.clear();
            cluster.per_force.clear();
            cluster.moved.clear();
            for body in &cluster.bodies {
                let body = &self.bodies[*body as usize];
                let stride = self.models[body.model].spheres.stride();
                cluster.motions.push(Motion {
                    moved: Vector3::zeros(),
                    turned: Vector3::zeros(),
                    rotation: body.rotation,
                    per_force: body.per_force,
                    per_torque: body.per_torque,
                    model: body.model,
                    start: cluster.moved.len(),
                });
                let own = super::part(&self.modal.per_force, body.start, stride);
                cluster.per_force.extend_from_slice(own);
                cluster.moved.resize(cluster.per_force.len(), 0.0);
            }
        }
    }

    /// Tells bodies what contacts have done to them.
    pub(super) fn take_from_clusters(&mut self) {
        for cluster in &self.groups.clusters {
            for (body, motion) in cluster.bodies.iter().zip(&cluster.motions) {
                let body = &mut self.bodies[*body as usize];
                (body.moved, body.turned) = (motion.moved, motion.turned);
                let stride = self.models[body.model].spheres.stride();
                let own = super::part(&cluster.moved, motion.start, stride);
                self.modal.moved[body.start..body.start + stride].copy_from_slice(own);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_of_a_round_have_no_cluster_in_common_and_every_group_has_a_round() {
        let at = |body: u32| {
            let body = f64::from(body);
            Vector3::new(
                libm::sin(body) * 9.0,
                libm::cos(body * 3.7) * 4.0,
                body / 90.0,
            )
        };
        let mut groups = Groups::default();
        for count in [3, 47, 48, 700] {
            groups.cluster(at, count);
            let sizes: Vec<usize> = groups.clusters.iter().map(|of| of.bodies.len()).collect();
            assert_eq!(sizes.iter().sum::<usize>(), count);
            assert!(sizes.len() == 1 || sizes.iter().all(|size| *size >= BODIES_LEAST));
            for (index, group) in groups.all.iter_mut().enumerate() {
                group.pairs = (0..(index * 7 % 5) as u32).collect();
            }
            groups.plan();
            let mut begin = 0;
            for end in &groups.ends {
                let mut taken = 0_u32;
                for index in &groups.order[begin..*end] {
                    let [i, j] = groups.all[*index as usize].clusters;
                    let bits = 1 << i | 1 << j;
                    assert_eq!(taken & bits, 0);
                    taken |= bits;
                }
                begin = *end;
            }
            let mut order = groups.order.clone();
            order.sort_unstable();
            let filled = (0..groups.all.len() as u32)
                .filter(|index| !groups.all[*index as usize].pairs.is_empty());
            assert!(order.into_iter().eq(filled));
        }
    }
}
