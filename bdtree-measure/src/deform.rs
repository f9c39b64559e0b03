//! Deforming all vertices, which every library that refits its tree has to do first.
//!
//! The product's leaf arithmetic (SPEC 5.5 and 5.9), so that all contenders see the same
//! vertices: `p + (((U_1 q_1) + U_2 q_2) + …)` in f32, products and sums rounded separately. Sixteen
//! coordinates at a time from one sequential stream, in the widest vectors of the processor. Bones then carry sixteen
//! vertices at a time, while these are still near.

use bdtree_runtime::BoneMap;
use pulp::{Arch, Simd, WithSimd};

use crate::skin::Columns;
use crate::{Body, BodySkin, Place};

/// Coordinates of a block.
const WIDTH: usize = 16;

/// Blocks after which bones carry their vertices: whole vertices end with them.
const CARRIED: usize = 3;

/// A body's positions, modes and bones in the order in which they are read.
#[derive(Debug, Clone)]
pub struct Deformer {
    arch: Arch,
    /// Numbers of all vertices.
    pub count: usize,
    modes: usize,
    rest: Vec<[f32; WIDTH]>,
    /// Block after block, in it mode after mode.
    fields: Vec<[f32; WIDTH]>,
    skin: Option<BodySkin>,
}

impl Deformer {
    /// Of a body.
    pub fn new(body: &Body) -> Self {
        let flat = body.positions.as_flattened();
        let count = flat.len();
        let blocks = count.div_ceil(WIDTH);
        let mut rest = vec![[0.0; WIDTH]; blocks];
        let mut fields = vec![[0.0; WIDTH]; blocks * body.modes];
        for (i, x) in flat.iter().enumerate() {
            rest[i / WIDTH][i % WIDTH] = *x;
        }
        for (i, u) in body.fields.as_flattened().iter().enumerate() {
            let (j, i) = (i / count, i % count);
            fields[i / WIDTH * body.modes + j][i % WIDTH] = *u;
        }
        Self {
            arch: Arch::new(),
            count,
            modes: body.modes,
            rest,
            fields,
            skin: body.skin.clone(),
        }
    }

    /// Writes x, y, z of all vertices at q to `out`, which holds [`Deformer::count`] numbers or more. `bones`: those of a
    /// pose ([`bdtree_runtime::Pose::bone_maps`]), none without a skin.
    pub fn deform(&self, q: &[f32], bones: &[BoneMap], out: &mut [f32]) {
        let out = &mut out[..self.count];
        let deformer = self;
        self.arch.dispatch(Deform {
            deformer,
            q,
            bones,
            out,
        });
    }

    #[inline(always)]
    fn carried<S: Simd>(
        &self,
        simd: S,
        skin: &BodySkin,
        q: &[f32],
        bones: &[BoneMap],
        out: &mut [f32],
    ) {
        let columns: Vec<Columns> = bones.iter().map(Columns::of).collect();
        for (k, out) in out.chunks_mut(CARRIED * WIDTH).enumerate() {
            self.blocks(CARRIED * k, q, out);
            skin.carry(simd, WIDTH * k, &columns, out.as_chunks_mut::<3>().0);
        }
    }

    /// Moves by q what `out` holds from a block on.
    #[inline(always)]
    fn blocks(&self, first: usize, q: &[f32], out: &mut [f32]) {
        let (whole, rest) = out.as_chunks_mut::<WIDTH>();
        let last = first + whole.len();
        for (k, out) in (first..).zip(whole.iter_mut()) {
            *out = self.block(k, q);
        }
        if !rest.is_empty() {
            let block = self.block(last, q);
            rest.copy_from_slice(&block[..rest.len()]);
        }
    }

    #[inline(always)]
    fn block(&self, k: usize, q: &[f32]) -> [f32; WIDTH] {
        let fields = &self.fields[k * self.modes..(k + 1) * self.modes];
        // From −0, which keeps the sign of a first product that is −0.
        let mut sum = [-0.0_f32; WIDTH];
        for (u, q) in fields.iter().zip(q) {
            for l in 0..WIDTH {
                sum[l] += u[l] * q;
            }
        }
        let rest = &self.rest[k];
        for l in 0..WIDTH {
            sum[l] += rest[l];
        }
        sum
    }

    /// The same, moved to a place; `scratch` holds the unmoved vertices meanwhile.
    pub fn deform_at(
        &self,
        q: &[f32],
        bones: &[BoneMap],
        place: &Place,
        scratch: &mut Vec<f32>,
        out: &mut [f32],
    ) {
        if *place == Place::IDENTITY {
            self.deform(q, bones, out);
            return;
        }
        scratch.resize(self.count, 0.0);
        self.deform(q, bones, scratch);
        let rows = place.rows();
        let out = out[..self.count].as_chunks_mut::<3>().0;
        let from = scratch.as_slice();
        self.arch.dispatch(MoveAll { rows, from, out });
    }
}

/// [`Deformer::deform`]. No closure: that would have wide vectors only where the compiler happens to inline it.
struct Deform<'a> {
    deformer: &'a Deformer,
    q: &'a [f32],
    bones: &'a [BoneMap],
    out: &'a mut [f32],
}

impl WithSimd for Deform<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            deformer,
            q,
            bones,
            out,
        } = self;
        match &deformer.skin {
            None => deformer.blocks(0, q, out),
            Some(skin) => deformer.carried(simd, skin, q, bones, out),
        }
    }
}

/// Vertices moved to a place.
struct MoveAll<'a> {
    rows: [[f32; 4]; 3],
    from: &'a [f32],
    out: &'a mut [[f32; 3]],
}

impl WithSimd for MoveAll<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        move_all(&self.rows, self.from, self.out);
    }
}

#[inline(always)]
fn move_all(rows: &[[f32; 4]; 3], from: &[f32], out: &mut [[f32; 3]]) {
    let columns = [0, 1, 2, 3].map(|k| [rows[0][k], rows[1][k], rows[2][k], 0.0]);
    for (p, out) in from.as_chunks::<3>().0.iter().zip(out) {
        let mut moved = [0.0_f32; 4];
        for k in 0..4 {
            moved[k] = columns[0][k] * p[0]
                + (columns[1][k] * p[1] + (columns[2][k] * p[2] + columns[3][k]));
        }
        *out = [moved[0], moved[1], moved[2]];
    }
}
