//! Light of the sky, scattered once by surfaces and by fog. In go a ray or a point of a surface and uniform
//! numbers, out comes an estimate of what the sky adds. Invariant: unbiased, and one shadow ray each.
//!
//! Directions are picked either as densely as the matter scatters or as densely as the sky is bright. They
//! are weighed by the mean of both densities: the balance heuristic with one sample. See Veach and Guibas
//! 1995, "Optimally combining sampling techniques for Monte Carlo rendering", section 3.3.

use super::direct::scattered_per_radiance;
use super::path::Path;
use super::visibility::Way;
use crate::color::{Rgb, luminance};
use crate::fog::{Medium, exp_minus, pick_henyey_greenstein, picked_henyey_greenstein};
use crate::math::{Ray, disc_from_square};
use crate::snapshot::{FrozenSky, SurfacePoint};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_1_PI, TAU};

/// How many of the directions are picked by the sky's brightness, where it is not the same everywhere.
const SHARE_OF_SKY: f64 = 0.5;

/// A place of an optical depth is found when it is off by less than this part of all of it.
const DEPTH_TOLERANCE: f64 = 1e-10;
/// Bisection alone needs 34 steps for that.
const MOST_STEPS: usize = 40;

/// Radiance that a surface scatters towards the eye, W m^-2 sr^-1.
pub(super) fn scattered(path: &mut Path, point: &SurfacePoint) -> Rgb {
    let snapshot = path.snapshot;
    let sky = snapshot.sky.as_ref().filter(|sky| path.samples_sky() && sky.lights_surfaces());
    let Some(sky) = sky else { return Rgb::ZERO };
    let Some(lobes) = Lobes::of(point) else { return Rgb::ZERO };
    let u = DVec2::from(path.sampler.next_2d());
    let (to_sky, density) =
        picked(sky, u, |u| lobes.pick(point, u), |direction| lobes.picked(point, direction));
    let scattered = scattered_per_radiance(point, to_sky) * sky.along(to_sky);
    if scattered == Rgb::ZERO {
        return Rgb::ZERO;
    }
    let shadow_ray = Ray { origin: point.position, direction: to_sky };
    let visible = snapshot.visibility(&shadow_ray, f64::INFINITY, Some(point.primitive));
    if visible == Rgb::ZERO {
        return Rgb::ZERO;
    }
    let fog = snapshot.medium.transmittance(point.position, to_sky, f64::INFINITY);
    scattered * visible * fog / density
}

/// Radiance that fog scatters into the ray on its way, W m^-2 sr^-1.
pub(super) fn in_scattered(path: &mut Path, ray: &Ray, way: &Way) -> Rgb {
    let (snapshot, medium) = (path.snapshot, &path.snapshot.medium);
    let sky = snapshot.sky.as_ref().filter(|sky| path.samples_sky() && sky.lights_fog());
    let Some(sky) = sky else { return Rgb::ZERO };
    let Some(range) = medium.range(ray, way.distance) else { return Rgb::ZERO };
    let [along, u, v] = path.sampler.next_3d();
    let Some((t, density_per_m)) = place_by_depth(medium, ray, range, along) else { return Rgb::ZERO };
    let point = ray.at(t);
    let g = medium.anisotropy_at(point);
    let (to_sky, density) = picked(
        sky,
        DVec2::new(u, v),
        |u| {
            let (cos, _) = pick_henyey_greenstein(g, u.x);
            about(ray.direction, DVec2::from_angle(TAU * u.y) * (1.0 - cos * cos).max(0.0).sqrt(), cos)
        },
        |direction| picked_henyey_greenstein(g, direction.dot(ray.direction)),
    );
    let scattered = medium.scattering_at(point, to_sky.dot(ray.direction)) * sky.along(to_sky);
    if scattered == Rgb::ZERO {
        return Rgb::ZERO;
    }
    let visible = snapshot.visibility(&Ray { origin: point, direction: to_sky }, f64::INFINITY, None);
    if visible == Rgb::ZERO {
        return Rgb::ZERO;
    }
    let seen_through = way.blended.iter().filter(|hit| hit.t < t);
    let visible = seen_through.fold(visible, |product, hit| product * hit.point.see_through);
    let tau = medium.optical_depth(point, to_sky, f64::INFINITY)
        + medium.optical_depth(ray.origin, ray.direction, t);
    scattered * exp_minus(tau) * visible / (density * density_per_m)
}

/// A direction and its density, 1/sr, by the sky's brightness or by how the matter scatters.
fn picked(
    sky: &FrozenSky,
    mut u: DVec2,
    pick: impl Fn(DVec2) -> DVec3,
    density: impl Fn(DVec3) -> f64,
) -> (DVec3, f64) {
    if !sky.is_uneven() {
        let direction = pick(u);
        return (direction, density(direction));
    }
    // What is left of a number that has decided is uniform again.
    let by_sky = u.x < SHARE_OF_SKY;
    u.x = if by_sky { u.x / SHARE_OF_SKY } else { (u.x - SHARE_OF_SKY) / (1.0 - SHARE_OF_SKY) };
    let direction = if by_sky { sky.pick(u) } else { None }.unwrap_or_else(|| pick(u));
    let of_sky = sky.picked(direction);
    (direction, density(direction) + SHARE_OF_SKY * (of_sky - density(direction)))
}

/// The ways that a surface scatters: to the eye's side, to the other side, in its coat. Shares of 1.
struct Lobes {
    reflected: f64,
    transmitted: f64,
}

impl Lobes {
    /// `None` if it scatters nothing.
    fn of(point: &SurfacePoint) -> Option<Self> {
        let cos_eye = point.shading_normal.dot(point.to_eye);
        let coat = point.gloss.as_ref().filter(|_| cos_eye > 0.0);
        let beneath = coat.map_or(Rgb::ONE, |gloss| Rgb::ONE - gloss.albedo(cos_eye));
        // What lies over it is picked as if it were matte.
        let over =
            point.layers.as_ref().map_or(0.0, |layers| layers.albedo(point.shading_normal, point.to_eye));
        let reflected = luminance(point.albedo * beneath) + over;
        let transmitted = luminance(point.transmission * beneath);
        let shone = coat.map_or(0.0, |gloss| luminance(gloss.albedo(cos_eye)));
        let all = reflected + transmitted + shone;
        (all > 0.0).then(|| Self { reflected: reflected / all, transmitted: transmitted / all })
    }

    fn pick(&self, point: &SurfacePoint, mut u: DVec2) -> DVec3 {
        let normal = point.shading_normal;
        let lambert = |u: DVec2, normal: DVec3| {
            // Malley's method: a uniform disc, projected up.
            let disc = disc_from_square(u);
            about(normal, disc, (1.0 - disc.length_squared()).max(0.0).sqrt())
        };
        if u.x < self.reflected {
            u.x /= self.reflected;
            return lambert(u, normal);
        }
        u.x -= self.reflected;
        match &point.gloss {
            Some(gloss) if u.x >= self.transmitted => {
                u.x = (u.x - self.transmitted) / (1.0 - self.reflected - self.transmitted);
                gloss.pick(normal, point.to_eye, u)
            }
            _ => {
                u.x /= self.transmitted;
                lambert(u, -normal)
            }
        }
    }

    fn picked(&self, point: &SurfacePoint, direction: DVec3) -> f64 {
        let cos = point.shading_normal.dot(direction);
        let matte = if cos > 0.0 { self.reflected } else { self.transmitted } * FRAC_1_PI * cos.abs();
        // Some of what is picked for the coat lies behind the surface, where light may come through.
        let shone = 1.0 - self.reflected - self.transmitted;
        let coat = point.gloss.as_ref().filter(|_| shone > 0.0);
        let coat = coat.map_or(0.0, |gloss| gloss.picked(point.shading_normal, point.to_eye, direction));
        matte + shone * coat
    }
}

/// A vector by its parts across an axis and along it.
fn about(axis: DVec3, across: DVec2, along: f64) -> DVec3 {
    let right = axis.any_orthonormal_vector();
    across.x * right + across.y * axis.cross(right) + along * axis
}

/// The place within `range` before which a share of the light lost on it is lost, and its density per metre:
/// as often as the eye's own light would be scattered there. `None` where nothing is lost.
fn place_by_depth(medium: &Medium, ray: &Ray, (start, end): (f64, f64), u: f64) -> Option<(f64, f64)> {
    let mean = |depth: Rgb| depth.element_sum() / 3.0;
    let depth_to = |t: f64| mean(medium.optical_depth(ray.origin, ray.direction, t));
    let extinction = |t: f64| mean(medium.extinction_at(ray.at(t)));
    let all = depth_to(end);
    let lost = -(-all).exp_m1();
    if lost <= 0.0 {
        return None;
    }
    let wanted = -(-u * lost).ln_1p();
    // Newton's method within what bisection leaves: of one even bank the first step is exact.
    let (mut low, mut high) = (start, end);
    let mut t = start + (end - start) * (wanted / all);
    for _ in 0..MOST_STEPS {
        let excess = depth_to(t) - wanted;
        if excess.abs() <= DEPTH_TOLERANCE * all {
            break;
        }
        if excess > 0.0 {
            high = t
        } else {
            low = t
        }
        let newton = t - excess / extinction(t);
        t = if low < newton && newton < high { newton } else { 0.5 * (low + high) };
    }
    let density_per_m = extinction(t) * (-depth_to(t)).exp() / lost;
    (density_per_m > 0.0).then_some((t, density_per_m))
}
