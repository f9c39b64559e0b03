//! The GPU that tests run on; on a machine without one, Mesa's lavapipe.

use bdtree_runtime::gpu::request_device;

/// A device with all that the first adapter allows.
///
/// # Panics
/// When there is none: tests that need one do not pass without.
pub fn device() -> (wgpu::Device, wgpu::Queue) {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    pollster::block_on(request_device(&instance))
        .expect("a GPU, or Mesa's lavapipe (mesa-vulkan-drivers, libvulkan1)")
}
