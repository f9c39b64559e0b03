//! What `--fix` constrains, and which points those are.

pub(crate) mod fix;
pub(crate) mod node_list;
pub(crate) mod nodes;
pub(crate) mod region;
