//! Times of keys. In go moments, out come times that Blender keeps apart. Invariant: at every frame Blender
//! shows the curve's value there.
//!
//! Where keys lie less than a hundredth of a frame apart, Blender keeps one, with the last one's value. A key
//! just beside a frame would give the frame another moment. So keys stay apart and frames come first. A jump
//! is two keys in neighbouring numbers of single precision. Blender keeps the value after the jump, which is
//! right, and a third key shortly before holds the value before it.

use crate::scene::{Animate, FrameRate, Segment, Track};
use std::collections::BTreeMap;

/// Least distance of keys in frames, twice what Blender needs: single precision moves keys by less than 0.003
/// frames up to frame 49,000.
pub(super) const APART_FRAMES: f64 = 0.02;
/// Distance in frames within which a key counts as the frame's. Blender snaps to a key within 0.0001.
const AT_FRAME: f64 = 1e-3;

/// Times of keys for linear interpolation: the moments, and for each jump the last time before it and the
/// first after it. Times increase, are not negative, and differ in single precision.
///
/// A moment too near to a frame moves away from it. Of two moments too near to each other one is dropped. In
/// both cases keys at the frames around limit the change to that interval. A jump too near to a frame becomes
/// a short slope.
pub(super) fn apart(rate: FrameRate, moments_s: &[f64], jumps_s: &[f64]) -> Vec<f64> {
    let apart_s = rate.seconds(APART_FRAMES);
    let (mut taken, mut jumps, mut others, mut pairs) = (Taken(BTreeMap::new()), vec![], vec![], vec![]);
    let mut moments = moments_s.to_vec();
    for &jump_s in jumps_s {
        let frame_s = nearest_frame(rate, jump_s);
        if jump_s as f32 == frame_s as f32 {
            pairs.push(jump_s);
            moments.extend([jump_s, jump_s - apart_s]);
        } else if (jump_s - frame_s).abs() < apart_s {
            moments.push(jump_s);
        } else {
            pairs.push(jump_s);
            jumps.push(jump_s);
            moments.push(jump_s - apart_s);
        }
    }
    for moment_s in moments {
        let frame_s = nearest_frame(rate, moment_s);
        let after_s = moment_s - frame_s;
        if after_s.abs() >= apart_s {
            others.push(moment_s);
            continue;
        }
        // A key of the scene at a frame keeps its own time, and so its value.
        let is_frame = moment_s as f32 == frame_s as f32;
        taken.insert(if is_frame { moment_s } else { frame_s });
        if !is_frame {
            others.push(frame_s + apart_s.copysign(after_s));
        }
    }
    for list in [&mut jumps, &mut others] {
        list.sort_by(f64::total_cmp);
        for &time_s in list.iter() {
            // Rounding may move it nearer to the frame.
            if taken.has_room(time_s, 0.999 * apart_s) {
                taken.insert(time_s);
            } else if !taken.contains(time_s) {
                let frame = rate.frame(time_s);
                taken.insert(rate.seconds(frame.floor()));
                taken.insert(rate.seconds(frame.ceil()));
            }
        }
    }
    for jump_s in pairs {
        if taken.contains(jump_s) {
            taken.insert(f64::from((jump_s as f32).next_down()));
        }
    }
    taken.0.into_values().collect()
}

/// Whether Blender shows exactly the keys' values at every frame.
pub(super) fn are_apart(rate: FrameRate, times_s: &[f64]) -> bool {
    let is_clear = |&time_s: &f64| {
        let frame_s = nearest_frame(rate, time_s);
        time_s as f32 == frame_s as f32 || (time_s - frame_s).abs() >= rate.seconds(AT_FRAME)
    };
    let apart_s = rate.seconds(APART_FRAMES);
    times_s.iter().all(is_clear) && times_s.windows(2).all(|pair| pair[1] - pair[0] >= apart_s)
}

/// Times of a track's keys: those reached by a curve, and those jumped to.
pub(super) fn reached_and_jumped_to<T: Animate>(track: &Track<T>) -> (Vec<f64>, Vec<f64>) {
    let (mut reached_s, mut jumped_s) = (Vec::new(), Vec::new());
    let mut jumps = false;
    for key in track.keys() {
        if jumps { &mut jumped_s } else { &mut reached_s }.push(key.time_s);
        jumps = matches!(key.to_next, Segment::Step);
    }
    (reached_s, jumped_s)
}

fn nearest_frame(rate: FrameRate, time_s: f64) -> f64 {
    rate.seconds(rate.frame(time_s).round())
}

/// Times by their bits in single precision, whose order is that of times that are not negative.
struct Taken(BTreeMap<u32, f64>);

impl Taken {
    fn insert(&mut self, time_s: f64) {
        if time_s >= 0.0 {
            self.0.entry(bits(time_s)).or_insert(time_s);
        }
    }

    fn contains(&self, time_s: f64) -> bool {
        time_s >= 0.0 && self.0.contains_key(&bits(time_s))
    }

    fn has_room(&self, time_s: f64, apart_s: f64) -> bool {
        let near = bits((time_s - apart_s).max(0.0))..=bits((time_s + apart_s).max(0.0));
        self.0.range(near).all(|(_, taken_s)| (taken_s - time_s).abs() >= apart_s)
    }
}

fn bits(time_s: f64) -> u32 {
    // Adding 0 turns -0 into 0.
    (time_s as f32 + 0.0).to_bits()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Sampler;

    const RATE: FrameRate = FrameRate { numerator: 24, denominator: 1 };

    fn in_frames(moments: &[f64], jumps: &[f64]) -> Vec<f64> {
        let seconds = |frames: &[f64]| -> Vec<f64> { frames.iter().map(|&at| RATE.seconds(at)).collect() };
        apart(RATE, &seconds(moments), &seconds(jumps)).into_iter().map(|at| RATE.frame(at)).collect()
    }

    #[track_caller]
    fn assert_near(found: &[f64], expected: &[f64]) {
        let near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5);
        assert!(found.len() == expected.len() && near, "{found:?} instead of {expected:?}");
    }

    #[test]
    fn moments_far_from_each_other_stay() {
        let moments = [0.75, 1.0, 1.25, 1.75, 2.0, 2.25];
        assert_near(&in_frames(&moments, &[]), &moments);
    }

    #[test]
    fn frames_come_first_and_what_is_near_them_moves_away() {
        assert_near(&in_frames(&[0.998, 1.25], &[]), &[0.98, 1.0, 1.25]);
        assert_near(&in_frames(&[1.002, 1.25, 2.0], &[]), &[1.0, 1.02, 1.25, 2.0]);
        assert_near(&in_frames(&[0.993, 0.998, 1.0, 1.0003], &[]), &[0.98, 1.0, 1.02]);
    }

    #[test]
    fn of_two_moments_one_stays_and_the_frames_around_them() {
        assert_near(&in_frames(&[5.5, 5.51, 9.5], &[]), &[5.0, 5.5, 6.0, 9.5]);
    }

    #[test]
    fn jumps_are_two_keys_and_one_before() {
        assert_near(&in_frames(&[1.0, 3.0], &[2.0]), &[1.0, 1.98, 2.0, 2.0, 3.0]);
        assert_near(&in_frames(&[1.0, 3.0], &[2.4]), &[1.0, 2.38, 2.4, 2.4, 3.0]);
        // Rather than the frame's own value.
        assert_near(&in_frames(&[1.0, 3.0], &[2.004]), &[1.0, 2.0, 2.02, 3.0]);
        assert_near(&in_frames(&[1.0, 3.0], &[1.996]), &[1.0, 1.98, 2.0, 3.0]);
        assert_near(&in_frames(&[0.0, 1.0], &[0.0]), &[0.0, 1.0]);
    }

    /// Whatever is asked for: frames that are asked for are there, and nothing is near anything but jumps.
    #[test]
    fn all_are_apart() {
        for index in 0..300 {
            let mut sampler = Sampler::new(index, 0, 0, 0);
            let mut some = |count: usize, cluster: f64| -> Vec<f64> {
                let near = |_| {
                    (20.0 * sampler.next_1d()).round() * 0.5
                        + cluster * (2.0 * sampler.next_1d() - 1.0).powi(3)
                };
                (0..count).map(near).collect()
            };
            let (moments, jumps) = (some(30, 0.1), some(4, 0.03));
            let found = in_frames(&moments, &jumps);
            for pair in found.windows(2) {
                let between = pair[1] - pair[0];
                let is_jump = between < 1e-5;
                assert!(is_jump || between > 0.99 * APART_FRAMES, "{pair:?} of {moments:?}, {jumps:?}");
            }
            let frames = moments.iter().filter(|at| at.fract() == 0.0 && **at >= 0.0);
            for frame in frames {
                assert!(found.iter().any(|at| (at - frame).abs() < 1e-5), "{frame} of {moments:?}");
            }
        }
    }
}
