//! A picture on a sun's disc. In go colours over the unit disc, out come points as dense as the
//! picture is bright. Invariant: every channel is 1 on average, so a picture moves light about and adds
//! none.

use crate::color::{Rgb, luminance};
use crate::math::{SquareDistribution, disc_from_square, square_from_disc};
use glam::DVec2;

/// Cells along an edge of the square that the disc is the image of: all of one area, about as wide
/// as high. Larger pictures are averaged.
pub const DISC_CELLS: usize = 512;

/// Colours over the unit disc, and points of it in proportion to the mean of their channels. Of
/// luminance red is only a fifth: points drawn by that would be few where the picture is red alone,
/// and each five times as bright.
#[derive(Clone, Debug)]
pub struct DiscPicture {
    colors: Vec<[f32; 3]>,
    by_brightness: SquareDistribution,
}

impl DiscPicture {
    /// Picture by the colour at points of the unit disc, x to the right and y up, asked at `per_cell`
    /// times as many points along either side as there are cells; `None` if it is black all over.
    pub fn new(per_cell: usize, color_at: impl Fn(DVec2) -> Rgb) -> Option<Self> {
        let points = (DISC_CELLS * per_cell) as f64;
        let color_of = |cell: usize| {
            let (column, row) = (cell % DISC_CELLS * per_cell, cell / DISC_CELLS * per_cell);
            let mut sum = Rgb::ZERO;
            for point in 0..per_cell * per_cell {
                let x = (column + point % per_cell) as f64 + 0.5;
                let y = (row + point / per_cell) as f64 + 0.5;
                sum += color_at(disc_from_square(DVec2::new(x, y) / points));
            }
            sum / (per_cell * per_cell) as f64
        };
        let mut colors: Vec<Rgb> = (0..DISC_CELLS * DISC_CELLS).map(color_of).collect();
        let cells = colors.len() as f64;
        let mean = colors.iter().sum::<Rgb>() / cells;
        let grey = luminance(mean);
        if grey <= 0.0 || !grey.is_finite() {
            return None;
        }
        for color in &mut colors {
            // A channel that is black all over has its light where the others have theirs.
            let shade = luminance(*color) / grey;
            let channel = |i: usize| if mean[i] > 0.0 { color[i] / mean[i] } else { shade };
            *color = Rgb::new(channel(0), channel(1), channel(2));
        }
        let by_brightness =
            SquareDistribution::new(DISC_CELLS, colors.iter().map(|color| brightness(*color)))?;
        Some(Self { colors: colors.iter().map(|color| color.as_vec3().to_array()).collect(), by_brightness })
    }

    /// A point of the disc, and the colour of all light if it came from there: its channels are 1 on
    /// average, and at most 3.
    pub fn point(&self, u: DVec2) -> (DVec2, Rgb) {
        let (cell, place) = self.by_brightness.pick(u);
        let color = self.color(cell);
        (disc_from_square(place), color / brightness(color))
    }

    /// Whether all of it has one colour, brighter here and darker there, so that points differ in
    /// nothing but their place.
    pub fn is_grey(&self) -> bool {
        self.colors.iter().all(|[red, green, blue]| red == green && green == blue)
    }

    /// The colour at a point of the disc; the mean over the disc is 1.
    pub fn color_at(&self, disc: DVec2) -> Rgb {
        self.color(self.by_brightness.cell(square_from_disc(disc)))
    }

    fn color(&self, cell: usize) -> Rgb {
        let [r, g, b] = self.colors[cell];
        Rgb::new(f64::from(r), f64::from(g), f64::from(b))
    }
}

fn brightness(color: Rgb) -> f64 {
    color.element_sum() / 3.0
}

/// Brightness of a star's disc at a distance from its middle, 1 at the edge, over that in the middle: the
/// linear law `1 - u (1 - mu)` with `mu` the cosine of the angle at which the light leaves it.
pub fn limb_darkening(u: f64, distance: f64) -> f64 {
    1.0 - u * (1.0 - (1.0 - distance * distance).max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Sampler;

    /// Whatever the picture: points with their colours give 1 in every channel.
    #[test]
    fn a_picture_adds_no_light() {
        let pictures: [fn(DVec2) -> Rgb; 3] = [
            |p| Rgb::new(1.0, if p.x > 0.3 { 0.5 } else { 0.01 }, 0.0),
            |p| Rgb::splat(limb_darkening(0.6, p.length())),
            |p| if p.distance(DVec2::new(0.5, 0.1)) < 0.1 { Rgb::new(1.0, 2.0, 3.0) } else { Rgb::ZERO },
        ];
        for picture in pictures {
            let picture = DiscPicture::new(1, picture).expect("it is bright somewhere");
            let (mut by_points, mut by_area) = (Rgb::ZERO, Rgb::ZERO);
            let count = 1 << 13;
            for sample in 0..count {
                let u = DVec2::from(Sampler::new(2, 0, 0, sample).next_2d());
                let (_, color) = picture.point(u);
                assert!((brightness(color) - 1.0).abs() < 1e-6);
                by_points += color / f64::from(count);
                by_area += picture.color_at(disc_from_square(u)) / f64::from(count);
            }
            assert!((by_points - 1.0).abs().max_element() < 1e-2, "{by_points}");
            assert!((by_area - 1.0).abs().max_element() < 2e-2, "{by_area}");
        }
    }

    #[test]
    fn bright_places_are_picked() {
        let spot = DVec2::new(0.5, 0.1);
        let at_spot = |p: DVec2| if p.distance(spot) < 0.1 { Rgb::ONE } else { Rgb::ZERO };
        let picture = DiscPicture::new(1, at_spot).expect("it is bright somewhere");
        for sample in 0..500 {
            let (p, _) = picture.point(Sampler::new(2, 0, 0, sample).next_2d().into());
            assert!(p.distance(spot) < 0.105, "{p}");
        }
        assert!(DiscPicture::new(1, |_| Rgb::ZERO).is_none());
    }
}
