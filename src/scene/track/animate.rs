//! Types that can be keyed: numbers, vectors, rotations, switches. In go values, out come interpolated ones.
//! Invariant: interpolation of valid values is valid.

use glam::{DQuat, DVec3};
use half::f16;

/// Type that can be keyed.
pub trait Animate: Copy + PartialEq {
    /// Derivative of a constant.
    const ZERO: Self;
    /// Bytes of the compact form of a value and its derivative; 0 without one.
    const BYTES: usize = 0;
    /// Appends the compact form, with numbers rounded to its precision.
    fn push_bytes(self, _derivative: Self, _out: &mut Vec<u8>) {}
    /// Decodes a value and its derivative.
    fn from_bytes(_bytes: &[u8]) -> (Self, Self) {
        (Self::ZERO, Self::ZERO)
    }
    /// Linear interpolation from `a` at 0 to `b` at 1.
    fn lerp(a: Self, b: Self, fraction: f64) -> Self;
    /// `sum(weights[i] * values[i])`, projected to valid values (unit quaternions).
    fn blend(values: [Self; 4], weights: [f64; 4]) -> Self;
}

impl Animate for f64 {
    const ZERO: Self = 0.0;
    fn lerp(a: Self, b: Self, fraction: f64) -> Self {
        a + (b - a) * fraction
    }
    fn blend(v: [Self; 4], w: [f64; 4]) -> Self {
        v[0] * w[0] + v[1] * w[1] + v[2] * w[2] + v[3] * w[3]
    }
}

impl Animate for DVec3 {
    const ZERO: Self = Self::ZERO;

    // Values have 24 bits, derivatives 11: between keys these matter less.
    const BYTES: usize = 3 * (4 + 2);
    fn push_bytes(self, derivative: Self, out: &mut Vec<u8>) {
        out.extend(self.as_vec3().to_array().into_iter().flat_map(f32::to_le_bytes));
        push_halves(&derivative.to_array(), out);
    }
    fn from_bytes(bytes: &[u8]) -> (Self, Self) {
        let (value, derivative) = bytes.split_at(3 * 4);
        let single = |at: usize| f32::from_le_bytes(array(value, at));
        (glam::Vec3::new(single(0), single(1), single(2)).as_dvec3(), Self::from_array(halves(derivative)))
    }

    fn lerp(a: Self, b: Self, fraction: f64) -> Self {
        a + (b - a) * fraction
    }
    fn blend(v: [Self; 4], w: [f64; 4]) -> Self {
        v[0] * w[0] + v[1] * w[1] + v[2] * w[2] + v[3] * w[3]
    }
}

impl<const N: usize> Animate for [f64; N] {
    const ZERO: Self = [0.0; N];
    fn lerp(a: Self, b: Self, fraction: f64) -> Self {
        std::array::from_fn(|index| f64::lerp(a[index], b[index], fraction))
    }
    fn blend(v: [Self; 4], w: [f64; 4]) -> Self {
        std::array::from_fn(|index| f64::blend(v.map(|values| values[index]), w))
    }
}

impl Animate for DQuat {
    const ZERO: Self = Self::from_xyzw(0.0, 0.0, 0.0, 0.0);
    // Components of a unit quaternion in 16-bit integers, uniformly fine.
    const BYTES: usize = 4 * (2 + 2);
    fn push_bytes(self, derivative: Self, out: &mut Vec<u8>) {
        let whole = |number: f64| (number * FINENESS).round() as i16;
        out.extend(self.to_array().into_iter().flat_map(|number| whole(number).to_le_bytes()));
        push_halves(&derivative.to_array(), out);
    }
    fn from_bytes(bytes: &[u8]) -> (Self, Self) {
        let (value, derivative) = bytes.split_at(4 * 2);
        let number = |at: usize| f64::from(i16::from_le_bytes(array(value, at))) / FINENESS;
        (Self::from_array(std::array::from_fn(number)), Self::from_array(halves(derivative)))
    }

    /// Shoemake's slerp (SIGGRAPH 1985) along the shorter arc. The angle comes from an arc tangent: near
    /// zero, for keys of a slow rotation, an arc cosine would lose half the digits.
    fn lerp(a: Self, b: Self, fraction: f64) -> Self {
        let b = if a.dot(b) < 0.0 { -b } else { b };
        let angle = 2.0 * f64::atan2((a - b).length(), (a + b).length());
        let sine = angle.sin();
        if sine == 0.0 {
            return a;
        }
        unit(a * (((1.0 - fraction) * angle).sin() / sine) + b * ((fraction * angle).sin() / sine))
    }

    fn blend(v: [Self; 4], w: [f64; 4]) -> Self {
        unit(v[0] * w[0] + v[1] * w[1] + v[2] * w[2] + v[3] * w[3])
    }
}

/// Steps of the 16-bit integers for numbers from -1 to 1.
const FINENESS: f64 = 32768.0;

/// Appends numbers in half precision, clamped below infinity.
fn push_halves(numbers: &[f64], out: &mut Vec<u8>) {
    let most = f16::MAX.to_f64();
    out.extend(numbers.iter().flat_map(|&number| f16::from_f64(number.clamp(-most, most)).to_le_bytes()));
}

fn halves<const N: usize>(bytes: &[u8]) -> [f64; N] {
    std::array::from_fn(|at| f16::from_le_bytes(array(bytes, at)).to_f64())
}

/// Bytes of the number at an index.
fn array<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    std::array::from_fn(|byte| bytes[N * at + byte])
}

/// Quaternion at unit length; the identity if it is zero (two opposite keys blended).
fn unit(quaternion: DQuat) -> DQuat {
    let length = quaternion.length();
    if length > 0.0 { quaternion * length.recip() } else { DQuat::IDENTITY }
}

/// Visibility: switches at keys only.
impl Animate for bool {
    const ZERO: Self = false;
    fn lerp(a: Self, b: Self, fraction: f64) -> Self {
        if fraction < 1.0 { a } else { b }
    }
    fn blend(v: [Self; 4], _w: [f64; 4]) -> Self {
        v[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn quaternion() -> impl Strategy<Value = DQuat> {
        prop::array::uniform4(-1.0..1.0_f64)
            .prop_filter("too short to normalise", |v| v.iter().map(|x| x * x).sum::<f64>() > 1e-3)
            .prop_map(|v| DQuat::from_array(v).normalize())
    }

    proptest! {
        #[test]
        fn slerp_takes_the_shorter_arc_at_constant_speed(
            a in quaternion(), b in quaternion(), fraction in 0.0..1.0_f64
        ) {
            let middle: DQuat = Animate::lerp(a, b, fraction);
            let angle = |p: DQuat, q: DQuat| 2.0 * f64::atan2((p - q).length().min((p + q).length()), (p - q).length().max((p + q).length()));
            prop_assert!((middle.length() - 1.0).abs() < 1e-12);
            prop_assert!((angle(a, middle) - fraction * angle(a, b)).abs() < 1e-9);
            prop_assert!((angle(middle, b) - (1.0 - fraction) * angle(a, b)).abs() < 1e-9);
        }

        #[test]
        fn slerp_of_near_parallel_quaternions_keeps_its_digits(
            a in quaternion(), log_angle in -12.0..-1.0_f64, fraction in 0.0..1.0_f64
        ) {
            let turn = |angle: f64| DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), angle);
            let angle = 10.0_f64.powf(log_angle);
            let error: DQuat = <DQuat as Animate>::lerp(a, turn(angle) * a, fraction) - turn(angle * fraction) * a;
            prop_assert!(error.length() < 1e-15 + 1e-12 * angle);
        }
    }
}
