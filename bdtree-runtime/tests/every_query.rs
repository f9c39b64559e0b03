//! Every query on one small mesh: what `scripts/test.sh --quick` asks. The pages of each query ask more.

use bdtree_fixtures::bake;
use bdtree_fixtures::hard::{HardCase, check_case, placements};

/// Balls, planes, capsules, boxes, frustums, nearest points, rays of each kind, pairs and distances: from the root,
/// with caches and fronts, within a number of visits and down to a level; at rest, within the range and at the limits,
/// in all places, with every kernel.
#[test]
fn every_query_equals_brute_force_on_a_small_mesh() {
    let mesh = bake::bumpy_sphere(6, 8);
    let basis = bake::smooth_basis(&mesh, 3, 1);
    let case = HardCase {
        name: "small sphere",
        mesh,
        basis,
        qs: Vec::new(),
        is_star: false,
    };
    assert!(check_case(&case, 2) >= 5 * placements().len());
}
