//! The conservative box of a posed mesh: it holds every deformed vertex, and no more than the bounding sphere.

use bdtree_fixtures::compare::kernels;
use bdtree_fixtures::{bake, golden, poses};
use bdtree_runtime::{Aabb, Asset, Model, Ray, Transform, VertexId};
use rand::RngExt;

/// Compares coordinates as they are, without a tolerance; how much wider the box is than the vertices' own, and
/// than the sphere's, along the axes.
fn check(asset: &Asset<'_>, q: &[f32], place: Transform) -> [f64; 2] {
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = asset.pose(q, place, &mut memory).expect("a pose");
    let aabb = pose.aabb().expect("a box");
    let sphere = pose.bounding_sphere().expect("a sphere");
    let exact = pose.exact_aabb().expect("a box");
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for vertex in (0..asset.vertex_count() as u32).map(VertexId) {
        let x = pose.deformed(vertex).expect("a vertex");
        for k in 0..3 {
            assert!(
                aabb.min[k] <= x[k] && x[k] <= aabb.max[k],
                "{vertex:?} at {x:?}: {aabb:?}, q {q:?}, {place:?}"
            );
            (low[k], high[k]) = (low[k].min(x[k]), high[k].max(x[k]));
        }
    }
    // The files of these tests have no vertices beside those of triangles.
    assert_eq!((exact.min, exact.max), (low, high));
    let mut wider = [0.0_f64; 2];
    for k in 0..3 {
        // Both are rounded up, far away by more.
        let far = 1e-9 * sphere.radius + 16.0 * f64::EPSILON * sphere.center[k].abs();
        assert!(
            aabb.min[k] >= sphere.center[k] - sphere.radius - far,
            "{aabb:?} {sphere:?}"
        );
        assert!(
            aabb.max[k] <= sphere.center[k] + sphere.radius + far,
            "{aabb:?} {sphere:?}"
        );
        let width = aabb.max[k] - aabb.min[k];
        wider[0] = wider[0].max(width / (high[k] - low[k]));
        wider[1] = wider[1].max(width / (2.0 * sphere.radius));
    }
    wider
}

#[test]
fn every_vertex_lies_in_the_box() {
    let mut rng = poses::rng(12);
    for name in ["sphere", "sparse", "animated", "tetrahedron"] {
        let path = golden::folder().join(format!("{name}.bdt"));
        let model = Model::read(path).expect("a golden file");
        for asset in kernels(model.asset()) {
            let mut qs = poses::hard_qs(&asset);
            qs.extend((0..60).map(|k| poses::random_q(&asset, 10_f64.powi(k % 4 - 3), &mut rng)));
            for (k, q) in qs.iter().enumerate() {
                let spread = [0.0, 1.0, 1e3, 1e7, 1e15][k % 5];
                let place = poses::random_transform(spread, &mut rng);
                let scale = 2_f64.powi([0, 40, -40][k % 3]);
                check(&asset, q, place.with_scale(scale * place.scale));
            }
        }
    }
}

#[test]
fn the_box_follows_the_pose() {
    let mesh = bake::bumpy_sphere(20, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 6, 5));
    let mut rng = poses::rng(13);
    for _ in 0..40 {
        let q = poses::random_q(model.asset(), 0.1, &mut rng);
        let place = poses::random_transform(3.0, &mut rng);
        let [wider, share] = check(model.asset(), &q, place);
        assert!(wider < 1.8 && share < 1.0 + 1e-12, "{wider} {share}");
    }
}

/// Against points along the ray: one in the box proves that the ray meets it, and a box that is missed by a thousandth of
/// its size is told to be.
#[test]
fn rays_that_may_meet_the_box_are_told() {
    let mut rng = poses::rng(14);
    let mut missed = 0;
    for round in 0..4000 {
        let scale = 10_f64.powi(round % 25 - 12);
        let far = [0.0, 1.0, 1e6][round as usize % 3] * scale;
        let mut point = |most: f64| [0; 3].map(|_| most * rng.random_range(-1.0..1.0));
        let middle = point(far);
        let (a, b) = (point(scale), point(scale));
        // Flat boxes, too.
        let flat = round % 4;
        let corner = |k: usize, x: f64| middle[k] + if k == flat as usize { 0.0 } else { x };
        let aabb = Aabb {
            min: [0, 1, 2].map(|k| corner(k, a[k].min(b[k]))),
            max: [0, 1, 2].map(|k| corner(k, a[k].max(b[k]))),
        };
        // Through a point of the box, on its boundary for every other ray.
        let inside = [0, 1, 2].map(|k| match round % 2 {
            0 => aabb.min[k],
            _ => 0.5 * aabb.min[k] + 0.5 * aabb.max[k],
        });
        let mut along = point(3.0);
        along[round as usize % 7 % 3] *= [1.0, 0.0, 1e-18][round as usize % 11 % 3];
        let origin = [0, 1, 2].map(|k| inside[k] - scale * along[k]);
        let ray = Ray::new(origin, along);
        assert!(aabb.intersects_ray(&ray), "{aabb:?} {ray:?}");
        // Backwards it starts beyond; a short one ends before. Both miss unless they start in the box.
        let size = (0..3).map(|k| aabb.max[k] - aabb.min[k]).sum::<f64>();
        let clear = (0..3).any(|k| {
            let gap = (aabb.min[k] - origin[k]).max(origin[k] - aabb.max[k]);
            gap > 1e-3 * size + 1e-6 * far
        });
        if clear {
            let back = Ray::new(origin, along.map(|c| -c));
            let short = ray.with_max_distance(1e-9 * size);
            assert!(!aabb.intersects_ray(&back), "{aabb:?} {back:?}");
            assert!(!aabb.intersects_ray(&short), "{aabb:?} {short:?}");
            missed += 1;
        }
    }
    assert!(missed > 1000, "{missed}");
    let unit = Aabb {
        min: [0.0; 3],
        max: [1.0; 3],
    };
    // Along a face, and beside it.
    assert!(unit.intersects_ray(&Ray::new([1.0, -1.0, 0.5], [0.0, 1.0, 0.0])));
    assert!(!unit.intersects_ray(&Ray::new([1.0 + 1e-9, -1.0, 0.5], [0.0, 1.0, 0.0])));
    // What is no ray is for queries to refuse.
    assert!(unit.intersects_ray(&Ray::new([5.0; 3], [0.0; 3])));
    assert!(unit.intersects_ray(&Ray::new([f64::NAN; 3], [1.0; 3])));
}
