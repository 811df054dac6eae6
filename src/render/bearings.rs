//! Bearings of slices that may cross wanted pixels. In go the fan of the light's centre and the pixels. Out
//! comes, for a slice's place, whether it may cross any. Invariant: no slice that crosses one is left out,
//! for any deviation of its own fan from the centre's.
//!
//! A late round has many slices and few pixels, and most slices cross none of these. Drawing all of them took
//! most of a late round's time under a sun with a picture on it.

use crate::film::Mask;
use crate::scene::Window;
use crate::transport::slices::{Fan, Ring};
use std::f64::consts::TAU;

/// Number of parts of the circle: each is about a pixel wide at the rim of a picture of a thousand pixels.
const PARTS: usize = 4096;

/// Directions about the axis of a fan.
pub(super) struct Bearings {
    is_wanted: Vec<bool>,
}

impl Bearings {
    /// Bearings of the slices of `base` that meet wanted pixels in a ring, and `margin_rad` to either
    /// side. Slices may have axes that are up to `deviation_rad` away from that of `base`.
    pub(super) fn new(base: &Fan, ring: Ring, deviation_rad: f64, wanted: &Mask, margin_rad: f64) -> Self {
        let mut is_wanted = vec![false; PARTS];
        let is_in_ring = |block: &Window| {
            let (least, greatest) = base.extent_of(*block);
            least <= ring.1 + deviation_rad && ring.0 - deviation_rad <= greatest
        };
        for block in wanted.inhabited_blocks().filter(is_in_ring) {
            let (first, width) = base.angles_across(block);
            let (low, high) = (part_at(first - margin_rad), part_at(first + width + margin_rad));
            // One more on either side, for rounding; the whole circle at most.
            let count = (high - low + 3.0).min(PARTS as f64) as usize;
            let from = (low - 1.0).rem_euclid(PARTS as f64) as usize;
            for part in from..from + count {
                is_wanted[part % PARTS] = true;
            }
        }
        Self { is_wanted }
    }

    /// Whether a slice through its place at an angle of the fan may cross a wanted pixel.
    pub(super) fn hold(&self, angle: f64) -> bool {
        self.is_wanted[part_at(angle).rem_euclid(PARTS as f64) as usize % PARTS]
    }
}

/// The part of an angle, before whole turns are subtracted.
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

    /// Fan of a pinhole's picture along -z, with a sun.
    fn fan(elevation_deg: f64, azimuth_deg: f64) -> Fan {
        let (sin, cos) = elevation_deg.to_radians().sin_cos();
        let (to_side, ahead) = azimuth_deg.to_radians().sin_cos();
        let to_sun = DVec3::new(cos * to_side, sin, -cos * ahead);
        Fan::of_pinhole(0.7, SIZE, to_sun)
    }

    fn meets(wanted: &Mask, fan: &Fan, angle: f64, ring: Ring) -> bool {
        let slice = fan.slice(angle, ring);
        slice.is_some_and(|slice| slice.crossings(SIZE, |x, y| wanted.contains(x, y)).next().is_some())
    }

    proptest! {
        /// Slices of one fan, and those of fans that deviate from it, in a ring that keeps them in order.
        #[test]
        fn no_slice_that_meets_wanted_pixels_is_left_out(
            (elevation_deg, azimuth_deg) in (-89.0..89.0_f64, -180.0..180.0_f64),
            wanted in prop::collection::hash_set((0..SIZE.width, 0..SIZE.height), 1..4),
            deviation_deg in prop::array::uniform2(-0.3..0.3_f64),
        ) {
            let base = fan(elevation_deg, azimuth_deg);
            let wanted = Mask::from_fn(Window::whole(SIZE), |x, y| wanted.contains(&(x, y)));
            let angle = |number: u32| base.angles.0 + base.angles.1 * f64::from(number) / 500.0;
            let bearings = Bearings::new(&base, Ring::WHOLE, 0.0, &wanted, 0.0);
            for angle in (0..500).map(angle) {
                prop_assert!(bearings.hold(angle) || !meets(&wanted, &base, angle, Ring::WHOLE), "{angle}");
            }

            let own = fan(elevation_deg + deviation_deg[0], azimuth_deg + deviation_deg[1]);
            let extent = base.extent();
            let ring = Ring(extent.0.max(0.02), extent.1.min(PI - 0.02));
            prop_assume!(ring.0 < ring.1);
            let rotation = (base.deviation(&own).sin() / ring.0.sin().min(ring.1.sin())).min(1.0).asin();
            let bearings = Bearings::new(&base, ring, base.deviation(&own), &wanted, 1.5 * rotation);
            for angle in (0..500).map(angle) {
                let (own_angle, _) = own.angle_through(&base, angle, 0.5 * (ring.0 + ring.1));
                prop_assert!(bearings.hold(angle) || !meets(&wanted, &own, own_angle, ring), "{angle}");
            }
        }
    }

    #[test]
    fn a_pixel_far_from_the_axis_is_met_by_few() {
        let base = fan(60.0, 0.0);
        let wanted = Mask::from_fn(Window::whole(SIZE), |x, y| (x, y) == (40, 20));
        let bearings = Bearings::new(&base, Ring::WHOLE, 0.0, &wanted, 0.0);
        let held = (0..1000).filter(|&number| bearings.hold(TAU * f64::from(number) / 1000.0)).count();
        assert!((1..200).contains(&held), "{held}");
    }
}
