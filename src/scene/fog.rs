//! Fog volumes. In go validated parameters, out come shapes and coefficients. Invariant: `density_per_m >=
//! 0`, albedo in `0..=1`, `|anisotropy| <= 0.9999`, scale heights above 0. Unbounded fog falls off with
//! height, as sunlight could not reach into it otherwise.

use super::grids::Between;
use super::{GridFrames, Mist, NodeIndex, Scene, Track};
use crate::color::Rgb;
use crate::diagnostic::{Diagnostic, Loss, Place};

/// Maximum number of fog volumes: sets of them are bit masks in the inner loops.
pub const MOST_FOGS: usize = 64;

/// Fog volume.
#[derive(Clone, Debug)]
pub struct Fog {
    /// The author's name.
    pub name: String,
    /// Node, whose transform leads from the shape's space to the world. It may be rotated, scaled and
    /// sheared, and may move.
    pub node: NodeIndex,
    /// Shape of the fog.
    pub shape: FogShape,
    /// Extinction sigma_t per channel where the fog is densest, 1/m: scattering plus absorption. For voxels,
    /// where they are 1.
    pub density_per_m: Track<Rgb>,
    /// Single-scattering albedo sigma_s / sigma_t per channel, `0..=1`.
    pub albedo: Track<Rgb>,
    /// Henyey-Greenstein g, at most 0.9999 in magnitude; forward for `g > 0`.
    pub anisotropy: Track<f64>,
}

/// Shape of fog. A new one is read in `scene/from_ron` and `scene/from_gltf`, frozen in `snapshot`, and
/// evaluated in `fog/bank.rs`.
#[derive(Clone, Debug)]
pub enum FogShape {
    /// The cube `[-1, 1]^3`, uniform.
    EvenBox,
    /// The cube `[-1, 1]^3`, falling off with height.
    ThinningBox(HeightFalloff),
    /// Unbounded, falling off with height.
    Layer(HeightFalloff),
    /// Grids of OpenVDB files, in the shape's space.
    Voxels(Box<GridFrames>),
    /// Drifting mist, in a box of the shape's space.
    Mist(Box<Mist>),
}

impl Fog {
    /// Extinction where keys make it largest, relative to that at a time, each in the channel where it is
    /// largest.
    pub fn densest(&self, time_s: f64) -> f64 {
        let now = self.density_per_m.at(time_s).max_element();
        let most = self.density_per_m.hull().into_iter().map(Rgb::max_element).fold(now, f64::max);
        if now > 0.0 { most / now } else { 1.0 }
    }
}

impl FogShape {
    /// Number of volumes as which it counts in the limit.
    pub fn most_banks(&self) -> usize {
        match self {
            // A scattering and an absorbing volume for each channel.
            Self::Voxels(grids) if grids.names.albedo.is_some() => 6,
            _ => 1,
        }
    }

    /// Whether it has emission.
    pub fn emits(&self) -> bool {
        matches!(self, Self::Voxels(grids) if grids.names.emission.is_some())
    }

    /// Falloff with height, if it has one.
    pub fn falloff(&self) -> Option<&HeightFalloff> {
        match self {
            Self::EvenBox | Self::Voxels(_) | Self::Mist(_) => None,
            Self::ThinningBox(falloff) | Self::Layer(falloff) => Some(falloff),
        }
    }
}

impl Scene {
    /// Warning about several grids with the name of one that is used.
    pub fn shared_grid_name(&self) -> Option<Diagnostic> {
        let shared = |fog: &Fog| {
            let FogShape::Voxels(grids) = &fog.shape else { return None };
            let (name, path) = (grids.shared_name.as_ref()?, grids.path.display());
            Some(format!("fog `{}`: {path} has several grids `{name}`, the first counts", fog.name))
        };
        let found = self.fogs.iter().find_map(shared)?;
        let remedy = "give each a name of its own where they are made";
        Some(Diagnostic::warning(Loss::SharedGridName, Place::Nowhere, found).remedy(remedy))
    }

    /// Warning about an open shutter with fog from files without velocities.
    pub fn held_fog(&self, shutter_frames: f64) -> Option<Diagnostic> {
        let held = |fog: &Fog| {
            let FogShape::Voxels(grids) = &fog.shape else { return None };
            let (why, remedy) = match grids.between() {
                Between::Carried => return None,
                Between::Held => (
                    "they have no velocities",
                    "write a grid of vectors `velocity`, m/s, into each file, or close the shutter",
                ),
                Between::CarriedTooFar => (
                    "velocities would carry it over 64 voxels",
                    "write files more often, with larger voxels or velocities in m/s, or close the shutter",
                ),
            };
            let found = format!("fog `{}` stays as it is half way to the next file: {why}", fog.name);
            (grids.frames.len() > 1).then_some((found, remedy))
        };
        let (found, remedy) = self.fogs.iter().find_map(held).filter(|_| shutter_frames > 0.0)?;
        Some(Diagnostic::warning(Loss::FogHeld, Place::Nowhere, found).remedy(remedy))
    }
}

/// Density proportional to `exp(-h / scale_height)` at a height h above a plane, and constant below it.
#[derive(Clone, Debug)]
pub struct HeightFalloff {
    /// The plane `y = base` of the shape's space. Heights are metres perpendicular to it.
    pub base: f64,
    /// Height over which density falls to 1/e.
    pub scale_height_m: Track<f64>,
}
