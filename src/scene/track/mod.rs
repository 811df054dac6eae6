//! Keys in, the value at any time out. Invariant: at least one key, key times strictly increasing,
//! so that every time has exactly one value.

mod animate;
mod segment;
#[cfg(test)]
mod tests;

pub use animate::Animate;
use segment::between;
pub use segment::{Handle, Segment};

pub use crate::description::ron::Extend;

/// A keyed value.
#[derive(Clone, Debug, PartialEq)]
pub struct Track<T> {
    times_s: Vec<f64>,
    /// Values, as many as times, unless they are among [`Ways::SmoothSingle`].
    values: Vec<T>,
    to_next: Ways<T>,
    extend: Extend,
}

/// Ways from key to key. Any curves take several times the memory of what scenes by the thousand nodes are
/// made of: straight lines between sampled keys, and smooth curves.
#[derive(Clone, Debug, PartialEq)]
enum Ways<T> {
    /// One way from every key.
    Alike(Segment<T>),
    /// Splines with one slope at each key, on both its sides.
    Smooth(Vec<T>),
    /// Splines where single precision holds all values and slopes as they are: of each key its value, then
    /// its slope.
    SmoothSingle(Vec<f32>),
    /// A way for each key.
    Each(Vec<Segment<T>>),
}

/// A value at a time, and the way to the next key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key<T> {
    /// Seconds.
    pub time_s: f64,
    /// The value there.
    pub value: T,
    /// Way from here to the next key; of the last key, not used.
    pub to_next: Segment<T>,
}

impl<T: Copy> From<T> for Track<T> {
    fn from(value: T) -> Self {
        let (times_s, values) = (vec![0.0], vec![value]);
        Self { times_s, values, to_next: Ways::Alike(Segment::Step), extend: Extend::Hold }
    }
}

impl<T: Animate> Track<T> {
    /// Track of a linear function of every value: keys and derivatives alike.
    pub fn map_linear<U>(&self, map: impl Fn(T) -> U) -> Track<U> {
        let handle = |handle: Handle<T>| Handle { time_s: handle.time_s, value: map(handle.value) };
        let segment = |segment: &Segment<T>| match *segment {
            Segment::Step => Segment::Step,
            Segment::Linear => Segment::Linear,
            Segment::Hermite { leave, arrive } => Segment::Hermite { leave: map(leave), arrive: map(arrive) },
            Segment::Bezier { leave, arrive } => {
                Segment::Bezier { leave: handle(leave), arrive: handle(arrive) }
            }
        };
        Track {
            times_s: self.times_s.clone(),
            values: (0..self.times_s.len()).map(|index| map(self.value(index))).collect(),
            to_next: match &self.to_next {
                Ways::Alike(way) => Ways::Alike(segment(way)),
                Ways::Smooth(slopes) => Ways::Smooth(slopes.iter().map(|&slope| map(slope)).collect()),
                Ways::SmoothSingle(singles) => {
                    let pairs = singles.chunks_exact(2 * T::SINGLES);
                    Ways::Smooth(pairs.map(|pair| map(T::from_singles(&pair[T::SINGLES..]))).collect())
                }
                Ways::Each(ways) => Ways::Each(ways.iter().map(segment).collect()),
            },
            extend: self.extend,
        }
    }
}

impl<T> Track<T> {
    /// Times of the keys, seconds.
    pub fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    /// Extension outside its keys.
    pub fn extend(&self) -> Extend {
        self.extend
    }
}

impl<T: Animate> Track<T> {
    /// A track through `keys`; `None` if there are none, a time is not finite, or times do not
    /// strictly increase.
    pub fn new(keys: Vec<Key<T>>, extend: Extend) -> Option<Self> {
        let finite = keys.iter().all(|key| key.time_s.is_finite());
        let increasing = keys.windows(2).all(|pair| pair[0].time_s < pair[1].time_s);
        let first = keys.first().filter(|_| finite && increasing)?;
        let to_next = if keys.iter().all(|key| key.to_next == first.to_next) {
            Ways::Alike(first.to_next)
        } else {
            smooth(&keys).unwrap_or_else(|| Ways::Each(keys.iter().map(|key| key.to_next).collect()))
        };
        let times_s = keys.iter().map(|key| key.time_s).collect();
        let values: Vec<T> = keys.iter().map(|key| key.value).collect();
        if let Ways::Smooth(slopes) = &to_next
            && let Some(singles) = in_singles(&values, slopes)
        {
            return Some(Self { times_s, values: Vec::new(), to_next: Ways::SmoothSingle(singles), extend });
        }
        Some(Self { times_s, values, to_next, extend })
    }

    /// Values between which all lie that it ever takes.
    pub(in crate::inside::scene) fn hull(&self) -> Vec<T> {
        let keys = self.keys();
        let inner = keys.windows(2).flat_map(|pair| pair[0].inner_control_points(&pair[1]));
        keys.iter().map(|key| key.value).chain(inner).collect()
    }

    /// The keys, put together anew.
    pub fn keys(&self) -> Vec<Key<T>> {
        (0..self.times_s.len()).map(|index| self.key(index)).collect()
    }

    /// Times of the first and the last key, seconds; none without keys.
    pub fn span_s(&self) -> Option<(f64, f64)> {
        Some((*self.times_s.first()?, *self.times_s.last()?))
    }

    fn key(&self, index: usize) -> Key<T> {
        let to_next = match &self.to_next {
            Ways::Alike(way) => *way,
            Ways::Smooth(slopes) => {
                let arrive = slopes.get(index + 1).copied().unwrap_or(T::ZERO);
                Segment::Hermite { leave: slopes[index], arrive }
            }
            Ways::SmoothSingle(singles) => {
                let slope = |index: usize| {
                    let from = (2 * index + 1) * T::SINGLES;
                    singles.get(from..from + T::SINGLES).map_or(T::ZERO, T::from_singles)
                };
                Segment::Hermite { leave: slope(index), arrive: slope(index + 1) }
            }
            Ways::Each(ways) => ways[index],
        };
        Key { time_s: self.times_s[index], value: self.value(index), to_next }
    }

    fn value(&self, index: usize) -> T {
        match &self.to_next {
            Ways::SmoothSingle(singles) => {
                let from = 2 * index * T::SINGLES;
                T::from_singles(&singles[from..from + T::SINGLES])
            }
            _ => self.values[index],
        }
    }

    /// The value of a key at rest; of rotations rounded to single precision the one that curves reach there.
    fn held(&self, index: usize) -> T {
        let value = self.value(index);
        match self.to_next {
            Ways::SmoothSingle(_) => T::blend([value; 4], [1.0, 0.0, 0.0, 0.0]),
            _ => value,
        }
    }

    /// True if the value is the same at all times.
    pub fn is_constant(&self) -> bool {
        (1..self.times_s.len()).all(|next| {
            let Key { value, to_next, .. } = self.key(next - 1);
            let stays = match to_next {
                Segment::Step | Segment::Linear => true,
                Segment::Hermite { leave, arrive } => leave == T::ZERO && arrive == T::ZERO,
                Segment::Bezier { leave, arrive } => leave.value == value && arrive.value == value,
            };
            stays && self.value(next) == value
        })
    }

    /// The value at `time_s`.
    pub fn at(&self, time_s: f64) -> T {
        let time_s = self.time_within_keys(time_s);
        // glTF stores key times in single precision: frame 13 at 24 a second is stored later than
        // 13/24, which must all the same find that key. Only the choice of key is rounded.
        let after = self.times_s.partition_point(|&key_s| key_s as f32 <= time_s as f32);
        if after == 0 || after == self.times_s.len() {
            return self.held(after.saturating_sub(1));
        }
        between(&self.key(after - 1), &self.key(after), time_s)
    }

    fn time_within_keys(&self, time_s: f64) -> f64 {
        let (first_s, last_s) = (self.times_s[0], self.times_s[self.times_s.len() - 1]);
        if self.extend == Extend::Hold || first_s == last_s {
            return time_s;
        }
        let wrapped_s = first_s + (time_s - first_s).rem_euclid(last_s - first_s);
        // Rounding in the line above may leave a full period as well as none.
        if wrapped_s as f32 >= last_s as f32 { first_s } else { wrapped_s }
    }
}

/// Values and slopes in single precision, if nothing is lost.
fn in_singles<T: Animate>(values: &[T], slopes: &[T]) -> Option<Vec<f32>> {
    if T::SINGLES == 0 {
        return None;
    }
    let mut singles = Vec::with_capacity(2 * values.len() * T::SINGLES);
    for number in values.iter().zip(slopes).flat_map(|(&value, &slope)| [value, slope]) {
        number.push_singles(&mut singles);
        if T::from_singles(&singles[singles.len() - T::SINGLES..]) != number {
            return None;
        }
    }
    Some(singles)
}

/// Splines whose slopes go on through their keys, the last one towards nowhere; `None` of other keys.
fn smooth<T: Animate>(keys: &[Key<T>]) -> Option<Ways<T>> {
    let mut slopes = Vec::with_capacity(keys.len());
    let mut expected = None;
    for key in keys {
        let Segment::Hermite { leave, arrive } = key.to_next else { return None };
        if expected.is_some_and(|expected| expected != leave) {
            return None;
        }
        expected = Some(arrive);
        slopes.push(leave);
    }
    (expected == Some(T::ZERO)).then_some(Ways::Smooth(slopes))
}
