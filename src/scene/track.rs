//! Keys in, the value at any time out. Invariant: at least one key, key times strictly increasing,
//! so that every time has exactly one value.

use glam::{DQuat, DVec3};

/// A keyed value.
#[derive(Clone, Debug, PartialEq)]
pub struct Track<T> {
    times_s: Vec<f64>,
    /// As many as times.
    values: Vec<T>,
    to_next: Ways<T>,
    extend: Extend,
}

/// How a track goes on from key to key. Any curves take several times the memory of what scenes by the
/// thousand nodes are made of: straight lines between sampled keys, and smooth curves.
#[derive(Clone, Debug, PartialEq)]
enum Ways<T> {
    /// From every key in the same way.
    Alike(Segment<T>),
    /// Splines with one slope at each key, on both its sides.
    Smooth(Vec<T>),
    /// As many as keys.
    Each(Vec<Segment<T>>),
}

/// What a track does outside its keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Extend {
    /// Keeps the first or last value.
    #[default]
    Hold,
    /// Starts over, before the first key too. The last key only closes the period: the value there
    /// is the first key's again.
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

/// What can be keyed.
pub trait Animate: Copy + PartialEq {
    /// The derivative of a value that does not change.
    const ZERO: Self;
    /// From `a` at 0 to `b` at 1.
    fn lerp(a: Self, b: Self, fraction: f64) -> Self;
    /// `sum(weights[i] * values[i])`, brought back to where such values live (unit quaternions).
    fn blend(values: [Self; 4], weights: [f64; 4]) -> Self;
}

impl<T: Copy> From<T> for Track<T> {
    fn from(value: T) -> Self {
        let (times_s, values) = (vec![0.0], vec![value]);
        Self { times_s, values, to_next: Ways::Alike(Segment::Step), extend: Extend::Hold }
    }
}

impl<T: Copy> Track<T> {
    /// The same with a linear function of every value: keys and derivatives alike.
    pub fn map_linear<U>(&self, map: impl Fn(T) -> U) -> Track<U> {
        let handle = |handle: Handle<T>| Handle { time_s: handle.time_s, value: map(handle.value) };
        let segment = |segment: &Segment<T>| match *segment {
            Segment::Step => Segment::Step,
            Segment::Linear => Segment::Linear,
            Segment::Hermite { leave, arrive } => Segment::Hermite { leave: map(leave), arrive: map(arrive) },
            Segment::Bezier { leave, arrive } => {
                Segment::Bezier { leave: handle(leave), arrive: handle(arrive) }
            }
        };
        Track {
            times_s: self.times_s.clone(),
            values: self.values.iter().map(|&value| map(value)).collect(),
            to_next: match &self.to_next {
                Ways::Alike(way) => Ways::Alike(segment(way)),
                Ways::Smooth(slopes) => Ways::Smooth(slopes.iter().map(|&slope| map(slope)).collect()),
                Ways::Each(ways) => Ways::Each(ways.iter().map(segment).collect()),
            },
            extend: self.extend,
        }
    }
}

impl<T> Track<T> {
    /// When the keys are, seconds.
    pub fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    /// What it does outside its keys.
    pub fn extend(&self) -> Extend {
        self.extend
    }
}

impl<T: Animate> Track<T> {
    /// A track through `keys`; `None` if there are none, a time is not finite, or times do not
    /// strictly increase.
    pub fn new(keys: Vec<Key<T>>, extend: Extend) -> Option<Self> {
        let finite = keys.iter().all(|key| key.time_s.is_finite());
        let increasing = keys.windows(2).all(|pair| pair[0].time_s < pair[1].time_s);
        let first = keys.first().filter(|_| finite && increasing)?;
        let to_next = if keys.iter().all(|key| key.to_next == first.to_next) {
            Ways::Alike(first.to_next)
        } else {
            smooth(&keys).unwrap_or_else(|| Ways::Each(keys.iter().map(|key| key.to_next).collect()))
        };
        let values = keys.iter().map(|key| key.value).collect();
        Some(Self { times_s: keys.iter().map(|key| key.time_s).collect(), values, to_next, extend })
    }

    /// The keys, put together anew.
    pub fn keys(&self) -> Vec<Key<T>> {
        (0..self.times_s.len()).map(|index| self.key(index)).collect()
    }

    fn key(&self, index: usize) -> Key<T> {
        let to_next = match &self.to_next {
            Ways::Alike(way) => *way,
            Ways::Smooth(slopes) => {
                let arrive = slopes.get(index + 1).copied().unwrap_or(T::ZERO);
                Segment::Hermite { leave: slopes[index], arrive }
            }
            Ways::Each(ways) => ways[index],
        };
        Key { time_s: self.times_s[index], value: self.values[index], to_next }
    }

    /// True if the value is the same at all times.
    pub fn is_constant(&self) -> bool {
        (1..self.times_s.len()).all(|next| {
            let Key { value, to_next, .. } = self.key(next - 1);
            let stays = match to_next {
                Segment::Step | Segment::Linear => true,
                Segment::Hermite { leave, arrive } => leave == T::ZERO && arrive == T::ZERO,
                Segment::Bezier { leave, arrive } => leave.value == value && arrive.value == value,
            };
            stays && self.values[next] == value
        })
    }

    /// The value at `time_s`.
    pub fn at(&self, time_s: f64) -> T {
        let time_s = self.time_within_keys(time_s);
        // glTF stores key times in single precision: frame 13 at 24 a second is stored later than
        // 13/24, which must all the same find that key. Only the choice of key is rounded.
        let after = self.times_s.partition_point(|&key_s| key_s as f32 <= time_s as f32);
        if after == 0 || after == self.times_s.len() {
            return self.values[after.saturating_sub(1)];
        }
        between(&self.key(after - 1), &self.key(after), time_s)
    }

    fn time_within_keys(&self, time_s: f64) -> f64 {
        let (first_s, last_s) = (self.times_s[0], self.times_s[self.times_s.len() - 1]);
        if self.extend == Extend::Hold || first_s == last_s {
            return time_s;
        }
        let wrapped_s = first_s + (time_s - first_s).rem_euclid(last_s - first_s);
        // Rounding in the line above may leave a full period as well as none.
        if wrapped_s as f32 >= last_s as f32 { first_s } else { wrapped_s }
    }
}

/// Splines whose slopes go on through their keys, the last one towards nowhere; `None` of other keys.
fn smooth<T: Animate>(keys: &[Key<T>]) -> Option<Ways<T>> {
    let mut slopes = Vec::with_capacity(keys.len());
    let mut expected = None;
    for key in keys {
        let Segment::Hermite { leave, arrive } = key.to_next else { return None };
        if expected.is_some_and(|expected| expected != leave) {
            return None;
        }
        expected = Some(arrive);
        slopes.push(leave);
    }
    (expected == Some(T::ZERO)).then_some(Ways::Smooth(slopes))
}

/// The value on the way from one key to the next.
fn between<T: Animate>(from: &Key<T>, to: &Key<T>, time_s: f64) -> T {
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
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn key<T>(time_s: f64, value: T, to_next: Segment<T>) -> Key<T> {
        Key { time_s, value, to_next }
    }

    fn track<T: Animate>(keys: Vec<Key<T>>) -> Track<T> {
        Track::new(keys, Extend::Hold).unwrap()
    }

    fn quaternion() -> impl Strategy<Value = DQuat> {
        prop::array::uniform4(-1.0..1.0_f64)
            .prop_filter("too short to normalise", |v| v.iter().map(|x| x * x).sum::<f64>() > 1e-3)
            .prop_map(|v| DQuat::from_array(v).normalize())
    }

    fn segment() -> impl Strategy<Value = Segment<f64>> {
        let handle = (-3.0..3.0, -2.0..2.0).prop_map(|(time_s, value)| Handle { time_s, value });
        prop_oneof![
            Just(Segment::Step),
            Just(Segment::Linear),
            (-5.0..5.0, -5.0..5.0).prop_map(|(leave, arrive)| Segment::Hermite { leave, arrive }),
            (handle.clone(), handle).prop_map(|(leave, arrive)| Segment::Bezier { leave, arrive }),
        ]
    }

    proptest! {
        #[test]
        fn passes_through_its_keys(values in prop::collection::vec((-1e3..1e3_f64, segment()), 1..8)) {
            let keys: Vec<_> =
                values.iter().enumerate().map(|(i, (v, s))| key(i as f64 * 0.7, *v, *s)).collect();
            let track = track(keys.clone());
            prop_assert_eq!(&track.keys(), &keys);
            for key in keys {
                prop_assert!((track.at(key.time_s) - key.value).abs() <= 1e-12 * key.value.abs());
            }
        }

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

        #[test]
        fn hermite_reproduces_any_cubic(c in prop::array::uniform4(-3.0..3.0_f64), u in 0.0..1.0_f64) {
            let value = |t: f64| c[0] + t * (c[1] + t * (c[2] + t * c[3]));
            let slope = |t: f64| c[1] + t * (2.0 * c[2] + t * 3.0 * c[3]);
            let (start_s, end_s) = (1.25, 4.0);
            let curve = track(vec![
                key(start_s, value(start_s), Segment::Hermite { leave: slope(start_s), arrive: slope(end_s) }),
                key(end_s, value(end_s), Segment::Step),
            ]);
            let time_s = start_s + u * (end_s - start_s);
            prop_assert!((curve.at(time_s) - value(time_s)).abs() < 1e-11);
        }

        #[test]
        fn bezier_finds_every_point_of_its_parametric_curve(
            x1 in 0.0..1.0_f64, x2 in 0.0..1.0_f64, y in prop::array::uniform4(-3.0..3.0_f64), s in 0.0..1.0_f64
        ) {
            let curve = track(vec![
                key(0.0, y[0], Segment::Bezier {
                    leave: Handle { time_s: x1, value: y[1] },
                    arrive: Handle { time_s: x2, value: y[2] },
                }),
                key(1.0, y[3], Segment::Step),
            ]);
            // De Casteljau, as an oracle that shares nothing with the evaluation.
            let point = |mut p: [f64; 4]| {
                for level in (1..4).rev() {
                    for i in 0..level {
                        p[i] = p[i] * (1.0 - s) + p[i + 1] * s;
                    }
                }
                p[0]
            };
            let slope = 3.0 * ((1.0 - s) * (1.0 - s) * x1 + 2.0 * s * (1.0 - s) * (x2 - x1) + s * s * (1.0 - x2));
            prop_assume!(slope > 1e-3);
            prop_assert!((curve.at(point([0.0, x1, x2, 1.0])) - point(y)).abs() < 1e-9);
        }

        #[test]
        fn bezier_time_never_runs_backwards(handles in prop::array::uniform4(-5.0..5.0_f64)) {
            // With values equal to times the curve is the identity wherever time is single-valued.
            let curve = track(vec![
                key(0.0, 0.0, Segment::Bezier {
                    leave: Handle { time_s: handles[0].max(0.0), value: handles[0].max(0.0) },
                    arrive: Handle { time_s: handles[1].min(1.0), value: handles[1].min(1.0) },
                }),
                key(1.0, 1.0, Segment::Step),
            ]);
            for step in 0..=50 {
                let time_s = f64::from(step) / 50.0;
                prop_assert!((curve.at(time_s) - time_s).abs() < 1e-9);
            }
        }

        #[test]
        fn cycles_repeat_and_holds_hold(time_s in -50.0..50.0_f64) {
            let keys = vec![key(1.0, 0.0, Segment::Linear), key(2.0, 1.0, Segment::Linear), key(4.0, 5.0, Segment::Step)];
            let cycle = Track::new(keys.clone(), Extend::Cycle).unwrap();
            let hold = track(keys);
            let phase_s = 1.0 + (time_s - 1.0).rem_euclid(3.0);
            prop_assume!(phase_s < 3.999);
            prop_assert!((cycle.at(time_s) - hold.at(phase_s)).abs() < 1e-9);
            prop_assert_eq!(hold.at(1.0 - time_s.abs()), 0.0);
            prop_assert_eq!(hold.at(4.0 + time_s.abs()), 5.0);
        }
    }

    #[test]
    fn cycle_starts_over_at_its_last_key() {
        let keys = vec![key(0.0, 0.0, Segment::Linear), key(0.1, 1.0, Segment::Step)];
        let cycle = Track::new(keys, Extend::Cycle).unwrap();
        for round in -30..30 {
            assert!(cycle.at(f64::from(round) * 0.1).abs() < 1e-9, "round {round}");
        }
    }

    #[test]
    fn step_keys_stored_in_single_precision_are_found_on_their_frame() {
        let keys = (0..48)
            .map(|frame| key(f64::from((f64::from(frame) / 24.0) as f32), f64::from(frame), Segment::Step))
            .collect();
        let track = track(keys);
        for frame in 0..48 {
            assert_eq!(track.at(f64::from(frame) / 24.0), f64::from(frame));
        }
    }

    #[test]
    fn bezier_matches_blender() {
        // Keys 0 at frame 1 and 1 at frame 48 with Blender's automatic handles, which lie flat at a
        // third; values as Blender 5.0.1 evaluates them.
        let curve = track(vec![
            key(
                1.0,
                0.0,
                Segment::Bezier {
                    leave: Handle { time_s: 1.0 + 47.0 / 3.0, value: 0.0 },
                    arrive: Handle { time_s: 48.0 - 47.0 / 3.0, value: 1.0 },
                },
            ),
            key(48.0, 1.0, Segment::Step),
        ]);
        for (frame, value) in [
            (1.0, 0.0),
            (6.0, 0.031544),
            (12.5, 0.150309),
            (13.0, 0.162276),
            (24.0, 0.484045),
            (36.25, 0.84375),
        ] {
            assert!((curve.at(frame) - value).abs() < 1e-6, "frame {frame}");
        }
    }

    #[test]
    fn quaternion_spline_stays_on_the_unit_sphere() {
        let half_turn = DQuat::from_rotation_y(std::f64::consts::PI);
        let hermite = Segment::Hermite { leave: DQuat::ZERO, arrive: DQuat::ZERO };
        let track = track(vec![key(0.0, DQuat::IDENTITY, hermite), key(1.0, half_turn, Segment::Step)]);
        for step in 0..=10 {
            assert!((track.at(f64::from(step) / 10.0).length() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn constant_means_the_same_value_at_all_times() {
        let two = |to_next| track(vec![key(0.0, 2.0, to_next), key(1.0, 2.0, Segment::Step)]);
        let flat = Handle { time_s: 0.5, value: 2.0 };
        assert!(Track::from(2.0).is_constant());
        assert!(two(Segment::Linear).is_constant());
        assert!(two(Segment::Hermite { leave: 0.0, arrive: 0.0 }).is_constant());
        assert!(!two(Segment::Hermite { leave: 1.0, arrive: 0.0 }).is_constant());
        assert!(two(Segment::Bezier { leave: flat, arrive: flat }).is_constant());
        let bump = Handle { value: 3.0, ..flat };
        assert!(!two(Segment::Bezier { leave: flat, arrive: bump }).is_constant());
        assert!(!track(vec![key(0.0, 2.0, Segment::Step), key(1.0, 3.0, Segment::Step)]).is_constant());
    }

    #[test]
    fn visibility_switches_at_its_keys() {
        let track = track(vec![key(0.0, true, Segment::Step), key(1.0, false, Segment::Step)]);
        assert!(track.at(0.999) && !track.at(1.0));
    }

    #[test]
    fn one_slope_a_key_is_kept_once_and_given_back() {
        let spline = |leave: f64, arrive: f64| Segment::Hermite { leave, arrive };
        let smooth = vec![
            key(0.0, 1.0, spline(0.5, -1.0)),
            key(1.0, 2.0, spline(-1.0, 3.0)),
            key(2.5, 0.0, spline(3.0, 0.0)),
        ];
        let mut kinked = smooth.clone();
        kinked[1].to_next = spline(-1.5, 3.0);
        assert!(matches!(track(smooth.clone()).to_next, Ways::Smooth(_)));
        assert!(matches!(track(kinked.clone()).to_next, Ways::Each(_)));
        for keys in [smooth, kinked] {
            let track = track(keys.clone());
            assert_eq!(track.keys(), keys);
            let doubled = track.map_linear(|value| 2.0 * value);
            assert!(
                (0..50).all(|at| doubled.at(0.05 * f64::from(at)) == 2.0 * track.at(0.05 * f64::from(at)))
            );
        }
    }

    #[test]
    fn keys_out_of_order_make_no_track() {
        let keys = |times: &[f64]| times.iter().map(|&t| key(t, 0.0, Segment::Step)).collect();
        for times in [&[][..], &[1.0, 1.0], &[1.0, 0.0], &[f64::NAN], &[0.0, f64::INFINITY]] {
            assert!(Track::<f64>::new(keys(times), Extend::Hold).is_none(), "{times:?}");
        }
    }
}
