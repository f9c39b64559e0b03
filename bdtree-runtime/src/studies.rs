//! What was built, measured, and found not worth using; its mathematics stays tested.
//!
//! * *Temporal updates* (paper, eqs. 8–11): spheres of an earlier pose, grown by δR ‖q − q₀‖. They save 5 % of a
//!   query's time at best and are looser than spheres evaluated anew (docs/design/decisions/keeping-a-step.md).
//! * *Poses within a tolerance*: node bounds that leave out the modes that matter least. Each visit costs less,
//!   and there are more of them; no asset was found where that pays.

use crate::bones::{BoneMatrices, BoneSource};
use crate::cache::StepCache;
use crate::error::{PoseError, QueryError};
use crate::pose::Pose;
use crate::query::Query;
use crate::transform::Transform;
use crate::view::Asset;

/// [`Asset::pose`] with node bounds that leave out the modes that matter least: two by two, in the order of
/// the asset, as long as those left out move no vertex by more than `tolerance` together (world
/// units). Spheres become larger by what they move. Queries answer as they do for
/// other poses, since triangles have all modes; they visit more nodes, each of which costs
/// less.
///
/// # Errors
/// Those of [`Asset::pose`]; a tolerance that is NaN or negative.
pub fn pose_within<'p>(
    asset: &'p Asset<'p>,
    q: &[f32],
    at: impl Into<Transform>,
    tolerance: f64,
    memory: &'p mut [f32],
) -> Result<Pose<'p>, PoseError> {
    let rest = BoneSource::Matrices(BoneMatrices::Rest);
    asset.pose_within(q, rest, at.into(), tolerance, memory)
}

/// Lets a cache serve later poses of the asset it was started with: counts a step, in which leaves are
/// deformed anew and nodes are kept. Each query of the step then [`follow`]s.
pub fn next_step(cache: &mut StepCache<'_>, reference: &Pose<'_>) {
    if !cache.follow() {
        cache.start(reference); // the count began anew and everything is forgotten
    }
}

/// A query with the node spheres of the last [`StepCache::start`], whose pose was `reference`:
/// they grow by δR ‖q − q₀‖, one multiply-add per sphere instead of a node update (paper, eq. 8);
/// nodes first visited now are evaluated at `reference` too, so that errors do not add up over
/// steps. Spheres are looser than evaluated ones: start again when [`growth`] is no longer small
/// beside the radius of a leaf. Where `reference` is not the pose of the last start, or one of another asset,
/// questions return [`QueryError::Cache`].
pub fn follow<'q, 'm>(
    mut query: Query<'q, 'm>,
    cache: &'q mut StepCache<'_>,
    reference: &'q Pose<'q>,
) -> Query<'q, 'm> {
    query.side.follow(cache, reference);
    query
}

/// What following a reference has added to the radii of the root's lanes, at most (world units):
/// about as much as to all others, since δR hardly shrinks with depth.
///
/// # Errors
/// A corrupt asset.
pub fn growth(query: &mut Query<'_, '_>) -> Result<f64, QueryError> {
    query.side.growth()
}
