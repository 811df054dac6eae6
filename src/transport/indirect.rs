//! Indirect light of rays and surface points, from a grid or by random walks. In go rays and points, out come
//! radiances. Invariant: the radiance is 0 unless the path's illumination includes indirect light.

use super::path::{Path, Start};
use super::visibility::Way;
use super::{emissive, paths, sky_light, specular};
use crate::color::Rgb;
use crate::indirect::Indirect;
use crate::math::Ray;
use crate::snapshot::SurfacePoint;

/// Radiance that a surface scatters towards the eye, W m^-2 sr^-1.
pub(super) fn scattered(path: &mut Path, point: &SurfacePoint) -> Rgb {
    if let Some(bounces) = path.walks() {
        let of_sky = if path.walks_have_sky() { sky_light::by_surface(path, point) } else { Rgb::ZERO };
        return of_sky + paths::scattered(path, bounces, point);
    }
    let Some(indirect) = path.transport.indirect else { return Rgb::ZERO };
    let by_rays = if path.light.is_in_specular { 0.0 } else { Indirect::share_of_rays(point) };
    let seen = if by_rays > 0.0 { by_rays * specular::seen(path, indirect, point) } else { Rgb::ZERO };
    if !path.light.has_rest {
        return seen;
    }
    let emission =
        if indirect.has_emission() { Rgb::ZERO } else { emissive::by_surface(path, point, by_rays) };
    seen + emission + indirect.scattered(path.snapshot, point, 1.0 - by_rays)
}

/// Radiance that fog scatters into the ray on its way, past blended surfaces, W m^-2 sr^-1.
pub(super) fn in_scattered(path: &mut Path, ray: &Ray, way: &Way, from: Start) -> Rgb {
    if let Some(bounces) = path.walks() {
        let of_sky =
            if path.walks_have_sky() { sky_light::on_the_way(path, (ray, from), way) } else { Rgb::ZERO };
        return of_sky + paths::in_scattered(path, bounces, ray, way);
    }
    let Some(indirect) = path.indirect() else { return Rgb::ZERO };
    way.past_blended(|distance| match from {
        Start::Camera => {
            let through = path.through_fog((ray, from), distance);
            indirect.seen_in_fog(path.snapshot, ray, distance, through)
        }
        Start::Surface(_) | Start::Specular(_) => {
            indirect.in_scattered(path.snapshot, ray, distance, !path.light.is_in_specular)
        }
    })
}
