//! Pairs that stay close: which leaves may touch is found out once for several steps.

use core::ops::ControlFlow;

use crate::cache::Posed;
use crate::contact::TriangleId;
use crate::error::QueryError;
use crate::motion::Motion;
use crate::narrow::Triangle;
use crate::pair_frame::PairFrame;
use crate::pose::Pose;
use crate::traverse::{FrontSlot, PairStackEntry, PairVisitor, Two, Walk};
use crate::workspace::Memory;

/// Steps that a front is meant to last, at the speed of the step before.
const STEPS: f64 = 8.0;

/// Most steps where nothing is near: such a front costs nothing to keep.
const STEPS_APART: f64 = 512.0;

/// Widest margin of a front that has leaves, over the sizes of both.
const MARGIN_REL: f64 = 1.0 / 64.0;

/// Queries that a front must have served to be worth its making, and what counts as enough before
/// there was any.
const SERVED_MIN: u32 = 2;
const FRESH: u32 = SERVED_MIN;

/// Queries without a front after one that was not.
const PAUSE: u32 = 16;

/// What a pair of instances keeps from step to step: the pairs of leaves that were within the
/// tolerance and a margin of each other, the *front* where the traversal ended. Until the two
/// have moved by the margin nothing else can touch, so only these leaves are tested, and no node is
/// visited; two that are apart cost a comparison. The answers are those of a walk from the root.
///
/// Deviation from front tracking as in rigid hierarchies (T. Larsson, T. Akenine-Möller; S. Ehmann,
/// M. Lin): what is kept are pairs of leaves with one margin for all, like a neighbour list, not a
/// front of nodes that rises and sinks, since testing eight lanes again is cheaper than remembering
/// each. The margin follows the speed of the two; where they are too fast for it or the memory is
/// too short, the walk from the root is all that is done.
///
/// A pair query takes it by [`PairQuery::front`](super::PairQuery::front). Keep the order of the pair: (b, a) is another
/// pair than (a, b). A front used with another pair, or for another prediction, forgets what it has and begins anew.
#[derive(Debug)]
pub struct PairFront<'m> {
    memory: Memory<'m>,
    state: State,
}

/// All of a front but its memory.
#[derive(Debug)]
struct State {
    len: usize,
    /// Of which pair of instances and for which tolerance.
    of: Option<Identity>,
    /// Motion of the two, together, up to which the front holds.
    until: f64,
    /// Motion of the two at the last query, and how far it was from the one before.
    moved: f64,
    /// Steps that the next margin is meant for.
    steps: f64,
    /// Queries that the front has served.
    served: u32,
    /// Queries to come that do without.
    pause: u32,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Identity {
    starts: [u64; 2],
    tolerance: f64,
}

#[cfg(feature = "alloc")]
impl PairFront<'static> {
    /// A front whose memory grows to what the pair needs.
    pub const fn new() -> Self {
        Self {
            memory: Memory::Owned(alloc::vec::Vec::new()),
            state: State::NEW,
        }
    }
}

#[cfg(feature = "alloc")]
impl Default for PairFront<'static> {
    fn default() -> Self {
        Self::new()
    }
}

impl<'m> PairFront<'m> {
    /// Bytes that a front takes for a pair of leaves.
    pub const SLOT_BYTES: usize = size_of::<FrontSlot>();

    /// A front in these bytes, at any address: [`PairFront::SLOT_BYTES`] for each pair of leaves that is near, say four for each
    /// pair of triangles that touch; more is not used, with fewer the front is not kept.
    pub fn in_bytes(memory: &'m mut [u8]) -> Self {
        Self {
            memory: Memory::of_bytes(memory),
            state: State::NEW,
        }
    }

    /// A pair query with what was found at earlier steps.
    ///
    /// # Errors
    /// [`QueryError::Motion`] where a pose has no motion; a corrupt asset.
    pub(super) fn walk(
        &mut self,
        posed: [Posed<'_>; 2],
        stack: &mut [PairStackEntry],
        visitor: &mut dyn PairVisitor,
    ) -> Result<Walk, QueryError> {
        let slots = self.memory.all_slots();
        let room = slots.len();
        let (walk, found) = self.state.query(slots, posed, stack, visitor)?;
        if found > room && self.memory.grows() {
            // A quarter more, since the next front may be a little larger.
            self.memory.up_to::<FrontSlot>(found + found / 4);
            self.state.pause = 0;
        }
        Ok(walk)
    }
}

impl State {
    const NEW: Self = Self {
        len: 0,
        of: None,
        until: f64::NEG_INFINITY,
        moved: 0.0,
        steps: STEPS,
        served: FRESH,
        pause: 0,
    };

    /// What was done, and how many pairs of leaves a front that was made had, with room or without.
    fn query(
        &mut self,
        memory: &mut [FrontSlot],
        posed: [Posed<'_>; 2],
        stack: &mut [PairStackEntry],
        visitor: &mut dyn PairVisitor,
    ) -> Result<(Walk, usize), QueryError> {
        let [posed1, posed2] = posed.map(Posed::shorter);
        let poses = [posed1.pose, posed2.pose];
        let [Some(motion1), Some(motion2)] = poses.map(|pose| pose.motion) else {
            return Err(QueryError::Motion);
        };
        let motions = [&motion1, &motion2];
        let tolerance = visitor.tolerance();
        let moved = motions[0].total() + motions[1].total();
        let step = self.step_to(motions, tolerance, moved);
        // A bounded query reports spheres, which the front does not have.
        let bounded = posed1.is_bounded() || posed2.is_bounded();
        let posed = [posed1, posed2];
        if moved <= self.until && !bounded {
            self.served += 1;
            let leaves = memory.get(..self.len).unwrap_or_default();
            if leaves.is_empty() {
                return Ok((Walk::default(), 0));
            }
            let Some(frame) = PairFrame::new(&posed[0], &posed[1], tolerance) else {
                return Ok((Walk::default(), 0));
            };
            let two = Two {
                posed,
                frame: &frame,
                leaves: Some(leaves),
            };
            return Ok((two.walk(stack, visitor)?, 0));
        }
        let margin = if bounded {
            None
        } else {
            self.next_margin(step)
        };
        let reach = tolerance + margin.unwrap_or(0.0);
        if PairFrame::new(&posed[0], &posed[1], reach).is_none() {
            self.keep(0, moved, margin);
            return Ok((Walk::default(), 0));
        }
        // A wide margin is worth its walk only where it meets nothing at all.
        let size = |pose: &Pose<'_>| pose.reach * pose.placement.world_per_stored();
        let widest = MARGIN_REL * (size(poses[0]) + size(poses[1]));
        let margin = margin
            .map(|margin| margin.min(widest))
            .filter(|margin| *margin >= f64::from(SERVED_MIN) * step);
        let reach = tolerance + margin.unwrap_or(0.0);
        let Some(frame) = PairFrame::new(&posed[0], &posed[1], reach) else {
            self.keep(0, moved, margin);
            return Ok((Walk::default(), 0));
        };
        let two = Two {
            posed,
            frame: &frame,
            leaves: None,
        };
        let room: &mut [FrontSlot] = match margin {
            Some(_) => memory,
            None => &mut [],
        };
        let room_len = room.len();
        let mut collecting = Collecting {
            visitor,
            room,
            found: 0,
        };
        let walk = two.walk(stack, &mut collecting)?;
        let found = collecting.found;
        if margin.is_some() && found > room_len {
            self.pause = PAUSE;
        }
        let whole = found <= room_len && !walk.stopped;
        self.keep(found, moved, margin.filter(|_| whole));
        Ok((walk, found))
    }

    /// How far the two have moved since the last query for the same pair and tolerance; for others
    /// everything is forgotten.
    fn step_to(&mut self, motions: [&Motion; 2], tolerance: f64, moved: f64) -> f64 {
        let of = Identity {
            starts: motions.map(Motion::start),
            tolerance,
        };
        if self.of != Some(of) || moved < self.moved {
            self.of = Some(of);
            self.until = f64::NEG_INFINITY;
            self.moved = moved;
            (self.steps, self.served, self.pause) = (STEPS, FRESH, 0);
        }
        let step = moved - self.moved;
        self.moved = moved;
        step
    }

    /// The margin of the front to be made, if one is worth it.
    fn next_margin(&mut self, step: f64) -> Option<f64> {
        if self.pause > 0 {
            self.pause -= 1;
            return None;
        }
        if self.served < SERVED_MIN {
            (self.steps, self.served, self.pause) = (STEPS, FRESH, PAUSE);
            return None;
        }
        let margin = step * self.steps;
        margin.is_finite().then_some(margin)
    }

    /// Keeps a front of `len` pairs that was made with a margin, none without one.
    fn keep(&mut self, len: usize, moved: f64, margin: Option<f64>) {
        let Some(margin) = margin else {
            self.until = f64::NEG_INFINITY;
            return;
        };
        self.len = len;
        // Sums of motions have lost far less.
        self.until = moved + margin * (1.0 - f64::from(f32::EPSILON));
        self.served = 0;
        self.steps = if len == 0 {
            (2.0 * self.steps).min(STEPS_APART)
        } else {
            STEPS
        };
    }
}

/// Takes down the pairs of leaves that a walk meets.
struct Collecting<'s> {
    visitor: &'s mut (dyn PairVisitor + 's),
    room: &'s mut [FrontSlot],
    /// How many there were, with room or without.
    found: usize,
}

impl PairVisitor for Collecting<'_> {
    fn tolerance(&self) -> f64 {
        self.visitor.tolerance()
    }

    fn meet(&mut self, leaves: &[FrontSlot]) {
        let rest = self.room.get_mut(self.found..).unwrap_or_default();
        for (slot, leaves) in rest.iter_mut().zip(leaves) {
            *slot = *leaves;
        }
        self.found += leaves.len();
    }

    fn triangles(&mut self, ids: [TriangleId; 2], corners: [&Triangle; 2]) -> ControlFlow<()> {
        self.visitor.triangles(ids, corners)
    }
}
