//! Which version this is.
#![allow(unsafe_code)] // names of functions: docs/design/unsafe.md

use std::ffi::c_char;

/// Major version of the interface that the header describes.
pub const BDT_VERSION_MAJOR: u32 = 0;
/// Minor version: while the major one is 0, another minor version may change functions and structs.
pub const BDT_VERSION_MINOR: u32 = 1;
/// Patch version: changes neither functions nor structs.
pub const BDT_VERSION_PATCH: u32 = 0;

/// Returns the version of the library: major · 10^6 + minor · 10^3 + patch. Compare it with the header's
/// `BDT_VERSION_MAJOR` and `BDT_VERSION_MINOR`, which must be the same. Thread-safety: any thread, any time.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_version() -> u32 {
    BDT_VERSION_MAJOR * 1_000_000 + BDT_VERSION_MINOR * 1_000 + BDT_VERSION_PATCH
}

/// Returns the version of the library as text, for example "0.1.0": static, never NULL. Thread-safety: any thread, any
/// time.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_version_text() -> *const c_char {
    const TEXT: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");
    TEXT.as_ptr().cast()
}

/// Returns 1 if the library knows which handles live, so that freed and foreign ones return `BDT_STATUS_ERROR_HANDLE`
/// instead of being read: builds with debug assertions. Else 0. Thread-safety: any thread, any time.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_checks_handles() -> i32 {
    i32::from(cfg!(debug_assertions))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_constants_are_the_crates_version() {
        let text = format!("{BDT_VERSION_MAJOR}.{BDT_VERSION_MINOR}.{BDT_VERSION_PATCH}");
        assert_eq!(text, env!("CARGO_PKG_VERSION"));
        assert_eq!(bdt_version(), 1_000);
    }
}
