//! Parts of a vertex buffer that a shader may bind.

use std::ops::Range;

/// A part of a buffer and the items within it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Window {
    /// Where it begins in the buffer (bytes), a multiple of the alignment.
    pub(crate) start: u64,
    /// Bytes.
    pub(crate) len: u64,
    pub(crate) items: Range<usize>,
}

/// Splits items (ranges of bytes, ascending and apart) into windows of at most `limit` bytes that begin at multiples of
/// `align`. The first item that fits none is the error.
pub(crate) fn windows(items: &[Range<u64>], limit: u64, align: u64) -> Result<Vec<Window>, usize> {
    let mut all: Vec<Window> = Vec::new();
    for (k, item) in items.iter().enumerate() {
        if let Some(last) = all.last_mut()
            && item.end - last.start <= limit
        {
            last.len = item.end - last.start;
            last.items.end = k + 1;
            continue;
        }
        let start = item.start - item.start % align.max(1);
        if item.end - start > limit {
            return Err(k);
        }
        all.push(Window {
            start,
            len: item.end - start,
            items: k..k + 1,
        });
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_aligned_within_the_limit_and_hold_every_item_once() {
        let mut items = Vec::new();
        let mut at = 0_u64;
        for k in 0..500_u64 {
            at += 24 * (k % 7);
            let len = 24 * (1 + (k * k) % 40);
            items.push(at..at + len);
            at += len;
        }
        for limit in [1300, 4096, 100_000, 1 << 30] {
            let all = windows(&items, limit, 256).unwrap();
            let mut next = 0;
            for window in &all {
                assert_eq!(window.items.start, next);
                next = window.items.end;
                assert!(window.start % 256 == 0 && window.len <= limit);
                for item in &items[window.items.clone()] {
                    assert!(window.start <= item.start);
                    assert!(item.end <= window.start + window.len);
                }
            }
            assert_eq!(next, items.len());
            assert!(limit < 1 << 30 || all.len() == 1);
        }
    }

    #[test]
    fn an_item_that_fits_no_window_is_named() {
        assert_eq!(windows(&[0..100, 100..500], 300, 256), Err(1));
    }
}
