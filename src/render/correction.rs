//! Correction of the grid's indirect light by random walks, smoothed over the picture. In go sums over
//! probes, out comes the relative correction of each pass, place by place. Invariant: differences within the
//! noise change nothing. The correction is continuous, from place to place and as noise falls.
//!
//! Corrections are means over ever smaller surroundings. Each is shrunk towards the next larger by the share
//! of noise in their difference (James & Stein 1961, "Estimation with quadratic loss"). Donoho & Johnstone
//! 1995 do so level by level ("Adapting to unknown smoothness via wavelet shrinkage"). A relative correction
//! is smooth across edges, where light itself is not. Dark places are changed little. Shrunk parts no longer
//! add up to the whole, so that the difference is shared among them evenly: benchmarking of small area
//! estimates (Pfeffermann 2013, "New important developments in small area estimation").

use super::map::Map;
use super::moments::Moments;
use super::probes::PASSES;
use crate::color::Rgb;
use crate::scene::Size;
use crate::transport::Sample;
use glam::DVec2;

/// Standard deviations of the surroundings, in cells.
const LEVELS: [f64; 6] = [f64::INFINITY, 12.0, 6.0, 3.0, 1.5, 0.6];
/// Standard deviation of the surroundings in which signal and noise are compared, as a multiple of the
/// mean's.
const COMPARED: f64 = 4.0;
/// Minimum correction: with less, light would be black or negative.
const LEAST: f64 = -0.95;

/// Weights of the means over surroundings of one size.
struct Level {
    sigma: f64,
    /// Sum of the grid's light over the surroundings.
    light: Map<Rgb>,
    /// Share of signal in the means' differences; the rest is noise.
    signal: Map<f64>,
}

/// Weights with which means are added up, in one pass.
pub(super) struct Scheme {
    pass: usize,
    levels: Vec<Level>,
}

impl Scheme {
    pub(super) fn of(moments: &Moments, pass: usize) -> Self {
        let (count, difference, grid) = (moments.count(), moments.difference(pass), moments.grid(pass));
        let mut scheme = Self { pass, levels: Vec::new() };
        if grid.sum() == Rgb::ZERO {
            return scheme;
        }
        let mut so_far = Map::filled(grid.shape, Rgb::ZERO);
        for sigma in LEVELS {
            let light = grid.smoothed(sigma);
            let count = count.smoothed(sigma);
            // A Gaussian's square has sqrt(1/2) of its standard deviation, and a variance has squared
            // weights.
            let squares = moments.squares_left(pass, &so_far).smoothed(sigma * 0.5_f64.sqrt());
            let found = mean_of(&difference.smoothed(sigma), &light);
            let per_probe = |cell: usize| 1.0 / count.of(cell).max(1e-9);
            let detail = found.like(|cell| {
                let detail = (found.of(cell) - so_far.of(cell)) * light.of(cell) * per_probe(cell);
                mean(detail * detail)
            });
            let noise = squares.like(|cell| mean(squares.of(cell)) * per_probe(cell).powi(2));
            let (detail, noise) = (detail.smoothed(COMPARED * sigma), noise.smoothed(COMPARED * sigma));
            let signal = detail.like(|cell| {
                let (detail, noise) = (detail.of(cell), noise.of(cell));
                if detail > noise { 1.0 - noise / detail } else { 0.0 }
            });
            so_far = so_far.like(|cell| {
                let so_far = so_far.of(cell);
                so_far + signal.of(cell) * (found.of(cell) - so_far)
            });
            scheme.levels.push(Level { sigma, light, signal });
        }
        scheme
    }

    /// Relative corrections of the light, from a part of the probes that the scheme was made from. All probes
    /// are `times` as many.
    pub(super) fn shares(&self, moments: &Moments, times: f64) -> Map<Rgb> {
        let difference = moments.difference(self.pass);
        let nearer = |so_far: Map<Rgb>, level: &Level| {
            let found = mean_of(&difference.smoothed(level.sigma), &level.light);
            found.like(|cell| {
                let so_far = so_far.of(cell);
                (so_far + level.signal.of(cell) * (times * found.of(cell) - so_far)).max(Rgb::splat(LEAST))
            })
        };
        let none = Map::filled(difference.shape, Rgb::ZERO);
        let Some((whole, parts)) = self.levels.split_first() else { return none };
        let whole = nearer(none, whole);
        let parts = parts.iter().fold(whole.clone(), nearer);
        let grid = moments.grid(self.pass);
        let lost = grid.like(|cell| grid.of(cell) * (whole.of(cell) - parts.of(cell)));
        let lost = ratio(lost.sum(), grid.sum());
        parts.like(|cell| (parts.of(cell) + lost).max(Rgb::splat(LEAST)))
    }
}

/// A sum over that of the light; 0 where there is no light.
fn mean_of(sum: &Map<Rgb>, light: &Map<Rgb>) -> Map<Rgb> {
    sum.like(|cell| ratio(sum.of(cell), light.of(cell)))
}

fn ratio(sum: Rgb, light: Rgb) -> Rgb {
    let of_channel = |sum: f64, light: f64| if light > 0.0 { sum / light } else { 0.0 };
    Rgb::new(of_channel(sum.x, light.x), of_channel(sum.y, light.y), of_channel(sum.z, light.z))
}

/// Mean of the colour channels.
pub(super) fn mean(value: Rgb) -> f64 {
    value.element_sum() / 3.0
}

/// Relative correction of indirect light, by pass.
pub(super) struct Correction {
    /// The whole picture.
    pub(super) size: Size,
    pub(super) shares: [Map<Rgb>; PASSES],
}

impl Correction {
    /// Corrects the indirect light of a sample at a place of the picture, in pixels. Changes of a part of the
    /// light are added to all sums that include the part.
    pub(super) fn apply(&self, sample: &mut Sample, film_px: DVec2) {
        let place = film_px / DVec2::new(self.size.width as f64, self.size.height as f64);
        let between = self.shares[0].shape.about(place);
        let [of_surfaces, of_fog] = self.shares.each_ref().map(|shares| shares.between(&between));
        let (on_surfaces, in_fog) = (of_surfaces * sample.indirect, of_fog * sample.indirect_shafts);
        sample.radiance += on_surfaces + in_fog;
        sample.indirect += on_surfaces;
        sample.shafts += in_fog;
        sample.indirect_shafts += in_fog;
    }
}
