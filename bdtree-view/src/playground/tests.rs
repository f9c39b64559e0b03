//! The playground without a window.

mod hands;

use std::sync::OnceLock;

use bdtree_build::basis::elastic::ElasticOptions;
use bdtree_build::progress::Silent;
use bdtree_build::recipe::{Elastic, Motion, Recipe};
use bdtree_dynamics::BodyId;
use bdtree_fixtures::{golden, models};
use bdtree_tools::AssetFile;
use nalgebra::Vector3;

use super::checkpoint;
use super::*;

pub(super) const SIZE: [u32; 2] = [640, 400];

pub(super) const SETTINGS: Settings = Settings {
    step_s: 1.0 / 150.0,
    threads: 1,
    scale: 1.0,
    is_deformable: true,
    level: None,
    seed: 1,
};

/// The beam, 1 m long and 5 cm thick, with four modes.
fn beam() -> AssetFile {
    static BEAM: OnceLock<Vec<u8>> = OnceLock::new();
    let bytes = BEAM.get_or_init(|| {
        let options = ElasticOptions {
            mode_count: 4,
            resolution: Some(40),
            ..ElasticOptions::default()
        };
        let motion = Motion::Elastic(Elastic {
            options,
            range_rel: None,
        });
        let recipe = Recipe::of_surface(models::path("beam"), motion);
        bdtree_build::bake(&recipe, &Silent).expect("a bake").bytes
    });
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("beam.bdt");
    std::fs::write(&path, bytes).expect("written");
    AssetFile::read(&path).expect("a file")
}

pub(super) fn golden_file(name: &str) -> AssetFile {
    AssetFile::read(&golden::folder().join(name)).expect("a golden file")
}

pub(super) fn of(files: &[AssetFile]) -> Simulation {
    Simulation::new(files, SETTINGS).expect("a simulation")
}

/// A playground of tetrahedra that do not deform, seen from where it begins.
pub(super) fn tetrahedra(count: usize) -> Playground {
    let mut simulation = of(&[golden_file("tetrahedron.bdt")]);
    fill(&mut simulation, count).expect("bodies");
    let mut play = Playground::new(simulation);
    play.fit(SIZE[0] as f32 / SIZE[1] as f32);
    play
}

/// Where a point of the world is in the picture.
pub(super) fn pixel(play: &Playground, at: [f64; 3]) -> [f32; 2] {
    let camera = play.camera.expect("a camera");
    let at = at.map(|x| x as f32);
    camera.project(at, SIZE).expect("in front")
}

pub(super) fn center(simulation: &Simulation, body: usize) -> Vector3<f64> {
    let state = simulation.world().state(BodyId(body)).expect("a body");
    state.position.into()
}

fn velocity(simulation: &Simulation, body: usize) -> Vector3<f64> {
    let state = simulation.world().state(BodyId(body)).expect("a body");
    state.velocity.into()
}

/// No two bodies are within reach of each other, and none of the ground.
fn is_apart(simulation: &Simulation) -> bool {
    let balls: Vec<_> = simulation.balls().collect();
    balls.iter().enumerate().all(|(k, (a, reach))| {
        let away = |b: &[f64; 3]| (Vector3::from(*a) - Vector3::from(*b)).norm();
        a[1] >= *reach && balls[..k].iter().all(|(b, other)| away(b) >= reach + other)
    })
}

#[test]
fn files_that_cannot_fall_say_what_would_help() {
    let files = [
        golden_file("sphere.bdt"),
        golden_file("skinned.bdt"),
        golden_file("tetrahedron.bdt"),
    ];
    let mut simulation = of(&files);
    let problem = |kind: usize| simulation.able(kind).expect_err("it cannot fall");
    assert!(problem(0).starts_with("sphere.bdt: mode 0 has no frequency"));
    assert!(problem(0).ends_with("bdtree-build --modes 10, or start with --rigid"));
    assert!(problem(1).starts_with("skinned.bdt: the asset has a skin"));
    assert!(simulation.able(2).is_ok());
    // A grid is made of those that can.
    fill(&mut simulation, 5).expect("bodies");
    assert_eq!(simulation.of(), [2; 5]);
    let play = Playground::new(simulation);
    assert_eq!((play.chosen, &play.problem), (2, &None));
    // Where none can, that is what the window says.
    let mut simulation = of(&files[..1]);
    let error = fill(&mut simulation, 1).expect_err("nothing falls");
    let mut play = Playground::new(simulation);
    assert_eq!(play.problem.as_ref().map(|p| &p.text), Some(&error));
    play.fit(1.5);
    play.problem = None;
    play.drop_at([320.0, 300.0], SIZE);
    assert_eq!(play.problem.map(|p| p.text), Some(error));
    // Without its modes the first falls.
    let settings = Settings {
        is_deformable: false,
        ..SETTINGS
    };
    let mut rigid = Simulation::new(&files[..1], settings).expect("a simulation");
    fill(&mut rigid, 2).expect("bodies");
    rigid.steps(10, None).expect("steps");
    assert!(velocity(&rigid, 0).y < 0.0);
}

#[test]
fn a_grid_is_apart_and_the_same_for_a_seed_and_any_threads() {
    let files = [beam()];
    let run = |seed, threads| {
        let settings = Settings {
            step_s: 1.0 / 300.0,
            seed,
            threads,
            ..SETTINGS
        };
        let mut simulation = Simulation::new(&files, settings).expect("a simulation");
        fill(&mut simulation, 12).expect("bodies");
        assert!(is_apart(&simulation));
        simulation.steps(400, None).expect("steps");
        assert!(simulation.report().events > 0, "they lie on the ground");
        simulation.state()
    };
    let first = run(1, 1);
    assert_eq!(first, run(1, 2));
    assert_ne!(first, run(2, 1));
}

/// A beam is 5 cm thick and falls four times 0.5 m: 6.3 m/s, two radii of 1.3 cm in 1/240 s.
#[test]
fn thin_and_small_bodies_take_more_steps() {
    let rate = |files: &[AssetFile], scale| {
        let settings = Settings { scale, ..SETTINGS };
        let simulation = Simulation::new(files, settings).expect("a simulation");
        simulation.fitting_rate()
    };
    let files = [golden_file("tetrahedron.bdt"), beam()];
    assert_eq!(rate(&files[..1], 1.0), 150);
    assert_eq!(rate(&files, 1.0), 300);
    // Time goes with the root of sizes.
    assert_eq!(rate(&files, 0.1), 900);
    assert_eq!(rate(&files, 1e-6), 1200, "there is an end to it");
    // Fewer and larger spheres need fewer.
    let coarser = Settings {
        level: Some(0),
        ..SETTINGS
    };
    let coarser = Simulation::new(&files, coarser).expect("a simulation");
    assert_eq!(coarser.fitting_rate(), 150);
    // What cannot fall asks for nothing.
    assert_eq!(rate(&[golden_file("sphere.bdt")], 1e-6), 150);
}

#[test]
fn bodies_are_dropped_one_above_the_other() {
    let mut simulation = of(&[beam()]);
    let reach = simulation.kinds()[0].reach();
    for _ in 0..6 {
        drop_above(&mut simulation, 0, [0.3, 0.1, -0.2]).expect("a body");
        let (all, reach) = (simulation.balls().collect::<Vec<_>>(), reach);
        let (below, new) = all.split_at(all.len() - 1);
        for (at, _) in below {
            let away = Vector3::from(*at) - Vector3::from(new[0].0);
            assert!(away.norm() > 1.999_999 * reach, "{away}");
        }
        simulation.steps(20, None).expect("steps");
    }
    let heights: Vec<f64> = (0..6).map(|body| center(&simulation, body).y).collect();
    assert!(
        heights[0] < 2.2 * reach && heights[5] > 3.0 * reach,
        "{heights:?}"
    );
    drop_above(&mut simulation, 0, [9.0, 0.0, 9.0]).expect("a body");
    let alone = center(&simulation, 6);
    assert!(
        (alone - Vector3::new(9.0, 2.0 * reach, 9.0)).norm() < 1e-9,
        "{alone}"
    );
}

#[test]
fn a_step_that_fails_halts_before_it() {
    let mut play = tetrahedra(3);
    // Two bodies in one place, each turned another way.
    for _ in 0..2 {
        let place = [40.0, 5.0, 0.0];
        let still = [[0.0; 3]; 2];
        play.simulation.add(0, place, still).expect("a body");
    }
    let before = play.simulation.state();
    play.advance(1.0 / 30.0);
    let problem = play.problem.clone().expect("a failure");
    assert!(
        problem
            .text
            .starts_with("step 1: bodies 3 and 4 overlap by "),
        "{}",
        problem.text
    );
    assert!(
        problem.text.ends_with("; halted at the state before"),
        "{}",
        problem.text
    );
    assert_eq!(problem.bodies, [3, 4]);
    assert_eq!(play.simulation.state(), before);
    assert!(!play.pace.is_running && !play.is_moving());
    // Without them it goes on.
    play.remove(&problem.bodies);
    play.pace.toggle();
    play.advance(1.0 / 30.0);
    assert_eq!((play.simulation.world().steps(), &play.problem), (5, &None));
}

#[test]
fn what_is_too_fast_is_slowed_down() {
    let mut play = tetrahedra(1);
    let fast = [[0.0, -900.0, 0.0], [0.0; 3]];
    let added = play.simulation.add(0, [9.0, 20.0, 0.0], fast);
    assert_eq!(added, Ok(BodyId(1)));
    while play.problem.is_none() {
        play.advance(1.0 / 30.0);
    }
    let mut before = velocity(&play.simulation, 1).norm();
    for tries in 0.. {
        assert!(tries < 40, "{:?}", play.problem);
        let Some(problem) = play.problem.clone() else {
            break;
        };
        assert_eq!(
            (problem.bodies.as_slice(), play.pace.is_running),
            (&[1][..], false)
        );
        play.slow_down(&problem);
        let speed = velocity(&play.simulation, 1).norm();
        assert!(speed < 0.85 * before && play.pace.is_running, "{speed}");
        before = speed;
        (0..30).for_each(|_| play.advance(1.0 / 30.0));
    }
    assert!(velocity(&play.simulation, 0).norm() < 20.0);
}

#[test]
fn bodies_are_taken_out_and_the_others_go_on() {
    let mut simulation = of(&[beam()]);
    fill(&mut simulation, 3).expect("bodies");
    simulation.steps(80, None).expect("steps");
    let known = |simulation: &Simulation, body| {
        let at = simulation.world().placement(BodyId(body)).expect("a body");
        let mut rate = vec![0.0; simulation.q(body).len()];
        let told = simulation.world().q_rate(BodyId(body), &mut rate);
        told.expect("its own modes");
        let rate = rate.into_iter().map(|rate| rate as f32).collect();
        (at, [simulation.q(body), rate], velocity(simulation, body))
    };
    let before = [0, 2].map(|body| known(&simulation, body));
    simulation.remove(&[1]).expect("removed");
    for (body, (at, q, speed)) in before.iter().enumerate() {
        let (found, found_q, found_speed) = known(&simulation, body);
        for k in 0..3 {
            assert!((found.translation[k] - at.translation[k]).abs() < 1e-9);
        }
        let all = found_q.iter().flatten().zip(q.iter().flatten());
        assert!(all.clone().all(|(a, b)| (a - b).abs() < 1e-6));
        assert!(q[1].iter().any(|rate| rate.abs() > 1e-3));
        assert!((found_speed - speed).norm() < 1e-9);
    }
    simulation.steps(80, None).expect("steps");
    assert_eq!(simulation.of(), [0, 0]);
}

#[test]
fn the_beginning_comes_back() {
    let mut play = tetrahedra(4);
    let beginning = play.simulation.state();
    play.advance(0.05);
    let later = play.simulation.state();
    play.drop_at([320.0, 200.0], SIZE);
    assert_eq!(play.simulation.of().len(), 5);
    play.reset();
    assert_eq!(play.simulation.state(), beginning);
    play.advance(0.05);
    assert_eq!(play.simulation.state(), later, "and goes on as before");
    play.clear();
    assert!(play.simulation.of().is_empty() && !play.is_moving());
    play.reset();
    assert_eq!(play.simulation.of().len(), 4);
}

#[test]
fn a_checkpoint_goes_on_with_files_in_another_order() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("state");
    let mut first = of(&[golden_file("tetrahedron.bdt"), beam()]);
    fill(&mut first, 6).expect("bodies");
    first.steps(100, None).expect("steps");
    checkpoint::write(&path, &first).expect("written");
    let mut again = of(&[beam(), golden_file("tetrahedron.bdt")]);
    checkpoint::read(&path, &mut again).expect("read");
    assert_eq!(again.of(), [1, 0, 1, 0, 1, 0]);
    for simulation in [&mut first, &mut again] {
        simulation.steps(50, None).expect("steps");
        drop_above(simulation, simulation.of()[0], [0.0; 3]).expect("a body");
        simulation.steps(50, None).expect("steps");
    }
    assert_eq!(first.state().world, again.state().world);

    let refused = |files: &[AssetFile], settings: Settings| {
        let mut simulation = Simulation::new(files, settings).expect("a simulation");
        let error = checkpoint::read(&path, &mut simulation).expect_err("refused");
        assert!(simulation.of().is_empty());
        error.to_string()
    };
    let all = [golden_file("tetrahedron.bdt"), beam()];
    let scaled = Settings {
        scale: 2.0,
        ..SETTINGS
    };
    let faster = Settings {
        step_s: 1.0 / 300.0,
        ..SETTINGS
    };
    let rigid = Settings {
        is_deformable: false,
        ..SETTINGS
    };
    assert!(refused(&all, scaled).ends_with("is of bodies with --scale 1"));
    assert!(refused(&all, faster).ends_with("is of --rate 150"));
    let coarser = Settings {
        level: Some(0),
        ..SETTINGS
    };
    assert!(refused(&all, rigid).ends_with("is of a run without --rigid"));
    assert!(refused(&all, coarser).ends_with("is of a run without --level"));
    let text = refused(&all[..1], SETTINGS);
    assert!(
        text.ends_with("has bodies of another file, beam.bdt: open it, too"),
        "{text}"
    );
    let bytes = std::fs::read(&path).expect("there");
    std::fs::write(&path, &bytes[..bytes.len() - 1]).expect("written");
    assert!(refused(&all, SETTINGS).contains("not a saved state"));
    std::fs::write(&path, "notes").expect("written");
    assert!(refused(&all, SETTINGS).ends_with("is not a checkpoint of the playground"));
}
