//! The surface: what hangs together, what is solid and what is a sheet.

pub(crate) mod components;
