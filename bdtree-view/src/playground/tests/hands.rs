//! What hands do to bodies: throws, pulls, pokes.

use bdtree_dynamics::BodyId;
use nalgebra::Vector3;

use super::*;
use crate::playground::grab::{Grab, Point};

#[test]
fn what_is_thrown_gets_where_it_is_aimed_at() {
    let mut play = tetrahedra(0);
    let reach = play.reach();
    let aim = Vector3::new(0.4, 0.0, 0.3);

    play.speed = 9.0;
    let at = pixel(&play, aim.into());
    play.throw_at(at, SIZE);
    assert_eq!((play.simulation.of().len(), &play.problem), (1, &None));
    let camera = play.camera.expect("a camera");
    let eye: [f64; 3] = camera.eye.as_dvec3().to_array();
    let before = (center(&play.simulation, 0) - Vector3::from(eye)).norm();
    assert!((before - 1.5 * reach).abs() < 1e-6, "{before}");
    let mut nearest = f64::INFINITY;
    for _ in 0..300 {
        play.simulation.steps(1, None).expect("a step");
        nearest = nearest.min((center(&play.simulation, 0) - aim).norm());
    }
    // Its center of mass gets no nearer to the ground.
    assert!(nearest < 1.3 * reach, "{nearest} of {reach}");
    // Where one is, there is no room for another.
    play.clear();
    play.throw_at(at, SIZE);
    play.throw_at(at, SIZE);
    let text = play.problem.expect("no room").text;
    assert!(text.ends_with("move the camera away"), "{text}");
    assert_eq!(play.simulation.of().len(), 1);
}

/// A point of a body that a ray from above finds.
fn point(simulation: &mut Simulation, x: f64, z: f64) -> (Point, Vector3<f64>) {
    let ray = bdtree_runtime::Ray::new([x, 50.0, z], [0.0, -1.0, 0.0]);
    let hit = simulation.world_mut().cast_ray(&ray).expect("an answer");
    let (body, hit) = hit.expect("a body");
    let point = Point::new(simulation, body, &hit).expect("a point");
    (point, hit.point.into())
}

#[test]
fn a_held_point_comes_to_the_pointer_and_stays() {
    for file in [beam(), golden_file("tetrahedron.bdt")] {
        let mut simulation = of(&[file]);
        drop_above(&mut simulation, 0, [0.0; 3]).expect("a body");
        let middle = center(&simulation, 0);
        let (point, at) = point(&mut simulation, middle.x, middle.z);
        let target = at + Vector3::new(0.5, 1.0, 0.0);
        let mut grab = Grab::new(point, target.into());
        let mut most = 0.0_f64;
        for _ in 0..1500 {
            simulation.steps(1, Some(&mut grab)).expect("a step");
            most = most.max(simulation.world().energy().mechanical());
        }
        let [held, _] = grab.ends();
        let away = target - Vector3::from(held);
        let sag = 9.81 / 400.0;
        assert!((away - Vector3::new(0.0, sag, 0.0)).norm() < 0.02, "{away}");
        let speed = velocity(&simulation, 0).norm();
        assert!(speed < 0.05, "{speed}");
        let energy = simulation.world().energy();
        assert!(most.is_finite() && energy.modal < 1.0, "{energy:?}");
        // Let go while it is moved, it flies on.
        grab.target += Vector3::new(0.0, 0.0, 2.0);
        simulation.steps(15, Some(&mut grab)).expect("steps");
        let flies = velocity(&simulation, 0).z;
        simulation.steps(15, None).expect("steps");
        assert!(flies > 1.0, "{flies}");
        assert!((velocity(&simulation, 0).z - flies).abs() < 0.3 * flies);
    }
}

/// The pushed point gets as much faster as asked, whether the body is stiff or gives way.
#[test]
fn a_poke_moves_the_point() {
    for (file, within) in [(beam(), 0.25), (golden_file("tetrahedron.bdt"), 0.05)] {
        let mut simulation = of(&[file]);
        drop_above(&mut simulation, 0, [0.0; 3]).expect("a body");
        let middle = center(&simulation, 0);
        let (mut point, before) = point(&mut simulation, middle.x, middle.z);
        let change = Vector3::new(0.0, -3.0, 0.0);
        point.poke(simulation.world_mut(), change).expect("a poke");
        simulation.steps(1, None).expect("a step");
        // Its place now, by a spring that does not pull.
        let mut look = Grab::new(point, before.into());
        simulation.steps(1, Some(&mut look)).expect("a step");
        let moved = Vector3::from(look.ends()[0]) - before;
        // In the step of a constant force the point moves half as far as it is fast at the end.
        let expected = 0.5 * change * SETTINGS.step_s;
        let off = (moved - expected).dot(&change.normalize()).abs() / expected.norm();
        assert!(off < within, "{moved} instead of {expected}");
        let swings = simulation.q(0).iter().any(|q| q.abs() > 1e-5);
        assert_eq!(swings, !simulation.q(0).is_empty(), "modes are pushed, too");
    }
}

#[test]
fn hands_take_what_is_at_the_pointer() {
    let mut play = tetrahedra(1);
    let at = pixel(&play, center(&play.simulation, 0).into());
    play.grab(at, SIZE);
    assert_eq!(play.grabbed().map(Grab::body), Some(BodyId(0)));
    let [_, before] = play.grabbed().expect("held").ends();
    play.drag([30.0, -20.0], [at[0] + 30.0, at[1] - 20.0], SIZE);
    let [_, after] = play.grabbed().expect("held").ends();
    // The pointer's place moves across the view, and not along it.
    let camera = play.camera.expect("a camera");
    let [right, up, forward] = camera
        .axes()
        .map(|a| Vector3::from(a.as_dvec3().to_array()));
    let by = Vector3::from(after) - Vector3::from(before);
    assert!(
        by.dot(&right) > 0.0 && by.dot(&up) > 0.0 && by.dot(&forward).abs() < 1e-6,
        "{by}"
    );
    let seen = pixel(&play, after);
    assert!((seen[0] - at[0] - 30.0).abs() < 0.1 && (seen[1] - at[1] + 20.0).abs() < 0.1);
    // However far down, it is not below the ground.
    play.drag([0.0, 900.0], [at[0], at[1] + 900.0], SIZE);
    assert!(play.grabbed().expect("held").ends()[1][1] >= 0.0);
    play.let_go();

    // Beside it there is only the camera to be turned.
    let camera = play.camera;
    play.grab([3.0, 3.0], SIZE);
    assert!(play.grabbed().is_none());
    play.drag([40.0, 0.0], [43.0, 3.0], SIZE);
    assert_ne!(play.camera, camera);
    play.let_go();
    play.camera = camera;

    play.poke_at(at, SIZE);
    play.simulation.steps(1, None).expect("a step");
    let forward = camera.expect("a camera").axes()[2].as_dvec3().to_array();
    assert!(velocity(&play.simulation, 0).dot(&Vector3::from(forward)) > 0.5);
    play.remove_at([3.0, 3.0], SIZE);
    assert_eq!(play.simulation.of().len(), 1, "nothing is there");
    play.reset();
    play.remove_at(at, SIZE);
    assert!(play.simulation.of().is_empty());
    play.camera = camera.map(|camera| camera.orbited(0.0, -15.0));
    play.drop_at([320.0, 3.0], SIZE);
    play.camera = camera;
    play.drop_at(at, SIZE);
    assert_eq!(
        (play.simulation.of().len(), &play.problem),
        (1, &None),
        "none above the sky"
    );
}
