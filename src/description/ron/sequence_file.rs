//! Fields of a sequence file: render settings, never contents. In goes RON, out come settings. Invariant:
//! only the version and the scene are required; the scene has defaults for other fields.

use super::number::{Finite, NonNegative, Number, Positive, RelativeError, Stops, Whole};
use super::version::Version;
use crate::color::Look;
use crate::passes::Pass;
use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Unexpected, Visitor};
use std::fmt;
use std::path::PathBuf;

/// `Sequence(..)`: frames of a scene, and their settings.
#[derive(Clone, Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SequenceFields {
    /// Version of the format.
    pub version: Version,
    /// A .ron, .glb or .gltf scene, relative to the sequence file.
    pub scene: PathBuf,
    /// First and last frame.
    pub frames: Option<Frames>,
    /// Frames a second, as a whole number or a fraction.
    pub frame_rate: Option<FrameRate>,
    /// Columns and rows.
    pub size: Option<(Whole<1, 65536>, Whole<1, 65536>)>,
    /// Animations of a glTF scene to play: a name, a number from 0, or `all`.
    pub animation: Option<String>,
    /// Name of the camera.
    pub camera: Option<String>,
    /// Samples a pixel; with a tolerance, the maximum.
    pub samples: Option<Whole<1, 65536>>,
    /// Relative error of a block of pixels that suffices.
    pub tolerance: Option<Number<RelativeError>>,
    /// Reconstruction filter.
    pub filter: Option<PixelFilter>,
    /// Passes beside the beauty.
    pub passes: Option<Vec<Pass>>,
    /// Seed of the sample points.
    pub seed: Option<u32>,
    /// Time for which the shutter is open, in frames.
    pub shutter_frames: Option<Number<NonNegative>>,
    /// Offset from the frame to the middle of that time, in parts of it: -0.5 closes at the frame, 0.5 opens
    /// at it.
    pub shutter_position: Option<Number<Finite>>,
    /// Exposure of pictures for viewing, in stops.
    pub exposure: Option<Number<Stops>>,
    /// Look of pictures for viewing.
    pub look: Option<Look>,
    /// Maximum number of reflections by mirrors.
    pub mirror_depth: Option<Whole<0, 64>>,
    /// Number of scatterings beyond the first: a number, or `"all"`.
    pub bounces: Option<Bounces>,
    /// The stepped method's image plane.
    pub march: Option<March>,
}

/// Movement of the image plane in the stepped method.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct March {
    /// Depth to which the plane is moved.
    pub depth_m: Number<Positive>,
    /// Step of the plane.
    pub step_m: Number<Positive>,
}

/// Number of scatterings beyond direct light and single scattering.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Bounces {
    /// At most this many, `bounces: 3`.
    UpTo(u32),
    /// All orders, `bounces: "all"`.
    All,
}

impl<'de> Deserialize<'de> for Bounces {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NumberOrAll;
        impl Visitor<'_> for NumberOrAll {
            type Value = Bounces;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a whole number from 0 to 64, or \"all\"")
            }
            fn visit_u64<E: Error>(self, count: u64) -> Result<Bounces, E> {
                let is_few = count <= 64;
                is_few
                    .then_some(Bounces::UpTo(count as u32))
                    .ok_or_else(|| E::invalid_value(Unexpected::Unsigned(count), &self))
            }
            fn visit_str<E: Error>(self, text: &str) -> Result<Bounces, E> {
                (text == "all")
                    .then_some(Bounces::All)
                    .ok_or_else(|| E::invalid_value(Unexpected::Str(text), &self))
            }
        }
        deserializer.deserialize_any(NumberOrAll)
    }
}

/// Reconstruction filter of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[cfg_attr(feature = "program", derive(clap::ValueEnum))]
#[non_exhaustive]
pub enum PixelFilter {
    /// The pixel itself, everywhere alike.
    #[default]
    Box,
    /// A window of Blackman and Harris, 1.5 pixels wide: Blender's default.
    BlackmanHarris,
}

/// Maximum magnitude of frame numbers: beyond it, times in single precision cannot resolve parts of frames.
pub const MAX_FRAME: i64 = 10_000_000;

/// First and last frame, `(1, 48)`; the last is not before the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frames(pub(crate) i64, pub(crate) i64);

impl<'de> Deserialize<'de> for Frames {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (first, last) = <(i64, i64)>::deserialize(deserializer)?;
        if first <= last && -MAX_FRAME <= first && last <= MAX_FRAME {
            return Ok(Self(first, last));
        }
        let found = format!("frames {first} to {last}");
        let expected = format!("(first, last), the last not before the first, both within {MAX_FRAME} of 0");
        Err(D::Error::invalid_value(Unexpected::Other(&found), &expected.as_str()))
    }
}

/// Frames a second as a fraction, such as 24/1 or 24000/1001.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRate {
    /// Number of frames.
    pub numerator: u32,
    /// Number of seconds that they take, at least 1.
    pub denominator: u32,
}

impl<'de> Deserialize<'de> for FrameRate {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(FrameRateVisitor)
    }
}

/// Maximum numerator and denominator of a frame rate.
const MAX_RATE: u32 = 1_000_000;

struct FrameRateVisitor;

impl<'de> Visitor<'de> for FrameRateVisitor {
    type Value = FrameRate;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a whole number such as 24 or a fraction such as (24000, 1001), from 1 to {MAX_RATE}")
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Self::Value, E> {
        match u32::try_from(value) {
            Ok(numerator @ 1..=MAX_RATE) => Ok(FrameRate { numerator, denominator: 1 }),
            _ => Err(E::invalid_value(Unexpected::Unsigned(value), &self)),
        }
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<Self::Value, A::Error> {
        let mut part = |index| {
            let part = sequence.next_element::<Whole<1, MAX_RATE>>()?;
            part.map(|Whole(part)| part).ok_or_else(|| A::Error::invalid_length(index, &FrameRateVisitor))
        };
        Ok(FrameRate { numerator: part(0)?, denominator: part(1)? })
    }
}
