//! The exact method. In go a ray, a light and the fog, out comes the light scattered along the
//! ray: visibility is a union of intervals found from the triangles themselves, and what is left
//! is integrated on smooth pieces. Invariant: nothing is sampled, nothing is stepped.

use super::sun_stretch::SunStretch;
use super::veils::Veils;
use super::visibility::Layer;
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
    /// What dims the rest of it.
    veils: Veils,
}

impl LitSegments {
    /// What `shadows` leave of `range`.
    pub fn from_shadows(shadows: IntervalSet, range: (f64, f64)) -> Self {
        Self { shadows, range, veils: Veils::default() }
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
        self.veils.clear();
        self.range = range;
        if let FrozenLight::Point { position, emission, .. } = light {
            self.shade_outside(emission, ray, *position);
        }
    }

    /// Finds what `light` reaches of `ray` within `range`, which must not reach beyond the first surface.
    pub fn find(&mut self, snapshot: &Snapshot, ray: &Ray, light: &FrozenLight, range: (f64, f64)) {
        self.find_through(snapshot, ray, light, range, &[]);
    }

    /// The same of a ray that is seen through `layers`.
    pub(super) fn find_through(
        &mut self,
        snapshot: &Snapshot,
        ray: &Ray,
        light: &FrozenLight,
        range: (f64, f64),
        layers: &[Layer],
    ) {
        self.start(ray, light, range);
        let plane = match *light {
            FrozenLight::Sun { to_light, .. } => LightPlane::towards_direction(ray, to_light, range),
            FrozenLight::Point { position, .. } => LightPlane::towards_point(ray, position, range),
        };
        if snapshot.has_blended() {
            self.veils.find(snapshot, ray, light, plane.as_ref(), range, layers);
        }
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
                    self.for_each_within(stretch, |start, end, share| {
                        let sunny =
                            sunny.get_or_insert_with(|| SunStretch::new(medium, stretch, ray, to_light));
                        sum += share * sunny.integral(start, end);
                    });
                }
                sum * irradiance
            }
            FrozenLight::Point { position, intensity, emission } => {
                for stretch in stretches {
                    let near = NearLight::new(medium, stretch, ray, position, emission);
                    self.for_each_within(stretch, |start, end, share| {
                        sum += share * near.integral(start, end)
                    });
                }
                sum * intensity
            }
        }
    }

    /// Lit parts of a stretch, with the share of the light that is left there.
    fn for_each_within(&self, stretch: &Stretch, mut lit: impl FnMut(f64, f64, Rgb)) {
        let (start, end) = (stretch.start.max(self.range.0), stretch.end.min(self.range.1));
        self.shadows.for_each_gap(start, end, |start, end| self.veils.for_each_piece(start, end, &mut lit));
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
    /// How fast the optical depths to eye and light change, both together.
    depths_per_m: f64,
    is_soft: bool,
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
        let is_soft = matches!(emission, Emission::Spot(_));
        let tau = |t: f64| medium.tau_to_eye(stretch, ray, t);
        let to_eye = tau(stretch.end) - tau(stretch.start);
        let to_light = |t: f64| medium.optical_depth_to(ray.at(t), Source::At(light));
        let middle = to_light(0.5 * (stretch.start + stretch.end));
        let change = |t: f64| (to_light(t) - middle).abs().max_element();
        let depths = to_eye.max_element() + change(stretch.start) + change(stretch.end);
        let depths_per_m = depths / (stretch.end - stretch.start);
        Self { medium, stretch, ray, light, emission, kinks, nearest, gap, depths_per_m, is_soft }
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
        if !self.medium.is_even() {
            // Such fog may reach far, and change by any factor on the way: how finely to cut is found from the
            // integrand.
            let angle = |t: f64| ((t - self.nearest) / self.gap).atan();
            let (from, to) = (angle(start), angle(end));
            let mut fitted = Antiderivative::default();
            let integrand = |theta: f64| {
                let t = self.nearest + self.gap * theta.tan();
                self.integrand(t.clamp(start, end))
            };
            fitted.fit(integrand, from, to, FIT_TOLERANCE);
            return fitted.between(from, to) / self.gap;
        }
        let before = self.one_sided_integral(-1.0, self.nearest - end, self.nearest - start);
        before + self.one_sided_integral(1.0, start - self.nearest, end - self.nearest)
    }

    /// Over the part that lies before (`side` -1) or behind (1) the nearest point, between two distances from it.
    ///
    /// In `psi = atan(gap / distance)` both the transmittance and the phase function are smooth on the
    /// scale of psi itself, so pieces shrink with it.
    fn one_sided_integral(&self, side: f64, from: f64, to: f64) -> Rgb {
        let mut from = from.max(0.0);
        let mut sum = Rgb::ZERO;
        let longest = (1.0 / self.depths_per_m).max((to - from) / MAX_PIECES);
        while from < to {
            let psi = |distance: f64| self.gap.atan2(distance);
            let near = psi(from);
            let mut reach = to.min(from + longest);
            if reach <= from {
                reach = to;
            }
            let mut far = psi(reach);
            if far < SHRINKAGE * near {
                far = SHRINKAGE * near;
                reach = self.gap / far.tan();
            }
            let (middle, half_width) = (0.5 * (near + far), 0.5 * (near - far));
            // Optical depth per radian at the far end, where it is largest.
            let depths = self.depths_per_m * (self.gap * self.gap + reach * reach) / self.gap;
            let steepness = half_width * (1.0 / middle).max(0.25 * depths);
            // A spot's soft edge is a cubic of a cosine, however short the piece.
            let steepness = if self.is_soft { steepness.max(0.5) } else { steepness };
            for (node, weight) in gauss_legendre(order_for(steepness)) {
                let distance = (self.gap / (middle + node * half_width).tan()).clamp(from, reach);
                sum += weight * half_width * self.integrand(self.nearest + side * distance);
            }
            from = reach;
        }
        sum / self.gap
    }

    /// Scattering, transmittance both ways and the light's share, without the inverse square.
    fn integrand(&self, t: f64) -> Rgb {
        let point = self.ray.at(t);
        let way = self.light - point;
        let to_light = way / way.length().max(f64::MIN_POSITIVE);
        let share = self.emission.share(-to_light);
        let to_eye = self.medium.tau_to_eye(self.stretch, self.ray, t);
        let tau = to_eye + self.medium.optical_depth_to(point, Source::At(self.light));
        let ahead = self.nearest - t;
        let cos = ahead / ahead.hypot(self.gap);
        share * self.medium.scattering(self.stretch, self.ray, t, cos) * exp_minus(tau)
    }
}

/// What a fit may be wrong by, as a share of itself.
const FIT_TOLERANCE: f64 = 1e-9;

/// How far the angle may shrink over a piece, as a factor: an ellipse around the piece that keeps out of
/// the essential singularity at 0 then has the parameter 2.6, and 10 nodes do.
const SHRINKAGE: f64 = 0.2;

/// A bound on the work for one interval.
const MAX_PIECES: f64 = 4096.0;

/// Gauss-Legendre nodes for a relative error of 1e-8, where the nearest singularity lies `1 / steepness`
/// half widths from the middle: the error falls with the power `-2 n` of the ellipse's parameter
/// `1 / s + sqrt(1 / s^2 - 1)` (Trefethen, Approximation Theory and Approximation Practice, theorem 19.3).
fn order_for(steepness: f64) -> usize {
    match steepness {
        s if s < 0.02 => 2,
        s if s < 0.09 => 3,
        s if s < 0.2 => 4,
        s if s < 0.4 => 6,
        s if s < 0.57 => 8,
        s if s < 0.69 => 10,
        _ => 14,
    }
}
