//! Poses at which normals from fields are tried, to find the vertices where they are too far off.

use bdtree_format::ModeRecord;
use bdtree_runtime::{Asset, VertexId};
use glam::DVec3;

use crate::error::GpuError;
use crate::tangents::{Around, Tangents, wide};

/// The farthest vertex moves by so much of the diagonal of the rest positions' box.
const SHARE: f64 = 0.1;
/// Poses of all modes at once, beside each mode alone and pairs of modes.
const MIXTURES: u64 = 32;
/// Up to so many modes pairs of them are tried.
const PAIRED_MODES: usize = 24;
/// Cosine of the angle from which on a vertex counts, 0.3°: other poses are off by more than these, and are
/// to stay within a degree.
const COSINE: f64 = 0.999_986_292_247_427_1;
/// Shorter than this of the sum of its terms' lengths a normal cancels: nothing to compare with.
const CANCELS: f64 = 1e-3;

/// Modes and their q in each pose; each is tried in both directions. All move the farthest vertex alike, as far as
/// `q_limit` allows.
pub(crate) struct Samples(Vec<Vec<(u16, f64)>>);

impl Samples {
    pub(crate) fn new(asset: &Asset<'_>) -> Result<Self, GpuError> {
        let far = SHARE * diagonal(asset);
        let one = |record: &ModeRecord| {
            let most = f64::from(record.field_norm_max.get());
            if most > 0.0 { far / most } else { 0.0 }
        };
        let reach: Vec<f64> = asset.modes().iter().map(one).collect();
        let modes = 0..reach.len() as u16;
        let of = |mode: u16, part: f64| (mode, part * reach[usize::from(mode)]);
        let mut poses: Vec<Vec<_>> = modes.clone().map(|j| vec![of(j, 1.0)]).collect();
        if reach.len() <= PAIRED_MODES {
            let pairs = modes.clone().flat_map(|j| (0..j).map(move |k| (j, k)));
            poses.extend(
                pairs.flat_map(|(j, k)| [1.0, -1.0].map(|sign| vec![of(j, 1.0), of(k, sign)])),
            );
        }
        let mixture = |seed| modes.clone().map(|j| of(j, part(seed, j.into()))).collect();
        poses.extend((0..MIXTURES).map(mixture));
        for pose in &mut poses {
            let most = farthest(asset, pose)?;
            let scale = if most > 0.0 { far / most } else { 0.0 };
            for (mode, q) in pose {
                let limit = f64::from(asset.modes()[usize::from(*mode)].q_limit.get());
                *q = (*q * scale).clamp(-limit, limit);
            }
        }
        Ok(Self(poses))
    }

    /// Whether the normal of a vertex's tangents is more than 0.3° from the exact one in any pose; `places` has for each of
    /// the asset's modes its place among the vertex's, or `None`.
    pub(crate) fn off(
        &self,
        around: &Around,
        tangents: &Tangents,
        places: &[Option<usize>],
    ) -> bool {
        let mut q: Vec<(usize, f64)> = Vec::new();
        self.0.iter().any(|pose| {
            let place = |(mode, q): &(u16, f64)| Some((places[usize::from(*mode)]?, *q));
            q.clear();
            q.extend(pose.iter().filter_map(place));
            !surely_near(around, tangents, &q) && {
                let found = off(around, tangents, &q);
                q.iter_mut().for_each(|(_, q)| *q = -*q);
                found || off(around, tangents, &q)
            }
        })
    }
}

/// A normal longer than this of what its polynomial's rounding is relative to turns by less than 10⁻⁹ from it.
const TURNS_LITTLE: f64 = 1e-5;
/// More than that changes a cosine.
const ROUNDED: f64 = 1e-9;

/// True if [`off`] is surely false for q and for −q: by the normal as a polynomial, which takes less time than the sum over the
/// triangles.
fn surely_near(around: &Around, tangents: &Tangents, q: &[(usize, f64)]) -> bool {
    let Some((even, odd, size)) = around.even_and_odd(q) else {
        return false;
    };
    [1.0, -1.0].into_iter().all(|sign| {
        let exact = even + sign * odd;
        let [a, b] = tangents.moved_by(q, sign);
        let normal = a.cross(b);
        let (length, lengths) = (exact.length(), normal.length() * exact.length());
        length > TURNS_LITTLE * size
            && normal.dot(exact) >= (COSINE + ROUNDED) * lengths
            && lengths > 0.0
    })
}

/// `q` lists modes by their place among the vertex's.
fn off(around: &Around, tangents: &Tangents, q: &[(usize, f64)]) -> bool {
    let (exact, size) = around.normal(q);
    let length = exact.length();
    if !(length > CANCELS * size) {
        return false;
    }
    let [a, b] = tangents.moved_by(q, 1.0);
    let normal = a.cross(b);
    // A normal that is zero or no number is off.
    !(normal.dot(exact) >= COSINE * normal.length() * length && normal.length() > 0.0)
}

/// A number in [−1, 1), the same on every machine.
fn part(seed: u64, mode: u64) -> f64 {
    // SplitMix64 (Steele, Lea & Flood 2014).
    let mut x = (seed << 32 | mode)
        .wrapping_add(1)
        .wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^= x >> 31;
    (x >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

fn diagonal(asset: &Asset<'_>) -> f64 {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for p in asset.positions() {
        low = low.min(wide(*p));
        high = high.max(wide(*p));
    }
    (high - low).length()
}

/// How far a pose moves the vertex that it moves farthest.
fn farthest(asset: &Asset<'_>, pose: &[(u16, f64)]) -> Result<f64, GpuError> {
    let mut most = 0.0_f64;
    for vertex in 0..asset.vertex_count() as u32 {
        let fields = asset.displacements(VertexId(vertex))?;
        let by = pose.iter().fold(DVec3::ZERO, |sum, (mode, q)| {
            sum + *q * wide(fields.of(usize::from(*mode)))
        });
        most = most.max(by.length());
    }
    Ok(most)
}
