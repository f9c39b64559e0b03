//! Embedding a file in a program, aligned.

/// Bytes at a multiple of 64, for [`crate::include_bdt!`].
#[doc(hidden)]
#[repr(C, align(64))]
pub struct Aligned<T: ?Sized>(pub T);

/// The bytes of a `.bdt` file, embedded at compile time and 64-byte aligned
/// (`&'static [u8]`); the path is relative to the calling source file.
#[macro_export]
macro_rules! include_bdt {
    ($path:expr) => {{
        static BYTES: &$crate::embed::Aligned<[u8]> =
            &$crate::embed::Aligned(*::core::include_bytes!($path));
        &BYTES.0 as &'static [u8]
    }};
}
