//! What can go wrong on a GPU.

use std::fmt;

use bdtree_runtime::{FormatError, PoseError};

/// Why something is not done on a GPU.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum GpuError {
    /// There is no adapter; with the backend's words.
    NoAdapter(String),
    /// The adapter gives no device.
    NoDevice {
        /// Its name.
        adapter: String,
        /// Why, in its own words.
        cause: String,
    },
    /// The device is lost: everything made on it has to be made anew on another.
    DeviceLost,
    /// The device refuses; with its own words.
    Device(String),
    /// Part of an asset does not fit the device's limits.
    AssetTooLarge {
        /// Which part.
        what: &'static str,
        /// Bytes that have to fit.
        bytes: u64,
        /// The device's limit.
        limit: u64,
    },
    /// So many instances, or their output, do not fit the device's limits.
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
    Full {
        /// Instances that fit.
        capacity: u32,
    },
    /// Instances, output, positions or a pose are of another asset.
    Mismatch(&'static str),
    /// What cannot be done, and what can instead.
    Unsupported(&'static str),
    /// q or placement are refused.
    Pose(PoseError),
    /// An instance reaches farther from the origin than f32 does: put the origin near the camera.
    TooFar {
        /// Number of the instance.
        instance: u32,
    },
    /// The asset's bytes break a rule that only the deep check reads; run `verify`.
    Corrupt(FormatError),
}

impl fmt::Display for GpuError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoAdapter(why) => write!(f, "no GPU adapter: {why}"),
            Self::NoDevice { adapter, cause } => write!(f, "GPU adapter {adapter}: {cause}"),
            Self::DeviceLost => {
                f.write_str("the GPU device is lost; make a new one and upload again")
            }
            Self::Device(why) => write!(f, "the GPU device refuses: {why}"),
            Self::AssetTooLarge { what, bytes, limit } => write!(
                f,
                "{what} of the asset take {bytes} bytes, the device allows {limit}"
            ),
            Self::TooManyInstances {
                instances,
                fit,
                bytes,
                limit,
            } => write!(
                f,
                "{instances} instances take {bytes} bytes of one buffer, the device allows {limit}: \
                 {fit} instances fit"
            ),
            Self::Full { capacity } => write!(f, "all {capacity} instances are taken"),
            Self::Mismatch(what) => write!(f, "{what} made for another asset"),
            Self::Unsupported(what) => f.write_str(what),
            Self::Pose(error) => write!(f, "{error}"),
            Self::TooFar { instance } => write!(
                f,
                "instance {instance} reaches farther from the origin than f32 numbers do"
            ),
            Self::Corrupt(error) => write!(f, "corrupt asset: {error}"),
        }
    }
}

impl std::error::Error for GpuError {}

impl From<PoseError> for GpuError {
    fn from(error: PoseError) -> Self {
        Self::Pose(error)
    }
}

impl From<FormatError> for GpuError {
    fn from(error: FormatError) -> Self {
        Self::Corrupt(error)
    }
}
