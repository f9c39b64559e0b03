//! What can keep a picture from being made.

use bdtree_gpu::GpuError;

/// Why there is no picture.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// Nothing to draw with.
    #[error(
        "no graphics adapter for Vulkan ({0}): install the graphics card's driver or Mesa's \
         software Vulkan (Debian: apt-get install mesa-vulkan-drivers libvulkan1)"
    )]
    NoAdapter(String),
    /// More than the device takes.
    #[error("{what}: {needed} {unit}, the graphics device takes at most {limit}")]
    TooLarge {
        /// What is too large.
        what: &'static str,
        /// How large it is.
        needed: u64,
        /// How large it may be.
        limit: u64,
        /// What is counted.
        unit: &'static str,
    },
    /// A body of a crowd cannot be drawn.
    #[error("body {body}: {reason}")]
    Body {
        /// Its number.
        body: usize,
        /// Why.
        reason: String,
    },
    /// The adapter gives no device, or an asset could not be deformed on it.
    #[error("{0}")]
    Skinning(#[from] GpuError),
    /// The device was lost, ran out of memory or refused an operation.
    #[error("graphics device: {0}")]
    Device(String),
}
