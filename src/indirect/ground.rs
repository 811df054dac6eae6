//! Plain ground: flat, wide, and at right angles to the gradient of fog. In go the parts of a snapshot, out
//! come its height and its optics. Invariant: splitting the ground into pieces changes nothing.

use crate::canopy::surroundings::Surroundings;
use crate::canopy::surroundings::wide::WidePart;
use crate::math::bounds;
use crate::ordinates::surface_optics::SurfaceOptics;
use glam::DVec3;

/// Maximum roughness of a plain, in scale heights of the fog.
const FLAT: f64 = 0.1;
/// Minimum width of a ground, in scale heights.
const NARROWEST: f64 = 6.0;
/// Maximum height of hills, as a share of their width.
const HILL: f64 = 0.5;
/// Minimum share of the bounding box that pieces cover.
const CLOSED: f64 = 0.7;

/// A plain.
pub(super) struct Ground {
    /// Height from the world's origin along the direction in which fog thins out, metres.
    pub(super) height_m: f64,
    pub(super) optics: SurfaceOptics,
    /// Its parts, by number.
    pub(super) parts: Vec<usize>,
}

/// Ground beneath fog.
pub(super) enum Beneath {
    Nothing,
    Plain(Ground),
    /// Ground without a common height.
    Hills,
}

impl Beneath {
    /// Finds the ground below fog that thins out along `up` with the scale height `scale_m`.
    pub(super) fn of(surroundings: &Surroundings, up: DVec3, scale_m: f64) -> Self {
        let across = |(low, high): (DVec3, DVec3)| {
            let size = high - low;
            size - size.dot(up.abs()) * up.abs()
        };
        let mut flat: Vec<(usize, f64, f64, (DVec3, DVec3))> = Vec::new();
        for WidePart { number, corners, area_m2, width_m } in surroundings.wide_parts(scale_m, up) {
            let heights = || corners.iter().map(|corner| corner.dot(up));
            let (low_m, high_m) = heights()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
            if high_m - low_m <= FLAT * scale_m {
                flat.push((number, 0.5 * (low_m + high_m), area_m2, bounds(corners)));
            } else if width_m >= NARROWEST * scale_m && high_m - low_m <= HILL * width_m {
                return Self::Hills;
            }
        }
        let Some(&(_, height_m, ..)) = flat.iter().max_by(|a, b| a.2.total_cmp(&b.2)) else {
            return Self::Nothing;
        };
        flat.retain(|part| (part.1 - height_m).abs() <= FLAT * scale_m);
        let all = flat.iter().map(|part| part.3).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        let size = all.map_or(DVec3::ZERO, across);
        let mut sides = size.to_array();
        sides.sort_by(f64::total_cmp);
        let area: f64 = flat.iter().map(|part| part.2).sum();
        let is_plain = sides[1] >= NARROWEST * scale_m && area >= CLOSED * sides[1] * sides[2];
        if !is_plain {
            return Self::Nothing;
        }
        let parts: Vec<usize> = flat.iter().map(|part| part.0).collect();
        Self::Plain(Ground { height_m, optics: surroundings.mean_of(&parts), parts })
    }
}
