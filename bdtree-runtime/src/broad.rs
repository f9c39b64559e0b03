//! The broad phase: which of many instances may touch, from their root spheres alone.
//!
//! The paper (4) sorts root spheres into a uniform subdivision at each step. Here every sphere goes
//! into the cell of a grid for spheres of its size, within a factor of two, so that one giant does
//! not make the cells of the many small ones too large: at most a few spheres can lie in a cell
//! without touching each other. Cost: O(n + pairs found) for spheres of similar size, times the
//! number of different sizes otherwise.

use core::ops::ControlFlow;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

use crate::contact::{Coverage, Sink};
use crate::error::QueryError;
#[cfg(feature = "alloc")]
use crate::instance::Instance;
use crate::math::{dot, sub};
use crate::query::{ARGUMENT_MAX, BoundingSphere, length};
use crate::rounding::{CELL_ROUNDING, CELL_SHARE, MARGIN};
use crate::workspace::{Stats, Workspace};

/// Memory for the grids.
#[derive(Debug, Clone, Copy, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
struct GridSlot {
    /// Of the sphere with the slot's index: hash of its cell, and in the low bits its level.
    cell: u64,
    /// The sphere with the slot's index: the one that was put into its bucket before it.
    next: u32,
    /// The bucket with the slot's index: the sphere that was put into it last.
    newest: u32,
}

impl GridSlot {
    /// A slot to fill memory with.
    const EMPTY: Self = Self {
        cell: 0,
        next: NONE,
        newest: NONE,
    };
}

/// No sphere.
const NONE: u32 = u32::MAX;

/// Sizes that have a grid of their own, each half of the one before; the last takes all below.
const LEVELS: usize = 64;

/// The bits of [`GridSlot::cell`] that are the level.
const LEVEL_BITS: u64 = LEVELS as u64 - 1;

/// Width of a cell over the largest diameter of its level: then a sphere looks into at most two cells
/// along each axis, with 1 into three.
const CELL_DIAMETERS: f64 = 2.0;

/// Slots that `count` spheres need: at most four each.
const fn grid_slots(count: usize) -> usize {
    match count.saturating_mul(2).checked_next_power_of_two() {
        Some(slots) => slots,
        None => usize::MAX, // more than memory holds
    }
}

/// Bytes of a workspace that suffice for [`pairs`] of `count` spheres. `instance_pairs` needs 32 more for each.
pub const fn bytes_for(count: usize) -> usize {
    grid_slots(count)
        .saturating_mul(size_of::<GridSlot>())
        .saturating_add(align_of::<GridSlot>())
}

/// Reports every pair of spheres that are at most `prediction` apart, as two ascending indices, once:
/// the pairs that may touch where the spheres are [`Pose::bounding_sphere`](crate::Pose::bounding_sphere)s. A pair
/// that is farther apart by a rounding error may be among them. The order is the same for the same
/// spheres, but not sorted. [`Workspace::stats`] tells how many were compared.
///
/// # Errors
/// A coordinate, radius or prediction that is not finite or beyond 2^100, a negative radius or
/// prediction, 2^32 spheres or more, too little memory.
pub fn pairs(
    spheres: &[BoundingSphere],
    prediction: f64,
    workspace: &mut Workspace<'_>,
    out: &mut impl Sink<[usize; 2]>,
) -> Result<Coverage, QueryError> {
    let slots = workspace.memory.slots(grid_slots(spheres.len()))?;
    let (coverage, stats) = search(spheres, prediction, slots, |pair| out.push(pair))?;
    workspace.stats = stats;
    Ok(coverage)
}

/// Reports every pair of instances whose bounding spheres are at most `prediction` apart and whose groups
/// [meet](Instance::may_meet), as [`pairs`] does: what to ask with [`Instance::against`]. Sinks append: clear them
/// yourself.
///
/// # Errors
/// Those of [`pairs`]; a corrupt asset.
#[cfg(feature = "alloc")]
pub fn instance_pairs(
    instances: &[Instance],
    prediction: f64,
    workspace: &mut Workspace<'_>,
    out: &mut impl Sink<[usize; 2]>,
) -> Result<Coverage, QueryError> {
    let count = instances.len();
    let lens = [count, grid_slots(count)];
    let (spheres, slots) = workspace.memory.two_slots::<BoundingSphere, _>(lens)?;
    for (sphere, instance) in spheres.iter_mut().zip(instances) {
        *sphere = instance.bounding_sphere()?;
    }
    let (coverage, stats) = search(spheres, prediction, slots, |[i, j]| {
        if instances[i].may_meet(&instances[j]) {
            out.push([i, j])
        } else {
            ControlFlow::Continue(())
        }
    })?;
    workspace.stats = stats;
    Ok(coverage)
}

fn search(
    spheres: &[BoundingSphere],
    tolerance: f64,
    slots: &mut [GridSlot],
    mut found: impl FnMut([usize; 2]) -> ControlFlow<()>,
) -> Result<(Coverage, Stats), QueryError> {
    let what = "prediction: negative, not finite or beyond 2^100";
    let tolerance = length(tolerance, what)?;
    if u32::try_from(spheres.len()).is_err() {
        return Err(QueryError::Argument("spheres: 2^32 or more"));
    }
    let grids = Grids::new(spheres, tolerance, slots)?;
    let mut search = Search {
        spheres,
        tolerance,
        grids,
        slots,
        stats: Stats::default(),
    };
    let coverage = Coverage::of(search.run(&mut found).is_break());
    Ok((coverage, search.stats))
}

/// One grid per level.
struct Grids {
    /// Exponent of the largest reach.
    top: i32,
    /// The largest reach of each level's spheres; 0 where there are none.
    reaches: [f64; LEVELS],
    /// Cells per unit of length.
    densities: [f64; LEVELS],
}

impl Grids {
    /// Checks the spheres and writes the level of each into its slot.
    fn new(
        spheres: &[BoundingSphere],
        tolerance: f64,
        slots: &mut [GridSlot],
    ) -> Result<Self, QueryError> {
        let mut largest = 0.0_f64;
        for sphere in spheres {
            if !sphere.center.iter().all(|x| x.abs() <= ARGUMENT_MAX) {
                let what = "center of a sphere: not finite or beyond 2^100";
                return Err(QueryError::Argument(what));
            }
            length(
                sphere.radius,
                "radius of a sphere: negative, not finite or beyond 2^100",
            )?;
            largest = largest.max(reach(sphere, tolerance));
        }
        let mut grids = Self {
            top: exponent(largest),
            reaches: [0.0; LEVELS],
            densities: [0.0; LEVELS],
        };
        slots.fill(GridSlot::EMPTY);
        for (sphere, slot) in spheres.iter().zip(slots) {
            let reach = reach(sphere, tolerance);
            let level = grids.level(reach);
            grids.reaches[level] = grids.reaches[level].max(reach);
            slot.cell = level as u64;
        }
        for (density, reach) in grids.densities.iter_mut().zip(&grids.reaches) {
            *density = 1.0 / (2.0 * CELL_DIAMETERS * reach);
        }
        Ok(grids)
    }

    fn level(&self, reach: f64) -> usize {
        ((self.top - exponent(reach)) as usize).min(LEVELS - 1)
    }

    /// The cell of a point. Monotone in each coordinate whatever is rounded, so a sphere between two
    /// points is in a cell between theirs.
    fn cell(&self, point: [f64; 3], level: usize) -> [i64; 3] {
        point.map(|x| floor(x * self.densities[level]))
    }
}

/// Half of what a sphere and the tolerance reach over, and at least what keeps cells apart in f64.
fn reach(sphere: &BoundingSphere, tolerance: f64) -> f64 {
    const LEAST: f64 = f64::from_bits((1023 - 200) << 52);
    let [x, y, z] = sphere.center.map(f64::abs);
    let far = x.max(y).max(z);
    (sphere.radius + 0.5 * tolerance)
        .max(far * CELL_SHARE)
        .max(LEAST)
}

/// Of a positive normal number.
fn exponent(x: f64) -> i32 {
    (x.to_bits() >> 52) as i32 - 1023
}

/// Saturates.
fn floor(x: f64) -> i64 {
    let whole = x as i64;
    if whole as f64 > x { whole - 1 } else { whole }
}

/// Hash of a cell, with its level.
fn hash([x, y, z]: [i64; 3], level: usize) -> u64 {
    let mut h = (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ (y as u64)
            .wrapping_mul(0xc2b2_ae3d_27d4_eb4f)
            .rotate_left(21)
        ^ (z as u64)
            .wrapping_mul(0x1656_67b1_9e37_79f9)
            .rotate_left(42);
    h = (h ^ level as u64 ^ (h >> 32)).wrapping_mul(0xd6e8_feb8_6659_fd93);
    (h ^ (h >> 32)) & !LEVEL_BITS | level as u64
}

struct Search<'s> {
    spheres: &'s [BoundingSphere],
    tolerance: f64,
    grids: Grids,
    /// As many as a power of two, and as buckets.
    slots: &'s mut [GridSlot],
    stats: Stats,
}

impl Search<'_> {
    /// The largest first: every sphere looks at those before it of its own size and at all larger.
    fn run(&mut self, found: &mut impl FnMut([usize; 2]) -> ControlFlow<()>) -> ControlFlow<()> {
        for level in 0..LEVELS {
            if self.grids.reaches[level] == 0.0 {
                continue;
            }
            for i in 0..self.spheres.len() {
                if self.slots[i].cell & LEVEL_BITS != level as u64 {
                    continue;
                }
                for other in 0..=level {
                    if self.grids.reaches[other] > 0.0 {
                        self.look(i, other, found)?;
                    }
                }
                let own = hash(self.grids.cell(self.spheres[i].center, level), level);
                let bucket = self.bucket(own);
                self.slots[i].cell = own;
                self.slots[i].next = self.slots[bucket].newest;
                self.slots[bucket].newest = i as u32;
            }
        }
        ControlFlow::Continue(())
    }

    fn bucket(&self, hash: u64) -> usize {
        (hash / LEVELS as u64) as usize & (self.slots.len() - 1)
    }

    /// Compares sphere `i` with those of a level that are in the grid and in reach.
    fn look(
        &mut self,
        i: usize,
        level: usize,
        found: &mut impl FnMut([usize; 2]) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let sphere = self.spheres[i];
        let reach = self.grids.reaches[level] + reach(&sphere, self.tolerance);
        let far = sphere.center.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        // What the comparison below grants, and the rounding of these sums.
        let reach = reach * (1.0 + 2.0 * MARGIN) + far * CELL_ROUNDING;
        let low = self.grids.cell(sphere.center.map(|x| x - reach), level);
        let high = self.grids.cell(sphere.center.map(|x| x + reach), level);
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                for x in low[0]..=high[0] {
                    self.compare(i, [x, y, z], level, found)?;
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// Compares sphere `i` with those in a cell.
    fn compare(
        &mut self,
        i: usize,
        cell: [i64; 3],
        level: usize,
        found: &mut impl FnMut([usize; 2]) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let sphere = &self.spheres[i];
        let wanted = hash(cell, level);
        let mut j = self.slots[self.bucket(wanted)].newest;
        while let Some(other) = self.spheres.get(j as usize) {
            let slot = &self.slots[j as usize];
            if slot.cell == wanted {
                self.stats.sphere_tests += 1;
                // Another cell of the same hash has its own turn.
                if near(sphere, other, self.tolerance)
                    && self.grids.cell(other.center, level) == cell
                {
                    let j = j as usize;
                    found([i.min(j), i.max(j)])?;
                }
            }
            j = slot.next;
        }
        ControlFlow::Continue(())
    }
}

/// Whether two spheres are not certainly farther apart than the tolerance.
fn near(a: &BoundingSphere, b: &BoundingSphere, tolerance: f64) -> bool {
    let apart = sub(a.center, b.center);
    let reach = a.radius + b.radius + tolerance;
    dot(apart, apart) * (1.0 - MARGIN) <= reach * reach
}
