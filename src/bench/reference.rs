//! The reference picture. In goes a snapshot, out comes a converged frame with its own noise. Invariant: its
//! method has no bias, and its random numbers are in no measured picture.

use super::brute_force::{self, Deviation};
use super::error::{colors, mean};
use super::{Effort, Method, Stage};
use crate::film::Frame;
use glam::DVec3;
use std::fmt;

/// Seeds of the two halves and of the checked rays; measured pictures have the sequence's seed, mostly 0.
const HALVES: [u32; 2] = [0x5eed_0a11, 0x5eed_0b22];
const CHECK: u32 = 0x5eed_0c33;

/// Maximum number of triangle tests by brute force, over all rays: a few seconds.
const MOST_TESTS: usize = 200_000_000;

/// A converged picture.
pub struct Reference {
    /// The picture.
    pub frame: Frame,
    /// Samples a pixel and the method; `None` if it was read from a file.
    pub samples: Option<(u32, Method)>,
    /// Root mean square of its standard error, relative to the mean.
    pub noise: f64,
    /// Deviations of its method from brute force, for each light; none without fog.
    pub deviations: Vec<Deviation>,
}

impl Reference {
    /// Renders both halves with `samples / 2` a pixel each; their difference is the noise.
    pub fn render(stage: &Stage, samples: u32) -> Self {
        let half = Effort::of_samples((samples / 2).max(2));
        let method = stage.unbiased();
        let [mut frame, other] = HALVES.map(|seed| method.picture(stage, half, seed));
        let square: f64 = colors(&frame).zip(colors(&other)).map(|(a, b)| (a - b) * (a - b)).sum();
        let values = colors(&frame).count() as f64;
        for channel in &mut frame.channels {
            let Some(other) = other.channel(&channel.name) else { continue };
            for (value, other) in channel.pixels.iter_mut().zip(&other.pixels) {
                *value = 0.5 * (*value + other);
            }
        }
        // The variance of the mean of two is a quarter of that of their difference.
        let noise = 0.5 * (square / values).sqrt() / mean(&frame);
        Self { frame, samples: Some((2 * half.samples, method)), noise, deviations: Vec::new() }
    }

    /// A given picture, with the root mean square of its standard error.
    pub fn known(frame: Frame, standard_error: f64) -> Self {
        let noise = standard_error / mean(&frame);
        Self { frame, samples: None, noise, deviations: Vec::new() }
    }

    /// Mean of all values.
    pub fn mean(&self) -> f64 {
        mean(&self.frame)
    }

    /// Checks the exact method against brute force, on a few hundred rays a light.
    pub fn check(&mut self, stage: &Stage, triangles: &[[DVec3; 3]]) {
        if stage.snapshot().medium.is_empty() || triangles.is_empty() {
            return;
        }
        let rays = (MOST_TESTS / triangles.len()).clamp(16, 512) as u32;
        let lights = stage.snapshot().lights.iter();
        self.deviations = lights
            .map(|light| brute_force::deviation(stage.snapshot(), triangles, light, rays, CHECK))
            .filter(|deviation| deviation.rays > 0)
            .collect();
    }

    /// An error without the reference's own noise; `None` where the noise is most of it.
    pub fn net(&self, rmse: f64) -> Option<f64> {
        const TELLS: f64 = 1.2;
        (rmse > TELLS * self.noise).then(|| (rmse * rmse - self.noise * self.noise).sqrt())
    }
}

impl fmt::Display for Reference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.samples {
            Some((samples, Method::Paths)) => {
                write!(f, "reference: {samples} samples a pixel, by random walks")?;
            }
            Some((samples, _)) => write!(f, "reference: {samples} samples a pixel, ray by ray")?,
            None => write!(f, "reference: from a file")?,
        }
        write!(f, "; its noise {:.3} %", 100.0 * self.noise)?;
        if let Some(worst) = self.deviations.iter().max_by(|a, b| a.relative_rmse.total_cmp(&b.relative_rmse))
        {
            write!(f, "; {} rays against brute force in f64: {:.0e}", worst.rays, worst.relative_rmse)?;
        }
        Ok(())
    }
}
