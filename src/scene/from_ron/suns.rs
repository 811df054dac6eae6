//! Picture on a sun's disc: limb darkening, an image or a fractal. In go the fields of a RON sun, out comes a
//! [`SunPicture`]. Invariant: a picture has a disc, and is not black.

use super::Resolver;
use super::lights::is_always_zero;
use crate::description::ron;
use crate::scene::{Julia, Light, LightKind, MOST_SUN_PICTURES, SunDisc, SunPicture, SunShows};
use std::path::Path;
use std::sync::Arc;

impl Resolver<'_> {
    /// Kind of a sun, without its direction and power.
    pub(super) fn sun(&mut self, owner: &str, sun: &ron::Sun) -> Option<LightKind> {
        let ron::Sun {
            angular_diameter_deg,
            limb_darkening,
            image,
            fractal,
            picture_rotation_deg,
            visible_to_camera,
            ..
        } = sun;
        let diameter = self.keyed(owner, "angular_diameter_deg", angular_diameter_deg);
        let rotation = self.keyed(owner, "picture_rotation_deg", picture_rotation_deg);
        let darkening = limb_darkening.si();
        let picture = match (image, fractal) {
            (Some(_), Some(_)) => {
                self.problems.error(
                    owner,
                    "the sun has an image and a fractal",
                    "at most one of `image` and `fractal`",
                    "take one of the two out",
                );
                None
            }
            (Some(image), None) => self.image_of_sun(owner, image, darkening).map(Some),
            (None, Some(julia)) => self.fractal_of_sun(owner, julia, darkening).map(Some),
            (None, None) if darkening > 0.0 => SunPicture::new(SunShows::Even, darkening).map(Some),
            (None, None) => Some(None),
        };
        let (angular_diameter, picture_rotation) = (diameter?, rotation?);
        if is_always_zero(&angular_diameter) {
            let asked = image.is_some() || fractal.is_some() || darkening > 0.0 || *visible_to_camera;
            if asked {
                self.problems.error(
                    &format!("{owner}.angular_diameter_deg"),
                    "the sun has no disc that could show anything",
                    "an angle greater than 0 with `image`, `fractal`, `limb_darkening` or `visible_to_camera`",
                    "give the sun a size: 0.53 as in nature, or larger",
                );
            }
            return Some(LightKind::Sun);
        }
        let visible_to_camera = *visible_to_camera;
        Some(LightKind::SunDisc(SunDisc {
            angular_diameter,
            picture: picture?,
            picture_rotation,
            visible_to_camera,
        }))
    }

    fn image_of_sun(&mut self, owner: &str, path: &Path, darkening: f64) -> Option<SunPicture> {
        // An image that could not be read is reported already.
        let image = self.sun_images.get(path)?;
        let picture = SunPicture::new(SunShows::Image(Arc::clone(image)), darkening);
        if picture.is_none() {
            self.problems.error(
                &format!("{owner}.image"),
                "the circle in the middle of the image is black",
                "an image that is bright somewhere",
                "take another image",
            );
        }
        picture
    }

    fn fractal_of_sun(&mut self, owner: &str, julia: &ron::Julia, darkening: f64) -> Option<SunPicture> {
        let real = self.keyed(owner, "fractal.real", &julia.real);
        let imaginary = self.keyed(owner, "fractal.imaginary", &julia.imaginary);
        let julia = Julia { real: real?, imaginary: imaginary?, iterations: julia.iterations.0 };
        SunPicture::new(SunShows::Julia(julia), darkening)
    }

    /// Limits the number of pictures, each of which takes time and memory.
    pub(super) fn check_number_of_sun_pictures(&mut self) {
        let has_picture =
            |light: &Light| matches!(&light.kind, LightKind::SunDisc(disc) if disc.picture.is_some());
        let pictures = self.scene.lights.iter().filter(|light| has_picture(light)).count();
        if pictures > MOST_SUN_PICTURES {
            self.problems.error(
                "lights",
                format!("{pictures} suns have pictures"),
                &format!("at most {MOST_SUN_PICTURES}"),
                "take pictures and limb darkening out of some",
            );
        }
    }
}
