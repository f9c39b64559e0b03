//! Questions about one instance.
#![allow(unsafe_code)] // names of functions: docs/design/unsafe.md

use std::cell::Cell;
use std::ffi::c_void;
use std::mem::MaybeUninit;

use bdtree_runtime::{Budgeted, Frustum, FrustumState, Ray, RayIntersection, Shape};

use crate::answers::{BdtBound, BdtContact, BdtHit, BdtLane};
use crate::border::{Handle, In, Out, call, done};
use crate::instance::BdtInstance;
use crate::sink::{Array, Callback};
use crate::status::{BdtStatus, Fault};
use crate::types::{BdtPlane, BdtRay, BdtShape, BdtVec3};
use crate::workspace::{BdtWorkspace, ask};

/// Takes a contact, which is gone when it returns. Returns 0 to go on, anything else to end the query. It must neither
/// throw nor jump away; calls with the same workspace or instance return `BDT_STATUS_ERROR_BUSY`.
pub type BdtOnContact =
    Option<extern "C" fn(contact: *const BdtContact, context: *mut c_void) -> i32>;

/// Takes a hit, as `BdtOnContact` a contact.
pub type BdtOnHit = Option<extern "C" fn(hit: *const BdtHit, context: *mut c_void) -> i32>;

/// Writes every triangle that the shape touches, in no order that means anything. Meshes are surfaces, not solids: a ball
/// wholly inside a closed mesh touches nothing.
/// `shape`: world. `out`: room for `capacity` contacts (may be NULL with 0); `count`: how many there are, written even
/// when they do not fit.
/// Errors: `BDT_STATUS_TRUNCATED`, `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_ARGUMENT`, `_FORMAT` (a damaged file).
/// Thread-safety: one thread at a time per workspace and per instance (`bdt_workspace_set_shared`).
#[unsafe(no_mangle)]
pub extern "C" fn bdt_contacts(
    workspace: Handle<BdtWorkspace>,
    instance: Handle<BdtInstance>,
    shape: In<BdtShape>,
    mut out: Out<BdtContact>,
    capacity: usize,
    mut count: Out<usize>,
) -> BdtStatus {
    call(|| {
        let shape = shape.one("shape")?.checked()?;
        let mut array = Array::new(&mut out, capacity, &mut count)?;
        ask(&workspace, &instance, false, |asked| {
            if asked.has_limit() {
                let Shape::Ball(ball) = shape else {
                    return Err(Fault::Argument(
                        "max_visits: contacts of balls alone have it",
                    ));
                };
                return asked.within(|query| {
                    let found = query.contacts(ball, &mut array)?;
                    let bound = BdtBound {
                        is_complete: u32::from(found.complete),
                        reserved: 0,
                        at_least: found.at_least,
                        unseen_triangles: found.unseen_triangles,
                    };
                    Ok((found.coverage, bound))
                });
            }
            asked.whole(|query| query.contacts(shape, &mut array))
        })?;
        array.end(&mut count)
    })
}

/// Hands every triangle that the shape touches to a callback, with `context`.
/// Errors: `BDT_STATUS_STOPPED`; those of `bdt_contacts`. Thread-safety: as `bdt_contacts`; the callback is called by
/// this thread.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_contacts_each(
    workspace: Handle<BdtWorkspace>,
    instance: Handle<BdtInstance>,
    shape: In<BdtShape>,
    callback: BdtOnContact,
    context: *mut c_void,
) -> BdtStatus {
    call(|| {
        let shape = shape.one("shape")?.checked()?;
        let mut sink = Callback::<BdtContact>::new(callback, context)?;
        ask(&workspace, &instance, true, |asked| {
            asked.whole(|query| query.contacts(shape, &mut sink))
        })?;
        Ok(sink.end())
    })
}

/// Writes 1 if the shape touches any triangle, else 0; ends with the first one that is found.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_ARGUMENT`, `_FORMAT` (a damaged file). Thread-safety: as
/// `bdt_contacts`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_intersects(
    workspace: Handle<BdtWorkspace>,
    instance: Handle<BdtInstance>,
    shape: In<BdtShape>,
    mut is_touched: Out<i32>,
) -> BdtStatus {
    done(|| {
        let shape = shape.one("shape")?.checked()?;
        let found = ask(&workspace, &instance, false, |asked| {
            asked.whole(|query| query.intersects(shape))
        })?;
        is_touched.one("is_touched")?.write(i32::from(found));
        Ok(())
    })
}

/// Writes the point of the mesh nearest to `point` (world), if it is within `max_distance` (which may be INFINITY); else
/// `BdtHit::triangle` is `BDT_NONE`.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_ARGUMENT`, `_FORMAT` (a damaged file). Thread-safety: as
/// `bdt_contacts`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_project_point(
    workspace: Handle<BdtWorkspace>,
    instance: Handle<BdtInstance>,
    point: BdtVec3,
    max_distance: f64,
    mut out: Out<BdtHit>,
) -> BdtStatus {
    done(|| {
        let point: [f64; 3] = point.into();
        let found = ask(&workspace, &instance, false, |asked| {
            asked.either(
                |query| query.project_point(point, max_distance),
                |query| Ok(bounded(query.project_point(point, max_distance)?)),
            )
        })?;
        out.one("out")?.write(found.into());
        Ok(())
    })
}

/// Writes where the ray (world) first meets the mesh; if it does not, `BdtHit::triangle` is `BDT_NONE`. Triangles are
/// two-sided; those without area are missed.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_ARGUMENT`, `_FORMAT` (a damaged file). Thread-safety: as
/// `bdt_contacts`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_cast_ray(
    workspace: Handle<BdtWorkspace>,
    instance: Handle<BdtInstance>,
    ray: In<BdtRay>,
    mut out: Out<BdtHit>,
) -> BdtStatus {
    done(|| {
        let ray = Ray::from(*ray.one("ray")?);
        let out = Cell::from_mut(out.one("out")?);
        // Written where it is found: each time that a hit is handed on takes some nanoseconds.
        let put = |found: Option<RayIntersection>| {
            out.set(MaybeUninit::new(found.into()));
        };
        ask(&workspace, &instance, false, |asked| {
            asked.either(
                |query| query.cast_ray(&ray).map(put),
                |query| {
                    let (found, bound) = bounded(query.cast_ray(&ray)?);
                    put(found);
                    Ok(((), bound))
                },
            )
        })
    })
}

pub(crate) fn bounded<T>(found: Budgeted<T>) -> (T, BdtBound) {
    let bound = BdtBound {
        is_complete: u32::from(found.complete),
        reserved: 0,
        at_least: found.at_least,
        unseen_triangles: 0,
    };
    (found.found, bound)
}

/// Writes 1 if the ray (world) meets the mesh at all, else 0, in less time than `bdt_cast_ray`.
/// Errors and thread-safety: as `bdt_cast_ray`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_intersects_ray(
    workspace: Handle<BdtWorkspace>,
    instance: Handle<BdtInstance>,
    ray: In<BdtRay>,
    mut is_met: Out<i32>,
) -> BdtStatus {
    done(|| {
        let ray = Ray::from(*ray.one("ray")?);
        let found = ask(&workspace, &instance, false, |asked| {
            asked.whole(|query| query.intersects_ray(&ray))
        })?;
        is_met.one("is_met")?.write(i32::from(found));
        Ok(())
    })
}

/// Writes every triangle that the ray (world) meets, unsorted, as `bdt_contacts` does.
/// Errors and thread-safety: as `bdt_contacts`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_cast_ray_all(
    workspace: Handle<BdtWorkspace>,
    instance: Handle<BdtInstance>,
    ray: In<BdtRay>,
    mut out: Out<BdtHit>,
    capacity: usize,
    mut count: Out<usize>,
) -> BdtStatus {
    call(|| {
        let ray = Ray::from(*ray.one("ray")?);
        let mut array = Array::new(&mut out, capacity, &mut count)?;
        ask(&workspace, &instance, false, |asked| {
            asked.whole(|query| query.cast_ray_all(&ray, &mut array))
        })?;
        array.end(&mut count)
    })
}

/// Hands every triangle that the ray (world) meets to a callback, with `context`, unsorted.
/// Errors and thread-safety: as `bdt_contacts_each`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_cast_ray_all_each(
    workspace: Handle<BdtWorkspace>,
    instance: Handle<BdtInstance>,
    ray: In<BdtRay>,
    callback: BdtOnHit,
    context: *mut c_void,
) -> BdtStatus {
    call(|| {
        let ray = Ray::from(*ray.one("ray")?);
        let mut sink = Callback::<BdtHit>::new(callback, context)?;
        ask(&workspace, &instance, true, |asked| {
            asked.whole(|query| query.cast_ray_all(&ray, &mut sink))
        })?;
        Ok(sink.end())
    })
}

/// All of the mesh is in the region.
pub const BDT_INSIDE: u32 = 0;
/// Part of the mesh is in the region, or perhaps.
pub const BDT_ACROSS: u32 = 1;
/// None of the mesh is in the region.
pub const BDT_OUTSIDE: u32 = 2;

/// Writes whether the mesh is in the region of 1 to 64 planes (world), for example a view frustum: `BDT_INSIDE`,
/// `BDT_ACROSS` or `BDT_OUTSIDE`. A visible mesh is never called outside.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_ARGUMENT`, `_FORMAT` (a damaged file). Thread-safety: as
/// `bdt_contacts`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_frustum_state(
    workspace: Handle<BdtWorkspace>,
    instance: Handle<BdtInstance>,
    planes: In<BdtPlane>,
    plane_count: usize,
    mut state: Out<u32>,
) -> BdtStatus {
    done(|| {
        const PLANES: &str =
            "planes: none, more than 64, or one with a zero or too large normal or d";
        let planes = planes.many(plane_count, "planes")?;
        if planes.len() > 64 {
            return Err(Fault::Argument(PLANES));
        }
        let planes: Vec<[f64; 4]> = (planes.iter())
            .map(|plane| [plane.normal.x, plane.normal.y, plane.normal.z, plane.d])
            .collect();
        let frustum = Frustum::new(&planes).ok_or(Fault::Argument(PLANES))?;
        let found = ask(&workspace, &instance, false, |asked| {
            asked.whole(|query| query.frustum_state(&frustum))
        })?;
        state.one("state")?.write(match found {
            FrustumState::Inside => BDT_INSIDE,
            FrustumState::Intersects => BDT_ACROSS,
            FrustumState::Outside => BDT_OUTSIDE,
        });
        Ok(())
    })
}

/// Writes the lanes of a level of the tree (0 is the root's), and leaf lanes above it, whose spheres the shape touches;
/// no triangles are looked at. Arrays as in `bdt_contacts`.
/// Errors and thread-safety: as `bdt_contacts`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_level_spheres(
    workspace: Handle<BdtWorkspace>,
    instance: Handle<BdtInstance>,
    level: u32,
    shape: In<BdtShape>,
    mut out: Out<BdtLane>,
    capacity: usize,
    mut count: Out<usize>,
) -> BdtStatus {
    call(|| {
        let shape = shape.one("shape")?.checked()?;
        let mut array = Array::new(&mut out, capacity, &mut count)?;
        ask(&workspace, &instance, false, |asked| {
            asked.whole(|query| query.level_spheres(level as usize, shape, &mut array))
        })?;
        array.end(&mut count)
    })
}
