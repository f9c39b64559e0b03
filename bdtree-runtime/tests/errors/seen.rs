//! A sound file, and the rules of the errors that others lead to.

use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::sync::LazyLock;

use bdtree_build::input::{GroupKind, RawGroup};
use bdtree_build::mass::Momentum;
use bdtree_fixtures::bake;
use bdtree_runtime::{
    Ball, Contact, Datum, FormatError, Instance, Model, QueryError, SkeletonError, SkeletonPose,
    Workspace,
};

/// Several nodes, six local modes (so the header block ends with padding), frames, groups, mass
/// and momenta, metadata.
pub(crate) static FILE: LazyLock<Model> = LazyLock::new(|| {
    let mut mesh = bake::bumpy_sphere(14, 1);
    for name in ["a", "b"] {
        mesh.groups.push(RawGroup {
            kind: GroupKind::Group,
            name: name.to_string(),
            first_triangle: 3,
            triangle_count: 4,
        });
    }
    let mut basis = bake::smooth_basis(&mesh, 6, 1);
    let count = mesh.positions.len();
    for (k, u) in basis.fields.iter_mut().enumerate() {
        if mesh.positions[k % count][(k / count) % 3] < 0.5 {
            *u = [0.0; 3];
        }
    }
    // The sphere is closed, so it has a mass; modes of which that is known have momenta.
    for (j, mode) in basis.modes.iter_mut().enumerate() {
        mode.modal_mass_kg = Some(2.0);
        mode.momentum = Some(Momentum {
            about: [0.1, 0.2, 0.3],
            linear: [1.0, 0.0, j as f64],
            angular: [0.5; 3],
        });
    }
    bake::baked(&mesh, &bake::with_frames(basis, 3, 1.0, 1))
});

/// The rules of the errors seen so far; each error's text is checked when it is noted.
#[derive(Default)]
pub(crate) struct Seen(pub(crate) BTreeSet<String>);

impl Seen {
    pub(crate) fn note(&mut self, error: &FormatError) {
        let text = error.to_string();
        // What a caller gave has no place in the file.
        let arguments = [
            "SPEC 7.1: a vertex id",
            "SPEC 7.2: a triangle id",
            "argument",
        ];
        if arguments.iter().any(|rule| error.rule.starts_with(rule)) {
            let told = ["there is no ", "argument `out` holds "];
            assert!(told.iter().any(|start| text.starts_with(start)), "{text}");
            self.0.insert(error.rule.to_string());
            return;
        }
        let place = format!("section {} at byte {}: ", error.section, error.byte);
        let rest = text.strip_prefix(&place).expect("the place comes first");
        let fault = rest.strip_suffix(&format!(" ({})", error.rule));
        let fault = fault.expect("the rule comes last");
        let number = |datum| match datum {
            Datum::Integer(x) => x,
            other => panic!("{other} is no whole number"),
        };
        let least = |datum| match datum {
            Datum::AtLeast(x) => x,
            other => panic!("{other} is no least number"),
        };
        let (expected, found) = (error.expected, error.found);
        let told = match &error.rule[..8] {
            _ if error.rule.contains("magic bytes") => {
                "not a .bdt file, or one that was transferred as text".to_string()
            }
            "SPEC 9.1" => {
                format!("format version {found} is not supported (this program reads {expected})")
            }
            "SPEC 2.4" if error.rule.contains("CRC-32") => format!(
                "checksum mismatch: the header says {:08x}, the bytes give {:08x}",
                number(found),
                number(expected)
            ),
            "SPEC 4.1" if error.rule.contains("checksum") => format!(
                "checksum mismatch: the section table says {:08x}, the bytes give {:08x}",
                number(expected),
                number(found)
            ),
            "SPEC 2.1" if error.rule.contains("whole header") => {
                format!(
                    "the file has {found} bytes, its header needs {}",
                    least(expected)
                )
            }
            "SPEC 3.4" if error.rule.contains("header block") => format!(
                "the file has {found} bytes, its header and tables need {}",
                least(expected)
            ),
            "SPEC 3.4" if error.rule.contains("file_bytes") => {
                format!("the file has {found} bytes, its header says {expected}")
            }
            _ => format!("found {found}, expected {expected}"),
        };
        assert_eq!(fault, told);
        self.0.insert(error.rule.to_string());
    }

    /// Opens, verifies and plays the clips of a skin; notes everything.
    pub(crate) fn skinned(&mut self, bytes: &[u8]) {
        let model = match Model::from_bytes(bytes) {
            Ok(model) => model,
            Err(error) => return self.note(&error),
        };
        let asset = model.asset();
        let sound = asset.verify(&mut |error| {
            self.note(&error);
            ControlFlow::Continue(())
        });
        let clips = asset.skeleton().map_or(0, |skeleton| skeleton.clip_count());
        let played = SkeletonPose::new(&model)
            .and_then(|mut pose| (0..clips).try_for_each(|clip| pose.play(clip, 0.75)));
        match played {
            Err(SkeletonError::Corrupt(error)) => {
                assert!(!sound, "{error}");
                let text = SkeletonError::from(error).to_string();
                assert_eq!(text, error.to_string());
                self.note(&error);
            }
            Err(SkeletonError::NoSkin) => assert!(asset.skeleton().is_none()),
            Err(error) => panic!("{error}"),
            Ok(()) => {}
        }
    }

    /// Opens, verifies and asks; notes everything.
    pub(crate) fn everything(&mut self, bytes: &[u8]) {
        let model = match Model::from_bytes(bytes) {
            Ok(model) => model,
            Err(error) => return self.note(&error),
        };
        model.asset().verify(&mut |error| {
            self.note(&error);
            ControlFlow::Continue(())
        });
        let mut body = Instance::new(&model).expect("an instance");
        let q = vec![0.01; model.asset().mode_count()];
        body.set_q(&q).expect("pose");
        let mut workspace = Workspace::new();
        let mut query = body.query(&mut workspace);
        let mut found: Vec<Contact> = Vec::new();
        let ball = query.contacts(Ball::new([0.0; 3], 100.0), &mut found);
        if let Err(QueryError::Corrupt(error)) = ball {
            assert!(
                QueryError::from(error)
                    .to_string()
                    .ends_with(&error.to_string())
            );
            self.note(&error);
        }
    }
}
