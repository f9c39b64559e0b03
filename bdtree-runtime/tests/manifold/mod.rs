//! Contact regions of known bodies: normal, depth, area and shared volume.

mod falling;
mod random_poses;

use bdtree_build::input::RawMesh;
use bdtree_fixtures::{bake, poses};
use bdtree_runtime::{
    ContactManifold, ContactPoint, Coverage, Model, PairContact, Pose, QueryError, SliceSink,
    Transform, TriangleId, Workspace,
};
use rand::seq::SliceRandom;

fn mesh(positions: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> RawMesh {
    RawMesh {
        name: "body".into(),
        positions,
        triangles,
        ..RawMesh::default()
    }
}

fn rigid(mesh: &RawMesh) -> Model {
    bake::baked(mesh, &bake::rigid(mesh))
}

/// The unit cube's faces at these corners, outwards; bit 0 of a corner is x, then y, then z.
fn boxes(boxes: &[([f64; 3], [f64; 3])]) -> RawMesh {
    const FACES: [[u32; 4]; 6] = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for (low, high) in boxes {
        let start = positions.len() as u32;
        for corner in 0..8 {
            positions.push([0, 1, 2].map(|k| {
                if corner >> k & 1 == 0 {
                    low[k]
                } else {
                    high[k]
                }
            }));
        }
        for [a, b, c, d] in FACES {
            triangles.push([a, b, c].map(|v| start + v));
            triangles.push([a, c, d].map(|v| start + v));
        }
    }
    mesh(positions, triangles)
}

/// A sheet in z = 0, seen from above, from −2 to 2, of 2 n² triangles.
fn sheet(n: u32) -> RawMesh {
    let at = |i: u32, j: u32| i * (n + 1) + j;
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..=n {
        for j in 0..=n {
            let [x, y] = [i, j].map(|k| 4.0 * f64::from(k) / f64::from(n) - 2.0);
            positions.push([x, y, 0.0]);
        }
    }
    for i in 0..n {
        for j in 0..n {
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    mesh(positions, triangles)
}

/// A surface of revolution around z through (radius, z), bottom first, the ends on the axis.
fn turned(profile: &[(f64, f64)], columns: u32) -> RawMesh {
    let rows = profile.len() as u32;
    let mut positions = vec![[0.0, 0.0, profile[0].1]];
    for (r, z) in &profile[1..profile.len() - 1] {
        for j in 0..columns {
            let phi = std::f64::consts::TAU * f64::from(j) / f64::from(columns);
            positions.push([r * phi.cos(), r * phi.sin(), *z]);
        }
    }
    let top = positions.len() as u32;
    positions.push([0.0, 0.0, profile[profile.len() - 1].1]);
    let at = |i: u32, j: u32| 1 + (i - 1) * columns + j % columns;
    let mut triangles = Vec::new();
    for j in 0..columns {
        triangles.push([0, at(1, j + 1), at(1, j)]);
        for i in 1..rows - 2 {
            triangles.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
        }
        triangles.push([at(rows - 2, j), at(rows - 2, j + 1), top]);
    }
    mesh(positions, triangles)
}

fn sphere(n: u32) -> RawMesh {
    let profile: Vec<(f64, f64)> = (0..=n)
        .map(|i| {
            let theta = std::f64::consts::PI * f64::from(i) / f64::from(n);
            (theta.sin(), -theta.cos())
        })
        .collect();
    turned(&profile, 2 * n)
}

fn place(translation: [f64; 3]) -> Transform {
    Transform {
        translation,
        ..Transform::IDENTITY
    }
}

/// The pairs of two posed assets and their regions, which are those of the pairs.
fn contact(a: &Pose<'_>, b: &Pose<'_>, tolerance: f64) -> (Vec<PairContact>, Vec<ContactManifold>) {
    let mut workspace = Workspace::new();
    let mut query = a.against(b, &mut workspace);
    let (mut pairs, mut whole) = (Vec::new(), Vec::new());
    query.contacts(tolerance, &mut pairs).expect("pair");
    let coverage = query.contact_manifolds(tolerance, &mut whole);
    assert_eq!(coverage, Ok(Coverage::Complete));
    let regions = regions(a, b, &mut pairs);
    assert_eq!(regions, whole);
    (pairs, regions)
}

fn regions(a: &Pose<'_>, b: &Pose<'_>, pairs: &mut [PairContact]) -> Vec<ContactManifold> {
    let mut workspace = Workspace::new();
    let mut regions = Vec::new();
    let coverage = a.against(b, &mut workspace).condense(pairs, &mut regions);
    assert_eq!(coverage, Ok(Coverage::Complete));
    for region in &regions {
        let length = region.normal1.iter().map(|c| c * c).sum::<f64>();
        assert_eq!(region.normal2, region.normal1.map(|c| -c));
        assert!((length - 1.0).abs() < 1e-12 && region.depth >= 0.0 && region.area >= 0.0);
        let area: f64 = region.points().iter().map(|p| p.area).sum();
        assert!(
            (area - region.area).abs() <= 1e-12 * area,
            "shares make the whole"
        );
        for (k, point) in region.points().iter().enumerate() {
            is_at(a, point.triangle1, point.barycentric1, point.point1);
            is_at(b, point.triangle2, point.barycentric2, point.point2);
            near(apart(region, point)[0], point.distance, 1e-12);
            assert!(-point.distance <= region.depth, "deeper than its region");
            for other in &region.points()[..k] {
                assert!(
                    [point.point1, point.point2] != [other.point1, other.point2],
                    "two points are one"
                );
            }
        }
    }
    regions
}

/// How far a contact's points are apart along the normal and across it.
fn apart(region: &ContactManifold, point: &ContactPoint) -> [f64; 2] {
    let way = [0, 1, 2].map(|k| point.point2[k] - point.point1[k]);
    let along: f64 = (0..3).map(|k| way[k] * region.normal1[k]).sum();
    let across: f64 = (0..3)
        .map(|k| (way[k] - along * region.normal1[k]).powi(2))
        .sum();
    [along, across.sqrt()]
}

/// A triangle and weights give the point: forces on q go where it is.
fn is_at(pose: &Pose<'_>, triangle: TriangleId, weights: [f64; 3], point: [f64; 3]) {
    assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    let corners = pose.deformed_triangle(triangle).expect("a triangle");
    for axis in 0..3 {
        let x: f64 = (0..3).map(|k| weights[k] * corners[k][axis]).sum();
        let far = (x - point[axis]).abs();
        assert!(
            far < 1e-9,
            "{triangle:?} {weights:?}: {far:e} from {point:?}"
        );
    }
}

fn between(
    a: &RawMesh,
    ta: Transform,
    b: &RawMesh,
    tb: Transform,
    tolerance: f64,
) -> Vec<ContactManifold> {
    let (a, b) = (rigid(a), rigid(b));
    let a = a.asset().pose(&[], ta, &mut []).expect("pose");
    let b = b.asset().pose(&[], tb, &mut []).expect("pose");
    contact(&a, &b, tolerance).1
}

/// Depth times area over the points.
fn volume(region: &ContactManifold) -> f64 {
    region.points().iter().map(|p| -p.distance * p.area).sum()
}

#[track_caller]
fn near(found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance,
        "{found}, expected {expected}"
    );
}

/// How far the spheres' normal, depth, area and shared volume are off, relatively.
fn spheres(n: u32, direction: [f64; 3], d: f64) -> [f64; 4] {
    let center = direction.map(|c| c * (2.0 - d));
    let found = between(
        &sphere(n),
        Transform::IDENTITY,
        &sphere(n),
        place(center),
        0.0,
    );
    assert_eq!(found.len(), 1);
    let [region] = found[..] else { unreachable!() };
    let along: f64 = (0..3).map(|k| region.normal1[k] * direction[k]).sum();
    let area = std::f64::consts::PI * (d - d * d / 4.0);
    let shared = std::f64::consts::PI * (6.0 - d) * d * d / 12.0;
    [
        1.0 - along,
        (region.depth / d - 1.0).abs(),
        (region.area / area - 1.0).abs(),
        (volume(&region) / shared - 1.0).abs(),
    ]
}

#[test]
fn overlapping_spheres() {
    let direction = [2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0];
    // Facets lie inside their sphere by about h²/8, h = π/n: against a depth of d on both sides.
    let d = 0.2;
    let [turn, depth, area, shared] = spheres(48, direction, d);
    let facet = (std::f64::consts::PI / 48.0).powi(2) / 8.0 / d;
    assert!(turn < 1e-4, "{turn}");
    assert!(depth < 3.0 * facet, "{depth} {facet}");
    assert!(area < 4.0 * facet, "{area} {facet}");
    // The lens is not quite a paraboloid: d²/24 of it and less.
    assert!(shared < 8.0 * facet + 0.01, "{shared} {facet}");
    // Four times fewer facets per length: errors of a second order fall by about 16.
    let coarse = spheres(12, direction, d);
    assert!(coarse[2] > 5.0 * area, "{} {area}", coarse[2]);
    assert!(coarse[1] > 3.0 * depth, "{} {depth}", coarse[1]);
}

#[test]
fn a_box_in_a_plane() {
    let d = 0.0625;
    let body = boxes(&[([-0.5, -0.25, -d], [0.5, 0.25, 1.0])]);
    for n in [1, 7, 16] {
        let found = between(
            &body,
            Transform::IDENTITY,
            &sheet(n),
            Transform::IDENTITY,
            0.0,
        );
        let [region] = found[..] else {
            panic!("{} regions", found.len())
        };
        for k in 0..3 {
            near(region.normal1[k], [0.0, 0.0, -1.0][k], 1e-12);
        }
        near(region.depth, d, 1e-12);
        near(region.area, 0.5, 1e-12);
        assert_eq!(region.points().len(), 4);
        for point in region.points() {
            near(point.distance, -d, 1e-12);
            near(point.point1[0].abs(), 0.5 / 3_f64.sqrt(), 1e-9);
            near(point.point1[1].abs(), 0.25 / 3_f64.sqrt(), 1e-9);
            near(point.point1[2], -d, 1e-12);
            near(point.point2[2], 0.0, 1e-12);
        }
        // The other way round: the same points, the opposite normal.
        let swapped = between(
            &sheet(n),
            Transform::IDENTITY,
            &body,
            Transform::IDENTITY,
            0.0,
        );
        near(swapped[0].normal1[2], 1.0, 1e-12);
        near(volume(&swapped[0]), 0.5 * d, 1e-12);
    }
}

#[test]
fn a_cylinder_in_a_plane() {
    let (radius, d): (f64, f64) = (0.5, 0.05);
    let body = turned(
        &[(0.0, -1.0), (radius, -1.0), (radius, 1.0), (0.0, 1.0)],
        96,
    );
    let mut lying = place([0.1, 0.05, radius - d]);
    lying.rotation = [0.5_f64.sqrt(), 0.0, 0.0, 0.5_f64.sqrt()];
    let found = between(&body, lying, &sheet(9), Transform::IDENTITY, 0.0);
    let [region] = found[..] else {
        panic!("{} regions", found.len())
    };
    let half = (radius * radius - (radius - d) * (radius - d)).sqrt();
    let segment = radius * radius * (half / radius).asin() - half * (radius - d);
    // 96 sides: sagitta r (1 − cos π/96) = 2.7e-4.
    near(region.depth, d, 5e-4);
    near(region.normal1[2], -1.0, 1e-9);
    near(region.area / (4.0 * half), 1.0, 0.02);
    near(volume(&region) / (2.0 * segment), 1.0, 0.03);
}

#[test]
fn faces_that_only_touch_have_depth_0() {
    let low = boxes(&[([-1.0, -1.0, -1.0], [1.0, 1.0, 0.0])]);
    let high = boxes(&[([-0.5, -0.25, 0.0], [0.5, 0.75, 1.0])]);
    for region in between(&high, Transform::IDENTITY, &low, Transform::IDENTITY, 0.0) {
        assert_eq!(region.depth, 0.0);
        assert_eq!(region.normal1, [0.0, 0.0, -1.0]);
        assert!(region.area > 0.0);
    }
    // Lifted, within a tolerance: the gap.
    let found = between(
        &high,
        place([0.0, 0.0, 0.125]),
        &low,
        Transform::IDENTITY,
        0.25,
    );
    assert!(!found.is_empty());
    for region in &found {
        assert_eq!((region.depth, region.points()[0].distance), (0.0, 0.125));
        near(region.normal1[2], -1.0, 1e-12);
    }
}

/// A box that rests on a larger one, their faces in one plane or a rounding apart: points are where their triangles
/// and weights say ([`is_at`]), although rays along the normal begin inside neither.
#[test]
fn a_box_that_rests_on_another() {
    let below = boxes(&[([-1.0, -1.0, -1.0], [1.0, 1.0, 0.0])]);
    for (side, sink) in [
        (0.3, 0.0),
        (0.3, 1e-16),
        (0.3, 1e-9),
        (1.0, 0.0),
        (1.0, 1e-3),
    ] {
        for shift in [0.0, 0.1, 1.0 / 3.0] {
            let above = boxes(&[([-side, -side, 0.0], [side, side, 0.5])]);
            let at = place([shift, 0.5 * shift, -sink]);
            let found = between(&above, at, &below, Transform::IDENTITY, 0.0);
            assert!(!found.is_empty());
            for region in &found {
                assert!(region.depth <= sink + 1e-6, "{}", region.depth);
            }
        }
    }
}

#[test]
fn crossing_edges() {
    let cube = boxes(&[([-0.5; 3], [0.5; 3])]);
    let (d, half) = (0.125, 0.5_f64.sqrt());
    let (sin, cos) = (
        (std::f64::consts::PI / 8.0).sin(),
        (std::f64::consts::PI / 8.0).cos(),
    );
    let mut below = place([0.0, 0.0, 0.5 * d - half]);
    below.rotation = [0.0, sin, 0.0, cos];
    let mut above = place([0.0, 0.0, half - 0.5 * d]);
    above.rotation = [sin, 0.0, 0.0, cos];
    let found = between(&cube, below, &cube, above, 0.0);
    let [region] = found[..] else {
        panic!("{} regions", found.len())
    };
    near(region.normal1[2], 1.0, 1e-9);
    near(region.depth, d, 1e-9);
    near(region.area, 2.0 * d * d, 1e-9);
    assert!(
        region
            .points()
            .iter()
            .all(|p| p.distance < 0.0 && p.distance > -d)
    );
}

#[test]
fn triangles_of_open_surfaces_cross() {
    let one = mesh(
        vec![[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        vec![[0, 1, 2]],
    );
    let other = mesh(
        vec![[0.0, -1.0, 0.75], [0.0, 1.0, 0.75], [0.0, 0.0, 2.0]],
        vec![[0, 1, 2]],
    );
    let found = between(&one, Transform::IDENTITY, &other, Transform::IDENTITY, 0.0);
    let [region] = found[..] else {
        panic!("{} regions", found.len())
    };
    assert_eq!(region.points().len(), 1);
    // Tip into edge: at most 0.25 along z.
    assert!(
        region.depth > 0.0 && region.depth <= 0.25,
        "{}",
        region.depth
    );
}

#[test]
fn feet_on_one_triangle_stay_apart() {
    let foot = |x: f64, y: f64| ([x, y, -0.01], [x + 0.1, y + 0.1, 0.5]);
    let chair = boxes(&[
        foot(0.1, -0.6),
        foot(1.5, -0.7),
        foot(0.5, -1.5),
        foot(1.3, -1.6),
    ]);
    let found = between(
        &chair,
        Transform::IDENTITY,
        &sheet(1),
        Transform::IDENTITY,
        0.0,
    );
    assert_eq!(found.len(), 4);
    // Corners are stored in f32.
    for region in found {
        near(region.area, 0.01, 1e-7);
        near(region.depth, 0.01, 1e-7);
    }
}

#[test]
fn the_order_of_pairs_does_not_matter() {
    let mesh = bake::bumpy_sphere(16, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 5, 5));
    let asset = *model.asset();
    let mut rng = poses::rng(3);
    let q = poses::random_q(&asset, 0.2, &mut rng);
    let (mut memory1, mut memory2) = (vec![0.0; asset.pose_len()], vec![0.0; asset.pose_len()]);
    let pose1 = asset
        .pose(&q, Transform::IDENTITY, &mut memory1)
        .expect("pose");
    let pose2 = asset
        .pose(&[0.0; 5], place([1.0, 0.9, 0.4]), &mut memory2)
        .expect("pose");
    let (mut pairs, expected) = contact(&pose1, &pose2, 0.01);
    assert!(!expected.is_empty());
    for _ in 0..3 {
        pairs.shuffle(&mut rng);
        assert_eq!(regions(&pose1, &pose2, &mut pairs), expected);
    }
    // A pair that is there twice counts once.
    let mut twice = [pairs.clone(), pairs.clone()].concat();
    assert_eq!(regions(&pose1, &pose2, &mut twice), expected);
    // Pairs of other meshes, on either side.
    for side in 0..2 {
        let mut others = pairs.clone();
        let beyond = TriangleId(asset.triangle_count() as u32);
        match side {
            0 => others[1].triangle1 = beyond,
            _ => others[1].triangle2 = beyond,
        }
        let mut none: Vec<ContactManifold> = Vec::new();
        let mut workspace = Workspace::new();
        let refused = pose1
            .against(&pose2, &mut workspace)
            .condense(&mut others, &mut none);
        let why = "pairs: a triangle id that the mesh does not have";
        assert_eq!(refused, Err(QueryError::Argument(why)));
    }
    // What is wrong is said; a full sink holds the first ones.
    let mut room = [expected[0]; 0];
    let mut sink = SliceSink::new(&mut room);
    let mut workspace = Workspace::new();
    let mut query = pose1.against(&pose2, &mut workspace);
    let full = query.condense(&mut pairs, &mut sink);
    assert_eq!(full, Ok(Coverage::Truncated));
    assert_eq!(query.contact_manifolds(0.01, &mut sink), full);
    let mut bytes = [0; 1000];
    let mut small = Workspace::in_bytes(&mut bytes);
    let mut query = pose1.against(&pose2, &mut small);
    let short = query.condense(&mut pairs, &mut sink);
    assert!(matches!(short, Err(QueryError::Memory { .. })));
    let short = query.contact_manifolds(0.01, &mut sink);
    assert!(matches!(short, Err(QueryError::Memory { .. })));
    // Of no pairs there are no regions.
    let mut query = pose1.against(&pose2, &mut workspace);
    assert_eq!(query.condense(&mut [], &mut sink), Ok(Coverage::Complete));
}
