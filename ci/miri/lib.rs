//! What of the tests' library needs the runtime only.

#[path = "../../fixtures/src/ask/mod.rs"]
pub mod ask;
#[path = "../../fixtures/src/lanes.rs"]
pub mod lanes;
#[path = "../../fixtures/src/mutate/mod.rs"]
pub mod mutate;
#[path = "../../fixtures/src/poses.rs"]
pub mod poses;
#[path = "../../fixtures/src/sections.rs"]
pub mod sections;
