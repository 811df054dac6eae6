//! Light of the sky, scattered once by surfaces and by fog. In go a ray or a surface point and uniform
//! numbers, out comes an estimate of the radiance. Invariant: unbiased, with one shadow ray each.
//!
//! Directions are sampled either by the BSDF or phase function, or by the sky's radiance. They are weighted
//! by the mean of both densities: the balance heuristic with one sample. See Veach and Guibas 1995,
//! "Optimally combining sampling techniques for Monte Carlo rendering", section 3.3.

use super::direct::scattered_per_radiance;
use super::lobes::{Lobes, about};
use super::path::{Path, Start};
use super::visibility::Way;
use crate::color::Rgb;
use crate::fog::{FoggyRay, exp_minus, henyey_greenstein_pdf, sample_henyey_greenstein};
use crate::math::Ray;
use crate::snapshot::{FrozenSky, SurfacePoint};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Share of directions that are sampled by the sky's radiance, where it is not uniform.
const SHARE_OF_SKY: f64 = 0.5;

/// Radiance of the sky that a surface scatters towards the eye, W m^-2 sr^-1; 0 if indirect light includes
/// it.
pub(super) fn scattered(path: &mut Path, point: &SurfacePoint) -> Rgb {
    if path.samples_sky() { by_surface(path, point) } else { Rgb::ZERO }
}

/// Radiance of the sky that a surface scatters towards the eye, W m^-2 sr^-1; 0 unless the path follows light
/// of the sky.
pub(super) fn by_surface(path: &mut Path, point: &SurfacePoint) -> Rgb {
    if path.light.sky { from_sky(path, point) } else { Rgb::ZERO }
}

/// Radiance of the sky that a surface scatters towards the eye, W m^-2 sr^-1, for any illumination.
pub(super) fn from_sky(path: &mut Path, point: &SurfacePoint) -> Rgb {
    let snapshot = path.snapshot;
    let sky = snapshot.sky.as_ref().filter(|sky| sky.lights_surfaces());
    let Some(sky) = sky else { return Rgb::ZERO };
    let Some(lobes) = Lobes::of(point) else { return Rgb::ZERO };
    let u = DVec2::from(path.sampler.next_2d());
    let (to_sky, density) =
        sample_sky_or_matter(sky, u, |u| lobes.sample(point, u), |direction| lobes.pdf(point, direction));
    let scattered = scattered_per_radiance(point, to_sky) * sky.along_beside_suns(to_sky);
    if scattered == Rgb::ZERO || density <= 0.0 {
        return Rgb::ZERO;
    }
    let shadow_ray = Ray { origin: point.position, direction: to_sky };
    let visible = snapshot.visibility(&shadow_ray, f64::INFINITY, Some(point.primitive));
    if visible == Rgb::ZERO {
        return Rgb::ZERO;
    }
    let fog = exp_minus(path.depth_to_sky(&shadow_ray));
    scattered * visible * fog / density
}

/// Radiance of the sky that fog scatters into the ray on its way, W m^-2 sr^-1; 0 if indirect light includes
/// it.
pub(super) fn in_scattered(path: &mut Path, (ray, from): (&Ray, Start), way: &Way) -> Rgb {
    if path.samples_sky() { on_the_way(path, (ray, from), way) } else { Rgb::ZERO }
}

/// Radiance of the sky that fog scatters into the ray on its way, W m^-2 sr^-1; 0 unless the path follows
/// light of the sky.
pub(super) fn on_the_way(path: &mut Path, (ray, from): (&Ray, Start), way: &Way) -> Rgb {
    let medium = &path.snapshot.medium;
    let Some(sky) = above_fog(path) else { return Rgb::ZERO };
    let Some(range) = medium.range(ray, way.distance) else { return Rgb::ZERO };
    let [along, u, v] = path.sampler.next_3d();
    let sampled = match path.seen_fog(ray, from) {
        Some(seen) => {
            seen.place_by_depth(range, along).map(|sampled| (sampled, seen.optical_depth(sampled.0)))
        }
        None => {
            let fog = medium.along(ray, range.1);
            place_by_depth(&fog, range, along).map(|sampled| (sampled, fog.optical_depth(sampled.0)))
        }
    };
    let Some(((t, density_per_m), depth)) = sampled else { return Rgb::ZERO };
    let point = ray.at(t);
    let Some(found) = FromSky::sample(path, sky, point, ray.direction, DVec2::new(u, v)) else {
        return Rgb::ZERO;
    };
    let seen_through = way.blended.iter().filter(|hit| hit.t < t);
    let visible = seen_through.fold(found.visible, |product, hit| product * hit.point.see_through);
    found.scattered * exp_minus(found.depth + depth) * visible / (found.density * density_per_m)
}

/// Radiance of the sky that fog at a point scatters towards the eye, per metre, W m^-3 sr^-1. `from_eye` is
/// the direction of travel from the eye.
pub(super) fn by_fog(path: &mut Path, point: DVec3, from_eye: DVec3) -> Rgb {
    let Some(sky) = above_fog(path) else { return Rgb::ZERO };
    let u = DVec2::from(path.sampler.next_2d());
    let found = FromSky::sample(path, sky, point, from_eye, u);
    found.map_or(Rgb::ZERO, |found| found.scattered * exp_minus(found.depth) * found.visible / found.density)
}

/// The sky, if it lights fog and the path follows its light.
fn above_fog<'a>(path: &Path<'a>) -> Option<&'a FrozenSky<'a>> {
    path.snapshot.sky.as_ref().filter(|sky| path.light.sky && sky.lights_fog())
}

/// Light from one direction of the sky, at a point in fog.
struct FromSky {
    /// Per metre without attenuation, W m^-3 sr^-1.
    scattered: Rgb,
    visible: Rgb,
    /// Optical depth of fog towards the sky.
    depth: Rgb,
    /// Probability density of the direction, 1/sr.
    density: f64,
}

impl FromSky {
    /// `None` if nothing arrives.
    fn sample(path: &Path, sky: &FrozenSky, point: DVec3, from_eye: DVec3, u: DVec2) -> Option<Self> {
        let (snapshot, medium) = (path.snapshot, &path.snapshot.medium);
        let g = medium.anisotropy_at(point);
        let (to_sky, density) = sample_sky_or_matter(
            sky,
            u,
            |u| {
                let (cos, _) = sample_henyey_greenstein(g, u.x);
                about(from_eye, DVec2::from_angle(TAU * u.y) * (1.0 - cos * cos).max(0.0).sqrt(), cos)
            },
            |direction| henyey_greenstein_pdf(g, direction.dot(from_eye)),
        );
        let scattered = medium.scattering_at(point, to_sky.dot(from_eye)) * sky.along_beside_suns(to_sky);
        if scattered == Rgb::ZERO {
            return None;
        }
        let shadow_ray = Ray { origin: point, direction: to_sky };
        let visible = snapshot.visibility(&shadow_ray, f64::INFINITY, None);
        let depth = path.depth_to_sky(&shadow_ray);
        (visible != Rgb::ZERO).then_some(Self { scattered, visible, depth, density })
    }
}

/// Samples a direction by the sky's radiance or by the matter's scattering. Returns its density, too, 1/sr.
fn sample_sky_or_matter(
    sky: &FrozenSky,
    mut u: DVec2,
    sample: impl Fn(DVec2) -> DVec3,
    pdf: impl Fn(DVec3) -> f64,
) -> (DVec3, f64) {
    if !sky.is_uneven() {
        let direction = sample(u);
        return (direction, pdf(direction));
    }
    // The remainder of a number that decided is uniform again.
    let by_sky = u.x < SHARE_OF_SKY;
    u.x = if by_sky { u.x / SHARE_OF_SKY } else { (u.x - SHARE_OF_SKY) / (1.0 - SHARE_OF_SKY) };
    let direction = if by_sky { sky.sample(u) } else { None }.unwrap_or_else(|| sample(u));
    let of_sky = sky.pdf(direction);
    (direction, pdf(direction) + SHARE_OF_SKY * (of_sky - pdf(direction)))
}

/// Distance within `range` at which a given share of its loss is reached, and the density there per metre:
/// proportional to the extinction of light from the eye. `None` where nothing is lost.
fn place_by_depth(fog: &FoggyRay, range: (f64, f64), u: f64) -> Option<(f64, f64)> {
    let mean = |depth: Rgb| depth.element_sum() / 3.0;
    let depth_to = |t: f64| mean(fog.optical_depth(t));
    let all = depth_to(range.1);
    let lost = -(-all).exp_m1();
    if lost <= 0.0 {
        return None;
    }
    let t = fog.place_at_depth(range, -(-u * lost).ln_1p(), mean);
    let density_per_m = mean(fog.extinction(t)) * (-depth_to(t)).exp() / lost;
    (density_per_m > 0.0).then_some((t, density_per_m))
}
