//! Skinning on a GPU: every vertex of every instance within the bound that the instance states, in
//! compute passes and in a vertex shader.

use bdtree_build::input::read_mesh;
use bdtree_fixtures::{bake, models, poses};
use bdtree_gpu::{Normals, twin};
use bdtree_runtime::{Asset, Model, Transform, VertexId};

use crate::devices::{self, Gpu};

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// The largest share of the bound that a position takes, against the leaf arithmetic.
fn used(
    asset: &Asset<'_>,
    (q, place): &(Vec<f32>, Transform),
    origin: [f64; 3],
    positions: &[[f32; 3]],
    bound: f64,
) -> f64 {
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = asset.pose(q, *place, &mut memory).expect("pose");
    let mut worst = 0.0_f64;
    for (i, y) in (0..).zip(positions) {
        let x = pose.deformed(VertexId(i)).expect("a vertex");
        let off = length([0, 1, 2].map(|k| x[k] - origin[k] - f64::from(y[k])));
        assert!(off.is_finite());
        worst = worst.max(off / bound);
    }
    worst
}

#[test]
fn positions_are_within_their_bound() {
    check(devices::assets());
}

/// Every mesh of fixtures/, whatever is wrong with its triangles.
#[test]
fn positions_of_all_fixtures_are_within_their_bound() {
    let mut all = Vec::new();
    for fixture in models::meshes().filter(|f| !f.is_large && !f.is_broken) {
        let mesh = read_mesh(&models::path(fixture.name)).expect("a mesh");
        let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 5, 3));
        all.push((fixture.name.to_string(), model));
    }
    assert!(all.len() > 20, "{}", all.len());
    check(all);
}

fn check(assets: Vec<(String, Model)>) {
    let gpu = Gpu::new();
    let mut twins_equal = true;
    for (seed, (name, model)) in (0..).zip(assets) {
        let asset = model.asset();
        let placed = devices::placed(asset, seed);
        let n = asset.vertex_count();
        let origin = asset.origin();
        // All together eight by eight, and one by one.
        let together = gpu.skin(asset, Normals::None, &placed, origin);
        let together = together.expect("skinning");
        for (k, placed) in placed.iter().enumerate() {
            let bound = together.errors[k];
            let ours = &together.positions[k * n..][..n];
            let worst = used(asset, placed, origin, ours, bound);
            assert!(worst <= 1.0, "{name}, instance {k}: {worst} of the bound");
            let twin = twin::positions(asset, &together.instances, k as u32).expect("twin");
            for (a, b) in twin.iter().zip(ours) {
                let off = length([0, 1, 2].map(|k| f64::from(a[k]) - f64::from(b[k])));
                assert!(off <= 2.0 * bound, "{name}, instance {k}: {a:?} {b:?}");
                twins_equal &= a == b;
            }
        }
        let single = gpu.skin(asset, Normals::None, &placed[3..4], origin);
        let single = single.expect("skinning");
        let worst = used(
            asset,
            &placed[3],
            origin,
            &single.positions,
            single.errors[0],
        );
        assert!(worst <= 1.0, "{name} alone: {worst} of the bound");
    }
    println!(
        "{}: the processor has the same bits: {twins_equal}",
        gpu.driver
    );
    // As docs/reference/gpu-deformation.md says; other drivers may round and fuse otherwise.
    assert!(twins_equal || !gpu.driver.contains("Mesa 22.3"));
}

/// The bound is not so wide that anything passes: a vertex off by a few units in the last place of the
/// mesh's extent is outside.
#[test]
fn the_bound_is_narrow() {
    let gpu = Gpu::new();
    let mesh = bake::bumpy_sphere(10, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 10, 1));
    let asset = model.asset();
    let q = poses::random_q(asset, 0.3, &mut poses::rng(1));
    let place = Transform {
        rotation: [0.5, -0.5, 0.5, 0.5],
        translation: [0.1, 0.2, 0.3],
        scale: 1.1,
    };
    let placed = [(q, place)];
    let skinned = gpu.skin(asset, Normals::None, &placed, [0.0; 3]);
    let skinned = skinned.expect("skinning");
    assert!(skinned.errors[0] < 2e-5, "{}", skinned.errors[0]);
    let worst = used(
        asset,
        &placed[0],
        [0.0; 3],
        &skinned.positions,
        skinned.errors[0],
    );
    assert!(worst > 1e-3, "{worst}: nothing was compared");
}

/// Far from the world's origin f32 numbers hold what is near the camera.
#[test]
fn coordinates_are_relative_to_the_camera() {
    let gpu = Gpu::new();
    let mesh = bake::bumpy_sphere(8, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 4, 1));
    let asset = model.asset();
    let q = poses::random_q(asset, 0.3, &mut poses::rng(1));
    let place = Transform {
        translation: [1e8, -2e8, 3e8],
        ..Transform::IDENTITY
    };
    let placed = [(q, place)];
    for (origin, bound) in [([1e8 + 1.0, -2e8, 3e8], 1e-4), ([0.0; 3], 1e4)] {
        let skinned = gpu.skin(asset, Normals::None, &placed, origin);
        let skinned = skinned.expect("skinning");
        assert!(skinned.errors[0] < bound, "{}", skinned.errors[0]);
        let worst = used(
            asset,
            &placed[0],
            origin,
            &skinned.positions,
            skinned.errors[0],
        );
        assert!(worst <= 1.0, "{worst}");
    }
}

/// Slots of all triangles below a node, lane by lane.
fn slots_below(asset: &Asset<'_>, node: usize, lane: usize) -> Vec<usize> {
    let record = &asset.nodes()[node];
    let before = |mask: u8| (mask & ((1_u16 << lane) - 1) as u8).count_ones() as usize;
    if record.leaf_mask >> lane & 1 == 1 {
        let counts = &record.leaf_counts;
        let start: usize = counts[..lane].iter().map(|c| usize::from(*c)).sum();
        let start = record.first_slot as usize + start;
        (start..start + usize::from(counts[lane])).collect()
    } else if record.inner_mask >> lane & 1 == 1 {
        let child = record.first_child as usize + before(record.inner_mask);
        (0..8).flat_map(|k| slots_below(asset, child, k)).collect()
    } else {
        Vec::new()
    }
}

#[test]
fn vertices_lie_in_every_sphere_enlarged_by_the_bound() {
    let gpu = Gpu::new();
    let mut tried = 0;
    for (seed, (name, model)) in (0..).zip(devices::assets()) {
        let asset = model.asset();
        // Spheres are in stored units, and the world here in mesh units about the origin.
        let place = Transform::IDENTITY;
        let placed: Vec<_> = devices::placed(asset, seed)
            .into_iter()
            .map(|(q, _)| (q, place))
            .collect();
        let skinned = gpu.skin(asset, Normals::None, &placed, asset.origin());
        let skinned = skinned.expect("skinning");
        let lanes: Vec<Vec<Vec<usize>>> = (0..asset.node_count())
            .map(|i| (0..8).map(|lane| slots_below(asset, i, lane)).collect())
            .collect();
        for (k, (q, place)) in placed.iter().enumerate() {
            let positions = &skinned.positions[k * asset.vertex_count()..];
            let mut memory = vec![0.0; asset.pose_len()];
            let pose = asset.pose(q, *place, &mut memory).expect("pose");
            for (i, lanes) in lanes.iter().enumerate() {
                let spheres = pose.node_spheres(i as u32).expect("spheres");
                for (lane, slots) in lanes.iter().enumerate() {
                    let center =
                        [0, 1, 2].map(|k| asset.unit() * f64::from(spheres.center[k][lane]));
                    let radius = asset.unit() * f64::from(spheres.radius[lane]);
                    for v in slots.iter().flat_map(|s| asset.triangles()[*s].corners) {
                        let x = positions[v as usize];
                        let off = length([0, 1, 2].map(|k| f64::from(x[k]) - center[k]));
                        let reach = radius + skinned.errors[k];
                        assert!(off <= reach * (1.0 + 1e-12), "{name}: {off} {reach}");
                        tried += 1;
                    }
                }
            }
        }
    }
    assert!(tried > 100_000, "{tried}");
}
