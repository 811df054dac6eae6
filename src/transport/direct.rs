//! Direct light on a surface. In goes a surface point, out comes the radiance that it scatters towards the
//! eye. Invariant: the geometric normal decides on which side of the surface the light and the eye are, never
//! the shading normal.

use crate::color::Rgb;
use crate::math::Ray;
use crate::scattering::bump_shadow;
use crate::snapshot::{FrozenLight, Snapshot, SurfacePoint};
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// Radiance of all lights that a surface scatters towards the eye, W m^-2 sr^-1: `f / pi * sum(cos *
/// irradiance * visibility * transmittance)`. `f` is the albedo for lights before the surface, the
/// transmission for those behind it. The part that `lamps_seen::images` computes is left out.
pub(super) fn scattered(snapshot: &Snapshot, lights: &[FrozenLight], point: &SurfacePoint) -> Rgb {
    let beside_images = |light| {
        lit(snapshot, point, Unshadowed::beside_images(light, point), |shadow_ray, distance| {
            snapshot.visibility(shadow_ray, distance, Some(point.primitive))
        })
    };
    lights.iter().map(beside_images).sum()
}

/// Radiance of one light that a surface scatters towards the eye, W m^-2 sr^-1.
pub(super) fn of_light(snapshot: &Snapshot, light: &FrozenLight, point: &SurfacePoint) -> Rgb {
    lit(snapshot, point, Unshadowed::new(light, point), |shadow_ray, distance| {
        snapshot.visibility(shadow_ray, distance, Some(point.primitive))
    })
}

/// Radiance of one light as in [`scattered`], where the transmittance of blended surfaces is known.
pub(super) fn scattered_past_blended(
    snapshot: &Snapshot,
    light: &FrozenLight,
    point: &SurfacePoint,
    let_through: Rgb,
) -> Rgb {
    lit(snapshot, point, Unshadowed::beside_images(light, point), |shadow_ray, distance| {
        let is_hidden = snapshot.casting().any_hit(shadow_ray, distance, Some(point.primitive));
        if is_hidden { Rgb::ZERO } else { let_through }
    })
}

fn lit(
    snapshot: &Snapshot,
    point: &SurfacePoint,
    unshadowed: Option<Unshadowed>,
    visible: impl Fn(&Ray, f64) -> Rgb,
) -> Rgb {
    let Some(unshadowed) = unshadowed else { return Rgb::ZERO };
    let Unshadowed { radiance, to_light, distance } = unshadowed;
    let visible = visible(&Ray { origin: point.position, direction: to_light }, distance);
    if visible == Rgb::ZERO {
        return Rgb::ZERO;
    }
    radiance * visible * snapshot.medium.transmittance(point.position, to_light, distance)
}

/// Radiance of all lights that a surface scatters if nothing occludes them, W m^-2 sr^-1.
pub fn unshadowed(lights: &[FrozenLight], point: &SurfacePoint) -> Rgb {
    lights.iter().filter_map(|light| Unshadowed::new(light, point)).map(|light| light.radiance).sum()
}

/// Light of one source that a surface scatters towards the eye if nothing occludes it.
pub(super) struct Unshadowed {
    /// W m^-2 sr^-1.
    pub(super) radiance: Rgb,
    /// Unit vector.
    pub(super) to_light: DVec3,
    /// Metres.
    pub(super) distance: f64,
}

impl Unshadowed {
    /// `None` if the radiance is zero.
    #[inline]
    pub(super) fn new(light: &FrozenLight, point: &SurfacePoint) -> Option<Self> {
        let (to_light, distance, arriving) = light.arriving_at(point.position);
        let radiance = arriving * scattered_per_radiance(point, to_light);
        (radiance != Rgb::ZERO).then_some(Self { radiance, to_light, distance })
    }

    /// As [`Self::new`], without the specular reflection of surfaces that show the light as an image.
    #[inline]
    pub(super) fn beside_images(light: &FrozenLight, point: &SurfacePoint) -> Option<Self> {
        if !is_image(light, point) {
            return Self::new(light, point);
        }
        let (to_light, distance, arriving) = light.arriving_at(point.position);
        let [all, shine] =
            [point, &specular_part(point)].map(|point| scattered_per_radiance(point, to_light));
        Some(Self { radiance: arriving * (all - shine).max(Rgb::ZERO), to_light, distance })
    }
}

/// Alpha of the narrowest lobe of a surface.
pub(super) fn narrowest(point: &SurfacePoint) -> Option<f64> {
    let coat = point.layers.as_ref().and_then(|layers| layers.clearcoat.as_ref()).map(|coat| &coat.gloss);
    point.gloss.iter().chain(coat).map(|gloss| gloss.alpha()).reduce(f64::min)
}

/// Whether a surface shows a light as an image.
fn is_image(light: &FrozenLight, point: &SurfacePoint) -> bool {
    let FrozenLight::Point { shape, .. } = light else { return false };
    shape.shown_m2 > 0.0 && narrowest(point).is_some_and(|alpha| shape.shows_in(alpha, point.position))
}

/// The surface with its specular lobes alone.
pub(super) fn specular_part(point: &SurfacePoint) -> SurfacePoint {
    SurfacePoint { albedo: Rgb::ZERO, transmission: Rgb::ZERO, mirror: Rgb::ZERO, ..*point }
}

/// BSDF times cosine from a direction towards the eye, 1/sr, all layers included.
#[inline]
pub(super) fn scattered_per_radiance(point: &SurfacePoint, to_light: DVec3) -> Rgb {
    let beneath = beneath_layers(point, to_light);
    let Some(layers) = &point.layers else { return beneath };
    let is_before = point.geometric_normal.dot(to_light) > 0.0;
    layers.over(beneath, point.shading_normal, point.to_eye, to_light, is_before)
}

/// BSDF times cosine of the base below the layers, 1/sr.
#[inline]
fn beneath_layers(point: &SurfacePoint, to_light: DVec3) -> Rgb {
    let is_before = point.geometric_normal.dot(to_light) > 0.0;
    let (side, lambert) = if is_before { (1.0, point.albedo) } else { (-1.0, point.transmission) };
    let (normal, specular_normal) = (point.shading_normal, point.specular_normal);
    // Light on different sides of the normal and of the triangle is lost.
    let [cos, cos_shine] = [normal, specular_normal].map(|normal| (side * normal.dot(to_light)).max(0.0));
    if cos == 0.0 && cos_shine == 0.0 {
        return Rgb::ZERO;
    }
    let not_shaded = point.unbent_normal.map_or(1.0, |unbent| bump_shadow(unbent, normal, to_light));
    let mut scattered = FRAC_1_PI * cos * not_shaded * lambert;
    if let Some(gloss) = &point.gloss {
        // Seen from behind, as interpolated normals may be at a silhouette, there is no specular reflection.
        let cos_eye = specular_normal.dot(point.to_eye).max(0.0);
        scattered *= gloss.beneath(cos_eye, cos);
        if is_before {
            scattered += cos_shine * gloss.brdf(specular_normal, point.to_eye, to_light);
        }
    }
    if let Some(dielectric) = &point.dielectric {
        scattered += cos_shine * dielectric.bsdf(specular_normal, point.to_eye, to_light);
    }
    scattered
}
