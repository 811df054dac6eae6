//! Correction of the grid's indirect light by random walks, smoothed over the picture. In go sums over the
//! probes of two halves, out come relative corrections of each pass, place by place. Invariant: corrections
//! are continuous, from place to place and as noise falls.
//!
//! The grid errs most where its light has edges, and its error may change sign there. So the relative
//! difference is fitted by the grid's light of both passes, which has no noise, by local linear regression
//! (He, Sun & Tang 2010, "Guided image filtering"; Bitterli and others 2016, "Nonlinearly weighted
//! first-order regression for denoising Monte Carlo renderings"). Estimates are such fits, and means, over
//! surroundings of several sizes. Dark places are changed little. Errors of estimates are measured in means
//! over blocks, by cross-validation: an estimate from one half of the walks beside the other half. They are
//! mixed by exponential weights (Leung & Barron 2006, "Information theory and mixing least-squares
//! regressions"). Mixed parts no longer add up to the whole, so that the difference is shared among them
//! evenly: benchmarking of small area estimates (Pfeffermann 2013, "New important developments in small area
//! estimation").

use super::map::Map;
use super::moments::Moments;
use super::probes::PASSES;
use crate::color::Rgb;
use crate::scene::Size;
use crate::transport::Sample;
use glam::{DMat3, DVec2, DVec3};

/// Standard deviations of the surroundings, in cells.
const SURROUNDINGS: [f64; 4] = [8.0, 4.0, 2.0, 1.0];
/// Standard deviation of the surroundings in which errors of estimates are compared, in cells.
const COMPARED: f64 = 6.0;
/// Excess of an estimate's error, as a share of the noise of blocks, at which its weight is 1/e.
const MIXED: f64 = 0.1;
/// Penalty on slopes in relation to light: ridge regression (Hoerl & Kennard 1970).
const RIDGE: f64 = 1e-3;
/// Standard deviation of a cell's neighbours, in cells, and how many of its own probes their mean is worth.
const NEIGHBOURS: f64 = 1.0;
const FEW: f64 = 2.0;
/// Minimum correction: with less, light would be black or negative.
const LEAST: f64 = -0.95;

/// Relative corrections by each half of the walks. They share the weights of estimates.
pub(super) fn by_halves(halves: &[Moments; 2], near_cells: f64) -> [[Map<Rgb>; PASSES]; 2] {
    let all = halves[0].with(&halves[1]);
    let guides: [Map<Rgb>; PASSES] = std::array::from_fn(|pass| guide(&all, pass));
    let by_pass: [[Map<Rgb>; 2]; PASSES] = std::array::from_fn(|pass| {
        let grid = all.grid(pass);
        // All probes are twice as many as those of a half.
        let differences = halves.each_ref().map(|half| {
            let difference = half.difference(pass);
            difference.like(|cell| 2.0 * difference.of(cell))
        });
        let estimates = estimates(&grid, &guides, &differences);
        let blocks = Blocks { near_cells, count: all.count().smoothed(near_cells) };
        let weights = blocks.weights(&grid, &estimates, &differences);
        [0, 1].map(|half| mixed(&grid, &weights, &estimates[half], &differences[half]))
    });
    [0, 1].map(|half| by_pass.each_ref().map(|of_halves| of_halves[half].clone()))
}

/// The grid's light of a pass, by itself and its mean over the picture: from 0 in the dark to 1. Where probes
/// are few, it is their neighbours'.
fn guide(all: &Moments, pass: usize) -> Map<Rgb> {
    let (count, grid) = (all.count(), all.grid(pass));
    let mean = grid.sum() / count.sum().max(f64::MIN_POSITIVE);
    let (counts, sums) = (count.smoothed(NEIGHBOURS), grid.smoothed(NEIGHBOURS));
    grid.like(|cell| {
        let light = grid.of(cell) + FEW * sums.of(cell) / counts.of(cell).max(f64::MIN_POSITIVE);
        ratio(light, light + mean * (count.of(cell) + FEW))
    })
}

/// Estimates of relative corrections, by each of two differences: none, that of the whole picture, and means
/// and fits over surroundings.
fn estimates(
    grid: &Map<Rgb>,
    guides: &[Map<Rgb>; PASSES],
    differences: &[Map<Rgb>; 2],
) -> [Vec<Map<Rgb>>; 2] {
    let mut estimates = differences.each_ref().map(|difference| {
        let whole = ratio(difference.sum(), grid.sum());
        vec![Map::filled(grid.shape, Rgb::ZERO), Map::filled(grid.shape, whole)]
    });
    for sigma in SURROUNDINGS {
        let (light, weights) = (grid.smoothed(sigma), fit(grid, guides, sigma));
        for (estimates, difference) in estimates.iter_mut().zip(differences) {
            let times = |guide: &Map<Rgb>| difference.like(|cell| difference.of(cell) * guide.of(cell));
            let [one, other] = guides.each_ref().map(|guide| times(guide).smoothed(sigma));
            let sums = [difference.smoothed(sigma), one, other];
            let fitted = |cell: usize| -> Rgb {
                weights.iter().zip(&sums).map(|(weight, sum)| weight.of(cell) * sum.of(cell)).sum()
            };
            estimates.push(grid.like(|cell| ratio(sums[0].of(cell), light.of(cell))));
            estimates.push(grid.like(fitted));
        }
    }
    estimates
}

/// Weights of a linear fit by least squares, relative to the grid's light. It adds up sums over surroundings:
/// of the difference, and of the difference times each guide.
fn fit(grid: &Map<Rgb>, guides: &[Map<Rgb>; PASSES], sigma: f64) -> [Map<Rgb>; 1 + PASSES] {
    let [one, other] = guides;
    let sums = |value: &dyn Fn(usize) -> Rgb| grid.like(|cell| grid.of(cell) * value(cell)).smoothed(sigma);
    let light = grid.smoothed(sigma);
    let firsts = [sums(&|cell| one.of(cell)), sums(&|cell| other.of(cell))];
    let seconds = [
        sums(&|cell| one.of(cell) * one.of(cell)),
        sums(&|cell| one.of(cell) * other.of(cell)),
        sums(&|cell| other.of(cell) * other.of(cell)),
    ];
    // Of each channel, the solution of the normal equations for the values in a cell.
    let solved = light.like(|cell| {
        let (light, ridge) = (light.of(cell), RIDGE * light.of(cell));
        let [first, last] = firsts.each_ref().map(|sums| sums.of(cell));
        let [own, mixed, others] = seconds.each_ref().map(|sums| sums.of(cell));
        let weights = [0, 1, 2].map(|channel| {
            let normal = DMat3::from_cols(
                DVec3::new(light[channel], first[channel], last[channel]),
                DVec3::new(first[channel], own[channel] + ridge[channel], mixed[channel]),
                DVec3::new(last[channel], mixed[channel], others[channel] + ridge[channel]),
            );
            let weights = normal.inverse() * DVec3::new(1.0, one.of(cell)[channel], other.of(cell)[channel]);
            // There is nothing to fit where there is no light.
            if weights.is_finite() { weights } else { DVec3::ZERO }
        });
        DMat3::from_cols(weights[0], weights[1], weights[2]).transpose()
    });
    std::array::from_fn(|term| solved.like(|cell| solved.of(cell).col(term)))
}

/// Estimates mixed by their weights, with the difference of the whole picture.
fn mixed(grid: &Map<Rgb>, weights: &[Map<f64>], estimates: &[Map<Rgb>], difference: &Map<Rgb>) -> Map<Rgb> {
    let parts = grid.like(|cell| -> Rgb {
        weights.iter().zip(estimates).map(|(weight, estimate)| weight.of(cell) * estimate.of(cell)).sum()
    });
    let sum = grid.like(|cell| parts.of(cell) * grid.of(cell)).sum();
    let lost = ratio(difference.sum() - sum, grid.sum());
    parts.like(|cell| (parts.of(cell) + lost).max(Rgb::splat(LEAST)))
}

/// Means over blocks of pixels.
struct Blocks {
    /// Standard deviation of a Gaussian as wide as a block, in cells.
    near_cells: f64,
    /// Number of probes.
    count: Map<f64>,
}

impl Blocks {
    /// Means, from sums over probes.
    fn means(&self, sums: &Map<Rgb>) -> Map<Rgb> {
        let sums = sums.smoothed(self.near_cells);
        sums.like(|cell| sums.of(cell) / self.count.of(cell).max(f64::MIN_POSITIVE))
    }

    /// Weights of estimates, cell by cell, by their errors in means over blocks.
    fn weights(
        &self,
        grid: &Map<Rgb>,
        [ones, others]: &[Vec<Map<Rgb>>; 2],
        differences: &[Map<Rgb>; 2],
    ) -> Vec<Map<f64>> {
        let square = |difference: Rgb| mean(difference * difference);
        let [one, other] = differences.each_ref().map(|difference| self.means(difference));
        let noise = one.like(|cell| 0.5 * MIXED * square(one.of(cell) - other.of(cell))).smoothed(COMPARED);
        let added = |share: &Map<Rgb>| self.means(&grid.like(|cell| share.of(cell) * grid.of(cell)));
        let errors = ones.iter().zip(others).map(|(by_one, by_other)| {
            let [by_one, by_other] = [by_one, by_other].map(added);
            let error = |cell: usize| {
                square(by_one.of(cell) - other.of(cell)) + square(by_other.of(cell) - one.of(cell))
            };
            one.like(|cell| 0.5 * error(cell)).smoothed(COMPARED)
        });
        let errors: Vec<Map<f64>> = errors.collect();
        let least = one.like(|cell| errors.iter().map(|map| map.of(cell)).fold(f64::INFINITY, f64::min));
        let weight = |errors: &Map<f64>| {
            errors.like(|cell| {
                let excess = errors.of(cell) - least.of(cell);
                (-excess / noise.of(cell).max(f64::MIN_POSITIVE)).exp()
            })
        };
        let weights: Vec<Map<f64>> = errors.iter().map(weight).collect();
        let all = one.like(|cell| weights.iter().map(|map| map.of(cell)).sum::<f64>());
        weights.iter().map(|map| map.like(|cell| map.of(cell) / all.of(cell))).collect()
    }
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

#[cfg(test)]
mod tests {
    use super::super::map::Shape;
    use super::super::probes::Probe;
    use super::*;
    use crate::transport::Noted;

    /// Where the grid's light has an edge at which its error changes sign, each side has its own correction.
    #[test]
    fn a_correction_changes_its_sign_at_an_edge() {
        let shape = Shape { columns: 48, rows: 28 };
        let mut halves = [Moments::none(shape), Moments::none(shape)];
        for number in 0..16 * shape.count() {
            let (column, row) = (number % shape.columns, number / shape.columns % shape.rows);
            let (grid, walk) = if column < 24 { (1.0, 1.3) } else { (3.0, 2.4) };
            let noise = 2.0 * ((12.9898 * number as f64).sin() * 43758.5453).rem_euclid(1.0) - 1.0;
            let cell = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
            halves[number / shape.count() % 2].add(&Probe {
                place: cell / DVec2::new(shape.columns as f64, shape.rows as f64),
                weight: 1.0,
                walk: [Rgb::splat(walk + grid * noise), Rgb::ZERO],
                grid: [Rgb::splat(grid), Rgb::ZERO],
                drawn: 1,
                noted: Noted::default(),
            });
        }
        let of_halves = by_halves(&halves, 1.0);
        for (column, right) in [(23, 0.3), (24, -0.2)] {
            let cell = column + 14 * shape.columns;
            let found = of_halves.iter().map(|shares| 0.5 * shares[0].of(cell).x).sum::<f64>();
            assert!((found - right).abs() < 0.05, "{column}: {found}");
        }
    }
}
