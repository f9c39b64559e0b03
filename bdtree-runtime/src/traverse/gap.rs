//! How far spheres of two instances are apart, as f32 keys that never say too much.

use bdtree_format::Row;

use super::frontier::SearchEntry;
use crate::bound::WideSpheres;
use crate::cache::Posed;
use crate::math::{norm, scale};
use crate::pair_frame::{PairFrame, PairMap};
use crate::rounding::{BUDGET_FAR, GAP_DISTANCE, GAP_FAR_LOST, GAP_LOST, round_down, round_up};
use crate::simd::Lanes;

/// How distances between spheres of two instances become keys (stored units of the first).
#[derive(Clone, Copy)]
pub(crate) struct Gap {
    pub(super) frame: PairFrame,
    /// Far apart, the direction from the first to the second: keys are gaps along it, less `base`.
    along: Option<[f32; 3]>,
    base: f64,
    unit: f64,
    pub(super) root: SearchEntry,
}

/// Beyond this many times the reach of both, gaps along the line between the origins are tighter
/// than f32 distances.
const FAR: f64 = 1024.0;

impl Gap {
    pub(crate) fn new(a: &Posed<'_>, b: &Posed<'_>) -> Self {
        let map = PairMap::new(a, b);
        let (apart, reach) = (norm(map.offset), map.reach_a + map.reach_b);
        let far = apart > FAR * reach;
        // What rounding may take from a gap (docs/design/guarantees.md, nearest pairs).
        let lost = if far {
            GAP_LOST * reach + GAP_FAR_LOST * apart
        } else {
            GAP_LOST * apart
        };
        let extra = map.exact + map.turned + lost;
        let base = if far { apart } else { 0.0 };
        let offset = if far { [0.0; 3] } else { map.offset };
        let [x, y, z] = offset.map(|x| x as f32);
        let key = round_down(apart - (reach + extra) * (1.0 + GAP_LOST) - base);
        Self {
            frame: map.rounded(offset, extra),
            along: far.then(|| scale(map.offset, 1.0 / apart).map(|x| x as f32)),
            base,
            unit: map.unit_a,
            root: SearchEntry {
                key,
                sphere_a: [0.0, 0.0, 0.0, round_up(map.reach_a)],
                sphere_b: [x, y, z, round_up(map.reach_b + extra)],
                ..SearchEntry::default()
            },
        }
    }

    /// A key above which everything is farther than `distance` (world).
    #[inline(always)]
    pub(crate) fn bound(&self, distance: f64) -> f32 {
        -round_down(self.base - distance / self.unit)
    }

    /// What everything at a key is not nearer than (world).
    pub(crate) fn distance(&self, key: f32) -> f64 {
        let gap = f64::from(key) + self.base * BUDGET_FAR;
        (gap * self.unit * (1.0 - f64::EPSILON)).max(0.0)
    }

    #[inline(always)]
    pub(super) fn keys<L: Lanes>(
        &self,
        spheres: WideSpheres<L>,
        other: [f32; 4],
        of_a: bool,
    ) -> Row {
        match self.along {
            None => spheres.gaps(other, GAP_DISTANCE).store(),
            Some([x, y, z]) => {
                let towards = if of_a { [-x, -y, -z] } else { [x, y, z] };
                spheres.gaps_along(towards, other).store()
            }
        }
    }
}
