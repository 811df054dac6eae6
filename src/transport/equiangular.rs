//! Equiangular sampling along the ray, the second baseline. Towards a near light, points are uniform in the
//! angle that the ray subtends at the light. See Kulla & Fajardo 2012, "Importance Sampling Techniques for
//! Path Tracing in Participating Media", eq. 8-10. Towards a distant light, they are distributed as an
//! exponential that falls along the ray. Invariant: unbiased.

use super::march::scattered_at;
use super::path::Path;
use super::visibility::Way;
use crate::color::Rgb;
use crate::math::Ray;
use crate::snapshot::FrozenLight;
use glam::DVec3;

/// In-scattered radiance of one light, estimated from `points` jittered points.
pub(super) fn in_scattered(path: &mut Path, points: u32, ray: &Ray, way: &Way, light: &FrozenLight) -> Rgb {
    let snapshot = path.snapshot;
    let range = snapshot.medium.range(ray, way.distance);
    let jitter = path.sampler.next_1d();
    let Some((start, end)) = range.and_then(|range| lit(light, ray, range)) else { return Rgb::ZERO };
    let mut sum = Rgb::ZERO;
    for index in 0..points {
        let u = (f64::from(index) + jitter) / f64::from(points);
        let (t, pdf_per_m) = match *light {
            FrozenLight::Point { position, .. } => equiangular(ray, position, start, end, u),
            FrozenLight::Sun { .. } => {
                let tau = snapshot.medium.optical_depth(ray.origin, ray.direction, end).element_sum() / 3.0;
                exponential(start, end, tau / (end - start), u)
            }
        };
        sum += scattered_at(snapshot, ray, t, light, &way.blended) / pdf_per_m;
    }
    sum / f64::from(points)
}

/// Samples a distance along the ray, up to `distance`, in a lamp's light; with its density, 1/m.
pub(super) fn sample(path: &mut Path, ray: &Ray, distance: f64, lamp: &FrozenLight) -> Option<(f64, f64)> {
    let u = path.sampler.next_1d();
    let FrozenLight::Point { position, .. } = lamp else { return None };
    let (start, end) = lit(lamp, ray, path.snapshot.medium.range(ray, distance)?)?;
    Some(equiangular(ray, *position, start, end, u))
}

/// Probability density with which [`sample`] samples a distance, 1/m.
pub(super) fn per_m(path: &Path, (ray, distance): (&Ray, f64), lamp: &FrozenLight, t: f64) -> f64 {
    let range = path.snapshot.medium.range(ray, distance);
    match (lamp, range.and_then(|range| lit(lamp, ray, range))) {
        (FrozenLight::Point { position, .. }, Some((start, end))) if start <= t && t <= end => {
            Angle::of(ray, *position).per_m((start, end), t)
        }
        _ => 0.0,
    }
}

/// The part of a range within a spot's cone: a point outside of it would have no light.
fn lit(light: &FrozenLight, ray: &Ray, (start, end): (f64, f64)) -> Option<(f64, f64)> {
    let FrozenLight::Point { position, emission, .. } = light else { return Some((start, end)) };
    let [mut first, mut second] =
        emission.borders(ray, *position).map(|border| border.unwrap_or(start).clamp(start, end));
    if first > second {
        std::mem::swap(&mut first, &mut second);
    }
    let pieces = [(start, first), (first, second), (second, end)];
    let is_lit =
        |&(from, to): &(f64, f64)| from < to && emission.reaches(ray.at(0.5 * (from + to)) - *position);
    pieces.into_iter().filter(is_lit).reduce(|hull, piece| (hull.0, piece.1))
}

fn equiangular(ray: &Ray, light: DVec3, start: f64, end: f64, u: f64) -> (f64, f64) {
    let angle = Angle::of(ray, light);
    let t = angle.sample((start, end), u);
    (t, angle.per_m((start, end), t))
}

/// Angles at a light that the points of a ray subtend.
pub(super) struct Angle {
    /// Distance along the ray to the point nearest to the light, and that point's distance to it, metres.
    nearest: f64,
    gap: f64,
}

impl Angle {
    pub(super) fn of(ray: &Ray, light: DVec3) -> Self {
        let nearest = (light - ray.origin).dot(ray.direction);
        Self { nearest, gap: ray.at(nearest).distance(light).max(f64::MIN_POSITIVE) }
    }

    fn at(&self, t: f64) -> f64 {
        ((t - self.nearest) / self.gap).atan()
    }

    /// Maps a uniform number to a distance within a range, uniform in the angle.
    pub(super) fn sample(&self, (start, end): (f64, f64), u: f64) -> f64 {
        let (from, to) = (self.at(start), self.at(end));
        (self.nearest + self.gap * (from + u * (to - from)).tan()).clamp(start, end)
    }

    /// Probability density of [`Self::sample`], 1/m.
    pub(super) fn per_m(&self, (start, end): (f64, f64), t: f64) -> f64 {
        let offset = t - self.nearest;
        self.gap / ((self.at(end) - self.at(start)) * (self.gap * self.gap + offset * offset))
    }
}

fn exponential(start: f64, end: f64, sigma_per_m: f64, u: f64) -> (f64, f64) {
    let width = end - start;
    let reach = -(-sigma_per_m * width).exp_m1();
    if reach < 1e-9 {
        return (start + u * width, 1.0 / width);
    }
    let offset = -(-u * reach).ln_1p() / sigma_per_m;
    (start + offset, sigma_per_m * (-sigma_per_m * offset).exp() / reach)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::{Cone, Emission, LampShape};

    /// A spot 2 m above a level ray lights 4 m of it with a cone of 45 degrees to either side. A ray that
    /// meets only the cone's mirror image above it, or ends before the cone, has no lit part.
    #[test]
    fn a_spot_is_looked_for_within_its_cone() {
        let cos = 0.5_f64.sqrt();
        let cone = Cone { axis: DVec3::NEG_Y, cos_outer: cos, cos_inner: cos };
        let spot = |height_m: f64| FrozenLight::Point {
            position: DVec3::new(5.0, height_m, 0.0),
            intensity: Rgb::ONE,
            emission: Emission::Spot(cone),
            shape: LampShape::NONE,
        };
        let ray = Ray { origin: DVec3::ZERO, direction: DVec3::X };
        let (from, to) = lit(&spot(2.0), &ray, (0.0, 20.0)).expect("it crosses the cone");
        assert!((from - 3.0).abs() < 1e-9 && (to - 7.0).abs() < 1e-9, "{from} to {to}");
        assert_eq!(lit(&spot(2.0), &ray, (4.0, 6.0)), Some((4.0, 6.0)));
        assert_eq!(lit(&spot(2.0), &ray, (0.0, 2.9)), None);
        assert_eq!(lit(&spot(-2.0), &ray, (0.0, 20.0)), None, "from above");
    }
}
