//! Skins on a GPU: vertices within the bound of their instance, normals against the deformed triangles, in compute passes
//! and in a vertex shader.

use bdtree_fixtures::poses;
use bdtree_gpu::{GpuError, NormalFields, Normals, Skinner, twin};
use bdtree_runtime::{Asset, BoneMatrices, PoseError, Transform, VertexId};

use crate::devices::{Gpu, Skinned};
use crate::normals::{U, angle, cross, exact, exact_bound, norm, wide};
use crate::skins::{Posed, assets, posed};
use crate::vertex_shader::drawn_as_twin;

/// Deforms all poses on the device.
fn skin(gpu: &Gpu, asset: &Asset<'_>, normals: Normals, posed: &[Posed], o: [f64; 3]) -> Skinned {
    let skinned = gpu.skin_each(asset, normals, posed.len(), o, |instances, k| {
        let Posed {
            q, matrices, place, ..
        } = &posed[k];
        instances.push_with_bones(asset, q, BoneMatrices::Skinning(matrices), *place)
    });
    skinned.expect("skinning")
}

/// The largest share of the bound that a position takes, against the leaf arithmetic.
fn used(asset: &Asset<'_>, posed: &Posed, o: [f64; 3], positions: &[[f32; 3]], bound: f64) -> f64 {
    let mut memory = vec![0.0; asset.pose_len()];
    let bones = BoneMatrices::Skinning(&posed.matrices);
    let pose = asset.pose_with_bones(&posed.q, bones, posed.place, &mut memory);
    let pose = pose.expect("pose");
    let mut worst = 0.0_f64;
    for (i, y) in (0..).zip(positions) {
        let x = pose.deformed(VertexId(i)).expect("a vertex");
        let off = norm([0, 1, 2].map(|k| x[k] - o[k] - f64::from(y[k])));
        assert!(off.is_finite());
        worst = worst.max(off / bound);
    }
    worst
}

#[test]
fn positions_with_bones_are_within_their_bound() {
    let gpu = Gpu::new();
    let (mut twins_equal, mut largest) = (true, [0.0_f64; 9]);
    for (seed, (name, model)) in (0..).zip(assets()) {
        let asset = model.asset();
        let posed = posed(asset, seed);
        let n = asset.vertex_count();
        let origin = asset.origin();
        // Eight by eight, and one by one.
        let together = skin(&gpu, asset, Normals::None, &posed, origin);
        for (k, pose) in posed.iter().enumerate() {
            let kind = pose.kind;
            let bound = together.errors[k];
            let ours = &together.positions[k * n..][..n];
            let worst = used(asset, pose, origin, ours, bound);
            assert!(worst <= 1.0, "{name}, {kind} {k}: {worst} of the bound");
            largest[k % 9] = largest[k % 9].max(worst);
            let twin = twin::positions(asset, &together.instances, k as u32).expect("twin");
            for (a, b) in twin.iter().zip(ours) {
                let off = norm([0, 1, 2].map(|k| f64::from(a[k]) - f64::from(b[k])));
                assert!(off <= 2.0 * bound, "{name}, {kind} {k}: {a:?} {b:?}");
                twins_equal &= a == b;
            }
            let single = skin(&gpu, asset, Normals::None, &posed[k..=k], origin);
            let worst = used(asset, pose, origin, &single.positions, single.errors[0]);
            assert!(worst <= 1.0, "{name}, {kind} alone: {worst} of the bound");
        }
    }
    let driver = &gpu.driver;
    println!(
        "{driver}: the processor has the same bits: {twins_equal}; of the bound: {largest:.4?}"
    );
    // Something was compared.
    assert!(
        largest[1..].iter().any(|share| *share > 1e-2),
        "{largest:?}"
    );
    assert!(twins_equal || !driver.contains("Mesa 22.3"));
}

/// The bound is a few units in the last place of what bones reach.
#[test]
fn the_bound_with_bones_is_narrow() {
    let gpu = Gpu::new();
    let all = assets();
    let asset = all[0].1.asset(); // the bar, 4 long
    let pose = &posed(asset, 1)[1];
    let skinned = skin(
        &gpu,
        asset,
        Normals::None,
        std::slice::from_ref(pose),
        [0.0; 3],
    );
    assert!(skinned.errors[0] < 4e-4, "{}", skinned.errors[0]);
}

/// An instance without matrices stands as a pose without matrices does.
#[test]
fn bones_are_at_rest_unless_told() {
    let gpu = Gpu::new();
    for (name, model) in assets() {
        let asset = model.asset();
        let q = poses::random_q(asset, 0.3, &mut poses::rng(1));
        let placed = [(q.clone(), Transform::IDENTITY)];
        let skinned = gpu.skin(asset, Normals::None, &placed, asset.origin());
        let skinned = skinned.expect("skinning");
        let mut memory = vec![0.0; asset.pose_len()];
        let pose = asset
            .pose(&q, Transform::IDENTITY, &mut memory)
            .expect("pose");
        for (i, y) in (0..).zip(&skinned.positions) {
            let x = pose.deformed(VertexId(i)).expect("a vertex");
            let off = norm([0, 1, 2].map(|k| x[k] - asset.origin()[k] - f64::from(y[k])));
            assert!(off <= skinned.errors[0], "{name}: {off}");
        }
    }
}

#[test]
fn exact_normals_with_bones_are_those_of_the_positions() {
    let gpu = Gpu::new();
    let mut compared = 0;
    for (seed, (name, model)) in (0..).zip(assets()) {
        let asset = model.asset();
        let posed = posed(asset, seed);
        let skinned = skin(&gpu, asset, Normals::Exact, &posed, asset.origin());
        let n = asset.vertex_count();
        for (k, pose) in posed.iter().enumerate() {
            let positions = &skinned.positions[k * n..][..n];
            for (i, exact) in exact(asset, positions).iter().enumerate() {
                // Beyond 2^125 there is no normal.
                let Some(bound) = exact_bound(exact).filter(|_| norm(exact.0) < 1e37) else {
                    continue;
                };
                let off = angle(wide(skinned.normals[k * n + i]), exact.0);
                assert!(off <= bound, "{name} {} {i}: {off} over {bound}", pose.kind);
                compared += 1;
            }
        }
    }
    assert!(compared > 10_000, "{compared}");
}

/// A vertex's matrix in f64, and Σ w ‖A_b‖_F.
fn blended(asset: &Asset<'_>, maps: &[[[f32; 4]; 3]], vertex: usize) -> ([[f64; 3]; 3], f64) {
    let (mut m, mut size) = ([[0.0; 3]; 3], 0.0);
    for influence in asset.influences(VertexId(vertex as u32)).expect("a vertex") {
        let weight = f64::from(influence.weight);
        let mut square = 0.0;
        for (row, own) in m.iter_mut().zip(&maps[usize::from(influence.bone)]) {
            for (sum, own) in row.iter_mut().zip(&own[..3]) {
                *sum += weight * f64::from(*own);
                square += f64::from(*own) * f64::from(*own);
            }
        }
        size += weight * square.sqrt();
    }
    (m, size)
}

/// Normals of fields on the device and their twins against f64, as far apart as rounding of the tangents allows.
#[test]
fn field_normals_follow_bones() {
    let gpu = Gpu::new();
    let mut compared = [0; 9];
    for (seed, (name, model)) in (0..).zip(assets()) {
        let asset = model.asset();
        let fields = NormalFields::new(asset).expect("fields");
        let posed = posed(asset, seed);
        let skinned = skin(&gpu, asset, Normals::Fields, &posed, asset.origin());
        let n = asset.vertex_count();
        let influences = asset.skin_record().map_or(0, |skin| skin.influences_max);
        for (k, pose) in posed.iter().enumerate() {
            let mut memory = vec![0.0; asset.pose_len()];
            let bones = BoneMatrices::Skinning(&pose.matrices);
            let posed = asset.pose_with_bones(&pose.q, bones, pose.place, &mut memory);
            let posed = posed.expect("pose");
            let maps: Vec<_> = posed.bone_maps().iter().map(|map| *map.rows()).collect();
            let world = posed.stored_to_world().linear();
            let positions = &skinned.positions[k * n..][..n];
            let instances = &skinned.instances;
            let twin = twin::normals(asset, &fields, instances, k as u32, positions);
            let twin = twin.expect("twin");
            for (i, twin) in twin.iter().enumerate() {
                if fields.marked().binary_search(&(i as u32)).is_ok() {
                    continue; // as exact ones
                }
                let (m, size) = blended(asset, &maps, i);
                let along = |m: &[[f64; 3]; 3], v: [f64; 3]| {
                    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
                };
                // M + 2 roundings of a tangent, I + 4 of what bones make of it, √3 for components, 2 u each.
                let terms = asset.mode_count() as f64 + f64::from(influences) + 6.0;
                let sides = fields.tangents(i, &pose.q).map(|(v, length)| {
                    let v = along(&m, v);
                    let own = norm(v);
                    (
                        v.map(|c| c / own),
                        2.0 * U * 1.8 * terms * size * length / own,
                    )
                });
                let [(a, off_a), (b, off_b)] = sides;
                let normal = cross(a, b);
                let lost = 2.0 * (off_a + off_b + 16.0 * U);
                let length = norm(normal);
                if !(length > 4.0 * lost) || size < 1e-30 {
                    continue;
                }
                let bound = lost / (length - lost) + 32.0 * U;
                let normal = along(&world, normal);
                for found in [twin, &skinned.normals[k * n + i]] {
                    let off = angle(wide(*found), normal);
                    assert!(off <= bound, "{name} {} {i}: {off} over {bound}", pose.kind);
                }
                compared[k % 9] += 1;
            }
        }
    }
    println!("compared: {compared:?}");
    // None where all is on a line or a point.
    for k in [0, 1, 2, 3, 7] {
        assert!(compared[k] > 1000, "{compared:?}");
    }
}

/// Where all bones do the same, triangles do, too: mirrored, sheared and in proportion the normals of fields are those of
/// the deformed triangles.
#[test]
fn normals_of_fields_are_those_of_mirrored_and_sheared_triangles() {
    let gpu = Gpu::new();
    let mut compared = 0;
    for (seed, (name, model)) in (0..).zip(assets()) {
        let asset = model.asset();
        // Weights that sum to 1.
        if asset
            .skin_record()
            .is_none_or(|skin| skin.weight_defect > 1e-5)
        {
            continue;
        }
        let fields = NormalFields::new(asset).expect("fields");
        let mut posed = posed(asset, seed);
        posed.truncate(4);
        for pose in &mut posed {
            let first = pose.matrices[0];
            pose.matrices.fill(first);
            pose.q.fill(0.0);
        }
        let skinned = skin(&gpu, asset, Normals::Fields, &posed, asset.origin());
        let n = asset.vertex_count();
        for (k, pose) in posed.iter().enumerate() {
            let positions = &skinned.positions[k * n..][..n];
            for (i, (sum, size, _)) in exact(asset, positions).iter().enumerate() {
                let is_marked = fields.marked().binary_search(&(i as u32)).is_ok();
                if is_marked || norm(*sum) < 1e-2 * size {
                    continue;
                }
                let off = angle(wide(skinned.normals[k * n + i]), *sum);
                assert!(off <= 3e-3, "{name} {} {i}: {off}", pose.kind);
                compared += 1;
            }
        }
    }
    assert!(compared > 1000, "{compared}");
}

#[test]
fn a_vertex_shader_follows_bones() {
    let gpu = Gpu::new();
    let mut compared = 0;
    for (seed, (name, model)) in (0..).zip(assets()) {
        let asset = model.asset();
        let posed = &posed(asset, seed)[..9];
        for normals in [Normals::None, Normals::Fields] {
            compared += drawn_as_twin(
                &gpu,
                (&name, asset),
                normals,
                (9, asset.origin()),
                |instances, k| {
                    let pose = &posed[k];
                    let bones = BoneMatrices::Skinning(&pose.matrices);
                    instances.push_with_bones(asset, &pose.q, bones, pose.place)
                },
                |k, v, found, expected| {
                    let kind = posed[k].kind;
                    // On a line or in a point any direction.
                    let is_any = !["rest", "turned", "mirrored", "huge"].contains(&kind);
                    if is_any || norm(wide(expected)) <= 0.5 {
                        return;
                    }
                    for axis in 0..3 {
                        let off = (found[axis] - expected[axis]).abs();
                        assert!(off <= 2e-3, "{name} {kind} {v}: {found:?} {expected:?}");
                    }
                },
            );
        }
    }
    assert!(compared > 10_000, "{compared}");
}

/// Bindings of 8 KiB: influences are split with their vertices, and results keep their bits.
#[test]
fn split_skins_give_the_same_bits() {
    let whole = Gpu::new();
    let small = Gpu::with_limits(|limits| limits.max_storage_buffer_binding_size = 8 << 10);
    let mut split = 0;
    for (seed, (name, model)) in (0..).zip(assets()) {
        let asset = model.asset();
        // An instance's rows and positions have to fit.
        let rows = 32 * (13 + asset.mode_count() + 12 * asset.bone_count());
        if rows > 8 << 10 {
            continue;
        }
        let posed = &posed(asset, seed)[1..2];
        let skinner = Skinner::new(&small.device, &small.queue).expect("skinner");
        let uploaded = skinner.upload(asset, Normals::Fields).expect("upload");
        split += u32::from(uploaded.range_count() > 1);
        for normals in [Normals::Fields, Normals::Exact] {
            let [a, b] = [&whole, &small].map(|gpu| skin(gpu, asset, normals, posed, [1.0; 3]));
            assert!(a.positions == b.positions, "{name}: positions");
            assert!(a.normals == b.normals, "{name}: normals");
        }
    }
    assert!(split >= 2, "{split} assets were split");
}

#[test]
fn matrices_that_a_pose_refuses_are_refused() {
    let gpu = Gpu::new();
    let skinner = Skinner::new(&gpu.device, &gpu.queue).expect("skinner");
    let all = assets();
    let asset = all[0].1.asset();
    let uploaded = skinner.upload(asset, Normals::None).expect("upload");
    assert!(uploaded.has_skin() && uploaded.bone_count() == 3);
    let mut instances = skinner.instances(&uploaded, 2).expect("instances");
    let q = vec![0.0; asset.mode_count()];
    let mut push = |matrices: &[_]| {
        let bones = BoneMatrices::Skinning(matrices);
        instances.push_with_bones(asset, &q, bones, Transform::IDENTITY)
    };
    let identity = [
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
    ];
    let too_few = push(&[identity; 2]);
    assert!(
        matches!(
            too_few,
            Err(GpuError::Pose(PoseError::BoneCount {
                expected: 3,
                found: 2
            }))
        ),
        "{too_few:?}"
    );
    let too_far = push(&[
        identity,
        identity,
        identity.map(|row| row.map(|x| 1e30 * x)),
    ]);
    assert!(
        matches!(
            too_far,
            Err(GpuError::Pose(PoseError::MatrixRange { index: 2 }))
        ),
        "{too_far:?}"
    );
    push(&[identity; 3]).expect("push");
    assert_eq!(instances.len(), 1);
}
