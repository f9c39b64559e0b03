//! What a bake refuses, and what it reports.

use crate::tree_support::*;
use bdtree_build::basis::{Basis, BasisMode};
use bdtree_build::error::{BakeError, Part, Place};
use bdtree_build::input::{GroupKind, RawGroup, RawMesh};
use bdtree_build::pipeline::{BakeSettings, Provenance, bake_fields};
use bdtree_build::progress::Silent;

#[test]
fn bad_input_is_refused_with_its_place() {
    let good = grid(3);
    let fields = waves(&good, 2);
    let refuse = |mesh: &RawMesh, basis: &Basis| {
        bake_fields(
            mesh,
            basis,
            &BakeSettings::default(),
            &Provenance::default(),
            &Silent,
        )
        .unwrap_err()
    };
    let places = |error: BakeError| -> Vec<Place> {
        error
            .problems
            .into_iter()
            .map(|problem| problem.place)
            .collect()
    };
    let text = refuse(&RawMesh::default(), &Basis::default()).to_string();
    assert!(text.contains("no triangles"), "{text}");
    let mut mesh = good.clone();
    mesh.positions[7][1] = f64::NAN;
    assert_eq!(places(refuse(&mesh, &fields)), [Part::Vertex(7).into()]);
    mesh = good.clone();
    mesh.triangles[4] = [0, 1, 99];
    assert_eq!(places(refuse(&mesh, &fields)), [Part::Triangle(4).into()]);
    let mut basis = fields.clone();
    basis.fields[good.positions.len() + 3][0] = f64::INFINITY;
    assert_eq!(
        places(refuse(&good, &basis))[0],
        Place::from(Part::Mode(1)).at(Part::Vertex(3))
    );
    basis = fields.clone();
    basis.fields[2][0] = 1e200;
    assert_eq!(
        places(refuse(&good, &basis))[0],
        Place::from(Part::Mode(0)).at(Part::Vertex(2))
    );
    basis = fields.clone();
    basis.fields[2][0] = 1e38;
    assert_eq!(places(refuse(&good, &basis)), [Part::Mode(0).into()]);
    basis = fields.clone();
    basis.modes[1].q_range = Some(-1.0);
    assert_eq!(places(refuse(&good, &basis)), [Part::Mode(1).into()]);
    basis = fields.clone();
    basis.modes[0].omega_rad_s = Some(f64::NAN);
    assert_eq!(places(refuse(&good, &basis)), [Part::Mode(0).into()]);
    mesh = good.clone();
    mesh.groups.push(RawGroup {
        kind: GroupKind::Object,
        name: "wing".to_string(),
        first_triangle: 10,
        triangle_count: 9,
    });
    assert_eq!(
        places(refuse(&mesh, &fields)),
        [Part::Group("wing".to_string()).into()]
    );
    basis = fields.clone();
    basis.vertex_count = 3;
    assert!(refuse(&good, &basis).to_string().contains("16"));
    let many = crate::tree_support::basis(&good, 513, |_, p| p);
    assert!(refuse(&good, &many).to_string().contains("513"));
    let settings = BakeSettings {
        leaf_size: Some(0),
        ..BakeSettings::default()
    };
    assert!(bake_fields(&good, &fields, &settings, &Provenance::default(), &Silent).is_err());
}

#[test]
fn reports_what_was_made() {
    let mesh = grid(30);
    let baked = bake_with(&mesh, &waves(&mesh, 4), &BakeSettings::default());
    let json = serde_json::to_value(&baked.report).unwrap();
    assert_eq!(json["vertices"], 961);
    assert_eq!(json["triangles"], 1800);
    assert_eq!(json["modes"], 4);
    assert_eq!(json["bytes"], baked.bytes.len());
    assert!(json["frequencies_hz"].is_null() && json["basis_error_rel"].is_null());
    let levels = json["tightness"].as_array().unwrap();
    assert_eq!(levels.len() as u64, json["depth"].as_u64().unwrap());
    for level in levels {
        let (mean, max) = (
            level["mean"].as_f64().unwrap(),
            level["max"].as_f64().unwrap(),
        );
        assert!((1.0 - 1e-6..2.0).contains(&mean) && max >= mean, "{level}");
    }
}

#[test]
fn what_would_not_open_is_not_made() {
    let mesh = RawMesh {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        ..RawMesh::default()
    };
    let mut basis = Basis {
        vertex_count: 3,
        fields: vec![[0.0, 0.0, 1.0]; 3],
        modes: vec![BasisMode {
            modal_mass_kg: Some(0.0),
            ..BasisMode::default()
        }],
        animation: None,
    };
    let made = |basis: &Basis| {
        bake_fields(
            &mesh,
            basis,
            &BakeSettings::default(),
            &Provenance::default(),
            &Silent,
        )
    };
    let error = made(&basis).unwrap_err().to_string();
    assert_eq!(error, "mode 0: modal mass 0 kg is not a positive number");
    basis.modes[0].modal_mass_kg = Some(1e-300);
    assert!(made(&basis).is_ok());
}

#[test]
fn sizes_that_readers_refuse_are_refused() {
    let made = |scale: f64, offset: f64| {
        let mesh = RawMesh {
            positions: [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
                .map(|p| p.map(|x| x * scale + offset))
                .to_vec(),
            triangles: vec![[0, 1, 2]],
            ..RawMesh::default()
        };
        let settings = BakeSettings::default();
        bake_fields(
            &mesh,
            &Basis::default(),
            &settings,
            &Provenance::default(),
            &Silent,
        )
        .map(|_| ())
    };
    for (scale, offset) in [(1e150, 0.0), (1e-310, 0.0), (1e28, 1e30)] {
        let error = made(scale, offset).unwrap_err().to_string();
        assert!(error.contains("cannot be stored"), "{error}");
    }
    for (scale, offset) in [
        (1e29, 0.0),
        (1e-29, 0.0),
        (1.0, 1e6),
        (0.0, 0.0),
        (0.0, 5.0),
    ] {
        assert_eq!(made(scale, offset), Ok(()), "{scale} {offset}");
    }
}
