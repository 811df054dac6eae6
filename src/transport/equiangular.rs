//! Equiangular sampling along the ray, the second baseline. Towards a near light, points are spread evenly
//! over the angle that the ray subtends there. See Kulla & Fajardo 2012, "Importance Sampling Techniques
//! for Path Tracing in Participating Media", eq. 8-10. Towards a distant light, they are spread evenly
//! over the integral of an exponential fall-off. Invariant: unbiased.

use super::march::scattered_at;
use super::path::Path;
use super::visibility::Way;
use crate::color::Rgb;
use crate::math::Ray;
use crate::snapshot::FrozenLight;

/// In-scattered radiance of one light, estimated from `points` jittered points.
pub(super) fn in_scattered(path: &mut Path, points: u32, ray: &Ray, way: &Way, light: &FrozenLight) -> Rgb {
    let snapshot = path.snapshot;
    let Some((start, end)) = snapshot.medium.range(ray, way.distance) else { return Rgb::ZERO };
    let jitter = path.sampler.next_1d();
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

fn equiangular(ray: &Ray, light: glam::DVec3, start: f64, end: f64, u: f64) -> (f64, f64) {
    let nearest = (light - ray.origin).dot(ray.direction);
    let gap = ray.at(nearest).distance(light).max(f64::MIN_POSITIVE);
    let angle = |t: f64| ((t - nearest) / gap).atan();
    let (from, to) = (angle(start), angle(end));
    let offset = gap * (from + u * (to - from)).tan();
    let t = (nearest + offset).clamp(start, end);
    (t, gap / ((to - from) * (gap * gap + offset * offset)))
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
