//! Sky. In go fields of a file, out come its picture and light. Invariant: a sky that exists is not black.

use super::{Resolver, track};
use crate::color::Rgb;
use crate::description::ron;
use crate::diagnostic::{Diagnostic, Loss};
use crate::scene::{Sky, SkyPicture};
use std::path::Path;

impl Resolver<'_> {
    /// Resolves the sky, if there is one.
    pub(super) fn sky(&mut self) {
        let Some(sky) = &self.file.sky else { return };
        if self.scene.background != Rgb::ZERO {
            self.problems.error(
                "sky",
                "the scene has a sky and a background",
                "`sky` or `background_w_per_m2_sr`",
                "take `background_w_per_m2_sr` out: a sky is seen too",
            );
        }
        let (picture, strength, rotation, lights) = match sky {
            ron::Sky::Constant { radiance_w_per_m2_sr, lights } => {
                let strength = track(radiance_w_per_m2_sr, "sky.radiance_w_per_m2_sr", &mut self.problems);
                (Some(SkyPicture::Even(Rgb::ONE)), strength, Some(0.0.into()), lights)
            }
            ron::Sky::Gradient {
                zenith_w_per_m2_sr,
                horizon_w_per_m2_sr,
                ground_w_per_m2_sr,
                strength,
                lights,
            } => {
                let picture = SkyPicture::Gradient {
                    zenith: zenith_w_per_m2_sr.si(),
                    horizon: horizon_w_per_m2_sr.si(),
                    ground: ground_w_per_m2_sr.si(),
                };
                let strength = track(strength, "sky.strength", &mut self.problems);
                (Some(picture), strength, Some(0.0.into()), lights)
            }
            ron::Sky::Image { image, strength_w_per_m2_sr, rotation_deg, lights } => {
                let strength = track(strength_w_per_m2_sr, "sky.strength_w_per_m2_sr", &mut self.problems);
                let rotation = track(rotation_deg, "sky.rotation_deg", &mut self.problems);
                (self.image_of_sky(image), strength, rotation, lights)
            }
        };
        let (Some(picture), Some(strength), Some(rotation)) = (picture, strength, rotation) else { return };
        match Sky::new(picture) {
            Some(sky) => {
                self.scene.sky = Some(sky.with(strength, rotation, *lights));
            }
            None => self.problems.error(
                "sky",
                "the sky is black all over",
                "a sky that is bright somewhere",
                "make it brighter, or take `sky` out",
            ),
        }
    }

    /// Radiances below 0, which filters cause, become 0.
    fn image_of_sky(&mut self, path: &Path) -> Option<SkyPicture> {
        let image = self.sky_image.take()?;
        let name = path.display().to_string();
        if let Some((loss, found)) = image.doubt {
            let (place, found) = (self.problems.place("sky.image"), format!("{name}: {found}"));
            self.scene.remarks.push(Diagnostic::warning(loss, place, found));
        }
        let (picture, negative) = SkyPicture::of_image(name, [image.width, image.height], image.texels);
        if negative > 0 {
            let found =
                format!("{negative} texels of {} have radiances below 0, which count as 0", path.display());
            let place = self.problems.place("sky.image");
            self.scene.remarks.push(Diagnostic::warning(Loss::NegativeRadiance, place, found));
        }
        Some(picture)
    }
}
