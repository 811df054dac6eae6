//! Correction of the grid's indirect light by random walks, smoothed over the picture. In go sums over
//! probes, out comes by which share of itself each pass's light is to grow where. Invariant: what is no
//! more than noise changes nothing, and the share has no jumps, neither from place to place nor as noise
//! falls.
//!
//! Shares are means of ever smaller surroundings. Each is shrunk towards the next larger by how much of
//! their difference is noise (James & Stein 1961, "Estimation with quadratic loss"). Donoho & Johnstone
//! 1995 do so level by level ("Adapting to unknown smoothness via wavelet shrinkage"). A share of the
//! light is smooth across edges, and light itself is not. Dark places get little.

use super::map::Map;
use super::moments::Moments;
use super::probes::PASSES;
use crate::color::Rgb;
use crate::film::Frame;
use glam::DVec2;

/// Standard deviations of the surroundings, in cells.
const LEVELS: [f64; 6] = [f64::INFINITY, 12.0, 6.0, 3.0, 1.5, 0.6];
/// Standard deviation of the surroundings over which signal and noise are compared, over that of the
/// means.
const COMPARED: f64 = 4.0;
/// Times the noise: what is above it counts as signal. By chance it is above once in a few places.
const CAUTION: f64 = 1.5;
/// No pass loses more of its light: it would be black or negative.
const LEAST: f64 = -0.95;

/// Weights of the means over surroundings of one size.
struct Level {
    sigma: f64,
    /// The grid's light, summed over them.
    light: Map<Rgb>,
    /// Share of what they differ by that is no noise.
    signal: Map<f64>,
}

/// Weights by which means are added up, in one pass.
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
        let mut so_far = Map::filled(Rgb::ZERO);
        for sigma in LEVELS {
            let light = grid.smoothed(sigma);
            let count = count.smoothed(sigma);
            // Weights of a mean's variance are squares of its own.
            let squares = moments.squares_left(pass, &so_far).smoothed(sigma * 0.5_f64.sqrt());
            let found = mean_of(&difference.smoothed(sigma), &light);
            let per_probe = |cell: usize| 1.0 / count.of(cell).max(1e-9);
            let detail = Map::from_fn(|cell| {
                let detail = (found.of(cell) - so_far.of(cell)) * light.of(cell) * per_probe(cell);
                mean(detail * detail)
            });
            let noise = Map::from_fn(|cell| mean(squares.of(cell)) * per_probe(cell).powi(2));
            let (detail, noise) = (detail.smoothed(COMPARED * sigma), noise.smoothed(COMPARED * sigma));
            let signal = Map::from_fn(|cell| {
                let (detail, noise) = (detail.of(cell), CAUTION * noise.of(cell));
                if detail > noise { 1.0 - noise / detail } else { 0.0 }
            });
            so_far = Map::from_fn(|cell| {
                let so_far = so_far.of(cell);
                so_far + signal.of(cell) * (found.of(cell) - so_far)
            });
            scheme.levels.push(Level { sigma, light, signal });
        }
        scheme
    }

    /// Shares by which the light is to grow, from a part of the probes that the scheme was made from; `times`
    /// as many are all.
    pub(super) fn shares(&self, moments: &Moments, times: f64) -> Map<Rgb> {
        let difference = moments.difference(self.pass);
        self.levels.iter().fold(Map::filled(Rgb::ZERO), |so_far, level| {
            let found = mean_of(&difference.smoothed(level.sigma), &level.light);
            Map::from_fn(|cell| {
                let so_far = so_far.of(cell);
                (so_far + level.signal.of(cell) * (times * found.of(cell) - so_far)).max(Rgb::splat(LEAST))
            })
        })
    }
}

/// A sum by the light that it is a sum over; 0 where there is none.
fn mean_of(sum: &Map<Rgb>, light: &Map<Rgb>) -> Map<Rgb> {
    let ratio = |sum: f64, light: f64| if light > 0.0 { sum / light } else { 0.0 };
    Map::from_fn(|cell| {
        let (sum, light) = (sum.of(cell), light.of(cell));
        Rgb::new(ratio(sum.x, light.x), ratio(sum.y, light.y), ratio(sum.z, light.z))
    })
}

/// Mean of the colour channels.
pub(super) fn mean(value: Rgb) -> f64 {
    value.element_sum() / 3.0
}

/// Share of itself by which indirect light is to grow, by pass.
pub(super) struct Correction(pub(super) [Map<Rgb>; PASSES]);

impl Correction {
    /// Puts it into a frame that has the passes of indirect light. What is added to a part of the light is
    /// added to all that it is a part of.
    pub(super) fn apply(&self, frame: &mut Frame) {
        /// The first letters of a pass's channels, and of those that it is a part of.
        const CHANNELS: [(&str, &[&str]); PASSES] =
            [("indirect.", &[""]), ("indirect_shafts.", &["shafts.", ""])];
        let (full, window) = (frame.full, frame.window);
        for ((part, wholes), share) in CHANNELS.iter().zip(&self.0) {
            let number = |first: &str, letter: &str| {
                let name = format!("{first}{letter}");
                frame.channels.iter().position(|channel| channel.name == name)
            };
            let parts = ["R", "G", "B"].map(|letter| number(part, letter));
            let wholes = ["R", "G", "B"]
                .map(|letter| wholes.iter().filter_map(|first| number(first, letter)).collect::<Vec<_>>());
            for (pixel, (x, y)) in window.pixels().enumerate() {
                let place = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let share = share.at(place / DVec2::new(full.width as f64, full.height as f64));
                for (index, (part, wholes)) in parts.iter().zip(&wholes).enumerate() {
                    let Some(part) = *part else { continue };
                    let added = (share[index] * f64::from(frame.channels[part].pixels[pixel])) as f32;
                    for channel in wholes.iter().chain([&part]) {
                        frame.channels[*channel].pixels[pixel] += added;
                    }
                }
            }
        }
    }
}
