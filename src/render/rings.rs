//! In which rings about the axis the slices of a fan are laid out, and how densely. In goes the fan, out come rings. Invariant: they
//! are those of the whole picture, whichever part of it is wanted.
//!
//! Slices of a fan crowd about its axis, and most of them tell nothing there that others do not: fewer do.

use crate::transport::slices::{Fan, Ring};
use std::f64::consts::PI;

/// Slices crowd within this part of the way from the axis to where they lie farthest apart. With the sun amid leaves500 a ninth of the time
/// is spent there, on a hundredth of the square of the error.
const CROWD: f64 = 0.1;

/// At its rim they still lie so many times as close as there. With all of them it would be ten times, so a quarter are left.
const CLOSER_AT_RIM: f64 = 2.5;

/// The picture, and what lies about the axis and about its far side in rings of their own.
pub(super) fn rings(fan: &Fan) -> Vec<Ring> {
    let (least, greatest) = fan.extent();
    let greatest_px = fan.separation(Ring::WHOLE).greatest_px;
    let crowd_rad = (CROWD * greatest_px / fan.px_per_rad()).min(1.0).asin();
    let (low, high) = (crowd_rad, PI - crowd_rad);
    let mut borders = Vec::new();
    if least.max(low) < greatest.min(high) {
        borders.extend((least < low).then_some(low));
        borders.extend((high < greatest).then_some(high));
    }
    borders.push(PI);
    let starts = std::iter::once(0.0).chain(borders.iter().copied());
    starts.zip(&borders).map(|(from, &to)| Ring(from, to)).collect()
}

/// How many slices there are to a pixel's width.
#[derive(Clone, Copy)]
pub(super) enum PerPixel {
    /// Where they lie farthest apart: for pictures of one fan, whose pixels have no other slices.
    Least(f64),
    /// On average: of many fans, which lie farthest apart in different places.
    Mean(f64),
}

/// How many slices a radian of a ring has.
pub(super) fn slices_per_rad(fan: &Fan, ring: Ring, slices: PerPixel) -> f64 {
    let (whole, own) = (fan.separation(Ring::WHOLE), fan.separation(ring));
    let own = if own.area_px > 0.0 { own } else { whole };
    match slices {
        PerPixel::Least(slices) => slices * whole.greatest_px.min(CLOSER_AT_RIM * own.greatest_px),
        PerPixel::Mean(slices) => slices * own.mean_px,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Size;
    use glam::DVec3;

    const SIZE: Size = Size { width: 480, height: 270 };

    /// A picture along -z by a pinhole, and a sun so high.
    fn fan(elevation_deg: f64) -> Fan {
        let (sin, cos) = elevation_deg.to_radians().sin_cos();
        Fan::of_pinhole(0.7, SIZE, DVec3::new(0.0, sin, -cos))
    }

    /// If that, or its far side, is in the picture.
    #[test]
    fn a_crowd_about_the_axis_is_thinned() {
        for (elevation_deg, crowd) in [(50.0, None), (5.0, Some(0)), (175.0, Some(1)), (90.0, None)] {
            let fan = fan(elevation_deg);
            let all_per_rad = 8.0 * fan.separation(Ring::WHOLE).greatest_px;
            let rings = rings(&fan);
            assert_eq!(rings.len(), if crowd.is_some() { 2 } else { 1 }, "{rings:?}");
            for (number, &ring) in rings.iter().enumerate() {
                let share = slices_per_rad(&fan, ring, PerPixel::Least(8.0)) / all_per_rad;
                let expected = if crowd == Some(number) { 0.25 } else { 1.0 };
                assert!((share / expected - 1.0).abs() < 0.15, "{elevation_deg}: {share} in {ring:?}");
            }
        }
    }

    #[test]
    fn rings_cover_the_picture_once() {
        // The sun beside the picture, in it, behind the camera, and at right angles.
        for fan in [50.0, 5.0, 175.0, 90.0].map(fan) {
            let rings = rings(&fan);
            assert!(rings[0].0 == 0.0 && rings[rings.len() - 1].1 == PI, "{rings:?}");
            assert!(rings.windows(2).all(|pair| pair[0].1 == pair[1].0), "{rings:?}");
            assert!(rings.iter().all(|ring| ring.0 < ring.1), "{rings:?}");
            let area_px: f64 = rings.iter().map(|&ring| fan.separation(ring).area_px).sum();
            let whole_px = fan.separation(Ring::WHOLE).area_px;
            assert!((area_px / whole_px - 1.0).abs() < 1e-9, "{area_px} {whole_px}");
            let pixels = (SIZE.width * SIZE.height) as f64;
            assert!((whole_px / pixels - 1.0).abs() < 0.02, "{whole_px} {pixels}");
        }
    }
}
