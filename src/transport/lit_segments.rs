//! The exact method. In go a ray, a light and the fog, out comes the light scattered along the
//! ray: visibility is a union of intervals found from the triangles themselves, and what is left
//! is integrated on smooth pieces. Invariant: nothing is sampled, nothing is stepped.

use crate::accel::LightPlane;
use crate::color::Rgb;
use crate::math::{IntervalSet, Ray, gauss_legendre};
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
                let cos = to_light.dot(ray.direction);
                for stretch in stretches {
                    let line = DepthLine::new(medium, stretch, ray, light.source());
                    let mut through = Rgb::ZERO;
                    self.for_each_within(stretch, |start, end| through += line.integral(start, end));
                    sum += medium.scattering(stretch, cos) * through;
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

/// The optical depth from the eye to `t` and on to a distant light: linear in `t` on a stretch.
struct DepthLine {
    start: f64,
    tau_at_start: Rgb,
    tau_per_m: Rgb,
}

impl DepthLine {
    fn new(medium: &Medium, stretch: &Stretch, ray: &Ray, source: Source) -> Self {
        let width = stretch.end - stretch.start;
        // Just inside, so that a way that starts in a face is measured on this stretch's side.
        let (a, b) = (stretch.start + 1e-3 * width, stretch.end - 1e-3 * width);
        let tau = |t: f64| stretch.tau_to_eye(t) + medium.optical_depth_to(ray.at(t), source);
        let (tau_a, tau_b) = (tau(a), tau(b));
        let tau_per_m = (tau_b - tau_a) / (b - a);
        Self { start: stretch.start, tau_at_start: tau_a - tau_per_m * (a - stretch.start), tau_per_m }
    }

    /// `integral of exp(-tau(t)) dt` over `[start, end]`, metres.
    ///
    /// Written as `width * exp(-tau_min) * (1 - exp(-d)) / d` with `d` the difference of the ends'
    /// depths: nothing cancels, neither in thin fog nor as the ray turns towards the sun (`d -> 0`).
    fn integral(&self, start: f64, end: f64) -> Rgb {
        let width = end - start;
        let one = |at_start: f64, per_m: f64| {
            let (tau_start, change) = (at_start + per_m * (start - self.start), per_m * width);
            let nearest = tau_start + change.min(0.0);
            width * (-nearest).exp() * mean_transmittance(change.abs())
        };
        let (tau, k) = (self.tau_at_start, self.tau_per_m);
        if tau.x == tau.y && tau.y == tau.z && k.x == k.y && k.y == k.z {
            return Rgb::splat(one(tau.x, k.x));
        }
        Rgb::new(one(tau.x, k.x), one(tau.y, k.y), one(tau.z, k.z))
    }
}

/// `(1 - exp(-d)) / d`, the mean of `exp(-x)` over `[0, d]`, for `d >= 0`.
fn mean_transmittance(d: f64) -> f64 {
    if d < 1e-3 {
        // Taylor: the next term is d^4 / 120, below 1e-14.
        return 1.0 - d * (0.5 - d * (1.0 / 6.0 - d / 24.0));
    }
    -(-d).exp_m1() / d
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
        // The phase function turns over about (1 - |g|) radians, the exponential over one optical depth.
        let turns = (to - from) * PIECES_PER_RADIAN / (1.0 - self.medium.sharpest_g(self.stretch));
        let depths = (self.stretch.tau_to_eye(end) - self.stretch.tau_to_eye(start)).max_element();
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
        let tau = self.stretch.tau_to_eye(t) + self.medium.optical_depth_to(point, Source::At(self.light));
        share * self.medium.scattering(self.stretch, to_light.dot(self.ray.direction)) * exp_minus(tau)
    }
}

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
