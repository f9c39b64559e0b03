//! Deforms three instances of an embedded file on a GPU, reads them back, and holds every vertex against the
//! processor's: none may be farther from it than the error that the instance states.

use bdtree_gpu::{Normals, Skinner, read_back, request_device};
use bdtree_runtime::{Asset, Pose, Transform, VertexId, include_bdt};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // An engine has a device of its own.
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let (_, device, queue) = pollster::block_on(request_device(&instance, None))?;

    // Once per asset.
    let asset = Asset::open(include_bdt!("../../fixtures/golden/sphere.bdt"))?;
    let skinner = Skinner::new(&device, &queue)?;
    let uploaded = skinner.upload(&asset, Normals::Fields)?;
    let mut instances = skinner.instances(&uploaded, 3)?;
    let output = skinner.output(&uploaded, 3)?;

    // Every frame: f32 positions are relative to the camera, wherever in the world that is.
    let camera = [1e6, 0.0, 0.0];
    let placed = [0.0, 3.0, 6.0].map(|x| Transform {
        translation: [1e6 + x, 0.5, -2.0],
        ..Transform::IDENTITY
    });
    let qs = [[0.0, 0.0, 0.0], [0.2, -0.1, 0.3], [-0.3, 0.2, 0.1]];
    instances.clear(camera);
    let mut errors = Vec::new();
    for (q, place) in qs.iter().zip(placed) {
        errors.push(instances.push_at(&asset, q, place)?);
    }
    instances.write();
    let mut encoder = device.create_command_encoder(&Default::default());
    skinner.record(&mut encoder, &uploaded, &instances, &output)?;
    queue.submit([encoder.finish()]);

    // An engine draws from `output.positions()`; this program looks at them.
    let count = asset.vertex_count();
    let found = read_back(&device, &queue, output.positions(), 3 * count)?;
    let mut memory = vec![0.0; asset.pose_len()];
    for (k, (q, place)) in qs.iter().zip(placed).enumerate() {
        let pose = Pose::new(&asset, q, place, &mut memory)?;
        let mut worst = 0.0_f64;
        for (i, y) in (0..).zip(&found[k * count..][..count]) {
            let x = asset.deformed(&pose, VertexId(i))?;
            let off = [0, 1, 2].map(|axis| x[axis] - camera[axis] - f64::from(y[axis]));
            worst = worst.max(off.iter().map(|d| d * d).sum::<f64>().sqrt());
        }
        println!(
            "instance {k}: {count} vertices off by {worst:.1e} at most, {:.1e} allowed",
            errors[k]
        );
        assert!(worst <= errors[k]);
    }
    Ok(())
}
