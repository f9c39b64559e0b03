//! Measures what frames of Bevy with many deforming meshes take, and prints medians.
//!
//! Run in `bdtree-bevy`: `cargo run --release -p bdtree-bevy-speed`.

mod colliders;
mod hover;
mod models;
mod world;

fn main() {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    println!("{cores} cores; medians of {} frames\n", world::FRAMES);
    hover::measure();
    colliders::measure();
}
