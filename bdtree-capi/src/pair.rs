//! Questions about two instances.
#![allow(unsafe_code)] // names of functions: docs/design/unsafe.md

use std::ffi::c_void;

use bdtree_runtime::{PairContact, PairFront, PairQuery, Proxy, QueryError};

use crate::answers::{BdtIndexPair, BdtLanePair, BdtLaneTriangle, BdtManifold, BdtPairContact};
use crate::border::{Handle, Kind, Out, call, done, give};
use crate::instance::BdtInstance;
use crate::query::bounded;
use crate::sink::{Array, Callback};
use crate::status::{BdtStatus, Fault};
use crate::workspace::{BdtWorkspace, Desk, VISITS, not_asked};

/// What a pair of instances keeps from step to step: `bdt_pair_contacts`, `bdt_pair_triangles`, `bdt_pair_intersects` and
/// `bdt_pair_manifolds` give the same answers with it, and visit no node until the two have moved by a margin. Keep the
/// order of the pair. One thread at a time may use it.
pub struct BdtFront {
    _opaque: [u8; 0],
}

impl Kind for BdtFront {
    type Value = PairFront<'static>;
    const TAG: u64 = u64::from_le_bytes(*b"bdtFRONT");
    const NAME: &'static str = "front";
}

/// Makes a front.
/// Ownership: `*out` is yours, to be freed by `bdt_front_free`; NULL on errors.
/// Errors: `BDT_STATUS_ERROR_NULL`. Thread-safety: any thread.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_front_new(mut out: Out<*mut BdtFront>) -> BdtStatus {
    give(&mut out, || Ok(PairFront::new()))
}

/// Frees a front. NULL is nothing.
/// Errors: `BDT_STATUS_ERROR_HANDLE`, `_BUSY` (from a callback of a call that uses it). Thread-safety: no other thread
/// may use the handle meanwhile or afterwards.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_front_free(front: Handle<BdtFront>) -> BdtStatus {
    done(|| front.free())
}

/// Two instances to ask.
struct Pair<'h> {
    workspace: &'h Handle<BdtWorkspace>,
    instances: [&'h Handle<BdtInstance>; 2],
    front: Option<&'h Handle<BdtFront>>,
    has_callbacks: bool,
}

impl<'h> Pair<'h> {
    fn new(
        workspace: &'h Handle<BdtWorkspace>,
        first: &'h Handle<BdtInstance>,
        second: &'h Handle<BdtInstance>,
    ) -> Self {
        Self {
            workspace,
            instances: [first, second],
            front: None,
            has_callbacks: false,
        }
    }

    /// With what is kept from step to step, unless it is NULL.
    fn front(mut self, front: &'h Handle<BdtFront>) -> Self {
        self.front = (!front.address().is_null()).then_some(front);
        self
    }

    /// The question calls the program.
    fn with_callbacks(mut self) -> Self {
        self.has_callbacks = true;
        self
    }

    fn ask<T>(
        &self,
        question: impl FnOnce(&mut PairQuery<'_, '_, 'static>) -> Result<T, QueryError>,
    ) -> Result<T, Fault> {
        self.within(|max_visits, mut query| {
            if max_visits.is_some() {
                return Err(Fault::Argument(VISITS));
            }
            Ok(question(&mut query)?)
        })
    }

    /// The question gets the limit of visits, and what to ask.
    fn within<T>(
        &self,
        question: impl FnOnce(Option<u64>, PairQuery<'_, '_, 'static>) -> Result<T, Fault>,
    ) -> Result<T, Fault> {
        // As in `ask` for one instance.
        let (mut question, mut answer) = (Some(question), None);
        self.put_question(&mut |max_visits, query| {
            if let Some(question) = question.take() {
                answer = Some(question(max_visits, query)?);
            }
            Ok(())
        })?;
        answer.ok_or_else(not_asked)
    }

    fn put_question(&self, question: &mut Question<'_>) -> Result<(), Fault> {
        let [first, second] = self.instances;
        if first.address() == second.address() && !first.address().is_null() {
            // The handle itself is checked first.
            first.shared()?;
            return Err(Fault::Busy("instance"));
        }
        let mut desk = self.workspace.exclusive()?;
        desk.clear();
        let Desk {
            memory,
            is_shared,
            levels,
            max_visits,
            proxies,
            stats,
            ..
        } = &mut *desk;
        let mut front = self.front.map(Handle::exclusive).transpose()?;
        let front = front.as_deref_mut();
        let answer = if *is_shared {
            let (one, two) = (
                first.reading(self.has_callbacks)?,
                second.reading(self.has_callbacks)?,
            );
            let (pose1, pose2) = (one.pose(), two.pose());
            let query = pose1.against(&pose2, memory);
            question(*max_visits, options(query, *levels, proxies, front))
        } else {
            let (mut one, mut two) = (first.exclusive()?, second.exclusive()?);
            let query = one.against(&mut two, memory);
            question(*max_visits, options(query, *levels, proxies, front))
        };
        *stats = memory.stats();
        answer
    }
}

/// [`Pair::within`]'s, of any answer.
type Question<'q> = dyn FnMut(Option<u64>, PairQuery<'_, '_, 'static>) -> Result<(), Fault> + 'q;

fn options<'q, 'm>(
    mut query: PairQuery<'q, 'm, 'static>,
    [level1, level2]: [Option<usize>; 2],
    [proxies1, proxies2]: &'q mut [Vec<Proxy>; 2],
    front: Option<&'q mut PairFront<'static>>,
) -> PairQuery<'q, 'm, 'static> {
    if let Some(level) = level1 {
        query = query.max_level1(level, proxies1);
    }
    if let Some(level) = level2 {
        query = query.max_level2(level, proxies2);
    }
    match front {
        Some(front) => query.front(front),
        None => query,
    }
}

/// Writes every pair of triangles, one of each instance, whose distance is at most `prediction` (world), with points and
/// normals; at 0 those that share a point. Arrays as in `bdt_contacts`.
/// `front`: of this pair of instances, or NULL.
/// Errors: `BDT_STATUS_TRUNCATED`, `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY` (also if both instances are the same one),
/// `_ARGUMENT`, `_FORMAT` (a damaged file). Thread-safety: one thread at a time per workspace, front and instance
/// (`bdt_workspace_set_shared`).
#[unsafe(no_mangle)]
pub extern "C" fn bdt_pair_contacts(
    workspace: Handle<BdtWorkspace>,
    first: Handle<BdtInstance>,
    second: Handle<BdtInstance>,
    front: Handle<BdtFront>,
    prediction: f64,
    mut out: Out<BdtPairContact>,
    capacity: usize,
    mut count: Out<usize>,
) -> BdtStatus {
    call(|| {
        let mut array = Array::new(&mut out, capacity, &mut count)?;
        Pair::new(&workspace, &first, &second)
            .front(&front)
            .ask(|query| query.contacts(prediction, &mut array))?;
        array.end(&mut count)
    })
}

/// Takes a contact of two instances, as `BdtOnContact` a contact.
pub type BdtOnPairContact =
    Option<extern "C" fn(contact: *const BdtPairContact, context: *mut c_void) -> i32>;

/// Hands every pair of triangles that `bdt_pair_contacts` would write to a callback, with `context`.
/// Errors: `BDT_STATUS_STOPPED`; those of `bdt_pair_contacts`. Thread-safety: as `bdt_pair_contacts`; the callback is
/// called by this thread.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_pair_contacts_each(
    workspace: Handle<BdtWorkspace>,
    first: Handle<BdtInstance>,
    second: Handle<BdtInstance>,
    front: Handle<BdtFront>,
    prediction: f64,
    callback: BdtOnPairContact,
    context: *mut c_void,
) -> BdtStatus {
    call(|| {
        let mut sink = Callback::<BdtPairContact>::new(callback, context)?;
        Pair::new(&workspace, &first, &second)
            .front(&front)
            .with_callbacks()
            .ask(|query| query.contacts(prediction, &mut sink))?;
        Ok(sink.end())
    })
}

/// Writes which pairs of triangles `bdt_pair_contacts` would write, without their points: several times faster where many
/// touch.
/// Errors and thread-safety: as `bdt_pair_contacts`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_pair_triangles(
    workspace: Handle<BdtWorkspace>,
    first: Handle<BdtInstance>,
    second: Handle<BdtInstance>,
    front: Handle<BdtFront>,
    prediction: f64,
    mut out: Out<BdtIndexPair>,
    capacity: usize,
    mut count: Out<usize>,
) -> BdtStatus {
    call(|| {
        let mut array = Array::new(&mut out, capacity, &mut count)?;
        Pair::new(&workspace, &first, &second)
            .front(&front)
            .ask(|query| query.triangle_pairs(prediction, &mut array))?;
        array.end(&mut count)
    })
}

/// Writes 1 if any two triangles share a point, else 0; ends with the first pair that is found.
/// Errors and thread-safety: as `bdt_pair_contacts`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_pair_intersects(
    workspace: Handle<BdtWorkspace>,
    first: Handle<BdtInstance>,
    second: Handle<BdtInstance>,
    front: Handle<BdtFront>,
    mut is_touching: Out<i32>,
) -> BdtStatus {
    done(|| {
        let found = Pair::new(&workspace, &first, &second)
            .front(&front)
            .ask(|query| query.intersects())?;
        is_touching.one("is_touching")?.write(i32::from(found));
        Ok(())
    })
}

/// Writes the nearest two triangles, one of each instance, and where they are nearest, if that is within `max_distance`
/// (world; may be INFINITY); else `BdtPairContact::triangle1` is `BDT_NONE`.
/// Errors: those of `bdt_pair_contacts`; `_ARGUMENT` with a limit of levels. Thread-safety: as `bdt_pair_contacts`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_pair_closest_points(
    workspace: Handle<BdtWorkspace>,
    first: Handle<BdtInstance>,
    second: Handle<BdtInstance>,
    max_distance: f64,
    mut out: Out<BdtPairContact>,
) -> BdtStatus {
    done(|| {
        let pair = Pair::new(&workspace, &first, &second);
        let (found, bound) = pair.within(|max_visits, mut query| match max_visits {
            None => Ok((query.closest_points(max_distance)?, None)),
            Some(visits) => {
                let found = query.max_visits(visits).closest_points(max_distance)?;
                let (found, bound) = bounded(found);
                Ok((found, Some(bound)))
            }
        })?;
        if let Some(bound) = bound {
            workspace.exclusive()?.bound = bound;
        }
        out.one("out")?.write(found.into());
        Ok(())
    })
}

/// Writes the distance of the two meshes (world) if it is within `max_distance` (which may be INFINITY), else -1.
/// Errors and thread-safety: as `bdt_pair_closest_points`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_pair_distance(
    workspace: Handle<BdtWorkspace>,
    first: Handle<BdtInstance>,
    second: Handle<BdtInstance>,
    max_distance: f64,
    mut distance: Out<f64>,
) -> BdtStatus {
    done(|| {
        let found =
            Pair::new(&workspace, &first, &second).ask(|query| query.distance(max_distance))?;
        distance.one("distance")?.write(found.unwrap_or(-1.0));
        Ok(())
    })
}

/// Writes one manifold per connected region of contact: `bdt_pair_contacts`, condensed to one point or four with normal,
/// area and depth. Both surfaces must list their corners counterclockwise as seen from outside, or both clockwise.
/// `prediction` 0: only triangles that touch form regions. Arrays as in `bdt_contacts`. `front`: of this pair, or NULL.
/// Errors: those of `bdt_pair_contacts`; `_ARGUMENT` with a limit of levels. Thread-safety: as `bdt_pair_contacts`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_pair_manifolds(
    workspace: Handle<BdtWorkspace>,
    first: Handle<BdtInstance>,
    second: Handle<BdtInstance>,
    front: Handle<BdtFront>,
    prediction: f64,
    mut out: Out<BdtManifold>,
    capacity: usize,
    mut count: Out<usize>,
) -> BdtStatus {
    call(|| {
        let mut array = Array::new(&mut out, capacity, &mut count)?;
        Pair::new(&workspace, &first, &second)
            .front(&front)
            .ask(|query| query.contact_manifolds(prediction, &mut array))?;
        array.end(&mut count)
    })
}

/// Writes the manifolds of `pair_count` contacts that `bdt_pair_contacts` has written: all of them, in any order. They are
/// only read.
/// Errors: those of `bdt_pair_contacts`; `_ARGUMENT` for triangles that the models do not have. Thread-safety: as
/// `bdt_pair_contacts`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_pair_condense(
    workspace: Handle<BdtWorkspace>,
    first: Handle<BdtInstance>,
    second: Handle<BdtInstance>,
    pairs: crate::border::In<BdtPairContact>,
    pair_count: usize,
    mut out: Out<BdtManifold>,
    capacity: usize,
    mut count: Out<usize>,
) -> BdtStatus {
    call(|| {
        let mut pairs: Vec<PairContact> = crate::sink::converted(&pairs, pair_count, "pairs")?;
        let mut array = Array::new(&mut out, capacity, &mut count)?;
        Pair::new(&workspace, &first, &second)
            .ask(|query| query.condense(&mut pairs, &mut array))?;
        array.end(&mut count)
    })
}

/// Writes the pairs of lanes, one of each tree, whose spheres are at most `prediction` apart (world), of `level1` and
/// `level2` (0 is the root's) and leaf lanes above them; no triangles are looked at. `reach`: what a sphere of the one and
/// a sphere of the other together stick out of those above them; with 0 some pairs may be missing, but all triangles
/// within `prediction` lie in a reported pair. Arrays as in `bdt_contacts`.
/// Errors: those of `bdt_pair_contacts`; `_ARGUMENT` with a limit of levels. Thread-safety: as `bdt_pair_contacts`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_pair_level_spheres(
    workspace: Handle<BdtWorkspace>,
    first: Handle<BdtInstance>,
    second: Handle<BdtInstance>,
    level1: u32,
    level2: u32,
    prediction: f64,
    reach: f64,
    mut out: Out<BdtLanePair>,
    capacity: usize,
    mut count: Out<usize>,
) -> BdtStatus {
    call(|| {
        let mut array = Array::new(&mut out, capacity, &mut count)?;
        let levels = [level1, level2].map(|level| level as usize);
        Pair::new(&workspace, &first, &second)
            .ask(|query| query.level_spheres(levels, prediction, reach, &mut array))?;
        array.end(&mut count)
    })
}

/// Writes pairs of a lane of the first tree, of `level` or a leaf lane above it, and a triangle of the second mesh that is
/// at most `prediction` (world) from the lane's sphere. `reach`: as in `bdt_pair_level_spheres`, of the first mesh alone.
/// Arrays as in `bdt_contacts`.
/// Errors and thread-safety: as `bdt_pair_level_spheres`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_pair_level_triangles(
    workspace: Handle<BdtWorkspace>,
    first: Handle<BdtInstance>,
    second: Handle<BdtInstance>,
    level: u32,
    prediction: f64,
    reach: f64,
    mut out: Out<BdtLaneTriangle>,
    capacity: usize,
    mut count: Out<usize>,
) -> BdtStatus {
    call(|| {
        let mut array = Array::new(&mut out, capacity, &mut count)?;
        Pair::new(&workspace, &first, &second)
            .ask(|query| query.level_triangles(level as usize, prediction, reach, &mut array))?;
        array.end(&mut count)
    })
}
