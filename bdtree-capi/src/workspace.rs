//! Workspaces: the memory of queries, and how they look.
#![allow(unsafe_code)] // names of functions: docs/design/unsafe.md

use bdtree_runtime::{BudgetedQuery, Proxy, Query, QueryError, Stats, Workspace};

use crate::answers::{BdtBound, BdtProxy, BdtStats};
use crate::border::{Handle, Kind, Out, call, done, give};
use crate::instance::BdtInstance;
use crate::sink::put_items;
use crate::status::{BdtStatus, Fault};

/// The memory that queries work in, how they look, and what the last one did. One serves any number of models and
/// instances; one thread at a time may use it: keep one per thread.
pub struct BdtWorkspace {
    _opaque: [u8; 0],
}

/// What a workspace owns.
pub struct Desk {
    pub(crate) memory: Workspace<'static>,
    /// Instances are only read.
    pub(crate) is_shared: bool,
    /// Where queries end, of the first and of the second mesh.
    pub(crate) levels: [Option<usize>; 2],
    pub(crate) max_visits: Option<u64>,
    /// Of the last query.
    pub(crate) proxies: [Vec<Proxy>; 2],
    pub(crate) bound: BdtBound,
    pub(crate) stats: Stats,
}

pub(crate) const VISITS: &str = "max_visits: this query has no such limit";

/// Of a query without a limit of visits.
const COMPLETE: BdtBound = BdtBound {
    is_complete: 1,
    reserved: 0,
    at_least: 0.0,
    unseen_triangles: 0,
};

impl Desk {
    /// Forgets what the query before has left.
    #[inline]
    pub(crate) fn clear(&mut self) {
        self.proxies.iter_mut().for_each(Vec::clear);
        self.bound = COMPLETE;
    }
}

impl Kind for BdtWorkspace {
    type Value = Desk;
    const TAG: u64 = u64::from_le_bytes(*b"bdtWORKS");
    const NAME: &'static str = "workspace";
}

/// Makes a workspace. It grows to what the largest query so far has needed.
/// Ownership: `*out` is yours, to be freed by `bdt_workspace_free`; NULL on errors.
/// Errors: `BDT_STATUS_ERROR_NULL`. Thread-safety: any thread.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_workspace_new(mut out: Out<*mut BdtWorkspace>) -> BdtStatus {
    give(&mut out, || {
        Ok(Desk {
            memory: Workspace::new(),
            is_shared: false,
            levels: [None; 2],
            max_visits: None,
            proxies: [Vec::new(), Vec::new()],
            bound: COMPLETE,
            stats: Stats::default(),
        })
    })
}

/// Frees a workspace. NULL is nothing.
/// Errors: `BDT_STATUS_ERROR_HANDLE`, `_BUSY` (from a callback of a call that uses it). Thread-safety: no other thread
/// may use the handle meanwhile or afterwards.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_workspace_free(workspace: Handle<BdtWorkspace>) -> BdtStatus {
    done(|| workspace.free())
}

/// Says whether queries with this workspace only read instances (`is_shared` not 0), so that several threads, each with a
/// workspace of its own, may ask the same instance at once; nobody may set it meanwhile. Without (the default) a query
/// uses the instance's step cache and has the instance for itself. Answers are the same.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`. Thread-safety: one thread at a time per workspace.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_workspace_set_shared(
    workspace: Handle<BdtWorkspace>,
    is_shared: i32,
) -> BdtStatus {
    done(|| {
        workspace.exclusive()?.is_shared = is_shared != 0;
        Ok(())
    })
}

/// Ends the queries of this workspace at a level of the tree (0 is the root's) of the first and of the second mesh; below
/// 0: without a limit (the default). Of every subtree below that a query cannot rule out it then reports a sphere:
/// `bdt_workspace_proxies`. So every triangle of the full answer is reported or lies in such a sphere.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`. Thread-safety: one thread at a time per workspace.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_workspace_set_max_levels(
    workspace: Handle<BdtWorkspace>,
    first: i32,
    second: i32,
) -> BdtStatus {
    done(|| {
        workspace.exclusive()?.levels = [first, second].map(|level| usize::try_from(level).ok());
        Ok(())
    })
}

/// Limits the node visits of `bdt_cast_ray`, `bdt_project_point`, `bdt_contacts` with a ball and
/// `bdt_pair_closest_points`, the most promising first; 0: without a limit (the default). `bdt_workspace_bound` says what
/// an answer may have missed. Other queries return `BDT_STATUS_ERROR_ARGUMENT` while there is a limit.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`. Thread-safety: one thread at a time per workspace.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_workspace_set_max_visits(
    workspace: Handle<BdtWorkspace>,
    max_visits: u64,
) -> BdtStatus {
    done(|| {
        workspace.exclusive()?.max_visits = (max_visits > 0).then_some(max_visits);
        Ok(())
    })
}

/// Writes the spheres at which the last query ended, of the first mesh (`side` 0) or the second (1). In queries of two
/// meshes sphere k of one and sphere k of the other belong together.
/// `out`: room for `capacity` spheres; `count`: how many there are.
/// Errors: `BDT_STATUS_TRUNCATED`, `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_INDEX`. Thread-safety: one thread at a
/// time per workspace.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_workspace_proxies(
    workspace: Handle<BdtWorkspace>,
    side: usize,
    mut out: Out<BdtProxy>,
    capacity: usize,
    mut count: Out<usize>,
) -> BdtStatus {
    call(|| {
        let desk = workspace.shared()?;
        let proxies = desk.proxies.get(side);
        let proxies = proxies.ok_or(crate::model::missing("side", 2, side))?;
        let proxies = proxies.iter().map(|proxy| BdtProxy::from(*proxy));
        put_items(proxies, &mut out, capacity, &mut count)
    })
}

/// Writes what the last query may have missed because of `bdt_workspace_set_max_visits`.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`. Thread-safety: one thread at a time per workspace.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_workspace_bound(
    workspace: Handle<BdtWorkspace>,
    mut out: Out<BdtBound>,
) -> BdtStatus {
    done(|| {
        out.one("out")?.write(workspace.shared()?.bound);
        Ok(())
    })
}

/// Writes how many nodes the last query looked at, of several rays together.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`. Thread-safety: one thread at a time per workspace.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_workspace_stats(
    workspace: Handle<BdtWorkspace>,
    mut out: Out<BdtStats>,
) -> BdtStatus {
    done(|| {
        out.one("out")?.write(workspace.shared()?.stats.into());
        Ok(())
    })
}

/// A question about to be asked.
pub(crate) struct Asked<'q, 'm> {
    /// Until it is asked with a limit of visits.
    query: Option<Query<'q, 'm>>,
    max_visits: Option<u64>,
    bound: &'q mut BdtBound,
    /// What several queries of one call did together.
    sum: Option<Stats>,
}

impl<'q, 'm> Asked<'q, 'm> {
    /// One that has no limit of visits.
    #[inline]
    pub(crate) fn whole<T>(
        &mut self,
        question: impl FnOnce(&mut Query<'q, 'm>) -> Result<T, QueryError>,
    ) -> Result<T, Fault> {
        if self.max_visits.is_some() {
            return Err(Fault::Argument(VISITS));
        }
        self.plain(question)
    }

    /// Several that have no limit of visits; they add up what they do.
    #[inline]
    pub(crate) fn summed<T>(
        &mut self,
        questions: impl FnOnce(&mut Query<'q, 'm>, &mut Stats) -> Result<T, QueryError>,
    ) -> Result<T, Fault> {
        let mut sum = Stats::default();
        let answer = self.whole(|query| questions(query, &mut sum));
        self.sum = Some(sum);
        answer
    }

    #[inline]
    fn plain<T>(
        &mut self,
        question: impl FnOnce(&mut Query<'q, 'm>) -> Result<T, QueryError>,
    ) -> Result<T, Fault> {
        let query = self.query.as_mut().ok_or_else(not_asked)?;
        Ok(question(query)?)
    }

    /// One with a limit of visits or without: the second closure asks within a limit and says what it may have missed.
    #[inline]
    pub(crate) fn either<T>(
        &mut self,
        question: impl FnOnce(&mut Query<'q, 'm>) -> Result<T, QueryError>,
        within: impl FnOnce(&mut BudgetedQuery<'q, 'm>) -> Result<(T, BdtBound), QueryError>,
    ) -> Result<T, Fault> {
        if self.has_limit() {
            return self.within(within);
        }
        self.plain(question)
    }

    #[inline]
    pub(crate) fn has_limit(&self) -> bool {
        self.max_visits.is_some()
    }

    /// One with a limit of visits.
    pub(crate) fn within<T>(
        &mut self,
        question: impl FnOnce(&mut BudgetedQuery<'q, 'm>) -> Result<(T, BdtBound), QueryError>,
    ) -> Result<T, Fault> {
        let max_visits = self.max_visits.unwrap_or(u64::MAX);
        let query = self.query.take().ok_or_else(not_asked)?;
        let (answer, bound) = question(&mut query.max_visits(max_visits))?;
        *self.bound = bound;
        Ok(answer)
    }
}

/// Asks an instance, as the workspace says: with its step cache or only reading it, down to a level or all.
/// `has_callbacks`: whether the question calls the program.
#[inline]
pub(crate) fn ask<T>(
    workspace: &Handle<BdtWorkspace>,
    instance: &Handle<BdtInstance>,
    has_callbacks: bool,
    question: impl FnOnce(&mut Asked<'_, '_>) -> Result<T, Fault>,
) -> Result<T, Fault> {
    // Through pointers, so that what comes before and after a question is compiled once for all of them, and none is copied.
    let (mut question, mut answer) = (Some(question), None);
    put_question(workspace, instance, has_callbacks, &mut |asked| {
        if let Some(question) = question.take() {
            answer = Some(question(asked)?);
        }
        Ok(())
    })?;
    answer.ok_or_else(not_asked)
}

/// Never seen: a question that is put is asked, once.
pub(crate) fn not_asked() -> Fault {
    Fault::Panic("a question was not asked once".to_string())
}

/// [`ask`] for any question.
fn put_question(
    workspace: &Handle<BdtWorkspace>,
    instance: &Handle<BdtInstance>,
    has_callbacks: bool,
    question: &mut dyn FnMut(&mut Asked<'_, '_>) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let mut desk = workspace.exclusive()?;
    desk.clear();
    let Desk {
        memory,
        is_shared,
        levels: [level, _],
        max_visits,
        proxies: [proxies, _],
        bound,
        stats,
    } = &mut *desk;
    let limit = level.map(|level| (level, proxies));
    let mut sum = None;
    let put = |query| {
        let mut asked = Asked {
            query: Some(to_level(query, limit)),
            max_visits: *max_visits,
            bound,
            sum: None,
        };
        let answer = question(&mut asked);
        sum = asked.sum;
        answer
    };
    let answer = if *is_shared {
        let instance = instance.reading(has_callbacks)?;
        put(instance.snapshot().query(memory))
    } else {
        let mut instance = instance.exclusive()?;
        put(instance.query(memory))
    };
    *stats = sum.unwrap_or_else(|| memory.stats());
    answer
}

#[inline]
fn to_level<'q, 'm>(
    query: Query<'q, 'm>,
    limit: Option<(usize, &'q mut Vec<Proxy>)>,
) -> Query<'q, 'm> {
    match limit {
        None => query,
        Some((level, proxies)) => query.max_level(level, proxies),
    }
}
