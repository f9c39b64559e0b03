//! What `--fix` constrains, and which points those are.

pub(crate) mod fix;
pub(crate) mod hold;
pub(crate) mod hold_nodes;
pub(crate) mod node_list;
