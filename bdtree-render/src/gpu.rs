//! A device to draw with, and what went wrong on it.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bdtree_gpu::{GpuError, request_device};
use wgpu::{Adapter, Device, Instance, InstanceDescriptor, Queue, Surface};

use crate::error::RenderError;

/// An adapter and its device, with all that the adapter can hold.
#[derive(Debug, Clone)]
pub struct Gpu {
    /// The entry to the system's graphics.
    pub instance: Instance,
    /// What draws: a graphics card or a program.
    pub adapter: Adapter,
    /// Its device.
    pub device: Device,
    /// Where work goes.
    pub queue: Queue,
    failure: Arc<Mutex<Failure>>,
}

/// What went wrong.
#[derive(Debug, Default)]
struct Failure {
    /// The first thing since it was last asked for.
    first: Option<String>,
    /// Stays, as a lost device does; what fails on it afterwards says less.
    lost: Option<String>,
}

fn noted(failure: &Mutex<Failure>) -> MutexGuard<'_, Failure> {
    failure.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Gpu {
    /// A device for pictures in memory, of the fastest adapter there is; a program that draws on the
    /// processor will do.
    ///
    /// # Errors
    /// When there is no adapter, or it gives no device.
    pub fn offscreen() -> Result<Self, RenderError> {
        let instance = Instance::new(InstanceDescriptor::new_without_display_handle());
        Self::for_surface(instance, None)
    }

    /// A device that can also show pictures on a surface of `instance`.
    ///
    /// # Errors
    /// As of [`Gpu::offscreen`].
    pub fn for_surface(
        instance: Instance,
        surface: Option<&Surface<'_>>,
    ) -> Result<Self, RenderError> {
        let requested = pollster::block_on(request_device(&instance, surface));
        let (adapter, device, queue) = requested.map_err(|error| match error {
            GpuError::NoAdapter(why) => RenderError::NoAdapter(why),
            error => error.into(),
        })?;
        let failure = Arc::<Mutex<Failure>>::default();
        let here = failure.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            noted(&here).first.get_or_insert(error.to_string());
        }));
        let here = failure.clone();
        device.set_device_lost_callback(move |_, text| {
            noted(&here).lost.get_or_insert(format!("lost: {text}"));
        });
        Ok(Self {
            instance,
            adapter,
            device,
            queue,
            failure,
        })
    }

    /// Whether all has gone well since the last call.
    ///
    /// # Errors
    /// The first thing that has not: a lost device, no memory, an operation that was refused.
    pub fn check(&self) -> Result<(), RenderError> {
        // wgpu tells of a loss only where it is asked how far the device is.
        let _ = self.device.poll(wgpu::PollType::Poll);
        let mut failure = noted(&self.failure);
        let first = failure.first.take();
        match failure.lost.clone().or(first) {
            Some(text) => Err(RenderError::Device(one_line(&text))),
            None => Ok(()),
        }
    }

    /// Waits until all work is done, then checks.
    ///
    /// # Errors
    /// As of [`Gpu::check`].
    pub fn finish(&self) -> Result<(), RenderError> {
        let waited = bdtree_gpu::wait(&self.device);
        self.check()?;
        Ok(waited?)
    }

    /// Checks that a buffer of so many bytes may be made.
    ///
    /// # Errors
    /// When it is larger than the device allows.
    pub(crate) fn allows_buffer(
        device: &Device,
        what: &'static str,
        needed: u64,
    ) -> Result<(), RenderError> {
        let limit = device.limits().max_buffer_size;
        if needed > limit {
            return Err(RenderError::TooLarge {
                what,
                needed,
                limit,
                unit: "bytes",
            });
        }
        Ok(())
    }
}

/// Text of several lines as one.
pub fn one_line(text: &str) -> String {
    let words: Vec<&str> = text.split_whitespace().collect();
    words.join(" ")
}
