//! Lamps that the camera sees, directly, in mirrors, and in surfaces so smooth that a highlight is an image
//! of the lamp. In go rays and points of surfaces, out comes radiance. Invariant: a lamp's light that a
//! smooth surface reflects is found either here or by rays to the lamp (`direct.rs`), as
//! `LampShape::shows_in` decides.

use super::direct::{narrowest, scattered_per_radiance, specular_part};
use super::leg::Shown;
use super::lobes::Lobes;
use super::path::{Path, Start};
use super::visibility::Way;
use crate::color::Rgb;
use crate::math::Ray;
use crate::snapshot::{SurfacePoint, Watcher};
use glam::DVec2;

/// Radiance of lamps that a ray meets on its way, past blended surfaces.
pub(super) fn on_the_way(path: &Path, (ray, from): (&Ray, Start), way: &Way) -> Shown {
    let (snapshot, mut sum) = (path.snapshot, Rgb::ZERO);
    let (watcher, shown) = match from {
        _ if !path.light.has_rest => return Shown::default(),
        Start::Camera => (Watcher::Camera, snapshot.view.shown_along(ray)),
        Start::Surface(_) => (Watcher::Mirror, 0.0..f64::INFINITY),
        // Already found at the surface.
        Start::Specular(_) => return Shown::default(),
    };
    for (t, radiance) in snapshot.lamps_met(watcher, ray) {
        if t < way.distance && shown.contains(&t) {
            sum += way.seen_through(t) * path.through_fog((ray, from), t) * radiance;
        }
    }
    Shown::emitted(sum)
}

/// Radiance of lamps that a surface shows as images, by one ray near the mirror direction.
pub(super) fn images(path: &mut Path, point: &SurfacePoint) -> Rgb {
    let snapshot = path.snapshot;
    let alpha = narrowest(point).filter(|&alpha| snapshot.shows_lamps(alpha, point.position));
    let (Some(alpha), true) = (alpha, path.light.has_rest) else { return Rgb::ZERO };
    let specular = specular_part(point);
    let Some(lobes) = Lobes::of(&specular) else { return Rgb::ZERO };
    let direction = lobes.sample(&specular, DVec2::from(path.sampler.next_2d()));
    let per_pdf = scattered_per_radiance(&specular, direction) / lobes.pdf(&specular, direction);
    if per_pdf == Rgb::ZERO || !per_pdf.is_finite() {
        return Rgb::ZERO;
    }
    let ray = Ray { origin: point.position, direction };
    let shown = snapshot.lights.iter().filter(|light| light.shows_in(alpha, point.position));
    let seen = |(t, radiance): (f64, Rgb)| {
        let visible = snapshot.visibility(&ray, t, Some(point.primitive));
        radiance * visible * snapshot.medium.transmittance(ray.origin, direction, t)
    };
    per_pdf * shown.filter_map(|light| light.met_by(Watcher::Mirror, &ray)).map(seen).sum::<Rgb>()
}
