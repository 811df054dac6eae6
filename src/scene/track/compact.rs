//! Compact keys of smooth curves, the same in memory and on the disk. In go keys, out come the same keys.
//! Invariant: keys that would lose a bit are refused; callers round their numbers first.

use super::{Animate, Key, Segment};
use std::marker::PhantomData;
use std::ops::Range;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::inside::scene) struct SmoothKey<T> {
    /// Seconds.
    pub(in crate::inside::scene) time_s: f64,
    pub(in crate::inside::scene) value: T,
    /// Derivative on both sides.
    pub(in crate::inside::scene) slope: T,
}

/// Bytes of a time: single precision, counted from the start.
const TIME: usize = size_of::<f32>();

/// Compact keys, at least one, little-endian: for each its time, then value and slope ([`Animate::BYTES`]).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Compact<T> {
    start_s: f64,
    /// Two pieces, so that joining curves copies none. The second may be empty.
    pieces: [Box<[u8]>; 2],
    of: PhantomData<T>,
}

impl<T: Animate> SmoothKey<T> {
    /// Key rounded to the precision of compact ones, in a track that starts at `start_s`.
    pub(in crate::inside::scene) fn shortened(self, start_s: f64) -> Self {
        let mut bytes = Vec::with_capacity(Compact::<T>::STRIDE);
        self.push(start_s, &mut bytes);
        Self::of(start_s, &bytes)
    }

    fn push(self, start_s: f64, out: &mut Vec<u8>) {
        out.extend(((self.time_s - start_s) as f32).to_le_bytes());
        self.value.push_bytes(self.slope, out);
    }

    fn of(start_s: f64, bytes: &[u8]) -> Self {
        let (value, slope) = T::from_bytes(&bytes[TIME..]);
        Self { time_s: time_s(start_s, bytes), value, slope }
    }
}

impl<T: Animate> Compact<T> {
    const STRIDE: usize = TIME + T::BYTES;

    /// Compact keys; `None` if anything would be lost.
    pub(super) fn new(start_s: f64, keys: &[SmoothKey<T>]) -> Option<Self> {
        if T::BYTES == 0 {
            return None;
        }
        let mut bytes = Vec::with_capacity(keys.len() * Self::STRIDE);
        for key in keys {
            key.push(start_s, &mut bytes);
            if SmoothKey::of(start_s, &bytes[bytes.len() - Self::STRIDE..]) != *key {
                return None;
            }
        }
        Some(Self::of(start_s, bytes.into()))
    }

    fn of(start_s: f64, bytes: Box<[u8]>) -> Self {
        Self { start_s, pieces: [bytes, Box::default()], of: PhantomData }
    }

    /// Whether another curve may follow: both have one piece, and the same start of times.
    pub(super) fn can_precede(&self, next: &Self) -> bool {
        let is_one_piece = |curve: &Self| curve.pieces[1].is_empty();
        self.start_s == next.start_s && is_one_piece(self) && is_one_piece(next)
    }

    /// These keys without the last, then those of a curve that starts with it.
    pub(super) fn then(self, next: Self) -> Self {
        let ([first, _], [second, _]) = (self.pieces, next.pieces);
        let mut first = first.into_vec();
        first.truncate(first.len() - Self::STRIDE);
        Self { pieces: [first.into(), second], ..Self::of(self.start_s, Box::default()) }
    }

    /// The keys of these indices.
    pub(super) fn part(&self, indices: Range<usize>) -> Self {
        let bytes: Vec<u8> = indices.flat_map(|index| self.bytes(index)).copied().collect();
        Self::of(self.start_s, bytes.into())
    }

    /// Writes the length in bytes, the start, and the keys.
    pub(super) fn write(&self, out: &mut Vec<u8>) {
        out.extend(((self.len() * Self::STRIDE) as u64).to_le_bytes());
        out.extend(self.start_s.to_le_bytes());
        self.pieces.iter().for_each(|piece| out.extend_from_slice(piece));
    }

    /// Reads what `write` wrote from the front of `bytes`; `None` for anything else.
    pub(super) fn read(bytes: &mut &[u8]) -> Option<Self> {
        let (length, rest) = bytes.split_first_chunk()?;
        let (start_s, rest) = rest.split_first_chunk()?;
        let (own, rest) = rest.split_at_checked(usize::try_from(u64::from_le_bytes(*length)).ok()?)?;
        let read = Self::of(f64::from_le_bytes(*start_s), own.into());
        *bytes = rest;
        let whole = T::BYTES > 0 && !own.is_empty() && own.len().is_multiple_of(Self::STRIDE);
        let times = || (0..read.len()).map(|index| read.time_s(index));
        let ordered = || times().zip(times().skip(1)).all(|(before, after)| before < after);
        (whole && times().all(f64::is_finite) && ordered()).then_some(read)
    }

    pub(super) fn len(&self) -> usize {
        self.pieces.iter().map(|piece| piece.len()).sum::<usize>() / Self::STRIDE
    }

    pub(super) fn time_s(&self, index: usize) -> f64 {
        time_s(self.start_s, self.bytes(index))
    }

    pub(super) fn value(&self, index: usize) -> T {
        self.smooth_key(index).value
    }

    pub(super) fn key(&self, index: usize) -> Key<T> {
        let SmoothKey { time_s, value, slope: leave } = self.smooth_key(index);
        let arrive = if index + 1 < self.len() { self.smooth_key(index + 1).slope } else { T::ZERO };
        Key { time_s, value, to_next: Segment::Hermite { leave, arrive } }
    }

    fn smooth_key(&self, index: usize) -> SmoothKey<T> {
        SmoothKey::of(self.start_s, self.bytes(index))
    }

    fn bytes(&self, index: usize) -> &[u8] {
        let [first, second] = &self.pieces;
        let at = index * Self::STRIDE;
        let from = if at < first.len() { &first[at..] } else { &second[at - first.len()..] };
        &from[..Self::STRIDE]
    }
}

fn time_s(start_s: f64, bytes: &[u8]) -> f64 {
    start_s + f64::from(f32::from_le_bytes(std::array::from_fn(|byte| bytes[byte])))
}
