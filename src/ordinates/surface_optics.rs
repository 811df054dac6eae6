//! Optical properties of surfaces. In go shares of light, out come their means. Invariant: they are
//! independent of the object that has the surface.

use crate::color::Rgb;

/// Reflectance, transmittance and emission of a surface.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SurfaceOptics {
    /// Hemispherical reflectance.
    pub(crate) reflectance: Rgb,
    /// Hemispherical transmittance.
    pub(crate) transmittance: Rgb,
    /// Emitted radiance.
    pub(crate) emission: Rgb,
    /// Share that passes straight through, beyond that which passes in all channels, as in coloured glass.
    pub(crate) straight: Rgb,
    /// Coverage: the share that does not pass straight through in all channels.
    pub(crate) cover: f64,
}

impl SurfaceOptics {
    /// Share that is scattered.
    pub(crate) fn albedo(&self) -> Rgb {
        self.reflectance + self.transmittance
    }

    /// Share of light from all sides that leaves on the other side.
    pub(crate) fn through(&self) -> Rgb {
        self.transmittance + self.straight
    }
}

/// Mean over places, weighted by area; that of colours by area times coverage.
#[derive(Default)]
pub(crate) struct MeanOptics {
    sum: SurfaceOptics,
    area: f64,
}

impl MeanOptics {
    pub(crate) fn add(&mut self, area: f64, optics: &SurfaceOptics) {
        let covered = area * optics.cover;
        self.sum.reflectance += covered * optics.reflectance;
        self.sum.transmittance += covered * optics.transmittance;
        self.sum.emission += covered * optics.emission;
        self.sum.straight += covered * optics.straight;
        self.sum.cover += covered;
        self.area += area;
    }

    pub(crate) fn mean(&self) -> SurfaceOptics {
        let [per_cover, per_area] =
            [self.sum.cover, self.area].map(|sum| if sum > 0.0 { 1.0 / sum } else { 0.0 });
        SurfaceOptics {
            reflectance: per_cover * self.sum.reflectance,
            transmittance: per_cover * self.sum.transmittance,
            emission: per_cover * self.sum.emission,
            straight: per_cover * self.sum.straight,
            cover: per_area * self.sum.cover,
        }
    }
}
