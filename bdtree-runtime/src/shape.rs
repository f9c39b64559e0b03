//! Shapes as values: what a deformed mesh is tested against. World coordinates and lengths.
//!
//! A shape is made without a check; the query that takes it refuses coordinates or lengths that are not
//! finite or beyond 2^100, negative lengths and zero directions, and names the field.

pub use crate::narrow::{Frustum, FrustumState};
use crate::vector::{Quat, Vec3};

/// The shapes that [`Query::contacts`](crate::Query::contacts) and [`Query::intersects`](crate::Query::intersects) take,
/// in world coordinates and lengths; pass a [`Ball`], [`Capsule`], [`Cuboid`] or [`HalfSpace`] as it is.
///
/// Shapes are closed: a triangle that touches the boundary touches the shape. They are made without a check; the query
/// refuses coordinates and lengths that are not finite or beyond 2^100, negative lengths and zero normals, with
/// [`QueryError::Argument`](crate::QueryError::Argument), which names the field.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Shape {
    /// All points within a distance of one.
    Ball(Ball),
    /// All points within a distance of a segment.
    Capsule(Capsule),
    /// A box, turned as you like.
    Cuboid(Cuboid),
    /// All points on one side of a plane.
    HalfSpace(HalfSpace),
}

/// All points within `radius` of `center`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball {
    /// Its center.
    pub center: [f64; 3],
    /// Not negative; 0 tests the center alone.
    pub radius: f64,
}

impl Ball {
    /// A ball about a point.
    pub fn new(center: impl Into<Vec3>, radius: f64) -> Self {
        let Vec3(center) = center.into();
        Self { center, radius }
    }
}

/// All points within `radius` of the segment from `a` to `b`. With `a = b` it is a ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Capsule {
    /// One end of the segment.
    pub a: [f64; 3],
    /// The other end.
    pub b: [f64; 3],
    /// Not negative; 0 tests the segment alone.
    pub radius: f64,
}

impl Capsule {
    /// A capsule about the segment between two points.
    pub fn new(a: impl Into<Vec3>, b: impl Into<Vec3>, radius: f64) -> Self {
        let (Vec3(a), Vec3(b)) = (a.into(), b.into());
        Self { a, b, radius }
    }
}

/// A closed box about `center`, whose axes are turned by `rotation`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cuboid {
    /// Its center.
    pub center: [f64; 3],
    /// Quaternion (x, y, z, w), within 1e-3 of unit length; it is normalised first.
    pub rotation: [f64; 4],
    /// Half the edges along its own axes; not negative, may be 0.
    pub half_extents: [f64; 3],
}

impl Cuboid {
    /// A box along the axes of the world.
    pub fn new(center: impl Into<Vec3>, half_extents: impl Into<Vec3>) -> Self {
        let (Vec3(center), Vec3(half_extents)) = (center.into(), half_extents.into());
        Self {
            center,
            rotation: [0.0, 0.0, 0.0, 1.0],
            half_extents,
        }
    }

    /// The same box turned about its center: `rotation` takes the place of the one before.
    pub fn rotated(self, rotation: impl Into<Quat>) -> Self {
        let Quat(rotation) = rotation.into();
        Self { rotation, ..self }
    }
}

/// All points x with `normal · x ≤ offset`, `normal` being normalised first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfSpace {
    /// Out of the half-space; of any length but 0.
    pub normal: [f64; 3],
    /// Height of the boundary along the unit normal.
    pub offset: f64,
}

impl HalfSpace {
    /// What lies below the plane at height `offset` along `normal`.
    pub fn new(normal: impl Into<Vec3>, offset: f64) -> Self {
        let Vec3(normal) = normal.into();
        Self { normal, offset }
    }
}

/// A ray from `origin` along `direction`, up to `max_distance`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it starts: finite, at most 2^100.
    pub origin: [f64; 3],
    /// Where it goes: finite, not zero, of any length, since it is normalised first.
    pub direction: [f64; 3],
    /// How far it goes: not negative; above 2^100 without end.
    pub max_distance: f64,
}

impl Ray {
    /// A ray without end.
    pub fn new(origin: impl Into<Vec3>, direction: impl Into<Vec3>) -> Self {
        let (Vec3(origin), Vec3(direction)) = (origin.into(), direction.into());
        Self {
            origin,
            direction,
            max_distance: f64::INFINITY,
        }
    }

    /// The same ray up to a distance.
    pub fn with_max_distance(self, max_distance: f64) -> Self {
        Self {
            max_distance,
            ..self
        }
    }
}

macro_rules! shapes {
    ($($shape:ident),*) => {$(
        impl From<$shape> for Shape {
            fn from(shape: $shape) -> Self {
                Self::$shape(shape)
            }
        }
    )*};
}
shapes!(Ball, Capsule, Cuboid, HalfSpace);
