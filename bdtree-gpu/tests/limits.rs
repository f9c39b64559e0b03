//! What a device does not allow is split or refused with an error that says what fits; nothing panics.

use bdtree_fixtures::{bake, mutate, poses};
use bdtree_format::{Header, ModeRecord, SectionKind};
use bdtree_gpu::{GpuError, Normals, Skinner, read_back, twin, vertex_layout};
use bdtree_runtime::{Model, PoseError, Transform};
use rand::RngExt;

use crate::devices::{self, Gpu};

/// Bindings of 16 KiB: meshes are split into ranges of vertices, of positions, normal fields and rings
/// alike, and the results keep their bits.
#[test]
fn split_assets_give_the_same_bits() {
    let whole = Gpu::new();
    let small = Gpu::with_limits(|limits| {
        limits.max_storage_buffer_binding_size = 16 << 10;
        limits.max_compute_workgroups_per_dimension = 3;
    });
    let mut split = 0;
    for (seed, (name, model)) in (0..).zip(devices::assets()) {
        let asset = model.asset();
        let n = asset.vertex_count();
        // One instance has to fit.
        let fit = (16 << 10) / (12 * n).max(32 * (12 + asset.mode_count()) / 8);
        let placed = devices::placed(asset, seed);
        let placed = &placed[1..=fit.clamp(1, placed.len() - 1).min(7)];
        let skinner = Skinner::new(&small.device, &small.queue).expect("skinner");
        let uploaded = skinner.upload(asset, Normals::Fields).expect("upload");
        split += u32::from(uploaded.range_count() > 1);
        for normals in [Normals::Fields, Normals::Exact] {
            let a = whole.skin(asset, normals, placed, [1.0, 2.0, 3.0]);
            let b = small.skin(asset, normals, placed, [1.0, 2.0, 3.0]);
            let (a, b) = (a.expect("whole"), b.expect("split"));
            assert!(a.positions == b.positions, "{name}: positions");
            assert!(a.normals == b.normals, "{name}: normals");
            assert!(a.positions.iter().flatten().any(|x| *x != 0.0));
        }
    }
    assert!(split >= 3, "{split} assets were split");
}

#[test]
fn sizes_beyond_the_device_are_refused_with_what_fits() {
    let gpu = Gpu::with_limits(|limits| limits.max_storage_buffer_binding_size = 16 << 10);
    let mesh = bake::bumpy_sphere(14, 1); // 366 vertices
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 10, 1));
    let asset = model.asset();
    let n = asset.vertex_count();
    let skinner = Skinner::new(&gpu.device, &gpu.queue).expect("skinner");
    let uploaded = skinner.upload(asset, Normals::None).expect("upload");
    let fit = (16 << 10) / (12 * n) as u32;
    assert!(skinner.output(&uploaded, fit).is_ok());
    match skinner.output(&uploaded, fit + 1) {
        Err(GpuError::TooManyInstances {
            instances,
            fit: found,
            bytes,
            limit,
        }) => {
            assert_eq!((instances, found), (u64::from(fit) + 1, u64::from(fit)));
            assert_eq!((bytes, limit), (12 * n as u64 * instances, 16 << 10));
        }
        other => panic!("{other:?}"),
    }
    // Instances: blocks of eight, 22 rows of 32 bytes.
    let fit = (((16 << 10) - 32) / (22 * 32)) * 8;
    assert!(skinner.instances(&uploaded, fit).is_ok());
    match skinner.instances(&uploaded, fit + 1) {
        Err(GpuError::TooManyInstances { fit: found, .. }) => assert_eq!(found, u64::from(fit)),
        other => panic!("{other:?}"),
    }
    assert!(skinner.instances(&uploaded, u32::MAX).is_err());
    assert!(skinner.output(&uploaded, u32::MAX).is_err());
    // A single vertex of 512 modes takes 6 KiB, twice that with normals' fields: refused where it does not fit.
    let tiny = Gpu::with_limits(|limits| limits.max_storage_buffer_binding_size = 4 << 10);
    let mesh = bake::bumpy_sphere(3, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 400, 1));
    let asset = model.asset();
    let skinner = Skinner::new(&tiny.device, &tiny.queue).expect("skinner");
    match skinner.upload(asset, Normals::None) {
        Err(GpuError::AssetTooLarge { what, bytes, limit }) => {
            assert_eq!((what, bytes, limit), ("displacements", 4800, 4 << 10));
        }
        other => panic!("{other:?}"),
    }
    // A vertex shader needs the asset whole.
    let skinner = Skinner::new(&gpu.device, &gpu.queue).expect("skinner");
    let uploaded = skinner.upload(asset, Normals::None).expect("upload");
    let instances = skinner.instances(&uploaded, 1).expect("instances");
    let layout = vertex_layout(&gpu.device);
    let group = skinner.vertex_group(&layout, &uploaded, &instances);
    assert!(matches!(group, Err(GpuError::Unsupported(_))), "{group:?}");
}

#[test]
fn instances_have_the_checks_of_poses() {
    let gpu = Gpu::new();
    let mesh = bake::bumpy_sphere(6, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 2, 1));
    let other = bake::baked(&mesh, &bake::smooth_basis(&mesh, 2, 2));
    let asset = model.asset();
    let skinner = Skinner::new(&gpu.device, &gpu.queue).expect("skinner");
    let uploaded = skinner.upload(asset, Normals::None).expect("upload");
    let mut instances = skinner.instances(&uploaded, 2).expect("instances");
    let limit = asset.modes()[1].q_limit.get();
    let here = Transform::IDENTITY;
    let mut refused = |q: &[f32], place: Transform| match instances.push_at(asset, q, place) {
        Err(GpuError::Pose(error)) => error,
        other => panic!("{q:?}: {other:?}"),
    };
    assert_eq!(
        refused(&[0.0, f32::NAN], here),
        PoseError::NotFinite { mode: 1 }
    );
    assert_eq!(
        refused(&[f32::INFINITY, 0.0], here),
        PoseError::NotFinite { mode: 0 }
    );
    let over = refused(&[0.0, 2.0 * limit], here);
    assert!(
        matches!(over, PoseError::OverLimit { mode: 1, .. }),
        "{over:?}"
    );
    assert_eq!(
        refused(&[0.0], here),
        PoseError::ModeCount {
            expected: 2,
            found: 1
        }
    );
    let turned = Transform {
        rotation: [0.0, 0.0, 0.0, 1.1],
        ..here
    };
    assert_eq!(refused(&[0.0; 2], turned), PoseError::Rotation);
    let nowhere = Transform {
        translation: [f64::NAN, 0.0, 0.0],
        ..here
    };
    assert_eq!(refused(&[0.0; 2], nowhere), PoseError::Translation);
    let endless = Transform { scale: 0.0, ..here };
    assert_eq!(refused(&[0.0; 2], endless), PoseError::Scale);
    assert!(instances.is_empty(), "what is refused is not added");

    // Beyond f32, seen from a camera elsewhere.
    instances.clear([1e37, 0.0, 0.0]);
    let far = instances.push_at(asset, &[0.0; 2], here);
    assert!(
        matches!(far, Err(GpuError::TooFar { instance: 0 })),
        "{far:?}"
    );
    instances.clear([f64::NAN; 3]);
    assert!(instances.push_at(asset, &[0.0; 2], here).is_err());
    instances.clear([0.0; 3]);

    let stranger = other.asset();
    let mixed = instances.push_at(stranger, &[0.0; 2], here);
    assert!(matches!(mixed, Err(GpuError::Mismatch(_))), "{mixed:?}");
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = stranger.pose(&[0.0; 2], here, &mut memory).expect("pose");
    let mixed = instances.push(&pose);
    assert!(matches!(mixed, Err(GpuError::Mismatch(_))), "{mixed:?}");

    // A pose and its q give the same instance.
    let mut memory = vec![0.0; asset.pose_len()];
    let q = [0.25 * limit, f32::MIN_POSITIVE / 2.0];
    let pose = asset.pose(&q, here, &mut memory).expect("pose");
    instances.push(&pose).expect("push");
    instances.push_at(asset, &q, here).expect("push");
    let [a, b] = [0, 1].map(|k| twin::positions(asset, &instances, k).expect("twin"));
    assert!(a == b);
    let full = instances.push_at(asset, &q, here);
    assert!(
        matches!(full, Err(GpuError::Full { capacity: 2 })),
        "{full:?}"
    );

    // Instances and outputs of other assets, and too small ones.
    let theirs = skinner.upload(stranger, Normals::None).expect("upload");
    let small = skinner.output(&uploaded, 1).expect("output");
    let wrong = skinner.output(&theirs, 2).expect("output");
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    for (asset, output) in [(&theirs, &wrong), (&uploaded, &small), (&uploaded, &wrong)] {
        let refused = skinner.record(&mut encoder, asset, &instances, output);
        assert!(refused.is_err());
        println!("{}", refused.expect_err("an error"));
    }
}

#[test]
fn broken_records_are_refused() {
    let gpu = Gpu::new();
    let mesh = bake::bumpy_sphere(6, 1);
    let mut rng = poses::rng(1);
    let (mut refused, mut taken) = (0, 0);
    for (sparse, model) in [
        (true, bake::baked(&mesh, &bake::local_basis(&mesh, 6, 1))),
        (false, bake::baked(&mesh, &bake::smooth_basis(&mesh, 3, 1))),
    ] {
        for _ in 0..150 {
            let mut bytes = model.asset().bytes().to_vec();
            let kinds = [
                SectionKind::TRIANGLES,
                SectionKind::TRIANGLE_SLOTS,
                SectionKind::POSITIONS,
                SectionKind::DISPLACEMENTS,
                if sparse {
                    SectionKind::VERTEX_MODES
                } else {
                    SectionKind::TRIANGLES
                },
                if sparse {
                    SectionKind::MODE_LISTS
                } else {
                    SectionKind::POSITIONS
                },
            ];
            let modes = if sparse { 6 } else { 3 } * size_of::<ModeRecord>();
            let section = match kinds.get(rng.random_range(0..=kinds.len())) {
                Some(kind) => mutate::section(&bytes, *kind),
                None => size_of::<Header>()..size_of::<Header>() + modes,
            };
            let at = section.start + (rng.random_range(0..section.len()) & !1);
            let length = [2, 4, 40][rng.random_range(0..3)].min(section.end - at);
            match rng.random_range(0..3) {
                0 => bytes[at..at + length].fill(0xff),
                1 => bytes[at..at + length].fill(rng.random_range(0..4)),
                _ => rng.fill(&mut bytes[at..at + length]),
            }
            // Else the table of modes would never get past its checksum.
            mutate::repair(&mut bytes);
            let Ok(model) = Model::from_bytes(&bytes) else {
                continue;
            };
            let skinner = Skinner::new(&gpu.device, &gpu.queue).expect("skinner");
            for normals in [Normals::Fields, Normals::Exact] {
                match skinner.upload(model.asset(), normals) {
                    Ok(_) => taken += 1,
                    Err(GpuError::Corrupt(_)) => refused += 1,
                    Err(other) => panic!("{other}"),
                }
            }
        }
    }
    println!("{refused} refused, {taken} taken");
    assert!(
        refused > 20 && taken > 20,
        "{refused} refused, {taken} taken"
    );
}

#[test]
fn a_lost_device_is_an_error() {
    let mesh = bake::bumpy_sphere(6, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 2, 1));
    let asset = model.asset();
    let gpu = Gpu::new();
    let skinner = Skinner::new(&gpu.device, &gpu.queue).expect("skinner");
    let uploaded = skinner.upload(asset, Normals::Exact).expect("upload");
    let mut instances = skinner.instances(&uploaded, 1).expect("instances");
    let output = skinner.output(&uploaded, 1).expect("output");
    instances
        .push_at(asset, &[0.0; 2], Transform::IDENTITY)
        .expect("push");
    gpu.device.destroy();
    let lost = [
        skinner.upload(asset, Normals::Exact).map(|_| ()),
        skinner.instances(&uploaded, 1).map(|_| ()),
        skinner.output(&uploaded, 1).map(|_| ()),
        Skinner::new(&gpu.device, &gpu.queue).map(|_| ()),
        read_back(&gpu.device, &gpu.queue, output.positions(), 3).map(|_| ()),
    ];
    for (k, result) in lost.into_iter().enumerate() {
        assert_eq!(result, Err(GpuError::DeviceLost), "step {k}");
    }
    // What is done every frame does not ask, and does not panic either.
    instances.write();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let _ = skinner.record(&mut encoder, &uploaded, &instances, &output);
}
