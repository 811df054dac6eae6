//! How each pass becomes channels of a frame. Invariant: names and types are those that Blender
//! 5 shows as Combined, Alpha, Depth, Normal and Position; a layer has one name and no nested dots.
//!
//! To add a pass: add it to [`Pass`], then its line to [`layout`] and to [`value`].

use super::Precision;
use crate::scene::Pass;
use crate::transport::Sample;
use glam::DVec3;

/// Depth of a pixel that shows no surface. Infinity trips readers up; Cycles writes this number.
const BACKGROUND_DEPTH_M: f32 = 1e10;

/// How the samples of a pixel become its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PixelRule {
    /// The weighted mean; a sample that shows no surface counts as the background.
    Mean,
    /// The sample nearest to the pixel's centre. A mean of depths or of ids lies on neither surface; Cycles does the same.
    Nearest,
    /// How much of it each id covers.
    Ranked,
    /// What [`Film::estimates`](super::Film::estimates) says of the finished picture; no sample holds it.
    Estimate,
}

/// A pass as channels.
pub(super) struct PassLayout {
    /// Full names, at most four, or three if they are averaged. None if the pass has its own way.
    pub(super) channels: &'static [&'static str],
    pub(super) precision: Precision,
    pub(super) rule: PixelRule,
    /// The value where no surface is seen.
    pub(super) background: f32,
}

/// The channels of a pass.
pub(super) fn layout(pass: Pass) -> PassLayout {
    let (channels, precision, rule): (&'static [&'static str], _, _) = match pass {
        Pass::Shafts => (&["shafts.R", "shafts.G", "shafts.B"], Precision::Half, PixelRule::Mean),
        Pass::Transmittance => {
            (&["transmittance.R", "transmittance.G", "transmittance.B"], Precision::Half, PixelRule::Mean)
        }
        Pass::Albedo => (&["albedo.R", "albedo.G", "albedo.B"], Precision::Half, PixelRule::Mean),
        Pass::Normal => (&["Normal.X", "Normal.Y", "Normal.Z"], Precision::Float, PixelRule::Mean),
        Pass::Position => (&["Position.X", "Position.Y", "Position.Z"], Precision::Float, PixelRule::Nearest),
        Pass::Depth => (&["Z"], Precision::Float, PixelRule::Nearest),
        // Exact up to 2^24 instances.
        Pass::LeafId => (&["leaf_id.X"], Precision::Float, PixelRule::Nearest),
        Pass::Error => (&["error.Y"], Precision::Half, PixelRule::Estimate),
        Pass::Motion => {
            (&["Vector.X", "Vector.Y", "Vector.Z", "Vector.W"], Precision::Float, PixelRule::Nearest)
        }
        Pass::Cryptomatte => (&[], Precision::Float, PixelRule::Ranked),
    };
    let background = if pass == Pass::Depth { BACKGROUND_DEPTH_M } else { 0.0 };
    PassLayout { channels, precision, rule, background }
}

/// What a sample shows in a pass; passes with fewer channels use the first ones.
pub(super) fn value(pass: Pass, sample: &Sample) -> [f64; 4] {
    let three = |value: DVec3| value.extend(0.0).to_array();
    match (pass, &sample.surface) {
        (Pass::Shafts, _) => three(sample.shafts),
        (Pass::Transmittance, _) => three(sample.transmittance),
        (Pass::Albedo, Some(surface)) => three(surface.albedo),
        (Pass::Normal, Some(surface)) => three(surface.normal),
        (Pass::Position, Some(surface)) => three(surface.position),
        (Pass::Depth, Some(surface)) => [surface.depth_m; 4],
        (Pass::LeafId, Some(surface)) => [f64::from(surface.leaf_id); 4],
        (Pass::Motion, _) => sample.motion_px,
        // Of no sample, see [`PixelRule`].
        (Pass::Error | Pass::Cryptomatte, _) => [0.0; 4],
        (_, None) => [f64::from(layout(pass).background); 4],
    }
}
