//! Deformed vertices: all of them, or the corners of four triangles.

use bdtree_format::TriangleRecord;

use crate::contact::VertexId;
use crate::error::{FormatError, QueryError};
use crate::pose::Pose;
use crate::simd::{Four, Lanes, Work};
use crate::view::Asset;

/// Vertices that are deformed together: the corners of four triangles.
pub(super) const TOGETHER: usize = 12;

/// Where deformed corners come from (stored units).
pub(super) trait Deformed: Copy {
    /// Hands over each coordinate of each corner of four triangles: corner, axis and the four numbers.
    ///
    /// # Errors
    /// A vertex that the asset does not have.
    fn corners<L: Lanes>(
        self,
        asset: &Asset<'_>,
        four: [&TriangleRecord; 4],
        take: impl FnMut(usize, usize, Four),
    ) -> Result<(), FormatError>;
}

/// From all vertices, which are deformed already; the fourth number is not used.
impl Deformed for &[[f32; 4]] {
    #[inline(always)]
    fn corners<L: Lanes>(
        self,
        asset: &Asset<'_>,
        four: [&TriangleRecord; 4],
        mut take: impl FnMut(usize, usize, Four),
    ) -> Result<(), FormatError> {
        for i in 0..3 {
            let mut rows = [Four::splat(0.0); 4];
            for k in 0..4 {
                let vertex = four[k].corners[i];
                let Some(at) = self.get(vertex as usize) else {
                    return Err(asset.unknown_vertex(VertexId(vertex)));
                };
                rows[k] = Four::load(at);
            }
            let columns = Four::transposed(rows);
            for axis in 0..3 {
                take(i, axis, columns[axis]);
            }
        }
        Ok(())
    }
}

/// Deformed where they are needed: a vertex for each of its triangles. For some triangles that takes less time than finding out which
/// vertices they share.
impl Deformed for &Pose<'_> {
    #[inline(always)]
    fn corners<L: Lanes>(
        self,
        asset: &Asset<'_>,
        four: [&TriangleRecord; 4],
        mut take: impl FnMut(usize, usize, Four),
    ) -> Result<(), FormatError> {
        let mut corners = [[[0.0; 4]; 3]; 3];
        asset.deform_four::<L>(self, four, &mut corners)?;
        for i in 0..3 {
            for axis in 0..3 {
                take(i, axis, Four::load(&corners[i][axis]));
            }
        }
        Ok(())
    }
}

/// Vertices to deform, from one on; the fourth number is not used.
#[derive(Debug)]
pub(super) struct Vertices<'p> {
    pub(super) pose: &'p Pose<'p>,
    pub(super) first: u32,
    pub(super) out: &'p mut [[f32; 4]],
}

/// To the bit as [`Pose::deformed_stored`] says.
impl Work for Vertices<'_> {
    type Output = Result<(), QueryError>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Self {
            pose,
            mut first,
            out,
        } = self;
        let (twelves, rest) = out.as_chunks_mut::<TOGETHER>();
        for twelve in twelves {
            // Twelve corners of four triangles.
            let record = |k: u32| TriangleRecord {
                corners: [first + k, first + 4 + k, first + 8 + k],
                id: 0,
            };
            let records = [record(0), record(1), record(2), record(3)];
            let [a, b, c, d] = &records;
            let mut corners = [[[0.0; 4]; 3]; 3];
            pose.asset
                .deform_four::<L>(pose, [a, b, c, d], &mut corners)?;
            let (fours, _) = twelve.as_chunks_mut::<4>();
            for (four, [x, y, z]) in fours.iter_mut().zip(&corners) {
                let columns = [
                    Four::load(x),
                    Four::load(y),
                    Four::load(z),
                    Four::splat(0.0),
                ];
                let rows = Four::transposed(columns);
                for k in 0..4 {
                    four[k] = rows[k].store();
                }
            }
            first += TOGETHER as u32;
        }
        for vertex in rest {
            let [x, y, z] = pose.deformed_stored(VertexId(first))?;
            *vertex = [x, y, z, 0.0];
            first += 1;
        }
        Ok(())
    }
}
