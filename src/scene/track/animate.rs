//! Values that can be keyed: numbers, vectors, turns, switches. In go values, out come values between
//! them. Invariant: a value between two is valid if they are.

use glam::{DQuat, DVec3};

/// Value that can be keyed.
pub trait Animate: Copy + PartialEq {
    /// The derivative of a value that does not change.
    const ZERO: Self;
    /// Number of single-precision numbers that may stand for a value; 0 if that is not provided for.
    const SINGLES: usize = 0;
    /// Appends the value in single precision.
    fn push_singles(self, _out: &mut Vec<f32>) {}
    /// The value of so many of them.
    fn from_singles(_singles: &[f32]) -> Self {
        Self::ZERO
    }
    /// Linear interpolation from `a` at 0 to `b` at 1.
    fn lerp(a: Self, b: Self, fraction: f64) -> Self;
    /// `sum(weights[i] * values[i])`, brought back to where such values live (unit quaternions).
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
    const SINGLES: usize = 3;
    fn push_singles(self, out: &mut Vec<f32>) {
        out.extend(self.as_vec3().to_array());
    }
    fn from_singles(singles: &[f32]) -> Self {
        glam::Vec3::from_slice(singles).as_dvec3()
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
    const SINGLES: usize = 4;
    fn push_singles(self, out: &mut Vec<f32>) {
        out.extend(self.as_quat().to_array());
    }
    fn from_singles(singles: &[f32]) -> Self {
        glam::Quat::from_slice(singles).as_dquat()
    }

    /// Shoemake's slerp (SIGGRAPH 1985) along the shorter arc. The angle comes from an arc tangent:
    /// near zero, where keys of a slow turn are, an arc cosine would lose half the digits.
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

/// The quaternion at unit length; the identity where it has none (two opposite keys blended).
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
