//! A frozen light: a point in, direction and irradiance out. Invariant: directions point from the
//! lit point towards the light.

use crate::color::Rgb;
use crate::scattering::Source;
use crate::scene::{Light, LightKind};
use glam::{DAffine3, DVec3};

/// A light at one time, in relative space.
#[derive(Clone, Copy, Debug)]
pub enum FrozenLight {
    /// Parallel light.
    Sun {
        /// Unit vector towards the sun.
        to_light: DVec3,
        /// On a perpendicular plane, W/m^2.
        irradiance: Rgb,
    },
    /// Light from a point, perhaps only within a cone.
    Point {
        /// Where, relative to the camera.
        position: DVec3,
        /// On the axis if there is a cone, W/sr.
        intensity: Rgb,
        /// The beam of a spot.
        cone: Option<Cone>,
    },
}

/// The soft-edged cone of a spot.
#[derive(Clone, Copy, Debug)]
pub struct Cone {
    /// Unit vector along the beam.
    pub axis: DVec3,
    /// Beyond this there is no light.
    pub cos_outer: f64,
    /// Within this there is all of it.
    pub cos_inner: f64,
}

impl FrozenLight {
    /// Freezes `light`; `None` if it gives no light at this time.
    pub fn new(light: &Light, relative_from_light: DAffine3, time_s: f64) -> Option<Self> {
        let power = light.power.at(time_s);
        if power.max_element() <= 0.0 {
            return None;
        }
        let beam = (-relative_from_light.matrix3.z_axis).try_normalize().unwrap_or(DVec3::NEG_Z);
        let position = relative_from_light.translation;
        Some(match &light.kind {
            LightKind::Sun => Self::Sun { to_light: -beam, irradiance: power },
            LightKind::Point => Self::Point { position, intensity: power, cone: None },
            LightKind::Spot { outer_angle, blend } => {
                let cos_outer = outer_angle.at(time_s).cos();
                let cone = Cone {
                    axis: beam,
                    cos_outer,
                    cos_inner: cos_outer + (1.0 - cos_outer) * blend.at(time_s),
                };
                Self::Point { position, intensity: power, cone: Some(cone) }
            }
        })
    }

    /// Where its light comes from.
    pub fn source(&self) -> Source {
        match *self {
            Self::Sun { to_light, .. } => Source::Towards(to_light),
            Self::Point { position, .. } => Source::At(position),
        }
    }

    /// Direction to the light, distance, and unshadowed irradiance on a plane facing it, W/m^2.
    pub fn arriving_at(&self, point: DVec3) -> (DVec3, f64, Rgb) {
        match *self {
            Self::Sun { to_light, irradiance } => (to_light, f64::INFINITY, irradiance),
            Self::Point { position, intensity, cone } => {
                let way = position - point;
                let distance = way.length();
                if distance == 0.0 {
                    return (DVec3::Y, 0.0, Rgb::ZERO);
                }
                let to_light = way / distance;
                let falloff = cone.map_or(1.0, |cone| cone.falloff(-to_light.dot(cone.axis)));
                (to_light, distance, intensity * falloff / (distance * distance))
            }
        }
    }
}

impl Cone {
    /// The share of the intensity at an angle from the axis, as Cycles does it:
    /// `smoothstep((cos - cos_outer) / ((1 - cos_outer) * blend))`.
    pub fn falloff(&self, cos_angle: f64) -> f64 {
        let width = self.cos_inner - self.cos_outer;
        if width <= 0.0 {
            return if cos_angle >= self.cos_outer { 1.0 } else { 0.0 };
        }
        let x = ((cos_angle - self.cos_outer) / width).clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Track;

    #[test]
    fn inverse_square() {
        let light = Light {
            name: String::new(),
            node: 0,
            power: Track::from(Rgb::splat(8.0)),
            kind: LightKind::Point,
        };
        let frozen = FrozenLight::new(&light, DAffine3::IDENTITY, 0.0).expect("shines");
        let (to_light, distance, irradiance) = frozen.arriving_at(DVec3::new(0.0, -2.0, 0.0));
        assert_eq!((to_light, distance, irradiance), (DVec3::Y, 2.0, Rgb::splat(2.0)));
    }

    #[test]
    fn falloff_is_a_smoothstep_between_the_cones() {
        let cone = Cone { axis: DVec3::NEG_Z, cos_outer: 0.5, cos_inner: 0.7 };
        assert_eq!(cone.falloff(0.4), 0.0);
        assert_eq!(cone.falloff(0.9), 1.0);
        assert!((cone.falloff(0.6) - 0.5).abs() < 1e-15);
    }
}
