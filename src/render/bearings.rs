//! Which slices may cross pixels that are wanted. In go a fan and the pixels, out comes whether its slice at an angle
//! need be looked at. Invariant: no slice that crosses one is left out.
//!
//! A late pass has many slices and few pixels, and most slices meet none of these: to draw them all the same took most of its time under a sun with a picture on it.

use crate::film::Mask;
use crate::scene::Window;
use crate::transport::slices::{Fan, Ring};
use std::f64::consts::TAU;

/// In so many parts a turn is marked: each is about a pixel wide at the rim of a picture of a thousand.
const PARTS: usize = 4096;

/// Directions about the axis of a fan.
pub(super) struct Bearings {
    is_wanted: Vec<bool>,
}

impl Bearings {
    /// Those of the slices of a fan that meet pixels which are wanted, in a ring.
    pub(super) fn new(fan: &Fan, ring: Ring, wanted: &Mask) -> Self {
        let mut is_wanted = vec![false; PARTS];
        let is_in_ring = |block: &Window| {
            let (least, greatest) = fan.extent_of(*block);
            least <= ring.1 && ring.0 <= greatest
        };
        for block in wanted.inhabited_blocks().filter(is_in_ring) {
            let (first, width) = fan.angles_across(block);
            let (low, high) = (part_at(first), part_at(first + width));
            // One more on either side, for rounding; a whole turn at most.
            let count = (high - low + 3.0).min(PARTS as f64) as usize;
            let from = (low - 1.0).rem_euclid(PARTS as f64) as usize;
            for part in from..from + count {
                is_wanted[part % PARTS] = true;
            }
        }
        Self { is_wanted }
    }

    /// Whether the fan's slice at an angle may meet any.
    pub(super) fn hold(&self, angle: f64) -> bool {
        self.is_wanted[part_at(angle).rem_euclid(PARTS as f64) as usize % PARTS]
    }
}

/// The part that an angle lies in, before whole turns are taken off.
fn part_at(angle: f64) -> f64 {
    (angle / TAU * PARTS as f64).floor()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Size;
    use glam::DVec3;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    const SIZE: Size = Size { width: 48, height: 27 };

    /// A picture along -z by a pinhole, and a sun there.
    fn fan(elevation_deg: f64, azimuth_deg: f64) -> Fan {
        let (sin, cos) = elevation_deg.to_radians().sin_cos();
        let (to_side, ahead) = azimuth_deg.to_radians().sin_cos();
        let to_sun = DVec3::new(cos * to_side, sin, -cos * ahead);
        Fan::of_pinhole(0.7, SIZE, to_sun)
    }

    fn meets(wanted: &Mask, fan: &Fan, angle: f64, ring: Ring) -> bool {
        let slice = fan.slice(angle, ring);
        slice.is_some_and(|slice| slice.crossings(SIZE, |x, y| wanted.unwanted_around(x, y)).next().is_some())
    }

    proptest! {
        #[test]
        fn no_slice_that_meets_wanted_pixels_is_left_out(
            (elevation_deg, azimuth_deg) in (-89.0..89.0_f64, -180.0..180.0_f64),
            wanted in prop::collection::hash_set((0..SIZE.width, 0..SIZE.height), 1..4),
            (from, to) in (0.0..1.5_f64, 1.5..PI),
        ) {
            let fan = fan(elevation_deg, azimuth_deg);
            let wanted = Mask::from_fn(Window::whole(SIZE), |x, y| wanted.contains(&(x, y)));
            for ring in [Ring::WHOLE, Ring(from, to)] {
                let bearings = Bearings::new(&fan, ring, &wanted);
                for angle in (0..500).map(|number| fan.angles.0 + fan.angles.1 * f64::from(number) / 500.0) {
                    prop_assert!(bearings.hold(angle) || !meets(&wanted, &fan, angle, ring), "{angle}");
                }
            }
        }
    }

    #[test]
    fn a_pixel_far_from_the_axis_is_met_by_few() {
        let base = fan(60.0, 0.0);
        let wanted = Mask::from_fn(Window::whole(SIZE), |x, y| (x, y) == (40, 20));
        let bearings = Bearings::new(&base, Ring::WHOLE, &wanted);
        let held = (0..1000).filter(|&number| bearings.hold(TAU * f64::from(number) / 1000.0)).count();
        assert!((1..200).contains(&held), "{held}");
    }
}
