//! Many rays.

use bdtree_runtime::{Query, QueryError, Ray, RayIntersection};

use super::lines::Answer;
use crate::scene::RaysMode;

/// What the rays meet.
pub(super) fn solve(
    query: &mut Query<'_, '_>,
    mode: RaysMode,
    rays: &[Ray],
) -> Result<Answer, QueryError> {
    Ok(match mode {
        RaysMode::First => {
            let mut hits = vec![None; rays.len()];
            query.cast_rays(rays, &mut hits)?;
            let hits = hits.into_iter().map(Into::into).collect();
            Answer::First { hits }
        }
        RaysMode::Any => {
            let mut hits = vec![false; rays.len()];
            query.intersects_rays(rays, &mut hits)?;
            Answer::Any { hits }
        }
        RaysMode::All => {
            let mut found: Vec<(usize, RayIntersection)> = Vec::new();
            query.cast_rays_all(rays, &mut found)?;
            found.sort_by(|(i, a), (j, b)| {
                let by_distance = a.distance.total_cmp(&b.distance);
                i.cmp(j).then(by_distance).then(a.triangle.cmp(&b.triangle))
            });
            let mut hits: Vec<Vec<_>> = rays.iter().map(|_| Vec::new()).collect();
            for (i, hit) in found {
                hits[i].push(Some(hit).into());
            }
            Answer::All { hits }
        }
    })
}
