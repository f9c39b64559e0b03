//! Deforming all vertices, which every library that refits its tree has to do first.
//!
//! The product's leaf arithmetic (SPEC 5.5), so that all contenders see the same
//! vertices: `p + (((U_1 q_1) + U_2 q_2) + …)` in f32, products and sums rounded separately. Sixteen
//! coordinates at a time from one sequential stream, in the widest vectors of the processor.

use pulp::Arch;

use crate::{Body, Place};

/// Coordinates of a block.
const WIDTH: usize = 16;

/// A body's positions and modes in the order in which they are read.
#[derive(Debug, Clone)]
pub struct Deformer {
    arch: Arch,
    /// Numbers of all vertices.
    pub count: usize,
    modes: usize,
    rest: Vec<[f32; WIDTH]>,
    /// Block after block, in it mode after mode.
    fields: Vec<[f32; WIDTH]>,
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
        }
    }

    /// Writes x, y, z of all vertices at q to `out`, which holds [`Deformer::count`] numbers or more.
    pub fn deform(&self, q: &[f32], out: &mut [f32]) {
        self.arch.dispatch(|| self.blocks(q, out));
    }

    #[inline(always)]
    fn blocks(&self, q: &[f32], out: &mut [f32]) {
        let (whole, rest) = out[..self.count].as_chunks_mut::<WIDTH>();
        let last = whole.len();
        for (k, out) in whole.iter_mut().enumerate() {
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
    pub fn deform_at(&self, q: &[f32], place: &Place, scratch: &mut Vec<f32>, out: &mut [f32]) {
        if *place == Place::IDENTITY {
            self.deform(q, out);
            return;
        }
        scratch.resize(self.count, 0.0);
        self.deform(q, scratch);
        let rows = place.rows();
        let out = out[..self.count].as_chunks_mut::<3>().0;
        self.arch.dispatch(|| move_all(&rows, scratch, out));
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
