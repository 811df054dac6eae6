//! Fog and sky, for programs that make scenes. In go numbers, out come the fields of a file. Invariant:
//! names, units and ranges are those of docs/scene-format.md.

use super::animated::Animated;
use serde::Serialize;
use std::path::PathBuf;

/// A bank of fog: in a box, thinner with height, or both; or as dense as voxels are.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fog {
    /// Name of the object that the fog follows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parent: Option<String>,
    /// The corner of its box with the smallest coordinates, in its parent's space.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_m: Option<[f64; 3]>,
    /// The corner with the largest coordinates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_m: Option<[f64; 3]>,
    /// The height over which its density falls to 1/e.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale_height_m: Option<Animated<f64>>,
    /// Where that begins: a y coordinate of its parent's space.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base_m: Option<f64>,
    /// An OpenVDB file that says how dense it is, in its parent's space.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vdb: Option<PathBuf>,
    /// The file's grid that does; none is `density`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid: Option<String>,
    /// Billows that it is made of, in its box.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mist: Option<Mist>,
    /// Extinction coefficient sigma_t where the fog is densest; of voxels that of 1 in them.
    pub density_per_m: Animated<[f64; 3]>,
    /// How much of the extinction is scattering, `0..=1`.
    pub albedo: Animated<[f64; 3]>,
    /// Henyey-Greenstein g; forward if positive.
    pub anisotropy: Animated<f64>,
}

impl Fog {
    /// Grey fog in a box, of an extinction a metre; it scatters all that it takes, to all sides alike.
    pub fn in_box(min_m: [f64; 3], max_m: [f64; 3], density_per_m: f64) -> Self {
        Self {
            parent: None,
            min_m: Some(min_m),
            max_m: Some(max_m),
            scale_height_m: None,
            base_m: None,
            vdb: None,
            grid: None,
            mist: None,
            density_per_m: Animated::Still([density_per_m; 3]),
            albedo: Animated::Still([1.0; 3]),
            anisotropy: Animated::Still(0.0),
        }
    }
}

/// Billows of mist that drift.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mist {
    /// How wide the largest are.
    pub size_m: f64,
    /// Sizes of billows, 1 to 8: each half of the one before.
    pub octaves: u32,
    /// The share of the box that they fill, `0..=1`.
    pub cover: Animated<f64>,
    /// What carries them.
    pub wind_m_per_s: Animated<[f64; 3]>,
    /// How often they have turned over.
    pub evolution_turns: Animated<f64>,
    /// Their form as a whole.
    pub shape: MistShape,
    /// Over how far that fades; none is half of `size_m`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edge_m: Option<f64>,
    /// Name of an object that heights count from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ground: Option<String>,
    /// Another seed, other billows.
    pub seed: u32,
    /// How far apart density is computed; none is as docs/scene-format.md says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub voxel_m: Option<f64>,
}

impl Mist {
    /// Four sizes of billows in still air, which fill half of a box.
    pub fn new(size_m: f64) -> Self {
        Self {
            size_m,
            octaves: 4,
            cover: Animated::Still(0.5),
            wind_m_per_s: Animated::Still([0.0; 3]),
            evolution_turns: Animated::Still(0.0),
            shape: MistShape::default(),
            edge_m: None,
            ground: None,
            seed: 0,
            voxel_m: None,
        }
    }
}

/// The form of mist in its box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum MistShape {
    /// All of it, faded at the sides and at the top.
    #[default]
    Box,
    /// What touches all of its sides, faded all around.
    Ellipsoid,
}

/// What lies behind the scene and lights it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Sky {
    /// The same everywhere.
    Constant {
        /// How bright it is.
        radiance_w_per_m2_sr: Animated<[f64; 3]>,
        /// What it lights.
        lights: SkyLight,
    },
    /// From the horizon up, and something else below.
    Gradient {
        /// Straight up.
        zenith_w_per_m2_sr: [f64; 3],
        /// Just above the horizon.
        horizon_w_per_m2_sr: [f64; 3],
        /// Below the horizon.
        ground_w_per_m2_sr: [f64; 3],
        /// Multiplies all of it.
        strength: Animated<[f64; 3]>,
        /// What it lights.
        lights: SkyLight,
    },
    /// An image of all directions.
    Image {
        /// Radiance HDR or OpenEXR, longitude across and latitude down.
        image: PathBuf,
        /// Radiance of what is 1 in the image.
        strength_w_per_m2_sr: Animated<[f64; 3]>,
        /// Turned about +y, anticlockwise as seen from above.
        rotation_deg: Animated<f64>,
        /// What it lights.
        lights: SkyLight,
    },
}

/// What a sky lights. It is seen in any case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum SkyLight {
    /// Nothing.
    Nothing,
    /// Surfaces.
    Surfaces,
    /// Surfaces and fog.
    #[default]
    SurfacesAndFog,
}
