//! What of the tests' library needs the runtime only.

#[path = "../../tests/src/ask/mod.rs"]
pub mod ask;
#[path = "../../tests/src/lanes.rs"]
pub mod lanes;
#[path = "../../tests/src/mutate/mod.rs"]
pub mod mutate;
#[path = "../../tests/src/poses.rs"]
pub mod poses;
#[path = "../../tests/src/sections.rs"]
pub mod sections;
