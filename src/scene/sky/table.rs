//! Importance sampling of a sky's image. In goes the image's radiance, out comes a table of densities.
//! Invariant: every direction with light in bilinear interpolation can be sampled.

use crate::math::{SquareDistribution, square_from_sphere};
use glam::{DVec2, DVec3, Vec2};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Cells along an edge of the table, which covers the square of `sphere_from_square`.
pub(super) const CELLS: usize = 256;
/// Number of samples across an image, unless it has more texels.
const LOOKED_UP: usize = 1024;
/// Number of samples across in bright parts: a cell is 18 of these steps wide, so that a texel's footprint
/// also counts in adjacent cells.
const LOOKED_UP_CLOSELY: usize = 8192;
/// Brightness relative to the mean above which an image is sampled densely: at most an eighth of it.
const BRIGHT: f64 = 8.0;
/// Share of directions that are uniform, so that no density is 0.
const ANYWHERE: f64 = 1e-3;
/// Parts of an image for parallel work.
const STRIPS: usize = 16;

/// Direction of a point of an equirectangular image, `[0, 1]^2` from its top left corner.
pub(super) fn direction_of(place: DVec2) -> DVec3 {
    let ((sin_across, cos_across), (sin_down, cos_down)) =
        ((TAU * (place.x - 0.5)).sin_cos(), (PI * place.y).sin_cos());
    DVec3::new(sin_down * sin_across, cos_down, -sin_down * cos_across)
}

/// Light from each cell, of an image with a number of texels; `bright` is the brightness at a point, in a
/// direction. Texels are distributed to cells, and not cells sampled from texels, so that no sun is missed,
/// however small. `None` if all is dark.
pub(super) fn table_of(
    size: [usize; 2],
    bright: impl Fn(DVec3, Vec2) -> f64 + Sync,
) -> Option<SquareDistribution> {
    let [width, height] = size;
    let solid_angle = |row: usize| (PI * (row as f64 + 0.5) / height as f64).sin();
    let middle = |column: usize, row: usize| {
        let texel = DVec2::new(column as f64, row as f64) + 0.5;
        let place = texel / DVec2::new(width as f64, height as f64);
        (place, direction_of(place))
    };
    let texel = |column: usize, row: usize| {
        let (place, direction) = middle(column, row);
        bright(direction, place.as_vec2()) as f32
    };
    let row_of = |row: usize| (0..width).map(|column| texel(column, row)).collect();
    let texels: Vec<Vec<f32>> = (0..height).into_par_iter().map(row_of).collect();
    let of_row = |row: usize| solid_angle(row) * texels[row].iter().copied().map(f64::from).sum::<f64>();
    let all = width as f64 * (0..height).map(solid_angle).sum::<f64>();
    let bright_from = (BRIGHT * (0..height).map(of_row).sum::<f64>() / all) as f32;
    // Its footprint reaches to the centres of its neighbours.
    let is_near_bright = |column: usize, row: usize| {
        let columns = [column + width - 1, column, column + 1].map(|column| column % width);
        let rows = &texels[row.saturating_sub(1)..(row + 2).min(height)];
        rows.iter().any(|row| columns.iter().any(|column| row[*column] > bright_from))
    };
    let strip = |strip: usize| {
        let mut cells = vec![0.0; CELLS * CELLS];
        let first_of = |strip: usize| strip * height / STRIPS * width;
        for texel in first_of(strip)..first_of(strip + 1) {
            let (column, row) = (texel % width, texel / width);
            let across = if is_near_bright(column, row) { LOOKED_UP_CLOSELY } else { LOOKED_UP };
            let steps = across.div_ceil(width).min(2 * CELLS);
            if steps == 1 {
                let (_, direction) = middle(column, row);
                cells[cell_of(direction)] += solid_angle(row) * f64::from(texels[row][column]);
            } else {
                add_texel(&mut cells, size, ([column, row], steps), &bright);
            }
        }
        cells
    };
    // In a fixed order, so that the sums do not depend on threads.
    let strips: Vec<Vec<f64>> = (0..STRIPS).into_par_iter().map(strip).collect();
    let cells: Vec<f64> =
        (0..CELLS * CELLS).map(|cell| strips.iter().map(|strip| strip[cell]).sum()).collect();
    let anywhere = ANYWHERE * cells.iter().sum::<f64>() / (CELLS * CELLS) as f64;
    SquareDistribution::new(CELLS, cells.into_iter().map(|cell| cell + anywhere))
}

/// Adds the light of a texel's rectangle to cells, with a number of samples along either side.
fn add_texel(
    cells: &mut [f64],
    [width, height]: [usize; 2],
    ([column, row], steps): ([usize; 2], usize),
    bright: impl Fn(DVec3, Vec2) -> f64,
) {
    let place_of = |texel: usize, step: usize, count: usize| {
        (texel as f64 + (step as f64 + 0.5) / steps as f64) / count as f64
    };
    let area = 1.0 / (steps * steps) as f64;
    for down in (0..steps).map(|step| place_of(row, step, height)) {
        let solid_angle = area * (PI * down).sin();
        for across in (0..steps).map(|step| place_of(column, step, width)) {
            let place = DVec2::new(across, down);
            let direction = direction_of(place);
            cells[cell_of(direction)] += solid_angle * bright(direction, place.as_vec2());
        }
    }
}

fn cell_of(direction: DVec3) -> usize {
    let square = CELLS as f64 * square_from_sphere(direction);
    let index = |place: f64| (place as usize).min(CELLS - 1);
    index(square.y) * CELLS + index(square.x)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::math::Sampler;
    use crate::scene::{Sky, SkyPicture, Texture, Wrap};

    /// `integral L^2 / p / (integral L)^2` of suns of one texel: 1 if samples are as dense as it is bright.
    /// They are as dense all over a cell, so that it is at most cells over texel for each cell that the
    /// texel reaches into, four or fewer. Where its rim is missed it is thousands of times as much.
    #[test]
    fn picks_are_as_dense_as_a_texel_is_bright_out_to_its_rim() {
        let [width, height] = [1024, 512];
        for sun in 0..12 {
            let (x, y) = Sampler::new(8, 0, 0, sun).next_2d();
            let (column, row) = ((x * width as f64) as usize, 20 + (y * (height - 40) as f64) as usize);
            let mut texels = vec![[0.1, 0.1, 0.1, 1.0]; width * height];
            texels[row * width + column] = [1e5, 1e5, 1e5, 1.0];
            let wrap = [Wrap::Repeat, Wrap::Clamp];
            let texture = Texture { name: String::new(), width, height, texels: texels.into(), wrap };
            let sky = Sky::new(SkyPicture::Image(texture)).unwrap();
            let (mut light, mut squares) = (0.0, 0.0);
            const STEPS: usize = 64;
            for step in 0..STEPS * STEPS {
                let within = (DVec2::new((step % STEPS) as f64, (step / STEPS) as f64) + 0.5) / STEPS as f64;
                let texel = DVec2::new(column as f64, row as f64) - 0.5 + 2.0 * within;
                let place = texel / DVec2::new(width as f64, height as f64);
                let direction = direction_of(place);
                let (bright, weight): (Rgb, f64) = (sky.along(direction), (PI * place.y).sin());
                light += weight * bright.x;
                squares += weight * bright.x * bright.x / sky.pdf(direction);
            }
            let solid_angle = 4.0 * 2.0 * PI * PI / (width * height * STEPS * STEPS) as f64;
            let ratio = squares / (light * light * solid_angle);
            let cell = 4.0 * PI / (CELLS * CELLS) as f64;
            let texel =
                2.0 * PI * PI * (PI * (row as f64 + 0.5) / height as f64).sin() / (width * height) as f64;
            let most = 4.0 * cell / texel;
            assert!((1.0..most).contains(&ratio), "at {column}, {row}: {ratio} of {most}");
        }
    }

    /// However dark it is there.
    #[test]
    fn no_direction_has_a_density_of_0() {
        let texel = |index: usize| if index == 40 { [1e4, 1e4, 1e4, 1.0] } else { [0.0, 0.0, 0.0, 1.0] };
        let texels = (0..64 * 32).map(texel).collect::<Vec<_>>().into();
        let wrap = [Wrap::Repeat, Wrap::Clamp];
        let sky =
            Sky::new(SkyPicture::Image(Texture { name: String::new(), width: 64, height: 32, texels, wrap }));
        assert!(sky.unwrap().pdf(DVec3::NEG_Y) > 0.0);
    }
}
