//! Panics of the `gltf` crate become errors, without a word on stderr.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

thread_local! {
    /// Panics of this thread are not reported.
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

/// The result of `f`, or the message of the panic that ended it. Nothing is printed.
///
/// The first call puts a hook before the process's panic hook; it keeps silent only while this
/// function runs on the panicking thread and hands every other panic on. (Where panics abort, they
/// still do.)
pub(super) fn contained<T>(f: impl FnOnce() -> T) -> Result<T, String> {
    static HOOK: Once = Once::new();
    // The hook cannot be changed by a thread that panics already.
    if !std::thread::panicking() {
        HOOK.call_once(|| {
            let before = panic::take_hook();
            panic::set_hook(Box::new(move |info| {
                if !QUIET.get() {
                    before(info);
                }
            }));
        });
    }
    let outer = QUIET.replace(true);
    let result = panic::catch_unwind(AssertUnwindSafe(f));
    QUIET.set(outer);
    result.map_err(|payload| {
        let text = payload.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| payload.downcast_ref::<&str>().copied());
        text.unwrap_or("unknown cause").to_string()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn contained_panics_are_silent_and_others_are_not() {
        let heard = Arc::new(AtomicUsize::new(0));
        let before = panic::take_hook();
        let ear = Arc::clone(&heard);
        let this = std::thread::current().id();
        // Only the panics of this test count: others run beside it.
        panic::set_hook(Box::new(move |info| {
            let name = std::thread::current().name().map(str::to_string);
            if std::thread::current().id() == this || name.as_deref() == Some("beside") {
                ear.fetch_add(1, Ordering::SeqCst);
            } else {
                before(info);
            }
        }));
        assert_eq!(contained(|| 7), Ok(7));
        assert_eq!(
            contained(|| panic!("at {}", 3)),
            Err::<(), _>("at 3".into())
        );
        assert_eq!(contained(|| panic!("bare")), Err::<(), _>("bare".into()));
        assert_eq!(heard.load(Ordering::SeqCst), 0);
        let beside = || {
            let thread = std::thread::Builder::new().name("beside".into());
            thread.spawn(|| panic!("heard")).expect("thread").join()
        };
        assert_eq!(contained(|| beside().is_err()), Ok(true));
        assert_eq!(heard.load(Ordering::SeqCst), 1);
        assert!(panic::catch_unwind(|| panic!("heard too")).is_err());
        assert_eq!(heard.load(Ordering::SeqCst), 2);
    }
}
