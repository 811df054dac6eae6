//! Fog whose density is an exponential of the height, on the ways of eye and light. In go its section of the
//! slice and a ray. Out come its metres on both ways and its density, as series around the centre of a piece.
//! Invariant: where the density changes little on a way, nothing is divided by its change, so nothing cancels
//! on level ways.

use super::lit_cells::{ORDER, Piece};
use super::section::{LightWay, Line, Linear};
use crate::color::Rgb;
use crate::math::{PlanarRay, fast_exp};
use std::ops::Range;

/// A number and its derivatives at the centre of a piece, in halves of its width.
pub(super) type Series = [f64; ORDER];

/// One bank of fog, or its part above its base, on an interval of a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct ThinningFog {
    pub(super) sigma_t: Rgb,
    /// Scattering per metre and irradiance at the base, where the ray is inside, 1/(m sr).
    pub(super) scattering: Rgb,
    /// Heights on the ray's part inside.
    pub(super) along_ray: Option<Ascent>,
    pub(super) to_light: Option<Column>,
}

/// Thinning fog along the ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ascent {
    metres_per_reach: f64,
    scale_heights_per_reach: f64,
    density_at_start: f64,
}

/// Light's way through thinning fog.
#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    way: LightWay,
    /// Scale heights at the lower end.
    at_lower: Line,
    at_upper: Line,
    scale_heights: Linear,
}

impl Column {
    /// Column of a way; `None` if its fog is infinite.
    pub(super) fn new(way: LightWay, scale_heights: Linear) -> Option<Self> {
        let (at_lower, at_upper) = (scale_heights.along(&way.lower), scale_heights.along(&way.upper));
        let column = Self { way, at_lower, at_upper, scale_heights };
        if !column.is_endless() {
            return Some(column);
        }
        let at_upper = Line { at_axis: f64::INFINITY, growth: 0.0 };
        (scale_heights.per_height > 0.0).then_some(Self { at_upper, ..column })
    }

    /// Metres at a reach, at the density of the base.
    pub(super) fn metres(&self, reach: f64) -> f64 {
        self.metres_and_ends(reach).0
    }

    /// As [`Self::metres`], with the densities at the lower and the upper end.
    fn metres_and_ends(&self, reach: f64) -> (f64, f64, f64) {
        let (low, high) = (self.at_lower.at(reach), self.at_upper.at(reach));
        let (at_lower, at_upper) = (fast_exp(-low), fast_exp(-high));
        let metres = if self.is_thin(reach) {
            let length = self.way.upper.at(reach) - self.way.lower.at(reach);
            at_lower * length * mean_of_exp_minus(high - low)
        } else {
            (at_lower - at_upper) / self.scale_heights.per_height
        };
        (metres, at_lower, at_upper)
    }

    /// Whether the density changes so little on the way that the difference of its ends would cancel.
    fn is_thin(&self, reach: f64) -> bool {
        (self.at_upper.at(reach) - self.at_lower.at(reach)).abs() < SMALL_CHANGE
    }

    fn is_endless(&self) -> bool {
        self.way.upper.at_axis == f64::INFINITY
    }

    fn series(&self, piece: &Piece) -> Series {
        let (metres, at_lower, at_upper) = self.metres_and_ends(piece.middle);
        let h = piece.half_width;
        let (per_upper, per_lower) = (-h * self.at_upper.growth, -h * self.at_lower.growth);
        let mut series = [metres; ORDER];
        if self.is_thin(piece.middle) {
            // Gain at the upper end, minus loss at the lower end, minus thinning of all between.
            let mut gain = h * self.way.upper.growth * at_upper;
            let mut loss = h * self.way.lower.growth * at_lower;
            let thinning = h * self.scale_heights.per_reach;
            for j in 1..ORDER {
                series[j] = gain - loss - thinning * series[j - 1];
                gain *= per_upper;
                loss *= per_lower;
            }
        } else {
            let mut upper = at_upper / self.scale_heights.per_height;
            let mut lower = at_lower / self.scale_heights.per_height;
            for metres in &mut series[1..] {
                upper *= per_upper;
                lower *= per_lower;
                *metres = lower - upper;
            }
        }
        series
    }

    /// Maximum change of an exponent per reach.
    fn exponents_change(&self) -> f64 {
        let ends = self.at_lower.growth.abs().max(self.at_upper.growth.abs());
        if self.is_endless() { ends } else { ends.max(self.scale_heights.per_reach.abs()) }
    }

    /// Bound on the growth of the metres per reach, at a reach of a range; its logarithm is convex.
    fn growth_bound(&self, reach: f64, longest: f64) -> f64 {
        let (_, at_lower, at_upper) = self.metres_and_ends(reach);
        let per_height = self.scale_heights.per_height.abs();
        if self.is_endless() {
            return self.at_lower.growth.abs() * at_lower / per_height;
        }
        let metres = at_lower.max(at_upper) * longest.min(per_height.recip());
        self.way.upper.growth.abs() * at_upper
            + self.way.lower.growth.abs() * at_lower
            + self.scale_heights.per_reach.abs() * metres
    }
}

/// Change below which an exponential's mean is a polynomial.
const SMALL_CHANGE: f64 = 0.5;

/// `(1 - exp(-x)) / x` for `|x| < 0.5`: the first omitted term is `x^9 / 10!`, below 1e-9.
fn mean_of_exp_minus(x: f64) -> f64 {
    let x2 = x * x;
    let x4 = x2 * x2;
    let low = (1.0 - x * (1.0 / 2.0)) + x2 * (1.0 / 6.0 - x * (1.0 / 24.0));
    let high = (1.0 / 120.0 - x * (1.0 / 720.0)) + x2 * (1.0 / 5040.0 - x * (1.0 / 40_320.0));
    low + x4 * (high + x4 * (1.0 / 362_880.0))
}

impl Ascent {
    pub(super) fn new(scale_heights: &Linear, ray: &PlanarRay, start: f64) -> Self {
        let heights = scale_heights.along(&Line { at_axis: 0.0, growth: ray.slope });
        Self {
            metres_per_reach: 1.0 / ray.direction.x,
            scale_heights_per_reach: heights.growth,
            density_at_start: fast_exp(-heights.at(start)),
        }
    }

    /// Metres over a distance in reach, at the density of the base, and the density there.
    pub(super) fn metres_and_density(&self, reach: f64) -> (f64, f64) {
        let change = self.scale_heights_per_reach * reach;
        let share = fast_exp(-change);
        let mean =
            if change.abs() < SMALL_CHANGE { mean_of_exp_minus(change) } else { (1.0 - share) / change };
        (self.metres_per_reach * reach * self.density_at_start * mean, self.density_at_start * share)
    }

    /// Density as a series, at a distance in reach from the start.
    pub(super) fn density(&self, reach: f64, half_width: f64) -> Series {
        let ratio = -self.scale_heights_per_reach * half_width;
        let mut series = [self.metres_and_density(reach).1; ORDER];
        for j in 1..ORDER {
            series[j] = ratio * series[j - 1];
        }
        series
    }
}

impl ThinningFog {
    /// The metres of this fog, to the eye and to the light; the interval begins at `start`.
    pub(super) fn metres(&self, start: f64, piece: &Piece) -> Series {
        let mut metres = self.to_light.map_or([0.0; ORDER], |column| column.series(piece));
        if let Some(ascent) = self.along_ray {
            let (to_eye, density) = ascent.metres_and_density(piece.middle - start);
            let ratio = -ascent.scale_heights_per_reach * piece.half_width;
            let mut term = ascent.metres_per_reach * piece.half_width * density;
            metres[0] += to_eye;
            for metres in &mut metres[1..] {
                *metres += term;
                term *= ratio;
            }
        }
        metres
    }

    /// Maximum change of an exponent per reach, for any density of the fog.
    pub(super) fn exponents_change(&self) -> f64 {
        let of_ray = self.along_ray.map_or(0.0, |ascent| ascent.scale_heights_per_reach.abs());
        of_ray.max(self.to_light.map_or(0.0, |column| column.exponents_change()))
    }

    /// Bound on the growth of the optical depth at a reach of a range; its logarithm is convex.
    pub(super) fn depth_change(&self, start: f64, reach: f64, range: &Range<f64>) -> f64 {
        let of_ray = self
            .along_ray
            .map_or(0.0, |ascent| ascent.metres_per_reach * ascent.metres_and_density(reach - start).1);
        let of_light = self.to_light.map_or(0.0, |column| {
            let length = |at: f64| column.way.upper.at(at) - column.way.lower.at(at);
            column.growth_bound(reach, length(range.start).max(length(range.end)))
        });
        self.sigma_t.max_element() * (of_ray + of_light)
    }
}
