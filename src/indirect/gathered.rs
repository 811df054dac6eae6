//! Radiance from all sides at a place. In go harmonics of radiance, out comes the light that a lobe gathers.
//! Invariant: that light is never negative.

use super::lobe::Lobe;
use crate::canopy::clumps::Clump;
use crate::canopy::fluence::Peak;
use crate::color::Rgb;
use crate::ordinates::harmonics::{COUNT, product};

/// Radiance on one side of a leaf, as moments.
pub(super) struct Gathered {
    pub(super) moments: [[f32; COUNT]; 3],
    /// Moments of degree 4.
    pub(super) fourth: [[f32; COUNT]; 3],
    /// Forward peak of each sun.
    pub(super) peaks: Vec<Peak>,
    pub(super) clump: Clump,
}

impl Gathered {
    pub(super) const NOTHING: Self =
        Self { moments: [[0.0; COUNT]; 3], fourth: [[0.0; COUNT]; 3], peaks: Vec::new(), clump: Clump::NONE };

    /// Light that a lobe gathers; for a cosine lobe, irradiance, W/m^2.
    pub(super) fn by(&self, lobe: &Lobe) -> Rgb {
        // A leaf's specular lobe uses harmonics up to l = 2 alone.
        let lobe = &if lobe.has_third() { lobe.up_to_second() } else { *lobe };
        let beyond = lobe.of_fourth_of_travel().map_or(Rgb::ZERO, |of| product(&of, &self.fourth));
        let irradiance = product(&lobe.of_travel(), &self.moments) + beyond;
        with_peaks(irradiance, self.peaks.iter().copied(), lobe)
    }
}

/// Sum of the light that a lobe gathers by harmonics and from forward peaks.
pub(super) fn with_peaks(by_harmonics: Rgb, peaks: impl Iterator<Item = Peak>, lobe: &Lobe) -> Rgb {
    peaks.fold(by_harmonics.max(Rgb::ZERO), |irradiance, peak| {
        irradiance + lobe.of_peak(peak.travel) * peak.irradiance
    })
}
