//! The flags of `bench`. Invariant: what excludes another is refused by the grammar, before anything is read.

use super::parse::{SizeArgument, parse_bounces, parse_noise, parse_seconds, parse_size};
use super::shared_arguments::SceneArguments;
use clap::Args;
use std::path::PathBuf;
use sunfleck::bench::Method;
use sunfleck::scene::Bounces;

#[derive(Args, Debug)]
pub(super) struct BenchArguments {
    /// A sequence (.ron), a scene (.ron), a glTF file (.glb, .gltf) or a mesh (.obj).
    pub(super) input: PathBuf,
    /// Which frame [default: the first].
    #[arg(long, allow_negative_numbers = true)]
    pub(super) frame: Option<i64>,
    /// Picture size [default: the sequence's, made smaller until it has no more pixels than 480x270,
    /// with --quick 240x135].
    #[arg(long, value_parser = parse_size, value_name = "WxH|P%")]
    pub(super) size: Option<SizeArgument>,
    /// Name of the camera [default: the sequence's, else the first].
    #[arg(long)]
    pub(super) camera: Option<String>,
    /// How often light is scattered beyond direct light and single scattering [default: the scene's,
    /// else all].
    #[arg(long, value_parser = parse_bounces, value_name = "N|all")]
    pub(super) bounces: Option<Bounces>,
    /// Which methods [default: all that make such light: `literal` none beyond the first, `paths` more].
    #[arg(long, value_enum, value_delimiter = ',', value_name = "LIST")]
    pub(super) methods: Option<Vec<Method>>,
    /// How often each point is measured; the least time counts [default: 3, with --quick 2].
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=100), value_name = "N", allow_negative_numbers = true)]
    pub(super) rounds: Option<u32>,
    /// A method takes no more effort than fits into so many seconds [default: 8, with --quick 0.5].
    #[arg(long, value_parser = parse_seconds, value_name = "SECONDS", allow_negative_numbers = true)]
    pub(super) longest: Option<f64>,
    /// Nor more than so many samples a pixel, however fast they are [default: as many as --longest lets it].
    #[arg(
        long, value_parser = clap::value_parser!(u32).range(1..=65536), value_name = "N", allow_negative_numbers = true
    )]
    pub(super) most_samples: Option<u32>,
    /// Samples a pixel of the reference [default: 256, with --quick 32].
    #[arg(long, value_parser = clap::value_parser!(u32).range(4..=65536), value_name = "N", allow_negative_numbers = true)]
    pub(super) reference_samples: Option<u32>,
    /// Measure against this picture instead of rendering a reference.
    #[arg(long, value_name = "FILE.exr", conflicts_with = "reference_samples")]
    pub(super) reference: Option<PathBuf>,
    /// That picture's own noise (root mean square of its standard error).
    #[arg(long, value_parser = parse_noise, value_name = "X", requires = "reference", default_value_t = 0.0, allow_negative_numbers = true)]
    pub(super) reference_noise: f64,
    /// Points of other renderers to show beside: a CSV file.
    #[arg(long, value_name = "FILE.csv")]
    pub(super) peers: Option<PathBuf>,
    /// Where the points go as CSV [default: out/bench/NAME.csv].
    #[arg(long, value_name = "FILE")]
    pub(super) csv: Option<PathBuf>,
    /// Where the plot goes as SVG [default: out/bench/NAME.svg].
    #[arg(long, value_name = "FILE")]
    pub(super) svg: Option<PathBuf>,
    /// Less of everything: a first look.
    #[arg(long)]
    pub(super) quick: bool,
    /// Threads for the reference; what is timed has one [default: all cores].
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1024), allow_negative_numbers = true)]
    pub(super) threads: Option<u32>,
    #[command(flatten)]
    pub(super) scene: SceneArguments,
}
