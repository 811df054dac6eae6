//! Displacement by the mean wind over time. In goes its keyed velocity, out comes a displacement. Invariant:
//! it is continuous, its derivative is the velocity, and every machine computes the same.

use crate::scene::{Extend, Track};
use glam::DVec3;

/// Offset of the two points of Gauss' rule from the middle, relative to half an interval: 1 / sqrt(3). The
/// rule is exact for cubics, and so for all curves between keys except Bezier curves.
const GAUSS: f64 = 0.577_350_269_189_625_8;
/// Parts of each curve for the rule, because of Bezier curves.
const PARTS: usize = 64;

/// Velocity, m/s, and its integral.
#[derive(Clone, Debug)]
pub(crate) struct Drift {
    pub(super) velocity: Track<DVec3>,
    /// Displacements from the first key to the start of each part, and to the last key.
    ways: Vec<DVec3>,
}

impl Drift {
    pub(crate) fn new(velocity: Track<DVec3>) -> Self {
        let mut drift = Self { ways: vec![DVec3::ZERO], velocity };
        let mut way = DVec3::ZERO;
        for key in 1..drift.velocity.times_s().len() {
            for part in 0..PARTS {
                let [from_s, to_s] = [part, part + 1].map(|part| drift.begins_s(key, part));
                way += drift.within_part(from_s, to_s);
                drift.ways.push(way);
            }
        }
        drift
    }

    /// Whether there is never any wind.
    pub(super) fn is_still(&self) -> bool {
        self.velocity.is_constant() && self.velocity.at(0.0) == DVec3::ZERO
    }

    pub(super) fn velocity(&self, time_s: f64) -> DVec3 {
        self.velocity.at(time_s)
    }

    /// Displacement: for a constant velocity, since time 0; for others, since the first key.
    pub(super) fn way(&self, time_s: f64) -> DVec3 {
        let times_s = self.velocity.times_s();
        let (Some(&first_s), Some(&last_s), Some(&all)) = (times_s.first(), times_s.last(), self.ways.last())
        else {
            return DVec3::ZERO;
        };
        if times_s.len() == 1 {
            return self.velocity(time_s) * time_s;
        }
        let period_s = last_s - first_s;
        let rounds = match self.velocity.extend() {
            Extend::Hold => 0.0,
            Extend::Cycle => ((time_s - first_s) / period_s).floor(),
        };
        let within_s = time_s - rounds * period_s;
        let after = times_s.partition_point(|&key_s| key_s <= within_s);
        let way = match after {
            0 => self.velocity(first_s) * (within_s - first_s),
            after if after == times_s.len() => all + self.velocity(last_s) * (within_s - last_s),
            after => {
                let share = (within_s - times_s[after - 1]) / (times_s[after] - times_s[after - 1]);
                let part = ((share * PARTS as f64) as usize).min(PARTS - 1);
                self.ways[(after - 1) * PARTS + part] + self.within_part(self.begins_s(after, part), within_s)
            }
        };
        way + all * rounds
    }

    /// Start time of a part of the curve that leads to a key.
    fn begins_s(&self, key: usize, part: usize) -> f64 {
        let [from_s, to_s] = [key - 1, key].map(|key| self.velocity.times_s()[key]);
        from_s + (to_s - from_s) * (part as f64 / PARTS as f64)
    }

    /// Displacement between two times within a part.
    fn within_part(&self, from_s: f64, to_s: f64) -> DVec3 {
        let (middle_s, half_s) = (0.5 * (from_s + to_s), 0.5 * (to_s - from_s));
        let [before, behind] = [-GAUSS, GAUSS].map(|at| self.velocity(middle_s + at * half_s));
        (before + behind) * half_s
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scene::{Handle, Key, Segment};

    fn drift(extend: Extend, to_next: Segment<DVec3>) -> Drift {
        let key = |time_s, x| Key { time_s, value: DVec3::X * x, to_next };
        Drift::new(Track::new(vec![key(1.0, 2.0), key(3.0, 4.0), key(4.0, 2.0)], extend).unwrap())
    }

    #[test]
    fn the_way_is_the_integral_of_the_velocity() {
        // By hand: before the first key, and of trapezia, stairs and cubics up to 3.
        for (to_next, at_three) in [
            (Segment::Linear, 6.0),
            (Segment::Step, 4.0),
            // h (a + b) / 2 + h^2 (a' - b') / 12.
            (Segment::Hermite { leave: DVec3::X, arrive: DVec3::ZERO }, 6.0 + 4.0 / 12.0),
        ] {
            let drift = drift(Extend::Hold, to_next);
            assert!((drift.way(0.5).x + 1.0).abs() < 1e-12);
            assert!((drift.way(3.0).x - at_three).abs() < 1e-12, "{to_next:?}: {}", drift.way(3.0));
            assert!((drift.way(6.0).x - drift.way(4.0).x - 4.0).abs() < 1e-12);
        }
        assert_eq!(Drift::new(DVec3::X.into()).way(2.5), DVec3::X * 2.5);
    }

    #[test]
    fn the_way_never_leaps_and_its_rate_is_the_velocity() {
        let handle = |time_s| Handle { time_s, value: DVec3::X * 3.0 };
        let bezier = Segment::Bezier { leave: handle(1.2), arrive: handle(2.9) };
        let curved = Drift::new(
            Track::new(
                vec![
                    Key { time_s: 1.0, value: DVec3::X * 2.0, to_next: bezier },
                    Key { time_s: 3.0, value: DVec3::X * 4.0, to_next: Segment::Step },
                ],
                Extend::Cycle,
            )
            .unwrap(),
        );
        for drift in [curved, drift(Extend::Cycle, Segment::Linear), drift(Extend::Hold, Segment::Step)] {
            let step_s = 1e-4;
            for step in -80_000..80_000_i32 {
                let time_s = (f64::from(step) + 0.5) * step_s;
                let moved = (drift.way(time_s + 0.5 * step_s) - drift.way(time_s - 0.5 * step_s)) / step_s;
                let error = (moved - drift.velocity(time_s)).length();
                assert!(error < 2e-2, "{time_s} s: {error}");
            }
        }
    }
}
