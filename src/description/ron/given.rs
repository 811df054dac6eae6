//! Numbers from code. In go plain numbers, out come those of fields. Invariant: a number out of range fails
//! to serialize, just as it fails to parse; this is how parts are validated.

use super::animated::{Animated, Keyable};
use super::number::{
    Direction, Finite, Number, Point, Quaternion, QuaternionRate, Span, Three, Triple, Whole,
};
use super::number::{Range, unmet};
use glam::{DQuat, DVec3};
use serde::ser::{Error, Serialize, Serializer};
use std::fmt::Display;

impl<R> Default for Number<R> {
    /// 0, whether or not it is in range.
    fn default() -> Self {
        Self::new(0.0)
    }
}

impl<R, const ONE_WILL_DO: bool> Default for Three<R, ONE_WILL_DO> {
    /// 0, whether or not it is in range.
    fn default() -> Self {
        Self::new(DVec3::ZERO)
    }
}

impl<R> Default for Span<R> {
    /// 0, whether or not it is in range.
    fn default() -> Self {
        Self::new(0.0, 0.0)
    }
}

impl<R> From<f64> for Number<R> {
    fn from(value: f64) -> Self {
        Self::new(value)
    }
}

impl<R, const ONE_WILL_DO: bool> From<[f64; 3]> for Three<R, ONE_WILL_DO> {
    fn from(values: [f64; 3]) -> Self {
        Self::new(DVec3::from_array(values))
    }
}

impl<R> From<f64> for Triple<R> {
    fn from(value: f64) -> Self {
        Self::new(DVec3::splat(value))
    }
}

impl<R> From<f64> for Span<R> {
    fn from(value: f64) -> Self {
        Self::new(value, value)
    }
}

impl<R> From<[f64; 2]> for Span<R> {
    fn from([low, high]: [f64; 2]) -> Self {
        Self::new(low, high)
    }
}

impl<const LOW: u32, const HIGH: u32> From<u32> for Whole<LOW, HIGH> {
    fn from(value: u32) -> Self {
        Self(value)
    }
}

impl From<[f64; 3]> for Direction {
    fn from(vector: [f64; 3]) -> Self {
        Self(DVec3::from_array(vector))
    }
}

impl From<[f64; 4]> for Quaternion {
    fn from(values: [f64; 4]) -> Self {
        Self(DQuat::from_array(values).normalize())
    }
}

impl From<[f64; 4]> for QuaternionRate {
    fn from(values: [f64; 4]) -> Self {
        Self(DQuat::from_array(values))
    }
}

impl<T: Keyable> From<T> for Animated<T> {
    fn from(value: T) -> Self {
        Self::Still(value)
    }
}

impl<T: Keyable + From<f64>> From<f64> for Animated<T> {
    fn from(value: f64) -> Self {
        Self::Still(value.into())
    }
}

impl<T: Keyable + From<[f64; N]>, const N: usize> From<[f64; N]> for Animated<T> {
    fn from(values: [f64; N]) -> Self {
        Self::Still(values.into())
    }
}

impl<R: Range> Serialize for Number<R> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match unmet::<R>(self.value()) {
            None => serializer.serialize_f64(self.value()),
            Some(expected) => refuse(self.value(), expected),
        }
    }
}

impl<R: Range, const ONE_WILL_DO: bool> Serialize for Three<R, ONE_WILL_DO> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.value().to_array().map(Number::<R>::new).serialize(serializer)
    }
}

impl<R: Range> Serialize for Span<R> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let [low, high] = self.ends();
        if low > high {
            return refuse(format!("the range ({low}, {high})"), "the lower number first");
        }
        [low, high].map(Number::<R>::new).serialize(serializer)
    }
}

impl<const LOW: u32, const HIGH: u32> Serialize for Whole<LOW, HIGH> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if (LOW..=HIGH).contains(&self.0) {
            return serializer.serialize_u32(self.0);
        }
        refuse(self.0, format!("a whole number from {LOW} to {HIGH}"))
    }
}

impl Serialize for Direction {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.0.is_finite() && self.0.try_normalize().is_none() {
            return refuse("a vector of length 0", "a direction (x, y, z)");
        }
        Point::new(self.0).serialize(serializer)
    }
}

impl Serialize for Quaternion {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if !self.0.is_finite() {
            return refuse("a quaternion without a direction", "four finite numbers that are not all 0");
        }
        QuaternionRate(self.0).serialize(serializer)
    }
}

impl Serialize for QuaternionRate {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.to_array().map(Number::<Finite>::new).serialize(serializer)
    }
}

/// Error with a finding and an expectation, as in readers of files.
fn refuse<T, E: Error>(found: impl Display, expected: impl Display) -> Result<T, E> {
    Err(E::custom(format_args!("{found} does not belong here, expected {expected}")))
}
