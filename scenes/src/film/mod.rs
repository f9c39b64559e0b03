//! What makes pictures and films of many bodies: [`Heap`] is a heap of them that stands still, [`PALETTE`] and [`view`]
//! are the look that all films share, [`Frames`] writes a film's pictures into a folder and [`film_command`] says how
//! they become a film. [`bdtree_render::Crowd`] draws them.

mod command;
mod frames;
mod heap;
mod look;

pub use command::film_command;
pub use frames::Frames;
pub use heap::Heap;
pub use look::{BACKGROUND, FLOOR, PALETTE, RED, colour, colour_of, sphere_wires, view};
