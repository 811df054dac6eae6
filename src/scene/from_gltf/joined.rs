//! Functions of several tracks. In go tracks, out comes the track of the function's value. Invariant: it
//! jumps where any of them jumps. Between keys it is linear, which is exact if one track is linear and the
//! others constant.

use crate::scene::{Animate, Extend, Key, Segment, Track};

/// Linear pieces of a curve.
const PARTS_OF_CURVES: usize = 32;

/// Keys of a track, with the interpolation to the next.
pub(super) struct Course(Vec<(f64, Way)>);

#[derive(Clone, Copy, PartialEq)]
enum Way {
    Stays,
    Straight,
    Curve,
}

impl Course {
    pub(super) fn of<T: Animate>(track: &Track<T>) -> Self {
        let way = |to_next: Segment<T>| match to_next {
            Segment::Step => Way::Stays,
            Segment::Linear => Way::Straight,
            Segment::Hermite { .. } | Segment::Bezier { .. } => Way::Curve,
        };
        Self(track.keys().iter().map(|key| (key.time_s, way(key.to_next))).collect())
    }

    /// Number of its keys up to a time, in single precision as in tracks.
    fn passed(&self, time_s: f64) -> usize {
        self.0.partition_point(|(key_s, _)| *key_s as f32 <= time_s as f32)
    }

    /// Interpolation from a time to the next key of any track.
    fn way_from(&self, time_s: f64) -> Way {
        match self.passed(time_s) {
            0 => Way::Stays,
            passed if passed == self.0.len() => Way::Stays,
            passed => self.0[passed - 1].1,
        }
    }

    /// Whether it may jump at a time.
    fn jumps_at(&self, time_s: f64) -> bool {
        let passed = self.passed(time_s);
        passed >= 2 && self.0[passed - 2].1 == Way::Stays && self.0[passed - 1].0 as f32 == time_s as f32
    }
}

/// Track of `value` over these tracks; `None` without tracks.
pub(super) fn joined<T: Animate>(courses: &[Course], value: impl Fn(f64) -> T) -> Option<Track<T>> {
    let mut times_s: Vec<f64> =
        courses.iter().flat_map(|course| course.0.iter().map(|(time_s, _)| *time_s)).collect();
    times_s.sort_by(f64::total_cmp);
    times_s.dedup_by_key(|time_s| *time_s as f32);
    let mut keys = Vec::with_capacity(times_s.len());
    for (index, &time_s) in times_s.iter().enumerate() {
        let ways = || courses.iter().map(|course| course.way_from(time_s));
        let to_next = if ways().all(|way| way == Way::Stays) { Segment::Step } else { Segment::Linear };
        keys.push(Key { time_s, value: value(time_s), to_next });
        let Some(&next_s) = times_s.get(index + 1) else { break };
        if ways().any(|way| way == Way::Curve) {
            keys.extend((1..PARTS_OF_CURVES).map(|part| {
                let time_s = time_s + (next_s - time_s) * part as f64 / PARTS_OF_CURVES as f64;
                Key { time_s, value: value(time_s), to_next }
            }));
        }
        // Last moment before a jump, as tracks compare times in single precision.
        let before_s = f64::from((next_s as f32).next_down());
        if to_next == Segment::Linear && courses.iter().any(|course| course.jumps_at(next_s)) {
            keys.push(Key { time_s: before_s, value: value(before_s), to_next: Segment::Step });
        }
    }
    // Keys that are adjacent already.
    keys.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    keys.dedup_by_key(|key| key.time_s as f32);
    Track::new(keys, Extend::Hold)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn track(keys: &[(f64, f64, Segment<f64>)]) -> Track<f64> {
        let keys = keys.iter().map(|&(time_s, value, to_next)| Key { time_s, value, to_next });
        Track::new(keys.collect(), Extend::Hold).unwrap()
    }

    #[test]
    fn a_jump_stays_a_jump_beside_what_moves() {
        let jumps = track(&[(0.0, 1.0, Segment::Step), (0.4, 3.0, Segment::Step), (1.1, 2.0, Segment::Step)]);
        let moves = track(&[(0.0, 0.0, Segment::Linear), (2.0, 2.0, Segment::Linear)]);
        let product = |time_s: f64| jumps.at(time_s) * moves.at(time_s);
        let both = joined(&[Course::of(&jumps), Course::of(&moves)], product).unwrap();
        for time_s in [-1.0, 0.0, 0.1, 0.399, 0.399999, 0.4, 0.41, 1.0999, 1.1, 1.5, 2.0, 3.0] {
            assert!((both.at(time_s) - product(time_s)).abs() < 1e-6, "{time_s}: {}", both.at(time_s));
        }
    }

    #[test]
    fn curves_are_followed_nearly() {
        let curve =
            track(&[(0.0, 0.0, Segment::Hermite { leave: 3.0, arrive: -1.0 }), (1.0, 1.0, Segment::Step)]);
        let jumps = track(&[(0.0, 1.0, Segment::Step), (0.5, 2.0, Segment::Step)]);
        let product = |time_s: f64| jumps.at(time_s) * curve.at(time_s);
        let both = joined(&[Course::of(&jumps), Course::of(&curve)], product).unwrap();
        for step in 0..=1000 {
            let time_s = f64::from(step) / 1000.0;
            assert!((both.at(time_s) - product(time_s)).abs() < 2e-3, "{time_s}");
        }
    }

    #[test]
    fn steps_alone_stay_steps() {
        let a = track(&[(0.0, 1.0, Segment::Step), (1.0, 2.0, Segment::Step)]);
        let b = track(&[(0.5, 1.0, Segment::Step), (0.7, 4.0, Segment::Step)]);
        let both = joined(&[Course::of(&a), Course::of(&b)], |time_s| a.at(time_s) + b.at(time_s)).unwrap();
        assert_eq!(both.keys().iter().map(|key| key.time_s).collect::<Vec<_>>(), [0.0, 0.5, 0.7, 1.0]);
        assert!(both.keys().iter().all(|key| key.to_next == Segment::Step));
    }
}
