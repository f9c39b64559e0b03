//! What the source has called modes and triangles.

use bdtree_build::input::{GroupKind as Kind, RawGroup};
use bdtree_fixtures::bake;
use bdtree_runtime::{GroupKind, Model, TriangleId};

#[test]
fn modes_are_found_by_name() {
    let (mesh, basis) = bake::face_with_shapes();
    let model = bake::baked(&mesh, &basis);
    let asset = model.asset();
    let expected: Vec<Option<&str>> = basis
        .modes
        .iter()
        .map(|mode| mode.name.as_deref())
        .collect();
    assert_eq!(asset.mode_count(), 52);
    let names: Vec<Option<&str>> = asset.mode_names().collect();
    assert_eq!(names, expected);
    for (k, name) in expected.iter().enumerate() {
        let name = name.expect("a name");
        assert_eq!(asset.mode_name(k), Some(name));
        assert_eq!(asset.mode_index(name), Some(k));
    }
    assert_eq!(asset.mode_name(52), None);
    assert_eq!(asset.mode_index("no such shape"), None);
}

#[test]
fn a_name_that_stands_twice_is_the_first_mode_and_one_may_have_none() {
    let mesh = bake::bumpy_sphere(5, 1);
    let mut basis = bake::smooth_basis(&mesh, 4, 2);
    basis.modes[1].name = Some("smile".into());
    basis.modes[3].name = Some("smile".into());
    basis.modes[2].name = Some("läuft".into());
    let model = bake::baked(&mesh, &basis);
    let asset = model.asset();
    let names: Vec<Option<&str>> = asset.mode_names().collect();
    assert_eq!(names, [None, Some("smile"), Some("läuft"), Some("smile")]);
    assert_eq!(asset.mode_index("smile"), Some(1));
    assert_eq!(asset.mode_index("läuft"), Some(2));
    assert_eq!(
        (asset.mode_name(0), asset.mode_name(3)),
        (None, Some("smile"))
    );
    // Names outlive the view: they are the file's bytes.
    let kept: Option<&str> = {
        let view = *asset;
        view.mode_name(2)
    };
    assert_eq!(kept, Some("läuft"));
}

#[test]
fn groups_have_their_kinds() {
    let mut mesh = bake::bumpy_sphere(5, 1);
    let given = [
        (Kind::Object, GroupKind::Object, "body", 0, 30),
        (Kind::Group, GroupKind::Group, "left", 3, 7),
        (Kind::Material, GroupKind::Material, "glass", 5, 9),
    ];
    mesh.groups = given
        .iter()
        .map(|(kind, _, name, first, count)| RawGroup {
            kind: *kind,
            name: (*name).to_string(),
            first_triangle: *first,
            triangle_count: *count,
        })
        .collect();
    let model: Model = bake::baked(&mesh, &bake::rigid(&mesh));
    let groups: Vec<_> = model.asset().groups().collect();
    assert_eq!(groups.len(), given.len());
    for (group, (_, kind, name, first, count)) in groups.iter().zip(given) {
        assert_eq!((group.kind, group.name), (kind, name));
        assert_eq!(
            (group.first_triangle, group.triangle_count),
            (TriangleId(first), count)
        );
    }
    assert_eq!(model.asset().mode_names().count(), 0);
}
