//! What can go wrong on a GPU.

use bdtree_runtime::{FormatError, PoseError};

/// Why something is not done on a GPU.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// There is no adapter; with the backend's words.
    #[error("no GPU adapter: {0}")]
    NoAdapter(String),
    /// The adapter gives no device.
    #[error("GPU adapter {adapter}: {cause}")]
    NoDevice {
        /// Its name.
        adapter: String,
        /// Why, in its own words.
        cause: String,
    },
    /// The device is lost: everything made on it has to be made anew on another.
    #[error("the GPU device is lost; make a new one and upload again")]
    DeviceLost,
    /// The device refuses; with its own words.
    #[error("the GPU device refuses: {0}")]
    Device(String),
    /// Part of an asset does not fit the device's limits.
    #[error("{what} of the asset take {bytes} bytes, the device allows {limit}")]
    AssetTooLarge {
        /// Which part.
        what: &'static str,
        /// Bytes that have to fit.
        bytes: u64,
        /// The device's limit.
        limit: u64,
    },
    /// So many instances, or their output, do not fit the device's limits.
    #[error(
        "{instances} instances take {bytes} bytes of one buffer, the device allows {limit}: \
         {fit} instances fit"
    )]
    TooManyInstances {
        /// Instances asked for.
        instances: u64,
        /// Instances that fit.
        fit: u64,
        /// Bytes of the buffer.
        bytes: u64,
        /// The device's limit.
        limit: u64,
    },
    /// More instances than there is room for.
    #[error("all {capacity} instances are taken")]
    Full {
        /// Instances that fit.
        capacity: u32,
    },
    /// Instances, output, positions or a pose are of another asset.
    #[error("{0} made for another asset")]
    Mismatch(&'static str),
    /// What cannot be done, and what can instead.
    #[error("{0}")]
    Unsupported(&'static str),
    /// q or placement are refused.
    #[error(transparent)]
    Pose(#[from] PoseError),
    /// An instance reaches farther from the origin than f32 does: put the origin near the camera.
    #[error("instance {instance} reaches farther from the origin than f32 numbers do")]
    TooFar {
        /// Number of the instance.
        instance: u32,
    },
    /// The asset's bytes break a rule that only the deep check reads; run `verify`.
    #[error("damaged .bdt file: {0}")]
    Corrupt(#[from] FormatError),
}
