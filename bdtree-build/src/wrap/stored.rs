//! The shape as the file stores it: origin, length unit, f32 positions and fields, limits of q
//! (SPEC 5). Tree and bounds are made from these numbers and no others.

use bdtree_format::UNIT_EXPONENT_MAX;

use super::check::{check_counts, check_numbers, none_yet};
use super::frames::{Farthest, StoredFrames, place, store_frames};
use super::round::{round_nearest, vector_norm_up};
use super::units::{
    LIMIT_EXPONENTS, exponent, exponent_up, length, limit_exponent, origin, power, scale,
};
use crate::basis::Basis;
use crate::error::{BakeError, Part, Place};
use crate::input::RawMesh;
use crate::vec3::bounds;

/// A mode without a range of its own moves its farthest vertex by this share of the box diagonal at
/// its typical range.
pub const RANGE_DIAGONALS: f64 = 0.05;

/// Exponents of the least and the largest reach P + Σ W_j q_limit_j in stored units.
const REACH_EXPONENTS: (i32, i32) = (-20, 60);

/// The largest coordinate of the origin that readers take (SPEC 5.2).
const ORIGIN_EXPONENT_MAX: i32 = 80;

/// Exponent of q_limit of a field that is zero.
const ZERO_LIMIT_EXPONENT: i32 = 60;

/// Exponent of the largest product of P and W_j: with it norms and step bounds stay far below f32's
/// range.
const PRODUCT_EXPONENT_MAX: i32 = 120;

/// Vertices whose displacements are put in order at a time.
const VERTICES: usize = 256;

/// The limits of one mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeLimits {
    /// Hard limit of |q_j|: a power of two.
    pub q_limit: f32,
    /// Typical largest |q_j|.
    pub q_range: f32,
    /// S_j, the scaling of the second δR.
    pub step_scale: f32,
}

/// A shape in stored units.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredShape {
    /// Origin in mesh units; stored positions are relative to it.
    pub origin: [f64; 3],
    /// Stored lengths times 2^this are mesh units.
    pub unit_exponent: i32,
    /// Diagonal of the box around the rest positions (mesh units).
    pub diagonal: f64,
    /// Rest positions, N.
    pub positions: Vec<[f32; 3]>,
    /// Displacements, vertex-major: `displacements[i * M + j]` is U_ij.
    pub displacements: Vec<[f32; 3]>,
    /// An upper bound of all ‖p_i‖.
    pub position_norm: f32,
    /// Per mode, an upper bound of all ‖U_ij‖.
    pub field_norms: Vec<f32>,
    /// One per mode.
    pub limits: Vec<ModeLimits>,
    /// The animation, if there is one; each q is within its limit.
    pub frames: Option<StoredFrames>,
}

impl StoredShape {
    /// Number of modes M.
    pub fn mode_count(&self) -> usize {
        self.limits.len()
    }

    /// p_i in f64; `vertex` is below N.
    #[inline]
    pub(super) fn position(&self, vertex: u32) -> [f64; 3] {
        self.positions[vertex as usize].map(f64::from)
    }

    /// U_ij in f64; `vertex` is below N and `mode` below M.
    #[inline]
    pub(super) fn displacement(&self, vertex: u32, mode: u16) -> [f64; 3] {
        self.displacements[vertex as usize * self.limits.len() + usize::from(mode)].map(f64::from)
    }

    /// p_i + Σ_j U_ij q_j of all vertices in f64; `q` has M entries.
    pub fn deform(&self, q: &[f64]) -> Vec<[f64; 3]> {
        let mut deformed: Vec<[f64; 3]> = self.positions.iter().map(|p| p.map(f64::from)).collect();
        for (p, row) in deformed
            .iter_mut()
            .zip(self.displacements.chunks_exact(self.limits.len().max(1)))
        {
            for (u, &q) in row.iter().zip(q) {
                for (x, &u) in p.iter_mut().zip(u) {
                    *x += f64::from(u) * q;
                }
            }
        }
        deformed
    }
}

/// The mesh and its basis as stored: x − origin and U in units of 2^e, rounded to nearest f32,
/// subnormals as 0. Warnings go to `warnings`.
///
/// The origin is 0 when the box's center is within a diagonal of it, so that f32 sources are
/// stored as they are; else the center, rounded so that x − origin is exact for coordinates
/// far from 0. e is 0 unless the reach P + Σ W_j q_limit_j would leave 2⁻²⁰ … 2⁶⁰; the box's
/// diagonal is then about one unit.
///
/// # Errors
/// No triangle, a corner without a vertex, a basis for another number of vertices, more than 512
/// modes, counts over u32, numbers that are not finite or that f32 cannot hold, a range of q that
/// is not positive, an animation that cannot be stored: each with its vertex, mode or frame.
pub fn store(
    mesh: &RawMesh,
    basis: &Basis,
    warnings: &mut Vec<String>,
) -> Result<StoredShape, BakeError> {
    check_counts(mesh, basis)?;
    check_numbers(mesh, basis)?;
    let frames = store_frames(basis)?;
    let farthest = match &frames {
        Some(frames) => frames.farthest(basis.mode_count()),
        None => vec![None; basis.mode_count()],
    };
    let (low, high) = bounds(mesh.positions.iter().copied());
    let diagonal = length(std::array::from_fn(|k| high[k] - low[k]));
    if !diagonal.is_finite() {
        let message = "the box around all vertices is larger than f64 can measure";
        return Err(BakeError::one("encode", Place::NOWHERE, message));
    }
    let origin = origin(low, high, diagonal);
    let relative = |p: [f64; 3]| -> [f64; 3] { std::array::from_fn(|k| p[k] - origin[k]) };
    let longest: Vec<f64> = (0..basis.mode_count())
        .map(|j| largest_length(basis.field(j).iter().copied()))
        .collect();
    let unit_exponent = unit_exponent(
        largest_length(mesh.positions.iter().map(|&p| relative(p))),
        &longest,
        &farthest,
        diagonal,
    );
    if unit_exponent.abs() > UNIT_EXPONENT_MAX
        || origin.iter().any(|x| x.abs() > power(ORIGIN_EXPONENT_MAX))
    {
        let message = format!(
            "a box of diagonal {diagonal:e} around {origin:?} cannot be stored: sizes lie within \
             2^±{UNIT_EXPONENT_MAX} mesh units, positions within 2^{ORIGIN_EXPONENT_MAX} of the origin"
        );
        return Err(BakeError::one("encode", Place::file(&mesh.name), message));
    }

    let mut problems = none_yet();
    let quantise = |x: [f64; 3]| x.map(|c| round_nearest(scale(c, -unit_exponent)));
    let mut positions = Vec::with_capacity(mesh.positions.len());
    for (i, &p) in mesh.positions.iter().enumerate() {
        let stored = quantise(relative(p));
        if !stored.iter().all(|c| c.is_finite()) {
            problems.add(|| (Part::Vertex(i), format!("{p:?} is too large for f32")));
        }
        positions.push(stored);
    }
    let mode_count = basis.mode_count();
    let mut displacements = vec![[0.0; 3]; basis.fields.len()];
    // What belongs to a vertex will lie together: few vertices at a time stay in the cache.
    for (n, rows) in displacements
        .chunks_mut(VERTICES * mode_count.max(1))
        .enumerate()
    {
        for j in 0..mode_count {
            let fields = &basis.field(j)[n * VERTICES..];
            for (row, &u) in rows.chunks_exact_mut(mode_count).zip(fields) {
                row[j] = quantise(u);
            }
        }
    }
    if displacements.as_flattened().iter().any(|c| !c.is_finite()) {
        for j in 0..mode_count {
            for (i, &u) in basis.field(j).iter().enumerate() {
                if !quantise(u).iter().all(|c| c.is_finite()) {
                    let place = Place::from(Part::Mode(j)).at(Part::Vertex(i));
                    problems.add(|| (place, format!("displacement {u:?} is too large for f32")));
                }
            }
        }
    }
    problems.into_result(Place::NOWHERE)?;
    let (position_norm, field_norms) = largest_norms(&positions, &displacements, mode_count);
    let mut shape = StoredShape {
        origin,
        unit_exponent,
        diagonal,
        positions,
        displacements,
        position_norm,
        field_norms,
        limits: Vec::with_capacity(mode_count),
        frames,
    };
    add_limits(&mut shape, basis, &longest, &farthest, warnings)?;
    Ok(shape)
}

/// Upper bounds of all ‖p_i‖ and, per mode, of all ‖U_ij‖.
fn largest_norms(
    positions: &[[f32; 3]],
    displacements: &[[f32; 3]],
    mode_count: usize,
) -> (f32, Vec<f32>) {
    let norm = |v: &[f32; 3]| vector_norm_up(v.map(f64::from));
    let mut fields = vec![0.0f32; mode_count];
    for row in displacements.chunks_exact(mode_count.max(1)) {
        for (largest, u) in fields.iter_mut().zip(row) {
            *largest = largest.max(norm(u));
        }
    }
    (positions.iter().map(norm).fold(0.0, f32::max), fields)
}

fn largest_length(vectors: impl Iterator<Item = [f64; 3]>) -> f64 {
    vectors.map(length).fold(0.0, f64::max)
}

/// Lengths are measured against the diagonal, or against one unit when there is none.
fn reference(diagonal: f64) -> f64 {
    if diagonal > 0.0 { diagonal } else { 1.0 }
}

/// e: 0 where the reach allows it, else such that the diagonal is about one unit.
fn unit_exponent(
    position_reach: f64,
    longest: &[f64],
    farthest: &[Option<Farthest>],
    diagonal: f64,
) -> i32 {
    let fields: f64 = longest
        .iter()
        .zip(farthest)
        .filter(|&(&w, _)| w > 0.0)
        .map(|(&w, far)| {
            let own = limit_exponent(w, reference(diagonal));
            scale(w, far.map_or(own, |far| own.max(exponent_up(far.q))))
        })
        .sum();
    let reach = position_reach + fields;
    // One power of two inside, for what rounding adds later.
    let allowed = power(REACH_EXPONENTS.0 + 1)..=power(REACH_EXPONENTS.1 - 1);
    if reach == 0.0 || allowed.contains(&reach) {
        0
    } else {
        exponent(if diagonal > 0.0 { diagonal } else { reach })
    }
}

/// q_limit, q_range and S of each mode from the stored fields.
///
/// A limit is raised for frames that go beyond it, since every frame is playable; never for a
/// range, which is advisory: a larger limit makes the grids of all rows coarser.
fn add_limits(
    shape: &mut StoredShape,
    basis: &Basis,
    longest: &[f64],
    farthest: &[Option<Farthest>],
    warnings: &mut Vec<String>,
) -> Result<(), BakeError> {
    let mut problems = none_yet();
    let position_norm = f64::from(shape.position_norm);
    let diagonal = scale(reference(shape.diagonal), -shape.unit_exponent);
    let mut reach = position_norm;
    let mut raised = Vec::new();
    for (j, mode) in basis.modes.iter().enumerate() {
        let norm = f64::from(shape.field_norms[j]);
        if norm == 0.0 && longest[j] > 0.0 {
            warnings.push(format!(
                "mode {j}: the field is below what f32 holds, stored as zero"
            ));
        }
        if norm * position_norm > power(PRODUCT_EXPONENT_MAX) {
            let message = "displacements per unit of q are too large: scale the field down";
            problems.add(|| (Part::Mode(j), message.to_string()));
            continue;
        }
        let (mut limit, typical) = if norm > 0.0 {
            let limit = power(limit_exponent(norm, diagonal));
            (limit, RANGE_DIAGONALS * diagonal / norm)
        } else {
            (power(ZERO_LIMIT_EXPONENT), 1.0)
        };
        if let Some(far) = farthest[j].filter(|far| far.q > limit) {
            let exponent = exponent_up(far.q);
            if exponent > LIMIT_EXPONENTS.1 {
                let message = format!(
                    "q {:e} is beyond the largest limit, 2^{}",
                    far.q as f32, LIMIT_EXPONENTS.1
                );
                problems.add(|| (place(far.frame, j), message));
                continue;
            }
            warnings.push(format!(
                "mode {j}: limit of q raised from {limit} to {} for frame {}, which moves a vertex by \
                 {:.0} box diagonals (--align takes rigid motion out of frames)",
                power(exponent),
                far.frame,
                norm * far.q / diagonal
            ));
            limit = power(exponent);
            raised.push((j, far, norm));
        }
        reach += norm * limit;
        let wanted = mode.q_range.unwrap_or(typical);
        if wanted > limit {
            warnings.push(format!(
                "mode {j}: range of q {wanted} lowered to the limit {limit}"
            ));
        }
        let q_range = (wanted.min(limit) as f32).max(f32::MIN_POSITIVE);
        shape.limits.push(ModeLimits {
            q_limit: limit as f32,
            q_range,
            step_scale: q_range,
        });
    }
    if reach > power(REACH_EXPONENTS.1) {
        for (j, far, norm) in raised.into_iter().filter(|(_, _, norm)| *norm > 0.0) {
            let diagonals = norm * far.q / diagonal;
            let message = format!(
                "q {:e} moves a vertex by {diagonals:.1e} box diagonals: too far for f32",
                far.q as f32
            );
            problems.add(|| (place(far.frame, j), message));
        }
    }
    problems.into_result(Place::NOWHERE)?;
    if reach > power(REACH_EXPONENTS.1) || (reach > 0.0 && reach < power(REACH_EXPONENTS.0)) {
        let message = "positions and displacements are too far apart in size for f32";
        return Err(BakeError::one("encode", Place::NOWHERE, message));
    }
    Ok(())
}
