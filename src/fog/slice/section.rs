//! Section of one bank of fog by a slice. In go the bank and the half plane. Out come the range of a ray
//! inside, and the heights at which the light enters and leaves. Invariant: all that does not depend on the
//! ray is computed once a slice.
//!
//! A bank is bounded by planes, each of which cuts the half plane in a line. So the section is a convex
//! polygon, which may be unbounded. Its upper edge, where the light enters, is the minimum of some lines
//! `height(reach)`; its lower edge is the maximum of others. Both are the same for all rays. Fog that thins
//! out with height has two sections. Below its base it is uniform. Above it its density is `exp(-u)`, with
//! `u` linear in reach and height.

use crate::accel::HalfPlane;
use crate::fog::FogBank;
use crate::fog::bank::EDGE_SLACK;
use crate::math::Ray;
use glam::DVec3;

/// Angle to the light's direction, in radians, below which a border counts as parallel to it: as a line over
/// the reach it would be so steep that rounding moves it by metres.
const ALONG_THE_LIGHT: f64 = 1e-12;

/// Maximum number of borders: three pairs of faces, and the base.
const MOST_BORDERS: usize = 7;

/// A bank's section, or the part of it on one side of its base.
#[derive(Clone, Copy, Debug)]
pub(super) struct FogSection {
    /// Functions that are all positive inside.
    borders: [Linear; MOST_BORDERS],
    count: usize,
    /// Scale heights above the base, if the density depends on them.
    pub(super) scale_heights: Option<Linear>,
}

/// A linear function of the place in the half plane.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Linear {
    pub(super) at_eye: f64,
    pub(super) per_reach: f64,
    pub(super) per_height: f64,
}

/// `at_axis + growth * reach`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) at_axis: f64,
    pub(super) growth: f64,
}

/// Heights between which the light is in the fog. In unbounded fog the upper is infinite.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightWay {
    pub(super) upper: Line,
    pub(super) lower: Line,
}

impl Line {
    pub(super) fn at(&self, reach: f64) -> f64 {
        self.at_axis + self.growth * reach
    }
}

impl Linear {
    /// Values along a line `height(reach)`.
    pub(super) fn along(&self, line: &Line) -> Line {
        Line {
            at_axis: self.at_eye + self.per_height * line.at_axis,
            growth: self.per_reach + self.per_height * line.growth,
        }
    }

    fn at(&self, reach: f64, height: f64) -> f64 {
        self.at_eye + self.per_reach * reach + self.per_height * height
    }

    fn negative(&self) -> Self {
        Self { at_eye: -self.at_eye, per_reach: -self.per_reach, per_height: -self.per_height }
    }

    /// Line on which it is zero; `None` if that is parallel to the light.
    fn zero(&self) -> Option<Line> {
        let line =
            Line { at_axis: -self.at_eye / self.per_height, growth: -self.per_reach / self.per_height };
        (self.per_height.abs() > ALONG_THE_LIGHT * self.per_reach.abs()).then_some(line)
    }
}

impl FogSection {
    /// Calls back with the sections of a bank; `None` if its density has no sections.
    pub(super) fn for_each(fog: &FogBank, half_plane: &HalfPlane, mut each: impl FnMut(Self)) -> Option<()> {
        let mut section = Self { borders: Default::default(), count: 0, scale_heights: None };
        if fog.is_bounded() {
            let (at_eye, per_reach) = fog.in_cube(half_plane.eye, half_plane.outward);
            let (_, per_height) = fog.in_cube(half_plane.eye, half_plane.axis);
            for axis in 0..3 {
                let (at_eye, per_reach, per_height) = (at_eye[axis], per_reach[axis], per_height[axis]);
                section.add(Linear { at_eye: 1.0 - at_eye, per_reach: -per_reach, per_height: -per_height });
                section.add(Linear { at_eye: 1.0 + at_eye, per_reach, per_height });
            }
        }
        if fog.is_even() {
            each(section);
            return Some(());
        }
        let heights = |direction: DVec3| fog.climb(&Ray { origin: half_plane.eye, direction });
        let (outward, upward) = (heights(half_plane.outward)?, heights(half_plane.axis)?);
        let scale_heights =
            Linear { at_eye: outward.height(0.0), per_reach: outward.per_m, per_height: upward.per_m };
        let mut below = section;
        below.add(scale_heights.negative());
        each(below);
        section.add(scale_heights);
        section.scale_heights = Some(scale_heights);
        each(section);
        Some(())
    }

    fn add(&mut self, border: Linear) {
        self.borders[self.count] = border;
        self.count += 1;
    }

    fn borders(&self) -> &[Linear] {
        &self.borders[..self.count]
    }

    /// Every reach at which the light's way changes from one border to another, or is parallel to one.
    pub(super) fn for_each_break(&self, mut reach: impl FnMut(f64)) {
        let borders = self.borders();
        for (index, border) in borders.iter().enumerate() {
            let Some(line) = border.zero() else {
                reach(-border.at_eye / border.per_reach);
                continue;
            };
            for (other_index, other) in borders.iter().enumerate().skip(index + 1) {
                let Some(other_line) = other.zero() else { continue };
                let at = (other_line.at_axis - line.at_axis) / (line.growth - other_line.growth);
                let height = line.at(at);
                // Beyond a third border the lines cross, but the edges do not.
                let is_inside = |(third, border): (usize, &Linear)| {
                    third == index || third == other_index || border.at(at, height) >= -EDGE_SLACK
                };
                if borders.iter().enumerate().all(is_inside) {
                    reach(at);
                }
            }
        }
    }

    /// Light's way through the fog at a reach, and so up to the next breaks on both sides.
    pub(super) fn light_way(&self, reach: f64) -> Option<LightWay> {
        let mut upper = Line { at_axis: f64::INFINITY, growth: 0.0 };
        let mut lower = Line { at_axis: f64::NEG_INFINITY, growth: 0.0 };
        for border in self.borders() {
            let Some(line) = border.zero() else {
                if border.at(reach, 0.0) < 0.0 {
                    return None;
                }
                continue;
            };
            let is_above = border.per_height < 0.0;
            if is_above && line.at(reach) < upper.at(reach) {
                upper = line;
            } else if !is_above && line.at(reach) > lower.at(reach) {
                lower = line;
            }
        }
        (lower.at(reach) < upper.at(reach)).then_some(LightWay { upper, lower })
    }

    /// Part of a range of reaches in which a ray is inside.
    pub(super) fn span_of(&self, slope: f64, (mut enter, mut leave): (f64, f64)) -> (f64, f64) {
        for border in self.borders() {
            let growth = border.per_reach + slope * border.per_height;
            let at = -border.at_eye / growth;
            if growth > 0.0 {
                enter = enter.max(at);
            } else if growth < 0.0 {
                leave = leave.min(at);
            } else if border.at_eye < 0.0 {
                return (0.0, 0.0);
            }
        }
        (enter, leave)
    }
}
