//! One C interface over `bdtree-runtime` and the worlds of `bdtree-dynamics`: the header `include/bdtree.h`, the shared
//! library `libbdtree.so` and the static one `libbdtree.a`.
//!
//! The header says what each function does; it is made from the comments here by `ci/header`. Rust programs use
//! `bdtree-runtime` itself.
//!
//! | file | what it has |
//! |---|---|
//! | `border` | pointers become references: all `unsafe` but the names of functions |
//! | `registry` | which handles live, with debug assertions |
//! | `status`, `sink` | what functions return, where answers go |
//! | `types`, `answers` | plain structs |
//! | `model`, `names`, `instance`, `skeleton`, `workspace` | handles and what can be read and set |
//! | `query`, `batch`, `pair`, `broad` | questions |
//! | `world`, `world_types`, `body` | worlds |

pub mod answers;
pub mod batch;
pub mod body;
pub mod border;
pub mod broad;
pub mod instance;
pub mod model;
pub mod names;
pub mod pair;
pub mod query;
mod ray_blocks;
mod registry;
mod sink;
pub mod skeleton;
pub mod status;
pub mod types;
pub mod version;
pub mod workspace;
pub mod world;
pub mod world_types;
