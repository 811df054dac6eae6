//! Options of whoever loads a scene. In go choices, out come the settings that a made-up camera and light
//! depend on. Invariant: a choice that is not made leaves what the input says.

use super::{FrameRate, RenderSettings, Size};

/// Which photometric units a glTF file's lights are in; the file does not say.
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

/// Options of whoever renders, beside what the input says itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ResolveOptions {
    /// Units of the lights of a glTF file, whatever it says.
    pub light_units: Option<LightUnits>,
    /// Animations of a glTF file that play, whatever its sequence says: a name, a number from 0, or `all`.
    pub animation: Option<String>,
    /// Leaves inputs dark that have no light.
    pub no_default_light: bool,
    /// Leaves suns in the picture of the sky that shows them.
    pub keep_sky_suns: bool,
    /// Size of the picture in place of the input's; a camera and light that are made up depend on it.
    pub size: Option<Size>,
    /// See `size`.
    pub frame_rate: Option<FrameRate>,
    /// See `size`.
    pub camera: Option<String>,
}

impl ResolveOptions {
    /// The input's settings as far as a made-up camera and light depend on them, as they are rendered.
    pub(crate) fn overrule(&self, settings: &RenderSettings) -> RenderSettings {
        RenderSettings {
            size: self.size.unwrap_or(settings.size),
            frame_rate: self.frame_rate.unwrap_or(settings.frame_rate),
            camera: self.camera.clone().or(settings.camera.clone()),
            ..settings.clone()
        }
    }
}
