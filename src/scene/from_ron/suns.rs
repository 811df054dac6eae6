//! What is on a sun's disc: limb darkening, an image or a fractal. Invariant: a picture has a disc to
//! be on, and is not black; one that stays the same is made once.

use super::Resolver;
use super::lights::is_always_zero;
use crate::color::Rgb;
use crate::description::ron;
use crate::scene::{DISC_CELLS, DiscPicture, Julia, LightKind, SunDisc, SunPicture, Texture, limb_darkening};
use glam::{DVec2, Vec2};
use std::path::Path;
use std::sync::Arc;

impl Resolver<'_> {
    /// A sun without its direction and power.
    pub(super) fn sun(&mut self, owner: &str, light: &ron::Light) -> Option<LightKind> {
        let ron::Light::Sun {
            angular_diameter_deg,
            limb_darkening,
            image,
            fractal,
            picture_rotation_deg,
            visible_to_camera,
            ..
        } = light
        else {
            return None;
        };
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
            (Some(image), None) => self.image_of_sun(owner, image, darkening),
            (None, Some(julia)) => self.fractal_of_sun(owner, julia, darkening),
            (None, None) if darkening > 0.0 => still(1, |p| Rgb::splat(limb(darkening, p))),
            (None, None) => Some(SunPicture::Even),
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
        // Images that could not be read were reported when the file was.
        let texture = &self.scene.textures[*self.textures.get(path)?];
        let side = texture.width.min(texture.height);
        let per_cell = side.div_ceil(DISC_CELLS).min(MOST_PER_CELL);
        let picture = still(per_cell, |p| inscribed(texture, p) * limb(darkening, p));
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
        if !julia.is_still() {
            return Some(SunPicture::Julia { julia, limb_darkening: darkening });
        }
        let color = julia.color_at(0.0);
        still(1, |p| color(p) * limb(darkening, p))
    }
}

/// Texels beyond this many a cell, either way, are passed between.
const MOST_PER_CELL: usize = 8;

fn still(per_cell: usize, color_at: impl Fn(DVec2) -> Rgb) -> Option<SunPicture> {
    DiscPicture::new(per_cell, color_at).map(|picture| SunPicture::Still(Arc::new(picture)))
}

fn limb(u: f64, p: DVec2) -> f64 {
    limb_darkening(u, p.length())
}

/// The image's colour where the disc is the largest circle in its middle.
fn inscribed(texture: &Texture, p: DVec2) -> Rgb {
    let size = DVec2::new(texture.width as f64, texture.height as f64);
    let radius = 0.5 * size.min_element() / size;
    let uv = 0.5 + DVec2::new(p.x, -p.y) * radius;
    texture.color(Vec2::new(uv.x as f32, uv.y as f32))
}
