//! A frozen light without extent: a point in, direction and irradiance out. Invariant: directions
//! point from the lit point towards the light.

use super::Emission;
use crate::color::Rgb;
use glam::DVec3;

/// A light without extent at one time, in relative space.
#[derive(Clone, Copy, Debug)]
pub enum FrozenLight {
    /// Parallel light.
    Sun {
        /// Unit vector towards the sun.
        to_light: DVec3,
        /// Irradiance on a perpendicular plane, W/m^2.
        irradiance: Rgb,
    },
    /// Light from a point, perhaps not the same in all directions.
    Point {
        /// Position relative to the camera.
        position: DVec3,
        /// Largest intensity, W/sr.
        intensity: Rgb,
        /// Share of the intensity by direction.
        emission: Emission,
    },
}

/// Place of a light, in relative space.
#[derive(Clone, Copy, Debug)]
pub enum LightPlace {
    /// Infinitely far away; unit vector towards the light.
    Towards(DVec3),
    /// A point.
    At(DVec3),
}

impl FrozenLight {
    /// Place of the light.
    pub fn place(&self) -> LightPlace {
        match *self {
            Self::Sun { to_light, .. } => LightPlace::Towards(to_light),
            Self::Point { position, .. } => LightPlace::At(position),
        }
    }

    /// Direction to the light, distance, and unshadowed irradiance on a plane facing it, W/m^2.
    pub fn arriving_at(&self, point: DVec3) -> (DVec3, f64, Rgb) {
        match *self {
            Self::Sun { to_light, irradiance } => (to_light, f64::INFINITY, irradiance),
            Self::Point { position, intensity, emission } => {
                let way = position - point;
                let distance = way.length();
                if distance == 0.0 {
                    return (DVec3::Y, 0.0, Rgb::ZERO);
                }
                let to_light = way / distance;
                (to_light, distance, intensity * emission.share(-to_light) / (distance * distance))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_square() {
        let intensity = Rgb::splat(8.0);
        let light = FrozenLight::Point { position: DVec3::ZERO, intensity, emission: Emission::Even };
        let (to_light, distance, irradiance) = light.arriving_at(DVec3::new(0.0, -2.0, 0.0));
        assert_eq!((to_light, distance, irradiance), (DVec3::Y, 2.0, Rgb::splat(2.0)));
    }

    #[test]
    fn a_point_on_the_light_is_dark_and_not_undefined() {
        let normal = DVec3::Z;
        let intensity = Rgb::ONE;
        let light =
            FrozenLight::Point { position: DVec3::ONE, intensity, emission: Emission::Flat { normal } };
        assert_eq!(light.arriving_at(DVec3::ONE), (DVec3::Y, 0.0, Rgb::ZERO));
    }
}
