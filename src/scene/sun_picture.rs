//! Picture on a sun's disc: an image, a fractal, limb darkening. In go contents and a time, out comes a disc
//! picture. Invariant: a picture is not black; a constant one is made once.

use super::{DISC_CELLS, DiscPicture, Julia, Texture, Wrap, limb_darkening};
use crate::color::Rgb;
use crate::description::image::DecodedImage;
use glam::{DVec2, Vec2};
use std::sync::Arc;

/// Maximum number of suns with a picture, each of which takes megabytes.
pub const MOST_SUN_PICTURES: usize = 16;

/// Maximum number of texels to sample along either side of a cell.
const MOST_PER_CELL: usize = 8;

/// Picture on a sun's disc.
#[derive(Clone, Debug)]
pub struct SunPicture {
    shows: SunShows,
    limb_darkening: f64,
    /// Picture at all times, if it is constant.
    still: Option<Arc<DiscPicture>>,
}

/// Content of a sun's disc, before limb darkening.
#[derive(Clone, Debug)]
pub enum SunShows {
    /// Uniform.
    Even,
    /// Largest centred circle of an image.
    Image(Arc<Texture>),
    /// A fractal.
    Julia(Julia),
}

impl SunPicture {
    /// Picture with a coefficient of [`limb_darkening`]; `None` if it is black.
    pub fn new(shows: SunShows, limb_darkening: f64) -> Option<Self> {
        let limb = |p: DVec2| limb(limb_darkening, p);
        let still = match &shows {
            SunShows::Even => Some(DiscPicture::new(1, |p| Rgb::splat(limb(p)))?),
            SunShows::Image(image) => {
                let side = image.width.min(image.height);
                let per_cell = side.div_ceil(DISC_CELLS).min(MOST_PER_CELL);
                Some(DiscPicture::new(per_cell, |p| inscribed(image, p) * limb(p))?)
            }
            SunShows::Julia(julia) if julia.is_still() => {
                let color = julia.color_at(0.0);
                Some(DiscPicture::new(1, |p| color(p) * limb(p))?)
            }
            SunShows::Julia(_) => None,
        };
        Some(Self { shows, limb_darkening, still: still.map(Arc::new) })
    }

    /// Content without limb darkening.
    pub fn shows(&self) -> &SunShows {
        &self.shows
    }

    /// Coefficient of [`limb_darkening`].
    pub fn limb_darkening(&self) -> f64 {
        self.limb_darkening
    }

    /// Picture at a time.
    pub fn at(&self, time_s: f64) -> Option<Arc<DiscPicture>> {
        match (&self.still, &self.shows) {
            (None, SunShows::Julia(julia)) => {
                let color = julia.color_at(time_s);
                DiscPicture::new(1, |p| color(p) * limb(self.limb_darkening, p)).map(Arc::new)
            }
            (still, _) => still.clone(),
        }
    }
}

/// Image for suns, clamped at its edges.
pub(super) fn image_for_suns(name: &str, image: DecodedImage) -> Arc<Texture> {
    let DecodedImage { width, height, texels, .. } = image;
    Arc::new(Texture { name: name.to_owned(), width, height, texels, wrap: [Wrap::Clamp; 2] })
}

fn limb(u: f64, p: DVec2) -> f64 {
    limb_darkening(u, p.length())
}

/// Colour of the image at a point of the disc, which is its largest centred circle.
fn inscribed(image: &Texture, p: DVec2) -> Rgb {
    let size = DVec2::new(image.width as f64, image.height as f64);
    let radius = 0.5 * size.min_element() / size;
    let uv = 0.5 + DVec2::new(p.x, -p.y) * radius;
    image.color(Vec2::new(uv.x as f32, uv.y as f32))
}
