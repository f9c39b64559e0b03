//! A sphere and a box around a whole deformed mesh, from the root node alone.

use bdtree_format::LANES;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

use super::unit;
use crate::bound::Spheres;
use crate::contact::VertexId;
use crate::error::{FormatError, QueryError};
use crate::math::{norm, sub};
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
        let root = self.asset.node(0)?;
        let spheres = self.node_spheres(0)?;
        let (center, radius) = around(&spheres, root.inner_mask | root.leaf_mask);
        // No vertex is farther from the origin than B; a radius that is NaN is not smaller.
        let all = self.reach + f64::from(self.slack);
        let (center, radius) = if radius < all {
            (center, radius)
        } else {
            ([0.0; 3], all)
        };
        let sphere = self.world_sphere(center, radius, self.reach);
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
        if let Some(aabb) = self.bone_box() {
            return Ok(aabb);
        }
        let root = self.asset.node(0)?;
        let spheres = self.node_spheres(0)?;
        let all = self.bounding_sphere()?;
        let whole = all.aabb();
        let mut aabb = Aabb {
            min: [f64::INFINITY; 3],
            max: [f64::NEG_INFINITY; 3],
        };
        for lane in (0..LANES).filter(|k| (root.inner_mask | root.leaf_mask) & (1 << k) != 0) {
            let center = spheres.center.map(|row| row[lane]);
            let radius = f64::from(spheres.radius[lane]);
            // A lane's center lies within twice the reach (docs/design/guarantees.md).
            let part = self.world_sphere(center, radius, 2.0 * self.reach);
            // Anything but a smaller radius, NaN of a corrupt file included, says no more than the whole.
            let part = if part.radius < all.radius { part } else { all }.aabb();
            for k in 0..3 {
                aabb.min[k] = aabb.min[k].min(part.min[k]);
                aabb.max[k] = aabb.max[k].max(part.max[k]);
            }
        }
        // The whole's sphere holds them too, and may say more where the parts reach far.
        for k in 0..3 {
            aabb.min[k] = aabb.min[k].max(whole.min[k]);
            aabb.max[k] = aabb.max[k].min(whole.max[k]);
        }
        // Parts that are outside of the whole, or missing, are those of a damaged file.
        let is_sound = (0..3).all(|k| aabb.min[k] <= aabb.max[k]);
        Ok(if is_sound { aabb } else { whole })
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

/// A sphere around those of some lanes (stored units): about the middle of their box, which f32
/// holds exactly enough since the radius is formed about what it holds.
fn around(spheres: &Spheres, lanes: u8) -> ([f32; 3], f64) {
    let used = || (0..LANES).filter(|k| lanes & (1 << k) != 0);
    let center = [0, 1, 2].map(|axis| {
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for k in used() {
            low = low.min(spheres.center[axis][k] - spheres.radius[k]);
            high = high.max(spheres.center[axis][k] + spheres.radius[k]);
        }
        0.5 * low + 0.5 * high
    });
    // Without lanes, which no sound root is, nothing is known.
    let mut radius = if lanes == 0 { f64::INFINITY } else { 0.0 };
    for k in used() {
        let apart = [0, 1, 2].map(|axis| f64::from(spheres.center[axis][k]));
        let apart = norm(sub(apart, center.map(f64::from)));
        let reach = apart * (1.0 + MARGIN) + f64::from(spheres.radius[k]);
        // Anything but "not larger" counts, so that NaN stays.
        let within = reach <= radius;
        radius = if within { radius } else { reach };
        if reach.is_nan() {
            break;
        }
    }
    (center, radius)
}
