//! Resolution of sums into a picture. In goes a film, out comes a frame of named channels, in the order in
//! which films keep their passes. Invariant: sums are divided by weights only here.

use super::frame::BEAUTY;
use super::hues::{self, HueSums};
use super::pixel_sum::value;
use super::smooth::{self, FogPlanes};
use super::{Channel, Film, Frame, Precision, holes, mattes};
use crate::color::Rgb;
use crate::passes::Pass;

impl Film {
    /// Pixels of the full picture without samples; [`Film::resolve`] would fill them from their neighbours.
    pub fn holes(&self) -> Vec<(usize, usize)> {
        let pixels = self.window.pixels().zip(&self.weights);
        pixels.filter(|(_, weight)| value(weight) == 0.0).map(|(pixel, _)| pixel).collect()
    }

    /// Finished picture; see [`Film::resolve`]. The film's memory is freed on the way.
    pub fn into_frame(mut self) -> Frame {
        let variances = self.noise_of_fog();
        self.fresh = Vec::new();
        let fog = variances.map(|variances| (self.fog_to_smooth(), variances));
        self.fog = Vec::new();
        let channels = self.channels();
        (self.sums, self.hues) = (Vec::new(), Vec::new());
        self.frame(channels, fog)
    }

    /// Colours so far, without passes, for observers.
    pub fn look(&self) -> Frame {
        let mut channels: Vec<Channel> = self.means().take(BEAUTY.len()).collect();
        self.correct(&mut channels, HueSums::missing);
        self.fill_from_neighbours(&mut channels, BEAUTY.len());
        self.frame(channels, self.noisy_fog())
    }

    /// Picture so far. Values are not clamped and NaN stays NaN; [`Frame::check`] finds them.
    pub fn resolve(&self) -> Frame {
        self.frame(self.channels(), self.noisy_fog())
    }

    /// Fog that is to be smoothed and how noisy it is; `None` if shafts are not smoothed.
    fn noisy_fog(&self) -> Option<(FogPlanes, Vec<f32>)> {
        self.noise_of_fog().map(|variances| (self.fog_to_smooth(), variances))
    }

    /// The variance of each pixel, NaN where nothing is known; `None` if shafts are not smoothed.
    fn noise_of_fog(&self) -> Option<Vec<f32>> {
        let variance = |pixel| self.estimate(pixel).and_then(|estimate| estimate.variance);
        let variances = self.window.pixels().map(|pixel| variance(pixel).unwrap_or(f64::NAN) as f32);
        (!self.fog.is_empty()).then(|| variances.collect())
    }

    fn fog_to_smooth(&self) -> FogPlanes {
        let mut fog = self.fog_planes(self.window);
        hues::correct(fog.shafts.iter_mut(), &self.hues, &self.weights, HueSums::missing_shafts);
        fog
    }

    fn frame(&self, channels: Vec<Channel>, fog: Option<(FogPlanes, Vec<f32>)>) -> Frame {
        let mut frame = Frame { full: self.full, window: self.window, channels };
        if let Some((fog, variances)) = fog {
            smooth::smooth(&mut frame, &fog, &variances);
        }
        frame
    }

    fn channels(&self) -> Vec<Channel> {
        let mut channels: Vec<Channel> = self.means().collect();
        let mean_channels = channels.len();
        self.correct(&mut channels, HueSums::missing);
        if let Some(number) = self.passes.mean.iter().position(|&pass| pass == Pass::Shafts) {
            self.correct(&mut channels[BEAUTY.len() + 3 * number..], HueSums::missing_shafts);
        }
        channels.extend(self.nearest());
        if self.passes.mattes {
            channels.extend(mattes::channels(&self.mattes, &self.weights));
        }
        self.fill_from_neighbours(&mut channels, mean_channels);
        channels
    }

    /// Adds the correction for hues to the first three channels.
    fn correct(&self, channels: &mut [Channel], missing: fn(&HueSums, f64) -> Rgb) {
        let planes = channels[..3].iter_mut().map(|channel| &mut channel.pixels);
        hues::correct(planes, &self.hues, &self.weights, missing);
    }

    fn fill_from_neighbours(&self, channels: &mut [Channel], mean_channels: usize) {
        let known = self.weights.iter().map(|weight| value(weight) != 0.0).collect();
        holes::fill(self.window, known, channels, mean_channels);
    }

    /// Beauty, and the passes that are averaged.
    fn means(&self) -> impl Iterator<Item = Channel> {
        let beauty = BEAUTY.into_iter().map(|name| (name, Precision::Half));
        let names = beauty.chain(names(&self.passes.mean)).enumerate();
        let mean = move |(offset, (name, precision))| {
            let sums = self.sums.iter().skip(offset).step_by(self.passes.mean_channels());
            let sums = sums.map(value).zip(self.weights.iter().map(value));
            let mean = |(sum, weight)| if weight == 0.0 { 0.0 } else { (sum / weight) as f32 };
            Channel::new(name, precision, sums.map(mean).collect())
        };
        names.map(mean)
    }

    /// Passes that show the nearest sample.
    fn nearest(&self) -> impl Iterator<Item = Channel> {
        let stride = self.passes.nearest_channels();
        names(&self.passes.nearest).enumerate().map(move |(offset, (name, precision))| {
            let pixels = self.nearest_values.iter().skip(offset).step_by(stride).copied().collect();
            Channel::new(name, precision, pixels)
        })
    }
}

fn names(passes: &[Pass]) -> impl Iterator<Item = (&'static str, Precision)> {
    let rows = passes.iter().map(|&pass| pass.row());
    rows.flat_map(|row| row.channels.iter().map(move |&name| (name, row.precision)))
}
