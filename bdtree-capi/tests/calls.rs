//! Answers of calls that no golden file has, beside those of the library.

use bdtree_capi::answers::*;
use bdtree_capi::batch::*;
use bdtree_capi::instance::*;
use bdtree_capi::names::*;
use bdtree_capi::pair::*;
use bdtree_capi::query::*;
use bdtree_capi::status::BdtStatus;
use bdtree_capi::types::*;
use bdtree_capi::workspace::*;
use bdtree_runtime::{
    Capsule, Contact, ContactManifold, Instance, Model, PairContact, Ray, Shape, Transform,
    Workspace,
};

use crate::shared::{self, *};

const Q: [f32; 3] = [0.2, -0.1, 0.05];

fn bodies() -> [*mut BdtInstance; 2] {
    let model = load("sphere.bdt");
    let [one, two] = [instance(model), instance(model)];
    let at = BdtTransform {
        translation: vec3(1.2, 0.3, 0.1),
        ..IDENTITY
    };
    assert_eq!(bdt_instance_set_q(handle(one), read(&Q), 3), BdtStatus::Ok);
    assert_eq!(
        bdt_instance_set_placement(handle(two), read(&[at])),
        BdtStatus::Ok
    );
    [one, two]
}

fn bodies_of_the_library() -> [Instance; 2] {
    let model = Model::read(golden("sphere.bdt")).expect("a model");
    let [mut one, mut two] = [0, 1].map(|_| Instance::new(&model).expect("an instance"));
    one.set_q(&Q).expect("q");
    two.set_placement(Transform::from_translation([1.2, 0.3, 0.1]))
        .expect("a place");
    [one, two]
}

/// More than are cast together twice.
const RAYS: usize = 300;

fn rays() -> Vec<BdtRay> {
    (0..RAYS)
        .map(|k| {
            let x = k as f64 * (4.0 / RAYS as f64) - 1.5;
            BdtRay {
                origin: vec3(x, 3.0, 0.02 * x),
                direction: vec3(0.1, -1.0, 0.05),
                max_distance: 100.0,
            }
        })
        .collect()
}

#[test]
fn batches_are_single_calls() {
    let ([one, two], desk, rays) = (bodies(), workspace(), rays());
    let mut own = bodies_of_the_library();
    let mut memory = Workspace::new();
    let mut rows: Vec<Vec<BdtHit>> = Vec::new();
    for body in &mut own {
        let mut query = body.query(&mut memory);
        rows.push(
            rays.iter()
                .map(|ray| query.cast_ray(&Ray::from(*ray)).expect("a ray").into())
                .collect(),
        );
    }
    let handles = [handle(one), handle(two)];
    let mut hits = vec![zeroed::<BdtHit>(); 2 * RAYS];
    let status = bdt_cast_rays_at_instances(
        handle(desk),
        read(&handles),
        2,
        read(&rays),
        RAYS,
        write(&mut hits),
    );
    assert_eq!(status, BdtStatus::Ok, "{}", last_error());
    for (i, row) in rows.iter().enumerate() {
        for (hit, own) in hits[RAYS * i..].iter().zip(row) {
            assert_eq!(
                *hit,
                BdtHit {
                    index: i as u32,
                    ..*own
                }
            );
        }
    }
    let mut nearest = vec![zeroed::<BdtHit>(); RAYS];
    let status = bdt_cast_rays_nearest(
        handle(desk),
        read(&handles),
        2,
        read(&rays),
        RAYS,
        write(&mut nearest),
    );
    assert_eq!(status, BdtStatus::Ok, "{}", last_error());
    let mut met = [0; 2];
    for (k, hit) in nearest.iter().enumerate() {
        let both = [hits[k], hits[RAYS + k]]
            .into_iter()
            .filter(|hit| hit.triangle != BDT_NONE);
        let first = both.min_by(|a, b| a.distance.total_cmp(&b.distance));
        match first {
            Some(first) => {
                assert_eq!(*hit, first);
                met[first.index as usize] += 1;
            }
            None => assert_eq!(hit.triangle, BDT_NONE),
        }
    }
    assert!(met.iter().all(|count| *count > 3), "{met:?}");
    let (mut single, mut is_met) = (vec![zeroed::<BdtHit>(); RAYS], vec![9_u8; RAYS]);
    for (shared, refined) in [(1, 0), (0, 0), (0, 1)] {
        assert_eq!(
            bdt_instance_set_refining(handle(one), refined),
            BdtStatus::Ok
        );
        assert_eq!(
            bdt_workspace_set_shared(handle(desk), shared),
            BdtStatus::Ok
        );
        let status = bdt_cast_rays(
            handle(desk),
            handle(one),
            read(&rays),
            RAYS,
            write(&mut single),
        );
        assert_eq!(status, BdtStatus::Ok);
        let status = bdt_intersects_rays(
            handle(desk),
            handle(one),
            read(&rays),
            RAYS,
            write(&mut is_met),
        );
        assert_eq!(status, BdtStatus::Ok);
        for (k, (hit, own)) in single.iter().zip(&rows[0]).enumerate() {
            assert_eq!(
                *hit,
                BdtHit {
                    index: k as u32,
                    ..*own
                }
            );
            assert_eq!(is_met[k] == 1, own.triangle != BDT_NONE);
        }
    }
}

/// Rays in front of one that is refused are answered, those behind it are not touched; of several rays their visits add up.
#[test]
fn a_refused_ray_ends_a_batch() {
    let ([one, _], desk, mut rays) = (bodies(), workspace(), rays());
    assert_eq!(bdt_workspace_set_shared(handle(desk), 1), BdtStatus::Ok);
    let mut visits = [0; RAYS];
    let mut single = vec![zeroed::<BdtHit>(); RAYS];
    for ((ray, hit), visits) in rays.iter().zip(&mut single).zip(&mut visits) {
        let status = bdt_cast_ray(
            handle(desk),
            handle(one),
            read(&[*ray]),
            write(std::slice::from_mut(hit)),
        );
        assert_eq!(status, BdtStatus::Ok);
        *visits = stats(desk).nodes_visited;
    }
    assert!(visits.iter().any(|visits| *visits > 1));
    let mut hits = vec![zeroed::<BdtHit>(); RAYS];
    let mut cast = |rays: &[BdtRay]| {
        hits.fill(zeroed());
        let status = bdt_cast_rays(
            handle(desk),
            handle(one),
            read(rays),
            RAYS,
            write(&mut hits),
        );
        (status, hits.clone())
    };
    assert_eq!(cast(&rays).0, BdtStatus::Ok);
    assert_eq!(stats(desk).nodes_visited, visits.iter().sum::<u64>());
    for bad in [0, 127, 128, 200, RAYS - 1] {
        let direction = std::mem::replace(&mut rays[bad].direction, vec3(0.0, 0.0, 0.0));
        let (status, hits) = cast(&rays);
        rays[bad].direction = direction;
        assert_eq!(status, BdtStatus::ErrorArgument, "{}", last_error());
        for (k, (hit, single)) in hits.iter().zip(&single).enumerate() {
            let expected = match k < bad {
                true => BdtHit {
                    index: k as u32,
                    ..*single
                },
                false => zeroed(),
            };
            assert_eq!(*hit, expected, "ray {k} of {bad}");
        }
    }
}

fn stats(desk: *mut BdtWorkspace) -> BdtStats {
    let mut found = [zeroed::<BdtStats>()];
    let status = bdt_workspace_stats(handle(desk), write(&mut found));
    assert_eq!(status, BdtStatus::Ok);
    found[0]
}

#[test]
fn shapes_and_pairs_are_the_librarys() {
    let ([one, two], desk) = (bodies(), workspace());
    let [mut own1, mut own2] = bodies_of_the_library();
    let mut memory = Workspace::new();
    let mut found: Vec<Contact> = Vec::new();
    let capsule = Capsule::new([0.0, 0.0, 0.8], [0.5, 0.0, 0.9], 0.3);
    own1.query(&mut memory)
        .contacts(Shape::from(capsule), &mut found)
        .expect("contacts");
    let shape = bdt_capsule(vec3(0.0, 0.0, 0.8), vec3(0.5, 0.0, 0.9), 0.3);
    let (mut slots, mut count) = (vec![zeroed::<BdtContact>(); 200], 0);
    let status = bdt_contacts(
        handle(desk),
        handle(one),
        read(&[shape]),
        write(&mut slots),
        200,
        shared::one(&mut count),
    );
    assert_eq!(status, BdtStatus::Ok, "{}", last_error());
    let expected: Vec<BdtContact> = found.into_iter().map(BdtContact::from).collect();
    assert!(count > 5 && slots[..count] == expected);

    let mut regions: Vec<ContactManifold> = Vec::new();
    let mut pairs: Vec<PairContact> = Vec::new();
    let mut query = own1.against(&mut own2, &mut memory);
    query.contact_manifolds(0.0, &mut regions).expect("regions");
    query.contacts(0.0, &mut pairs).expect("contacts");
    let mut slots = vec![zeroed::<BdtManifold>(); 4];
    let status = bdt_pair_manifolds(
        handle(desk),
        handle(one),
        handle(two),
        handle(std::ptr::null_mut()),
        0.0,
        write(&mut slots),
        4,
        shared::one(&mut count),
    );
    assert_eq!(status, BdtStatus::Ok, "{}", last_error());
    let expected: Vec<BdtManifold> = regions.into_iter().map(BdtManifold::from).collect();
    assert!(count > 0 && slots[..count] == expected);
    let pairs: Vec<BdtPairContact> = pairs.into_iter().map(BdtPairContact::from).collect();
    let status = bdt_pair_condense(
        handle(desk),
        handle(one),
        handle(two),
        read(&pairs),
        pairs.len(),
        write(&mut slots),
        4,
        shared::one(&mut count),
    );
    assert_eq!(status, BdtStatus::Ok, "{}", last_error());
    assert!(slots[..count] == expected);
}

/// Levels leave spheres, limits of visits bounds.
#[test]
fn limits_leave_their_marks() {
    let ([one, _], desk) = (bodies(), workspace());
    let ball = bdt_ball(vec3(0.0, 0.0, 1.0), 0.3);
    let (mut slots, mut count) = (vec![zeroed::<BdtContact>(); 200], 0);
    assert_eq!(
        bdt_workspace_set_max_levels(handle(desk), 0, -1),
        BdtStatus::Ok
    );
    let status = bdt_contacts(
        handle(desk),
        handle(one),
        read(&[ball]),
        write(&mut slots),
        200,
        shared::one(&mut count),
    );
    assert_eq!((status, count), (BdtStatus::Ok, 0), "{}", last_error());
    let mut proxies = vec![zeroed::<BdtProxy>(); 8];
    let status = bdt_workspace_proxies(
        handle(desk),
        0,
        write(&mut proxies),
        8,
        shared::one(&mut count),
    );
    assert_eq!(status, BdtStatus::Ok);
    assert!(count > 0 && proxies[..count].iter().all(|proxy| proxy.radius > 0.1));

    assert_eq!(
        bdt_workspace_set_max_levels(handle(desk), -1, -1),
        BdtStatus::Ok
    );
    assert_eq!(bdt_workspace_set_max_visits(handle(desk), 1), BdtStatus::Ok);
    let mut near: BdtHit = zeroed();
    let status = bdt_project_point(
        handle(desk),
        handle(one),
        vec3(2.0, 0.0, 0.0),
        f64::INFINITY,
        shared::one(&mut near),
    );
    assert_eq!(status, BdtStatus::Ok, "{}", last_error());
    let mut bound: BdtBound = zeroed();
    assert_eq!(
        bdt_workspace_bound(handle(desk), shared::one(&mut bound)),
        BdtStatus::Ok
    );
    assert!(bound.is_complete == 0 && bound.at_least > 0.5, "{bound:?}");
    let mut stats: BdtStats = zeroed();
    assert_eq!(
        bdt_workspace_stats(handle(desk), shared::one(&mut stats)),
        BdtStatus::Ok
    );
    assert_eq!(stats.nodes_visited, 1);
    let mut is_touched = 0;
    let status = bdt_intersects(
        handle(desk),
        handle(one),
        read(&[ball]),
        shared::one(&mut is_touched),
    );
    assert_eq!(status, BdtStatus::ErrorArgument);
    assert!(last_error().contains("max_visits"));
}

#[test]
fn names_are_cut_between_characters() {
    let model = load("sphere.bdt");
    let name = |capacity: usize| {
        let (mut bytes, mut length) = ([b'x'.cast_signed(); 20], 0);
        let status = bdt_model_group_name(
            handle(model),
            1,
            write(&mut bytes),
            capacity,
            shared::one(&mut length),
        );
        let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(20);
        let text = bytes[..end]
            .iter()
            .map(|byte| byte.cast_unsigned())
            .collect();
        (status, String::from_utf8(text).expect("UTF-8"), length)
    };
    assert_eq!(name(8), (BdtStatus::Ok, "Glas ü".to_string(), 7));
    assert_eq!(name(7), (BdtStatus::Truncated, "Glas ".to_string(), 7));
    assert_eq!(
        name(0),
        (BdtStatus::Truncated, "xxxxxxxxxxxxxxxxxxxx".to_string(), 7)
    );
    let mut index = 9;
    assert_eq!(
        bdt_model_mode_index(handle(model), text("field 2"), shared::one(&mut index)),
        BdtStatus::Ok
    );
    assert_eq!(index, 2);
    let status = bdt_model_mode_index(handle(model), text("field 3"), shared::one(&mut index));
    assert_eq!(status, BdtStatus::ErrorIndex);
}
