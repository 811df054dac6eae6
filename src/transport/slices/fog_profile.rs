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
use crate::scattering::{FogBox, Medium, exp_minus, henyey_greenstein};
use glam::DVec3;

/// All fog of a slice.
#[derive(Debug, Default)]
pub(super) struct FogProfile {
    boxes: Vec<BoxProfile>,
    /// Reaches at which the light's way changes from one face of a box to another, in order.
    breaks: Vec<f64>,
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
    upper: Vec<Line>,
    lower: Vec<Line>,
    sigma_t: Rgb,
    sigma_s: Rgb,
    g: f64,
    /// Reaches between which the current ray is inside.
    span: (f64, f64),
}

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
        self.boxes.clear();
        self.boxes.extend(medium.boxes().iter().map(|fog| BoxProfile::new(fog, half_plane)));
        self.breaks.clear();
        for profile in &self.boxes {
            for lines in [&profile.upper, &profile.lower] {
                for (index, a) in lines.iter().enumerate() {
                    self.breaks.extend(lines[index + 1..].iter().map(|b| crossing(a, b)));
                }
            }
            for upper in &profile.upper {
                self.breaks.extend(profile.lower.iter().map(|lower| crossing(upper, lower)));
            }
        }
        self.breaks.retain(|reach| *reach > 0.0 && reach.is_finite());
        self.breaks.sort_unstable_by(f64::total_cmp);
    }

    /// Follows a ray of the given slope up to a reach; `spread` is reach per metre of the ray.
    pub(super) fn follow(&mut self, slope: f64, spread: f64, end: f64, shadows: &IntervalSet) -> Passage {
        let Self { boxes, breaks, cuts } = self;
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
        let from = breaks.partition_point(|reach| *reach <= first);
        cuts.extend(breaks[from..].iter().take_while(|reach| **reach < last));
        cuts.sort_unstable_by(f64::total_cmp);
        for index in 1..cuts.len() {
            let (start, end) = (cuts[index - 1], cuts[index]);
            if start < end {
                passage.scattered += stretch(boxes, slope, spread, (start, end), shadows);
            }
        }
        passage
    }
}

/// Light scattered between two reaches between which nothing changes.
fn stretch(
    boxes: &[BoxProfile],
    slope: f64,
    spread: f64,
    (start, end): (f64, f64),
    shadows: &IntervalSet,
) -> Rgb {
    let middle = 0.5 * (start + end);
    let (mut tau_start, mut tau_end, mut scattering) = (Rgb::ZERO, Rgb::ZERO, Rgb::ZERO);
    for profile in boxes {
        let (enter, leave) = profile.span;
        let way_to_eye = |reach: f64| (reach.clamp(enter, leave) - enter) / spread;
        let (mut way_start, mut way_end) = (0.0, 0.0);
        if enter < leave {
            (way_start, way_end) = (way_to_eye(start), way_to_eye(end));
            if enter < middle && middle < leave {
                scattering += profile.sigma_s * henyey_greenstein(slope * spread, profile.g);
            }
        }
        let (light_start, light_end) = profile.way_to_light(slope, start, middle, end);
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
    fn new(fog: &FogBox, half_plane: &HalfPlane) -> Self {
        let (at_eye, per_reach) = fog.in_cube(DVec3::ZERO, half_plane.outward);
        let (_, per_height) = fog.in_cube(DVec3::ZERO, half_plane.axis);
        let (mut upper, mut lower) = (Vec::with_capacity(3), Vec::with_capacity(3));
        for axis in 0..3 {
            let (c, r, h) = (at_eye[axis], per_reach[axis], per_height[axis]);
            // Where c + r reach + h height = face.
            let line = |face: f64| Line { at_axis: (face - c) / h, growth: -r / h };
            if h != 0.0 {
                upper.push(line(h.signum()));
                lower.push(line(-h.signum()));
            }
        }
        let (sigma_t, sigma_s, g) = (fog.sigma_t, fog.sigma_s, fog.g);
        Self { at_eye, per_reach, per_height, upper, lower, sigma_t, sigma_s, g, span: (0.0, 0.0) }
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

    /// Lengths of the light's way through the box to the ray at `start` and `end`; which edges it
    /// crosses is told by `middle`.
    fn way_to_light(&self, slope: f64, start: f64, middle: f64, end: f64) -> (f64, f64) {
        // Faces along the light bound the reach.
        for axis in 0..3 {
            let within = (self.at_eye[axis] + middle * self.per_reach[axis]).abs() <= 1.0;
            if self.per_height[axis] == 0.0 && !within {
                return (0.0, 0.0);
            }
        }
        let pick = |lines: &[Line], sign: f64, none: Line| {
            lines
                .iter()
                .copied()
                .reduce(|a, b| if sign * a.at(middle) < sign * b.at(middle) { a } else { b })
                .unwrap_or(none)
        };
        let ray = Line { at_axis: 0.0, growth: slope };
        let upper = pick(&self.upper, 1.0, ray);
        let lower = pick(&self.lower, -1.0, ray);
        let lower = if lower.at(middle) < ray.at(middle) { ray } else { lower };
        if upper.at(middle) <= lower.at(middle) {
            return (0.0, 0.0);
        }
        (upper.at(start) - lower.at(start), upper.at(end) - lower.at(end))
    }
}

fn crossing(a: &Line, b: &Line) -> f64 {
    (b.at_axis - a.at_axis) / (a.growth - b.growth)
}
