//! The command line's grammar. Invariant: flags work in any order; unknown ones are refused.

pub(super) use super::bench_arguments::BenchArguments;
use super::parse::{
    ChannelsLimit, ChunkArgument, Crop, SizeArgument, parse_bounces, parse_chunk, parse_crop, parse_limit,
    parse_seconds, parse_share_limit, parse_shutter, parse_shutter_position, parse_size, parse_tolerance,
    parse_white,
};
pub(super) use super::shared_arguments::{BakeArguments, DisplayArguments, SceneArguments};
pub(super) use super::words::{
    FarmProfile, OnlyArgument, PassArgument, PreviewArgument, ProgressArgument, Volume, passes,
};
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;
use sunfleck::scene::{Bounces, PixelFilter};
use sunfleck::sequence::Skip;

/// Falling leaves to EXR sequences, with volumetric shadows integrated exactly along every ray.
#[derive(Debug, Parser)]
#[command(name = "sunfleck", version, max_term_width = 100)]
pub(super) struct Arguments {
    #[command(subcommand)]
    pub(super) command: Command,
}

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Render a sequence or scene to EXR frames.
    Render(RenderArguments),
    /// Draw a scene without shadows, in moments, or show frames that are there: pictures, a contact
    /// sheet, an animation.
    Preview(PreviewArguments),
    /// Say what an input holds, and what of it is not honoured.
    Inspect(InspectArguments),
    /// Measure what error each method reaches in which time.
    ///
    /// How time grows, what is skipped and both ways to all light: `cargo bench`, as docs/figures.md says.
    Bench(BenchArguments),
    /// Write an input as glTF, which Blender and others open.
    Export(ExportArguments),
    /// Compare EXR frames: two, or two folders frame by frame.
    Diff(DiffArguments),
    /// Write a job for the manager of a render farm.
    Farm(FarmArguments),
    /// Keep a scene loaded, and render what lines of the input stream ask for.
    Serve(ServeArguments),
    /// Print a completion script for a shell.
    Completions {
        /// Which shell.
        shell: clap_complete::Shell,
    },
}

#[derive(Args, Debug)]
pub(super) struct RenderArguments {
    /// A sequence (.ron), a scene (.ron), a glTF file (.glb, .gltf) or a mesh (.obj).
    pub(super) input: PathBuf,
    /// Frames, such as 1-48, 1-48x2, 1-48:2, 1..48, 5,9 or all, or those that a file lists,
    /// @FILE [default: all].
    #[arg(long, allow_hyphen_values = true)]
    pub(super) frames: Option<String>,
    /// Output: a folder, or a name with ####, %04d or $F4 [default: out/NAME/NAME.####.exr].
    #[arg(long, value_name = "PATTERN|DIR")]
    pub(super) out: Option<PathBuf>,
    /// Picture size: 960x540, or a percentage of the sequence's, 50% [default: the sequence's, else 960x540].
    #[arg(long, value_parser = parse_size, value_name = "WxH|P%")]
    pub(super) size: Option<SizeArgument>,
    /// The estimated relative error of every block of 8x8 pixels at which to stop [default: the
    /// sequence's, else 0.02].
    #[arg(long, value_parser = parse_tolerance, value_name = "X", allow_negative_numbers = true)]
    pub(super) tolerance: Option<f64>,
    /// How often light is scattered beyond direct light and single scattering: a number, or `all`
    /// [default: the sequence's].
    #[arg(long, value_parser = parse_bounces, value_name = "N|all")]
    pub(super) bounces: Option<Bounces>,
    /// Exactly so many samples a pixel; beside --tolerance, at most [default: the sequence's].
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=65536), allow_negative_numbers = true)]
    pub(super) samples: Option<u32>,
    /// By what weights a pixel is the mean of the picture around it [default: the sequence's, else box].
    #[arg(long, value_enum)]
    pub(super) filter: Option<PixelFilter>,
    /// How light in fog is found.
    #[arg(long, value_enum, default_value_t)]
    pub(super) volume: Volume,
    /// Points a ray and light, for --volume march [default: the sequence's steps] and
    /// equiangular [default: 1].
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1_000_000), value_name = "N", allow_negative_numbers = true)]
    pub(super) volume_steps: Option<u32>,
    /// Name of the camera [default: the sequence's, else the first].
    #[arg(long)]
    pub(super) camera: Option<String>,
    /// Only these pixels, x1 and y1 excluded; the frame keeps its full display window.
    #[arg(long, value_parser = parse_crop, value_name = "x0,y0,x1,y1")]
    pub(super) crop: Option<Crop>,
    /// Passes beside the beauty, or `all` or `none` [default: the sequence's].
    #[arg(long, value_enum, value_delimiter = ',', value_name = "LIST")]
    pub(super) passes: Option<Vec<PassArgument>>,
    /// Shafts alone in place of the beauty, with alpha for what fog hides: to be laid over other pictures.
    #[arg(long, value_enum)]
    pub(super) only: Option<OnlyArgument>,
    /// Which frames that exist already are kept.
    #[arg(long, value_enum, default_value_t)]
    pub(super) skip: Skip,
    /// Seed of the sample points [default: the sequence's, else 0].
    #[arg(long, allow_negative_numbers = true)]
    pub(super) seed: Option<u32>,
    /// Frames that the shutter is open for; 0 is an instant without motion blur.
    #[arg(long, value_name = "S", value_parser = parse_shutter, allow_negative_numbers = true)]
    pub(super) shutter: Option<f64>,
    /// Where the shutter opens: 0 is centred on the frame, 0.5 opens at it, -0.5 closes at it.
    #[arg(long, value_name = "P", value_parser = parse_shutter_position, allow_negative_numbers = true)]
    pub(super) shutter_position: Option<f64>,
    /// Threads to render with [default: all cores].
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1024), allow_negative_numbers = true)]
    pub(super) threads: Option<u32>,
    /// Frames to render at once, each on its share of the threads; more take memory [default: 2, or a
    /// quarter of the threads, if there is memory; 1 with --frame-timeout or --live].
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=64), value_name = "N", allow_negative_numbers = true)]
    pub(super) frames_at_once: Option<u32>,
    /// Give a frame up that takes longer to render, seconds, and go on with the next
    /// (exit code 5 at the end).
    #[arg(long, value_parser = parse_seconds, value_name = "S", allow_negative_numbers = true)]
    pub(super) frame_timeout: Option<f64>,
    /// Write what each frame took to this file: a JSON object a line.
    #[arg(long, value_name = "FILE")]
    pub(super) stats: Option<PathBuf>,
    /// How progress is told.
    #[arg(long, value_enum, default_value_t)]
    pub(super) progress: ProgressArgument,
    /// Also write a picture for eyes beside each frame; beside kept ones too.
    #[arg(long, value_enum)]
    pub(super) preview: Option<PreviewArgument>,
    #[command(flatten)]
    pub(super) display: DisplayArguments,
    /// Show frames in the viewer tev while they are rendered; it listens on port 14158 unless told otherwise.
    #[arg(long, value_name = "HOST[:PORT]")]
    pub(super) live: Option<String>,
    /// Say what would be rendered, and render nothing.
    #[arg(long)]
    pub(super) dry_run: bool,
    #[command(flatten)]
    pub(super) scene: SceneArguments,
}

#[derive(Args, Debug)]
pub(super) struct ServeArguments {
    /// A sequence (.ron), a scene (.ron), a glTF file (.glb, .gltf) or a mesh (.obj).
    pub(super) input: PathBuf,
    /// Picture size that made-up cameras and lights are for: 960x540, or a percentage of the sequence's, 50%
    /// [default: the sequence's, else 960x540].
    #[arg(long, value_parser = parse_size, value_name = "WxH|P%")]
    pub(super) size: Option<SizeArgument>,
    /// Name of the camera [default: the sequence's, else the first].
    #[arg(long)]
    pub(super) camera: Option<String>,
    /// Threads to render with [default: all cores].
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1024), allow_negative_numbers = true)]
    pub(super) threads: Option<u32>,
    #[command(flatten)]
    pub(super) scene: SceneArguments,
}

#[derive(Args, Debug)]
pub(super) struct PreviewArguments {
    /// A sequence (.ron), a scene (.ron), a glTF file (.glb, .gltf), a mesh (.obj), an EXR
    /// frame, or a folder of them.
    pub(super) input: PathBuf,
    /// Frames, such as 1-48, 1-48x2, 1-48:2, 1..48, 5,9 or all, or those that a file lists,
    /// @FILE [default: all].
    #[arg(long, allow_hyphen_values = true)]
    pub(super) frames: Option<String>,
    /// A folder or NAME.####.png for a picture a frame, NAME.png for a contact sheet, NAME.webp or NAME.apng
    /// for an animation [default: pictures and a sheet in out/NAME.preview].
    #[arg(long, value_name = "PATTERN|DIR|FILE")]
    pub(super) out: Option<PathBuf>,
    /// Picture size [default: the sequence's, made smaller until it has no more pixels than 480x270].
    #[arg(long, value_parser = parse_size, value_name = "WxH|P%")]
    pub(super) size: Option<SizeArgument>,
    /// Name of the camera [default: the sequence's, else the first].
    #[arg(long)]
    pub(super) camera: Option<String>,
    /// Threads to draw with [default: all cores].
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1024), allow_negative_numbers = true)]
    pub(super) threads: Option<u32>,
    #[command(flatten)]
    pub(super) display: DisplayArguments,
    #[command(flatten)]
    pub(super) scene: SceneArguments,
}

#[derive(Args, Debug)]
pub(super) struct InspectArguments {
    /// A sequence (.ron), a scene (.ron), a glTF file (.glb, .gltf) or a mesh (.obj).
    pub(super) input: PathBuf,
    /// As JSON, with every node's world matrix at each of `--frames`.
    #[arg(long)]
    pub(super) json: bool,
    /// Only the files that the input consists of, a path a line.
    #[arg(long, conflicts_with = "json")]
    pub(super) dependencies: bool,
    /// Frames to look at, such as 1-24, 1-48x2, 5,9.5 or all, or those that a file lists, @FILE;
    /// fractions are allowed [default: the first].
    #[arg(long, allow_hyphen_values = true)]
    pub(super) frames: Option<String>,
    /// Picture size: 960x540, or a percentage of the sequence's, 50% [default: the sequence's, else 960x540].
    #[arg(long, value_parser = parse_size, value_name = "WxH|P%")]
    pub(super) size: Option<SizeArgument>,
    /// The estimated relative error at which rendering would stop [default: the sequence's, else 0.02].
    #[arg(long, value_parser = parse_tolerance, value_name = "X", allow_negative_numbers = true)]
    pub(super) tolerance: Option<f64>,
    /// Name of the camera [default: the sequence's, else the first].
    #[arg(long)]
    pub(super) camera: Option<String>,
    #[command(flatten)]
    pub(super) scene: SceneArguments,
}

#[derive(Args, Debug)]
pub(super) struct ExportArguments {
    /// A sequence (.ron), a scene (.ron), a glTF file (.glb, .gltf) or a mesh (.obj).
    pub(super) input: PathBuf,
    /// The file to write.
    #[arg(value_name = "OUT.glb")]
    pub(super) output: PathBuf,
    /// First and last frame of the animation, such as 1-48 [default: the input's].
    #[arg(long, allow_hyphen_values = true)]
    pub(super) frames: Option<String>,
    #[command(flatten)]
    pub(super) scene: SceneArguments,
}

#[derive(Args, Debug)]
pub(super) struct DiffArguments {
    /// The frame to judge, or a folder of frames.
    pub(super) output: PathBuf,
    /// The frame to judge it by, or a folder of those of the same numbers.
    pub(super) reference: PathBuf,
    /// The reference's own noise (root mean square of its standard error), taken out of the RMSE.
    #[arg(long, default_value_t = 0.0)]
    pub(super) reference_noise: f64,
    #[command(flatten)]
    pub(super) limits: LimitArguments,
    /// Writes output, reference and their difference side by side: a PNG, of folders a PNG a frame.
    #[arg(long, value_name = "FILE|DIR|PATTERN")]
    pub(super) picture: Option<PathBuf>,
    /// The difference that is white there [default: 99.9 % are below].
    #[arg(long, value_name = "X", value_parser = parse_white, requires = "picture", allow_negative_numbers = true)]
    pub(super) white: Option<f64>,
    #[command(flatten)]
    pub(super) display: DisplayArguments,
}

#[derive(Args, Debug)]
pub(super) struct FarmArguments {
    /// A sequence (.ron), a scene (.ron), a glTF file (.glb, .gltf) or a mesh (.obj).
    pub(super) input: PathBuf,
    /// The job's folder; frames go to `frames` in it, baked falls to `bakes`.
    #[arg(long, value_name = "DIR")]
    pub(super) out: PathBuf,
    /// Frames, such as 1-48, 1-48x2, 1-48:2, 1..48, 5,9 or all, or those that a file lists,
    /// @FILE [default: all].
    #[arg(long, allow_hyphen_values = true)]
    pub(super) frames: Option<String>,
    /// Frames that a task renders, 1 to 150, or as many as give most frames an hour, auto.
    #[arg(long, value_name = "N|auto", default_value = "8", value_parser = parse_chunk, allow_negative_numbers = true)]
    pub(super) chunk: ChunkArgument,
    /// Time of a frame on a machine, for --chunk auto and the limits of time of --profile slurm [default:
    /// estimated].
    #[arg(long, value_name = "S", value_parser = parse_seconds, allow_negative_numbers = true)]
    pub(super) frame_seconds: Option<f64>,
    /// Whose job.
    #[arg(long, value_enum, default_value_t)]
    pub(super) profile: FarmProfile,
    /// How many machines share the work, for --profile shell, which has a script for each of up to
    /// 1000 [default: 2], and for --chunk auto.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000), allow_negative_numbers = true)]
    pub(super) machines: Option<u32>,
    /// Flags of `render` for every task, after `--`.
    #[arg(last = true, value_name = "FLAGS")]
    pub(super) flags: Vec<String>,
}

/// Each may be given several times; of those that name a channel the last counts.
#[derive(Args, Debug)]
pub(super) struct LimitArguments {
    /// Largest root mean square error: of the colour, and of every other channel; or of those named,
    /// such as diffuse.*=0.01.
    #[arg(long, value_name = "[CHANNELS=]X", value_parser = parse_limit)]
    pub(super) max_rmse: Vec<ChannelsLimit>,
    /// Largest relative mean square error, likewise.
    #[arg(long, value_name = "[CHANNELS=]X", value_parser = parse_limit)]
    pub(super) max_relmse: Vec<ChannelsLimit>,
    /// Largest difference of a value, likewise.
    #[arg(long, value_name = "[CHANNELS=]X", value_parser = parse_limit)]
    pub(super) max_error: Vec<ChannelsLimit>,
    /// Largest share of a channel's ids that differ, 0 to 1.
    #[arg(long, value_name = "[CHANNELS=]SHARE", value_parser = parse_share_limit)]
    pub(super) max_ids: Vec<ChannelsLimit>,
}
