//! The words that flags take. In go words, out come the values that they stand for. Invariant: each is an
//! enum of its own, so that help lists all of them.

use crate::passes::Pass;
use crate::scene::{LightUnits, PixelFilter};
use clap::ValueEnum;
use clap::builder::PossibleValue;
use std::sync::LazyLock;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum Volume {
    /// The best for the scene: slices wherever they serve, else segments.
    #[default]
    Auto,
    /// Samples on epipolar slices, each slice solved as a whole; exact.
    Slices,
    /// Samples in pixels, with exact visibility intervals along every ray.
    Segments,
    /// Shadow rays at equal steps.
    March,
    /// Shadow rays at points spread over the angle seen from the light.
    Equiangular,
    /// As segments, with light of all orders by random walks: unbiased and noisy, for comparison.
    Paths,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum MethodArgument {
    All,
    /// Every pixel against every triangle at every step; a part of the picture is measured.
    Literal,
    March,
    MarchJittered,
    Equiangular,
    Segments,
    Slices,
    /// Slices, with more samples where they are needed.
    SlicesUntil,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum QuantityArgument {
    Leaves,
    Pixels,
    Lights,
    Accuracy,
    Fog,
    Threads,
}

/// `all`, `none`, or a pass by its name in the table of passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PassArgument {
    All,
    None,
    One(Pass),
}

impl ValueEnum for PassArgument {
    fn value_variants<'a>() -> &'a [Self] {
        static VARIANTS: LazyLock<Vec<PassArgument>> = LazyLock::new(|| {
            let passes = Pass::ALL.iter().copied().map(PassArgument::One);
            [PassArgument::All, PassArgument::None].into_iter().chain(passes).collect()
        });
        &VARIANTS
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(match self {
            Self::All => "all",
            Self::None => "none",
            Self::One(pass) => pass.name(),
        }))
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum FilterArgument {
    /// The pixel itself, everywhere alike.
    Box,
    /// A window 1.5 pixels wide, as Blender has it.
    BlackmanHarris,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum LightUnitsArgument {
    /// Lux and candela (Blender's default).
    Spec,
    /// Blender's "Unitless".
    Compat,
    /// Blender's "Raw".
    Raw,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Switch {
    On,
    Off,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum SkySunArgument {
    /// As a `Sun`, if one is found.
    Auto,
    /// As the rest.
    Off,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum OnlyArgument {
    /// Light that fog scatters.
    Shafts,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum SkipArgument {
    /// Those that are whole and were made by this version from this scene and these settings.
    Valid,
    /// All that exist.
    Exists,
    /// None: render everything again.
    #[default]
    None,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum ProgressArgument {
    /// A bar on a terminal, plain lines elsewhere.
    #[default]
    Auto,
    /// A line a frame.
    Plain,
    /// A JSON object a line.
    Jsonl,
    /// Open Job Description lines on the output stream.
    Openjd,
    /// Nothing.
    None,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum FarmProfile {
    /// Open Job Description, which AWS Deadline Cloud and `openjd` take.
    #[default]
    Openjd,
    /// Blender's Flamenco.
    Flamenco,
    /// Thinkbox's Deadline, by its plug-in CommandLine.
    Deadline,
    /// Slurm: an array of chunks, and the steps that wait for it.
    Slurm,
    /// Machines that share a disk, without a manager: a script for each.
    Shell,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum PreviewArgument {
    /// PNG.
    Png,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum CurveArgument {
    /// As Blender's AgX: bright light fades to white.
    #[default]
    Agx,
    /// The sRGB encoding alone; what is brighter than 1 is cut off.
    Srgb,
    /// The linear values themselves, cut off at 1.
    Raw,
}

impl From<FilterArgument> for PixelFilter {
    fn from(argument: FilterArgument) -> Self {
        match argument {
            FilterArgument::Box => Self::Box,
            FilterArgument::BlackmanHarris => Self::BlackmanHarris,
        }
    }
}

impl From<LightUnitsArgument> for LightUnits {
    fn from(argument: LightUnitsArgument) -> Self {
        match argument {
            LightUnitsArgument::Spec => Self::Spec,
            LightUnitsArgument::Compat => Self::Compat,
            LightUnitsArgument::Raw => Self::Raw,
        }
    }
}

/// The passes that a list of arguments stands for.
pub(super) fn passes(arguments: &[PassArgument]) -> Vec<Pass> {
    let mut passes = Vec::new();
    for argument in arguments {
        match argument {
            PassArgument::All => passes.extend(Pass::ALL),
            PassArgument::None => {}
            PassArgument::One(pass) => passes.push(*pass),
        }
    }
    passes.sort_unstable();
    passes.dedup();
    passes
}
