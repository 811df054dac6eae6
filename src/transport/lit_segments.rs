//! The exact method. In go a ray, a light and the fog, out comes the light scattered along the
//! ray: visibility is a union of intervals found from the triangles themselves, and what is left
//! is integrated on smooth pieces. Invariant: nothing is sampled, nothing is stepped.

use super::sun_stretch::SunStretch;
use crate::accel::LightPlane;
use crate::color::Rgb;
use crate::math::{Antiderivative, IntervalSet, Ray, gauss_legendre};
use crate::scattering::{Medium, Source, Stretch, exp_minus};
use crate::snapshot::{Emission, FrozenLight, Snapshot};
use glam::DVec3;

/// The parts of a ray that one light reaches.
#[derive(Clone, Debug, Default)]
pub struct LitSegments {
    shadows: IntervalSet,
    range: (f64, f64),
}

impl LitSegments {
    /// What `shadows` leave of `range`.
    pub fn from_shadows(shadows: IntervalSet, range: (f64, f64)) -> Self {
        Self { shadows, range }
    }

    /// Takes what the scene's `shadows` leave, where they are known already.
    pub(super) fn set(
        &mut self,
        ray: &Ray,
        light: &FrozenLight,
        range: (f64, f64),
        shadows: impl Iterator<Item = (f64, f64)>,
    ) {
        self.start(ray, light, range);
        for (start, end) in shadows {
            self.shadows.insert(start, end);
        }
    }

    /// Everything is lit, but for where the light does not shine.
    fn start(&mut self, ray: &Ray, light: &FrozenLight, range: (f64, f64)) {
        self.shadows.clear();
        self.range = range;
        if let FrozenLight::Point { position, emission, .. } = light {
            self.shade_outside(emission, ray, *position);
        }
    }

    /// Finds what `light` reaches of `ray` within `range`, which must not reach beyond the first surface.
    pub fn find(&mut self, snapshot: &Snapshot, ray: &Ray, light: &FrozenLight, range: (f64, f64)) {
        self.start(ray, light, range);
        let plane = match *light {
            FrozenLight::Sun { to_light, .. } => LightPlane::towards_direction(ray, to_light, range),
            FrozenLight::Point { position, .. } => LightPlane::towards_point(ray, position, range),
        };
        match plane {
            Some(plane) => snapshot.tree.add_shadows(&plane, &mut self.shadows),
            None => {
                if is_blocked_in_line(snapshot, ray, light, range) {
                    self.shadows.insert(range.0, range.1);
                }
            }
        }
    }

    /// Calls `lit(start, end)` for each lit part, in order.
    pub fn for_each(&self, lit: impl FnMut(f64, f64)) {
        self.shadows.for_each_gap(self.range.0, self.range.1, lit);
    }

    /// Total length of the lit parts, metres.
    pub fn length(&self) -> f64 {
        let mut length = 0.0;
        self.for_each(|start, end| length += end - start);
        length
    }

    /// Radiance scattered into the ray from its lit parts, W m^-2 sr^-1.
    pub fn integrate(&self, medium: &Medium, stretches: &[Stretch], ray: &Ray, light: &FrozenLight) -> Rgb {
        let mut sum = Rgb::ZERO;
        match *light {
            FrozenLight::Sun { to_light, irradiance } => {
                for stretch in stretches {
                    let mut sunny = None;
                    self.for_each_within(stretch, |start, end| {
                        let sunny =
                            sunny.get_or_insert_with(|| SunStretch::new(medium, stretch, ray, to_light));
                        sum += sunny.integral(start, end);
                    });
                }
                sum * irradiance
            }
            FrozenLight::Point { position, intensity, emission } => {
                for stretch in stretches {
                    let near = NearLight::new(medium, stretch, ray, position, emission);
                    self.for_each_within(stretch, |start, end| sum += near.integral(start, end));
                }
                sum * intensity
            }
        }
    }

    fn for_each_within(&self, stretch: &Stretch, lit: impl FnMut(f64, f64)) {
        let (start, end) = (stretch.start.max(self.range.0), stretch.end.min(self.range.1));
        self.shadows.for_each_gap(start, end, lit);
    }

    /// What lies outside a spot's cone, or behind a flat light, counts as shadow.
    fn shade_outside(&mut self, emission: &Emission, ray: &Ray, position: DVec3) {
        let borders = emission.borders(ray, position);
        let mut start = self.range.0;
        for end in borders.into_iter().flatten().chain([self.range.1]) {
            let end = end.clamp(start, self.range.1);
            if !emission.reaches(ray.at(0.5 * (start + end)) - position) {
                self.shadows.insert(start, end);
            }
            start = end;
        }
    }
}

/// Ray and light in one line: the whole range is lit or dark.
fn is_blocked_in_line(snapshot: &Snapshot, ray: &Ray, light: &FrozenLight, range: (f64, f64)) -> bool {
    // The middle of the range sees the light along the ray itself, forwards or backwards. Between
    // the ray's origin and the end of the range there is nothing, so one ray from there will do.
    let origin = ray.at(0.5 * (range.0 + range.1));
    let (to_light, distance, _) = light.arriving_at(origin);
    snapshot.tree.any_hit(&Ray { origin, direction: to_light }, distance, None)
}

/// What a near light scatters into a ray, in the equiangular variable
/// `theta = atan((t - nearest) / gap)`, in which the inverse square is constant:
/// `dt / distance^2 = dtheta / gap`.
struct NearLight<'a> {
    medium: &'a Medium,
    stretch: &'a Stretch,
    ray: &'a Ray,
    light: DVec3,
    emission: Emission,
    kinks: [Option<f64>; 2],
    nearest: f64,
    gap: f64,
}

/// A light this near to the ray, as a fraction of its distance, counts as this far from it: the
/// integral grows beyond all bounds as the gap closes, and no picture shows that.
const SMALLEST_RELATIVE_GAP: f64 = 1e-7;

impl<'a> NearLight<'a> {
    fn new(medium: &'a Medium, stretch: &'a Stretch, ray: &'a Ray, light: DVec3, emission: Emission) -> Self {
        let to_light = light - ray.origin;
        let nearest = to_light.dot(ray.direction);
        let gap = ray.direction.cross(to_light).length();
        let gap = gap.max(SMALLEST_RELATIVE_GAP * to_light.length()).max(f64::MIN_POSITIVE);
        let kinks = emission.kinks(ray, light);
        Self { medium, stretch, ray, light, emission, kinks, nearest, gap }
    }

    /// Over a lit interval, per unit of intensity, 1/(m^2 sr).
    fn integral(&self, start: f64, end: f64) -> Rgb {
        // The falloff's slope jumps at the inner cone.
        let mut sum = Rgb::ZERO;
        let mut from = start;
        for cut in self.kinks.iter().flatten() {
            if *cut > from && *cut < end {
                sum += self.smooth_integral(from, *cut);
                from = *cut;
            }
        }
        sum + self.smooth_integral(from, end)
    }

    fn smooth_integral(&self, start: f64, end: f64) -> Rgb {
        let angle = |t: f64| ((t - self.nearest) / self.gap).atan();
        let (from, to) = (angle(start), angle(end));
        if self.medium.thins_out(self.stretch) {
            // Density may change by any factor on the way: how finely to cut is found from the integrand.
            let mut fitted = Antiderivative::default();
            let integrand = |theta: f64| {
                let t = self.nearest + self.gap * theta.tan();
                self.integrand(t.clamp(start, end))
            };
            fitted.fit(integrand, from, to, FIT_TOLERANCE);
            return fitted.between(from, to) / self.gap;
        }
        // The phase function turns over about (1 - |g|) radians, the exponential over one optical depth.
        let turns = (to - from) * PIECES_PER_RADIAN / (1.0 - self.medium.sharpest_g(self.stretch));
        let tau = |t: f64| self.medium.tau_to_eye(self.stretch, self.ray, t);
        let depths = (tau(end) - tau(start)).max_element();
        let pieces = turns.max(depths).ceil().clamp(1.0, MAX_PIECES);
        let half_width = 0.5 * (to - from) / pieces;
        let rule = gauss_legendre(order_for(2.0 * half_width));
        let mut sum = Rgb::ZERO;
        for piece in 0..pieces as usize {
            let middle = from + (2 * piece + 1) as f64 * half_width;
            for (node, weight) in rule {
                let t = self.nearest + self.gap * (middle + node * half_width).tan();
                sum += *weight * self.integrand(t.clamp(start, end));
            }
        }
        sum * half_width / self.gap
    }

    /// Scattering, transmittance both ways and the light's share, without the inverse square.
    fn integrand(&self, t: f64) -> Rgb {
        let point = self.ray.at(t);
        let way = self.light - point;
        let to_light = way / way.length().max(f64::MIN_POSITIVE);
        let share = self.emission.share(-to_light);
        let to_eye = self.medium.tau_to_eye(self.stretch, self.ray, t);
        let tau = to_eye + self.medium.optical_depth_to(point, Source::At(self.light));
        let cos = to_light.dot(self.ray.direction);
        share * self.medium.scattering(self.stretch, self.ray, t, cos) * exp_minus(tau)
    }
}

/// What a fit may be wrong by, as a share of itself.
const FIT_TOLERANCE: f64 = 1e-9;

/// How finely a lit interval is cut before the rule is applied; with `order_for` it keeps the
/// relative error below 1e-6 (`tests/airlight.rs`, against a dense quadrature).
const PIECES_PER_RADIAN: f64 = 0.5;

/// A bound on the work for one interval: at |g| = 0.999 pieces are 0.006 rad wide.
const MAX_PIECES: f64 = 512.0;

/// Gauss-Legendre nodes for an interval of `width` radians.
fn order_for(width: f64) -> usize {
    match width {
        w if w < 0.02 => 2,
        w if w < 0.1 => 3,
        w if w < 0.25 => 4,
        w if w < 0.5 => 6,
        w if w < 1.0 => 8,
        _ => 14,
    }
}
