//! Visible lamps. In go rays, out come distances and radiances. Invariant: lamps block nothing, as in Cycles,
//! where rays pass through them.

use super::luminaire::{Extent, Luminaire, Watcher};
use super::{FrozenLight, Snapshot};
use crate::color::Rgb;
use crate::math::Ray;
use crate::scene::AreaShape;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

impl Luminaire {
    /// Distance at which a ray meets it, metres, and its radiance there, W m^-2 sr^-1; `None` if it is not
    /// seen.
    pub fn met_by(&self, watcher: Watcher, ray: &Ray) -> Option<(f64, Rgb)> {
        let intensity = self.shown_to(watcher)?;
        let FrozenLight::Point { position, emission, shape, .. } = self.centre else { return None };
        let to_centre = position - ray.origin;
        let (t, area) = match &self.extent {
            Extent::Ball { radius } => {
                let along = to_centre.dot(ray.direction);
                let squared_gap = to_centre.cross(ray.direction).length_squared();
                let squared = radius * radius;
                let t = if shape.softened_m2 > 0.0 {
                    // A disc at right angles to the direction to its centre.
                    let (t, least) = (to_centre.length_squared() / along, along * along * squared);
                    (squared_gap * to_centre.length_squared() < least).then_some(t)?
                } else {
                    (squared_gap < squared).then(|| along - (squared - squared_gap).sqrt())?
                };
                (t, PI * squared)
            }
            Extent::Flat { shape, half_axes: [right, up] } => {
                let across = right.cross(*up);
                let cos = across.dot(ray.direction);
                let t = across.dot(to_centre) / cos;
                let offset = t * ray.direction - to_centre;
                let in_square = DVec2::new(offset.cross(*up).dot(across), right.cross(offset).dot(across));
                let in_square = in_square / across.length_squared();
                let (is_within, area) = match shape {
                    AreaShape::Rectangle => (in_square.abs().max_element() < 1.0, 4.0),
                    AreaShape::Ellipse => (in_square.length_squared() < 1.0, PI),
                };
                is_within.then_some((t, area * cos.abs()))?
            }
            _ => return None,
        };
        (t > 0.0).then(|| (t, intensity * emission.share(-ray.direction) / area))
    }
}

impl Snapshot<'_> {
    /// Distances at which a ray meets lamps, metres, and their radiances.
    pub fn lamps_met(&self, watcher: Watcher, ray: &Ray) -> impl Iterator<Item = (f64, Rgb)> {
        self.lights.iter().filter_map(move |light| light.met_by(watcher, ray))
    }

    /// Whether a camera ray meets a lamp or, beyond the scene, a sun.
    pub fn sees_light(&self, ray: &Ray) -> bool {
        self.suns_along(ray.direction) != Rgb::ZERO || self.lamps_met(Watcher::Camera, ray).next().is_some()
    }

    /// Whether a specular lobe of an alpha shows lamps as images at a place.
    pub fn shows_lamps(&self, alpha: f64, place: DVec3) -> bool {
        self.lights.iter().any(|light| light.shows_in(alpha, place))
    }
}
