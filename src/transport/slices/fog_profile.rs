//! Fog within one slice under a distant light. In go the boxes of fog and the half plane, out come,
//! for any ray of it, transmittance and light scattered on the way. Invariant: everything that does
//! not depend on the ray is found once a slice.
//!
//! A box cuts the half plane in a convex polygon. Its upper edge, where the light enters, is the
//! least of up to three lines `height(reach)`, its lower edge the greatest of as many; both are the
//! same for all rays. So the light's way through the fog is linear in the reach between breaks that
//! are known beforehand, and so is the camera's.

use super::depth_line::DepthLine;
use super::lit_cells::LitCells;
use super::sweep::PlanarRay;
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
    /// Whether all fog weakens all colours alike.
    is_grey: bool,
    /// Where the current ray's stretches begin and end.
    cuts: Vec<f64>,
    /// What of the light the scene lets through.
    lit: LitCells,
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
    /// Light scattered into the current ray there, per metre and irradiance, 1/(m sr).
    scattering: Rgb,
}

/// Between which heights the light is in a box.
#[derive(Clone, Copy, Debug)]
struct LightWay {
    upper: Line,
    lower: Line,
}

/// A break too many costs one exponential, a break too few an error: rounding must not lose one.
const EDGE_SLACK: f64 = 1e-9;

/// A face as near to the light's direction, in radians, runs along it: as a line over the reach it would be so
/// steep that rounding puts it metres from where it is.
const ALONG_THE_LIGHT: f64 = 1e-12;

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

/// Cells for each optical depth of the way through all fog, to the eye and to the light: where they
/// are many each is soon done, where they are few many shadows lie in those that rays end in.
const CELLS_PER_DEPTH: f64 = 3.0;

impl FogProfile {
    /// Starts over with another slice, in which everything is lit.
    pub(super) fn start(&mut self, medium: &Medium, half_plane: &HalfPlane) {
        let Self { boxes, breaks, ways, lit, .. } = self;
        self.is_grey = medium.banks().iter().all(|fog| fog.sigma_t == Rgb::splat(fog.sigma_t.x));
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
        let densest: f64 = medium.banks().iter().map(|fog| fog.sigma_t.max_element()).sum();
        lit.start(breaks, CELLS_PER_DEPTH * densest);
    }

    /// The light's rays between two reaches, let through until now, are blocked from now on.
    pub(super) fn darken(&mut self, start: f64, end: f64) {
        self.lit.darken(start, end);
    }

    /// Follows a ray up to a reach. The `shadows` are those that [`FogProfile::darken`] was told of;
    /// `more_shadows` are this ray's own. `None` if the fog changes too fast along it.
    pub(super) fn follow(
        &mut self,
        ray: &PlanarRay,
        end: f64,
        shadows: &IntervalSet,
        more_shadows: &IntervalSet,
    ) -> Option<Passage> {
        let Self { boxes, breaks, ways, is_grey, cuts, lit } = self;
        cuts.clear();
        let (mut first, mut last) = (f64::INFINITY, 0.0_f64);
        let mut tau = Rgb::ZERO;
        for profile in boxes.iter_mut() {
            profile.span = profile.span_of(ray.slope, end);
            let (enter, leave) = profile.span;
            if enter < leave {
                (first, last) = (first.min(enter), last.max(leave));
                tau += profile.sigma_t * ((leave - enter) / ray.direction.x);
                profile.scattering = profile.sigma_s * henyey_greenstein(ray.direction.y, profile.g);
                cuts.push(enter);
                cuts.push(leave);
            }
        }
        let mut passage = Passage { transmittance: exp_minus(tau), scattered: Rgb::ZERO };
        if first >= last {
            return Some(passage);
        }
        let mut row = breaks.partition_point(|reach| *reach <= first);
        for &reach in breaks[row..].iter().take_while(|reach| **reach < last) {
            cuts.push(reach);
        }
        cuts.sort_unstable_by(f64::total_cmp);
        for index in 1..cuts.len() {
            let (start, end) = (cuts[index - 1], cuts[index]);
            if start < end {
                // Boxes that share a face share breaks.
                while breaks.get(row).is_some_and(|reach| *reach <= start) {
                    row += 1;
                }
                let ways = &ways[row * boxes.len()..][..boxes.len()];
                let Some(stretch) = Stretch::new(boxes, ways, ray, (start, end)) else { continue };
                let through = if *is_grey {
                    stretch.depth_line::<1>().lit_integral(start..end, lit, shadows, more_shadows)
                } else {
                    stretch.depth_line::<3>().lit_integral(start..end, lit, shadows, more_shadows)
                };
                passage.scattered += stretch.scattering * through?;
            }
        }
        // In full shadow rounding may leave a trace of either sign.
        passage.scattered = (passage.scattered / ray.direction.x).max(Rgb::ZERO);
        Some(passage)
    }

    /// The share of the light that gets through to the place on a ray at a reach.
    pub(super) fn transmittance_to_light(&self, ray: &PlanarRay, reach: f64) -> Rgb {
        let row = self.breaks.partition_point(|before| *before <= reach);
        let ways = &self.ways[row * self.boxes.len()..][..self.boxes.len()];
        let depth_in = |(profile, way): (&BoxProfile, &Option<LightWay>)| {
            way.map_or(Rgb::ZERO, |way| {
                let lower = way.lower.at(reach).max(ray.slope * reach);
                profile.sigma_t * (way.upper.at(reach) - lower).max(0.0)
            })
        };
        exp_minus(self.boxes.iter().zip(ways).map(depth_in).sum())
    }
}

/// A part of a ray on which nothing changes: the optical depth, to the eye and to the light
/// together, goes straight from one value to another.
struct Stretch {
    start: f64,
    /// Light scattered per metre and irradiance, 1/(m sr).
    scattering: Rgb,
    tau_at_start: Rgb,
    tau_per_reach: Rgb,
}

impl Stretch {
    /// `None` without fog on the ray.
    fn new(
        boxes: &[BoxProfile],
        ways: &[Option<LightWay>],
        ray: &PlanarRay,
        (start, end): (f64, f64),
    ) -> Option<Self> {
        let middle = 0.5 * (start + end);
        let (mut tau_at_start, mut tau_per_reach, mut scattering) = (Rgb::ZERO, Rgb::ZERO, Rgb::ZERO);
        for (profile, way) in boxes.iter().zip(ways) {
            // Metres of this fog, to the eye and to the light: at the start, and per reach.
            let mut metres = Line { at_axis: 0.0, growth: 0.0 };
            let (enter, leave) = profile.span;
            if enter < middle && middle < leave {
                scattering += profile.scattering;
                let per_reach = 1.0 / ray.direction.x;
                metres = Line { at_axis: (start - enter) * per_reach, growth: per_reach };
            } else if leave <= middle && enter < leave {
                metres.at_axis = (leave - enter) / ray.direction.x;
            }
            if let Some(LightWay { upper, lower }) = way {
                // The way ends at the ray, or at the lower edge if the ray is below the box.
                let ray = Line { at_axis: 0.0, growth: ray.slope };
                let lower = if lower.at(middle) < ray.at(middle) { &ray } else { lower };
                if lower.at(middle) < upper.at(middle) {
                    metres.at_axis += upper.at(start) - lower.at(start);
                    metres.growth += upper.growth - lower.growth;
                }
            }
            tau_at_start += profile.sigma_t * metres.at_axis;
            tau_per_reach += profile.sigma_t * metres.growth;
        }
        (scattering != Rgb::ZERO).then_some(Self { start, scattering, tau_at_start, tau_per_reach })
    }

    fn depth_line<const LANES: usize>(&self) -> DepthLine<LANES> {
        let lanes = |of: Rgb| std::array::from_fn(|lane| of[lane]);
        DepthLine {
            start: self.start,
            at_start: lanes(self.tau_at_start),
            per_reach: lanes(self.tau_per_reach),
        }
    }
}

impl BoxProfile {
    fn new(fog: &FogBank, half_plane: &HalfPlane) -> Self {
        let (at_eye, per_reach) = fog.in_cube(half_plane.eye, half_plane.outward);
        let (_, per_height) = fog.in_cube(half_plane.eye, half_plane.axis);
        let (sigma_t, sigma_s, g) = (fog.sigma_t, fog.sigma_s, fog.g);
        Self { at_eye, per_reach, per_height, sigma_t, sigma_s, g, span: (0.0, 0.0), scattering: Rgb::ZERO }
    }

    /// The lines in which the slice cuts the two faces across an axis of the cube, the one where the
    /// light enters first; `None` if they run along the light.
    fn faces(&self, axis: usize) -> Option<[Line; 2]> {
        let (c, r, h) = (self.at_eye[axis], self.per_reach[axis], self.per_height[axis]);
        // Where c + r reach + h height = face.
        let line = |face: f64| Line { at_axis: (face - c) / h, growth: -r / h };
        (h.abs() > ALONG_THE_LIGHT * r.abs()).then(|| [line(h.signum()), line(-h.signum())])
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
