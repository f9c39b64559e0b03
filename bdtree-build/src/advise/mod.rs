//! What to bake with, from measurements on the asset itself: how many of its modes its motion needs, and how
//! many triangles a leaf takes.
//!
//! [`samples`] says at which q an asset is judged, [`works`] what is asked of it there; both take an opened
//! asset and serve everything that measures one.

pub mod errors;
pub mod samples;
pub mod subject;
pub mod works;
