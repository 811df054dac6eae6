//! Ranges of fields. In goes a number in the author's unit, out comes whether it is in range. Invariant:
//! callers pass finite numbers only.

use std::ops::RangeInclusive;

/// Set of valid numbers.
pub trait Range: Copy {
    /// Expectation in the error for a number out of range.
    const EXPECTED: &'static str;
    /// Factor to SI units.
    const UNIT: f64 = 1.0;
    /// Whether `value`, finite and in the author's unit, lies in the range.
    fn contains(value: f64) -> bool;
}

/// Defines ranges, one a row: the expectation in errors, the test, and the unit if it is not SI's.
macro_rules! ranges {
    ($($(#[$doc:meta])* $name:ident: $expected:literal, $contains:expr $(, $unit:expr)?;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum $name {}

        impl Range for $name {
            const EXPECTED: &'static str = $expected;
            $(const UNIT: f64 = $unit;)?
            fn contains(value: f64) -> bool {
                let contains: fn(f64) -> bool = $contains;
                contains(value)
            }
        }
    )*};
}

/// Radians.
const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Full fields of view that numerics.md guarantees, degrees.
pub const FIELDS_OF_VIEW_DEG: RangeInclusive<f64> = 1e-4..=179.9;
/// Minimum f-stop: beyond it the opening is wider than its view.
pub const SMALLEST_F_STOP: f64 = 1e-3;
/// Minimum distance of focus: nearer planes lie within the rounding of positions.
pub const NEAREST_FOCUS_M: f64 = 1e-6;

ranges! {
    /// Any finite number.
    Finite: "a finite number, at most 1e15 in magnitude", |_| true;
    /// `0..`.
    NonNegative: "a finite number that is 0 or more", |value| value >= 0.0;
    /// More than 0.
    Positive: "a finite number greater than 0", |value| value > 0.0;
    /// `0..=1`.
    UnitInterval: "a number from 0 to 1", |value| (0.0..=1.0).contains(&value);
    /// More than 0, at most 1.
    RelativeError: "a relative error greater than 0 and at most 1, such as 0.02 for 2 %", |value| 0.0 < value && value <= 1.0;
    /// Stops, powers of two that multiply light: -100 to 100.
    Stops: "powers of two from -100 to 100, such as 1 for twice as bright", |value| value.abs() <= 100.0;
    /// At most 0.9999 in magnitude.
    Anisotropy: "a number from -0.9999 to 0.9999", |value| value.abs() <= 0.9999;
    /// Any angle, in degrees.
    Degrees: "a finite angle in degrees", |_| true, DEGREE;
    /// Full field of view in degrees.
    FieldOfView: "an angle from 0.0001 to 179.9 degrees", |value| FIELDS_OF_VIEW_DEG.contains(&value), DEGREE;
    /// Focal length over the diameter of a lens' opening.
    FStop: "an f-stop of at least 0.001, such as 2.8", |value| value >= SMALLEST_F_STOP;
    /// Distance of the plane in focus, metres.
    FocusDistance: "a distance of at least 0.000001 m", |value| value >= NEAREST_FOCUS_M;
    /// Full angle of a disc in degrees: 0 or more, less than 180.
    DiscAngle: "an angle of at least 0 and less than 180 degrees", |value| (0.0..180.0).contains(&value), DEGREE;
    /// Real or imaginary part of the constant of a Julia set; beyond it every point escapes.
    JuliaPart: "a number from -2 to 2", |value| (-2.0..=2.0).contains(&value);
    /// Half angle of a cone in degrees: more than 0, at most 90.
    HalfAngle: "an angle greater than 0 and at most 90 degrees", |value| 0.0 < value && value <= 90.0, DEGREE;
    /// Length or width of a leaf, in metres.
    LeafLength: "a length from 0.005 to 1 m", |value| (0.005..=1.0).contains(&value);
    /// Mass per area of a leaf, in kilograms per square metre.
    ArealMass: "from 0.01 to 2 kg/m2; paper and leaves have about 0.08", |value| (0.01..=2.0).contains(&value);
    /// Velocity of air along an axis, m/s, beyond that of any storm.
    AirVelocity: "from -200 to 200 m/s along each axis; a hurricane has 70", |value| value.abs() <= 200.0;
    /// Speed of air in any direction, m/s.
    AirSpeed: "from 0 to 200 m/s; a hurricane has 70", |value| (0.0..=200.0).contains(&value);
    /// Time scale of gusts in seconds, or size of eddies in metres.
    GustScale: "a number of at least 0.01", |value| value >= 0.01;
    /// Factor on speeds.
    SpeedGain: "a factor from 0.1 to 10", |value| (0.1..=10.0).contains(&value);
}
