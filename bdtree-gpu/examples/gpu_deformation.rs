//! Deforms three instances of an embedded file on a GPU, reads them back, and holds every vertex against the
//! processor's: none may be farther from it than the error that the instance states.

use bdtree_gpu::{Normals, Skinner, read_back, request_device};
use bdtree_runtime::{Instance, Model, Transform, VertexId, include_bdt};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // An engine has a device of its own.
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let (_, device, queue) = pollster::block_on(request_device(&instance, None))?;

    // Once per asset.
    let model = Model::from_static(include_bdt!("../../fixtures/golden/sphere.bdt"))?;
    let skinner = Skinner::new(&device, &queue)?;
    let uploaded = skinner.upload(model.asset(), Normals::Fields)?;
    let mut instances = skinner.instances(&uploaded, 3)?;
    let output = skinner.output(&uploaded, 3)?;

    let mut bodies = Vec::new();
    for (x, q) in [
        (0.0, [0.0; 3]),
        (3.0, [0.2, -0.1, 0.3]),
        (6.0, [-0.3, 0.2, 0.1]),
    ] {
        let mut body = Instance::new(&model)?;
        body.set_pose(&q, Transform::from_translation([1e6 + x, 0.5, -2.0]))?;
        bodies.push(body);
    }

    // Every frame: f32 positions are relative to the camera, wherever in the world that is.
    let camera = [1e6, 0.0, 0.0];
    instances.clear(camera);
    let mut errors = Vec::new();
    for body in &bodies {
        errors.push(instances.push(&body.pose())?);
    }
    instances.write();
    let mut encoder = device.create_command_encoder(&Default::default());
    skinner.record(&mut encoder, &uploaded, &instances, &output)?;
    queue.submit([encoder.finish()]);

    // An engine draws from `output.positions()`; this program looks at them.
    let count = model.asset().vertex_count();
    let found = read_back(&device, &queue, output.positions(), 3 * count)?;
    for (k, (body, allowed)) in bodies.iter().zip(errors).enumerate() {
        let pose = body.pose();
        let mut worst = 0.0_f64;
        for (i, y) in (0..).zip(&found[k * count..][..count]) {
            let x = pose.deformed(VertexId(i))?;
            let off = [0, 1, 2].map(|axis| x[axis] - camera[axis] - f64::from(y[axis]));
            worst = worst.max(off.iter().map(|d| d * d).sum::<f64>().sqrt());
        }
        println!(
            "instance {k}: {count} vertices off by {worst:.1e} at most, {allowed:.1e} allowed"
        );
        assert!(worst <= allowed);
    }
    Ok(())
}
