//! The device: asking for one, and what it says when it refuses.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::pin::pin;
use std::task::{Context, Poll, Waker};

use crate::error::GpuError;

/// The fastest adapter, which can show pictures on `surface` if there is one, and its device and queue with all that it
/// allows, for programs that have none yet: wgpu's defaults allow bindings of 128 MiB only. Timestamps are on
/// where there are any.
///
/// # Errors
/// [`GpuError::NoAdapter`], [`GpuError::NoDevice`].
pub async fn request_device(
    instance: &wgpu::Instance,
    surface: Option<&wgpu::Surface<'_>>,
) -> Result<(wgpu::Adapter, wgpu::Device, wgpu::Queue), GpuError> {
    let options = wgpu::RequestAdapterOptions {
        power_preference: wgpu::PowerPreference::HighPerformance,
        compatible_surface: surface,
        ..Default::default()
    };
    let adapter = instance
        .request_adapter(&options)
        .await
        .map_err(|e| GpuError::NoAdapter(e.to_string()))?;
    let timestamps =
        wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
    let descriptor = wgpu::DeviceDescriptor {
        label: Some("bdtree"),
        required_features: adapter.features() & timestamps,
        required_limits: adapter.limits(),
        ..Default::default()
    };
    match adapter.request_device(&descriptor).await {
        Ok((device, queue)) => Ok((adapter, device, queue)),
        Err(error) => Err(GpuError::NoDevice {
            adapter: adapter.get_info().name,
            cause: error.to_string(),
        }),
    }
}

/// What `make` returns, or the first error that the device reports meanwhile; a lost device is one.
pub(crate) fn checked<T>(
    device: &wgpu::Device,
    make: impl FnOnce() -> Result<T, GpuError>,
) -> Result<T, GpuError> {
    let made = scoped(device, make);
    // What is made on a lost device is invalid, and nothing says so until it is used.
    match made {
        Ok(_) | Err(GpuError::Device(_)) if is_lost(device) => Err(GpuError::DeviceLost),
        made => made,
    }
}

/// [`checked`] without asking whether the device is lost, for what is done every frame.
pub(crate) fn scoped<T>(
    device: &wgpu::Device,
    make: impl FnOnce() -> Result<T, GpuError>,
) -> Result<T, GpuError> {
    let scopes = [
        wgpu::ErrorFilter::Internal,
        wgpu::ErrorFilter::OutOfMemory,
        wgpu::ErrorFilter::Validation,
    ]
    .map(|filter| device.push_error_scope(filter));
    let made = make();
    let [internal, memory, validation] = scopes;
    // In the order in which they were pushed, backwards.
    let errors = [validation, memory, internal].map(|scope| now(scope.pop()).flatten());
    match errors.into_iter().flatten().next() {
        Some(error) => Err(GpuError::Device(error.to_string())),
        None => made,
    }
}

/// Whether a buffer of one word can not even be made. (The callback that tells of a loss is the caller's.)
fn is_lost(device: &wgpu::Device) -> bool {
    let probe = scoped(device, || {
        let word = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("probe"),
            size: 4,
            usage: wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: true,
        });
        Ok(word.slice(..).get_mapped_range_mut().is_err())
    });
    probe.unwrap_or(true)
}

/// Waits for all that was submitted.
///
/// # Errors
/// [`GpuError::DeviceLost`].
pub fn wait(device: &wgpu::Device) -> Result<(), GpuError> {
    // wgpu panics where the driver loses the device while it waits.
    let waited = catch_unwind(AssertUnwindSafe(|| {
        device.poll(wgpu::PollType::wait_indefinitely())
    }));
    match waited {
        Ok(Ok(_)) => Ok(()),
        _ => Err(GpuError::DeviceLost),
    }
}

/// The result of a future that is ready; in a browser, where it is not, `None`.
fn now<T>(future: impl Future<Output = T>) -> Option<T> {
    let mut context = Context::from_waker(Waker::noop());
    match pin!(future).as_mut().poll(&mut context) {
        Poll::Ready(value) => Some(value),
        Poll::Pending => None,
    }
}

/// Largest buffer that can be bound whole.
pub(crate) fn largest_binding(device: &wgpu::Device) -> u64 {
    let limits = device.limits();
    // A multiple of four, and indices of numbers are u32.
    limits
        .max_storage_buffer_binding_size
        .min(limits.max_buffer_size)
        .min(1 << 33)
        & !3
}
