//! The way from one key to the next. In go two keys, out comes the value at any time between them.
//! Invariant: time never runs backwards, so that every time between two keys has exactly one value.

use super::{Animate, Key};

/// Way of a value from one key to the next.
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
    /// Blender's Bezier curve: time and value of the two inner control points. A handle that reaches
    /// beyond the other key is shortened to end there, as Blender does.
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
    /// A cubic stays within the hull of its ends and of these.
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

/// The value on the way from one key to the next.
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
            // Each handle as (fraction of the duration, value), measured from its own key.
            let (leave_x, leave) = shortened((leave.time_s - from.time_s) / duration_s, from.value, leave);
            let (arrive_x, arrive) = shortened((to.time_s - arrive.time_s) / duration_s, to.value, arrive);
            let s = bezier_parameter(fraction, leave_x, 1.0 - arrive_x);
            T::blend([from.value, leave, arrive, to.value], bernstein(s))
        }
    }
}

/// A handle that reaches at most to the other key, so that time never runs backwards: its reach as a
/// fraction of the segment's duration, and its value. The same line is kept, only shortened
/// (Blender, `BKE_fcurve_correct_bezpart` in blenkernel/intern/fcurve.cc).
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

/// The parameter at which the Bezier curve with abscissas 0, `x1`, `x2`, 1 is at `x`; all in `0..=1`,
/// which makes the abscissa increase with the parameter.
fn bezier_parameter(x: f64, x1: f64, x2: f64) -> f64 {
    // Newton's method, kept inside a bracket that halves when a step would leave it.
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
