//! Every allowance for rounding: what a test of nodes or triangles gives away, so that it never rules out
//! what the leaf arithmetic reports.
//!
//! In the order of `docs/design/guarantees.md`, whose section of the same name derives each. u = 2⁻²⁴ (f32), v = 2⁻⁵³ (f64).
//! Ranges in which predicates are exact are not allowances; they stand with the predicates.

/// u, the unit roundoff of f32: 2⁻²⁴.
pub(crate) const U32: f64 = 1.0 / (1_u64 << 24) as f64;

/// An f32 not below `x`, which is not negative and below 2¹²⁰: rounding to nearest loses at
/// most u x, flushing at most 2⁻¹²⁶.
#[inline(always)]
pub(crate) fn round_up(x: f64) -> f32 {
    let up = x * (1.0 + 4.0 * U32);
    (up as f32).max(f32::MIN_POSITIVE)
}

/// [`round_up`], but NaN stays.
#[inline(always)]
pub(crate) fn round_up_or_nan(x: f64) -> f32 {
    let up = (x * (1.0 + 4.0 * U32)) as f32;
    if up < f32::MIN_POSITIVE {
        f32::MIN_POSITIVE
    } else {
        up
    }
}

/// An f32 above `x`, of any sign: rounding to nearest loses at most half of what is added.
#[inline(always)]
pub(crate) fn next_above(x: f64) -> f32 {
    x as f32 + f32::EPSILON * (x.abs() as f32) + f32::MIN_POSITIVE
}

/// An f32 not above `x`; −∞ for NaN.
#[inline(always)]
pub(crate) fn round_down(x: f64) -> f32 {
    if x.is_nan() {
        return f32::NEG_INFINITY;
    }
    let x = x.min(f64::from(f32::MAX)) as f32;
    x - f32::EPSILON * x.abs() - f32::MIN_POSITIVE
}

// Shares in whole numbers.

/// q̃ gets a second part where one alone would add more than this, times the radius of leaves, to every
/// radius: below a thousandth of the mean radius, which is 1.3 to 1.9 leaf radii where triangles are
/// about equally large.
pub(crate) const COARSE: f64 = 1.0 / 880.0;

/// Least λ: 2⁻¹⁰⁰, so that no product of it and a whole number is subnormal ("flushed values").
pub(crate) const SCALE_MIN: f64 = f64::from_bits((1023 - 100) << 52);

/// Least ρ: 2⁻³⁰, for the same.
pub(crate) const RATIO_MIN: f64 = f64::from_bits((1023 - 30) << 52);

// Rounding: the constants.

/// `slack`: 8u P + (M + 12) u S + 2⁻⁵⁴, which pays for vertices, centers and roots in f32 and for flushed values.
pub(crate) fn slack(p: f64, s: f64, mode_count: f64) -> f64 {
    const FLUSHED: f64 = 1.0 / (1_u64 << 54) as f64;
    8.0 * U32 * p + (mode_count + 12.0) * U32 * s + FLUSHED
}

/// `GAMMA`, γ' = 16u of T²: pays for the radicand, whose terms cancel where a part shrinks.
pub(crate) const GAMMA: f32 = 16.0 / (1_u32 << 24) as f32;

/// `SKIP`, 1 − 2⁻²⁰: pays for a squared f32 distance, for a sum of radii and its square.
pub(crate) const SKIP: f32 = 1.0 - 1.0 / (1 << 20) as f32;

/// `PairFrame`, `MAPPED`: 16u of √3 s B and of ‖t‖, for a center carried to another frame in f32.
pub(crate) const MAPPED: f64 = 16.0 * U32;

/// `PairFrame`, `RADIUS_SCALE`: 1 + 2⁻²², for a radius carried there.
pub(crate) const RADIUS_SCALE: f64 = 1.0 + 1.0 / (1 << 22) as f64;

/// `PairFrame`: 1 + 2⁻²⁰ of the reach of both, for comparing it with the distance of two bodies.
pub(crate) const BODIES_APART: f64 = 1.0 + 1.0 / (1 << 20) as f64;

/// `PairFrame`, spheres of a level: 2¹⁰⁰, a distance of origins (stored units) up to which f32 compares spheres.
pub(crate) const FRAMED_MAX: f64 = f64::from_bits((1023 + 100) << 52);

/// `HEIGHT_MARGIN`: 2⁻¹⁷ of the reach, for the heights of two sides over a plane.
pub(crate) const HEIGHT_MARGIN: f32 = 1.0 / (1 << 17) as f32;

/// `HEIGHT_MARGIN`: 1 − 2⁻²⁰, so that a normal is not longer than 1.
pub(crate) const NORMAL_LENGTH: f32 = 1.0 - 1.0 / (1 << 20) as f32;

/// `Gap` and the keys of closest points: 1 − 2⁻¹⁹ of an f32 distance, before radii are taken off.
pub(crate) const GAP_DISTANCE: f32 = 1.0 - 1.0 / (1 << 19) as f32;

/// `Gap`, origins far apart: 1 + 2⁻²¹ of the radii, for a sum and a difference of them.
pub(crate) const GAP_RADII: f32 = 1.0 + 1.0 / (1 << 21) as f32;

/// `Gap`: 16u of what is measured in f32: the distance of the origins, or, where they are far apart, the reach of both.
pub(crate) const GAP_LOST: f64 = 16.0 * U32;

/// `Gap`, origins far apart: 2⁻⁵⁰ of ‖t‖, for n's length and ‖t‖ in f64.
pub(crate) const GAP_FAR_LOST: f64 = 1.0 / (1_u64 << 50) as f64;

/// `Budget`: 1 − 2⁻⁴⁸ of ‖t‖, for a key that becomes a world distance.
pub(crate) const BUDGET_FAR: f64 = 1.0 - 1.0 / (1_u64 << 48) as f64;

/// 2⁻⁴⁰, for anything that takes a few dozen roundings of f64: far more than they lose. "Boxes and gaps of
/// triangles", `WorldFour`, `nearest_points`, `Budget`, `beyond_four`, `NearSegment`, `root_sphere`, proxies and the broad phase.
pub(crate) const MARGIN: f64 = 1.0 / (1_u64 << 40) as f64;

/// `Placement::error`: 2⁻⁴⁴ of the magnitudes that enter the f64 maps. Forming Q from
/// a normalised quaternion, rotating, scaling and adding take fewer than 64 roundings of v;
/// narrow-phase distances and shears add 2⁻⁴⁸.
pub(crate) const MAPS: f64 = 1.0 / (1_u64 << 44) as f64;

/// `WorldFour`, and heights over planes in general: 2⁻⁴⁹, 16v, of the sum of the magnitudes of a height's
/// products, which loses below 9v.
pub(crate) const HEIGHT_ROUNDING: f64 = f64::from_bits((1023 - 49) << 52);

/// `WorldFour`: 2⁻⁹⁰, what numbers below 2⁻³⁰⁰, which the exact test reads as 0, and underflow can add to
/// a height.
pub(crate) const HEIGHT_FLUSHED: f64 = f64::from_bits((1023 - 90) << 52);

/// Leaf predicates: 2⁻⁴⁶, 128v, for the normal equations of two edges, which lose below 16v.
pub(crate) const NORMAL_EQUATIONS: f64 = f64::from_bits((1023 - 46) << 52);

/// A ball: 4u of its radius, divided by the scale.
pub(crate) const BALL_RADIUS: f64 = 4.0 * U32;

/// A query point, or a plane's offset, rounded to f32: 2u of its norm.
pub(crate) const POINT: f64 = 2.0 * U32;

/// `NearSegment` and `NearBox`: 32u ρ, for what is cut to the reach ρ and rounded to f32.
pub(crate) const CUT_TO_REACH: f64 = 32.0 * U32;

/// `StoredPlane`: 8u B, for a height in f32.
pub(crate) const PLANE_HEIGHT: f64 = 8.0 * U32;

/// `Line::lanes`: 32u B, for the ray's origin, direction and parameter in f32.
pub(crate) const RAY: f64 = 32.0 * U32;

/// `Slabs`: 16u B, for the distance of a plane from the ray's origin in f32.
pub(crate) const BOX_GROWN: f64 = 16.0 * U32;

/// `Slabs`: 32u B, for the parameter where the ray meets a plane.
pub(crate) const BOX_PARAMETER: f64 = 32.0 * U32;

/// `Slabs`: 2^-40. A slower ray leaves no slab within its window of 4 B.
pub(crate) const ALONG_LEAST: f32 = 1.0 / (1_u64 << 40) as f32;

/// `Boxes::spheres`: 32u B, for centers of boxes, which may be farther from the origin than B.
pub(crate) const BOX_CENTER: f64 = 32.0 * U32;

/// `Boxes::around`: 4u of center and radius, for a sphere's least and greatest coordinates in f32.
pub(crate) const BOX_AROUND: f32 = 1.0 / (1 << 22) as f32;

/// `Boxes::spheres`: 1 + 2⁻²⁰, for half of a box's diagonal in f32.
pub(crate) const BOX_RADIUS: f32 = 1.0 + 1.0 / (1 << 20) as f32;

/// `Line::lanes`: 1 + 16u of the reach, for comparing the line's distance with it.
pub(crate) const RAY_REACH: f64 = 1.0 + 16.0 * U32;

/// `Line::lanes`: 1 + 2⁻¹⁹ of the square of a reach, for where a chord begins.
pub(crate) const CHORD: f32 = 1.0 + 1.0 / (1 << 19) as f32;

/// `Sieve`: 64 e B, below which an edge function may be 0.
pub(crate) const EDGE_FUNCTION: f64 = 64.0;

/// `Sieve`: 16 e, by which the range of a parameter grows.
pub(crate) const RAY_RANGE: f64 = 16.0;

// Derived bounds.

/// Steps (`Drift`): 8u of a norm of q − q₀, for the norm and the product with δR.
pub(crate) const DRIFT: f64 = 8.0 * U32;

// The tolerances of a checker (SPEC 5.8), which the constants above leave room for.

/// 2⁻⁴⁰: norms may exceed P and W by this share of them, far less than one f32 ulp.
pub(crate) const CHECKED_NORM: f64 = 1.0 / (1_u64 << 40) as f64;

/// 2⁻⁴⁴: shares of R² and ΔR_j² by which squares may exceed them.
pub(crate) const CHECKED_RADIUS: f64 = 1.0 / (1_u64 << 44) as f64;

/// 2⁻⁴⁸: share of R² and ΔR_j² that is added to d and e.
pub(crate) const CHECKED_SQUARE: f64 = 1.0 / (1_u64 << 48) as f64;

/// 2⁻⁴⁰: share of R ΔR_j by which b± may be too small.
pub(crate) const CHECKED_PRODUCT: f64 = 1.0 / (1_u64 << 40) as f64;

/// 2⁻⁴¹: share of δR² by which a vertex's norm may exceed it.
pub(crate) const CHECKED_STEP: f64 = 1.0 / (1_u64 << 41) as f64;

// Bones (SPEC 5.9).

/// `BoneSlack`: 2⁻⁵⁰, for flushed weights, matrices and products of them.
pub(crate) const BONES_FLUSHED: f64 = 1.0 / (1_u64 << 50) as f64;

/// `carried`: 2u for each of m + 16 roundings of a radius that grows by bones.
pub(crate) const BONES_ROUNDING: f32 = 2.0 / (1_u32 << 24) as f32;

/// Stretches in f32: 1 + 2⁻¹⁸, for σ, which loses below 26u, and for ρ, which loses below 5u more.
pub(crate) const STRETCH: f32 = 1.0 + 1.0 / (1 << 18) as f32;

/// Stretches in f32: 2⁻³⁰, for what flushing takes from sums of products of four elements, below 2⁻⁶¹ of σ².
pub(crate) const STRETCH_FLUSHED: f32 = 1.0 / (1 << 30) as f32;

/// Sums of weights and of their distances (SPEC 6.10): relative 2⁻⁴⁰, for at most 4096 terms added in f64.
pub(crate) const CHECKED_SUM: f64 = 1.0 / (1_u64 << 40) as f64;

// Single triangles and spheres, in f64.

/// `WorldFour`: 10⁻¹² of the span of two boxes, for their gap and for the distance of the triangles, which is off by 2⁻⁴⁸ of it.
pub(crate) const BOXES_APART: f64 = 1e-12;

/// `closest_point`: 2⁻⁸⁸ of the longest side's square, below which a squared distance may be a touch that rounding
/// hides: candidates lose 2⁻⁴⁷ of that side where the point is on the triangle.
pub(crate) const TOUCH: f64 = f64::from_bits((1023 - 88) << 52);

/// `triangle_distance`: 4v of the largest difference of coordinates, what a computed gap of triangles that touch may well be.
pub(crate) const TOUCHING_GAP: f64 = 2.0 * f64::EPSILON;

/// The broad phase: 2⁻⁵⁰ of the farthest coordinate is the least reach of a sphere, so that cells stay apart in f64.
pub(crate) const CELL_SHARE: f64 = 1.0 / (1_u64 << 50) as f64;

/// The broad phase: 2v of the farthest coordinate, for the corners of the cells that a sphere looks into.
pub(crate) const CELL_ROUNDING: f64 = f64::EPSILON;
