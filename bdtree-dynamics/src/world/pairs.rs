//! Pairs of bodies near each other, and what is known of them from the steps before: which contact spheres may touch, and the
//! forces between them.

use alloc::vec::Vec;

use bdtree_runtime::broad;
use nalgebra::Vector3;

use super::contact::{Contact, Side};
use super::solve::{Warm, order};
use super::{Frame, World};
use crate::error::DynamicsError;

/// Two bodies, or a body and a plane, that are near each other.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pair {
    pub(super) first: u32,
    /// A body, or a plane counted from the end of the numbers.
    pub(super) second: u32,
    /// What may touch: a part of [`Memory::candidates`], sorted.
    pub(super) near: Option<Part>,
    /// Its contacts of the step before, and then of this one.
    pub(super) contacts: Part,
    /// The group whose list they are in.
    pub(super) group: u32,
}

/// A part of a list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Part {
    start: u32,
    len: u32,
}

impl Part {
    pub(super) fn new(start: usize, end: usize) -> Self {
        Self {
            start: start as u32,
            len: (end - start) as u32,
        }
    }

    pub(super) fn of<T>(self, list: &[T]) -> &[T] {
        let start = self.start as usize;
        list.get(start..start + self.len as usize)
            .unwrap_or_default()
    }
}

/// Two contact spheres, a sphere and a triangle, or a sphere and a plane, that may touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Candidate {
    pub(super) elements: [u32; 2],
    /// How far apart they are at the snapshots, at least.
    gap: f32,
}

impl Candidate {
    /// `size` is what rounding is relative to.
    pub(super) fn new(elements: [u32; 2], gap: f64, size: f64) -> Self {
        let gap = (gap - 1e-6 * (size + gap.abs())) as f32;
        Self { elements, gap }
    }

    /// Of which nothing is known.
    pub(super) fn unknown(elements: [u32; 2]) -> Self {
        let gap = f32::NEG_INFINITY;
        Self { elements, gap }
    }

    /// Whether they may be within a distance while they are at most `far` from where they are at the snapshots, both together.
    #[inline]
    pub(super) fn may_be_within(&self, distance: f64, far: f64) -> bool {
        f64::from(self.gap) <= distance + far
    }
}

/// What looking at a pair has found, as parts of its group's lists.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    pub(super) pair: u32,
    pub(super) near: Option<Part>,
    pub(super) contacts: Part,
}

/// What keeps forces in no group: after a restore, and when bodies fall asleep or wake.
const LOOSE: u32 = u32::MAX;

/// Contact spheres that may touch, and contact forces of the step before.
#[derive(Debug, Default)]
pub(super) struct Memory {
    pub(super) candidates: Vec<Candidate>,
    candidates_before: Vec<Candidate>,
    pairs_before: Vec<Pair>,
    /// Of each group, in the order of its contacts.
    pub(super) warm: Vec<Vec<Warm>>,
    /// Sorted by bodies and spheres; used once.
    pub(super) loose: Vec<Warm>,
}

impl Memory {
    /// The forces of a pair's contacts in the step before, sorted by spheres.
    pub(super) fn warm_of(&self, pair: &Pair) -> &[Warm] {
        let list = match pair.group {
            LOOSE => Some(&self.loose),
            group => self.warm.get(group as usize),
        };
        list.map(|list| pair.contacts.of(list)).unwrap_or_default()
    }

    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        self.candidates.clear();
        self.loose.clear();
        for list in &mut self.warm {
            list.clear();
        }
    }
}

impl World {
    /// Pairs of bodies whose snapshots are within their allowances of each other, with what is known of them.
    ///
    /// # Errors
    /// Those of [`broad::pairs`].
    pub(super) fn find_pairs(&mut self) -> Result<(), DynamicsError> {
        let memory = &mut self.memory;
        core::mem::swap(&mut self.pairs, &mut memory.pairs_before);
        self.pairs.clear();
        let new = |first: usize, second: u32| Pair {
            first: first as u32,
            second,
            near: None,
            contacts: Part::default(),
            group: LOOSE,
        };
        for (index, body) in self.bodies.iter().enumerate() {
            if !body.moves(!self.models[body.model].modes.is_empty()) || body.frame == Frame::Driven
            {
                continue; // no plane moves it
            }
            let sphere = &self.spheres[index];
            for (k, plane) in self.planes.iter().enumerate() {
                let center = Vector3::from(sphere.center);
                let height = Vector3::from(plane.normal).dot(&center) - plane.offset;
                if height <= sphere.radius {
                    self.pairs.push(new(index, Side::plane(k).body));
                }
            }
        }
        self.near.clear();
        broad::pairs(&self.spheres, 0.0, &mut self.workspace, &mut self.near)?;
        for [first, second] in &self.near {
            let moves = |index: usize| {
                let body = &self.bodies[index];
                body.moves(!self.models[body.model].modes.is_empty())
            };
            if moves(*first) || moves(*second) {
                self.pairs.push(new(*first, *second as u32));
            }
        }
        self.pairs
            .sort_unstable_by_key(|pair| (pair.first, pair.second));
        self.remember();
        Ok(())
    }

    /// Takes over what is known from the step before.
    fn remember(&mut self) {
        let memory = &mut self.memory;
        core::mem::swap(&mut memory.candidates, &mut memory.candidates_before);
        memory.candidates.clear();
        let is_new = |body: u32| {
            let body = self.bodies.get(body as usize);
            body.is_some_and(|body| body.snapshot.is_new)
        };
        let mut before = memory.pairs_before.iter().peekable();
        let mut loose = (memory.loose.iter().enumerate()).peekable();
        let has_loose = !memory.loose.is_empty();
        for pair in &mut self.pairs {
            let at = (pair.first, pair.second);
            while before.next_if(|old| (old.first, old.second) < at).is_some() {}
            if let Some(old) = before.next_if(|old| (old.first, old.second) == at) {
                if !has_loose {
                    (pair.contacts, pair.group) = (old.contacts, old.group);
                }
                if let Some(near) = old.near
                    && !is_new(pair.first)
                    && !is_new(pair.second)
                {
                    let start = memory.candidates.len();
                    let kept = near.of(&memory.candidates_before);
                    memory.candidates.extend_from_slice(kept);
                    pair.near = Some(Part::new(start, memory.candidates.len()));
                }
            }
            if has_loose {
                let bodies = |warm: &Warm| (warm.sides[0].body, warm.sides[1].body);
                while loose.next_if(|(_, warm)| bodies(warm) < at).is_some() {}
                let Some((start, _)) = loose.peek().copied() else {
                    continue;
                };
                let mut end = start;
                while loose.next_if(|(_, warm)| bodies(warm) == at).is_some() {
                    end += 1;
                }
                pair.contacts = Part::new(start, end);
            }
        }
    }

    /// Writes down what looking at the pairs has found.
    pub(super) fn note_found(&mut self) {
        let candidates = &mut self.memory.candidates;
        for pair in &mut self.pairs {
            pair.contacts = Part::default();
        }
        for (index, group) in self.groups.all.iter().enumerate() {
            for found in &group.found {
                let pair = &mut self.pairs[found.pair as usize];
                if let Some(near) = found.near {
                    let start = candidates.len();
                    candidates.extend_from_slice(near.of(&group.near));
                    pair.near = Some(Part::new(start, candidates.len()));
                }
                (pair.contacts, pair.group) = (found.contacts, index as u32);
            }
        }
    }

    /// The contacts of the last step, sorted by bodies and spheres.
    pub(super) fn sorted_contacts(&self) -> impl Iterator<Item = &Contact> + use<'_> {
        self.pairs.iter().flat_map(|pair| {
            let group = self.groups.all.get(pair.group as usize);
            let all = group.map(|group| &group.contacts[..]).unwrap_or_default();
            pair.contacts.of(all)
        })
    }

    /// Their forces, which the next step begins with.
    pub(super) fn sorted_warm(&self) -> impl Iterator<Item = &Warm> + use<'_> {
        let pairs = self.pairs.iter();
        let of_pairs = pairs.flat_map(|pair| self.memory.warm_of(pair));
        let loose = match self.pairs.is_empty() {
            true => &self.memory.loose[..],
            false => &[],
        };
        of_pairs.chain(loose)
    }

    /// Takes forces out of groups, to be given back to pairs in the next step.
    pub(super) fn loosen(&mut self, from: &mut Vec<Warm>) {
        from.sort_unstable_by_key(|warm| order(&warm.sides));
        core::mem::swap(&mut self.memory.loose, from);
        for pair in &mut self.pairs {
            (pair.contacts, pair.group) = (Part::default(), LOOSE);
        }
    }
}
