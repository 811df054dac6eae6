//! Light of a near lamp that fog scatters into a ray. In go an interval of fog and a light, out comes the
//! integral over any lit part of it. A few parts of uniform fog of low depth are integrated one by one, with
//! rules whose order follows from the integrand's singularities. Otherwise all parts share one
//! antiderivative. Invariant: the antiderivative is fitted to a tolerance.
//!
//! The variable is `x = asinh((t - nearest) / gap)`, with `dt / distance^2 = dtheta / gap = dx / (gap cosh
//! x)`. It is the inverse Gudermannian of the equiangular angle `theta` (Kulla & Fajardo 2012). In `theta`
//! a phase function is a peak as narrow as `1 - |g|` at the far end. In `x` the cosine of the deflection
//! is `-tanh x`. Henyey & Greenstein's function becomes `((1 + e^2x) / ((1 -+ g)^2 + (1 +- g)^2
//! e^2x))^1.5`: a step as wide as the integrand's other changes. Its singularities, like those of `cosh
//! x`, lie `pi / 2` from the real axis for every `g`.

use super::LitSegments;
use super::beer_lambert::exp_minus;
use super::ray_interval::RayInterval;
use crate::color::Rgb;
use crate::light::{Emission, LampShape};
use crate::math::{Antiderivative, gauss_legendre};
use glam::DVec3;
use std::ops::Range;

/// A near light over an interval of a ray.
pub(super) struct NearLight<'a> {
    interval: &'a RayInterval<'a>,
    light: DVec3,
    emission: Emission,
    shape: LampShape,
    nearest: f64,
    gap: f64,
    /// Additional nodes for an angular distribution that is a polynomial: its degree, halved and rounded up.
    more_nodes: usize,
    /// Maximum extinction of all fog together, 1/m, which bounds the exponential's rate.
    densest_per_m: f64,
    /// The nearest poles before and after the interval, in `x`: see [`NearLight::poles`].
    poles: (f64, f64),
}

/// Minimum distance of a light from the ray, as a fraction of the light's distance: nearer lights count as
/// this far. The integral is unbounded as the gap closes, but no picture shows that.
const SMALLEST_RELATIVE_GAP: f64 = 1e-7;

/// Minimum gap as a fraction of the distance to the end of the fog: every ray passes through a lamp at the
/// camera.
const SMALLEST_SHARE: f64 = 1e-18;

/// Tolerance of a fit, relative to the integral over the whole range.
const FIT_TOLERANCE: f64 = 1e-8;

/// Tolerance near voxels, whose depths to the lamp are no more accurate, nor smoother, than their lattice.
const VOXEL_TOLERANCE: f64 = 1e-4;

/// Number of parts from which a fit costs no more than the parts one by one (`cargo bench --bench figures
/// -- near`).
const MANY_PARTS: usize = 20;

/// Maximum length of a step, see [`NearLight::part`].
const LONGEST_STEP: f64 = 2.0;

/// Maximum ratio of a distance along the ray to the gap, so that its square is finite.
const LARGEST_RATIO: f64 = 1e150;

/// Optical depth beyond which parts are fitted, too: most of their steps would add nothing.
const DEEPEST: f64 = 30.0;

impl<'a> NearLight<'a> {
    pub(super) fn new(interval: &'a RayInterval, light: DVec3, emission: Emission, shape: LampShape) -> Self {
        let ray = interval.ray;
        let to_light = light - ray.origin;
        let nearest = to_light.dot(ray.direction);
        let gap = ray.direction.cross(to_light).length();
        let gap = gap.max(SMALLEST_RELATIVE_GAP * to_light.length());
        let gap = gap.max(SMALLEST_SHARE * interval.end).max(f64::MIN_POSITIVE);
        // `Cone::falloff` is a cubic of the cosine, for any width of the cone's edge.
        let is_plain = !matches!(emission, Emission::Spot(_)) && shape.softened_m2 == 0.0;
        let more_nodes = if is_plain { 0 } else { 2 };
        let densest_per_m = interval.medium.most_extinction_per_m();
        let poles = (f64::NEG_INFINITY, f64::INFINITY);
        let mut near =
            Self { interval, light, emission, shape, nearest, gap, more_nodes, densest_per_m, poles };
        near.poles = near.poles();
        near
    }

    /// Integral over the lit parts of a range, per unit of intensity, 1/(m^2 sr).
    pub(super) fn integral(&self, range: Range<f64>, lit: &LitSegments) -> Rgb {
        let mut sum = Rgb::ZERO;
        if range.is_empty() {
            return sum;
        }
        let mut start = range.start;
        // The slope of a spot's falloff jumps at kinks, and light jumps at the lamp's surface.
        let [a, b] = self.emission.kinks(self.interval.ray, self.light);
        let [c, d] = self.shape.crossings(self.interval.ray);
        let mut ends = [a, b, c, d, None].map(|end| end.unwrap_or(range.end));
        ends.sort_unstable_by(f64::total_cmp);
        for end in ends.map(|end| end.clamp(range.start, range.end)) {
            if end > start {
                sum += self.smooth_integral(&(start..end), lit);
                start = end;
            }
        }
        sum
    }

    fn smooth_integral(&self, range: &Range<f64>, lit: &LitSegments) -> Rgb {
        let mut parts = 0;
        let mut hull = range.end..range.start;
        lit.for_each_part(range, |start, end, _| {
            parts += 1;
            hull = hull.start.min(start)..end;
        });
        if parts == 0 {
            return Rgb::ZERO;
        }
        let is_deep = self.densest_per_m * (hull.end - hull.start) > DEEPEST;
        let mut sum = Rgb::ZERO;
        // Cells are short.
        let is_smooth = self.interval.medium.is_even() || self.interval.is_in_a_cell();
        // Behind a grid, light is less smooth the nearer the ray comes to the axis.
        let is_smooth = is_smooth && !matches!(self.emission, Emission::Gridded(_));
        if parts < MANY_PARTS && !is_deep && is_smooth {
            lit.for_each_part(range, |start, end, share| sum += share * self.part(start, end));
        } else {
            let mut fitted = Antiderivative::default();
            let integrand = |x: f64| self.integrand(x, &hull);
            let has_voxels = self.interval.medium.has_voxels();
            let tolerance = if has_voxels { VOXEL_TOLERANCE } else { FIT_TOLERANCE };
            fitted.fit(integrand, self.x(hull.start), self.x(hull.end), tolerance);
            lit.for_each_part(range, |start, end, share| {
                sum += share * fitted.between(self.x(start), self.x(end));
            });
        }
        sum / self.gap
    }

    /// Integral over one part, times the gap, by Gauss-Legendre rules.
    ///
    /// On a step of width `w` a rule of `n` nodes errs by about `rho^-2n`, where `rho` belongs to the largest
    /// ellipse around the step in which the integrand is analytic (Trefethen, "Approximation Theory and
    /// Approximation Practice", theorem 19.3). Three things bound that ellipse: the lines at `pi / 2` from
    /// the real axis, the poles before and after the interval, and the change of the exponential over the
    /// step.
    fn part(&self, start: f64, end: f64) -> Rgb {
        let (mut t, mut x, last) = (start, self.x(start), self.x(end));
        let mut sum = Rgb::ZERO;
        while x < last {
            // A step may be 4/3 as long as its distance from a pole.
            let clear = (4.0 / 3.0 * (x - self.poles.0)).min(4.0 / 7.0 * (self.poles.1 - x));
            let mut to = last.min(x + LONGEST_STEP.min(clear.max(SHORTEST_STEP)));
            let mut to_t = if to < last { self.t(to).clamp(t, end) } else { end };
            let mut depths = self.depths_between(t, to_t);
            while depths > LONGEST_STEP && to - x > SHORTEST_STEP {
                to = x + (to - x) * (LONGEST_STEP / depths).clamp(0.1, 0.8);
                to_t = self.t(to).clamp(t, end);
                depths = self.depths_between(t, to_t);
            }
            let width = to - x;
            let pole = (x - self.poles.0).min(self.poles.1 - to);
            let wide = (width * (1.5 / pole).max(1.0)).max(depths);
            let (middle, half_width) = (0.5 * (x + to), 0.5 * width);
            let mut step = Rgb::ZERO;
            for (node, weight) in gauss_legendre(order_for(wide) + self.more_nodes) {
                step += *weight * self.integrand(middle + node * half_width, &(t..to_t));
            }
            sum += step * half_width;
            (t, x) = (to_t, to);
        }
        sum
    }

    /// Approximate change of the exponent from one place to another.
    fn depths_between(&self, from: f64, to: f64) -> f64 {
        let along = self.densest_per_m * (to - from);
        if self.poles == (f64::NEG_INFINITY, f64::INFINITY) {
            return along;
        }
        // Near a pole the way through the fog grows faster than the distance along the ray.
        let RayInterval { medium, ray, light, .. } = *self.interval;
        let to_light = |t: f64| medium.known_depth_to(ray.at(t), light);
        along + (to_light(to) - to_light(from)).abs().max_element()
    }

    /// Poles of the integrand on the real axis just before and just after the interval.
    ///
    /// The way to the light enters a bank through a face `y_i = a` at the fraction `(a - y_i(t)) / (p_i -
    /// y_i(t))` of its length, where `p` is the light in the bank's own space. It has a pole where the ray's
    /// coordinate `i` equals the light's. Within the interval there is none, as `a` lies between.
    fn poles(&self) -> (f64, f64) {
        let (first, last) = (self.x(self.interval.start), self.x(self.interval.end));
        let (mut before, mut after) = (f64::NEG_INFINITY, f64::INFINITY);
        let ray = self.interval.ray;
        for bank in self.interval.medium.banks() {
            let (origin, direction) = bank.in_cube(ray.origin, ray.direction);
            let (light, _) = bank.in_cube(self.light, DVec3::ZERO);
            for axis in 0..3 {
                // A way between the faces crosses neither.
                if light[axis].abs() <= 1.0 {
                    continue;
                }
                let x = self.x((light[axis] - origin[axis]) / direction[axis]);
                if x <= first {
                    before = before.max(x);
                } else if x >= last {
                    after = after.min(x);
                }
            }
        }
        (before, after)
    }

    fn x(&self, t: f64) -> f64 {
        // The library's `asinh` keeps its relative precision near 0, at three times the time; absolute
        // precision suffices.
        let ratio = ((t - self.nearest) / self.gap).clamp(-LARGEST_RATIO, LARGEST_RATIO);
        (ratio.abs() + (ratio * ratio + 1.0).sqrt()).ln().copysign(ratio)
    }

    fn t(&self, x: f64) -> f64 {
        self.nearest + self.gap * x.sinh()
    }

    /// Scattering, transmittance of both ways, the light's share and `1 / cosh x`, which is the inverse
    /// square times `gap dt/dx`. `t` is clamped to the range against rounding.
    fn integrand(&self, x: f64, range: &Range<f64>) -> Rgb {
        let exp = x.exp();
        let (sinh, cosh) = (0.5 * (exp - 1.0 / exp), 0.5 * (exp + 1.0 / exp));
        let t = (self.nearest + self.gap * sinh).clamp(range.start, range.end);
        let place = self.interval.ray.at(t);
        let way = self.light - place;
        let to_light = way / way.length().max(f64::MIN_POSITIVE);
        let share = self.emission.share(-to_light) * self.shape.share_in_fog(place);
        share / cosh * self.interval.scattering(t, -sinh / cosh) * exp_minus(self.interval.tau(t))
    }
}

/// Minimum length of a step, as rounding may put a pole arbitrarily near.
const SHORTEST_STEP: f64 = 1e-6;

/// Number of nodes for a step of a width, with a relative error below 1e-7 (`tests/library/near_light.rs`).
fn order_for(width: f64) -> usize {
    match width {
        w if w < 0.06 => 2,
        w if w < 0.25 => 3,
        w if w < 0.6 => 4,
        w if w < 1.0 => 5,
        w if w < 1.5 => 7,
        _ => 9,
    }
}
