//! Bakes a mesh and its deformation basis into a `.bdt` file.
//!
//! A [`Recipe`] says where the mesh comes from, what moves it and how the file is made; [`bake`] does it. A chair with
//! the ten lowest modes of its body:
//!
//! ```
//! use bdtree_build::progress::Silent;
//! use bdtree_build::recipe::{Elastic, Motion, Recipe};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! # let output = folder.path().join("chair.bdt");
//! # let chair = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/chair.obj");
//! let mut elastic = Elastic::default(); // ten modes of a stiff plastic
//! elastic.options.resolution = Some(24); // coarse and quick
//! let recipe = Recipe::of_surface(chair, Motion::Elastic(elastic));
//! let baked = bdtree_build::bake(&recipe, &Silent)?;
//! assert_eq!(baked.report.modes, 10);
//! baked.write(&output)?;
//! # Ok(())
//! # }
//! ```
//!
//! Mesh and fields that are in memory already go to [`bake_fields`]. What is wrong is a
//! [`BakeError`]: every problem, each with its [`Place`](error::Place).
//!
//! Flow: [`recipe`] → [`input`] → [`basis`] (with [`elastic`] below it) → [`wrap::store`] (with [`skin::store`]) → [`tree`] → [`wrap`](mod@wrap)
//! → [`encode`](mod@encode) → [`report`] → [`bdtree_output`].

pub mod advise;
pub mod basis;
mod disjoint_sets;
pub mod elastic;
pub mod encode;
pub mod error;
#[doc(hidden)]
pub mod figures;
pub mod input;
pub mod mass;
mod motion;
mod parallel;
pub mod pipeline;
pub mod progress;
pub mod recipe;
pub mod report;
pub mod skin;
pub mod tree;
mod vec3;
mod words;
pub mod wrap;

pub use error::BakeError;
pub use pipeline::{BakeSettings, Baked, Provenance, bake, bake_fields, bake_skinned};
pub use recipe::Recipe;
