//! The `bdtree` command as tests and pipelines see it: exit codes, streams, JSON fields.

mod deform;
mod diff;
#[cfg(feature = "render")]
mod drawn;
mod frames;
mod golden;
mod hostile;
mod info;
mod mass;
mod near;
mod oracle;
mod query;
#[cfg(feature = "render")]
mod render;
#[cfg(feature = "report")]
mod report;
mod scene_errors;
mod shapes;
mod support;
mod usage;
mod verify;
#[cfg(unix)]
mod view;
#[cfg(target_os = "linux")]
mod writing;
