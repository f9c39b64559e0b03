//! Many rays and many instances in one call.
#![allow(unsafe_code)] // names of functions: docs/design/unsafe.md

use std::mem::MaybeUninit;

use bdtree_runtime::{Aabb, Query, QueryError, Ray, RayIntersection, Stats};

use crate::answers::BdtHit;
use crate::border::{Handle, In, Out, call, done};
use crate::instance::BdtInstance;
use crate::ray_blocks::{add, cast_in_blocks};
use crate::sink::Array;
use crate::status::{BdtStatus, Fault};
use crate::types::BdtRay;
use crate::workspace::{BdtWorkspace, Desk, VISITS, ask};

/// Casts `count` rays (world): `hits[i]` becomes that of ray i, as `bdt_cast_ray` writes it, with the ray's number as
/// `index`. Rays after one that is not allowed are not cast.
/// `hits`: room for `count` hits.
/// Errors: those of `bdt_cast_ray`. Thread-safety: as `bdt_contacts`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_cast_rays(
    workspace: Handle<BdtWorkspace>,
    instance: Handle<BdtInstance>,
    rays: In<BdtRay>,
    count: usize,
    mut hits: Out<BdtHit>,
) -> BdtStatus {
    done(|| {
        let rays = rays.many(count, "rays")?;
        let hits = hits.many(count, "hits")?;
        let hit = |i, found: Option<RayIntersection>| BdtHit {
            index: i as u32,
            ..found.into()
        };
        let cast = |query: &mut Query<'_, '_>, rays: &[Ray], found: &mut [_]| {
            query.cast_rays(rays, found) // behind a closure, it takes a query of any lifetime
        };
        cast_each(&workspace, &instance, rays, hits, None, cast, hit)
    })
}

/// Casts rays at one instance and writes what `answer` makes of each one's number and result.
#[inline(always)] // answers are written where they are to stay
fn cast_each<T: Copy, C>(
    workspace: &Handle<BdtWorkspace>,
    instance: &Handle<BdtInstance>,
    rays: &[BdtRay],
    slots: &mut [MaybeUninit<C>],
    none: T,
    cast: impl Fn(&mut Query<'_, '_>, &[Ray], &mut [T]) -> Result<(), QueryError>,
    answer: impl Fn(usize, T) -> C,
) -> Result<(), Fault> {
    ask(workspace, instance, false, |asked| {
        asked.summed(|query, sum| {
            let mut slots = slots.iter_mut();
            cast_in_blocks(query, sum, numbered(rays), none, cast, |i, found| {
                if let Some(slot) = slots.next() {
                    slot.write(answer(i, found));
                }
            })
        })
    })
}

/// Casts `count` rays (world): `is_met[i]` becomes 1 if ray i meets the mesh, else 0.
/// `is_met`: room for `count` bytes.
/// Errors: those of `bdt_cast_ray`. Thread-safety: as `bdt_contacts`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_intersects_rays(
    workspace: Handle<BdtWorkspace>,
    instance: Handle<BdtInstance>,
    rays: In<BdtRay>,
    count: usize,
    mut is_met: Out<u8>,
) -> BdtStatus {
    done(|| {
        let rays = rays.many(count, "rays")?;
        let is_met = is_met.many(count, "is_met")?;
        let cast = |query: &mut Query<'_, '_>, rays: &[Ray], found: &mut [_]| {
            query.intersects_rays(rays, found)
        };
        let byte = |_, met| u8::from(met);
        cast_each(&workspace, &instance, rays, is_met, false, cast, byte)
    })
}

/// Writes every triangle that each of `ray_count` rays (world) meets, ray after ray, with the ray's number as
/// `BdtHit::index`. Arrays as in `bdt_contacts`.
/// Errors and thread-safety: as `bdt_contacts`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_cast_rays_all(
    workspace: Handle<BdtWorkspace>,
    instance: Handle<BdtInstance>,
    rays: In<BdtRay>,
    ray_count: usize,
    mut out: Out<BdtHit>,
    capacity: usize,
    mut count: Out<usize>,
) -> BdtStatus {
    call(|| {
        let rays = rays.many(ray_count, "rays")?;
        let mut array = Array::new(&mut out, capacity, &mut count)?;
        ask(&workspace, &instance, false, |asked| {
            asked.summed(|query, sum| {
                for (index, ray) in numbered(rays) {
                    let mut numbered = Numbered {
                        index,
                        array: &mut array,
                    };
                    query.cast_ray_all(&ray, &mut numbered)?;
                    add(sum, query.stats());
                }
                Ok(())
            })
        })?;
        array.end(&mut count)
    })
}

/// Adds the number of its ray to each hit.
struct Numbered<'n, 's> {
    index: usize,
    array: &'n mut Array<'s, BdtHit>,
}

impl bdtree_runtime::Sink<RayIntersection> for Numbered<'_, '_> {
    fn push(&mut self, hit: RayIntersection) -> std::ops::ControlFlow<()> {
        self.array.put((self.index, hit).into());
        std::ops::ControlFlow::Continue(())
    }
}

/// Casts each of `ray_count` rays (world) at each of `instance_count` instances: `hits[i * ray_count + k]` becomes that of
/// ray k with instance i, as `bdt_cast_ray` writes it, with the instance's number as `BdtHit::index`. Instances whose box
/// a ray misses cost little.
/// `hits`: room for instance_count · ray_count hits.
/// Errors: those of `bdt_cast_ray`; what was written before stays. Thread-safety: as `bdt_contacts`, for each instance.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_cast_rays_at_instances(
    workspace: Handle<BdtWorkspace>,
    instances: In<Handle<BdtInstance>>,
    instance_count: usize,
    rays: In<BdtRay>,
    ray_count: usize,
    mut hits: Out<BdtHit>,
) -> BdtStatus {
    done(|| {
        let instances = instances.handles(instance_count, "instances")?;
        let rays = rays.many(ray_count, "rays")?;
        let hits = hits.many(instance_count.saturating_mul(ray_count), "hits")?;
        if rays.is_empty() {
            return Ok(());
        }
        let mut desk = workspace.exclusive()?;
        let mut sum = Stats::default();
        let rows = hits.chunks_exact_mut(ray_count);
        for (i, (instance, row)) in instances.iter().zip(rows).enumerate() {
            let index = i as u32;
            for hit in &mut *row {
                hit.write(BdtHit {
                    index,
                    ..BdtHit::MISS
                });
            }
            at_instance(&mut desk, &mut sum, instance, rays, |k, hit| {
                if let Some(slot) = row.get_mut(k) {
                    slot.write((i, hit).into());
                }
            })?;
        }
        desk.stats = sum;
        Ok(())
    })
}

/// Casts each of `ray_count` rays (world) at all of `instance_count` instances: `hits[k]` becomes what ray k meets first,
/// with the instance's number as `BdtHit::index`, the lowest of those at the same distance.
/// `hits`: room for `ray_count` hits.
/// Errors and thread-safety: as `bdt_cast_rays_at_instances`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_cast_rays_nearest(
    workspace: Handle<BdtWorkspace>,
    instances: In<Handle<BdtInstance>>,
    instance_count: usize,
    rays: In<BdtRay>,
    ray_count: usize,
    mut hits: Out<BdtHit>,
) -> BdtStatus {
    done(|| {
        let instances = instances.handles(instance_count, "instances")?;
        let rays = rays.many(ray_count, "rays")?;
        let slots = hits.many(ray_count, "hits")?;
        let mut best = vec![BdtHit::MISS; ray_count];
        let mut desk = workspace.exclusive()?;
        let mut sum = Stats::default();
        for (i, instance) in instances.iter().enumerate() {
            at_instance(&mut desk, &mut sum, instance, rays, |k, hit| {
                if let Some(best) = best.get_mut(k)
                    && (best.triangle == BdtHit::MISS.triangle || hit.distance < best.distance)
                {
                    *best = (i, hit).into();
                }
            })?;
        }
        desk.stats = sum;
        for (slot, hit) in slots.iter_mut().zip(best) {
            slot.write(hit);
        }
        Ok(())
    })
}

/// Casts rays at one of several instances; `put` gets the number of each ray that meets it, and its hit.
fn at_instance(
    desk: &mut Desk,
    sum: &mut Stats,
    instance: &Handle<BdtInstance>,
    rays: &[BdtRay],
    put: impl FnMut(usize, RayIntersection),
) -> Result<(), Fault> {
    const LEVELS: &str = "max_levels: queries of several instances have no such limit";
    if desk.max_visits.is_some() {
        return Err(Fault::Argument(VISITS));
    }
    if desk.levels != [None; 2] {
        return Err(Fault::Argument(LEVELS));
    }
    let memory = &mut desk.memory;
    if desk.is_shared {
        let instance = instance.shared()?;
        let (aabb, pose) = (instance.aabb()?, instance.snapshot());
        Ok(cast(&mut pose.query(memory), &aabb, rays, sum, put)?)
    } else {
        let mut instance = instance.exclusive()?;
        let aabb = instance.aabb()?;
        Ok(cast(&mut instance.query(memory), &aabb, rays, sum, put)?)
    }
}

fn cast(
    query: &mut Query<'_, '_>,
    aabb: &Aabb,
    rays: &[BdtRay],
    sum: &mut Stats,
    mut put: impl FnMut(usize, RayIntersection),
) -> Result<(), QueryError> {
    // What is no ray meets the box, so that the query refuses it; one of negative length does not.
    let near = numbered(rays).filter(|(_, ray)| aabb.intersects_ray(ray) || ray.max_distance < 0.0);
    cast_in_blocks(query, sum, near, None, Query::cast_rays, |k, found| {
        if let Some(hit) = found {
            put(k, hit);
        }
    })
}

/// The runtime's rays, numbered.
fn numbered(rays: &[BdtRay]) -> impl Iterator<Item = (usize, Ray)> {
    rays.iter().map(|ray| Ray::from(*ray)).enumerate()
}
