//! Random sequences of calls with handles that live, were freed, are of another kind or are none, and with numbers of all
//! sorts: every call returns a status, and none crashes. `BDTREE_FUZZ_CALLS` sets how many (usually 20,000), and
//! `BDTREE_FUZZ_SEED` which.

/// One of a list, mostly; else NULL, one of another list, or an address that is none.
macro_rules! any {
    ($fuzz:ident.$list:ident) => {{
        let list = &$fuzz.$list;
        let address = match $fuzz.values.rng.random_range(0..40) {
            0 => null_mut(),
            1 => $fuzz.worlds.last().map_or(null_mut(), |other| other.cast()),
            2 => $fuzz.models.last().map_or(null_mut(), |other| other.cast()),
            3 => std::ptr::without_provenance_mut(16),
            _ => list[$fuzz.values.rng.random_range(0..list.len())],
        };
        handle(address)
    }};
}

mod values;
mod worlds;

use values::Values;

use std::collections::HashMap;
use std::ptr::null_mut;

use bdtree_capi::answers::*;
use bdtree_capi::batch::*;
use bdtree_capi::body::*;
use bdtree_capi::border::{Handle, Kind};
use bdtree_capi::broad::*;
use bdtree_capi::instance::*;
use bdtree_capi::model::*;
use bdtree_capi::names::*;
use bdtree_capi::pair::*;
use bdtree_capi::query::*;
use bdtree_capi::skeleton::*;
use bdtree_capi::status::BdtStatus;
use bdtree_capi::types::*;
use bdtree_capi::workspace::*;
use bdtree_capi::world::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::shared::*;

/// Room for the largest answers of a call.
const ROOM: usize = 64;

struct Fuzz {
    values: Values,
    /// Addresses of all kinds, freed ones too.
    models: Vec<*mut BdtModel>,
    instances: Vec<*mut BdtInstance>,
    workspaces: Vec<*mut BdtWorkspace>,
    poses: Vec<*mut BdtSkeletonPose>,
    fronts: Vec<*mut BdtFront>,
    worlds: Vec<*mut BdtWorld>,
    seen: HashMap<BdtStatus, usize>,
}

impl Fuzz {
    /// Frees one of a list, or tries to.
    fn free<K: Kind>(
        &mut self,
        address: Option<*mut K>,
        free: extern "C" fn(Handle<K>) -> BdtStatus,
    ) {
        if let Some(address) = address {
            let status = free(handle(address));
            self.saw(status);
        }
    }

    fn saw(&mut self, status: BdtStatus) {
        *self.seen.entry(status).or_default() += 1;
        assert_ne!(status, BdtStatus::ErrorPanic, "{}", last_error());
        assert!(BdtStatus::ALL.contains(&status));
        if (status as i32) < 0 {
            assert!(!last_error().is_empty());
        }
    }

    /// Makes a handle of a random kind.
    fn make(&mut self) {
        let names = [
            "sphere.bdt",
            "skinned.bdt",
            "animated.bdt",
            "tetrahedron.bdt",
            "none.bdt",
        ];
        let name = golden(names[self.values.rng.random_range(0..names.len())]);
        let (mut model, mut instance, mut desk) = (null_mut(), null_mut(), null_mut());
        let (mut pose, mut front, mut world) = (null_mut(), null_mut(), null_mut());
        let status = match self.values.rng.random_range(0..8) {
            0 => bdt_model_read(text(&name), one(&mut model)),
            1 => bdt_model_load(text(&name), one(&mut model)),
            2 => bdt_instance_new(any!(self.models), one(&mut instance)),
            3 => {
                let (nodes, leaves) = (self.values.small() as usize, self.values.small() as usize);
                bdt_instance_new_with_cache(any!(self.models), nodes, leaves, one(&mut instance))
            }
            4 => bdt_workspace_new(one(&mut desk)),
            5 => bdt_skeleton_pose_new(any!(self.models), one(&mut pose)),
            6 => bdt_front_new(one(&mut front)),
            _ => bdt_world_new(null_in(), one(&mut world)),
        };
        self.saw(status);
        self.models.extend((!model.is_null()).then_some(model));
        self.instances
            .extend((!instance.is_null()).then_some(instance));
        self.workspaces.extend((!desk.is_null()).then_some(desk));
        self.poses.extend((!pose.is_null()).then_some(pose));
        self.fronts.extend((!front.is_null()).then_some(front));
        self.worlds.extend((!world.is_null()).then_some(world));
    }

    /// Frees a handle of a random kind; its address stays in the list.
    fn end_one(&mut self) {
        let pick = self.values.rng.random_range(0..1000);
        match self.values.rng.random_range(0..6) {
            0 => self.free(self.models.get(pick).copied(), bdt_model_free),
            1 => self.free(self.instances.get(pick).copied(), bdt_instance_free),
            2 => self.free(self.workspaces.get(pick).copied(), bdt_workspace_free),
            3 => self.free(self.poses.get(pick).copied(), bdt_skeleton_pose_free),
            4 => self.free(self.fronts.get(pick).copied(), bdt_front_free),
            _ => self.free(self.worlds.get(pick).copied(), bdt_world_free),
        }
    }

    /// Sets or reads something.
    fn change(&mut self) {
        let count = [0, 1, 2, 3, 3, 3, 4][self.values.rng.random_range(0..7)];
        let q: Vec<f32> = (0..4).map(|_| self.values.number() as f32 * 0.1).collect();
        let q64: Vec<f64> = q.iter().map(|q| f64::from(*q)).collect();
        let (at, matrix, index) = (
            self.values.place(),
            self.values.matrix(),
            self.values.small(),
        );
        let (at, matrices, index_) = ([at], [matrix; 4], index as usize);
        let (mut out_q, mut out_q64) = ([0.0_f32; 4], [0.0_f64; 4]);
        let (x, force) = (self.values.number(), self.values.vec3());
        let status = match self.values.rng.random_range(0..41) {
            0 => bdt_instance_set_q(any!(self.instances), read(&q), count),
            1 => bdt_instance_q(any!(self.instances), write(&mut out_q), count),
            2 => bdt_instance_set_placement(any!(self.instances), read(&at)),
            3 => bdt_instance_set_pose(any!(self.instances), read(&q), count, read(&at)),
            4 => bdt_instance_set_joints(any!(self.instances), read(&matrices), 4),
            5 => bdt_instance_set_skinning_matrices(any!(self.instances), read(&matrices), 4),
            6 => bdt_instance_set_pose_with_joints(
                any!(self.instances),
                read(&q),
                count,
                read(&matrices),
                4,
                read(&at),
            ),
            7 => bdt_instance_aabb(any!(self.instances), one(&mut zeroed())),
            8 => bdt_instance_exact_aabb(any!(self.instances), one(&mut zeroed())),
            9 => bdt_instance_bounding_sphere(any!(self.instances), one(&mut zeroed())),
            10 => {
                let mut out = [vec3(0.0, 0.0, 0.0); ROOM];
                bdt_instance_vertices(any!(self.instances), index, ROOM, write(&mut out))
            }
            11 => bdt_instance_add_generalized_force(
                any!(self.instances),
                index,
                force,
                force,
                write(&mut out_q64),
                count,
            ),
            12 => bdt_instance_tags(any!(self.instances), one(&mut zeroed())),
            39 => bdt_instance_set_refining(any!(self.instances), index as i32 & 1),
            13 => bdt_instance_set_tags(any!(self.instances), read(&[zeroed()])),
            14 => bdt_instance_placement(any!(self.instances), one(&mut zeroed())),
            15 => bdt_instance_set_skeleton_pose(any!(self.instances), any!(self.poses)),
            16 => bdt_skeleton_pose_play(any!(self.poses), index_, x),
            17 => bdt_skeleton_pose_blend(any!(self.poses), index_, x, 0.5),
            18 => bdt_skeleton_pose_rest(any!(self.poses)),
            19 => bdt_skeleton_pose_joints(any!(self.poses), write(&mut [zeroed(); 4]), 4),
            20 => bdt_skeleton_pose_nodes(any!(self.poses), write(&mut [zeroed(); 4]), 4),
            21 => bdt_skeleton_pose_q(any!(self.poses), write(&mut out_q), count),
            22 => bdt_skeleton_pose_local(any!(self.poses), index_, one(&mut zeroed())),
            23 => bdt_skeleton_pose_set_local(any!(self.poses), index_, read(&[zeroed()])),
            24 => bdt_skeleton_pose_update(any!(self.poses)),
            25 => bdt_model_info(any!(self.models), one(&mut zeroed())),
            26 => bdt_model_mode(any!(self.models), index_, one(&mut zeroed())),
            27 => bdt_model_mass(any!(self.models), one(&mut zeroed())),
            28 => bdt_model_group(any!(self.models), index_, one(&mut zeroed())),
            29 => bdt_model_triangles(any!(self.models), index, 4, write(&mut [0; 12])),
            30 => bdt_model_frame(
                any!(self.models),
                index_,
                write(&mut out_q),
                count,
                null_out(),
                null_out(),
            ),
            31 => bdt_model_sample(any!(self.models), x, write(&mut out_q), count, null_out()),
            32 => bdt_model_joint_of(any!(self.models), index, force, one(&mut 0)),
            33 => bdt_model_verify_checksums(any!(self.models)),
            34 => bdt_model_clip_duration(any!(self.models), index_, one(&mut 0.0)),
            35 => bdt_model_joint_parent(any!(self.models), index_, one(&mut 0)),
            36 => self.name(index_),
            37 => bdt_transform_after(at[0], self.values.place(), one(&mut zeroed())),
            38 => bdt_joint_in_model(at[0], matrix, one(&mut zeroed())),
            _ => bdt_body_set_modes(any!(self.worlds), index, read(&q64), read(&q64), count),
        };
        self.saw(status);
    }

    fn name(&mut self, index: usize) -> BdtStatus {
        let capacity = self.values.rng.random_range(0..9);
        let (mut bytes, mut found) = ([0; 9], 0);
        let names = [
            bdt_model_mode_name,
            bdt_model_joint_name,
            bdt_model_clip_name,
            bdt_model_group_name,
        ];
        let indices = [
            bdt_model_mode_index,
            bdt_model_joint_index,
            bdt_model_clip_index,
        ];
        let pick = self.values.rng.random_range(0..7);
        match names.get(pick) {
            Some(name) => name(
                any!(self.models),
                index,
                write(&mut bytes),
                capacity,
                null_out(),
            ),
            None => indices[pick - 4](any!(self.models), text("field 0"), one(&mut found)),
        }
    }

    /// Asks one instance.
    fn ask(&mut self) {
        let (shape, ray, point, length) = (
            self.values.shape(),
            self.values.ray(),
            self.values.vec3(),
            self.values.length(),
        );
        let (shape, rays, level) = ([shape], [ray, self.values.ray(), RAY], self.values.small());
        let capacity = self.values.rng.random_range(0..=ROOM);
        let (mut contacts, mut hits): ([BdtContact; ROOM], [BdtHit; ROOM]) = (zeroed(), zeroed());
        let mut lanes: [BdtLane; ROOM] = zeroed();
        let (mut count, mut is_met) = (0, 0);
        let (desk, body) = (any!(self.workspaces), any!(self.instances));
        let handles = [any!(self.instances), any!(self.instances)];
        let status = match self.values.rng.random_range(0..22) {
            0 | 1 => bdt_contacts(
                desk,
                body,
                read(&shape),
                write(&mut contacts),
                capacity,
                one(&mut count),
            ),
            2 => bdt_contacts_each(desk, body, read(&shape), Some(some), null_mut()),
            3 => bdt_intersects(desk, body, read(&shape), one(&mut is_met)),
            4 => bdt_project_point(desk, body, point, length, one(&mut hits[0])),
            5 | 6 => bdt_cast_ray(desk, body, read(&rays), one(&mut hits[0])),
            7 => bdt_intersects_ray(desk, body, read(&rays), one(&mut is_met)),
            8 => bdt_cast_ray_all(
                desk,
                body,
                read(&rays),
                write(&mut hits),
                capacity,
                one(&mut count),
            ),
            9 => {
                let planes = [BdtPlane {
                    normal: point,
                    d: length,
                }; 3];
                bdt_frustum_state(desk, body, read(&planes), 3, one(&mut 0))
            }
            10 => bdt_level_spheres(
                desk,
                body,
                level,
                read(&shape),
                write(&mut lanes),
                capacity,
                one(&mut count),
            ),
            11 => bdt_cast_rays(desk, body, read(&rays), 3, write(&mut hits)),
            12 => bdt_intersects_rays(desk, body, read(&rays), 3, write(&mut [0; 3])),
            13 => bdt_cast_rays_all(
                desk,
                body,
                read(&rays),
                3,
                write(&mut hits),
                capacity,
                one(&mut count),
            ),
            14 => bdt_cast_rays_at_instances(
                desk,
                read(&handles),
                2,
                read(&rays),
                3,
                write(&mut hits),
            ),
            15 => bdt_cast_rays_nearest(desk, read(&handles), 2, read(&rays), 3, write(&mut hits)),
            16 => {
                let mut pairs: [BdtIndexPair; ROOM] = zeroed();
                bdt_instance_pairs(
                    desk,
                    read(&handles),
                    2,
                    length,
                    write(&mut pairs),
                    2,
                    one(&mut count),
                )
            }
            17 => bdt_workspace_set_shared(desk, level as i32),
            18 => bdt_workspace_set_max_levels(desk, level as i32 - 4, -1),
            19 => bdt_workspace_set_max_visits(desk, u64::from(level) / 4),
            20 => {
                let mut proxies: [BdtProxy; ROOM] = zeroed();
                bdt_workspace_proxies(
                    desk,
                    level as usize,
                    write(&mut proxies),
                    capacity,
                    one(&mut count),
                )
            }
            _ => bdt_workspace_stats(desk, one(&mut zeroed())),
        };
        self.saw(status);
    }

    /// Asks two instances.
    fn pair(&mut self) {
        let (length, level, reach) = (
            self.values.length() * 0.1,
            self.values.small(),
            self.values.length() * 0.1,
        );
        let (mut contacts, mut regions): ([BdtPairContact; ROOM], [BdtManifold; 4]) =
            (zeroed(), zeroed());
        let (mut pairs, mut lanes): ([BdtIndexPair; ROOM], [BdtLanePair; ROOM]) =
            (zeroed(), zeroed());
        let (mut count, mut near) = (0, 0.0);
        let (desk, a, b) = (
            any!(self.workspaces),
            any!(self.instances),
            any!(self.instances),
        );
        let front = if self.values.rng.random() {
            any!(self.fronts)
        } else {
            handle(null_mut())
        };
        let status = match self.values.rng.random_range(0..9) {
            0 => bdt_pair_contacts(
                desk,
                a,
                b,
                front,
                length,
                write(&mut contacts),
                ROOM,
                one(&mut count),
            ),
            1 => bdt_pair_triangles(
                desk,
                a,
                b,
                front,
                length,
                write(&mut pairs),
                ROOM,
                one(&mut count),
            ),
            2 => bdt_pair_intersects(desk, a, b, front, one(&mut 0)),
            3 => bdt_pair_closest_points(desk, a, b, length, one(&mut contacts[0])),
            4 => bdt_pair_distance(desk, a, b, length, one(&mut near)),
            5 => bdt_pair_manifolds(
                desk,
                a,
                b,
                front,
                length,
                write(&mut regions),
                4,
                one(&mut count),
            ),
            6 => bdt_pair_condense(
                desk,
                a,
                b,
                read(&contacts),
                3,
                write(&mut regions),
                4,
                one(&mut count),
            ),
            7 => bdt_pair_level_spheres(
                desk,
                a,
                b,
                level,
                level,
                length,
                reach,
                write(&mut lanes),
                ROOM,
                one(&mut count),
            ),
            _ => {
                let mut found: [BdtLaneTriangle; ROOM] = zeroed();
                bdt_pair_level_triangles(
                    desk,
                    a,
                    b,
                    level,
                    length,
                    reach,
                    write(&mut found),
                    ROOM,
                    one(&mut count),
                )
            }
        };
        self.saw(status);
    }
}

extern "C" fn some(contact: *const BdtContact, _: *mut std::ffi::c_void) -> i32 {
    i32::from(contact.addr().is_multiple_of(3))
}

fn setting(name: &str, usual: u64) -> u64 {
    std::env::var(name).map_or(usual, |text| text.parse().expect("a number"))
}

#[test]
fn random_calls_return_statuses() {
    let mut fuzz = Fuzz {
        values: Values {
            rng: Pcg64Mcg::seed_from_u64(setting("BDTREE_FUZZ_SEED", 23)),
        },
        models: vec![
            load("sphere.bdt"),
            load("skinned.bdt"),
            load("animated.bdt"),
        ],
        instances: vec![null_mut()],
        workspaces: vec![null_mut()],
        poses: vec![null_mut()],
        fronts: vec![null_mut()],
        worlds: vec![null_mut()],
        seen: HashMap::new(),
    };
    for call in 0..setting("BDTREE_FUZZ_CALLS", 20_000) {
        // Few handles, so that pairs of calls meet.
        if call % 500 < 30 {
            fuzz.make();
        }
        match fuzz.values.rng.random_range(0..100) {
            0 => fuzz.end_one(),
            1..30 => fuzz.change(),
            30..65 => fuzz.ask(),
            65..85 => fuzz.pair(),
            _ => worlds::step(&mut fuzz),
        }
        if fuzz.instances.len() > 60 {
            fuzz.instances.drain(1..20).for_each(|address| {
                bdt_instance_free(handle(address));
            });
        }
    }
    let ok = fuzz.seen.get(&BdtStatus::Ok).copied().unwrap_or_default();
    println!("{:?}", fuzz.seen);
    let all: usize = fuzz.seen.values().sum();
    assert!(5 * ok > all, "too few calls go well: {:?}", fuzz.seen);
    assert!(fuzz.seen.len() > 12, "{:?}", fuzz.seen);
}
