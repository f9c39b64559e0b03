//! The face and its shapes are what their pages say.

use bdtree_tests::fixtures::face::{face, face_shapes};

#[test]
fn shapes_are_local_and_mirror_each_other() {
    let mesh = face();
    assert!(mesh.is_manifold());
    let shapes = face_shapes(&mesh);
    assert_eq!(shapes.len(), 52);
    let mut names: Vec<&str> = shapes.iter().map(|s| s.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), 52);

    let moved = |field: &[[f64; 3]]| field.iter().filter(|u| **u != [0.0; 3]).count();
    let longest = |field: &[[f64; 3]]| {
        let square = |u: &[f64; 3]| u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
        field.iter().map(square).fold(0.0, f64::max).sqrt()
    };
    let mut total = 0;
    for shape in &shapes {
        let share = moved(&shape.field) as f64 / mesh.positions.len() as f64;
        assert!((0.014..0.35).contains(&share), "{} {share}", shape.name);
        let reach = longest(&shape.field);
        assert!((1e-3..3e-2).contains(&reach), "{} {reach}", shape.name);
        total += moved(&shape.field);
        if let Some(name) = shape.name.strip_suffix("_left") {
            let other = shapes.iter().find(|s| s.name == format!("{name}_right"));
            let other = &other.expect("a mirror image").field;
            // The grid is its own mirror image, but its rounding is not.
            assert!(moved(other).abs_diff(moved(&shape.field)) <= 20, "{name}");
            assert!((longest(other) - reach).abs() < 1e-9, "{name}");
        }
    }
    let mean = total as f64 / mesh.positions.len() as f64;
    assert!((3.5..4.5).contains(&mean), "{mean} shapes per vertex");
    let large = shapes
        .iter()
        .filter(|s| 5 * moved(&s.field) > mesh.positions.len());
    assert!((2..8).contains(&large.count()), "most shapes are small");
}
