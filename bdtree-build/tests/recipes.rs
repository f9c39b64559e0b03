//! Bakes described to the library: the same bytes as from the command, and problems with typed places.

use std::path::{Path, PathBuf};
use std::process::Command;

use bdtree_build::basis::dropped::Keep;
use bdtree_build::basis::pca::PcaOptions;
use bdtree_build::basis::volume::VolumeOptions;
use bdtree_build::error::{BakeError, Part, Place};
use bdtree_build::progress::{Progress, Silent};
use bdtree_build::recipe::{Elastic, Frames, Given, Morphs, Motion, Recipe, Source, Volume};
use bdtree_build::{Baked, bake};

fn fixture(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures");
    folder.join(name)
}

/// What the command writes.
fn command(arguments: &[&str]) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let output = Command::new(env!("CARGO_BIN_EXE_bdtree-build"))
        .args(arguments)
        .args(["-o", "x.bdt", "--quiet"])
        .current_dir(folder.path())
        .output()
        .expect("the command starts");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {stderr}");
    std::fs::read(folder.path().join("x.bdt")).expect("the file")
}

fn baked(recipe: &Recipe) -> Baked {
    bake(recipe, &Silent).expect("a sound recipe")
}

fn refused(recipe: &Recipe) -> BakeError {
    bake(recipe, &Silent).expect_err("a refusal")
}

fn elastic(mode_count: usize, resolution: u32) -> Elastic {
    let mut elastic = Elastic::default();
    elastic.options.mode_count = mode_count;
    elastic.options.resolution = Some(resolution);
    elastic
}

#[test]
fn recipes_and_arguments_make_the_same_bytes() {
    let path = |name: &str| fixture(name).display().to_string();
    let torus = path("torus.obj");
    let arguments = [torus.as_str(), "--modes", "3", "--resolution", "10"];
    let own = baked(&Recipe::of_surface(&torus, Motion::Elastic(elastic(3, 10))));
    assert!(own.bytes == command(&arguments));
    assert_eq!(own.report.elastic.expect("elastic modes").resolution, 10);

    let own = baked(&Recipe::of_surface(&torus, Motion::Rigid));
    assert!(own.bytes == command(&[&torus, "--modes", "0"]));

    let morphs = path("morph_nodes.glb");
    let first = Morphs {
        keep: Keep::First(1),
        ..Morphs::default()
    };
    let own = baked(&Recipe::of_surface(&morphs, Motion::Morphs(first)));
    assert!(own.bytes == command(&[&morphs, "--modes", "1"]));

    let (cube, swells) = (path("cube.obj"), path("cube_swells.npy"));
    let given = Given {
        path: swells.clone().into(),
        layout: None,
        frequencies: None,
        keep: Keep::All,
        range_rel: Some(0.1),
    };
    let own = baked(&Recipe::of_surface(&cube, Motion::Given(given)));
    assert!(own.bytes == command(&[&cube, "--basis", &swells, "--range-rel", "0.1"]));

    let tets = path("beam_tets.veg");
    let volume = Volume {
        path: tets.clone().into(),
        surface: None,
        options: VolumeOptions {
            mode_count: 2,
            ..VolumeOptions::default()
        },
        range_rel: None,
    };
    let own = baked(&Recipe::new(Source::Volume(volume)));
    assert!(own.bytes == command(&["--tets", &tets, "--modes", "2"]));
    assert!(own.report.volume.expect("modes of a volume").mass_kg > 0.0);

    let wave = path("wave");
    let frames = Frames {
        path: wave.clone().into(),
        surface: None,
        fps: Some(30.0),
        options: PcaOptions {
            align: true,
            ..PcaOptions::default()
        },
    };
    let own = baked(&Recipe::new(Source::Frames(frames)));
    assert!(own.bytes == command(&["--animation", &wave, "--fps", "30", "--align"]));
}

#[test]
fn a_file_decides_between_morph_targets_and_vibration() {
    let motion = || Motion::MorphsElseElastic(Morphs::default(), elastic(2, 8));
    let morphs = baked(&Recipe::of_surface(fixture("morph_nodes.glb"), motion()));
    assert!(morphs.report.elastic.is_none() && morphs.report.basis_error_rel.is_some());
    let vibration = baked(&Recipe::of_surface(fixture("torus.obj"), motion()));
    assert!(vibration.report.elastic.is_some() && vibration.report.modes == 2);
    let none = Motion::MorphsElseElastic(Morphs::default(), elastic(0, 8));
    assert_eq!(
        baked(&Recipe::of_surface(fixture("torus.obj"), none))
            .report
            .modes,
        0
    );

    let error = refused(&Recipe::of_surface(
        fixture("torus.obj"),
        Motion::Morphs(Morphs::default()),
    ));
    let place = Place::from(fixture("torus.obj").as_path());
    assert_eq!(error.problems[0].place, place);
    assert!(error.to_string().contains("no morph targets"), "{error}");
}

#[test]
fn problems_name_file_and_part() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("far.obj");
    std::fs::write(&path, "v 0 0 0\nv 1e300 0 0\nv 0 1 0\nf 1 2 3\n").expect("a mesh");
    let error = refused(&Recipe::of_surface(&path, Motion::Elastic(elastic(1, 4))));
    let place = Place::from(path.as_path()).at(Part::Vertex(1));
    assert_eq!(
        (error.problems.len(), &error.problems[0].place),
        (1, &place)
    );
    assert!(error.to_string().contains("far.obj: vertex 1: "), "{error}");

    let bad = fixture("bad_numbers.obj");
    let error = refused(&Recipe::of_surface(&bad, Motion::Rigid));
    let lines: Vec<&[Part]> = error.problems.iter().map(|p| &p.place.parts[..]).collect();
    assert!(lines.contains(&&[Part::Line(15)][..]), "{lines:?}");
    assert!(error.problems.iter().all(|p| p.stage == "input"));

    let mut unsound = elastic(1, 4);
    unsound.options.young_pa = -1.0;
    unsound.options.poisson = 2.0;
    let error = refused(&Recipe::of_surface(
        fixture("cube.obj"),
        Motion::Elastic(unsound),
    ));
    let places: Vec<Place> = error.problems.into_iter().map(|p| p.place).collect();
    assert_eq!(places, ["--young", "--poisson"].map(Place::option));
}

/// The names of the stages that begin.
#[derive(Default)]
struct Names(std::cell::RefCell<Vec<String>>);

impl Progress for Names {
    fn stage(&self, name: &str, _steps: Option<u64>) {
        self.0.borrow_mut().push(name.to_string());
    }

    fn advance(&self, _steps: u64) {}
}

#[test]
fn stages_begin_in_order_and_are_timed() {
    let names = Names::default();
    let recipe = Recipe::of_surface(fixture("cube.obj"), Motion::Rigid);
    let baked = bake(&recipe, &names).expect("a sound recipe");
    let begun = names.0.into_inner();
    let expected = [
        "input", "basis", "store", "tree", "leaves", "wrap", "encode", "report",
    ];
    assert_eq!(begun, expected);
    // The leaves' time is the tree's.
    let timed = begun.iter().filter(|name| *name != "leaves");
    assert!(
        timed
            .clone()
            .all(|name| baked.report.stages.contains_key(name))
    );
    assert_eq!(baked.report.stages.len(), timed.count());
}

/// Steps that a stage has done, one call after the other.
#[derive(Default)]
struct Steps {
    of: &'static str,
    counting: std::cell::Cell<bool>,
    total: std::cell::Cell<u64>,
    done: std::cell::RefCell<Vec<u64>>,
}

impl Progress for Steps {
    fn stage(&self, name: &str, steps: Option<u64>) {
        self.counting.set(name == self.of);
        if let (true, Some(steps)) = (self.counting.get(), steps) {
            self.total.set(steps);
        }
    }

    fn advance(&self, steps: u64) {
        if self.counting.get() {
            self.done.borrow_mut().push(steps);
        }
    }
}

/// Stages that may take long tell how far they are, from their first seconds to their end.
#[test]
fn long_stages_tell_how_far_they_are() {
    let mut elastic = Elastic::default();
    elastic.options.mode_count = 4;
    elastic.options.resolution = Some(10);
    let mut recipe = Recipe::of_surface(fixture("torus.obj"), Motion::Elastic(elastic));
    for (of, threads) in [
        ("modes", 1),
        ("leaves", 1),
        ("leaves", 2),
        ("wrap", 1),
        ("wrap", 2),
    ] {
        recipe.settings.threads = threads;
        let steps = Steps {
            of,
            ..Steps::default()
        };
        bake(&recipe, &steps).expect("a sound recipe");
        let done = steps.done.into_inner();
        assert_eq!(done.iter().sum::<u64>(), steps.total.get(), "{of}");
        if of == "modes" {
            let told = done.iter().filter(|steps| **steps > 0);
            assert!(told.count() >= 5, "{done:?}");
            let most = done.iter().max().copied().unwrap_or(0);
            assert!(most <= steps.total.get() / 2, "{done:?}");
        }
    }
}
