//! What worlds promise: no energy from nowhere, the same bytes for any number of threads and from any saved state, events,
//! queries.

use bdtree_dynamics::{BodyId, BodyOptions, DynamicsError, Phase, World, WorldOptions};
use bdtree_runtime::{Ball, Contact, Ray};

use crate::support::{falling, falling_beams, restless_beams};

fn bytes(world: &World) -> Vec<u8> {
    let mut out = Vec::new();
    world.save(&mut out);
    out
}

/// Mechanical and contact energy never exceed their least value so far by more than 1 % of the first.
#[test]
fn a_heap_never_gains_energy() {
    let mut world = restless_beams(8);
    let first = world.energy().mechanical();
    let (mut least, mut worst, mut deepest) = (f64::INFINITY, 0.0_f64, 0.0_f64);
    let mut events = 0;
    for _ in 0..2000 {
        let mechanical = world.energy().mechanical();
        let report = world.step().expect("a step");
        let energy = mechanical + report.contact_energy;
        least = least.min(energy);
        worst = worst.max(energy - least);
        deepest = deepest.max(report.penetration_rel);
        events = report.events;
    }
    assert!(worst < 0.01 * first, "{worst} of {first}");
    assert!(deepest < 1.0, "{deepest}");
    // They have come to rest on the ground.
    assert!(events >= 16, "{events}");
    assert!(
        world.energy().kinetic < 1e-4 * first,
        "{:?}",
        world.energy()
    );
}

/// One thread or more, in one go or from a saved state: the same bytes.
fn steps_are_the_same(count: usize, threads: usize, steps: u64) {
    let mut alone = falling_beams(count, 1);
    let mut together = falling_beams(count, threads);
    let mut saved = None;
    let middle = steps / 3;
    let mut events = 0;
    for n in 0..steps {
        if n == middle {
            saved = Some(bytes(&alone));
        }
        let reports = [
            alone.step().expect("a step"),
            together.step().expect("a step"),
        ];
        assert_eq!(reports[0].events, reports[1].events, "{n}");
        assert_eq!(reports[0].sweeps, reports[1].sweeps, "{n}");
        events += reports[0].events;
    }
    assert!(events > 0);
    let end = bytes(&alone);
    assert!(end == bytes(&together));
    let mut again = falling_beams(count, threads);
    again.restore(&saved.expect("a state")).expect("restored");
    assert_eq!(again.steps(), middle);
    for n in middle..steps {
        // Where queries have posed the instances makes no difference.
        if n % 50 == 0 {
            again.pose_instances().expect("poses");
        }
        again.step().expect("a step");
    }
    assert!(end == bytes(&again));
}

#[test]
fn steps_are_the_same_to_the_bit() {
    steps_are_the_same(12, 2, 400);
}

/// So many that they are in several clusters.
#[test]
fn steps_of_many_bodies_are_the_same_to_the_bit() {
    steps_are_the_same(100, 3, 90);
}

/// Cut or changed bytes are refused, and the world stays as it was.
#[test]
fn damaged_states_are_refused() {
    let mut world = falling_beams(3, 1);
    for _ in 0..60 {
        world.step().expect("a step");
    }
    let saved = bytes(&world);
    for len in (0..saved.len()).step_by(7) {
        let error = world.restore(&saved[..len]).expect_err("cut");
        assert!(matches!(error, DynamicsError::State { .. }), "{error}");
    }
    let mut longer = saved.clone();
    longer.push(0);
    assert!(world.restore(&longer).is_err());
    let mut others = falling_beams(4, 1);
    let error = others
        .restore(&saved)
        .expect_err("other bodies")
        .to_string();
    assert!(error.contains("another number of bodies"), "{error}");
    // NaN in the first position.
    let mut broken = saved.clone();
    broken[72..80].copy_from_slice(&f64::NAN.to_le_bytes());
    assert!(
        world
            .restore(&broken)
            .expect_err("NaN")
            .to_string()
            .contains("not finite")
    );
    assert!(bytes(&world) == saved);
}

/// Pairs begin, stay and part; impulses of a step are those of its contacts.
#[test]
fn events_follow_contacts() {
    let mut world = falling_beams(4, 1);
    let mut touching = std::collections::BTreeSet::new();
    let (mut began, mut ended) = (0, 0);
    for _ in 0..600 {
        world.step().expect("a step");
        let forces: f64 = world.contacts().map(|contact| contact.force[1]).sum();
        let mut impulses = 0.0;
        for event in world.events() {
            impulses += event.impulse[1];
            match event.phase {
                Phase::Began => {
                    assert!(touching.insert(event.bodies));
                    began += 1;
                }
                Phase::Touching => assert!(touching.contains(&event.bodies)),
                Phase::Ended => {
                    assert!(touching.remove(&event.bodies));
                    ended += 1;
                }
            }
        }
        assert!(
            (impulses - forces / 150.0).abs() < 1e-9,
            "{impulses} {forces}"
        );
    }
    assert!(began > 4 && ended > 0, "{began} {ended}");
    assert!(touching.iter().any(|bodies| bodies[1].is_none()));
}

/// Rays and shapes meet bodies where they are now.
#[test]
fn queries_see_bodies_as_they_are() {
    let mut world = falling_beams(5, 1);
    for _ in 0..200 {
        world.step().expect("a step");
    }
    // From above through the center of one of them.
    let [x, _, z] = world.state(BodyId(2)).expect("a state").position;
    let down = Ray::new([x, 10.0, z], [0.0, -1.0, 0.0]);
    let (body, hit) = world.cast_ray(&down).expect("a ray").expect("a hit");
    let best = (0..world.len())
        .filter_map(|k| {
            let mut workspace = bdtree_runtime::Workspace::new();
            let pose = world.instances()[k].pose();
            let hit = pose.query(&mut workspace).cast_ray(&down).expect("a ray");
            hit.map(|hit| (hit.distance, BodyId(k)))
        })
        .min_by(|a, b| a.0.total_cmp(&b.0));
    assert_eq!(best, Some((hit.distance, body)));
    let mut touched: Vec<(BodyId, Contact)> = Vec::new();
    world
        .touched_by(Ball::new(hit.point, 0.01), &mut touched)
        .expect("a ball");
    assert!(
        touched
            .iter()
            .any(|(of, contact)| *of == body && contact.triangle == hit.triangle)
    );
}

/// Updates that change nothing: the same motion, and more of each tree's numbers read.
#[test]
fn redundant_updates_change_no_motion() {
    let mut worlds = [false, true].map(|has_redundant_updates| {
        let rigid = BodyOptions {
            is_deformable: false,
            has_redundant_updates,
            ..BodyOptions::default()
        };
        falling(8, WorldOptions::default(), &rigid)
    });
    for _ in 0..300 {
        let [a, b] = worlds.each_mut().map(|world| world.step().expect("a step"));
        assert_eq!((a.events, a.penetration), (b.events, b.penetration));
    }
    let [plain, redundant] = &worlds;
    for body in (0..8).map(BodyId) {
        assert_eq!(plain.state(body), redundant.state(body));
    }
    let active = worlds
        .each_ref()
        .map(|w| w.instances()[0].pose().active_modes());
    assert_eq!(active, [0, 6]);
}
