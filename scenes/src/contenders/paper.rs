//! The paper's lazy tree on each workload.

use crate::workloads::bodies::Bodies;
use crate::workloads::curtain::Curtain;
use crate::workloads::pile::{COUNT, Pile};
use crate::workloads::rays::Rays;
use bdtree_measure::paper_tree::{Between, Memory, PaperTree, PlainTree, Step};
use bdtree_measure::peers::Update;
use bdtree_measure::place::Place;
use bdtree_runtime::{Asset, Contact, PairContact, Pose};

use super::frame;
use bdtree_measure::turns::{Counts, Entry, Role};

/// In tables.
pub const NAME: &str = "paper's tree";

/// The same, without layout for vector instructions.
pub const PLAIN: &str = "paper's tree, plain";

/// One instance: q and what has been computed in this step.
struct Instance<'a> {
    asset: Asset<'a>,
    numbers: Vec<f32>,
    memory: Memory,
}

impl<'a> Instance<'a> {
    fn new(tree: &PaperTree, asset: Asset<'a>) -> Self {
        Self {
            numbers: vec![0.0; asset.pose_len()],
            memory: Memory::new(tree, &asset),
            asset,
        }
    }

    /// Begins a step; gives the pose and the rest of the instance.
    fn pose(&mut self, q: &[f32], place: &Place) -> (Pose<'_>, &mut Memory) {
        let pose = self.asset.pose(q, place.transform(), &mut self.numbers);
        let pose = pose.expect("q within limits");
        self.memory.begin_step(&pose);
        (pose, &mut self.memory)
    }
}

/// W1, the tree written plainly.
pub fn plain_ball<'a>(tree: &'a PlainTree, asset: Asset<'a>, work: &'a Curtain) -> Entry<'a> {
    let mut numbers = vec![0.0; asset.pose_len()];
    let (mut step, mut stack) = (Step::default(), Vec::new());
    let mut found: Vec<Contact> = Vec::new();
    Entry::new(PLAIN, Role::Baseline, Counts::Same, move |i| {
        found.clear();
        let ball = work.ball(i);
        frame(Update::default(), || {
            let place = Place::IDENTITY.transform();
            let pose = asset.pose(work.q(i), place, &mut numbers);
            let pose = pose.expect("q within limits");
            step.prepare(&pose);
            tree.ball(&pose, &step, ball, &mut stack, &mut found);
            found.len()
        })
    })
}

/// W1.
pub fn ball<'a>(tree: &'a PaperTree, asset: Asset<'a>, work: &'a Curtain) -> Entry<'a> {
    let mut body = Instance::new(tree, asset);
    let mut found: Vec<Contact> = Vec::new();
    Entry::new(NAME, Role::Baseline, Counts::Same, move |i| {
        found.clear();
        let ball = work.ball(i);
        frame(Update::default(), || {
            let (pose, memory) = body.pose(work.q(i), &Place::IDENTITY);
            let mut spheres = memory.at(&pose);
            tree.walk_ball(&mut spheres, ball, &mut found);
            found.len()
        })
    })
}

/// W2.
pub fn pair<'a>(tree: &'a PaperTree, asset: Asset<'a>, work: &'a Bodies) -> Entry<'a> {
    let mut bodies = [(); 2].map(|()| Instance::new(tree, asset));
    let mut found: Vec<PairContact> = Vec::new();
    Entry::new(NAME, Role::Baseline, Counts::Same, move |i| {
        found.clear();
        let ([qa, qb], place) = (work.q(i), &work.places[i]);
        frame(Update::default(), || {
            let [a, b] = &mut bodies;
            let (pose_a, memory_a) = a.pose(qa, &Place::IDENTITY);
            let (pose_b, memory_b) = b.pose(qb, place);
            PaperTree::walk_pair(
                (tree, &mut memory_a.at(&pose_a)),
                (tree, &mut memory_b.at(&pose_b)),
                &Between::new(&Place::IDENTITY, place),
                &mut found,
            );
            found.len()
        })
    })
}

/// W3 with `count` rays a frame.
pub fn ray<'a>(
    tree: &'a PaperTree,
    asset: Asset<'a>,
    (work, count): (&'a Rays, usize),
) -> Entry<'a> {
    let mut body = Instance::new(tree, asset);
    Entry::new(NAME, Role::Baseline, Counts::Same, move |i| {
        frame(Update::default(), || {
            let (pose, memory) = body.pose(work.q(i), &Place::IDENTITY);
            let mut spheres = memory.at(&pose);
            let rays = work.of(i, count);
            rays.filter(|[from, along]| tree.walk_ray(&mut spheres, *from, *along).is_some())
                .count()
        })
    })
}

/// W4 on the given neighbours.
pub fn pile<'a>(tree: &'a PaperTree, asset: Asset<'a>, work: &'a Pile) -> Entry<'a> {
    let mut memories: Vec<Memory> = (0..COUNT).map(|_| Memory::new(tree, &asset)).collect();
    let mut numbers = vec![0.0; COUNT * asset.pose_len()];
    let mut found: Vec<PairContact> = Vec::new();
    Entry::new(NAME, Role::Baseline, Counts::Same, move |step| {
        found.clear();
        frame(Update::default(), || {
            let poses: Vec<Pose<'_>> = numbers
                .chunks_exact_mut(asset.pose_len())
                .enumerate()
                .map(|(i, numbers)| {
                    let place = work.place(step, i).transform();
                    let pose = asset.pose(work.q(step, i), place, numbers);
                    pose.expect("q within limits")
                })
                .collect();
            for (memory, pose) in memories.iter_mut().zip(&poses) {
                memory.begin_step(pose);
            }
            for [i, j] in &work.pairs {
                let (i, j) = (*i as usize, *j as usize);
                let (low, high) = memories.split_at_mut(j);
                PaperTree::walk_pair(
                    (tree, &mut low[i].at(&poses[i])),
                    (tree, &mut high[0].at(&poses[j])),
                    &Between::new(work.place(step, i), work.place(step, j)),
                    &mut found,
                );
            }
            found.len()
        })
    })
}
