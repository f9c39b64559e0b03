//! Bodies of a world.
#![allow(unsafe_code)] // names of functions: docs/design/unsafe.md

use bdtree_dynamics::BodyId;

use crate::border::{Handle, In, Out, done};
use crate::sink::put_all;
use crate::status::BdtStatus;
use crate::types::{BdtTransform, BdtVec3};
use crate::world::BdtWorld;
use crate::world_types::BdtBodyState;

/// Writes position, orientation and speeds of a body.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_INDEX` (no such body). Thread-safety: several threads may read a
/// world at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_body_state(
    world: Handle<BdtWorld>,
    body: u32,
    mut out: Out<BdtBodyState>,
) -> BdtStatus {
    done(|| {
        let (world, body) = (world.shared()?, BodyId(body as usize));
        let state = BdtBodyState::of(world.state(body)?, world.angular_velocity(body)?);
        out.one("out")?.write(state);
        Ok(())
    })
}

/// Writes where a body's mesh is: what a renderer needs besides q.
/// Errors and thread-safety: as `bdt_body_state`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_body_placement(
    world: Handle<BdtWorld>,
    body: u32,
    mut out: Out<BdtTransform>,
) -> BdtStatus {
    done(|| {
        let at = world.shared()?.placement(BodyId(body as usize))?;
        out.one("out")?.write(at.into());
        Ok(())
    })
}

/// Writes how many modes of a body move: as many as its model has, or 0 if it is not deformable.
/// Errors and thread-safety: as `bdt_body_state`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_body_mode_count(
    world: Handle<BdtWorld>,
    body: u32,
    mut count: Out<usize>,
) -> BdtStatus {
    done(|| {
        let of = world
            .shared()?
            .model_of(BodyId(body as usize))?
            .mode_count();
        count.one("count")?.write(of);
        Ok(())
    })
}

/// Writes q of a body and how fast it changes (per second), `count` numbers each, as many as `bdt_body_mode_count` says;
/// each may be NULL.
/// Errors: those of `bdt_body_state`; `_LENGTH`. Thread-safety: several threads may read a world at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_body_q(
    world: Handle<BdtWorld>,
    body: u32,
    mut q: Out<f64>,
    mut rate: Out<f64>,
    count: usize,
) -> BdtStatus {
    done(|| {
        let (world, body) = (world.shared()?, BodyId(body as usize));
        let mut own = vec![0.0; world.model_of(body)?.mode_count()];
        if !q.is_null() || count != own.len() {
            world.q(body, &mut own)?;
            put_all("entries of q", &own, &mut q, count)?;
        }
        if !rate.is_null() {
            world.q_rate(body, &mut own)?;
            put_all("rates of q", &own, &mut rate, count)?;
        }
        Ok(())
    })
}

/// Sets q of a body and how fast it changes (per second): `count` numbers each, as many as `bdt_body_mode_count` says.
/// Errors: those of `bdt_body_state`; `_LENGTH`, `_DYNAMICS` (not finite, or beyond the strain limit). Thread-safety: one
/// thread at a time per world.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_body_set_modes(
    world: Handle<BdtWorld>,
    body: u32,
    q: In<f64>,
    rate: In<f64>,
    count: usize,
) -> BdtStatus {
    done(|| {
        let (q, rate) = (q.many(count, "q")?, rate.many(count, "rate")?);
        Ok(world
            .exclusive()?
            .set_modes(BodyId(body as usize), q, rate)?)
    })
}

/// Sets velocity (world units per second) and angular velocity (rad/s, world axes) of a free body.
/// Errors: those of `bdt_body_state`; `_DYNAMICS` (not finite). Thread-safety: one thread at a time per world.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_body_set_velocity(
    world: Handle<BdtWorld>,
    body: u32,
    velocity: BdtVec3,
    angular_velocity: BdtVec3,
) -> BdtStatus {
    done(|| {
        let body = BodyId(body as usize);
        let (velocity, spin) = (velocity.into(), angular_velocity.into());
        Ok(world.exclusive()?.set_velocity(body, velocity, spin)?)
    })
}

/// Adds a force (N) at the center of mass and a torque (N · world unit), world axes, for the next step.
/// Errors: those of `bdt_body_state`; `_DYNAMICS` (not finite). Thread-safety: one thread at a time per world.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_body_add_force(
    world: Handle<BdtWorld>,
    body: u32,
    force: BdtVec3,
    torque: BdtVec3,
) -> BdtStatus {
    done(|| {
        let body = BodyId(body as usize);
        Ok(world
            .exclusive()?
            .add_force(body, force.into(), torque.into())?)
    })
}

/// Adds generalised forces on q for the next step, one per mode: what `bdt_instance_add_generalized_force` makes.
/// Errors: those of `bdt_body_set_modes`. Thread-safety: one thread at a time per world.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_body_add_modal_force(
    world: Handle<BdtWorld>,
    body: u32,
    force: In<f64>,
    count: usize,
) -> BdtStatus {
    done(|| {
        let force = force.many(count, "force")?;
        Ok(world
            .exclusive()?
            .add_modal_force(BodyId(body as usize), force)?)
    })
}

/// Adds impulses on q, one per mode: its rates change at once.
/// Errors: those of `bdt_body_set_modes`. Thread-safety: one thread at a time per world.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_body_add_modal_impulse(
    world: Handle<BdtWorld>,
    body: u32,
    impulse: In<f64>,
    count: usize,
) -> BdtStatus {
    done(|| {
        let impulse = impulse.many(count, "impulse")?;
        Ok(world
            .exclusive()?
            .add_modal_impulse(BodyId(body as usize), impulse)?)
    })
}

/// Says where the mesh of a driven body is at the end of the next step, and its q: `count` numbers, as many as
/// `bdt_body_mode_count` says.
/// Errors: those of `bdt_body_set_modes`; `_INDEX` also for bodies that are not driven. Thread-safety: one thread at a
/// time per world.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_body_drive(
    world: Handle<BdtWorld>,
    body: u32,
    q: In<f64>,
    count: usize,
    at: In<BdtTransform>,
) -> BdtStatus {
    done(|| {
        let (q, at) = (q.many(count, "q")?, *at.one("at")?);
        Ok(world.exclusive()?.drive(BodyId(body as usize), q, at)?)
    })
}
