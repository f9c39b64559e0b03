//! Skinning on a GPU: every vertex within the bound that its instance states.

use bdtree_runtime::gpu::{self, Normals, Skinner};
use bdtree_runtime::{AlignedBytes, Asset, Pose, Transform, VertexId};
use bdtree_tests::gpu::device;
use bdtree_tests::{bake, golden, poses};

#[test]
fn first() {
    let (device, queue) = device();
    let mesh = bake::bumpy_sphere(12, 1);
    for bytes in [
        bake::baked(&mesh, &bake::smooth_basis(&mesh, 10, 1)),
        bake::baked(&mesh, &bake::local_basis(&mesh, 12, 1)),
        AlignedBytes::read(golden::folder().join("tetrahedron.bdt")).expect("golden"),
    ] {
        let asset = Asset::open(&bytes).expect("open");
        let skinner = Skinner::new(&device, &queue).expect("skinner");
        let on_gpu = skinner.upload(&asset, Normals::Exact).expect("upload");
        for count in [1, 2, 3, 8, 13] {
            let mut instances = skinner.instances(&on_gpu, count).expect("instances");
            let output = skinner.output(&on_gpu, count).expect("output");
            let mut rng = poses::rng(3);
            instances.clear([0.5, 0.25, 1.0]);
            let mut given = Vec::new();
            for _ in 0..count {
                let q = poses::random_q(&asset, 0.3, &mut rng);
                let t = poses::random_transform(3.0, &mut rng);
                let e = instances.push_at(&asset, &q, t).expect("push");
                given.push((q, t, e));
            }
            instances.write();
            let mut encoder = device.create_command_encoder(&Default::default());
            skinner
                .record(&mut encoder, &on_gpu, &instances, &output)
                .expect("record");
            queue.submit([encoder.finish()]);
            let n = asset.vertex_count();
            let points =
                gpu::read_back(&device, &queue, output.positions(), n * count as usize).expect("read");
            let mut worst = 0.0_f64;
            for (k, (q, t, e)) in given.iter().enumerate() {
                let mut memory = vec![0.0; asset.pose_len()];
                let pose = Pose::new(&asset, q, *t, &mut memory).expect("pose");
                for v in 0..n {
                    let x = asset.deformed(&pose, VertexId(v as u32)).expect("vertex");
                    let y = points[k * n + v];
                    let d: f64 = (0..3)
                        .map(|i| (x[i] - instances.origin()[i] - f64::from(y[i])).powi(2))
                        .sum::<f64>()
                        .sqrt();
                    assert!(d <= *e, "{d} {e}");
                    worst = worst.max(d / e);
                }
            }
            println!("{count}: {worst}");
        }
    }
    let _ = Transform::IDENTITY;
}
