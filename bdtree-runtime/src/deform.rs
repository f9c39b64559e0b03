//! The leaf arithmetic: deformed vertices, only where a query touches them.

use bdtree_format::{SectionKind, TriangleRecord};

use crate::bones::PosedBones;
use crate::contact::{TriangleId, VertexId};
use crate::error::FormatError;
use crate::pose::Pose;
use crate::simd::{Fields, Four, LINE, Lanes, prefetch, prefetch_from, prefetch_lines};
use crate::view::Asset;

impl Pose<'_> {
    /// The deformed position of a vertex in the world: f64 from the stored position on.
    ///
    /// # Errors
    /// If the id is not below [`Asset::vertex_count`] (`found` is the id, `expected` the count); a corrupt asset.
    #[inline]
    pub fn deformed(&self, vertex: VertexId) -> Result<[f64; 3], FormatError> {
        Ok(self.placement.world(self.deformed_stored(vertex)?))
    }

    /// The deformed position of a vertex, relative to the origin (stored units), by the leaf arithmetic (SPEC 5.5):
    /// `p'_i = p_i + (((U_i1 q_1) + U_i2 q_2) + …)` (paper, eq. 1) over the modes that are stored for it, f32,
    /// products and sums rounded separately, modes in order, p last. The same bits on every processor. Bones then move it
    /// by their blended matrix (SPEC 5.9): `M = Σ_b w_b T_b`, influences in order, then `M x`.
    ///
    /// # Errors
    /// Those of [`Pose::deformed`].
    #[inline]
    pub fn deformed_stored(&self, vertex: VertexId) -> Result<[f32; 3], FormatError> {
        let moved = self.before_bones(vertex)?;
        match self.bones() {
            Some(bones) => self.asset.carried_vertex(bones, vertex.0 as usize, moved),
            None => Ok(moved),
        }
    }

    /// `p_i + Σ_j U_ij q_j`: [`Pose::deformed_stored`] without bones.
    #[inline]
    pub(crate) fn before_bones(&self, vertex: VertexId) -> Result<[f32; 3], FormatError> {
        if self.asset.lists_modes() {
            self.asset.deformed_listed(self.q, vertex)
        } else {
            self.asset.deformed_in::<false>(self.q, vertex)
        }
    }

    /// The deformed corners of a triangle in the world.
    ///
    /// # Errors
    /// If the id is not below [`Asset::triangle_count`] (`found` is the id, `expected` the count); a corrupt asset.
    pub fn deformed_triangle(&self, triangle: TriangleId) -> Result<[[f64; 3]; 3], FormatError> {
        let [a, b, c] = self.asset.triangle(triangle)?;
        Ok([self.deformed(a)?, self.deformed(b)?, self.deformed(c)?])
    }
}

impl Asset<'_> {
    /// Not inlined: beside it the loop over all modes would be compiled worse.
    #[inline(never)]
    fn deformed_listed(&self, q: &[f32], vertex: VertexId) -> Result<[f32; 3], FormatError> {
        self.deformed_in::<true>(q, vertex)
    }

    /// [`Pose::deformed_stored`] for the layout of displacements that the asset has: `LISTED` is
    /// [`Asset::lists_modes`], which traversals ask once, since in one piece of code each layout
    /// slows down the other.
    #[inline(always)]
    fn deformed_in<const LISTED: bool>(
        &self,
        q: &[f32],
        vertex: VertexId,
    ) -> Result<[f32; 3], FormatError> {
        let i = vertex.0 as usize;
        let Some(p) = self.positions.get(i) else {
            return Err(self.unknown_vertex(vertex));
        };
        // The sum starts with the first product, not with 0: adding to +0 would turn −0 into +0
        // and nothing else, and p is added last anyway, so starting from −0 keeps every bit.
        let mut sum = [-0.0_f32; 3];
        if LISTED {
            let (fields, modes) = self.listed_displacements(vertex)?;
            for (u, mode) in fields.iter().zip(modes) {
                let Some(q) = q.get(usize::from(*mode)) else {
                    return Err(self.unknown_mode_of(vertex));
                };
                for k in 0..3 {
                    sum[k] += u[k] * q;
                }
            }
        } else {
            let m = q.len();
            let start = i * m;
            let Some(fields) = self.displacements.get(start..start + m) else {
                return Err(self.out_of_range(
                    SectionKind::DISPLACEMENTS,
                    start + m,
                    self.displacements.len(),
                    12,
                ));
            };
            for (u, q) in fields.iter().zip(q) {
                for k in 0..3 {
                    sum[k] += u[k] * q;
                }
            }
        }
        Ok([p[0] + sum[0], p[1] + sum[1], p[2] + sum[2]])
    }

    /// Puts the deformed corners of four triangles into `corners`: of each corner, of each coordinate,
    /// that of the four (stored units). To the bit as [`Pose::deformed_stored`] says.
    ///
    /// A corner that several of them share is deformed once for each: side by side that takes less time
    /// than finding out.
    #[inline(always)]
    pub(crate) fn deform_four<L: Lanes>(
        &self,
        pose: &Pose<'_>,
        records: [&TriangleRecord; 4],
        corners: &mut [[[f32; 4]; 3]; 3],
    ) -> Result<(), FormatError> {
        let [a, b, c, d] = records.map(|record| record.corners);
        let vertices = [0, 1, 2].map(|i| [a[i], b[i], c[i], d[i]]);
        // In lists of modes no four have the same.
        let fields = if self.lists_modes() {
            None
        } else {
            Fields::of(self.positions, self.displacements, pose.q, &vertices)
        };
        match fields {
            Some(fields) => *corners = L::moved(&fields),
            // With bones already.
            None => return deform_singly(pose, &vertices, corners),
        }
        match pose.bones() {
            Some(bones) => self.carry_four(bones, &vertices, corners),
            None => Ok(()),
        }
    }

    /// A vertex carried by its bones, of the bits that SPEC 5.9 says.
    #[inline(always)]
    fn carried_vertex(
        &self,
        bones: &PosedBones<'_>,
        vertex: usize,
        [x, y, z]: [f32; 3],
    ) -> Result<[f32; 3], FormatError> {
        let blended = self.blended(bones, vertex)?;
        Ok(blended.map(|[a, b, c, t]| a * x + b * y + c * z + t))
    }

    /// `M = Σ_b w_b T_b` of a vertex (SPEC 5.9).
    #[inline(always)]
    pub(crate) fn blended(
        &self,
        bones: &PosedBones<'_>,
        vertex: usize,
    ) -> Result<[[f32; 4]; 3], FormatError> {
        let [x, y, z] = self.blended_rows(bones, vertex)?;
        Ok([x.store(), y.store(), z.store()])
    }

    #[inline(always)]
    fn blended_rows(
        &self,
        bones: &PosedBones<'_>,
        vertex: usize,
    ) -> Result<[Four; 3], FormatError> {
        let skin = self.skin.as_ref();
        let Some(influences) = skin.and_then(|skin| skin.influences_of(vertex)) else {
            return Err(self.unknown_bone(vertex));
        };
        // The sum starts with the first product: −0 keeps its bits.
        let mut blended = [Four::splat(-0.0); 3];
        for influence in influences {
            let Some(map) = bones.maps.get(usize::from(influence.bone)) else {
                return Err(self.unknown_bone(vertex));
            };
            let weight = Four::splat(influence.weight);
            for r in 0..3 {
                blended[r] = blended[r].add(weight.mul(Four::load(&map.rows[r])));
            }
        }
        Ok(blended)
    }

    /// [`Asset::carried_vertex`] for the corners of four triangles.
    ///
    /// Not inlined: beside it the loops of assets without bones would be compiled worse.
    #[inline(never)]
    fn carry_four(
        &self,
        bones: &PosedBones<'_>,
        vertices: &[[u32; 4]; 3],
        corners: &mut [[[f32; 4]; 3]; 3],
    ) -> Result<(), FormatError> {
        for (vertices, corner) in vertices.iter().zip(corners) {
            let mut blended = [[Four::splat(0.0); 3]; 4];
            for k in 0..4 {
                blended[k] = self.blended_rows(bones, vertices[k] as usize)?;
            }
            let [x, y, z] = [
                Four::load(&corner[0]),
                Four::load(&corner[1]),
                Four::load(&corner[2]),
            ];
            for r in 0..3 {
                let [i, j, k, l] = blended;
                let [a, b, c, t] = Four::transposed([i[r], j[r], k[r], l[r]]);
                let sum = a.mul(x).add(b.mul(y)).add(c.mul(z));
                corner[r] = sum.add(t).store();
            }
        }
        Ok(())
    }

    /// Asks for the numbers of triangles' vertices: their addresses follow no pattern, and all of them
    /// together take hardly longer than one. A shared corner is asked for each time.
    pub(crate) fn prefetch_vertices(&self, records: &[TriangleRecord]) {
        if self.lists_modes() {
            return self.prefetch_listed_vertices(records);
        }
        let m = self.modes.len();
        // Of a known number of lines each is one instruction: up to 21 modes.
        match (m * size_of::<[f32; 3]>()).div_ceil(LINE) {
            1 => self.prefetch_fields::<1>(records),
            2 => self.prefetch_fields::<2>(records),
            3 => self.prefetch_fields::<3>(records),
            4 => self.prefetch_fields::<4>(records),
            _ => self.prefetch_fields::<0>(records),
        }
    }

    /// Vertices whose displacements fill so many lines; 0: any number.
    #[inline(always)]
    fn prefetch_fields<const LINES: usize>(&self, records: &[TriangleRecord]) {
        let fields = self.displacements.as_ptr();
        for record in records {
            for vertex in record.corners {
                let i = vertex as usize;
                if let Some(p) = self.positions.get(i) {
                    prefetch(p);
                    let (m, first) = (self.modes.len(), i.wrapping_mul(self.modes.len()));
                    if LINES == 0 {
                        prefetch_from(self.displacements, first, m);
                    } else {
                        prefetch_lines::<LINES, _>(fields.wrapping_add(first));
                    }
                }
            }
        }
    }

    /// Not inlined: see [`Asset::deformed_in`].
    #[inline(never)]
    fn prefetch_listed_vertices(&self, records: &[TriangleRecord]) {
        for i in records.iter().flat_map(|record| record.corners) {
            let i = i as usize;
            let Some(p) = self.positions.get(i) else {
                continue; // the visit says so
            };
            prefetch(p);
            let records = self.vertex_modes_of(i);
            let entries =
                records.map(|[own, next]| own.first_entry as usize..next.first_entry as usize);
            if let Some(fields) = entries.and_then(|entries| self.displacements.get(entries)) {
                // No more than a vertex can have, whatever the file says.
                prefetch_from(fields, 0, fields.len().min(self.modes.len()));
            }
        }
    }
}

#[inline(never)]
fn deform_singly(
    pose: &Pose<'_>,
    vertices: &[[u32; 4]; 3],
    corners: &mut [[[f32; 4]; 3]; 3],
) -> Result<(), FormatError> {
    for (vertices, corner) in vertices.iter().zip(corners) {
        for k in 0..4 {
            let point = pose.deformed_stored(VertexId(vertices[k]))?;
            for axis in 0..3 {
                corner[axis][k] = point[axis];
            }
        }
    }
    Ok(())
}
