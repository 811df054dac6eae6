//! Highlights of glossy walls: light of lamps and suns that they reflect near the mirror direction. In go a
//! patch and the light that arrives, out comes radiance along ordinates in excess of a Lambertian wall's.
//! Invariant: the sum over all ordinates is the light that the coat and the base below it reflect.

use crate::accel::PrimitiveId;
use crate::canopy::surface_optics::reflectance;
use crate::color::Rgb;
use crate::math::Ray;
use crate::ordinates::quadrature::Quadrature;
use crate::ordinates::walls::Patch;
use crate::scattering::Gloss;
use crate::snapshot::Snapshot;
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// Light of one lamp or sun that reaches a patch.
#[derive(Clone, Copy)]
pub(super) struct Arriving {
    /// Unit vector towards the light.
    pub(super) to_light: DVec3,
    /// Irradiance on the patch, W/m^2.
    pub(super) irradiance: Rgb,
}

/// Highlights of one patch along each ordinate; none without a coat.
pub(super) fn of_patch(
    snapshot: &Snapshot,
    (patch, primitive): (&Patch, PrimitiveId),
    lights: &[Arriving],
    quadrature: &Quadrature,
) -> Vec<Rgb> {
    let towards = Ray { origin: patch.position + patch.normal - snapshot.view.eye, direction: -patch.normal };
    let point = snapshot.facet(primitive).seen_along(&towards, 1.0);
    let Some(gloss) = point.gloss.filter(|_| !lights.is_empty()) else { return Vec::new() };
    // The texture's mean over the patch, relative to its value at this place.
    let (here, mean) = (reflectance(&point), patch.optics.reflectance);
    let tint = Rgb::select(here.cmpgt(Rgb::ZERO), mean / here, Rgb::ZERO);
    let mut along = vec![Rgb::ZERO; quadrature.as_slice().len()];
    for light in lights {
        let radiances = reflected((&gloss, point.albedo), patch.normal, light.to_light, quadrature);
        for ((sum, radiance), ordinate) in along.iter_mut().zip(radiances).zip(quadrature.iter()) {
            if ordinate.direction.dot(patch.normal) > 0.0 {
                *sum += light.irradiance * (tint * radiance - FRAC_1_PI * mean);
            }
        }
    }
    along
}

/// Radiance along each ordinate that a coat and the Lambertian base below it reflect, for an irradiance of 1.
fn reflected(
    (gloss, albedo): (&Gloss, Rgb),
    normal: DVec3,
    to_light: DVec3,
    quadrature: &Quadrature,
) -> Vec<Rgb> {
    /// Alpha of the narrowest coat that ordinates resolve.
    const LEAST_ALPHA: f64 = 0.35;
    let (wide, cos_light) = (gloss.widened(LEAST_ALPHA), normal.dot(to_light));
    let coat = |direction: DVec3| wide.brdf(normal, direction, to_light);
    let cos = |direction: DVec3| direction.dot(normal).max(0.0);
    let all: Rgb = quadrature.iter().map(|o| o.weight * cos(o.direction) * coat(o.direction)).sum();
    let per_all = Rgb::select(all.cmpgt(Rgb::ZERO), gloss.albedo(cos_light) / all, Rgb::ZERO);
    let along = |direction: DVec3| match cos(direction) {
        0.0 => Rgb::ZERO,
        cos => per_all * coat(direction) + FRAC_1_PI * albedo * gloss.beneath(cos, cos_light),
    };
    quadrature.iter().map(|ordinate| along(ordinate.direction)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Vector flux that leaves a surface.
    fn flux(radiances: impl Iterator<Item = (DVec3, f64, f64)>, normal: DVec3) -> DVec3 {
        radiances
            .map(|(direction, weight, radiance)| {
                weight * direction.dot(normal).max(0.0) * radiance * direction
            })
            .sum()
    }

    /// Vector flux by the BRDF on fine steps.
    fn exact(gloss: &Gloss, normal: DVec3, to_light: DVec3) -> DVec3 {
        const RINGS: usize = 400;
        let (across, up) = normal.any_orthonormal_pair();
        let step = |number: usize| {
            let height = ((number / RINGS) as f64 + 0.5) / RINGS as f64;
            let (sin, cos) = (TAU * (number % RINGS) as f64 / RINGS as f64).sin_cos();
            let direction = (1.0 - height * height).sqrt() * (cos * across + sin * up) + height * normal;
            let radiance = gloss.brdf(normal, direction, to_light).x;
            (direction, TAU / (RINGS * RINGS) as f64, radiance)
        };
        flux((0..RINGS * RINGS).map(step), normal)
    }

    #[test]
    fn highlights_go_where_the_coat_sends_them() {
        let normal = DVec3::new(0.1, 0.9, -0.2).normalize();
        for quadrature in [Quadrature::new(), Quadrature::fine()] {
            // A narrow lobe is widened, and so leans towards the normal.
            for (roughness, to_light, degrees) in [
                (0.2, DVec3::new(1.0, 1.0, 0.3), 15.0),
                (0.6, DVec3::new(0.6, 1.0, -0.7), 6.0),
                (1.0, DVec3::Y, 6.0),
            ] {
                let to_light = to_light.normalize();
                let gloss = Gloss::new(Rgb::splat(0.9), Rgb::ONE, roughness);
                let radiances = reflected((&gloss, Rgb::ZERO), normal, to_light, &quadrature);
                let leaving = || quadrature.iter().zip(&radiances);
                let weighed = leaving().map(|(o, radiance)| (o.direction, o.weight, radiance.x));
                let (found, exact) = (flux(weighed, normal), exact(&gloss, normal, to_light));
                let off = found.normalize().dot(exact.normalize()).acos().to_degrees();
                assert!(off < degrees, "{roughness}: {off} degrees");
                let all: f64 =
                    leaving().map(|(o, r)| o.weight * o.direction.dot(normal).max(0.0) * r.x).sum();
                assert!(
                    (all / gloss.albedo(normal.dot(to_light)).x - 1.0).abs() < 1e-12,
                    "{roughness}: {all}"
                );
            }
        }
    }
}
