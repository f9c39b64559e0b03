//! The report on an asset: what each choice costs and buys, measured on the asset itself.
//!
//! [`measure`] fills a [`content::Content`]; [`page`] and the JSON of `bdtree report` are made of it. Counts and errors
//! are the same in every run on processors of the same kind, times are not.

mod advice;
mod comparison;
pub mod content;
mod depth;
pub mod lanes;
mod made;
mod measure;
mod modes;
mod page;
mod poses;
mod sections;
mod text;
mod tightness;
mod verdict;
mod words;

pub use measure::{Margins, Subject, measure};
pub use page::{Picture, page};

/// Repetitions of which times are medians.
const REPETITIONS: usize = 5;
