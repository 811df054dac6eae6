//! Options for loading a scene. In go choices, out come settings for the default camera and light. Invariant:
//! options that are not set leave the input's own values.

use super::{FrameRate, RenderSettings, Size};

/// Photometric units of a glTF file's lights, which the file does not name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "program", derive(clap::ValueEnum))]
#[non_exhaustive]
pub enum LightUnits {
    /// Lux and candela (Blender's default export): W = value / 683.
    Spec,
    /// Blender's "Unitless": W/m^2 and W/sr as they stand.
    Compat,
    /// Blender's "Raw": sun in W/m^2, point and spot in W of radiant power over 4 pi sr.
    Raw,
}

/// Options for resolving an input.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ResolveOptions {
    /// Units of a glTF file's lights, in place of those in its extras.
    pub light_units: Option<LightUnits>,
    /// Animations of a glTF file to play, in place of the sequence's: a name, a number from 0, or `all`.
    pub animation: Option<String>,
    /// Adds no default light.
    pub no_default_light: bool,
    /// Keeps suns in the picture of a sky, and makes no lights of them.
    pub keep_sky_suns: bool,
    /// Size of the picture in place of the input's, for the default camera and light.
    pub size: Option<Size>,
    /// See `size`.
    pub frame_rate: Option<FrameRate>,
    /// See `size`.
    pub camera: Option<String>,
}

impl ResolveOptions {
    /// The input's settings with these options, for the default camera and light.
    pub(crate) fn overrule(&self, settings: &RenderSettings) -> RenderSettings {
        RenderSettings {
            size: self.size.unwrap_or(settings.size),
            frame_rate: self.frame_rate.unwrap_or(settings.frame_rate),
            camera: self.camera.clone().or(settings.camera.clone()),
            ..settings.clone()
        }
    }
}
