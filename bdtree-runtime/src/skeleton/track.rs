//! The keys of one channel, and what they are between two of them (glTF 2.0, appendix C).

use bdtree_format::{ChannelRecord, interpolation};

use super::local::mix;
use super::rotation::{slerp, unit};
use crate::math::clamp;

/// Times and values of a channel; lengths fit each other.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Track<'a> {
    times: &'a [f32],
    /// Key by key.
    values: &'a [f32],
    /// Numbers of a value.
    components: usize,
    interpolation: u32,
}

/// Two keys and a place between them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span {
    before: usize,
    after: usize,
    /// 0 at the key before, 1 at the one after.
    pub(super) share: f64,
    /// From key to key.
    seconds: f64,
}

impl<'a> Track<'a> {
    /// The track of a channel; `None` where its numbers lie outside `keys`, it has none, or its kind is unknown.
    pub(crate) fn new(channel: &ChannelRecord, keys: &'a [f32]) -> Option<Self> {
        let components = channel.components()?;
        let count = channel.key_count as usize;
        let length = count
            .checked_mul(components)?
            .checked_mul(channel.values_per_key()?)?;
        let numbers = keys.get(channel.first_number as usize..)?;
        let (times, rest) = numbers.split_at_checked(count)?;
        Some(Self {
            times: (!times.is_empty()).then_some(times)?,
            values: rest.get(..length)?,
            components,
            interpolation: channel.interpolation,
        })
    }

    /// Seconds, one per key.
    pub(crate) fn times(&self) -> &'a [f32] {
        self.times
    }

    /// Values, key by key.
    pub(super) fn values(&self) -> &'a [f32] {
        self.values
    }

    /// Where a time lies among the keys: at the first before it, at the last behind it. `guess` is looked at first, and
    /// becomes the key after the time: channels of a clip mostly have the same times.
    pub(super) fn span(&self, time_s: f64, guess: &mut usize) -> Span {
        let at = |key: usize| self.times.get(key).map_or(0.0, |t| f64::from(*t));
        let is_guessed = (1..self.times.len()).contains(guess)
            && at(*guess - 1) <= time_s
            && at(*guess) > time_s;
        if !is_guessed {
            *guess = self.times.partition_point(|t| f64::from(*t) <= time_s);
        }
        let after = *guess;
        if after == 0 || after == self.times.len() {
            let key = after.saturating_sub(1);
            return Span {
                before: key,
                after: key,
                share: 0.0,
                seconds: 0.0,
            };
        }
        let before = after - 1;
        let seconds = at(after) - at(before);
        Span {
            before,
            after,
            share: clamp((time_s - at(before)) / seconds, 0.0, 1.0),
            seconds,
        }
    }

    /// A number of a key: `part` is 0, or of a spline 0 the in-tangent, 1 the value and 2 the out-tangent.
    fn number(&self, key: usize, part: usize, component: usize) -> f64 {
        let per_key = if self.interpolation == interpolation::CUBIC {
            3
        } else {
            1
        };
        let at = (key * per_key + part) * self.components + component;
        self.values.get(at).map_or(0.0, |x| f64::from(*x))
    }

    /// One number of the value at a place, by itself: not for rotations that are linear.
    pub(super) fn component(&self, span: Span, component: usize) -> f64 {
        let Span {
            before,
            after,
            share: t,
            seconds,
        } = span;
        match self.interpolation {
            interpolation::STEP => self.number(before, 0, component),
            interpolation::CUBIC => {
                let value = self.number(before, 1, component);
                if before == after {
                    return value;
                }
                let out = self.number(before, 2, component);
                let into = self.number(after, 0, component);
                let next = self.number(after, 1, component);
                let (t2, t3) = (t * t, t * t * t);
                (2.0 * t3 - 3.0 * t2 + 1.0) * value
                    + seconds * (t3 - 2.0 * t2 + t) * out
                    + (3.0 * t2 - 2.0 * t3) * next
                    + seconds * (t3 - t2) * into
            }
            _ => mix(
                self.number(before, 0, component),
                self.number(after, 0, component),
                t,
            ),
        }
    }

    /// Three numbers.
    pub(super) fn vector(&self, span: Span) -> [f64; 3] {
        // Spelled out: `array::map` is left as calls.
        [
            self.component(span, 0),
            self.component(span, 1),
            self.component(span, 2),
        ]
    }

    /// A unit quaternion.
    pub(super) fn rotation(&self, span: Span) -> [f64; 4] {
        if let Some([from, to]) = self.turn(span) {
            return slerp(from, to, span.share);
        }
        unit([0, 1, 2, 3].map(|k| self.component(span, k)))
    }

    /// The quaternions of both keys as they are, if what is between them is on an arc.
    #[inline]
    pub(super) fn turn(&self, span: Span) -> Option<[[f64; 4]; 2]> {
        let key = |key: usize| {
            let values = self.values.get(4 * key..)?;
            let [x, y, z, w] = *values.first_chunk()?;
            Some([f64::from(x), f64::from(y), f64::from(z), f64::from(w)])
        };
        if self.interpolation != interpolation::LINEAR || self.components != 4 {
            return None;
        }
        Some([key(span.before)?, key(span.after)?])
    }
}
