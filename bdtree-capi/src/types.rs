//! Vectors, placements, shapes and rays. World coordinates and lengths where nothing else is said.
#![allow(unsafe_code)] // names of functions: docs/design/unsafe.md

use bdtree_runtime::{
    Aabb, Ball, BoundingSphere, Capsule, Cuboid, HalfSpace, JointMatrix, Ray, Shape, Transform,
};
use zerocopy::FromBytes;

use crate::status::Fault;

/// In place of a number where there is none.
pub const BDT_NONE: u32 = u32::MAX;

/// A point or vector.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtVec3 {
    /// Along the first axis.
    pub x: f64,
    /// Along the second axis.
    pub y: f64,
    /// Along the third axis.
    pub z: f64,
}

impl From<[f64; 3]> for BdtVec3 {
    fn from([x, y, z]: [f64; 3]) -> Self {
        Self { x, y, z }
    }
}

impl From<BdtVec3> for [f64; 3] {
    fn from(BdtVec3 { x, y, z }: BdtVec3) -> Self {
        [x, y, z]
    }
}

/// A rotation: a quaternion within 1e-3 of unit length. The identity is (0, 0, 0, 1).
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtQuat {
    /// First imaginary part.
    pub x: f64,
    /// Second imaginary part.
    pub y: f64,
    /// Third imaginary part.
    pub z: f64,
    /// Real part.
    pub w: f64,
}

impl From<[f64; 4]> for BdtQuat {
    fn from([x, y, z, w]: [f64; 4]) -> Self {
        Self { x, y, z, w }
    }
}

impl From<BdtQuat> for [f64; 4] {
    fn from(BdtQuat { x, y, z, w }: BdtQuat) -> Self {
        [x, y, z, w]
    }
}

/// Where a mesh stands: world = rotation · (scale · mesh) + translation.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtTransform {
    /// From the mesh's axes to the world's.
    pub rotation: BdtQuat,
    /// World units; at most 2^80.
    pub translation: BdtVec3,
    /// World units per mesh unit: 2^-60 to 2^60.
    pub scale: f64,
}

impl From<Transform> for BdtTransform {
    fn from(at: Transform) -> Self {
        Self {
            rotation: at.rotation.into(),
            translation: at.translation.into(),
            scale: at.scale,
        }
    }
}

impl From<BdtTransform> for Transform {
    fn from(at: BdtTransform) -> Self {
        Self {
            rotation: at.rotation.into(),
            translation: at.translation.into(),
            scale: at.scale,
        }
    }
}

/// An affine map of points: row r of the result is `rows[r]` · (x, y, z, 1). Of a joint: from its space to the model's
/// (mesh units).
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtMatrix {
    /// Three rows of four numbers.
    pub rows: [[f64; 4]; 3],
}

impl From<JointMatrix> for BdtMatrix {
    fn from(rows: JointMatrix) -> Self {
        Self { rows }
    }
}

impl From<BdtMatrix> for JointMatrix {
    fn from(matrix: BdtMatrix) -> Self {
        matrix.rows
    }
}

/// A ray from `origin` along `direction`.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtRay {
    /// Finite, at most 2^100.
    pub origin: BdtVec3,
    /// Finite, not zero, of any length.
    pub direction: BdtVec3,
    /// Not negative; INFINITY (or anything above 2^100) for a ray without end.
    pub max_distance: f64,
}

impl From<BdtRay> for Ray {
    #[inline]
    fn from(ray: BdtRay) -> Self {
        Self {
            origin: ray.origin.into(),
            direction: ray.direction.into(),
            max_distance: ray.max_distance,
        }
    }
}

/// `BdtShape::kind`: all points within `size` of `a`.
pub const BDT_BALL: u32 = 1;
/// `BdtShape::kind`: all points within `size` of the segment from `a` to `b`.
pub const BDT_CAPSULE: u32 = 2;
/// `BdtShape::kind`: the box about `a`, turned by `rotation`, with the half edges `b`.
pub const BDT_CUBOID: u32 = 3;
/// `BdtShape::kind`: all points x with a · x <= size, the normal a being scaled to unit length first.
pub const BDT_HALF_SPACE: u32 = 4;

/// A closed shape, made by `bdt_ball`, `bdt_capsule`, `bdt_cuboid` or `bdt_half_space`. Coordinates and lengths are
/// finite and at most 2^100; radii and half edges are not negative.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtShape {
    /// `BDT_BALL`, `BDT_CAPSULE`, `BDT_CUBOID` or `BDT_HALF_SPACE`.
    pub kind: u32,
    /// 0.
    pub reserved: u32,
    /// Center, one end, or normal.
    pub a: BdtVec3,
    /// The other end, or half edges.
    pub b: BdtVec3,
    /// Of a box.
    pub rotation: BdtQuat,
    /// Radius, or height of the plane along the unit normal.
    pub size: f64,
}

impl BdtShape {
    /// The runtime's.
    #[inline]
    pub(crate) fn checked(&self) -> Result<Shape, Fault> {
        let (a, b): ([f64; 3], [f64; 3]) = (self.a.into(), self.b.into());
        Ok(match self.kind {
            BDT_BALL => Ball::new(a, self.size).into(),
            BDT_CAPSULE => Capsule::new(a, b, self.size).into(),
            BDT_CUBOID => Cuboid {
                center: a,
                rotation: self.rotation.into(),
                half_extents: b,
            }
            .into(),
            BDT_HALF_SPACE => HalfSpace::new(a, self.size).into(),
            _ => return Err(Fault::Argument("shape: of no known kind")),
        })
    }
}

/// No rotation.
const UPRIGHT: BdtQuat = BdtQuat {
    x: 0.0,
    y: 0.0,
    z: 0.0,
    w: 1.0,
};

const NOWHERE: BdtVec3 = BdtVec3 {
    x: 0.0,
    y: 0.0,
    z: 0.0,
};

const NOTHING: BdtShape = BdtShape {
    kind: 0,
    reserved: 0,
    a: NOWHERE,
    b: NOWHERE,
    rotation: UPRIGHT,
    size: 0.0,
};

/// Makes a ball from its center and radius (world). Checked by the call that takes it. Thread-safety: any.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_ball(center: BdtVec3, radius: f64) -> BdtShape {
    BdtShape {
        kind: BDT_BALL,
        a: center,
        size: radius,
        ..NOTHING
    }
}

/// Makes a capsule from the ends of its segment and its radius (world). Checked by the call that takes it.
/// Thread-safety: any.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_capsule(a: BdtVec3, b: BdtVec3, radius: f64) -> BdtShape {
    BdtShape {
        kind: BDT_CAPSULE,
        a,
        b,
        size: radius,
        ..NOTHING
    }
}

/// Makes a box from its center, the rotation from its axes to the world's, and half its edges along its own axes (world
/// units). Checked by the call that takes it. Thread-safety: any.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_cuboid(
    center: BdtVec3,
    rotation: BdtQuat,
    half_extents: BdtVec3,
) -> BdtShape {
    BdtShape {
        kind: BDT_CUBOID,
        a: center,
        b: half_extents,
        rotation,
        ..NOTHING
    }
}

/// Makes the half-space below the plane at height `offset` along the normal (world), which may have any length but 0.
/// Checked by the call that takes it. Thread-safety: any.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_half_space(normal: BdtVec3, offset: f64) -> BdtShape {
    BdtShape {
        kind: BDT_HALF_SPACE,
        a: normal,
        size: offset,
        ..NOTHING
    }
}

/// A plane (n, d) of a region: the points x with n · x + d >= 0. The normal may have any length but 0.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtPlane {
    /// Into the region.
    pub normal: BdtVec3,
    /// Minus the height of the plane along the normal, times the normal's length.
    pub d: f64,
}

/// A box along the axes of the world that holds something.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtAabb {
    /// Least coordinates.
    pub min: BdtVec3,
    /// Largest coordinates.
    pub max: BdtVec3,
}

impl From<Aabb> for BdtAabb {
    fn from(aabb: Aabb) -> Self {
        Self {
            min: aabb.min.into(),
            max: aabb.max.into(),
        }
    }
}

/// A sphere that holds something. World coordinates.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtSphere {
    /// Its center.
    pub center: BdtVec3,
    /// Its radius.
    pub radius: f64,
}

impl From<BoundingSphere> for BdtSphere {
    fn from(sphere: BoundingSphere) -> Self {
        Self {
            center: sphere.center.into(),
            radius: sphere.radius,
        }
    }
}

impl From<BdtSphere> for BoundingSphere {
    fn from(sphere: BdtSphere) -> Self {
        Self {
            center: sphere.center.into(),
            radius: sphere.radius,
        }
    }
}

// What other languages lay out by hand.
const _: () = {
    assert!(size_of::<BdtVec3>() == 24);
    assert!(size_of::<BdtQuat>() == 32);
    assert!(size_of::<BdtTransform>() == 64);
    assert!(size_of::<BdtMatrix>() == 96);
    assert!(size_of::<BdtRay>() == 56);
    assert!(size_of::<BdtShape>() == 96);
    assert!(size_of::<BdtPlane>() == 32);
    assert!(size_of::<BdtAabb>() == 48);
    assert!(size_of::<BdtSphere>() == 32);
};
