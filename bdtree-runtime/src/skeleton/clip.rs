//! Clips: what the source animates, by time (SPEC 7.9).

use bdtree_format::{ChannelRecord, ClipRecord, SectionKind, channel_path};
use core::mem::size_of;

use super::error::{SkeletonError, same_length};
use super::rotation::{KEYS, Slerps};
use super::track::{Span, Track};
use super::{LocalTransform, Skeleton};
use crate::error::{Datum, FormatError};
use crate::simd::Kernel;
use crate::verify::{self, CHANNELS, TARGETS};

/// An animation of the skeleton and of q.
#[derive(Debug, Clone, Copy)]
pub struct Clip<'a> {
    skeleton: Skeleton<'a>,
    record: &'a ClipRecord,
}

/// What moves one thing in a clip: a node's translation, rotation or scale, or the weights of modes.
#[derive(Debug, Clone, Copy)]
pub struct Channel<'a> {
    record: &'a ChannelRecord,
    track: Track<'a>,
}

impl<'a> Channel<'a> {
    /// What is animated, and how values between keys are found.
    pub fn record(&self) -> &'a ChannelRecord {
        self.record
    }

    /// Seconds of the keys; ascending in a verified file.
    pub fn times_s(&self) -> &'a [f32] {
        self.track.times()
    }

    /// Values, key by key: [`ChannelRecord::values_per_key`] of [`ChannelRecord::components`] numbers each.
    pub fn values(&self) -> &'a [f32] {
        self.track.values()
    }
}

impl<'a> Clip<'a> {
    pub(super) fn new(skeleton: Skeleton<'a>, record: &'a ClipRecord) -> Self {
        Self { skeleton, record }
    }

    /// The source's name; empty when it has none.
    pub fn name(&self) -> &'a str {
        let (start, bytes) = (self.record.name_start.get(), self.record.name_bytes.get());
        self.skeleton.skin.name(start, bytes)
    }

    /// Seconds from time 0 to the last key. A loop is `time % duration`.
    pub fn duration_s(&self) -> f64 {
        self.record.duration_s.get()
    }

    /// The pose at a time: rest where the clip animates nothing, q 0 where it does not animate the mode. Before the
    /// first key of a channel its first value holds, after the last one the last.
    ///
    /// # Errors
    /// A time that is not finite; `locals` of another length than [`Skeleton::node_count`], `q` of another than the
    /// asset has modes; a file that breaks the format's rules.
    pub fn sample(
        &self,
        time_s: f64,
        locals: &mut [LocalTransform],
        q: &mut [f32],
    ) -> Result<(), SkeletonError> {
        self.skeleton.rest(locals)?;
        q.fill(0.0);
        self.sample_over(time_s, locals, q)
    }

    /// The same over what is there: what the clip does not animate stays as `locals` and `q` are, which lets programs
    /// give their own pose at rest or defaults of q, and play one clip over another.
    ///
    /// # Errors
    /// Those of [`Clip::sample`]; what was written before one stays.
    pub fn sample_over(
        &self,
        time_s: f64,
        locals: &mut [LocalTransform],
        q: &mut [f32],
    ) -> Result<(), SkeletonError> {
        same_length("local transforms", self.skeleton.node_count(), locals.len())?;
        same_length("entries of q", self.skeleton.asset.mode_count(), q.len())?;
        if !time_s.is_finite() {
            return Err(SkeletonError::Time);
        }
        let mut turns = Turns::new(self.skeleton.asset.kernel);
        let mut guess = 0;
        for (k, record) in self.channels()?.iter().enumerate() {
            let channel = self.with_keys(k, record)?;
            let span = channel.track.span(time_s, &mut guess);
            play(&channel, span, locals, q, &mut turns).ok_or_else(|| self.broken(k, TARGETS))?;
        }
        turns.write(locals);
        Ok(())
    }

    /// Number of channels.
    pub fn channel_count(&self) -> usize {
        self.record.channel_count.get() as usize
    }

    /// A channel, counted from 0. That its target exists is checked where it is played ([`Clip::sample`]).
    ///
    /// # Errors
    /// No such channel; records or keys outside of the file, keys of an unknown kind.
    pub fn channel(&self, index: usize) -> Result<Channel<'a>, FormatError> {
        let own = self.channels()?;
        let record = own.get(index).ok_or_else(|| {
            let place = self.skeleton.asset.at(SectionKind::CLIPS, 0);
            place
                .rule(CHANNELS)
                .broken(Datum::Below(own.len() as u64), index)
        })?;
        self.with_keys(index, record)
    }

    fn with_keys(
        &self,
        index: usize,
        record: &'a ChannelRecord,
    ) -> Result<Channel<'a>, FormatError> {
        let track = Track::new(record, self.skeleton.skin.keys);
        let track = track.ok_or_else(|| self.broken(index, verify::KEYS))?;
        Ok(Channel { record, track })
    }

    fn channels(&self) -> Result<&'a [ChannelRecord], FormatError> {
        let first = self.record.first_channel.get() as usize;
        let end = first.saturating_add(self.record.channel_count.get() as usize);
        let all = self.skeleton.skin.channels;
        all.get(first..end).ok_or_else(|| {
            let place = self.skeleton.asset.at(SectionKind::CLIPS, 0);
            place.rule(CHANNELS).broken(Datum::at_most(all.len()), end)
        })
    }

    #[cold]
    fn broken(&self, index: usize, rule: &'static str) -> FormatError {
        let channel = (self.record.first_channel.get() as usize).saturating_add(index);
        let at = channel.saturating_mul(size_of::<ChannelRecord>());
        let place = self.skeleton.asset.at(SectionKind::CHANNELS, at);
        place.rule(rule).broken("what is there", "what is not")
    }
}

/// Writes what a channel animates, or keeps it in `turns`; `None` where there is no such thing.
fn play(
    Channel {
        record: channel,
        track,
    }: &Channel<'_>,
    span: Span,
    locals: &mut [LocalTransform],
    q: &mut [f32],
    turns: &mut Turns,
) -> Option<()> {
    let target = channel.target as usize;
    if channel.path == channel_path::MODES {
        let end = target.checked_add(channel.target_count as usize)?;
        for (k, q) in q.get_mut(target..end)?.iter_mut().enumerate() {
            *q = track.component(span, k) as f32;
        }
        return Some(());
    }
    let LocalTransform::Parts {
        translation,
        rotation,
        scale,
    } = locals.get_mut(target)?
    else {
        return None;
    };
    match channel.path {
        channel_path::TRANSLATION => *translation = track.vector(span),
        channel_path::ROTATION => match track.turn(span) {
            Some(keys) => turns.push(target, keys, span.share, locals),
            None => *rotation = track.rotation(span),
        },
        _ => *scale = track.vector(span),
    }
    Some(())
}

/// Rotations between two keys that are still to be written: together they take a fraction of the time.
struct Turns {
    kernel: Kernel,
    /// Nodes.
    targets: [usize; KEYS],
    from: [[f64; 4]; KEYS],
    to: [[f64; 4]; KEYS],
    shares: [f64; KEYS],
    count: usize,
}

impl Turns {
    fn new(kernel: Kernel) -> Self {
        /// Where there is none to write, one that takes no time.
        const NONE: [f64; 4] = [0.0, 0.0, 0.0, 1.0];
        Self {
            kernel,
            targets: [0; KEYS],
            from: [NONE; KEYS],
            to: [NONE; KEYS],
            shares: [0.0; KEYS],
            count: 0,
        }
    }

    #[inline]
    fn push(
        &mut self,
        target: usize,
        [from, to]: [[f64; 4]; 2],
        share: f64,
        locals: &mut [LocalTransform],
    ) {
        if self.count == KEYS {
            self.write(locals);
        }
        let k = self.count % KEYS;
        (self.targets[k], self.shares[k]) = (target, share);
        (self.from[k], self.to[k]) = (from, to);
        self.count += 1;
    }

    fn write(&mut self, locals: &mut [LocalTransform]) {
        self.kernel.run(Slerps {
            from: &mut self.from,
            to: &self.to,
            shares: &self.shares,
            count: self.count,
        });
        for (target, turned) in self.targets.iter().zip(&self.from).take(self.count) {
            if let Some(LocalTransform::Parts { rotation, .. }) = locals.get_mut(*target) {
                *rotation = *turned;
            }
        }
        self.count = 0;
    }
}
