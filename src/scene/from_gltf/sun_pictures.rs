//! Picture on a sun's disc, in `sunfleck_light`. In go its fields, out comes a [`SunPicture`]. Invariant: as
//! in scene files, a picture has a disc and is not black; anything else is an error at its own JSON path.

use super::Builder;
use super::light_extras::{Fractal, LightExtras};
use crate::description::image::DecodedImage;
use crate::diagnostic::Loss;
use crate::scene::sun_picture::image_for_suns;
use crate::scene::{Julia, LightKind, MOST_SUN_PICTURES, SunPicture, SunShows, Texture};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Images of suns, by their names in the file.
pub(super) fn images(decoded: BTreeMap<String, DecodedImage>) -> BTreeMap<String, Arc<Texture>> {
    let texture = |(name, image): (String, DecodedImage)| {
        let texture = image_for_suns(if name.starts_with("data:") { "the sun" } else { &name }, image);
        (name, texture)
    };
    decoded.into_iter().map(texture).collect()
}

impl Builder<'_> {
    /// Picture on a sun's disc, if there is one; on other lights it is reported.
    pub(super) fn sun_picture(
        &mut self,
        is_sun: bool,
        extras: &LightExtras,
        path: &str,
    ) -> Option<SunPicture> {
        let shows_nothing = extras.image.is_none() && extras.fractal.is_none();
        let limb_darkening = extras.limb_darkening.unwrap_or(0.0);
        if shows_nothing && limb_darkening == 0.0 {
            return None;
        }
        if !is_sun {
            self.report.not_honoured(Loss::PictureOnLamp, path);
            return None;
        }
        if !self.is_in_range(path, "limb_darkening", limb_darkening, 0.0..=1.0, "a number from 0 to 1") {
            return None;
        }
        let shows = match (&extras.image, extras.fractal) {
            (None, None) => SunShows::Even,
            // An image that could not be read is reported already.
            (Some(name), None) => SunShows::Image(Arc::clone(self.sun_images.get(name)?)),
            (None, Some(fractal)) => SunShows::Julia(self.julia(fractal, path)?),
            (Some(_), Some(_)) => {
                let found = "the sun has an image and a fractal";
                self.report.error(path, found, "at most one of `image` and `fractal`");
                return None;
            }
        };
        self.pictures_on_suns += 1;
        if self.pictures_on_suns > MOST_SUN_PICTURES {
            let expected = format!("pictures or limb darkening on at most {MOST_SUN_PICTURES} suns");
            self.report.error(path, "too many suns have pictures", &expected);
            return None;
        }
        let picture = SunPicture::new(shows, limb_darkening);
        if picture.is_none() {
            let found = "the circle in the middle of the image is black";
            self.report.error(format!("{path}.image"), found, "an image that is bright somewhere");
        }
        picture
    }

    fn julia(&mut self, fractal: Fractal, path: &str) -> Option<Julia> {
        let path = format!("{path}.fractal");
        let Fractal { real, imaginary, iterations } = fractal;
        for (field, value) in [("real", real), ("imaginary", imaginary)] {
            if !self.is_in_range(&path, field, value, -2.0..=2.0, "a number from -2 to 2") {
                return None;
            }
        }
        let is_whole = (1.0..=1000.0).contains(&iterations) && iterations.fract() == 0.0;
        if !is_whole {
            let found = format!("the number of iterations is {iterations}");
            self.report.error(format!("{path}.iterations"), found, "a whole number from 1 to 1000");
            return None;
        }
        Some(Julia { real: real.into(), imaginary: imaginary.into(), iterations: iterations as u32 })
    }

    /// Reports suns that have a picture and no disc.
    pub(super) fn settle_suns(&mut self) {
        for light in &mut self.scene.lights {
            let LightKind::SunDisc(disc) = &light.kind else { continue };
            if disc.angular_diameter.keys().iter().all(|key| key.value == 0.0) {
                self.report.not_honoured(Loss::SunWithoutAngle, &light.name);
                light.kind = LightKind::Sun;
            }
        }
    }
}
