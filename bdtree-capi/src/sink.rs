//! Where answers go: arrays of the caller's and callbacks.

use std::ffi::{c_char, c_void};
use std::mem::MaybeUninit;
use std::ops::ControlFlow;

use bdtree_runtime::Sink;

use crate::border::{In, Out};
use crate::status::{BdtStatus, Fault};

/// An array of the caller's: takes what fits and counts the rest.
pub(crate) struct Array<'s, C> {
    slots: &'s mut [MaybeUninit<C>],
    count: usize,
}

impl<'s, C> Array<'s, C> {
    /// The array and where its count goes, which must be there.
    pub(crate) fn new(
        out: &'s mut Out<C>,
        capacity: usize,
        count: &mut Out<usize>,
    ) -> Result<Self, Fault> {
        count.one("count")?.write(0);
        let slots = out.many(capacity, "out")?;
        Ok(Self { slots, count: 0 })
    }

    pub(crate) fn put(&mut self, item: C) {
        if let Some(slot) = self.slots.get_mut(self.count) {
            slot.write(item);
        }
        self.count += 1;
    }

    /// Tells how many there are.
    pub(crate) fn end(self, count: &mut Out<usize>) -> Result<BdtStatus, Fault> {
        count.one("count")?.write(self.count);
        Ok(if self.count > self.slots.len() {
            BdtStatus::Truncated
        } else {
            BdtStatus::Ok
        })
    }
}

impl<T, C: From<T>> Sink<T> for Array<'_, C> {
    #[inline]
    fn push(&mut self, item: T) -> ControlFlow<()> {
        self.put(item.into());
        ControlFlow::Continue(())
    }
}

/// Writes items to an array of the caller's.
pub(crate) fn put_items<C>(
    items: impl IntoIterator<Item = C>,
    out: &mut Out<C>,
    capacity: usize,
    count: &mut Out<usize>,
) -> Result<BdtStatus, Fault> {
    let mut array = Array::new(out, capacity, count)?;
    items.into_iter().for_each(|item| array.put(item));
    array.end(count)
}

/// Writes a text with a 0 behind it, cut between two characters where it is too long.
pub(crate) fn put_text(
    text: &str,
    buffer: &mut Out<c_char>,
    capacity: usize,
    length: &mut Out<usize>,
) -> Result<BdtStatus, Fault> {
    if let Some(length) = length.optional("length")? {
        length.write(text.len());
    }
    let slots = buffer.many(capacity, "buffer")?;
    let Some(room) = capacity.checked_sub(1) else {
        return Ok(BdtStatus::Truncated);
    };
    let kept = text.floor_char_boundary(room);
    let bytes = text.as_bytes().iter().take(kept).chain([&0]);
    for (slot, byte) in slots.iter_mut().zip(bytes) {
        slot.write(byte.cast_signed() as c_char);
    }
    Ok(if kept < text.len() {
        BdtStatus::Truncated
    } else {
        BdtStatus::Ok
    })
}

/// Writes exactly as many values as there are.
pub(crate) fn put_all<C: Copy, T: Copy + Into<C>>(
    what: &'static str,
    values: &[T],
    out: &mut Out<C>,
    found: usize,
) -> Result<(), Fault> {
    same_length(what, values.len(), found)?;
    let slots = out.many(found, "out")?;
    for (slot, value) in slots.iter_mut().zip(values) {
        slot.write((*value).into());
    }
    Ok(())
}

pub(crate) fn same_length(what: &'static str, expected: usize, found: usize) -> Result<(), Fault> {
    if expected == found {
        return Ok(());
    }
    Err(Fault::Length {
        what,
        expected,
        found,
    })
}

/// Hands every item to a function of the caller's, until it returns another number than 0.
pub(crate) struct Callback<C> {
    function: extern "C" fn(*const C, *mut c_void) -> i32,
    context: *mut c_void,
    is_stopped: bool,
}

impl<C> Callback<C> {
    pub(crate) fn new(
        function: Option<extern "C" fn(*const C, *mut c_void) -> i32>,
        context: *mut c_void,
    ) -> Result<Self, Fault> {
        Ok(Self {
            function: function.ok_or(Fault::Null("callback"))?,
            context,
            is_stopped: false,
        })
    }

    pub(crate) fn end(self) -> BdtStatus {
        if self.is_stopped {
            BdtStatus::Stopped
        } else {
            BdtStatus::Ok
        }
    }
}

impl<T, C: From<T>> Sink<T> for Callback<C> {
    fn push(&mut self, item: T) -> ControlFlow<()> {
        let item = C::from(item);
        if (self.function)(&raw const item, self.context) == 0 {
            return ControlFlow::Continue(());
        }
        self.is_stopped = true;
        ControlFlow::Break(())
    }
}

/// `count` values of the caller's, turned into the runtime's.
pub(crate) fn converted<C: Copy + zerocopy::FromBytes, T: From<C>>(
    values: &In<C>,
    count: usize,
    name: &'static str,
) -> Result<Vec<T>, Fault> {
    Ok(values
        .many(count, name)?
        .iter()
        .map(|value| T::from(*value))
        .collect())
}
