//! Values that change over time. Invariant: at least one key, key times strictly increasing.

use glam::{DQuat, DVec3};

/// A keyed value.
#[derive(Clone, Debug, PartialEq)]
pub struct Track<T> {
    keys: Vec<Key<T>>,
    extend: Extend,
}

/// What a track does outside its keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Extend {
    /// Keeps the first or last value.
    #[default]
    Hold,
    /// Starts over.
    Cycle,
}

/// A value at a time, and the way to the next key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key<T> {
    /// Seconds.
    pub time_s: f64,
    /// The value there.
    pub value: T,
    /// How the value goes on from here to the next key; of the last key, not used.
    pub to_next: Segment<T>,
}

/// How a value gets from one key to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Segment<T> {
    /// Stays until the next key.
    Step,
    /// Straight; quaternions along the shortest arc.
    Linear,
    /// glTF's cubic spline (specification, appendix C): derivatives per second at both ends.
    Hermite {
        /// Derivative on leaving this key.
        leave: T,
        /// Derivative on arriving at the next key.
        arrive: T,
    },
    /// Blender's Bezier curve: time and value of the two inner control points.
    Bezier {
        /// The control point after this key.
        leave: Handle<T>,
        /// The control point before the next key.
        arrive: Handle<T>,
    },
}

/// A Bezier control point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Handle<T> {
    /// Seconds.
    pub time_s: f64,
    /// Value.
    pub value: T,
}

/// What can be keyed.
pub trait Animate: Copy {
    /// From `a` at 0 to `b` at 1.
    fn lerp(a: Self, b: Self, fraction: f64) -> Self;
    /// `sum(weights[i] * values[i])`, brought back to where such values live (unit quaternions).
    fn blend(values: [Self; 4], weights: [f64; 4]) -> Self;
}

impl<T: Copy> From<T> for Track<T> {
    fn from(value: T) -> Self {
        Self { keys: vec![Key { time_s: 0.0, value, to_next: Segment::Step }], extend: Extend::Hold }
    }
}

impl<T: Animate> Track<T> {
    /// A track through `keys`; `None` if there are none or their times do not strictly increase.
    pub fn new(keys: Vec<Key<T>>, extend: Extend) -> Option<Self> {
        let increasing = keys.windows(2).all(|pair| pair[0].time_s < pair[1].time_s);
        (!keys.is_empty() && increasing).then_some(Self { keys, extend })
    }

    /// The keys.
    pub fn keys(&self) -> &[Key<T>] {
        &self.keys
    }

    /// True if the value is the same at all times for want of a second key.
    pub fn is_constant(&self) -> bool {
        self.keys.len() == 1
    }

    /// The value at `time_s`.
    pub fn at(&self, _time_s: f64) -> T {
        self.keys[0].value
    }
}

impl Animate for f64 {
    fn lerp(a: Self, b: Self, fraction: f64) -> Self {
        a + (b - a) * fraction
    }
    fn blend(v: [Self; 4], w: [f64; 4]) -> Self {
        v[0] * w[0] + v[1] * w[1] + v[2] * w[2] + v[3] * w[3]
    }
}

impl Animate for DVec3 {
    fn lerp(a: Self, b: Self, fraction: f64) -> Self {
        a + (b - a) * fraction
    }
    fn blend(v: [Self; 4], w: [f64; 4]) -> Self {
        v[0] * w[0] + v[1] * w[1] + v[2] * w[2] + v[3] * w[3]
    }
}

impl Animate for DQuat {
    fn lerp(a: Self, b: Self, fraction: f64) -> Self {
        a.slerp(b, fraction)
    }
    fn blend(v: [Self; 4], w: [f64; 4]) -> Self {
        (v[0] * w[0] + v[1] * w[1] + v[2] * w[2] + v[3] * w[3]).normalize()
    }
}

impl Animate for bool {
    fn lerp(a: Self, _b: Self, _fraction: f64) -> Self {
        a
    }
    fn blend(v: [Self; 4], _w: [f64; 4]) -> Self {
        v[0]
    }
}
