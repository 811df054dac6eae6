//! Flags that several commands have: how an input is read, and how pictures for eyes are made. Invariant:
//! they mean the same in every command.

use super::CliError;
use super::parse::{ExposureArgument, SizeArgument, parse_bloom, parse_exposure, parse_frame_rate};
use super::words::{SkySunArgument, Switch};
use clap::Args;
use std::path::PathBuf;
use sunfleck::color::{Bloom, Curve, Display, Look};
use sunfleck::diagnostic::Diagnostics;
use sunfleck::scene::{FrameRate, LightUnits, ResolveOptions};

/// How an input is read.
#[derive(Args, Clone, Debug, PartialEq)]
pub(super) struct SceneArguments {
    /// Frames a second, such as 24 or 24000/1001 [default: the input's, else 24].
    #[arg(long, value_parser = parse_frame_rate, allow_negative_numbers = true)]
    pub(super) fps: Option<FrameRate>,
    /// Units of the lights of a glTF file [default: what it says, else spec].
    #[arg(long, value_enum)]
    pub(super) light_units: Option<LightUnits>,
    /// Whether a glTF or OBJ file without light gets a sun and a sky [default: on; of export off].
    #[arg(long, value_enum, value_name = "on|off")]
    pub(super) default_light: Option<Switch>,
    /// Whether a sun in the picture of a sky lights as a `Sun` does, or as the rest of it [default: auto].
    #[arg(long, value_enum, value_name = "auto|off")]
    pub(super) sky_sun: Option<SkySunArgument>,
    /// Which animation of a glTF file plays: its name, its number from 0, or `all` [default: all that do not
    /// move the same things].
    #[arg(long, value_name = "NAME|all")]
    pub(super) animation: Option<String>,
    /// Refuse an input that asks for anything that is not honoured (exit code 3), and frames whose indirect
    /// light misses the tolerance by far (exit code 5).
    #[arg(long)]
    pub(super) strict: bool,
    #[command(flatten)]
    pub(super) bakes: BakeArguments,
}

/// Bakes of falls of many leaves, which take seconds.
#[derive(Args, Clone, Debug, PartialEq)]
pub(super) struct BakeArguments {
    /// Where baked falls are kept for the next time, or `off` [default: `sunfleck` in the
    /// user's folder of caches].
    #[arg(long, value_name = "FOLDER|off")]
    pub(super) bake_cache: Option<PathBuf>,
}

/// How pictures for eyes are made. EXR frames stay as they are.
#[derive(Args, Clone, Copy, Debug)]
pub(super) struct DisplayArguments {
    /// How light is brought into the range of a display, for pictures other than EXR.
    #[arg(long, value_enum, default_value_t, value_name = "CURVE")]
    pub(super) display: Curve,
    /// Contrast of those pictures under AgX, by Blender's look of this name [default: the input's, else
    /// none].
    #[arg(long, value_enum, value_name = "LOOK")]
    pub(super) look: Option<Look>,
    /// Brightens those pictures by so many powers of two, -100 to 100, or by what they need, auto [default:
    /// the input's, else auto].
    #[arg(long, value_parser = parse_exposure, value_name = "EV|auto", allow_negative_numbers = true)]
    pub(super) exposure: Option<ExposureArgument>,
    /// Scatters so much of those pictures' light around where it is, 0 to 1, as a lens does; or of what is
    /// beyond white alone, as a sun, auto [default: auto].
    #[arg(long, value_parser = parse_bloom, value_name = "SHARE|auto")]
    pub(super) bloom: Option<Bloom>,
}

impl DisplayArguments {
    /// Whether any of them was said.
    pub(super) fn is_asked_for(&self) -> bool {
        let Self { display, look, exposure, bloom } = self;
        *display != Curve::default() || look.is_some() || exposure.is_some() || bloom.is_some()
    }

    /// Display with an exposure in powers of two, and with the input's look unless another is asked for.
    pub(super) fn display(self, exposure_stops: f64, of_input: Look) -> Display {
        let Self { display: curve, look, bloom, .. } = self;
        Display { curve, look: look.unwrap_or(of_input), exposure_stops, bloom: bloom.unwrap_or_default() }
    }
}

impl SceneArguments {
    /// Options that the scene has to know.
    pub(super) fn options(&self) -> ResolveOptions {
        ResolveOptions {
            frame_rate: self.fps,
            light_units: self.light_units,
            no_default_light: self.default_light == Some(Switch::Off),
            keep_sky_suns: self.sky_sun == Some(SkySunArgument::Off),
            animation: self.animation.clone(),
            ..ResolveOptions::default()
        }
    }

    /// Options of a command that looks at the scene through a camera: with all flags that change what a
    /// camera or light that is made up has to serve. A percentage keeps the input's own shape.
    pub(super) fn seen(&self, size: Option<SizeArgument>, camera: Option<&String>) -> ResolveOptions {
        let size = match size {
            Some(SizeArgument::Pixels(size)) => Some(size),
            Some(SizeArgument::Percent(_)) | None => None,
        };
        ResolveOptions { size, camera: camera.cloned(), ..self.options() }
    }

    /// Refuses losses, if the user wants that.
    pub(super) fn check(&self, remarks: &Diagnostics) -> Result<(), CliError> {
        match remarks.refusing_losses().filter(|_| self.strict) {
            Some(losses) => Err(CliError::Scene(losses)),
            None => Ok(()),
        }
    }
}
