//! Worlds: bodies that fall, touch and vibrate.
#![allow(unsafe_code)] // names of functions: docs/design/unsafe.md

use bdtree_dynamics::{BodyId, BodyOptions, Frame, ModelId, Plane, World, WorldOptions};
use bdtree_runtime::{Contact, Ray, Sink};

use crate::answers::{BdtContact, BdtHit};
use crate::border::{Handle, In, Kind, Out, call, done, give};
use crate::model::BdtModel;
use crate::sink::{Array, put_items};
use crate::status::{BdtStatus, Fault};
use crate::types::{BdtPlane, BdtRay, BdtShape, BdtTransform, BdtVec3};
use crate::world_types::{
    BdtBodyOptions, BdtEnergy, BdtEvent, BdtStepReport, BdtWorldContact, BdtWorldOptions,
};

/// Bodies that fall, touch and vibrate, step by step; the same to the bit for any number of threads. One thread at a time
/// may use it.
pub struct BdtWorld {
    _opaque: [u8; 0],
}

impl Kind for BdtWorld {
    type Value = World;
    const TAG: u64 = u64::from_le_bytes(*b"bdtWORLD");
    const NAME: &'static str = "world";
}

/// Writes the usual options of a world.
/// Errors: `BDT_STATUS_ERROR_NULL`. Thread-safety: any thread.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_world_defaults(mut out: Out<BdtWorldOptions>) -> BdtStatus {
    done(|| {
        out.one("out")?.write(WorldOptions::default().into());
        Ok(())
    })
}

/// Writes the usual options of a body's model.
/// Errors: `BDT_STATUS_ERROR_NULL`. Thread-safety: any thread.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_body_defaults(mut out: Out<BdtBodyOptions>) -> BdtStatus {
    done(|| {
        out.one("out")?.write(BdtBodyOptions::usual());
        Ok(())
    })
}

/// Makes a world without bodies. `options`: NULL for the usual ones.
/// Ownership: `*out` is yours, to be freed by `bdt_world_free`; NULL on errors.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_DYNAMICS` (options beyond their limits). Thread-safety: any thread.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_world_new(
    options: In<BdtWorldOptions>,
    mut out: Out<*mut BdtWorld>,
) -> BdtStatus {
    give(&mut out, || {
        let options = if options.is_null() {
            WorldOptions::default()
        } else {
            (*options.one("options")?).into()
        };
        Ok(World::new(options)?)
    })
}

/// Frees a world. NULL is nothing.
/// Errors: `BDT_STATUS_ERROR_HANDLE`. Thread-safety: no other thread may use the handle meanwhile or afterwards.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_world_free(world: Handle<BdtWorld>) -> BdtStatus {
    done(|| world.free())
}

/// Adds what bodies of a model have in common; `*id` is its number. `options`: NULL for the usual ones. The model may be
/// freed before the world.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_ARGUMENT`, `_DYNAMICS` (options beyond their limits, a skin, no
/// frequencies), `_FORMAT` (a damaged file). Thread-safety: one thread at a time per world.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_world_add_model(
    world: Handle<BdtWorld>,
    model: Handle<BdtModel>,
    options: In<BdtBodyOptions>,
    mut id: Out<u32>,
) -> BdtStatus {
    done(|| {
        let options = if options.is_null() {
            BodyOptions::default()
        } else {
            options.one("options")?.checked()?
        };
        let id = id.one("id")?;
        let ModelId(index) = world.exclusive()?.add_model(model.shared()?, &options)?;
        id.write(index as u32);
        Ok(())
    })
}

/// Adds the ground or a wall: nothing goes where normal · x + d < 0 (world); the normal has unit length.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_DYNAMICS`. Thread-safety: one thread at a time per world.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_world_add_plane(world: Handle<BdtWorld>, plane: In<BdtPlane>) -> BdtStatus {
    done(|| {
        let plane = *plane.one("plane")?;
        let plane = Plane {
            normal: plane.normal.into(),
            offset: -plane.d,
        };
        Ok(world.exclusive()?.add_plane(plane)?)
    })
}

/// How a body's frame moves: by forces.
pub const BDT_FREE: u32 = 0;
/// How a body's frame moves: not; its modes do.
pub const BDT_HELD: u32 = 1;
/// How a body's frame and q move: as `bdt_body_drive` says.
pub const BDT_DRIVEN: u32 = 2;

/// Adds a body at rest: undeformed, its mesh placed at `at`, without speed; `*id` is its number. `model`: a number from
/// `bdt_world_add_model`. `frame`: `BDT_FREE`, `BDT_HELD` or `BDT_DRIVEN`.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_ARGUMENT`, `_INDEX` (no such model), `_POSE` (a placement that
/// is not allowed), `_DYNAMICS` (no mass, another scale than the model's). Thread-safety: one thread at a time per world.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_world_add_body(
    world: Handle<BdtWorld>,
    model: u32,
    frame: u32,
    at: In<BdtTransform>,
    mut id: Out<u32>,
) -> BdtStatus {
    done(|| {
        let frame = match frame {
            BDT_FREE => Frame::Free,
            BDT_HELD => Frame::Held,
            BDT_DRIVEN => Frame::Driven,
            _ => return Err(Fault::Argument("frame: of no known kind")),
        };
        let (at, id) = (*at.one("at")?, id.one("id")?);
        let BodyId(index) = world
            .exclusive()?
            .add_body(ModelId(model as usize), frame, at)?;
        id.write(index as u32);
        Ok(())
    })
}

/// Takes one step. `report`: what it did; may be NULL.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_STEP` (bodies too fast for the step: the world is not to be
/// stepped on), `_DYNAMICS`, `_FORMAT` (a damaged file). Thread-safety: one thread at a time per world.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_world_step(
    world: Handle<BdtWorld>,
    mut report: Out<BdtStepReport>,
) -> BdtStatus {
    done(|| {
        let report = report.optional("report")?;
        let mut world = world.exclusive()?;
        let did = world.step()?;
        if let Some(report) = report {
            report.write(BdtStepReport::of(did, world.times()));
        }
        Ok(())
    })
}

/// Writes how many bodies there are, how many of them sleep, and how many steps were taken; each may be NULL.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`. Thread-safety: several threads may read a world at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_world_counts(
    world: Handle<BdtWorld>,
    mut bodies: Out<u32>,
    mut asleep: Out<u32>,
    mut steps: Out<u64>,
) -> BdtStatus {
    done(|| {
        let world = world.shared()?;
        if let Some(bodies) = bodies.optional("bodies")? {
            bodies.write(world.len() as u32);
        }
        if let Some(asleep) = asleep.optional("asleep")? {
            asleep.write(world.asleep() as u32);
        }
        if let Some(steps) = steps.optional("steps")? {
            steps.write(world.steps());
        }
        Ok(())
    })
}

/// Writes which bodies began to touch, touch, or have parted in the last step, sorted by bodies; planes come last. Pairs
/// that sleep are not among them. Arrays as in `bdt_contacts`.
/// Errors: `BDT_STATUS_TRUNCATED`, `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`. Thread-safety: several threads may read a
/// world at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_world_events(
    world: Handle<BdtWorld>,
    mut out: Out<BdtEvent>,
    capacity: usize,
    mut count: Out<usize>,
) -> BdtStatus {
    call(|| {
        let events = world.shared()?.events().map(BdtEvent::from);
        put_items(events, &mut out, capacity, &mut count)
    })
}

/// Writes the contacts of the last step. Arrays as in `bdt_contacts`.
/// Errors and thread-safety: as `bdt_world_events`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_world_contacts(
    world: Handle<BdtWorld>,
    mut out: Out<BdtWorldContact>,
    capacity: usize,
    mut count: Out<usize>,
) -> BdtStatus {
    call(|| {
        let contacts = world.shared()?.contacts().map(BdtWorldContact::from);
        put_items(contacts, &mut out, capacity, &mut count)
    })
}

/// Writes the energies of all bodies as they are now.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`. Thread-safety: several threads may read a world at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_world_energy(world: Handle<BdtWorld>, mut out: Out<BdtEnergy>) -> BdtStatus {
    done(|| {
        let energy = world.shared()?.energy();
        out.one("out")?.write(energy.into());
        Ok(())
    })
}

/// Writes momentum (N s) and angular momentum about the world's origin (kg · world unit² / s) of all free bodies; each may
/// be NULL.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`. Thread-safety: several threads may read a world at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_world_momenta(
    world: Handle<BdtWorld>,
    mut linear: Out<BdtVec3>,
    mut angular: Out<BdtVec3>,
) -> BdtStatus {
    done(|| {
        let [momentum, about_origin] = world.shared()?.momenta();
        if let Some(linear) = linear.optional("linear")? {
            linear.write(momentum.into());
        }
        if let Some(angular) = angular.optional("angular")? {
            angular.write(about_origin.into());
        }
        Ok(())
    })
}

/// Writes what a ray (world) meets first, with the body as `BdtHit::index`; if nothing, `BdtHit::triangle` is `BDT_NONE`.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_ARGUMENT`, `_FORMAT` (a damaged file). Thread-safety: one thread
/// at a time per world.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_world_cast_ray(
    world: Handle<BdtWorld>,
    ray: In<BdtRay>,
    mut out: Out<BdtHit>,
) -> BdtStatus {
    done(|| {
        let ray = Ray::from(*ray.one("ray")?);
        let out = out.one("out")?;
        let found = world.exclusive()?.cast_ray(&ray)?;
        out.write(found.map_or(BdtHit::MISS, |(BodyId(body), hit)| (body, hit).into()));
        Ok(())
    })
}

/// Writes every triangle of every body that the shape (world) touches, with the body as `BdtContact::body`. Arrays as in
/// `bdt_contacts`.
/// Errors: `BDT_STATUS_TRUNCATED`; those of `bdt_world_cast_ray`. Thread-safety: one thread at a time per world.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_world_touched_by(
    world: Handle<BdtWorld>,
    shape: In<BdtShape>,
    mut out: Out<BdtContact>,
    capacity: usize,
    mut count: Out<usize>,
) -> BdtStatus {
    call(|| {
        let shape = shape.one("shape")?.checked()?;
        let mut array = OfBodies(Array::new(&mut out, capacity, &mut count)?);
        world.exclusive()?.touched_by(shape, &mut array)?;
        let OfBodies(array) = array;
        array.end(&mut count)
    })
}

/// Keeps the body with each contact.
struct OfBodies<'s>(Array<'s, BdtContact>);

impl Sink<(BodyId, Contact)> for OfBodies<'_> {
    fn push(&mut self, (BodyId(body), contact): (BodyId, Contact)) -> std::ops::ControlFlow<()> {
        self.0.put(BdtContact {
            body: body as u32,
            ..contact.into()
        });
        std::ops::ControlFlow::Continue(())
    }
}

/// Writes the whole state of the world: what goes on from it after `bdt_world_restore` is the same to the bit. Models,
/// planes and options are not in it. `out`: room for `capacity` bytes; `count`: how many there are.
/// Errors: `BDT_STATUS_TRUNCATED` (the bytes are of no use), `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`. Thread-safety:
/// several threads may read a world at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_world_save(
    world: Handle<BdtWorld>,
    mut out: Out<u8>,
    capacity: usize,
    mut count: Out<usize>,
) -> BdtStatus {
    call(|| {
        let mut bytes = Vec::new();
        world.shared()?.save(&mut bytes);
        put_items(bytes, &mut out, capacity, &mut count)
    })
}

/// Goes back to a state that `bdt_world_save` has written, of this world or of one with the same models, planes, bodies
/// and options. On errors nothing changes.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_STATE`. Thread-safety: one thread at a time per world.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_world_restore(
    world: Handle<BdtWorld>,
    bytes: In<u8>,
    length: usize,
) -> BdtStatus {
    done(|| {
        let bytes = bytes.many(length, "bytes")?;
        Ok(world.exclusive()?.restore(bytes)?)
    })
}
