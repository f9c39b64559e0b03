//! Deforms meshes on a GPU: `p' = p + U q`, with a skin `p' = Σ_b w_b T_b (p + U q)`, for every vertex of many
//! instances, as vertex buffers or inside a vertex shader.
//!
//! Everything is made on the caller's device. Results are near [`Pose::deformed`](bdtree_runtime::Pose::deformed), by a bound
//! that each instance states, but not to the bit: queries go on using their own arithmetic.
//! How an engine uses it, layouts, limits and errors: `docs/reference/gpu-deformation.md`.
//!
//! Features are wgpu's backends: `vulkan` (default), `metal`, `dx12`, `webgpu`. Types of wgpu stand in this crate's
//! API and in no other's of the library, so that its majors change nothing else.
//!
//! ```no_run
//! use bdtree_gpu::{GpuError, Normals, Skinner};
//! use bdtree_runtime::{Asset, Transform};
//!
//! fn frame(
//!     device: &wgpu::Device, queue: &wgpu::Queue, asset: &Asset<'_>, q: &[f32], camera: [f64; 3],
//! ) -> Result<(), GpuError> {
//!     // Once.
//!     let skinner = Skinner::new(device, queue)?;
//!     let chair = skinner.upload(asset, Normals::Exact)?;
//!     let mut instances = skinner.instances(&chair, 1000)?;
//!     let output = skinner.output(&chair, 1000)?;
//!     // Every frame.
//!     instances.clear(camera);
//!     instances.push_at(asset, q, Transform::IDENTITY)?;
//!     instances.write();
//!     let mut encoder = device.create_command_encoder(&Default::default());
//!     skinner.record(&mut encoder, &chair, &instances, &output)?;
//!     // Draw: output.positions() and output.normals() are vertex buffers of [f32; 3], N of each
//!     // instance one behind the other; chair.indices() is an index buffer of u32.
//!     queue.submit([encoder.finish()]);
//!     Ok(())
//! }
//! ```

mod asset;
mod bound;
mod buffers;
mod device;
mod error;
mod influences;
mod instances;
mod layouts;
mod normal_fields;
mod output;
mod ranges;
mod samples;
mod shader;
mod skinner;
mod tangents;
pub mod twin;
mod vertex;
mod vertex_triangles;

pub use asset::{GpuAsset, Normals};
pub use device::{request_device, wait};
pub use error::GpuError;
pub use instances::Instances;
pub use normal_fields::NormalFields;
pub use output::{Output, read_back};
pub use skinner::Skinner;
pub use vertex::{vertex_layout, vertex_source};
