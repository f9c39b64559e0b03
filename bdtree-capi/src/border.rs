//! What crosses the border between C and Rust: pointers become references here and nowhere else.
//!
//! Arguments have types of the layout of a pointer ([`Handle`], [`In`], [`Out`]), which the header shows as plain
//! pointers. Rust makes them only by `unsafe` constructors, whose promise is the one that the header asks of C; so the
//! functions of the interface need no `unsafe` of their own.
#![allow(unsafe_code)] // pointers become references here: docs/design/unsafe.md

use std::cell::UnsafeCell;
use std::ffi::{CStr, c_char};
use std::mem::{ManuallyDrop, MaybeUninit};
use std::ops::{Deref, DerefMut};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr;
use std::sync::atomic::{AtomicI32, AtomicU64, Ordering};

use zerocopy::FromBytes;

use crate::registry;
use crate::status::{BdtStatus, Fault, remember};

/// Runs the body of a function of the interface: no panic leaves it, and what went wrong is remembered for
/// `bdt_last_error`.
#[inline]
pub(crate) fn call(body: impl FnOnce() -> Result<BdtStatus, Fault>) -> BdtStatus {
    match catch_unwind(AssertUnwindSafe(body)) {
        Ok(Ok(status)) => status,
        Ok(Err(fault)) => remember(fault),
        Err(payload) => remember(Fault::of_panic(payload.as_ref())),
    }
}

/// The same for what has nothing else to say.
#[inline]
pub(crate) fn done(body: impl FnOnce() -> Result<(), Fault>) -> BdtStatus {
    call(|| body().map(|()| BdtStatus::Ok))
}

/// What a handle stands for.
pub trait Kind {
    /// What it owns.
    type Value;
    /// The first word of its memory while it lives.
    const TAG: u64;
    /// What errors call it.
    const NAME: &'static str;
}

/// In place of the tag once a handle is freed.
const FREED: u64 = u64::from_le_bytes(*b"bdtFREED");

/// A call has it for itself.
const TAKEN: i32 = -1;

/// The memory of a handle.
#[repr(C)]
struct Slot<V> {
    tag: AtomicU64,
    /// [`TAKEN`], or how many calls with callbacks read it.
    users: AtomicI32,
    value: UnsafeCell<ManuallyDrop<V>>,
}

/// A pointer to an opaque object of this library.
#[repr(transparent)]
pub struct Handle<K>(*mut K);

impl<K: Kind> Handle<K> {
    /// The handle at an address.
    ///
    /// # Safety
    /// NULL, or a handle of this kind that this library made, that nobody has freed, and that is used as the header
    /// says: by one thread at a time where a function does not say otherwise. With debug assertions any address will do.
    pub const unsafe fn new(address: *mut K) -> Self {
        Self(address)
    }

    /// Its address.
    pub const fn address(&self) -> *mut K {
        self.0
    }

    /// Makes a new one. The caller of the function frees it.
    pub(crate) fn make(value: K::Value) -> *mut K {
        let slot = Box::new(Slot {
            tag: AtomicU64::new(K::TAG),
            users: AtomicI32::new(0),
            value: UnsafeCell::new(ManuallyDrop::new(value)),
        });
        let address = Box::into_raw(slot).cast::<K>();
        registry::add(address.addr(), K::TAG);
        address
    }

    #[inline]
    fn slot(&self) -> Result<&Slot<K::Value>, Fault> {
        if self.0.is_null() {
            return Err(Fault::Null(K::NAME));
        }
        let slot = self.0.cast::<Slot<K::Value>>();
        if !slot.is_aligned() || !registry::lives(slot.addr(), K::TAG) {
            return Err(Fault::Handle(K::NAME));
        }
        // SAFETY: by the promise of `new` this is a slot that `make` allocated and nobody has freed; with debug
        // assertions the registry knows it, whatever was promised. All of it but the value is atomic, and the value is
        // in an UnsafeCell, so a shared reference excludes nothing.
        let slot = unsafe { &*slot };
        if slot.tag.load(Ordering::Relaxed) != K::TAG {
            return Err(Fault::Handle(K::NAME));
        }
        Ok(slot)
    }

    /// To read, in a call without callbacks.
    #[inline]
    pub(crate) fn shared(&self) -> Result<&K::Value, Fault> {
        let slot = self.slot()?;
        if slot.users.load(Ordering::Relaxed) == TAKEN {
            return Err(Fault::Busy(K::NAME));
        }
        // SAFETY: no call has it for itself: by the promise of `new` no other thread has while this one reads, and this
        // thread, which calls nothing of the program's until the reference ends, is not in `exclusive`.
        Ok(unsafe { &*slot.value.get() })
    }

    /// To read. In a call with callbacks they may read it too, but not change or free it.
    #[inline]
    pub(crate) fn reading(&self, has_callbacks: bool) -> Result<Reading<'_, K::Value>, Fault> {
        let value = self.shared()?;
        let users = has_callbacks.then_some(&self.slot()?.users);
        if let Some(users) = users {
            users.fetch_add(1, Ordering::Relaxed);
        }
        Ok(Reading { value, users })
    }

    /// For this call alone.
    #[inline]
    pub(crate) fn exclusive(&self) -> Result<Exclusive<'_, K::Value>, Fault> {
        let slot = self.slot()?;
        if slot.users.load(Ordering::Relaxed) != 0 {
            return Err(Fault::Busy(K::NAME));
        }
        slot.users.store(TAKEN, Ordering::Relaxed);
        // SAFETY: nobody reads or has it, as was just asked, and until the guard ends everybody else is refused. That
        // another thread does not ask at the same time is the promise of `new`.
        let value = unsafe { &mut *slot.value.get() };
        Ok(Exclusive {
            value,
            users: &slot.users,
        })
    }

    /// Drops what it owns. NULL is nothing.
    pub(crate) fn free(self) -> Result<(), Fault> {
        if self.0.is_null() {
            return Ok(());
        }
        let slot = self.slot()?;
        if slot.users.load(Ordering::Relaxed) != 0 {
            return Err(Fault::Busy(K::NAME));
        }
        slot.tag.store(FREED, Ordering::Relaxed);
        // SAFETY: nobody reads or has it, and with another tag nobody will.
        let value = unsafe { &mut *slot.value.get() };
        // SAFETY: the value is dropped once: behind another tag nobody comes here again.
        unsafe { ManuallyDrop::drop(value) };
        // Where handles are checked, an address is not given out again.
        if registry::free(self.0.addr()) {
            // SAFETY: `make` took it out of a Box of this type; the ManuallyDrop keeps the value from being dropped
            // again.
            drop(unsafe { Box::from_raw(self.0.cast::<Slot<K::Value>>()) });
        }
        Ok(())
    }
}

/// A value that a call reads.
pub(crate) struct Reading<'h, V> {
    value: &'h V,
    users: Option<&'h AtomicI32>,
}

impl<V> Deref for Reading<'_, V> {
    type Target = V;

    #[inline]
    fn deref(&self) -> &V {
        self.value
    }
}

impl<V> Drop for Reading<'_, V> {
    #[inline]
    fn drop(&mut self) {
        if let Some(users) = self.users {
            users.fetch_sub(1, Ordering::Relaxed);
        }
    }
}

/// A value that a call has for itself.
pub(crate) struct Exclusive<'h, V> {
    value: &'h mut V,
    users: &'h AtomicI32,
}

impl<V> Deref for Exclusive<'_, V> {
    type Target = V;

    #[inline]
    fn deref(&self) -> &V {
        self.value
    }
}

impl<V> DerefMut for Exclusive<'_, V> {
    #[inline]
    fn deref_mut(&mut self) -> &mut V {
        self.value
    }
}

impl<V> Drop for Exclusive<'_, V> {
    #[inline]
    fn drop(&mut self) {
        self.users.store(0, Ordering::Relaxed);
    }
}

/// A pointer to values of the caller's that a function reads: one, or as many as an argument beside it says.
#[repr(transparent)]
pub struct In<T>(*const T);

impl<T> In<T> {
    /// Values at an address.
    ///
    /// # Safety
    /// NULL, or so many values as the function is told to read (one where it is told nothing; a text up to its 0), which
    /// nobody changes meanwhile.
    pub const unsafe fn new(address: *const T) -> Self {
        Self(address)
    }

    /// Whether it is NULL.
    pub(crate) fn is_null(&self) -> bool {
        self.0.is_null()
    }

    #[inline]
    fn checked(&self, name: &'static str) -> Result<*const T, Fault> {
        if self.0.is_null() {
            return Err(Fault::Null(name));
        }
        if !self.0.is_aligned() {
            return Err(Fault::Unaligned(name));
        }
        Ok(self.0)
    }
}

impl<T: FromBytes> In<T> {
    /// The one value.
    #[inline]
    pub(crate) fn one(&self, name: &'static str) -> Result<&T, Fault> {
        let address = self.checked(name)?;
        // SAFETY: by the promise of `new` a value is there that nobody changes; it is aligned, and any bytes are a `T`.
        Ok(unsafe { &*address })
    }

    /// `count` values; NULL is no value.
    pub(crate) fn many(&self, count: usize, name: &'static str) -> Result<&[T], Fault> {
        if count == 0 {
            return Ok(&[]);
        }
        let address = self.checked(name)?;
        fits::<T>(count, name)?;
        // SAFETY: by the promise of `new` so many values are there that nobody changes; they are aligned, any bytes are a
        // `T`, and their size is below isize::MAX.
        Ok(unsafe { std::slice::from_raw_parts(address, count) })
    }
}

impl<K> In<Handle<K>> {
    /// `count` handles, each of which may be NULL.
    pub(crate) fn handles(&self, count: usize, name: &'static str) -> Result<&[Handle<K>], Fault> {
        if count == 0 {
            return Ok(&[]);
        }
        let address = self.checked(name)?;
        fits::<Handle<K>>(count, name)?;
        // SAFETY: as in `many`: any bytes are a pointer, and that it is a handle was promised with it.
        Ok(unsafe { std::slice::from_raw_parts(address, count) })
    }
}

impl In<c_char> {
    /// A text in UTF-8.
    pub(crate) fn text(&self, name: &'static str) -> Result<&str, Fault> {
        let address = self.checked(name)?;
        // SAFETY: by the promise of `new` a text with a 0 at its end is there, which nobody changes.
        let text = unsafe { CStr::from_ptr(address) };
        text.to_str().map_err(|_| Fault::Text(name))
    }
}

/// A pointer to memory of the caller's that a function writes: one value, or as many as an argument beside it says.
#[repr(transparent)]
pub struct Out<T>(*mut T);

impl<T> Out<T> {
    /// Memory at an address.
    ///
    /// # Safety
    /// NULL, or memory of the caller's for so many values as the function is told to write (one where it is told
    /// nothing), which nobody else reads or writes meanwhile, and which is no other argument's. Where a function says
    /// that it reads or changes them, they have been written before.
    pub const unsafe fn new(address: *mut T) -> Self {
        Self(address)
    }

    /// Whether it is NULL.
    pub(crate) fn is_null(&self) -> bool {
        self.0.is_null()
    }

    #[inline]
    fn checked(&self, name: &'static str) -> Result<*mut T, Fault> {
        if self.0.is_null() {
            return Err(Fault::Null(name));
        }
        if !self.0.is_aligned() {
            return Err(Fault::Unaligned(name));
        }
        Ok(self.0)
    }

    /// Room for the one value.
    #[inline]
    pub(crate) fn one(&mut self, name: &'static str) -> Result<&mut MaybeUninit<T>, Fault> {
        let address = self.checked(name)?.cast::<MaybeUninit<T>>();
        // SAFETY: by the promise of `new` there is room for a value that nobody else uses; it is aligned, and a
        // MaybeUninit needs no value.
        Ok(unsafe { &mut *address })
    }

    /// Room for the one value, if the caller wants it.
    #[inline]
    pub(crate) fn optional(
        &mut self,
        name: &'static str,
    ) -> Result<Option<&mut MaybeUninit<T>>, Fault> {
        if self.is_null() {
            return Ok(None);
        }
        self.one(name).map(Some)
    }

    /// Room for `count` values; NULL is no room.
    #[inline]
    pub(crate) fn many(
        &mut self,
        count: usize,
        name: &'static str,
    ) -> Result<&mut [MaybeUninit<T>], Fault> {
        if count == 0 {
            return Ok(&mut []);
        }
        let address = self.checked(name)?.cast::<MaybeUninit<T>>();
        fits::<T>(count, name)?;
        // SAFETY: by the promise of `new` there is room for so many values that nobody else uses; it is aligned, a
        // MaybeUninit needs no value, and its size is below isize::MAX.
        Ok(unsafe { std::slice::from_raw_parts_mut(address, count) })
    }
}

impl<T: FromBytes> Out<T> {
    /// `count` values that are there already, to be read and changed; NULL is no value.
    pub(crate) fn values(&mut self, count: usize, name: &'static str) -> Result<&mut [T], Fault> {
        if count == 0 {
            return Ok(&mut []);
        }
        let address = self.checked(name)?;
        fits::<T>(count, name)?;
        // SAFETY: as in `many`; by the promise of `new` they have been written, and any bytes are a `T`.
        Ok(unsafe { std::slice::from_raw_parts_mut(address, count) })
    }
}

/// A count that no memory can hold is a mistake of the caller's.
#[inline]
fn fits<T>(count: usize, name: &'static str) -> Result<(), Fault> {
    match count.checked_mul(size_of::<T>()) {
        Some(bytes) if bytes <= isize::MAX as usize => Ok(()),
        _ => Err(Fault::Count(name)),
    }
}

/// A pointer that a function writes to give a new handle away: NULL unless it succeeds.
pub(crate) fn give<K: Kind>(
    out: &mut Out<*mut K>,
    make: impl FnOnce() -> Result<K::Value, Fault>,
) -> BdtStatus {
    done(|| {
        let out = out.one("out")?;
        let out = out.write(ptr::null_mut());
        *out = Handle::<K>::make(make()?);
        Ok(())
    })
}
