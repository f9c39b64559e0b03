//! What follows a file that was read: a bake, `verify`, queries beside brute force.

use std::ops::ControlFlow;
use std::path::Path;

use bdtree_build::basis::Basis;
use bdtree_build::basis::dropped::{Keep, keep_fields};
use bdtree_build::basis::elastic::{ElasticOptions, elastic_basis};
use bdtree_build::basis::modal::modal_basis;
use bdtree_build::basis::morph::morph_basis;
use bdtree_build::basis::pca::{Modes, PcaOptions, pca_basis};
use bdtree_build::basis::volume::{VolumeOptions, volume_modes};
use bdtree_build::error::BakeError;
use bdtree_build::input::volume::surface;
use bdtree_build::input::{RawMesh, RawModel};
use bdtree_build::pipeline::{BakeSettings, Provenance, bake_fields};
use bdtree_build::progress::Silent;
use bdtree_runtime::{Ball, CacheSize, Contact, Model, Shape, Workspace};
use bdtree_tools::scene::{Query, Scene};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use serde_json::Value;

use super::read::Thing;
use bdtree_fixtures::compare::check_pose;
use bdtree_fixtures::{bake, oracle, poses};

/// Larger meshes are read only.
const TRIANGLES_MAX: usize = 4000;

/// Memory that modes and fields may take.
const MEMORY_BYTES: u64 = 512 << 20;

/// Bodies up to here are asked everything that `check_pose` asks, with arguments 10^15 times as
/// large.
const CHECKED_MAX: f64 = 1e14;

/// Bodies up to here are asked something: arguments lie below 2^100.
const ASKED_MAX: f64 = 1e29;

/// How far a thing got.
pub(super) enum End {
    /// Into a file whose queries equal brute force, or answers that do.
    Right,
    /// A later stage refused it: one line per problem.
    Refused(Vec<String>),
    /// There is nothing to follow.
    Nothing,
}

/// Bakes and asks; panics where an answer is wrong.
pub(super) fn follow(thing: Thing, rng: &mut Pcg64Mcg) -> End {
    let fields = match thing {
        Thing::Used => return End::Nothing,
        Thing::Scene(path, lines) => {
            check_answers(&path, &lines);
            return End::Right;
        }
        Thing::Model(model) if model.mesh.triangles.len() > TRIANGLES_MAX => return End::Nothing,
        Thing::Model(model) => of_model(model, rng),
        Thing::Basis(given, mesh) => {
            keep_fields(&mesh, given.basis, Keep::All).map(|kept| (mesh, kept.basis))
        }
        Thing::Sequence(sequence, mesh) => {
            let options = PcaOptions {
                modes: Modes::Count(rng.random_range(0..4)),
                align: rng.random_range(0..2) == 0,
                memory_limit_bytes: MEMORY_BYTES,
                ..PcaOptions::default()
            };
            pca_basis(&mesh, &sequence, &options, &Silent, &mut Vec::new())
                .map(|pca| (pca.mesh, pca.basis))
        }
        Thing::Volume(volume) => {
            let mesh = surface(&volume);
            if mesh.triangles.len() > TRIANGLES_MAX {
                return End::Nothing;
            }
            let options = VolumeOptions {
                mode_count: 2,
                memory_limit_bytes: MEMORY_BYTES,
                ..VolumeOptions::default()
            };
            volume_modes(&volume, &options, &Silent, &mut Vec::new()).map(|(modes, _)| {
                let fields = modes.on_vertices(<[_]>::to_vec);
                let basis = modal_basis(volume.nodes.len(), fields, &mut Vec::new());
                (mesh, basis)
            })
        }
    };
    match fields.and_then(|(mesh, basis)| bake_and_ask(&mesh, &basis, rng)) {
        Ok(()) => End::Right,
        Err(error) => End::Refused(error.problems.iter().map(ToString::to_string).collect()),
    }
}

/// The mesh with its morph targets, smooth fields, none, or its vibration modes.
fn of_model(model: RawModel, rng: &mut Pcg64Mcg) -> Result<(RawMesh, Basis), BakeError> {
    let RawModel { mesh, morphs, .. } = model;
    let basis = if !morphs.targets.is_empty() {
        morph_basis(&mesh, &morphs, Keep::All, MEMORY_BYTES, &mut Vec::new())?.basis
    } else {
        match rng.random_range(0..8) {
            0..4 => bake::rigid(&mesh),
            4..7 => bake::smooth_basis(&mesh, 2, 1),
            _ => {
                let options = ElasticOptions {
                    mode_count: 2,
                    resolution: Some(4),
                    memory_limit_bytes: MEMORY_BYTES,
                    ..ElasticOptions::default()
                };
                elastic_basis(&mesh, &options, &Silent, &mut Vec::new())?.0
            }
        }
    };
    Ok((mesh, basis))
}

fn bake_and_ask(mesh: &RawMesh, basis: &Basis, rng: &mut Pcg64Mcg) -> Result<(), BakeError> {
    let settings = BakeSettings {
        leaf_size: [None, Some(1), Some(8)][rng.random_range(0..3)],
        ..BakeSettings::default()
    };
    let baked = bake_fields(mesh, basis, &settings, &Provenance::default(), &Silent)?;
    let model = Model::from_bytes(&baked.bytes).expect("a baked file opens");
    let asset = model.asset();
    let sound = asset.verify(&mut |error| {
        eprintln!("{error}");
        ControlFlow::Continue(())
    });
    assert!(sound, "a baked file is not sound");
    let q = match rng.random_range(0..4) {
        0 => {
            let hard = poses::hard_qs(asset);
            hard[rng.random_range(0..hard.len())].clone()
        }
        _ => poses::random_q(asset, 0.2, rng),
    };
    let place = poses::random_transform(1.0, rng);
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = asset.pose(&q, place, &mut memory).expect("a pose");
    let body = oracle::deformed_triangles(&pose);
    let farthest = body.as_flattened().as_flattened().iter();
    let farthest = farthest.fold(0.0_f64, |m, x| m.max(x.abs()));
    if farthest < CHECKED_MAX {
        check_pose([*asset], &q, place, rng.random_range(0..u64::MAX), 1);
    } else if farthest < ASKED_MAX {
        let (center, radius) = (body[0][0], 0.5 * farthest);
        let mut workspace = Workspace::new();
        let mut found: Vec<Contact> = Vec::new();
        let mut query = pose.query(&mut workspace);
        let coverage = query.contacts(Ball::new(center, radius), &mut found);
        coverage.expect("a ball");
        let mut found: Vec<u32> = found.iter().map(|contact| contact.triangle.0).collect();
        found.sort_unstable();
        let expected = oracle::ball(&body, center, radius);
        assert!(expected.iter().map(|(id, _)| *id).eq(found), "a ball");
    }
    Ok(())
}

/// The answers of a scene beside brute force: balls, planes and nearest points of the first three
/// that are asked without a limit of depth or visits.
fn check_answers(path: &Path, lines: &str) {
    let scene = Scene::load(path, true).expect("it was read before");
    let lines: Vec<Value> = lines
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    assert_eq!(lines.len(), scene.queries.len(), "one line per query");
    for (i, line) in lines.iter().enumerate() {
        assert_eq!(line["query"].as_u64(), Some(i as u64));
    }
    if scene.options.max_depth.is_some() || scene.options.max_visits.is_some() {
        return;
    }
    let bodies = scene.bodies(|_| CacheSize::NONE).expect("poses");
    let known = |(query, _): &(&Query, &Value)| {
        matches!(
            query,
            Query::Contacts {
                shape: Shape::Ball(_) | Shape::HalfSpace(_),
                ..
            } | Query::Closest { .. }
        )
    };
    for (query, line) in scene.queries.iter().zip(&lines).filter(known).take(3) {
        let (Query::Contacts { instance, .. } | Query::Closest { instance, .. }) = *query else {
            continue;
        };
        let body = oracle::deformed_triangles(&bodies[instance].pose());
        let ids = |found: Vec<u32>| serde_json::json!(found);
        match *query {
            Query::Contacts {
                shape: Shape::Ball(ball),
                ..
            } => {
                let found = oracle::ball(&body, ball.center, ball.radius);
                let found = found.into_iter().map(|(id, _)| id).collect();
                assert_eq!(line["triangles"], ids(found), "{query:?}");
            }
            Query::Contacts {
                shape: Shape::HalfSpace(below),
                ..
            } => {
                let found = oracle::plane(&body, oracle::unit(below.normal), below.offset);
                assert_eq!(line["triangles"], ids(found), "{query:?}");
            }
            Query::Closest {
                point,
                max_distance,
                ..
            } => {
                let found = oracle::closest(&body, point, max_distance);
                let id = line["triangle"].as_u64().map(|id| id as u32);
                assert_eq!(
                    (id, line["distance"].as_f64()),
                    (found.map(|f| f.0), found.map(|f| f.1)),
                    "{query:?}"
                );
            }
            _ => {}
        }
    }
}
