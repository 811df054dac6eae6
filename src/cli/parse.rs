//! Parsers of flags' values. In goes text, out come values. Invariant: an error names the expectation, with
//! an example.

use glob::Pattern;
use sunfleck::color::Bloom;
use sunfleck::description::ron::{Range as _, RelativeError, Stops};
use sunfleck::scene::{Bounces, Size};

/// Pattern of channels, or `None` for all, and their maximum difference.
#[derive(Clone, Debug)]
pub(super) struct ChannelsLimit(pub(super) Option<Pattern>, pub(super) f64);

#[derive(Clone, Copy, Debug)]
pub(super) enum ExposureArgument {
    Stops(f64),
    Auto,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum SizeArgument {
    Pixels(Size),
    Percent(f64),
}

/// Frames in a task of a farm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ChunkArgument {
    Frames(u32),
    Auto,
}

/// A rectangle of pixels, far edges excluded.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crop {
    pub(super) x0: usize,
    pub(super) y0: usize,
    pub(super) x1: usize,
    pub(super) y1: usize,
}

pub(super) fn parse_size(text: &str) -> Result<SizeArgument, String> {
    let expected = "expected WIDTHxHEIGHT such as 960x540 (each 1 to 65536), or a percentage such as 50%";
    if let Some(percent) = text.strip_suffix('%') {
        let takes = |percent| percent > 0.0 && percent <= 1000.0;
        return number(percent, takes, expected).map(SizeArgument::Percent);
    }
    let (width, height) = text.split_once(['x', 'X']).ok_or(expected)?;
    let side = |text: &str| match text.trim().parse::<usize>() {
        Ok(side) if (1..=65536).contains(&side) => Ok(side),
        _ => Err(expected),
    };
    Ok(SizeArgument::Pixels(Size { width: side(width)?, height: side(height)? }))
}

/// Maximum number of frames in a task.
pub(super) const LARGEST_CHUNK: u32 = 150;

pub(super) fn parse_bounces(text: &str) -> Result<Bounces, String> {
    /// Maximum number of bounces below `all`; more make no difference.
    const MOST: u32 = 64;
    match text.trim() {
        "all" => Ok(Bounces::All),
        text => match text.parse::<u32>() {
            Ok(count) if count <= MOST => Ok(Bounces::UpTo(count)),
            _ => Err("expected a whole number from 0 to 64, or all".into()),
        },
    }
}

/// Number of a text, if the flag accepts it.
fn number(text: &str, takes: impl Fn(f64) -> bool, expected: &str) -> Result<f64, String> {
    text.trim().parse().ok().filter(|&number| takes(number)).ok_or_else(|| expected.into())
}

pub(super) fn parse_tolerance(text: &str) -> Result<f64, String> {
    number(text, RelativeError::contains, &format!("expected {}", RelativeError::EXPECTED))
}

pub(super) fn parse_chunk(text: &str) -> Result<ChunkArgument, String> {
    match text.trim() {
        "auto" => Ok(ChunkArgument::Auto),
        text => match text.parse::<u32>() {
            Ok(frames) if (1..=LARGEST_CHUNK).contains(&frames) => Ok(ChunkArgument::Frames(frames)),
            _ => Err(format!("expected a whole number from 1 to {LARGEST_CHUNK}, or auto")),
        },
    }
}

/// Maximum magnitude of a frame number; larger ones are typing errors.
const FARTHEST_FRAME: f64 = 1e9;

pub(super) fn parse_frame(text: &str) -> Result<f64, String> {
    number(
        text,
        |frame| frame.abs() <= FARTHEST_FRAME,
        "expected a frame such as 12 or 12.5, or several separated by commas",
    )
}

pub(super) fn parse_seconds(text: &str) -> Result<f64, String> {
    number(
        text,
        |seconds| seconds > 0.0 && seconds <= 1e6,
        "expected seconds, more than 0 and at most 1000000, such as 8 or 0.5",
    )
}

pub(super) fn parse_white(text: &str) -> Result<f64, String> {
    number(text, |white| white > 0.0 && white.is_finite(), "expected a number above 0")
}

pub(super) fn parse_exposure(text: &str) -> Result<ExposureArgument, String> {
    if text.trim() == "auto" {
        return Ok(ExposureArgument::Auto);
    }
    let expected = format!("expected {}, or auto", Stops::EXPECTED);
    number(text, Stops::contains, &expected).map(ExposureArgument::Stops)
}

pub(super) fn parse_bloom(text: &str) -> Result<Bloom, String> {
    if text.trim() == "auto" {
        return Ok(Bloom::Auto);
    }
    let expected = "expected a share of the light from 0 to 1, such as 0.05, or auto";
    number(text, |share| (0.0..=1.0).contains(&share), expected).map(Bloom::Share)
}

pub(super) fn parse_noise(text: &str) -> Result<f64, String> {
    number(
        text,
        |noise| noise >= 0.0 && noise.is_finite(),
        "expected the root mean square of a standard error, 0 or more, such as 0.0014",
    )
}

/// Number of at least 0, which demands equality; with a pattern also `inf`, for no limit.
pub(super) fn parse_limit(text: &str) -> Result<ChannelsLimit, String> {
    let (channels, number) = channels_and_number(text)?;
    let is_limit = number >= 0.0 && (number.is_finite() || channels.is_some());
    let expected = "expected a number from 0 on, or channels and one, such as diffuse.*=0.01";
    if is_limit { Ok(ChannelsLimit(channels, number)) } else { Err(expected.into()) }
}

pub(super) fn parse_share_limit(text: &str) -> Result<ChannelsLimit, String> {
    let (channels, number) = channels_and_number(text)?;
    let expected = "expected a share from 0 to 1, or channels and one, such as leaf_id.*=0.01";
    if (0.0..=1.0).contains(&number) { Ok(ChannelsLimit(channels, number)) } else { Err(expected.into()) }
}

/// Parses `CHANNELS=NUMBER`, or a number alone. An invalid number becomes NaN.
fn channels_and_number(text: &str) -> Result<(Option<Pattern>, f64), String> {
    let (channels, number) =
        text.rsplit_once('=').map_or((None, text), |(names, number)| (Some(names), number));
    let pattern = |names: &str| {
        Pattern::new(&one_star(names))
            .map_err(|error| format!("`{names}` is no pattern of names: {}", error.msg))
    };
    Ok((channels.map(pattern).transpose()?, number.trim().parse().unwrap_or(f64::NAN)))
}

/// Collapses several stars into one, as names of channels have no folders.
fn one_star(names: &str) -> String {
    let mut names = names.to_owned();
    while names.contains("**") {
        names = names.replace("**", "*");
    }
    names
}

pub(super) fn parse_crop(text: &str) -> Result<Crop, String> {
    let numbers: Option<Vec<usize>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x0, y0, x1, y1]) if x0 < x1 && y0 < y1 => Ok(Crop { x0, y0, x1, y1 }),
        _ => Err("expected x0,y0,x1,y1 in pixels with x0 < x1 and y0 < y1, such as 100,50,400,200".into()),
    }
}

pub(super) fn parse_shutter(text: &str) -> Result<f64, String> {
    number(
        text,
        |frames| (0.0..=1000.0).contains(&frames),
        "expected how many frames the shutter is open for, from 0 to 1000, such as 0.5",
    )
}

pub(super) fn parse_shutter_position(text: &str) -> Result<f64, String> {
    number(
        text,
        |position| (-1000.0..=1000.0).contains(&position),
        "expected where the shutter opens, from -1000 to 1000: 0 is centred, 0.5 opens at the frame",
    )
}

pub(super) fn parse_frame_rate(text: &str) -> Result<sunfleck::scene::FrameRate, String> {
    let (numerator, denominator) = text.split_once('/').unwrap_or((text, "1"));
    match (numerator.trim().parse::<u32>(), denominator.trim().parse::<u32>()) {
        (Ok(numerator), Ok(denominator)) if numerator > 0 && denominator > 0 => {
            Ok(sunfleck::scene::FrameRate { numerator, denominator })
        }
        _ => Err("expected frames a second such as 24, or a fraction such as 24000/1001".into()),
    }
}
