//! A chair that vibrates.

use std::sync::OnceLock;

use bdtree_fixtures::bake;
use bdtree_runtime::Model;

/// The chair with six vibration modes; baked once.
pub(crate) fn chair() -> &'static Model {
    static CHAIR: OnceLock<Model> = OnceLock::new();
    CHAIR.get_or_init(|| bake::elastic("chair", 6, 30, &[]))
}
