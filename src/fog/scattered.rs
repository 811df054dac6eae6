//! Light that fog scatters towards the origin of a ray. In go the lit parts of the ray, out comes radiance.
//! Invariant: it is integrated without sampling or stepping.

use super::beer_lambert::exp_minus;
use super::near_light::NearLight;
use super::ray_interval::RayInterval;
use super::sun_interval::SunInterval;
use super::{LitSegments, Medium};
use crate::color::Rgb;
use crate::light::FrozenLight;
use crate::math::Ray;

/// Scattering and transmittance of fog along a ray.
#[derive(Clone, Copy, Debug)]
pub struct Passage {
    /// Transmittance for light from behind.
    pub transmittance: Rgb,
    /// In-scattered radiance, W m^-2 sr^-1.
    pub scattered: Rgb,
}

impl Passage {
    /// Passage without fog.
    pub const NOTHING: Self = Self { transmittance: Rgb::ONE, scattered: Rgb::ZERO };
}

impl Medium {
    /// Passage of a ray that ends at `t_max` and is lit in parts.
    pub fn passage(&self, ray: &Ray, t_max: f64, lit: &LitSegments, light: &FrozenLight) -> Passage {
        let mut sum = Rgb::ZERO;
        let along = self.along(ray, t_max);
        RayInterval::for_each(&along, light.place(), |interval| {
            let range = lit.within(interval.start, interval.end);
            match *light {
                FrozenLight::Sun { to_light, .. } => {
                    let mut sunny = None;
                    lit.for_each_part(&range, |start, end, share| {
                        let sunny = sunny.get_or_insert_with(|| SunInterval::new(&interval, to_light));
                        sum += share * sunny.integral(start, end);
                    });
                }
                FrozenLight::Point { position, emission, shape, .. } => {
                    sum += NearLight::new(&interval, position, emission, shape).integral(range, lit);
                }
            }
        });
        let of_light = match *light {
            FrozenLight::Sun { irradiance, .. } => irradiance,
            FrozenLight::Point { intensity, .. } => intensity,
        };
        Passage { scattered: sum * of_light, transmittance: exp_minus(along.optical_depth(t_max)) }
    }
}
