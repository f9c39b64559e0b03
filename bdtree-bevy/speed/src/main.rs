//! Measures what frames of Bevy with many deforming meshes take, and prints medians.
//!
//! Run in `bdtree-bevy`: `cargo run --release -p bdtree-bevy-speed`; with `-- hover` or `-- colliders` one of the tables.
//! `-- heap 24 7` measures each second of a heap of 24 chairs under avian instead, for seven seconds.

mod colliders;
mod heap;
mod hover;
mod models;
mod world;

fn main() {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    if let Some((name, rest)) = wanted.split_first()
        && name == "heap"
    {
        println!("{cores} cores");
        return heap::measure(rest);
    }
    println!("{cores} cores; medians of {} frames\n", world::FRAMES);
    for (name, measure) in [
        ("hover", hover::measure as fn()),
        ("colliders", colliders::measure),
    ] {
        if wanted.is_empty() || wanted.iter().any(|one| one == name) {
            measure();
        }
    }
}
