//! Ray marching, the method that this renderer grew from: an image plane moves away from the camera step by
//! step, with a shadow ray from each place. It is the baseline. Invariant: nothing is random, but for one
//! number a ray where steps are jittered.

use super::path::{MarchSteps, Path};
use super::visibility::Way;
use crate::color::Rgb;
use crate::fog::exp_minus;
use crate::math::Ray;
use crate::snapshot::{BlendedHit, FrozenLight, Snapshot};

/// In-scattered radiance of one light by the midpoint rule, or a jittered rule.
pub(super) fn in_scattered(
    path: &mut Path,
    steps: MarchSteps,
    ray: &Ray,
    way: &Way,
    light: &FrozenLight,
) -> Rgb {
    let snapshot = path.snapshot;
    let Some((start, end)) = snapshot.medium.range(ray, way.distance) else { return Rgb::ZERO };
    let (first, step, count) = match steps {
        MarchSteps::Count(count) => {
            let step = (end - start) / f64::from(count);
            (start + 0.5 * step, step, count as usize)
        }
        MarchSteps::Jittered(count) => {
            let step = (end - start) / f64::from(count);
            (start + path.sampler.next_1d() * step, step, count as usize)
        }
        MarchSteps::Planes { depth_m, step_m } => {
            // Mirrored rays do not start at the eye, so their steps are taken along the ray.
            let along_axis = snapshot.view.depth(ray.direction);
            let from_eye = ray.origin.length_squared() == 0.0 && along_axis > 0.0;
            let ray_from_axis = if from_eye { 1.0 / along_axis } else { 1.0 };
            let step = step_m * ray_from_axis;
            let reach = end.min(depth_m * ray_from_axis);
            (0.5 * step, step, (reach / step).ceil() as usize)
        }
    };
    let mut sum = Rgb::ZERO;
    for index in 0..count {
        let t = first + index as f64 * step;
        if t >= end {
            break;
        }
        sum += step * scattered_at(snapshot, ray, t, light, &way.blended);
    }
    sum
}

/// Radiance that fog scatters per metre at `t`, attenuated to the ray's origin, W m^-3 sr^-1.
pub(super) fn scattered_at(
    snapshot: &Snapshot,
    ray: &Ray,
    t: f64,
    light: &FrozenLight,
    blended: &[BlendedHit],
) -> Rgb {
    let point = ray.at(t);
    let (to_light, light_distance, arriving) = light.arriving_in_fog(point);
    let scattering = snapshot.medium.scattering_at(point, to_light.dot(ray.direction));
    if arriving == Rgb::ZERO || scattering == Rgb::ZERO {
        return Rgb::ZERO;
    }
    let visible = snapshot.visibility(&Ray { origin: point, direction: to_light }, light_distance, None);
    if visible == Rgb::ZERO {
        return Rgb::ZERO;
    }
    let seen_through = blended.iter().filter(|hit| hit.t < t);
    let visible = seen_through.fold(visible, |product, hit| product * hit.point.see_through);
    let medium = &snapshot.medium;
    let tau = medium.optical_depth(point, to_light, light_distance)
        + medium.optical_depth(ray.origin, ray.direction, t);
    scattering * arriving * exp_minus(tau) * visible
}
