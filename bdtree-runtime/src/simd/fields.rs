//! Vertices moved by their modes, four at once.

/// Rest positions, displacements by all modes one vertex after the other, and q; and the corners of four
/// triangles, all of which lie in them and are followed by another vertex.
pub(crate) struct Fields<'a> {
    pub(super) positions: &'a [[f32; 3]],
    pub(super) displacements: &'a [[f32; 3]],
    pub(super) q: &'a [f32],
    /// First corners, second ones, third ones.
    pub(super) vertices: &'a [[u32; 4]; 3],
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
