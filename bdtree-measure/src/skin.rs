//! The bones of a body, as contenders take them: every vertex is carried by its blended matrix (SPEC 5.9).

use bdtree_build::advise::works::at_rest;
use bdtree_format::InfluenceRecord;
use bdtree_runtime::{Asset, BoneMap, VertexId};
use glam::Vec4;
use pulp::Simd;

use crate::MeasureError;

/// Which bones carry each vertex, and where they carry it at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct BodySkin {
    /// First influence of each vertex, and the end of the last one's: N + 1 numbers.
    starts: Vec<u32>,
    influences: Vec<InfluenceRecord>,
    /// Vertices as the source shows them without an animation (stored units).
    pub(crate) rest: Vec<[f32; 3]>,
}

impl BodySkin {
    /// An asset's; `None` where it has none.
    ///
    /// # Errors
    /// Records that break the format's rules.
    pub fn of_asset(asset: &Asset<'_>) -> Result<Option<Self>, MeasureError> {
        if !asset.has_skin() {
            return Ok(None);
        }
        let (mut starts, mut influences) = (vec![0], Vec::new());
        for vertex in (0..asset.vertex_count() as u32).map(VertexId) {
            influences.extend_from_slice(asset.influences(vertex)?);
            starts.push(influences.len() as u32);
        }
        Ok(Some(Self {
            starts,
            influences,
            // Here influences of bones that are not there are told.
            rest: at_rest(asset)?.into_owned(),
        }))
    }

    /// Carries vertices, of which `first` is the first's number, by bones of [`Columns`]: influences in order, products
    /// and sums rounded separately.
    #[inline(always)]
    pub(crate) fn carry<S: Simd>(
        &self,
        simd: S,
        first: usize,
        bones: &[Columns],
        vertices: &mut [[f32; 3]],
    ) {
        for (vertex, p) in (first..).zip(vertices) {
            let (start, end) = (self.starts[vertex], self.starts[vertex + 1]);
            let influences = &self.influences[start as usize..end as usize];
            let mut blended = Columns([0.0; 16]);
            // Vector after vector in registers: left alone, the compiler blends number by number.
            for (k, out) in S::as_mut_simd_f32s(&mut blended.0).0.iter_mut().enumerate() {
                // From −0, which keeps the sign of a first product that is −0.
                let mut sum = simd.splat_f32s(-0.0);
                for influence in influences {
                    let own = S::as_simd_f32s(&bones[usize::from(influence.bone)].0).0[k];
                    sum = simd.add_f32s(sum, simd.mul_f32s(simd.splat_f32s(influence.weight), own));
                }
                *out = sum;
            }
            let [x, y, z] = *p;
            let Columns(m) = &blended;
            let column = |c: usize| Vec4::from_slice(&m[4 * c..]);
            let carried = column(0) * x + column(1) * y + column(2) * z + column(3);
            *p = carried.truncate().to_array();
        }
    }
}

/// A bone's map by columns: three times four numbers of A, then t. So all three rows of a product are made at once, and
/// no vector is added up within itself. The fourth row is 0 and fills the vectors.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Columns([f32; 16]);

impl Columns {
    #[inline(always)]
    pub(crate) fn of(map: &BoneMap) -> Self {
        let rows = map.rows();
        let mut columns = [0.0; 16];
        for r in 0..3 {
            for c in 0..4 {
                columns[4 * c + r] = rows[r][c];
            }
        }
        Self(columns)
    }
}
