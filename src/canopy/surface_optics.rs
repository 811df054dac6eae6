//! Optical properties of a snapshot's surfaces. In go points of surfaces, out come shares of light.
//! Invariant: specular reflection counts as Lambertian, and no share is above 1.

use crate::accel::PrimitiveId;
use crate::color::Rgb;
use crate::math::Ray;
use crate::ordinates::surface_optics::SurfaceOptics;
use crate::snapshot::{Snapshot, SurfacePoint};
use glam::DVec3;

/// Minimum coverage where alpha is 1: a clear surface may emit.
const LEAST_COVER: f64 = 1e-3;

/// Cosine typical of the directions of light and view.
const COS: f64 = 0.6;

/// Optics of the side that `normal` faces, at a place in world space.
pub(crate) fn optics_at(
    snapshot: &Snapshot,
    primitive: PrimitiveId,
    position: DVec3,
    normal: DVec3,
) -> SurfaceOptics {
    let towards = Ray { origin: position + normal - snapshot.view.eye, direction: -normal };
    optics_of(&snapshot.facet(primitive).seen_along(&towards, 1.0))
}

/// Optics of a point. Light that its filter lets pass in all channels meets nothing.
pub(crate) fn optics_of(point: &SurfacePoint) -> SurfaceOptics {
    let cover = cover_of(point);
    if cover == 0.0 {
        return SurfaceOptics::default();
    }
    let share = point.alpha / cover;
    SurfaceOptics {
        reflectance: share * reflectance(point),
        transmittance: share * transmittance(point),
        emission: share * point.emission,
        straight: (passing(point) + (cover - 1.0)) / cover,
        cover,
    }
}

/// Coverage at a point.
pub(crate) fn cover_of(point: &SurfacePoint) -> f64 {
    (1.0 - passing(point).min_element()).clamp(LEAST_COVER * point.alpha, 1.0)
}

/// Share of light that passes straight through: no more than what is not scattered, as a pane of clear glass
/// reflects some of it.
fn passing(point: &SurfacePoint) -> Rgb {
    let scattered = point.alpha * (reflectance(point) + transmittance(point));
    point.see_through.min((Rgb::ONE - scattered).max(Rgb::ZERO))
}

/// Reflectance of all lobes together: specular reflection counts as Lambertian.
pub(crate) fn reflectance(point: &SurfacePoint) -> Rgb {
    let gloss = point.gloss.as_ref();
    let coat = gloss.map_or(Rgb::ZERO, |gloss| gloss.albedo(COS));
    let beneath = point.albedo * gloss.map_or(Rgb::ONE, |gloss| gloss.leaves(COS));
    (beneath + coat + point.mirror + of_dielectric(point)[0]).clamp(Rgb::ZERO, Rgb::ONE)
}

fn transmittance(point: &SurfacePoint) -> Rgb {
    point.transmission + of_dielectric(point)[1]
}

/// Reflectance and transmittance of a dielectric.
fn of_dielectric(point: &SurfacePoint) -> [Rgb; 2] {
    point.dielectric.as_ref().map_or([Rgb::ZERO; 2], |own| own.albedos(COS))
}
