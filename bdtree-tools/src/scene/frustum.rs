//! The planes of a frustum query.

use bdtree_runtime::Frustum;
use bdtree_runtime::narrow::frustum_triangle::FRUSTUM_PLANES_MAX;

use super::fields::{At, Fields, Problems};

/// Planes `[n_x, n_y, n_z, d]`, from 1 to [`FRUSTUM_PLANES_MAX`].
pub(super) fn read_frustum(fields: &Fields<'_>, problems: &mut Problems) -> Option<Frustum> {
    let list = fields.required("planes", problems)?;
    let items = list.items(problems)?;
    if items.is_empty() || items.len() > FRUSTUM_PLANES_MAX {
        let found = items.len();
        let message = format_args!("expected 1 to {FRUSTUM_PLANES_MAX} planes, found {found}");
        problems.add(&list.place, message);
        return None;
    }
    let planes: Vec<[f64; 4]> = items
        .iter()
        .filter_map(|item| read_plane(item, problems))
        .collect();
    (planes.len() == items.len()).then(|| Frustum::new(&planes))?
}

fn read_plane(item: &At<'_>, problems: &mut Problems) -> Option<[f64; 4]> {
    let numbers = item.numbers(problems)?;
    let Ok(plane) = <[f64; 4]>::try_from(numbers.as_slice()) else {
        let message = format_args!("expected 4 numbers, found {}", numbers.len());
        problems.add(&item.place, message);
        return None;
    };
    if plane[..3] == [0.0; 3] {
        problems.add(&item.place, "zero vector");
        return None;
    }
    if Frustum::new(&[plane]).is_none() {
        problems.add(&item.place, "farther than 2^100 from the origin");
        return None;
    }
    Some(plane)
}
