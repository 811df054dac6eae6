//! Fog within one slice under a distant light. In go the boxes of fog and the half plane, out come,
//! for any ray of it, transmittance and light scattered on the way. Invariant: everything that does
//! not depend on the ray is found once a slice.
//!
//! A box cuts the half plane in a convex polygon. Its upper edge, where the light enters, is the
//! least of up to three lines `height(reach)`, its lower edge the greatest of as many; both are the
//! same for all rays. So the light's way through the fog is linear in the reach between breaks that
//! are known beforehand, and so is the camera's.

use crate::accel::HalfPlane;
use crate::color::Rgb;
use crate::math::IntervalSet;
use crate::scattering::{FogBank, Medium, exp_minus, henyey_greenstein};
use glam::DVec3;

/// All fog of a slice.
#[derive(Debug, Default)]
pub(super) struct FogProfile {
    boxes: Vec<BoxProfile>,
    /// Reaches at which the light's way changes from one face of a box to another, in order.
    breaks: Vec<f64>,
    /// The light's way between one break and the next: a row of all boxes before the first break, one
    /// after each.
    ways: Vec<Option<LightWay>>,
    /// Where the current ray's stretches begin and end.
    cuts: Vec<f64>,
}

/// A box's polygon.
#[derive(Debug)]
struct BoxProfile {
    /// Coordinates in the cube `[-1, 1]^3`: at the camera, and per metre of reach and of height.
    at_eye: DVec3,
    per_reach: DVec3,
    per_height: DVec3,
    sigma_t: Rgb,
    sigma_s: Rgb,
    g: f64,
    /// Reaches between which the current ray is inside.
    span: (f64, f64),
}

/// Between which heights the light is in a box.
#[derive(Clone, Copy, Debug)]
struct LightWay {
    upper: Line,
    lower: Line,
}

/// A break too many costs one exponential, a break too few an error: rounding must not lose one.
const EDGE_SLACK: f64 = 1e-9;

/// `height = at_axis + growth * reach`.
#[derive(Clone, Copy, Debug)]
struct Line {
    at_axis: f64,
    growth: f64,
}

impl Line {
    fn at(&self, reach: f64) -> f64 {
        self.at_axis + self.growth * reach
    }
}

/// What fog does along one ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passage {
    /// Of what lies behind.
    pub(super) transmittance: Rgb,
    /// Light scattered on the way, per unit of irradiance, 1/sr.
    pub(super) scattered: Rgb,
}

impl FogProfile {
    /// Starts over with another slice.
    pub(super) fn start(&mut self, medium: &Medium, half_plane: &HalfPlane) {
        let Self { boxes, breaks, ways, .. } = self;
        boxes.clear();
        boxes.extend(medium.banks().iter().map(|fog| BoxProfile::new(fog, half_plane)));
        breaks.clear();
        for profile in boxes.iter() {
            profile.for_each_break(|reach| {
                if reach > 0.0 && reach.is_finite() {
                    breaks.push(reach);
                }
            });
        }
        breaks.sort_unstable_by(f64::total_cmp);
        ways.clear();
        for index in 0..=breaks.len() {
            let before = if index == 0 { 0.0 } else { breaks[index - 1] };
            let middle = breaks.get(index).map_or(before + 1.0, |after| 0.5 * (before + after));
            ways.extend(boxes.iter().map(|profile| profile.light_way(middle)));
        }
    }

    /// Follows a ray of the given slope up to a reach; `spread` is reach per metre of the ray.
    pub(super) fn follow(&mut self, slope: f64, spread: f64, end: f64, shadows: &IntervalSet) -> Passage {
        let Self { boxes, breaks, ways, cuts } = self;
        cuts.clear();
        let (mut first, mut last) = (f64::INFINITY, 0.0_f64);
        let mut tau = Rgb::ZERO;
        for profile in boxes.iter_mut() {
            profile.span = profile.span_of(slope, end);
            let (enter, leave) = profile.span;
            if enter < leave {
                (first, last) = (first.min(enter), last.max(leave));
                tau += profile.sigma_t * ((leave - enter) / spread);
                cuts.extend([enter, leave]);
            }
        }
        let mut passage = Passage { transmittance: exp_minus(tau), scattered: Rgb::ZERO };
        if first >= last {
            return passage;
        }
        let mut row = breaks.partition_point(|reach| *reach <= first);
        cuts.extend(breaks[row..].iter().take_while(|reach| **reach < last));
        cuts.sort_unstable_by(f64::total_cmp);
        for index in 1..cuts.len() {
            let (start, end) = (cuts[index - 1], cuts[index]);
            if start < end {
                row += usize::from(breaks.get(row).is_some_and(|reach| *reach <= start));
                let ways = &ways[row * boxes.len()..][..boxes.len()];
                passage.scattered += stretch(boxes, ways, slope, spread, (start, end), shadows);
            }
        }
        passage
    }
}

/// Light scattered between two reaches between which nothing changes.
fn stretch(
    boxes: &[BoxProfile],
    ways: &[Option<LightWay>],
    slope: f64,
    spread: f64,
    (start, end): (f64, f64),
    shadows: &IntervalSet,
) -> Rgb {
    let middle = 0.5 * (start + end);
    let (mut tau_start, mut tau_end, mut scattering) = (Rgb::ZERO, Rgb::ZERO, Rgb::ZERO);
    for (profile, way) in boxes.iter().zip(ways) {
        let (enter, leave) = profile.span;
        let way_to_eye = |reach: f64| (reach.clamp(enter, leave) - enter) / spread;
        let (mut way_start, mut way_end) = (0.0, 0.0);
        if enter < leave {
            (way_start, way_end) = (way_to_eye(start), way_to_eye(end));
            if enter < middle && middle < leave {
                scattering += profile.sigma_s * henyey_greenstein(slope * spread, profile.g);
            }
        }
        let (mut light_start, mut light_end) = (0.0, 0.0);
        if let Some(LightWay { upper, lower }) = way {
            // The way ends at the ray, or at the lower edge if the ray is below the box.
            let ray = Line { at_axis: 0.0, growth: slope };
            let lower = if lower.at(middle) < ray.at(middle) { &ray } else { lower };
            if lower.at(middle) < upper.at(middle) {
                light_start = upper.at(start) - lower.at(start);
                light_end = upper.at(end) - lower.at(end);
            }
        }
        tau_start += profile.sigma_t * (way_start + light_start);
        tau_end += profile.sigma_t * (way_end + light_end);
    }
    if scattering == Rgb::ZERO {
        return Rgb::ZERO;
    }
    let tau_per_reach = (tau_end - tau_start) / (end - start);
    let is_grey = tau_start.x == tau_start.y
        && tau_start.y == tau_start.z
        && tau_per_reach.x == tau_per_reach.y
        && tau_per_reach.y == tau_per_reach.z;
    let mut through = Rgb::ZERO;
    shadows.for_each_gap(start, end, |a, b| {
        let one = |channel: usize| {
            let tau = |reach: f64| tau_start[channel] + tau_per_reach[channel] * (reach - start);
            integral_of_transmittance(b - a, tau(a), tau(b))
        };
        through += if is_grey { Rgb::splat(one(0)) } else { Rgb::new(one(0), one(1), one(2)) };
    });
    scattering * through / spread
}

/// `integral of exp(-tau)` over an interval of this width, where tau goes straight from one value to
/// the other.
fn integral_of_transmittance(width: f64, tau_start: f64, tau_end: f64) -> f64 {
    let half_change = 0.5 * (tau_end - tau_start);
    if half_change.abs() < 0.25 {
        // sinh(x) / x: the next term is x^8 / 362880, below 5e-11.
        let square = half_change * half_change;
        let sinhc = 1.0 + square * (1.0 / 6.0 + square * (1.0 / 120.0 + square / 5040.0));
        return width * (-0.5 * (tau_start + tau_end)).exp() * sinhc;
    }
    width * ((-tau_start).exp() - (-tau_end).exp()) / (2.0 * half_change)
}

impl BoxProfile {
    fn new(fog: &FogBank, half_plane: &HalfPlane) -> Self {
        let (at_eye, per_reach) = fog.in_cube(half_plane.eye, half_plane.outward);
        let (_, per_height) = fog.in_cube(half_plane.eye, half_plane.axis);
        let (sigma_t, sigma_s, g) = (fog.sigma_t, fog.sigma_s, fog.g);
        Self { at_eye, per_reach, per_height, sigma_t, sigma_s, g, span: (0.0, 0.0) }
    }

    /// The lines in which the slice cuts the two faces across an axis of the cube, the one where the
    /// light enters first; `None` if they run along the light.
    fn faces(&self, axis: usize) -> Option<[Line; 2]> {
        let (c, r, h) = (self.at_eye[axis], self.per_reach[axis], self.per_height[axis]);
        // Where c + r reach + h height = face.
        let line = |face: f64| Line { at_axis: (face - c) / h, growth: -r / h };
        (h != 0.0).then(|| [line(h.signum()), line(-h.signum())])
    }

    /// Every reach at which the light passes from one face to another, or along a face.
    fn for_each_break(&self, mut reach: impl FnMut(f64)) {
        for axis in 0..3 {
            let Some(lines) = self.faces(axis) else {
                for face in [-1.0, 1.0] {
                    reach((face - self.at_eye[axis]) / self.per_reach[axis]);
                }
                continue;
            };
            for other in axis + 1..3 {
                let third = 3 - axis - other;
                let others = self.faces(other).into_iter().flatten();
                for (b, a) in others.flat_map(|b| lines.map(|a| (b, a))) {
                    let at = (b.at_axis - a.at_axis) / (a.growth - b.growth);
                    let coordinate =
                        self.at_eye[third] + at * self.per_reach[third] + a.at(at) * self.per_height[third];
                    // Beyond the third pair of faces the lines cross, but the faces do not.
                    if coordinate.abs() <= 1.0 + EDGE_SLACK {
                        reach(at);
                    }
                }
            }
        }
    }

    /// Where the light is in the box at a reach, and so on both sides of it up to the next breaks.
    fn light_way(&self, reach: f64) -> Option<LightWay> {
        let mut way: Option<LightWay> = None;
        for axis in 0..3 {
            let Some([upper, lower]) = self.faces(axis) else {
                if (self.at_eye[axis] + reach * self.per_reach[axis]).abs() > 1.0 {
                    return None;
                }
                continue;
            };
            let least = way
                .map_or(upper, |way| if upper.at(reach) < way.upper.at(reach) { upper } else { way.upper });
            let greatest = way
                .map_or(lower, |way| if lower.at(reach) > way.lower.at(reach) { lower } else { way.lower });
            way = Some(LightWay { upper: least, lower: greatest });
        }
        way.filter(|way| way.lower.at(reach) < way.upper.at(reach))
    }

    /// Reaches between which a ray is inside.
    fn span_of(&self, slope: f64, end: f64) -> (f64, f64) {
        let per_reach = self.per_reach + slope * self.per_height;
        let (mut enter, mut leave) = (0.0_f64, end);
        for axis in 0..3 {
            let (c, growth) = (self.at_eye[axis], per_reach[axis]);
            if growth == 0.0 {
                if c.abs() > 1.0 {
                    return (0.0, 0.0);
                }
                continue;
            }
            let (low, high) = ((-1.0 - c) / growth, (1.0 - c) / growth);
            enter = enter.max(low.min(high));
            leave = leave.min(low.max(high));
        }
        (enter, leave)
    }
}
