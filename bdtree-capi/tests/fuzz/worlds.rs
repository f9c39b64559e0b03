//! Calls of worlds.

use std::ptr::null_mut;

use bdtree_capi::answers::BdtContact;
use bdtree_capi::body::*;
use bdtree_capi::types::*;
use bdtree_capi::world::*;
use bdtree_capi::world_types::*;
use rand::RngExt;

use super::{Fuzz, ROOM};
use crate::shared::*;

/// Moves a world.
pub(super) fn step(fuzz: &mut Fuzz) {
    let (at, ray, shape, v) = (
        [fuzz.values.place()],
        [fuzz.values.ray()],
        [fuzz.values.shape()],
        fuzz.values.vec3(),
    );
    let (index, frame) = (fuzz.values.small(), fuzz.values.small() % 4);
    let mut options = [zeroed::<BdtBodyOptions>()];
    bdt_body_defaults(write(&mut options));
    options[0].has_mass = 1;
    options[0].mass.mass_kg = fuzz.values.length();
    options[0].mass.inertia = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
    options[0].contact = fuzz.values.small() % 4;
    let mut bytes = [0; 4000];
    let (mut id, mut count) = (0, 0);
    let world = any!(fuzz.worlds);
    let status = match fuzz.values.rng.random_range(0..14) {
        0 => bdt_world_add_model(world, any!(fuzz.models), read(&options), one(&mut id)),
        1 => bdt_world_add_body(world, index % 3, frame, read(&at), one(&mut id)),
        2 => bdt_world_add_plane(
            world,
            read(&[BdtPlane {
                normal: vec3(0.0, 1.0, 0.0),
                d: 9.0,
            }]),
        ),
        3 | 4 => bdt_world_step(world, null_out()),
        5 => bdt_world_cast_ray(world, read(&ray), one(&mut zeroed())),
        6 => {
            let mut found: [BdtContact; ROOM] = zeroed();
            bdt_world_touched_by(
                world,
                read(&shape),
                write(&mut found),
                ROOM,
                one(&mut count),
            )
        }
        7 => bdt_body_state(world, index, one(&mut zeroed())),
        8 => bdt_body_add_force(world, index, v, v),
        9 => bdt_body_set_velocity(world, index, v, v),
        10 => {
            let status = bdt_world_save(world, write(&mut bytes), 4000, one(&mut count));
            fuzz.saw(status);
            bytes[fuzz.values.rng.random_range(0..4000)] ^= fuzz.values.rng.random::<u8>() & 1;
            bdt_world_restore(any!(fuzz.worlds), read(&bytes), count.min(4000))
        }
        11 => bdt_body_placement(world, index, one(&mut zeroed())),
        12 => bdt_world_counts(world, one(&mut 0), null_out(), null_out()),
        _ => {
            let mut found: [BdtWorldContact; ROOM] = zeroed();
            bdt_world_contacts(world, write(&mut found), ROOM, one(&mut count))
        }
    };
    fuzz.saw(status);
}
