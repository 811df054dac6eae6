//! What surfaces do to light on its way from order to order. In go points of surfaces, out come shares.
//! Invariant: what shines counts as matte, and no share is above 1.

use crate::accel::PrimitiveId;
use crate::color::Rgb;
use crate::math::Ray;
use crate::snapshot::{Snapshot, SurfacePoint};
use glam::DVec3;

/// What becomes of light that meets a surface, and what it adds.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Scatters {
    /// Share that comes back.
    pub(super) reflectance: Rgb,
    /// Share that comes through.
    pub(super) transmittance: Rgb,
    /// Emitted radiance.
    pub(super) emission: Rgb,
    /// Share that does not pass as if there were nothing.
    pub(super) cover: f64,
}

impl Scatters {
    /// Share that is not absorbed.
    pub(super) fn sent(&self) -> Rgb {
        self.reflectance + self.transmittance
    }

    /// What gets away of it from a leaf that is bent: what meets that again is scattered again.
    pub(super) fn out_of_bent(&self, exposed: f64) -> Self {
        let out = gets_out(exposed, self.sent());
        Self {
            reflectance: out * self.reflectance,
            transmittance: out * self.transmittance,
            emission: out * self.emission,
            cover: self.cover,
        }
    }
}

/// The share of light scattered among things that gets out, where each time a `share` does and things send
/// on an `albedo`: `q / (1 - (1 - q) a)`, the sum of a geometric series.
pub(super) fn gets_out(share: f64, albedo: Rgb) -> Rgb {
    share / (Rgb::ONE - (1.0 - share) * albedo.min(Rgb::ONE))
}

/// What several places do together, each by its area, and in colours as much as it covers.
#[derive(Default)]
pub(super) struct MeanScatters {
    sum: Scatters,
    area: f64,
}

impl MeanScatters {
    pub(super) fn add(&mut self, area: f64, scatters: &Scatters) {
        let covered = area * scatters.cover;
        self.sum.reflectance += covered * scatters.reflectance;
        self.sum.transmittance += covered * scatters.transmittance;
        self.sum.emission += covered * scatters.emission;
        self.sum.cover += covered;
        self.area += area;
    }

    pub(super) fn mean(&self) -> Scatters {
        let [per_cover, per_area] =
            [self.sum.cover, self.area].map(|sum| if sum > 0.0 { 1.0 / sum } else { 0.0 });
        Scatters {
            reflectance: per_cover * self.sum.reflectance,
            transmittance: per_cover * self.sum.transmittance,
            emission: per_cover * self.sum.emission,
            cover: per_area * self.sum.cover,
        }
    }
}

/// What a surface does to light on the side that `normal` faces, at a place of world space.
pub(super) fn scatters(
    snapshot: &Snapshot,
    primitive: PrimitiveId,
    position: DVec3,
    normal: DVec3,
) -> Scatters {
    let towards = Ray { origin: position + normal - snapshot.view.eye, direction: -normal };
    scatters_of(&snapshot.facet(primitive).seen_along(&towards, 1.0))
}

/// The same of a point.
pub(super) fn scatters_of(point: &SurfacePoint) -> Scatters {
    Scatters {
        reflectance: reflectance(point),
        transmittance: point.transmission,
        emission: point.emission,
        cover: 1.0 - (1.0 - point.alpha).clamp(0.0, 1.0),
    }
}

/// All that comes back, whatever way: what shines counts as matte.
pub(super) fn reflectance(point: &SurfacePoint) -> Rgb {
    /// About where most light falls and most is seen.
    const COS: f64 = 0.6;
    let coat = point.gloss.as_ref().map_or(Rgb::ZERO, |gloss| gloss.albedo(COS));
    (point.albedo * (Rgb::ONE - coat) + coat + point.mirror).clamp(Rgb::ZERO, Rgb::ONE)
}
