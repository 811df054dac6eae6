//! Picture on a sun's disc. In go colours over the unit disc, out come points with a density proportional to
//! brightness. Invariant: every channel has the mean 1, so a picture redistributes light and adds none.

use crate::color::{Rgb, luminance};
use crate::math::{SquareDistribution, disc_from_square, large_list, square_from_disc};
use glam::DVec2;

/// Cells along an edge of the square that maps to the disc. They have equal areas, and are about as wide as
/// high. Larger pictures are averaged.
pub const DISC_CELLS: usize = 512;

/// Colours over the unit disc, and points with a density proportional to the mean of their channels. With
/// luminance in its place, purely red parts would have a fifth of the points, each five times as bright.
#[derive(Clone, Debug)]
pub struct DiscPicture {
    colors: Vec<[f32; 3]>,
    by_brightness: SquareDistribution,
}

impl DiscPicture {
    /// Picture from colours at points of the unit disc, x to the right and y up, sampled at `per_cell` points
    /// along either side of a cell; `None` if it is black.
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
        let mut colors: Vec<Rgb> = large_list(DISC_CELLS * DISC_CELLS);
        colors.extend((0..DISC_CELLS * DISC_CELLS).map(color_of));
        let cells = colors.len() as f64;
        let mean = colors.iter().sum::<Rgb>() / cells;
        let grey = luminance(mean);
        if grey <= 0.0 || !grey.is_finite() {
            return None;
        }
        for color in &mut colors {
            // A channel without light is distributed like the others.
            let shade = luminance(*color) / grey;
            let channel = |i: usize| if mean[i] > 0.0 { color[i] / mean[i] } else { shade };
            *color = Rgb::new(channel(0), channel(1), channel(2));
        }
        let by_brightness =
            SquareDistribution::new(DISC_CELLS, colors.iter().map(|color| brightness(*color)))?;
        Some(Self { colors: colors.iter().map(|color| color.as_vec3().to_array()).collect(), by_brightness })
    }

    /// Point of the disc, and the colour of the whole light if it came from there: its channels have the mean
    /// 1 and are at most 3.
    pub fn point(&self, u: DVec2) -> (DVec2, Rgb) {
        let (cell, place) = self.by_brightness.sample(u);
        let color = self.color(cell);
        (disc_from_square(place), color / brightness(color))
    }

    /// Whether the picture has a single hue, so that points differ only in density.
    pub fn is_grey(&self) -> bool {
        self.colors.iter().all(|[red, green, blue]| red == green && green == blue)
    }

    /// Colour at a point of the disc; its mean over the disc is 1.
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

/// Limb darkening: brightness at a distance from the centre (1 at the edge), relative to the centre. The
/// linear law is `1 - u (1 - mu)`, with `mu` the cosine of the angle at which the light leaves the star.
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
