//! Values that may be keyed: `45.0`, or `Keyed(keys: [(at_s: 0.0, value: 45.0), ..])`. In goes RON, out come
//! constants or keys. Invariant: both forms are read without buffering, so errors keep their line and column.

use super::number::{Direction, Finite, Number, Point, Quaternion, QuaternionRate, Range, Three};
use glam::{DQuat, DVec3};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserialize, DeserializeOwned, Deserializer, Error, IntoDeserializer, MapAccess, SeqAccess};
use serde::de::{Unexpected, Visitor};
use serde::{Serialize, Serializer};
use std::fmt;
use std::marker::PhantomData;

/// A constant value, or one that changes over time. Plain numbers and arrays are made constants by `into()`.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[serde(untagged, bound = "")]
#[non_exhaustive]
pub enum Animated<T: Keyable> {
    /// Constant.
    Still(T),
    /// Interpolated between keys.
    Keyed(Keys<T>),
}

impl<T: Keyable> Animated<T> {
    /// Linear interpolation between pairs of seconds and values; constant before the first and after the
    /// last.
    pub fn keys<V: Into<T>>(keys: impl IntoIterator<Item = (f64, V)>) -> Self {
        Self::Keyed(Keys::of(keys, Extend::Hold))
    }

    /// Linear interpolation between pairs of seconds and values, repeated cyclically. The last key ends the
    /// period, with the value of the first.
    pub fn cycle<V: Into<T>>(keys: impl IntoIterator<Item = (f64, V)>) -> Self {
        Self::Keyed(Keys::of(keys, Extend::Cycle))
    }
}

impl<T: Keyable + Default> Default for Animated<T> {
    fn default() -> Self {
        Self::Still(T::default())
    }
}

/// Keys of a value, as written in a file.
#[derive(Clone, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(deny_unknown_fields, bound = "")]
#[non_exhaustive]
pub struct Keys<T: Keyable> {
    /// Keys with strictly increasing times.
    pub keys: Vec<Key<T>>,
    /// Extrapolation outside the keys.
    #[serde(default)]
    pub extend: Extend,
}

impl<T: Keyable> Keys<T> {
    /// Keys of any interpolation, in order of time.
    pub fn new(keys: impl IntoIterator<Item = Key<T>>, extend: Extend) -> Self {
        Self { keys: keys.into_iter().collect(), extend }
    }

    fn of<V: Into<T>>(keys: impl IntoIterator<Item = (f64, V)>, extend: Extend) -> Self {
        Self::new(keys.into_iter().map(|(at_s, value)| Key::new(at_s, value, ToNext::Linear)), extend)
    }
}

/// A value at a time.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(deny_unknown_fields, bound = "")]
#[non_exhaustive]
pub struct Key<T: Keyable> {
    /// Seconds.
    pub at_s: Number<Finite>,
    /// The value there.
    pub value: T,
    /// Interpolation to the next key.
    #[serde(default)]
    pub to_next: ToNext<T>,
}

impl<T: Keyable> Key<T> {
    /// Value at a second, and the way to the next.
    pub fn new(at_s: f64, value: impl Into<T>, to_next: ToNext<T>) -> Self {
        Self { at_s: Number::new(at_s), value: value.into(), to_next }
    }
}

/// Interpolation from one key to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(deny_unknown_fields, bound = "")]
#[non_exhaustive]
pub enum ToNext<T: Keyable> {
    /// Constant until the next key.
    Step,
    /// Linear.
    #[default]
    Linear,
    /// A cubic with the given slopes at both ends, per second (glTF's CUBICSPLINE).
    Hermite {
        /// Slope after this key.
        leave_per_s: T::Rate,
        /// Slope before the next one.
        arrive_per_s: T::Rate,
    },
    /// A cubic with two handles, each a time and a value (Blender's Bezier curve).
    Bezier {
        /// Handle after this key.
        leave: Handle<T>,
        /// Handle before the next one.
        arrive: Handle<T>,
    },
}

/// A handle of a Bezier curve.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(deny_unknown_fields, bound = "")]
#[non_exhaustive]
pub struct Handle<T: Keyable> {
    /// Seconds, between the two keys.
    pub at_s: Number<Finite>,
    /// The value there.
    pub value: T,
}

impl<T: Keyable> Handle<T> {
    /// Value at a second.
    pub fn new(at_s: f64, value: impl Into<T>) -> Self {
        Self { at_s: Number::new(at_s), value: value.into() }
    }
}

/// Extrapolation of a keyed value outside its keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
#[non_exhaustive]
pub enum Extend {
    /// Keeps the first or last value.
    #[default]
    Hold,
    /// Repeats the keys, also before the first. The last key only ends the period; the value there is the
    /// first key's.
    Cycle,
}

/// Value that can be keyed in a file.
pub trait Keyable: Copy + fmt::Debug + PartialEq + DeserializeOwned + Serialize {
    /// Rate of change, per second.
    type Rate: Copy + fmt::Debug + PartialEq + DeserializeOwned + Serialize;
    /// Value in SI units.
    type Si: Copy;
    /// Expectation in the error for a curve that leaves the range.
    const EXPECTED: &'static str;

    /// The value in SI units.
    fn si(self) -> Self::Si;
    /// A rate in SI units per second.
    fn rate_si(rate: Self::Rate) -> Self::Si;
    /// Whether a curve may contain `value`.
    fn admits(_: Self::Si) -> bool {
        true
    }
}

/// Tolerance for rounding in a conversion to SI units and back.
const ROUNDING: f64 = 1.0 - 1e-12;

fn admits<R: Range>(value: f64) -> bool {
    value.is_finite() && R::contains(value / R::UNIT * ROUNDING)
}

impl<R: Range + fmt::Debug + PartialEq + 'static> Keyable for Number<R> {
    type Rate = Number<Finite>;
    type Si = f64;
    const EXPECTED: &'static str = R::EXPECTED;

    fn si(self) -> f64 {
        self.si()
    }
    fn rate_si(rate: Self::Rate) -> f64 {
        rate.si() * R::UNIT
    }
    fn admits(value: f64) -> bool {
        admits::<R>(value)
    }
}

impl<R: Range + fmt::Debug + PartialEq + 'static, const ONE_WILL_DO: bool> Keyable for Three<R, ONE_WILL_DO> {
    type Rate = Three<Finite, ONE_WILL_DO>;
    type Si = DVec3;
    const EXPECTED: &'static str = R::EXPECTED;

    fn si(self) -> DVec3 {
        self.si()
    }
    fn rate_si(rate: Self::Rate) -> DVec3 {
        rate.si() * R::UNIT
    }
    fn admits(value: DVec3) -> bool {
        value.to_array().into_iter().all(admits::<R>)
    }
}

impl Keyable for Direction {
    type Rate = Point;
    type Si = DVec3;
    const EXPECTED: &'static str = "a direction (x, y, z)";

    fn si(self) -> DVec3 {
        self.0
    }
    fn rate_si(rate: Self::Rate) -> DVec3 {
        rate.si()
    }
}

impl Keyable for Quaternion {
    type Rate = QuaternionRate;
    type Si = DQuat;
    const EXPECTED: &'static str = "a quaternion (x, y, z, w)";

    fn si(self) -> DQuat {
        self.0
    }
    fn rate_si(rate: Self::Rate) -> DQuat {
        rate.0
    }
}

impl Keyable for bool {
    type Rate = NoRate;
    type Si = bool;
    const EXPECTED: &'static str = "true or false";

    fn si(self) -> bool {
        self
    }
    fn rate_si(_: NoRate) -> bool {
        false
    }
}

/// Slope of a value that can only step: it cannot be written in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoRate(());

impl<'de> Deserialize<'de> for NoRate {
    fn deserialize<D: Deserializer<'de>>(_: D) -> Result<Self, D::Error> {
        Err(D::Error::invalid_value(Unexpected::Other("a slope of something that is on or off"), &"`Step`"))
    }
}

impl Serialize for NoRate {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_unit()
    }
}

impl<'de, T: Keyable> Deserialize<'de> for Animated<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(AnimatedVisitor(PhantomData))
    }
}

/// Numbers, booleans and tuples are constants; a struct with named fields holds keys.
struct AnimatedVisitor<T>(PhantomData<T>);

impl<'de, T: Keyable> Visitor<'de> for AnimatedVisitor<T> {
    type Value = Animated<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, or Keyed(keys: [(at_s: .., value: ..), ..])", T::EXPECTED)
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<Self::Value, E> {
        T::deserialize(value.into_deserializer()).map(Animated::Still)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Self::Value, E> {
        T::deserialize(value.into_deserializer()).map(Animated::Still)
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Self::Value, E> {
        T::deserialize(value.into_deserializer()).map(Animated::Still)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Self::Value, E> {
        T::deserialize(value.into_deserializer()).map(Animated::Still)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, sequence: A) -> Result<Self::Value, A::Error> {
        T::deserialize(SeqAccessDeserializer::new(sequence)).map(Animated::Still)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
        Keys::deserialize(MapAccessDeserializer::new(map)).map(Animated::Keyed)
    }
}
