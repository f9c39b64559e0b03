//! How far vertices on the device may be from the leaf arithmetic (docs/reference/gpu-deformation.md derives it).

use bdtree_runtime::{Asset, BoneMap, StoredToWorld};
use glam::DVec3;

/// Unit roundoff of f32.
const U32: f64 = 1.0 / (1_u64 << 24) as f64;
/// Twice what flushing a subnormal number loses.
const FLUSHED: f64 = 1.0 / (1_u128 << 125) as f64;

/// What an instance's vertices consist of (stored units).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reach {
    /// M.
    modes: f64,
    /// P.
    rest: f64,
    /// S = Σ W_j |q_j|.
    moved: f64,
    bones: Option<BoneReach>,
}

/// What bones do to them.
#[derive(Debug, Clone, Copy)]
struct BoneReach {
    /// I, most influences of a vertex.
    influences: f64,
    /// (1 + ε) max σ_b.
    stretch: f64,
    /// B' = (1 + ε) max (σ_b (P + S) + ‖t_b‖).
    reach: f64,
}

impl Reach {
    /// Of an asset at q, with a pose's bones if it has a skin.
    pub(crate) fn of(asset: &Asset<'_>, q: &[f32], bones: &[BoneMap]) -> Self {
        let weighted = asset.modes().iter().zip(q);
        let weighted =
            weighted.map(|(m, q)| f64::from(m.field_norm_max.get()) * f64::from(q.abs()));
        let moved = weighted.sum();
        let rest = f64::from(asset.header().position_norm_max.get());
        let bones = asset.skin_record().map(|skin| {
            let (mut stretch, mut reach) = (0.0_f64, 0.0_f64);
            for bone in bones {
                let own = f64::from(bone.stretch());
                let offset = DVec3::from_array(bone.rows().map(|row| f64::from(row[3])));
                stretch = stretch.max(own);
                reach = reach.max(own * (rest + moved) + offset.length());
            }
            let sum = 1.0 + f64::from(skin.weight_defect);
            BoneReach {
                influences: f64::from(skin.influences_max),
                stretch: sum * stretch,
                reach: sum * reach,
            }
        });
        Self {
            modes: asset.mode_count() as f64,
            rest,
            moved,
            bones,
        }
    }

    /// No deformed vertex is farther from the stored origin, before rounding.
    pub(crate) fn carried(&self) -> f64 {
        self.bones
            .map_or(self.rest + self.moved, |bones| bones.reach)
    }

    /// E (world units), where the placement's offset from the origin of coordinates is `away` long.
    pub(crate) fn error(&self, map: &StoredToWorld, away: f64) -> f64 {
        let (p, s, m) = (self.rest, self.moved, self.modes);
        let per_stored = map.scale();
        let reach = self.carried();
        let before = 3.0 * U32 * (p + (m + 2.0) * s);
        let placed = 16.0 * U32 * (2.0 * per_stored * reach + away) + map.error(reach);
        match self.bones {
            None => {
                let flushed = (m + 8.0) * FLUSHED * (1.0 + per_stored + p + s);
                per_stored * before + placed + flushed
            }
            Some(bones) => {
                let carried =
                    bones.stretch * before + 6.0 * U32 * (bones.influences + 5.0) * bones.reach;
                let sizes = (1.0 + per_stored) * (1.0 + bones.stretch) * (1.0 + p + s) + reach;
                let flushed = 2.0 * (m + 2.0 * bones.influences + 12.0) * FLUSHED * sizes;
                per_stored * carried + placed + flushed
            }
        }
    }
}
