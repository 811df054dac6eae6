//! A frozen light without extent. In goes a point, out come direction and irradiance. Invariant: directions
//! point from the lit point towards the light.

use super::{Emission, LampShape};
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
    /// Light from a point, with any angular distribution.
    Point {
        /// Position relative to the camera.
        position: DVec3,
        /// Maximum intensity, W/sr.
        intensity: Rgb,
        /// Share of the intensity by direction.
        emission: Emission,
        /// Extent of the lamp that it is a point of.
        shape: LampShape,
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
        self.arriving(point, LampShape::share)
    }

    /// Direction to the light, distance, and fluence at a point in fog, W/m^2.
    pub fn arriving_in_fog(&self, point: DVec3) -> (DVec3, f64, Rgb) {
        self.arriving(point, LampShape::share_in_fog)
    }

    fn arriving(&self, point: DVec3, share: impl Fn(&LampShape, DVec3) -> f64) -> (DVec3, f64, Rgb) {
        match *self {
            Self::Sun { to_light, irradiance } => (to_light, f64::INFINITY, irradiance),
            Self::Point { position, intensity, emission, shape } => {
                let way = position - point;
                let distance = way.length();
                if distance == 0.0 {
                    return (DVec3::Y, 0.0, Rgb::ZERO);
                }
                let to_light = way / distance;
                let share = emission.share(-to_light) * share(&shape, point);
                (to_light, distance, intensity * share / (distance * distance))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Ray;

    fn lamp(position: DVec3, emission: Emission, shape: LampShape) -> FrozenLight {
        FrozenLight::Point { position, intensity: Rgb::splat(8.0), emission, shape }
    }

    #[test]
    fn inverse_square() {
        let light = lamp(DVec3::ZERO, Emission::Even, LampShape::NONE);
        let (to_light, distance, irradiance) = light.arriving_at(DVec3::new(0.0, -2.0, 0.0));
        assert_eq!((to_light, distance, irradiance), (DVec3::Y, 2.0, Rgb::splat(2.0)));
    }

    /// On its axis a disc of radius 1 gives `I / (d^2 + 1)`.
    #[test]
    fn a_soft_lamp_is_a_disc() {
        let light = lamp(DVec3::ZERO, Emission::Even, LampShape { softened_m2: 1.0, ..LampShape::NONE });
        let (_, _, irradiance) = light.arriving_at(DVec3::new(0.0, -2.0, 0.0));
        assert!((irradiance.x - 8.0 / 5.0).abs() < 1e-12, "{irradiance}");
    }

    /// The lamp's disc and sphere, by their solid angles: within the sphere, at its surface, beyond; far away
    /// as on surfaces.
    #[test]
    fn a_soft_lamp_in_fog_is_a_disc_for_all_directions() {
        let shape = LampShape { softened_m2: 0.09, ..LampShape::NONE };
        for (d, expected) in
            [(0.15_f64, 0.5527864045000421), (0.3, 0.2928932188134524), (0.6, 0.7880061741721575)]
        {
            let found = shape.share_in_fog(DVec3::X * d);
            assert!((found - expected).abs() < 1e-12, "{d}: {found}");
        }
        let far = DVec3::Y * 30.0;
        assert!((shape.share_in_fog(far) / shape.share(far) - 1.0).abs() < 1e-6);
    }

    /// Points of a sphere give half the fluence within it that its whole surface gives.
    #[test]
    fn a_sphere_that_shines_inward_fills_itself() {
        let shape = LampShape { inward_m2: 0.09, ..LampShape::NONE };
        assert_eq!([0.2, 0.4].map(|d| shape.share_in_fog(DVec3::X * d)), [2.0, 1.0]);
        let ray = |y: f64| Ray { origin: DVec3::new(-1.0, y, 0.0), direction: DVec3::X };
        let [enter, leave] = shape.crossings(&ray(0.0)).map(|t| t.expect("it crosses"));
        assert!((enter - 0.7).abs() < 1e-12 && (leave - 1.3).abs() < 1e-12, "{enter} {leave}");
        assert_eq!(shape.crossings(&ray(0.4)), [None; 2]);
    }

    #[test]
    fn a_point_on_the_light_is_dark_and_not_undefined() {
        let light = lamp(DVec3::ONE, Emission::Flat { normal: DVec3::Z }, LampShape::NONE);
        assert_eq!(light.arriving_at(DVec3::ONE), (DVec3::Y, 0.0, Rgb::ZERO));
    }
}
