//! Lobes of a surface, for sampling directions. In go a point of a surface and uniform numbers, out come
//! directions and their densities. Invariant: the density is positive wherever the BSDF is.

use super::direct::scattered_per_radiance;
use crate::color::{Rgb, luminance};
use crate::math::disc_from_square;
use crate::scattering::Clearcoat;
use crate::snapshot::SurfacePoint;
use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_1_PI;

/// Kind of scattering by a surface.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    /// Diffuse reflection, on the eye's side.
    Reflected,
    Coated,
    /// Diffuse transmission, on the other side.
    Transmitted,
    Shone,
    /// Reflected by a dielectric.
    Mirrored,
    Refracted,
}

/// The lobes of a surface, with shares that add up to 1.
pub(super) struct Lobes {
    shares: [(Way, f64); 6],
    /// Albedo of all lobes together, approximate.
    pub(super) all: f64,
}

impl Lobes {
    /// `None` if it scatters nothing.
    pub(super) fn of(point: &SurfacePoint) -> Option<Self> {
        let cos_eye = point.specular_normal.dot(point.to_eye);
        let gloss = point.gloss.as_ref().filter(|_| cos_eye > 0.0);
        let beneath = gloss.map_or(Rgb::ONE, |gloss| gloss.leaves(cos_eye));
        // Cloth is sampled as if it were diffuse.
        let sheen = point
            .layers
            .as_ref()
            .map_or(0.0, |layers| layers.sheen_albedo(point.shading_normal, point.to_eye));
        let coated = coat(point).map_or(0.0, |coat| coat.albedo(point.to_eye));
        let reflected = luminance(point.albedo * beneath) + sheen;
        let transmitted = luminance(point.transmission * beneath);
        let shone = gloss.map_or(0.0, |gloss| luminance(gloss.albedo(cos_eye)));
        let [mirrored, refracted] =
            point.dielectric.as_ref().map_or([0.0; 2], |own| own.albedos(cos_eye).map(luminance));
        let all = reflected + transmitted + shone + coated + mirrored + refracted;
        let shares = [
            (Way::Reflected, reflected),
            (Way::Coated, coated),
            (Way::Transmitted, transmitted),
            (Way::Shone, shone),
            (Way::Mirrored, mirrored),
            (Way::Refracted, refracted),
        ];
        (all > 0.0).then(|| Self { shares: shares.map(|(way, share)| (way, share / all)), all })
    }

    /// Direction towards the light that two uniform numbers sample, with a density close to that of the BSDF
    /// times the cosine.
    pub(super) fn sample(&self, point: &SurfacePoint, mut u: DVec2) -> DVec3 {
        let (normal, specular_normal, to_eye) = (point.shading_normal, point.specular_normal, point.to_eye);
        let mut sampled = Way::Reflected;
        for (way, share) in self.shares.into_iter().filter(|(_, share)| *share > 0.0) {
            sampled = way;
            if u.x < share {
                u.x /= share;
                break;
            }
            u.x -= share;
        }
        let lambert = |normal: DVec3| {
            // Malley's method: a uniform disc, projected up.
            let disc = disc_from_square(u);
            about(normal, disc, (1.0 - disc.length_squared()).max(0.0).sqrt())
        };
        match (sampled, coat(point), &point.gloss, &point.dielectric) {
            (Way::Transmitted, ..) => lambert(-normal),
            (Way::Coated, Some(coat), ..) => coat.gloss.sample(coat.normal, to_eye, u),
            (Way::Shone, _, Some(gloss), _) => gloss.sample(specular_normal, to_eye, u),
            (Way::Mirrored, .., Some(dielectric)) => dielectric.sample(specular_normal, to_eye, false, u),
            (Way::Refracted, .., Some(dielectric)) => dielectric.sample(specular_normal, to_eye, true, u),
            _ => lambert(normal),
        }
    }

    /// Probability density of [`Lobes::sample`] for a direction, 1/sr.
    pub(super) fn pdf(&self, point: &SurfacePoint, direction: DVec3) -> f64 {
        let (normal, specular_normal, to_eye) = (point.shading_normal, point.specular_normal, point.to_eye);
        let cos = normal.dot(direction);
        let share = |way: Way| self.shares[way as usize].1;
        let matte = share(if cos > 0.0 { Way::Reflected } else { Way::Transmitted });
        let mut density = matte * FRAC_1_PI * cos.abs();
        // Some samples of gloss and coat lie behind the surface, where light may be transmitted.
        let gloss = point.gloss.as_ref().filter(|_| share(Way::Shone) > 0.0);
        density +=
            share(Way::Shone) * gloss.map_or(0.0, |gloss| gloss.pdf(specular_normal, to_eye, direction));
        let coat = coat(point).filter(|_| share(Way::Coated) > 0.0);
        density +=
            share(Way::Coated) * coat.map_or(0.0, |coat| coat.gloss.pdf(coat.normal, to_eye, direction));
        if let Some(dielectric) = point.dielectric.as_ref().filter(|_| share(Way::Refracted) > 0.0) {
            let [reflected, through] = dielectric.pdf(specular_normal, to_eye, direction);
            density += share(Way::Mirrored) * reflected + share(Way::Refracted) * through;
        }
        density
    }
}

/// Samples a direction from which a surface scatters light towards the eye, by one of its lobes or its
/// mirror. Returns it with the BSDF times cosine over its density, and the density, 1/sr; `None` for the
/// mirror.
pub(super) fn sample_bsdf(point: &SurfacePoint, (mut u, v): (f64, f64)) -> Option<(DVec3, Rgb, Option<f64>)> {
    let matte = matte_share(point);
    let share = 1.0 - matte.as_ref().map_or(0.0, |(_, share)| *share);
    if u < share {
        let normal = point.shading_normal;
        let reflected = 2.0 * point.to_eye.dot(normal) * normal - point.to_eye;
        let leaves = reflected.dot(point.geometric_normal) > 0.0;
        return leaves.then(|| (reflected.normalize(), point.mirror / share, None));
    }
    let (lobes, matte_share) = matte?;
    u = (u - share) / matte_share;
    let direction = lobes.sample(point, [u, v].into());
    let density = matte_share * lobes.pdf(point, direction);
    let weight = scattered_per_radiance(point, direction) / density;
    (density > 0.0).then_some((direction, weight, Some(density)))
}

/// Lobes of a surface, and the probability of sampling them rather than its mirror; `None` if it has no
/// lobes.
pub(super) fn matte_share(point: &SurfacePoint) -> Option<(Lobes, f64)> {
    let (lobes, mirror) = (Lobes::of(point)?, luminance(point.mirror));
    let share = lobes.all / (mirror + lobes.all);
    Some((lobes, share))
}

/// The clear coat of a surface seen from its front.
fn coat(point: &SurfacePoint) -> Option<&Clearcoat> {
    let coat = point.layers.as_ref()?.clearcoat.as_ref()?;
    (coat.normal.dot(point.to_eye) > 0.0).then_some(coat)
}

/// Vector with the given components across an axis and along it.
pub(super) fn about(axis: DVec3, across: DVec2, along: f64) -> DVec3 {
    let right = axis.any_orthonormal_vector();
    across.x * right + across.y * axis.cross(right) + along * axis
}
