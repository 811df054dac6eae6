//! Indirect specular reflection. In go a point and uniform numbers, out comes an estimate of the radiance
//! that it reflects of its surroundings. Invariant: lights are left out, as direct light has them. The sky
//! has a ray of its own.

use super::direct::{scattered_per_radiance, specular_part};
use super::lobes::Lobes;
use super::path::{Illumination, Path, Start, Transport, VolumeMethod};
use super::sky_light;
use crate::color::Rgb;
use crate::indirect::Indirect;
use crate::math::Ray;
use crate::snapshot::SurfacePoint;
use glam::DVec2;

/// Radiance of indirect light in the specular reflection of a surface, W m^-2 sr^-1.
pub(super) fn seen(path: &mut Path, indirect: &Indirect, point: &SurfacePoint) -> Rgb {
    let specular = specular_part(point);
    let of_sky = if indirect.has_sky() && path.light.has_rest {
        sky_light::from_sky(path, &specular)
    } else {
        Rgb::ZERO
    };
    of_sky + reflected(path, indirect, &specular)
}

/// Radiance along one ray, times the BSDF; its direction is sampled from the microfacet distribution.
fn reflected(path: &mut Path, indirect: &Indirect, specular: &SurfacePoint) -> Rgb {
    let Some(lobes) = Lobes::of(specular) else { return Rgb::ZERO };
    let direction = lobes.sample(specular, DVec2::from(path.sampler.next_2d()));
    let (scattered, density) = (scattered_per_radiance(specular, direction), lobes.pdf(specular, direction));
    if scattered == Rgb::ZERO || density <= 0.0 {
        return Rgb::ZERO;
    }
    // The light along this ray has one scattering less than the reflection. Its direction is random, so exact
    // shafts along it would cost time and add nothing.
    let volume = VolumeMethod::Equiangular { points: 1 };
    let transport = Transport { indirect: indirect.once_less(), volume, ..*path.transport };
    let sky = if indirect.has_sky() { path.light.has_rest } else { path.light.sky };
    let mut seen_from_there = Path {
        snapshot: path.snapshot,
        transport: &transport,
        light: Illumination { sky, is_in_specular: true, indirect_alone: false, ..path.light },
        sampler: &mut *path.sampler,
        scratch: &mut *path.scratch,
    };
    let ray = Ray { origin: specular.position, direction };
    let start = Start::Specular(specular.primitive);
    let (leg, _) = seen_from_there.follow(&ray, start, transport.mirror_depth);
    scattered * leg.shown.radiance / density
}
