//! Pictures of assets: deformed meshes and the spheres of their trees.
//!
//! [`Gpu`] is a device for pictures in memory or for a window. A [`Renderer`] draws what a [`Scene`]
//! holds ([`Mesh`]es, deformed on the device as [`SkinnedMesh`], [`Sphere`]s, [`Line`]s) as a [`Camera`] sees it into any texture view;
//! [`Studio`] is all of that for pictures without a window, as [`Image`]s; a [`Crowd`] draws thousands of bodies of a few assets. [`Level`] finds the spheres
//! of a tree at q, [`tightness`] colors them by their growth, [`Legend`] says what they mean.
//!
//! Everything is right-handed, y up unless a camera says otherwise, f32, relative to a point of the
//! caller's choice near the object. Colours are sRGB.
#![forbid(unsafe_code)]

mod camera;
mod crowd;
mod error;
mod framing;
mod gpu;
mod image;
mod legend;
mod level;
mod outline;
mod place;
mod readback;
mod renderer;
mod shading;
mod skinned;
mod studio;
mod text;
pub mod tightness;

pub use camera::{Box3, Camera, ViewDirection};
pub use crowd::{Body, Crowd, CrowdMemory, CrowdPicture, CrowdTexture, CrowdTimes, Shot};
pub use error::RenderError;
pub use framing::Framing;
pub use gpu::{Gpu, one_line};
pub use image::Image;
pub use legend::{Legend, draw_scale};
pub use level::{Level, NodeSphere, below};
pub use outline::{ball_outline, capsule_outline};
pub use place::Place;
pub use renderer::{Floor, Ground, Line, Mesh, Renderer, Scene, Sphere, texture};
pub use shading::{normals, smoothness};
pub use skinned::SkinnedMesh;
pub use studio::Studio;
pub use text::TextSize;
