//! Links `bdtree-runtime` without std and without a global allocator. A crate below this one that
//! links `alloc` fails the build ("no global memory allocator found"), one that links `std`
//! collides with the panic handler.
#![no_std]

use bdtree_runtime as _;

#[cfg(feature = "counter-example")]
extern crate alloc;

#[cfg(feature = "counter-example")]
#[unsafe(no_mangle)]
extern "C" fn allocate(count: usize) -> usize {
    alloc::vec![0_u8; count].len()
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}
