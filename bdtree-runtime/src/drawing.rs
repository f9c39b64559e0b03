//! What programs need that deform and draw whole meshes themselves, on a graphics card for instance: whole
//! sections, the checks that queries otherwise make on the way, and the matrix of a placement.

use bdtree_format::InfluenceRecord;

use crate::bones::BoneMap;
use crate::contact::{TriangleId, VertexId};
use crate::error::{FormatError, PoseError};
use crate::placement::Placement;
use crate::pose::{Pose, checked_q, identity};
use crate::transform::Transform;
use crate::view::Asset;

/// Tells open assets apart: two are equal where they are views of the same bytes at the same address. What is made
/// of an asset keeps it to refuse any other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct AssetId(usize, u32);

/// The affine map `x = linear · p + offset` from stored coordinates to the world, as a placement gives it, in f64.
#[derive(Debug, Clone, Copy)]
pub struct StoredToWorld(Placement);

impl StoredToWorld {
    /// Rows of the linear part: the rotation times [`StoredToWorld::scale`].
    pub fn linear(&self) -> [[f64; 3]; 3] {
        self.0.linear()
    }

    /// The world position of the stored origin (world units).
    pub fn offset(&self) -> [f64; 3] {
        self.0.origin_in_world()
    }

    /// A stored point in the world, to the bit as [`Pose::deformed`] places vertices.
    pub fn point(&self, p: [f32; 3]) -> [f64; 3] {
        self.0.world(p)
    }

    /// World units per stored unit.
    pub fn scale(&self) -> f64 {
        self.0.world_per_stored()
    }

    /// Bound of what rounding in f64 does to this map, to its application in any order, and to
    /// [`Pose::deformed`] of the same point, together: of points within `reach` stored units of the stored origin (world
    /// units; `Placement::error` of docs/design/guarantees.md).
    pub fn error(&self, reach: f64) -> f64 {
        self.0.error(0.0, reach) * self.0.world_per_stored()
    }
}

impl<'p> Pose<'p> {
    /// Where the pose puts stored coordinates.
    pub fn stored_to_world(&self) -> StoredToWorld {
        StoredToWorld(self.placement)
    }

    /// Where the pose puts each bone (stored units), in the order of [`Asset::bones`]; none without a skin. A vertex's are
    /// blended as [`Pose::deformed_stored`] says.
    pub fn bone_maps(&self) -> &'p [BoneMap] {
        self.bones().map_or(&[], |bones| bones.maps)
    }
}

impl<'a> Asset<'a> {
    /// What tells this asset from others that are open.
    pub fn id(&self) -> AssetId {
        let (address, crc) = identity(self);
        AssetId(address, crc)
    }

    /// Where a placement puts stored coordinates.
    ///
    /// # Errors
    /// A placement that [`Asset::pose`] refuses.
    pub fn stored_to_world(
        &self,
        placement: impl Into<Transform>,
    ) -> Result<StoredToWorld, PoseError> {
        Ok(StoredToWorld(Placement::new(
            self,
            &placement.into().checked()?,
        )))
    }

    /// Checks q as [`Asset::pose`] does.
    ///
    /// # Errors
    /// Another length than the asset has modes; an entry that is NaN, infinite or over its mode's hard limit.
    pub fn check_q(&self, q: &[f32]) -> Result<(), PoseError> {
        let modes = self.modes();
        if q.len() != modes.len() {
            return Err(PoseError::ModeCount {
                expected: modes.len(),
                found: q.len(),
            });
        }
        let mut entries = q.iter().zip(modes).enumerate();
        entries.try_for_each(|(mode, (q, record))| checked_q(mode, *q, record).map(|_| ()))
    }

    /// Displacements of all vertices as they lie in the file (stored units per unit of q): for each vertex those of
    /// all modes, or where [`Asset::vertex_modes`] has records those of the modes that it lists.
    pub fn displacement_fields(&self) -> &'a [[f32; 3]] {
        self.displacements
    }

    /// The influences of all vertices, one vertex behind the other, and where each vertex's begin, with one entry more
    /// that ends the last's. Both empty without a skin.
    pub fn all_influences(&self) -> (&'a [u32], &'a [InfluenceRecord]) {
        self.skin
            .map_or((&[], &[]), |skin| (skin.influence_starts, skin.influences))
    }

    /// The mode lists that [`Asset::vertex_modes`] and nodes refer to, one behind the other.
    pub fn mode_list_entries(&self) -> &'a [u16] {
        self.mode_lists
    }

    /// Checks every index that deforming and drawing the whole mesh follows, which [`Asset::open`] leaves
    /// to queries: corners of all triangles, displacements, modes and bones of all vertices. In an asset that passes,
    /// [`Asset::triangle`] and [`Asset::displacements`] fail for none of its ids, and name no others.
    ///
    /// # Errors
    /// The first index that points nowhere.
    pub fn check_mesh(&self) -> Result<(), FormatError> {
        for id in 0..self.triangle_count() as u32 {
            let corners = self.triangle(TriangleId(id))?;
            let count = self.vertex_count();
            if let Some(v) = corners.iter().find(|v| v.0 as usize >= count) {
                return Err(self.unknown_vertex(*v));
            }
        }
        for vertex in (0..self.vertex_count() as u32).map(VertexId) {
            let mut modes = self.displacements(vertex)?.iter().map(|(mode, _)| mode);
            if modes.any(|mode| mode >= self.mode_count()) {
                return Err(self.unknown_mode_of(vertex));
            }
            let influences = self.influences(vertex)?.iter();
            let mut bones = influences.map(|influence| usize::from(influence.bone));
            if bones.any(|bone| bone >= self.bone_count()) {
                return Err(self.unknown_bone(vertex.0 as usize));
            }
        }
        Ok(())
    }
}
