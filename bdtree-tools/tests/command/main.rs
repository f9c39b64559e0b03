//! The `bdtree` command as tests and pipelines see it: exit codes, streams, JSON fields.

mod deform;
mod diff;
mod frames;
mod hostile;
mod info;
mod oracle;
mod query;
mod scene_errors;
mod support;
mod usage;
mod verify;
