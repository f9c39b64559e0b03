//! Which handles live, in builds with debug assertions: there a foreign or freed pointer is told without reading it.

#[cfg(debug_assertions)]
use std::collections::HashMap;
#[cfg(debug_assertions)]
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

/// By address: the tag of a handle that lives, 0 of one that was freed. The memory of those is kept, so that no other
/// handle comes to lie there.
#[cfg(debug_assertions)]
fn handles() -> MutexGuard<'static, HashMap<usize, u64>> {
    static HANDLES: OnceLock<Mutex<HashMap<usize, u64>>> = OnceLock::new();
    let handles = HANDLES.get_or_init(Mutex::default);
    // Nothing panics while it is locked.
    handles.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A handle was made.
pub(crate) fn add(_address: usize, _tag: u64) {
    #[cfg(debug_assertions)]
    handles().insert(_address, _tag);
}

/// Whether a handle of this kind is there; always true where nobody keeps account.
#[inline]
pub(crate) fn lives(_address: usize, _tag: u64) -> bool {
    #[cfg(debug_assertions)]
    return handles().get(&_address) == Some(&_tag);
    #[cfg(not(debug_assertions))]
    true
}

/// A handle was freed; whether its memory is to be given back.
pub(crate) fn free(_address: usize) -> bool {
    #[cfg(debug_assertions)]
    {
        handles().insert(_address, 0);
        false
    }
    #[cfg(not(debug_assertions))]
    true
}
