//! The fields we give in tests, through the reader of given bases; and the large meshes' bytes.

use bdtree_build::basis::given::given_basis;
use bdtree_build::input::read_mesh;
use bdtree_tests::fixtures::{self, fields};

#[test]
fn smooth_and_local_fields_are_read_as_made() {
    let mesh = fixtures::mesh("torus").expect("a fixture made from a mesh");
    let largest = 0.05 * mesh.diagonal();
    let folder = tempfile::tempdir().expect("a folder for the test");
    let path = folder.path().join("U.npy");
    for (is_local, made) in [
        (false, fields::smooth_fields(&mesh, 6, 1)),
        (true, fields::local_fields(&mesh, 6, 1)),
    ] {
        std::fs::write(&path, fields::npy_n3m(&made)).expect("a file in the test's folder");
        let given = given_basis(&path, None, None, mesh.positions.len()).expect("a sound basis");
        assert!(given.warnings.is_empty(), "{:?}", given.warnings);
        for (j, field) in made.iter().enumerate() {
            assert_eq!(given.basis.field(j), field);
            let length = |u: &[f64; 3]| (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]).sqrt();
            let most = field.iter().map(length).fold(0.0, f64::max);
            // A few roundings of numbers near 0.05 diagonals.
            assert!((most - largest).abs() < 1e-12 * largest, "{most} {largest}");
            let at_rest = field.iter().filter(|u| **u == [0.0; 3]).count();
            assert_eq!(
                2 * at_rest > field.len(),
                is_local,
                "field {j}: {at_rest} at rest"
            );
        }
    }
}

/// SHA-256 of the large fixtures: the same on every platform, or the generator is at fault.
#[test]
fn large_fixtures_have_their_bytes() {
    let expected = [
        (
            "chair",
            "f0168f88fdeef1a794abbed4e79ef1b9db611ca720ce0e4c74568dc5ab3816b0",
        ),
        (
            "fish",
            "1b608e84dce8db5b97184049a4d83bd8af805f727e30ef50b89db5b7a7c3dd1f",
        ),
        (
            "bridge",
            "81913a578f4ca9d36c0e4dbb66103ac6707ea9da4ca8af63d1393397d39f3b3d",
        ),
        (
            "curtain",
            "c3163091379f4b121fa0c509920820c3c9489a2f39e244407567d966e7235a5f",
        ),
        (
            "face",
            "fbbd4a4d41b9719ca45c011f265cbb4ff3fd3293a9aa58395ab49052a4c9c755",
        ),
    ];
    let folder = tempfile::tempdir().expect("a folder for the test");
    for (name, hash) in expected {
        let path = folder.path().join(format!("{name}.obj"));
        fixtures::write(&path, &fixtures::content(name)).expect("a file in the test's folder");
        let mesh = read_mesh(&path).expect("a valid fixture");
        let found: String = mesh.hash.iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(found, hash, "{name}");
        assert!(mesh.warnings.is_empty(), "{:?}", mesh.warnings);
    }
}
