//! A sphere and a box around a whole deformed mesh, from the root node alone.

use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

use super::root_box::RootBox;
use super::unit;
use crate::contact::VertexId;
use crate::error::{FormatError, QueryError};
use crate::math::norm;
use crate::pose::Pose;
use crate::rounding::MARGIN;
use crate::shape::Ray;

/// A ball that holds something. World coordinates.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub struct BoundingSphere {
    /// Its center.
    pub center: [f64; 3],
    /// Its radius.
    pub radius: f64,
}

impl BoundingSphere {
    /// The box around it, rounding included.
    fn aabb(&self) -> Aabb {
        // The sums' own rounding.
        let far = |x: f64| f64::EPSILON * (x.abs() + self.radius);
        Aabb {
            min: self.center.map(|x| x - self.radius - far(x)),
            max: self.center.map(|x| x + self.radius + far(x)),
        }
    }
}

/// A box along the axes of the world that holds something.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb {
    /// Least coordinates.
    pub min: [f64; 3],
    /// Largest coordinates.
    pub max: [f64; 3],
}

impl Aabb {
    /// False only if the ray certainly misses the box, rounding included: whoever asks first whether a ray can meet an
    /// instance misses no hit. True also for what is no ray (NaN, a direction of zero), which queries refuse.
    pub fn intersects_ray(&self, ray: &Ray) -> bool {
        /// What coordinates, their differences and quotients are off by, in shares of the largest number that went in.
        const SHARE: f64 = 16.0 * f64::EPSILON;
        let Ok(direction) = unit(ray.direction, "") else {
            return true;
        };
        let coordinates = self.min.iter().chain(&self.max).chain(&ray.origin);
        let off = SHARE * coordinates.fold(0.0_f64, |most, x| most.max(x.abs()));
        // The stretch of the ray that lies between the faces of all axes so far.
        let (mut start, mut end) = (0.0_f64, ray.max_distance);
        for k in 0..3 {
            let low = self.min[k] - ray.origin[k] - off;
            let high = self.max[k] - ray.origin[k] + off;
            if direction[k] == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return false;
                }
                continue;
            }
            let [a, b] = [low / direction[k], high / direction[k]];
            let (near, far) = (a.min(b), a.max(b));
            start = start.max(near - SHARE * near.abs());
            end = end.min(far + SHARE * far.abs());
        }
        // NaN, of what is no box, is not above.
        !(start > end)
    }

    /// The sphere around it, rounding included.
    fn bounding_sphere(&self) -> BoundingSphere {
        let center = [0, 1, 2].map(|k| 0.5 * self.min[k] + 0.5 * self.max[k]);
        // From the center as rounded.
        let half = [0, 1, 2].map(|k| (self.max[k] - center[k]).max(center[k] - self.min[k]));
        BoundingSphere {
            center,
            radius: norm(half) * (1.0 + MARGIN),
        }
    }
}

impl Pose<'_> {
    /// A sphere that holds every deformed triangle in the world, the leaf arithmetic's rounding
    /// included: what a broad phase over instances compares. One node is evaluated; the sphere
    /// follows q, but it is not the smallest one.
    ///
    /// # Errors
    /// A corrupt asset.
    pub fn bounding_sphere(&self) -> Result<BoundingSphere, QueryError> {
        let (sphere, _) = self.around_root()?;
        let Some(boxed) = self.bone_box().map(|aabb| aabb.bounding_sphere()) else {
            return Ok(sphere);
        };
        // NaN, of a damaged file, is not smaller.
        Ok(if boxed.radius < sphere.radius {
            boxed
        } else {
            sphere
        })
    }

    /// A sphere and a box from the root's spheres.
    fn around_root(&self) -> Result<(BoundingSphere, Aabb), QueryError> {
        let root = self.asset.node(0)?;
        Ok(self.asset.kernel.run(RootBox {
            pose: self,
            spheres: &self.node_spheres(0)?,
            lanes: root.inner_mask | root.leaf_mask,
        }))
    }

    /// The smallest box around the deformed triangles in the world; infinite, and the wrong way round, without any. It
    /// computes every corner: for tools and settings, not for a broad phase ([`Pose::aabb`]).
    ///
    /// # Errors
    /// A corrupt asset.
    pub fn exact_aabb(&self) -> Result<Aabb, FormatError> {
        let mut aabb = Aabb {
            min: [f64::INFINITY; 3],
            max: [f64::NEG_INFINITY; 3],
        };
        for record in self.asset.triangles() {
            for corner in record.corners {
                let x = self.deformed(VertexId(corner))?;
                aabb.min = [0, 1, 2].map(|k| aabb.min[k].min(x[k]));
                aabb.max = [0, 1, 2].map(|k| aabb.max[k].max(x[k]));
            }
        }
        Ok(aabb)
    }

    /// A box that holds every deformed triangle in the world, the leaf arithmetic's rounding included: that
    /// around the spheres of the root's eight parts, so it follows q and the placement, but is not the
    /// smallest one. One node is evaluated. With bones it is the box around what each bone moves, from one pass over the
    /// bones.
    ///
    /// # Errors
    /// A corrupt asset.
    pub fn aabb(&self) -> Result<Aabb, QueryError> {
        self.bounds().map(|(_, aabb)| aabb)
    }

    /// [`Pose::aabb`], and in the same time a sphere that holds the mesh: [`Pose::bounding_sphere`], but with bones the one
    /// around the box.
    ///
    /// # Errors
    /// A corrupt asset.
    pub fn bounds(&self) -> Result<(BoundingSphere, Aabb), QueryError> {
        if let Some(aabb) = self.bone_box() {
            return Ok((aabb.bounding_sphere(), aabb));
        }
        let (all, mut aabb) = self.around_root()?;
        let whole = all.aabb();
        // The whole's sphere holds them too, and may say more where the parts reach far.
        for k in 0..3 {
            aabb.min[k] = aabb.min[k].max(whole.min[k]);
            aabb.max[k] = aabb.max[k].min(whole.max[k]);
        }
        // Parts that are outside of the whole, or missing, are those of a damaged file.
        let is_sound = (0..3).all(|k| aabb.min[k] <= aabb.max[k]);
        Ok((all, if is_sound { aabb } else { whole }))
    }

    /// A sphere in the world around one that holds vertices and lies within `reach` of the origin (both in
    /// stored units).
    pub(crate) fn world_sphere(&self, center: [f32; 3], radius: f64, reach: f64) -> BoundingSphere {
        let center = self.placement.world(center);
        let radius = radius + self.placement.error(norm(center), reach);
        BoundingSphere {
            center,
            radius: radius * self.placement.world_per_stored() * (1.0 + MARGIN),
        }
    }
}
