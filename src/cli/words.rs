//! Values of flags that are words. In go words, out come enums. Invariant: each is an enum, here or where its
//! values are used, so that help lists all of them.

use clap::ValueEnum;
use clap::builder::PossibleValue;
use std::sync::LazyLock;
use sunfleck::passes::Pass;

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
