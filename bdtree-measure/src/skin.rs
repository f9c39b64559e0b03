//! The bones of a body, as contenders take them: every vertex is carried by its blended matrix (SPEC 5.9).

use bdtree_build::advise::works::at_rest;
use bdtree_format::InfluenceRecord;
use bdtree_runtime::{Asset, BoneMap, VertexId};

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
    pub(crate) fn carry(&self, first: usize, bones: &[Columns], vertices: &mut [[f32; 3]]) {
        for (vertex, p) in (first..).zip(vertices) {
            let [start, end] = [0, 1].map(|k| self.starts[vertex + k] as usize);
            // From −0, which keeps the sign of a first product that is −0.
            let mut blended = [-0.0_f32; 16];
            for influence in &self.influences[start..end] {
                let Columns(own) = &bones[usize::from(influence.bone)];
                for l in 0..16 {
                    blended[l] += influence.weight * own[l];
                }
            }
            let [x, y, z] = *p;
            let mut carried = [0.0_f32; 4];
            for r in 0..4 {
                carried[r] =
                    blended[r] * x + blended[4 + r] * y + blended[8 + r] * z + blended[12 + r];
            }
            *p = [carried[0], carried[1], carried[2]];
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
