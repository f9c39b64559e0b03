//! The C interface, called as C calls it.

mod calls;
mod fuzz;
mod handles;
mod shared;
mod statuses;
mod worlds;
