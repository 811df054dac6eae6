//! Segment from one key to the next. In go two keys, out comes the value at any time between them. Invariant:
//! time never runs backwards on a curve, so that every time has exactly one value.

use super::{Animate, Key};

/// Interpolation from one key to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Segment<T> {
    /// Constant until the next key.
    Step,
    /// Linear; for quaternions along the shorter arc.
    Linear,
    /// glTF's cubic spline (specification, appendix C): derivatives per second at both ends.
    Hermite {
        /// Derivative after this key.
        leave: T,
        /// Derivative before the next key.
        arrive: T,
    },
    /// Blender's Bezier curve: time and value of the two inner control points. A handle beyond the other key
    /// is shortened to end there, as in Blender.
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

impl<T: Animate> Key<T> {
    /// Inner Bezier control points: the curve stays in the hull of its ends and of these.
    pub(in crate::inside::scene) fn inner_control_points(&self, next: &Self) -> Vec<T> {
        let third_s = (next.time_s - self.time_s) / 3.0;
        let along =
            |value: T, rate: T, time_s: f64| T::blend([value, rate, value, value], [1.0, time_s, 0.0, 0.0]);
        match self.to_next {
            Segment::Step | Segment::Linear => Vec::new(),
            Segment::Hermite { leave, arrive } => {
                vec![along(self.value, leave, third_s), along(next.value, arrive, -third_s)]
            }
            Segment::Bezier { leave, arrive } => vec![leave.value, arrive.value],
        }
    }
}

/// Value between two keys.
pub(super) fn between<T: Animate>(from: &Key<T>, to: &Key<T>, time_s: f64) -> T {
    let duration_s = to.time_s - from.time_s;
    let fraction = ((time_s - from.time_s) / duration_s).clamp(0.0, 1.0);
    match from.to_next {
        Segment::Step => from.value,
        Segment::Linear => T::lerp(from.value, to.value, fraction),
        Segment::Hermite { leave, arrive } => {
            // glTF 2.0 specification, appendix C.4.
            let (t, t2, t3) = (fraction, fraction * fraction, fraction * fraction * fraction);
            T::blend(
                [from.value, leave, to.value, arrive],
                [
                    2.0 * t3 - 3.0 * t2 + 1.0,
                    duration_s * (t3 - 2.0 * t2 + t),
                    -2.0 * t3 + 3.0 * t2,
                    duration_s * (t3 - t2),
                ],
            )
        }
        Segment::Bezier { leave, arrive } => {
            // Handles as (fraction of the duration, value), relative to their own keys.
            let (leave_x, leave) = shortened((leave.time_s - from.time_s) / duration_s, from.value, leave);
            let (arrive_x, arrive) = shortened((to.time_s - arrive.time_s) / duration_s, to.value, arrive);
            let s = bezier_parameter(fraction, leave_x, 1.0 - arrive_x);
            T::blend([from.value, leave, arrive, to.value], bernstein(s))
        }
    }
}

/// Handle that reaches at most to the other key, so that time never runs backwards: its reach as a fraction
/// of the duration, and its value. Its direction is kept (Blender, `BKE_fcurve_correct_bezpart` in
/// blenkernel/intern/fcurve.cc).
fn shortened<T: Animate>(reach: f64, key: T, handle: Handle<T>) -> (f64, T) {
    if reach <= 1.0 {
        (reach.max(0.0), handle.value)
    } else {
        let kept = 1.0 / reach;
        (1.0, T::blend([key, handle.value, key, key], [1.0 - kept, kept, 0.0, 0.0]))
    }
}

fn bernstein(s: f64) -> [f64; 4] {
    let r = 1.0 - s;
    [r * r * r, 3.0 * r * r * s, 3.0 * r * s * s, s * s * s]
}

/// Parameter at which the Bezier curve with abscissas 0, `x1`, `x2`, 1 is at `x`; all in `0..=1`, so the
/// abscissa increases with the parameter.
fn bezier_parameter(x: f64, x1: f64, x2: f64) -> f64 {
    // Newton's method, with bisection where a step would leave the bracket.
    let (mut low, mut high) = (0.0, 1.0);
    let mut s = x;
    for _ in 0..64 {
        let r = 1.0 - s;
        let [_, w1, w2, w3] = bernstein(s);
        let error = w1 * x1 + w2 * x2 + w3 - x;
        if error.abs() < 1e-15 {
            break;
        }
        if error > 0.0 {
            high = s;
        } else {
            low = s;
        }
        let slope = 3.0 * (r * r * x1 + 2.0 * r * s * (x2 - x1) + s * s * (1.0 - x2));
        let newton = s - error / slope;
        s = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
    }
    s
}
