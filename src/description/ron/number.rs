//! Numbers that know their range. In goes RON, out come finite values; invariant: a number that
//! was read lies in its range, and one that does not is an error at its own line and column.

use glam::{DQuat, DVec3};
use serde::de::{Deserialize, Deserializer, Error, IgnoredAny, SeqAccess, Unexpected, Visitor};
use std::fmt;
use std::marker::PhantomData;

/// Larger magnitudes are refused, so that squares stay finite in the `f32` of the kernels.
const MAX_MAGNITUDE: f64 = 1e15;

/// A set of admissible numbers.
pub trait Range: Copy {
    /// What to say to someone who left it.
    const EXPECTED: &'static str;
    /// What a number is multiplied by to get SI units.
    const UNIT: f64 = 1.0;
    /// Whether `value`, finite and in the author's unit, lies in the range.
    fn contains(value: f64) -> bool;
}

/// Any finite number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Finite {}
/// `0..`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NonNegative {}
/// More than 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Positive {}
/// `0..=1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UnitInterval {}
/// More than 0, at most 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RelativeError {}
/// Powers of two by which light is multiplied: within 100 of 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stops {}
/// At most 0.9999 in magnitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Anisotropy {}
/// Any angle, in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Degrees {}
/// A whole field of view in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FieldOfView {}
/// Focal length over the diameter of a lens' opening.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FStop {}
/// How far away a lens is in focus, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FocusDistance {}
/// The whole angle under which a disc is seen, in degrees: 0 or more, less than 180.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DiscAngle {}
/// A part of the constant of a Julia set; beyond it every point escapes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JuliaPart {}
/// Half the opening of a cone in degrees: more than 0, at most 90.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HalfAngle {}

/// Length or width of something light enough to be borne by the air, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LeafLength {}
/// Mass over area of such a thing, in kilograms per square metre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ArealMass {}
/// Speed of the air along an axis, m/s: no storm is faster.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AirVelocity {}
/// The same whatever its direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AirSpeed {}
/// From gust to gust in seconds, or across an eddy in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GustScale {}
/// A factor on speeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpeedGain {}

impl Range for Finite {
    const EXPECTED: &'static str = "a finite number, at most 1e15 in magnitude";
    fn contains(_: f64) -> bool {
        true
    }
}

impl Range for NonNegative {
    const EXPECTED: &'static str = "a finite number that is 0 or more";
    fn contains(value: f64) -> bool {
        value >= 0.0
    }
}

impl Range for Positive {
    const EXPECTED: &'static str = "a finite number greater than 0";
    fn contains(value: f64) -> bool {
        value > 0.0
    }
}

impl Range for UnitInterval {
    const EXPECTED: &'static str = "a number from 0 to 1";
    fn contains(value: f64) -> bool {
        (0.0..=1.0).contains(&value)
    }
}

impl Range for RelativeError {
    const EXPECTED: &'static str = "a relative error greater than 0 and at most 1, such as 0.02 for 2 %";
    fn contains(value: f64) -> bool {
        0.0 < value && value <= 1.0
    }
}

impl Range for Stops {
    const EXPECTED: &'static str = "powers of two from -100 to 100, such as 1 for twice as bright";
    fn contains(value: f64) -> bool {
        value.abs() <= 100.0
    }
}

impl Range for Anisotropy {
    const EXPECTED: &'static str = "a number from -0.9999 to 0.9999";
    fn contains(value: f64) -> bool {
        value.abs() <= 0.9999
    }
}

impl Range for Degrees {
    const EXPECTED: &'static str = "a finite angle in degrees";
    const UNIT: f64 = std::f64::consts::PI / 180.0;
    fn contains(_: f64) -> bool {
        true
    }
}

impl Range for FieldOfView {
    const EXPECTED: &'static str = "an angle from 0.0001 to 179.9 degrees";
    const UNIT: f64 = Degrees::UNIT;
    fn contains(value: f64) -> bool {
        (1e-4..=179.9).contains(&value)
    }
}

impl Range for FStop {
    const EXPECTED: &'static str = "an f-stop of at least 0.001, such as 2.8";
    fn contains(value: f64) -> bool {
        value >= 1e-3
    }
}

impl Range for FocusDistance {
    const EXPECTED: &'static str = "a distance of at least 0.000001 m";
    fn contains(value: f64) -> bool {
        value >= 1e-6
    }
}

impl Range for DiscAngle {
    const EXPECTED: &'static str = "an angle of at least 0 and less than 180 degrees";
    const UNIT: f64 = Degrees::UNIT;
    fn contains(value: f64) -> bool {
        (0.0..180.0).contains(&value)
    }
}

impl Range for JuliaPart {
    const EXPECTED: &'static str = "a number from -2 to 2";
    fn contains(value: f64) -> bool {
        (-2.0..=2.0).contains(&value)
    }
}

impl Range for HalfAngle {
    const EXPECTED: &'static str = "an angle greater than 0 and at most 90 degrees";
    const UNIT: f64 = Degrees::UNIT;
    fn contains(value: f64) -> bool {
        0.0 < value && value <= 90.0
    }
}

impl Range for LeafLength {
    const EXPECTED: &'static str = "a length from 0.005 to 1 m";
    fn contains(value: f64) -> bool {
        (0.005..=1.0).contains(&value)
    }
}

impl Range for ArealMass {
    const EXPECTED: &'static str = "from 0.01 to 2 kg/m2; paper and leaves have about 0.08";
    fn contains(value: f64) -> bool {
        (0.01..=2.0).contains(&value)
    }
}

impl Range for AirVelocity {
    const EXPECTED: &'static str = "from -200 to 200 m/s along each axis; a hurricane has 70";
    fn contains(value: f64) -> bool {
        value.abs() <= 200.0
    }
}

impl Range for AirSpeed {
    const EXPECTED: &'static str = "from 0 to 200 m/s; a hurricane has 70";
    fn contains(value: f64) -> bool {
        (0.0..=200.0).contains(&value)
    }
}

impl Range for GustScale {
    const EXPECTED: &'static str = "a number of at least 0.01";
    fn contains(value: f64) -> bool {
        value >= 0.01
    }
}

impl Range for SpeedGain {
    const EXPECTED: &'static str = "a factor from 0.1 to 10";
    fn contains(value: f64) -> bool {
        (0.1..=10.0).contains(&value)
    }
}

/// One number in a range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Number<R> {
    value: f64,
    range: PhantomData<R>,
}

impl<R: Range> Number<R> {
    /// A default that the program itself writes down.
    pub(crate) const fn new(value: f64) -> Self {
        Self { value, range: PhantomData }
    }

    /// The number in SI units: radians for angles, else as the author wrote it.
    pub fn si(self) -> f64 {
        self.value * R::UNIT
    }
}

impl Default for Number<NonNegative> {
    fn default() -> Self {
        Self::new(0.0)
    }
}

impl<'de, R: Range> Deserialize<'de> for Number<R> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        check::<R, D::Error>(f64::deserialize(deserializer)?).map(Self::new)
    }
}

fn check<R: Range, E: Error>(value: f64) -> Result<f64, E> {
    if value.is_finite() && value.abs() > MAX_MAGNITUDE && R::contains(value) {
        Err(E::invalid_value(Unexpected::Float(value), &Finite::EXPECTED))
    } else if value.is_finite() && R::contains(value) {
        Ok(value)
    } else {
        Err(E::invalid_value(Unexpected::Float(value), &R::EXPECTED))
    }
}

/// Three numbers `(x, y, z)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vector<R> {
    value: DVec3,
    range: PhantomData<R>,
}

/// A position or displacement.
pub type Point = Vector<Finite>;

impl<R: Range> Vector<R> {
    /// A default that the program itself writes down.
    pub(crate) const fn new(value: DVec3) -> Self {
        Self { value, range: PhantomData }
    }

    /// The vector in SI units.
    pub fn si(self) -> DVec3 {
        self.value * R::UNIT
    }
}

impl<'de, R: Range> Deserialize<'de> for Vector<R> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match deserializer.deserialize_any(OneOrTuple::<R, 3>::new("three numbers (x, y, z)", false))? {
            NumberOrTuple::Tuple(values) => Ok(Self::new(DVec3::from_array(values))),
            NumberOrTuple::Number(value) => Ok(Self::new(DVec3::splat(value))),
        }
    }
}

/// A vector that is not zero; its length means nothing.
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

/// Three numbers `(x, y, z)`, or one that stands for all three.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triple<R> {
    value: DVec3,
    range: PhantomData<R>,
}

impl<R: Range> Triple<R> {
    /// A default that the program itself writes down.
    pub(crate) const fn new(value: DVec3) -> Self {
        Self { value, range: PhantomData }
    }

    /// The numbers in SI units.
    pub fn si(self) -> DVec3 {
        self.value * R::UNIT
    }
}

impl<'de, R: Range> Deserialize<'de> for Triple<R> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let visitor = OneOrTuple::<R, 3>::new("one number, or three numbers (x, y, z)", true);
        Ok(Self::new(match deserializer.deserialize_any(visitor)? {
            NumberOrTuple::Number(value) => DVec3::splat(value),
            NumberOrTuple::Tuple(values) => DVec3::from_array(values),
        }))
    }
}

/// A rotation `(x, y, z, w)`; brought to unit length when it is read.
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

/// How fast a quaternion's four numbers change, per second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuaternionRate(pub(crate) DQuat);

impl<'de> Deserialize<'de> for QuaternionRate {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match deserializer
            .deserialize_any(OneOrTuple::<Finite, 4>::new("four numbers (x, y, z, w)", false))?
        {
            NumberOrTuple::Tuple(values) => Ok(Self(DQuat::from_array(values))),
            NumberOrTuple::Number(value) => Ok(Self(DQuat::from_array([value; 4]))),
        }
    }
}

/// From `low` to `high`; written `(low, high)`, or as one number that is both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span<R> {
    low: f64,
    high: f64,
    range: PhantomData<R>,
}

impl<R: Range> Span<R> {
    /// A default that the program itself writes down.
    pub(crate) const fn new(low: f64, high: f64) -> Self {
        Self { low, high, range: PhantomData }
    }

    /// The value at `fraction`, from 0 for `low` to 1 for `high`, in SI units.
    pub fn at(self, fraction: f64) -> f64 {
        (self.low + (self.high - self.low) * fraction) * R::UNIT
    }
}

impl<'de, R: Range> Deserialize<'de> for Span<R> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match deserializer
            .deserialize_any(OneOrTuple::<R, 2>::new("one number, or a range (low, high)", true))?
        {
            NumberOrTuple::Number(value) => Ok(Self::new(value, value)),
            NumberOrTuple::Tuple([low, high]) if low <= high => Ok(Self::new(low, high)),
            NumberOrTuple::Tuple([low, high]) => Err(D::Error::invalid_value(
                Unexpected::Other(&format!("the range ({low}, {high})")),
                &"a range (low, high) whose first number is not the larger one",
            )),
        }
    }
}

/// A whole number from `LOW` to `HIGH`.
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

/// What [`OneOrTuple`] found.
enum NumberOrTuple<const N: usize> {
    Number(f64),
    Tuple([f64; N]),
}

/// Reads a tuple of `N` numbers or, where `one_will_do`, a single one.
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
    type Value = NumberOrTuple<N>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.expected)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Self::Value, E> {
        if self.one_will_do {
            check::<R, E>(value).map(NumberOrTuple::Number)
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
        Ok(NumberOrTuple::Tuple(values))
    }
}
