//! Files that are damaged on purpose: opened, verified, and [asked everything](crate::ask), by the
//! million.
//!
//! What must hold of any bytes whatever: no panic, no error without a place, no query that visits more
//! than its file's counts allow. Of a file that `verify` passes: every query answers, and answers what
//! brute force answers. Of numbers changed under valid checksums: `verify` refuses exactly where a
//! bound no longer holds, as [`judge`](crate::judge) finds on its own.

mod case;
mod run;
mod sound;
mod sources;
mod watchdog;

pub use case::{Case, Examined};
pub use run::{Run, Summary};
pub use sources::Sources;
pub use watchdog::Watchdog;
