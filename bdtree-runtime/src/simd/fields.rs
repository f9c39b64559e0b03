//! Vertices moved by their modes, four at once: each in a register of its own, of which the last
//! number is not used, so that records of three numbers are read as they lie.
#![cfg_attr(target_arch = "x86_64", allow(unsafe_code))] // intrinsics; every block has its proof

#[cfg(target_arch = "x86_64")]
use core::arch::x86_64::{
    __m128, _mm_add_ps, _mm_loadu_ps, _mm_movehl_ps, _mm_movelh_ps, _mm_mul_ps, _mm_set1_ps,
    _mm_storeu_ps, _mm_unpackhi_ps, _mm_unpacklo_ps,
};

/// Rest positions, displacements by all modes one vertex after the other, and q; and the corners of four
/// triangles, all of which lie in them and are followed by another vertex.
pub(crate) struct Fields<'a> {
    positions: &'a [[f32; 3]],
    displacements: &'a [[f32; 3]],
    q: &'a [f32],
    /// First corners, second ones, third ones.
    vertices: &'a [[u32; 4]; 3],
}

impl<'a> Fields<'a> {
    /// `None` where a vertex is the last one or none.
    #[inline(always)]
    pub(crate) fn of(
        positions: &'a [[f32; 3]],
        displacements: &'a [[f32; 3]],
        q: &'a [f32],
        vertices: &'a [[u32; 4]; 3],
    ) -> Option<Self> {
        let last = vertices.as_flattened().iter().fold(0, |a, b| a.max(*b)) as usize;
        let whole = displacements.len() >= positions.len().checked_mul(q.len())?;
        (last < positions.len().saturating_sub(1) && whole).then_some(Self {
            positions,
            displacements,
            q,
            vertices,
        })
    }

    /// `p + (((U_1 q_1) + U_2 q_2) + …)` of each vertex, of each coordinate that of the four: products and
    /// sums rounded separately, modes in order, p last, so the same bits everywhere.
    #[inline(always)]
    pub(super) fn moved(&self) -> [[[f32; 4]; 3]; 3] {
        let mut out = [[[0.0; 4]; 3]; 3];
        for i in 0..3 {
            for k in 0..4 {
                let vertex = self.vertices[i][k] as usize;
                let fields = &self.displacements[vertex * self.q.len()..];
                // The sum starts with the first product: adding that to −0 keeps every bit.
                let mut sum = [-0.0_f32; 3];
                for (u, q) in fields.iter().zip(self.q) {
                    for axis in 0..3 {
                        sum[axis] += u[axis] * q;
                    }
                }
                for axis in 0..3 {
                    out[i][axis][k] = self.positions[vertex][axis] + sum[axis];
                }
            }
        }
        out
    }
}

#[cfg(target_arch = "x86_64")]
impl Fields<'_> {
    /// [`Fields::moved`] with SSE, which every x86-64 has.
    #[inline(always)]
    pub(super) fn moved_with_sse(&self) -> [[[f32; 4]; 3]; 3] {
        let [a, b, c] = *self.vertices;
        // Spelled out: behind a closure it would not be compiled with the instruction set of the caller.
        [self.four(a), self.four(b), self.four(c)]
    }

    #[inline(always)]
    fn four(&self, vertices: [u32; 4]) -> [[f32; 4]; 3] {
        let m = self.q.len();
        let mut sums = [splat(-0.0); 4];
        for (j, q) in self.q.iter().enumerate() {
            let q = splat(*q);
            for k in 0..4 {
                // SAFETY: the record of mode j of a vertex and the next one lie in the slice: the vertex is
                // not the last one, and the slice holds m records for each.
                let u = unsafe { load(self.displacements, vertices[k] as usize * m + j) };
                sums[k] = add(sums[k], mul(u, q));
            }
        }
        for k in 0..4 {
            // SAFETY: the vertex and the next one lie in the slice.
            let rest = unsafe { load(self.positions, vertices[k] as usize) };
            sums[k] = add(rest, sums[k]);
        }
        coordinates(sums)
    }
}

/// Record `i`, and the first number of the next.
///
/// # Safety
/// Both lie in `records`.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
unsafe fn load(records: &[[f32; 3]], i: usize) -> __m128 {
    // SAFETY: inside the slice, says the caller.
    let record = unsafe { records.as_ptr().add(i) };
    // SAFETY: SSE is part of x86-64; four f32 can be read there, says the caller.
    unsafe { _mm_loadu_ps(record.cast()) }
}

/// The first three numbers of each of four registers, side by side.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn coordinates([a, b, c, d]: [__m128; 4]) -> [[f32; 4]; 3] {
    // SAFETY: SSE is part of x86-64, here and below.
    let low_ab = unsafe { _mm_unpacklo_ps(a, b) };
    // SAFETY: see above.
    let low_cd = unsafe { _mm_unpacklo_ps(c, d) };
    // SAFETY: see above.
    let high_ab = unsafe { _mm_unpackhi_ps(a, b) };
    // SAFETY: see above.
    let high_cd = unsafe { _mm_unpackhi_ps(c, d) };
    // SAFETY: see above.
    let x = unsafe { _mm_movelh_ps(low_ab, low_cd) };
    // SAFETY: see above.
    let y = unsafe { _mm_movehl_ps(low_cd, low_ab) };
    // SAFETY: see above.
    let z = unsafe { _mm_movelh_ps(high_ab, high_cd) };
    [store(x), store(y), store(z)]
}

#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn splat(x: f32) -> __m128 {
    // SAFETY: SSE is part of x86-64.
    unsafe { _mm_set1_ps(x) }
}

#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn add(a: __m128, b: __m128) -> __m128 {
    // SAFETY: SSE is part of x86-64.
    unsafe { _mm_add_ps(a, b) }
}

#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn mul(a: __m128, b: __m128) -> __m128 {
    // SAFETY: SSE is part of x86-64.
    unsafe { _mm_mul_ps(a, b) }
}

#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn store(x: __m128) -> [f32; 4] {
    let mut out = [0.0; 4];
    // SAFETY: SSE is part of x86-64; `out` is four writable f32.
    unsafe { _mm_storeu_ps(out.as_mut_ptr(), x) };
    out
}
