//! Light that fog scatters towards the start of a ray. In go the lit parts of the ray, out comes radiance.
//! Invariant: nothing is sampled, nothing is stepped.

use super::near_light::NearLight;
use super::stretch::Stretch;
use super::sun_stretch::SunStretch;
use super::{LitSegments, Medium};
use crate::color::Rgb;
use crate::light::FrozenLight;
use crate::math::Ray;

impl Medium {
    /// Radiance scattered into a ray, which ends at `t_max`, from its lit parts, W m^-2 sr^-1.
    pub fn scattered(&self, ray: &Ray, t_max: f64, lit: &LitSegments, light: &FrozenLight) -> Rgb {
        let mut sum = Rgb::ZERO;
        Stretch::for_each(self, ray, t_max, light.place(), |stretch| {
            let range = lit.within(stretch.start, stretch.end);
            match *light {
                FrozenLight::Sun { to_light, .. } => {
                    let mut sunny = None;
                    lit.for_each_part(&range, |start, end, share| {
                        let sunny = sunny.get_or_insert_with(|| SunStretch::new(&stretch, to_light));
                        sum += share * sunny.integral(start, end);
                    });
                }
                FrozenLight::Point { position, emission, .. } => {
                    sum += NearLight::new(&stretch, position, emission).integral(range, lit);
                }
            }
        });
        sum * match *light {
            FrozenLight::Sun { irradiance, .. } => irradiance,
            FrozenLight::Point { intensity, .. } => intensity,
        }
    }
}
