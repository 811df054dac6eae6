//! Tracks of keys. In go keys, out comes the value at any time. Invariant: at least one key, key times
//! strictly increasing, so that every time has exactly one value.

mod animate;
mod compact;
mod segment;
#[cfg(test)]
mod tests;

pub use animate::Animate;
use compact::Compact;
pub(in crate::inside::scene) use compact::SmoothKey;
use segment::between;
pub use segment::{Handle, Segment};
use std::borrow::Cow;

pub use crate::description::ron::Extend;

/// A keyed value.
#[derive(Clone, Debug, PartialEq)]
pub struct Track<T>(Course<T>);

/// Storage: most tracks of a scene are constant, and most others are smooth.
#[derive(Clone, Debug, PartialEq)]
enum Course<T> {
    /// One key, at 0.
    Still(T),
    /// Smooth between keys, constant outside.
    Smooth(Box<Compact<T>>),
    Keyed(Box<Keyed<T>>),
}

/// Any keys.
#[derive(Clone, Debug, PartialEq)]
struct Keyed<T> {
    times_s: Vec<f64>,
    values: Vec<T>,
    to_next: Ways<T>,
    extend: Extend,
}

/// Segments between keys. Large scenes mostly have linear or smooth ones, whose forms take a fraction of the
/// memory.
#[derive(Clone, Debug, PartialEq)]
enum Ways<T> {
    /// One segment for all keys.
    Alike(Segment<T>),
    /// Splines with one slope at each key, on both its sides.
    Smooth(Vec<T>),
    /// A segment for each key.
    Each(Vec<Segment<T>>),
}

/// Value at a time, and the segment to the next key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key<T> {
    /// Seconds.
    pub time_s: f64,
    /// The value there.
    pub value: T,
    /// Segment to the next key; unused for the last key.
    pub to_next: Segment<T>,
}

impl<T> From<T> for Track<T> {
    fn from(value: T) -> Self {
        Self(Course::Still(value))
    }
}

impl<T: Animate> Track<T> {
    /// Track under a linear map of values and derivatives.
    pub fn map_linear<U>(&self, map: impl Fn(T) -> U) -> Track<U> {
        let handle = |handle: Handle<T>| Handle { time_s: handle.time_s, value: map(handle.value) };
        let segment = |segment: Segment<T>| match segment {
            Segment::Step => Segment::Step,
            Segment::Linear => Segment::Linear,
            Segment::Hermite { leave, arrive } => Segment::Hermite { leave: map(leave), arrive: map(arrive) },
            Segment::Bezier { leave, arrive } => {
                Segment::Bezier { leave: handle(leave), arrive: handle(arrive) }
            }
        };
        if let Course::Still(value) = self.0 {
            return Track::from(map(value));
        }
        let keys = self.keys();
        let to_next = Ways::Each(keys.iter().map(|key| segment(key.to_next)).collect());
        let times_s = keys.iter().map(|key| key.time_s).collect();
        let values = keys.iter().map(|key| map(key.value)).collect();
        Track(Course::Keyed(Box::new(Keyed { times_s, values, to_next, extend: self.extend() })))
    }
}

impl<T: Animate> Track<T> {
    /// Track of `keys`; `None` if there are none, a time is not finite, or times do not strictly increase.
    pub fn new(keys: Vec<Key<T>>, extend: Extend) -> Option<Self> {
        let finite = keys.iter().all(|key| key.time_s.is_finite());
        let increasing = keys.windows(2).all(|pair| pair[0].time_s < pair[1].time_s);
        let first = keys.first().filter(|_| finite && increasing)?;
        let to_next = if keys.iter().all(|key| key.to_next == first.to_next) {
            Ways::Alike(first.to_next)
        } else if let Some(smooth) = smooth(&keys) {
            if let Some(compact) = Compact::new(first.time_s, &smooth).filter(|_| extend == Extend::Hold) {
                return Some(Self(Course::Smooth(Box::new(compact))));
            }
            Ways::Smooth(smooth.iter().map(|key| key.slope).collect())
        } else {
            Ways::Each(keys.iter().map(|key| key.to_next).collect())
        };
        let times_s = keys.iter().map(|key| key.time_s).collect();
        let values = keys.iter().map(|key| key.value).collect();
        Some(Self(Course::Keyed(Box::new(Keyed { times_s, values, to_next, extend }))))
    }

    /// Smooth curve that starts at `start_s` or later.
    pub(in crate::inside::scene) fn smooth(start_s: f64, keys: &[SmoothKey<T>]) -> Option<Self> {
        if let Some(compact) = Compact::new(start_s, keys) {
            return Some(Self(Course::Smooth(Box::new(compact))));
        }
        let slope = |index: usize| keys.get(index).map_or(T::ZERO, |key| key.slope);
        let key = |(index, &SmoothKey { time_s, value, slope: leave }): (usize, &SmoothKey<T>)| {
            let arrive = slope(index + 1);
            Key { time_s, value, to_next: Segment::Hermite { leave, arrive } }
        };
        Self::new(keys.iter().enumerate().map(key).collect(), Extend::Hold)
    }

    /// Joins two smooth curves; the second starts where the first ends, and its slope there is kept.
    pub(in crate::inside::scene) fn then(self, next: Self) -> Option<Self> {
        let (first, next) = match (self.0, next.0) {
            (Course::Smooth(first), Course::Smooth(next)) if first.can_precede(&next) => {
                return Some(Self(Course::Smooth(Box::new(first.then(*next)))));
            }
            (first, next) => (Self(first), Self(next)),
        };
        let (mut keys, more) = (first.keys(), next.keys());
        keys.pop();
        if let (Some(Key { to_next: Segment::Hermite { arrive, .. }, .. }), Segment::Hermite { leave, .. }) =
            (keys.last_mut(), more.first()?.to_next)
        {
            *arrive = leave;
        }
        keys.extend(more);
        Self::new(keys, Extend::Hold)
    }

    /// Drops keys of a compact curve that no time in a span needs: its values there keep their bits, and it
    /// stays constant or not. Returns the curve with all keys, if it had more.
    pub(in crate::inside::scene) fn keep_span(&mut self, (from_s, to_s): (f64, f64)) -> Option<Self> {
        let Course::Smooth(compact) = &self.0 else { return None };
        let first = self.keys_until(from_s as f32).saturating_sub(1);
        // Single precision may choose the key before or after.
        let kept = first.saturating_sub(1)..(self.keys_until(to_s as f32) + 2).min(self.len());
        if kept == (0..self.len()) {
            return None;
        }
        let kept = Self(Course::Smooth(Box::new(compact.part(kept))));
        (kept.is_constant() == self.is_constant()).then(|| std::mem::replace(self, kept))
    }

    /// Appends a compact curve's bytes; `None` for any other track.
    pub(in crate::inside::scene) fn write(&self, out: &mut Vec<u8>) -> Option<()> {
        let Course::Smooth(compact) = &self.0 else { return None };
        compact.write(out);
        Some(())
    }

    /// Reads what `write` wrote from the front of `bytes`; `None` for anything else.
    pub(in crate::inside::scene) fn read(bytes: &mut &[u8]) -> Option<Self> {
        Compact::read(bytes).map(|compact| Self(Course::Smooth(Box::new(compact))))
    }

    /// Values whose convex hull contains all values of the track.
    pub(in crate::inside::scene) fn hull(&self) -> Vec<T> {
        let keys = self.keys();
        let inner = keys.windows(2).flat_map(|pair| pair[0].inner_control_points(&pair[1]));
        keys.iter().map(|key| key.value).chain(inner).collect()
    }

    /// Keys, rebuilt from the storage.
    pub fn keys(&self) -> Vec<Key<T>> {
        (0..self.len()).map(|index| self.key(index)).collect()
    }

    /// Times of the keys, seconds.
    pub fn times_s(&self) -> Cow<'_, [f64]> {
        match &self.0 {
            Course::Still(_) => Cow::Borrowed(&[0.0]),
            Course::Smooth(compact) => (0..compact.len()).map(|index| compact.time_s(index)).collect(),
            Course::Keyed(keyed) => Cow::Borrowed(&keyed.times_s),
        }
    }

    /// Times of the first and the last key, seconds.
    pub fn span_s(&self) -> (f64, f64) {
        (self.time_s(0), self.time_s(self.len() - 1))
    }

    /// Extrapolation outside its keys.
    pub fn extend(&self) -> Extend {
        match &self.0 {
            Course::Still(_) | Course::Smooth(_) => Extend::Hold,
            Course::Keyed(keyed) => keyed.extend,
        }
    }

    /// Number of keys, at least one.
    fn len(&self) -> usize {
        match &self.0 {
            Course::Still(_) => 1,
            Course::Smooth(compact) => compact.len(),
            Course::Keyed(keyed) => keyed.times_s.len(),
        }
    }

    fn time_s(&self, index: usize) -> f64 {
        match &self.0 {
            Course::Still(_) => 0.0,
            Course::Smooth(compact) => compact.time_s(index),
            Course::Keyed(keyed) => keyed.times_s[index],
        }
    }

    fn key(&self, index: usize) -> Key<T> {
        let keyed = match &self.0 {
            Course::Still(value) => return Key { time_s: 0.0, value: *value, to_next: Segment::Step },
            Course::Smooth(compact) => return compact.key(index),
            Course::Keyed(keyed) => keyed,
        };
        let to_next = match &keyed.to_next {
            Ways::Alike(way) => *way,
            Ways::Smooth(slopes) => {
                let arrive = slopes.get(index + 1).copied().unwrap_or(T::ZERO);
                Segment::Hermite { leave: slopes[index], arrive }
            }
            Ways::Each(ways) => ways[index],
        };
        Key { time_s: keyed.times_s[index], value: keyed.values[index], to_next }
    }

    /// Value of a key, outside of curves; for rounded rotations the one that curves reach there.
    fn held(&self, index: usize) -> T {
        match &self.0 {
            Course::Still(value) => *value,
            Course::Smooth(compact) => T::blend([compact.value(index); 4], [1.0, 0.0, 0.0, 0.0]),
            Course::Keyed(keyed) => keyed.values[index],
        }
    }

    /// Whether the value is constant.
    pub fn is_constant(&self) -> bool {
        (1..self.len()).all(|next| {
            let Key { value, to_next, .. } = self.key(next - 1);
            let stays = match to_next {
                Segment::Step | Segment::Linear => true,
                Segment::Hermite { leave, arrive } => leave == T::ZERO && arrive == T::ZERO,
                Segment::Bezier { leave, arrive } => leave.value == value && arrive.value == value,
            };
            stays && self.key(next).value == value
        })
    }

    /// Value at `time_s`.
    pub fn at(&self, time_s: f64) -> T {
        let time_s = self.time_within_keys(time_s);
        // glTF stores key times in single precision: frame 13 at 24 a second is stored after 13/24, and has
        // to find that key all the same. Only the choice of the key is rounded.
        let after = self.keys_until(time_s as f32);
        if after == 0 || after == self.len() {
            return self.held(after.saturating_sub(1));
        }
        between(&self.key(after - 1), &self.key(after), time_s)
    }

    /// Number of keys up to a time.
    fn keys_until(&self, time_s: f32) -> usize {
        let (mut low, mut high) = (0, self.len());
        while low < high {
            let middle = usize::midpoint(low, high);
            if self.time_s(middle) as f32 <= time_s { low = middle + 1 } else { high = middle }
        }
        low
    }

    fn time_within_keys(&self, time_s: f64) -> f64 {
        let (first_s, last_s) = self.span_s();
        if self.extend() == Extend::Hold || first_s == last_s {
            return time_s;
        }
        let wrapped_s = first_s + (time_s - first_s).rem_euclid(last_s - first_s);
        // Rounding above may leave a full period instead of none.
        if wrapped_s as f32 >= last_s as f32 { first_s } else { wrapped_s }
    }
}

/// Splines with continuous slopes that end in a derivative of 0; `None` for other keys.
fn smooth<T: Animate>(keys: &[Key<T>]) -> Option<Vec<SmoothKey<T>>> {
    let mut smooth = Vec::with_capacity(keys.len());
    let mut expected = None;
    for &Key { time_s, value, to_next } in keys {
        let Segment::Hermite { leave: slope, arrive } = to_next else { return None };
        if expected.is_some_and(|expected| expected != slope) {
            return None;
        }
        expected = Some(arrive);
        smooth.push(SmoothKey { time_s, value, slope });
    }
    (expected == Some(T::ZERO)).then_some(smooth)
}
