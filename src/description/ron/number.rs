//! Numbers with a range. In goes RON, out come finite values. Invariant: a number from a file lies in its
//! range; any other is an error at its own line and column.

pub use super::range::*;
use crate::description::LARGEST_NUMBER;
use glam::{DQuat, DVec3};
use serde::de::{Deserialize, Deserializer, Error, IgnoredAny, SeqAccess, Unexpected, Visitor};
use std::fmt;
use std::marker::PhantomData;

/// Number in a range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Number<R> {
    value: f64,
    range: PhantomData<R>,
}

impl<R> Number<R> {
    /// Creates a number that is validated with its part.
    pub(super) const fn new(value: f64) -> Self {
        Self { value, range: PhantomData }
    }

    /// Value in the author's unit.
    pub(super) fn value(self) -> f64 {
        self.value
    }
}

impl<R: Range> Number<R> {
    /// Value in SI units: radians for angles, else the author's unit.
    pub fn si(self) -> f64 {
        self.value * R::UNIT
    }
}

impl<'de, R: Range> Deserialize<'de> for Number<R> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        check::<R, D::Error>(f64::deserialize(deserializer)?).map(Self::new)
    }
}

fn check<R: Range, E: Error>(value: f64) -> Result<f64, E> {
    match unmet::<R>(value) {
        None => Ok(value),
        Some(expected) => Err(E::invalid_value(Unexpected::Float(value), &expected)),
    }
}

/// Expectation in the error for a value out of range; `None` if it lies within.
pub(super) fn unmet<R: Range>(value: f64) -> Option<&'static str> {
    if !value.is_finite() || !R::contains(value) {
        Some(R::EXPECTED)
    } else {
        (value.abs() > LARGEST_NUMBER).then_some(Finite::EXPECTED)
    }
}

/// Three numbers `(x, y, z)`; with `ONE_WILL_DO` one number may stand for all three.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Three<R, const ONE_WILL_DO: bool> {
    value: DVec3,
    range: PhantomData<R>,
}

/// Three numbers.
pub type Vector<R> = Three<R, false>;

/// A position or displacement.
pub type Point = Vector<Finite>;

/// Three numbers, or one for all three.
pub type Triple<R> = Three<R, true>;

impl<R, const ONE_WILL_DO: bool> Three<R, ONE_WILL_DO> {
    /// Creates numbers that are validated with their part.
    pub(super) const fn new(value: DVec3) -> Self {
        Self { value, range: PhantomData }
    }

    /// Values in the author's unit.
    pub(super) fn value(self) -> DVec3 {
        self.value
    }
}

impl<R: Range, const ONE_WILL_DO: bool> Three<R, ONE_WILL_DO> {
    /// Values in SI units.
    pub fn si(self) -> DVec3 {
        self.value * R::UNIT
    }
}

impl<'de, R: Range, const ONE_WILL_DO: bool> Deserialize<'de> for Three<R, ONE_WILL_DO> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let expected =
            if ONE_WILL_DO { "one number, or three numbers (x, y, z)" } else { "three numbers (x, y, z)" };
        let values = deserializer.deserialize_any(OneOrTuple::<R, 3>::new(expected, ONE_WILL_DO))?;
        Ok(Self::new(DVec3::from_array(values)))
    }
}

/// Vector other than zero, of any length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction(pub(crate) DVec3);

impl<'de> Deserialize<'de> for Direction {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let vector = Point::deserialize(deserializer)?.si();
        if vector.try_normalize().is_some() {
            Ok(Self(vector))
        } else {
            Err(D::Error::invalid_value(Unexpected::Other("a vector of length 0"), &"a direction (x, y, z)"))
        }
    }
}

/// Rotation `(x, y, z, w)`, normalized on reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quaternion(pub(crate) DQuat);

impl<'de> Deserialize<'de> for Quaternion {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let QuaternionRate(quaternion) = QuaternionRate::deserialize(deserializer)?;
        if quaternion.length_squared() > f64::MIN_POSITIVE {
            Ok(Self(quaternion.normalize()))
        } else {
            let found = Unexpected::Other("a quaternion of length 0");
            Err(D::Error::invalid_value(found, &"a quaternion (x, y, z, w) that is not 0"))
        }
    }
}

/// Rate of change of a quaternion's components, per second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuaternionRate(pub(crate) DQuat);

impl<'de> Deserialize<'de> for QuaternionRate {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let four = OneOrTuple::<Finite, 4>::new("four numbers (x, y, z, w)", false);
        deserializer.deserialize_any(four).map(|values| Self(DQuat::from_array(values)))
    }
}

/// Range from `low` to `high`; written as `(low, high)`, or as one number for both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span<R> {
    low: f64,
    high: f64,
    range: PhantomData<R>,
}

impl<R> Span<R> {
    /// Creates a range that is validated with its part.
    pub(super) const fn new(low: f64, high: f64) -> Self {
        Self { low, high, range: PhantomData }
    }

    /// Both ends in the author's unit.
    pub(super) fn ends(self) -> [f64; 2] {
        [self.low, self.high]
    }
}

impl<R: Range> Span<R> {
    /// Value at `fraction`, from 0 at `low` to 1 at `high`, in SI units.
    pub fn at(self, fraction: f64) -> f64 {
        (self.low + (self.high - self.low) * fraction) * R::UNIT
    }
}

impl<'de, R: Range> Deserialize<'de> for Span<R> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let two = OneOrTuple::<R, 2>::new("one number, or a range (low, high)", true);
        let [low, high] = deserializer.deserialize_any(two)?;
        if low <= high {
            return Ok(Self::new(low, high));
        }
        let found = format!("the range ({low}, {high})");
        let expected = "a range (low, high) whose first number is not the larger one";
        Err(D::Error::invalid_value(Unexpected::Other(&found), &expected))
    }
}

/// Integer from `LOW` to `HIGH`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Whole<const LOW: u32, const HIGH: u32>(pub(crate) u32);

impl<const LOW: u32, const HIGH: u32> Whole<LOW, HIGH> {
    /// The number.
    pub fn get(self) -> u32 {
        self.0
    }
}

impl<'de, const LOW: u32, const HIGH: u32> Deserialize<'de> for Whole<LOW, HIGH> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = u64::deserialize(deserializer)?;
        match u32::try_from(value) {
            Ok(whole) if (LOW..=HIGH).contains(&whole) => Ok(Self(whole)),
            _ => {
                let expected = format!("a whole number from {LOW} to {HIGH}");
                Err(D::Error::invalid_value(Unexpected::Unsigned(value), &expected.as_str()))
            }
        }
    }
}

/// Reads a tuple of `N` numbers or, with `one_will_do`, a single one for all.
struct OneOrTuple<R, const N: usize> {
    expected: &'static str,
    one_will_do: bool,
    range: PhantomData<R>,
}

impl<R: Range, const N: usize> OneOrTuple<R, N> {
    fn new(expected: &'static str, one_will_do: bool) -> Self {
        Self { expected, one_will_do, range: PhantomData }
    }
}

impl<'de, R: Range, const N: usize> Visitor<'de> for OneOrTuple<R, N> {
    type Value = [f64; N];

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.expected)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Self::Value, E> {
        if self.one_will_do {
            check::<R, E>(value).map(|value| [value; N])
        } else {
            Err(E::invalid_type(Unexpected::Float(value), &self))
        }
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Self::Value, E> {
        self.visit_f64(value as f64)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Self::Value, E> {
        self.visit_f64(value as f64)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<Self::Value, A::Error> {
        let mut values = [0.0; N];
        for (index, value) in values.iter_mut().enumerate() {
            let number = sequence.next_element::<Number<R>>()?;
            *value = number.ok_or_else(|| A::Error::invalid_length(index, &self))?.value;
        }
        if sequence.next_element::<IgnoredAny>()?.is_some() {
            return Err(A::Error::invalid_length(N + 1, &self));
        }
        Ok(values)
    }
}
