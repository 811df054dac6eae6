//! Provenance of a frame, as EXR attributes. In go hashes and settings, out come attributes. Invariant:
//! nothing depends on the clock, the machine or the number of threads, so a frame rendered twice is the same
//! file.

use super::file_hash;
use crate::scene::{FrameRate, Sampling};
use exr::math::Vec2;
use exr::meta::attribute::{AttributeValue, Chromaticities, Text};
use exr::meta::header::{Header, LayerAttributes};
use glam::{DAffine3, DMat4, DVec3};
use std::collections::BTreeMap;

/// Version of this program, which frames store.
const VERSION: &str = env!("CARGO_PKG_VERSION");

pub(super) const VERSION_NAME: &str = "sunfleck:version";
pub(super) const SCENE_HASH_NAME: &str = "sunfleck:sceneHash";
pub(super) const SETTINGS_HASH_NAME: &str = "sunfleck:settingsHash";
pub(super) const PIXEL_HASH_NAME: &str = "sunfleck:pixelHash";
const SEED_NAME: &str = "sunfleck:seed";
const SAMPLES_NAME: &str = "sunfleck:samples";
const TOLERANCE_NAME: &str = "sunfleck:tolerance";
const SEQUENCE_FRAMES_NAME: &str = "sunfleck:sequenceFrames";
const IMAGE_COUNTER_NAME: &str = "imageCounter";

/// Provenance of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Provenance {
    /// Number of the frame in its sequence; EXR has 32 bits for it.
    pub frame: i64,
    /// First and last frame of the input, whichever frames a run renders. So a farm's chunk writes the same
    /// bytes as a whole run, and a missing last frame is noticed.
    pub sequence_frames: (i64, i64),
    /// Frame rate, the same in every frame of a sequence.
    pub frame_rate: FrameRate,
    /// Time that the shutter was open, seconds.
    pub exposure_s: f64,
    /// Camera (right-handed, looking along -Z, +Y up) from world.
    pub camera_from_world: DAffine3,
    /// Hash of the scene's contents.
    pub scene_hash: String,
    /// Hash of all other parameters of the pixels: size, samples, passes, method and so on.
    pub settings_hash: String,
    /// Seed of the sample points.
    pub seed: u32,
    /// Samples a pixel.
    pub sampling: Sampling,
    /// Owner of the picture, if the author names one.
    pub owner: Option<String>,
    /// Comments.
    pub comments: Option<String>,
    /// Names of Cryptomatte's ids, for frames with such channels.
    pub object_names: BTreeMap<u32, String>,
}

/// Attributes of a file as texts, by name. Numbers are decimal, fractions `24/1`, lists separated by spaces.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Attributes(pub BTreeMap<String, String>);

impl Provenance {
    /// Whether a file with these attributes shows the same scene, rendered with the same settings by the same
    /// version.
    pub(super) fn matches(&self, attributes: &Attributes) -> bool {
        attributes.get(VERSION_NAME) == Some(VERSION)
            && attributes.get(SCENE_HASH_NAME) == Some(&self.scene_hash)
            && attributes.get(SETTINGS_HASH_NAME) == Some(&self.settings_hash)
            && attributes.get(IMAGE_COUNTER_NAME) == Some(&self.frame.to_string())
    }

    /// Attributes of the file's only part.
    pub(super) fn layer_attributes(&self, pixel_hash: &str) -> LayerAttributes {
        let mut attributes = LayerAttributes {
            owner: self.owner.as_deref().map(text),
            comments: self.comments.as_deref().map(text),
            software_name: Some(text(&format!("sunfleck {VERSION}"))),
            exposure: Some(self.exposure_s as f32),
            // Real frame rates have numerators below 2^31.
            frames_per_second: i32::try_from(self.frame_rate.numerator)
                .ok()
                .map(|numerator| (numerator, self.frame_rate.denominator)),
            world_to_camera: Some(world_to_camera(self.camera_from_world)),
            ..LayerAttributes::default()
        };
        let seed = self.seed.to_string();
        // With a tolerance, the maximum number.
        let (samples, tolerance) = match self.sampling {
            Sampling::Exactly(samples) => (samples, None),
            Sampling::Until { tolerance, most } => (most, Some(tolerance.to_string())),
        };
        let samples = samples.to_string();
        let (first, last) = self.sequence_frames;
        let sequence_frames = format!("{first}-{last}");
        for (name, value) in [
            (VERSION_NAME, VERSION),
            (SCENE_HASH_NAME, &self.scene_hash),
            (SETTINGS_HASH_NAME, &self.settings_hash),
            (PIXEL_HASH_NAME, pixel_hash),
            (file_hash::NAME, file_hash::PLACEHOLDER),
            (SEED_NAME, &seed),
            (SAMPLES_NAME, &samples),
            (SEQUENCE_FRAMES_NAME, &sequence_frames),
        ] {
            attributes.other.insert(text(name), AttributeValue::Text(text(value)));
        }
        if let Some(tolerance) = tolerance {
            attributes.other.insert(text(TOLERANCE_NAME), AttributeValue::Text(text(&tolerance)));
        }
        if let Ok(counter) = i32::try_from(self.frame) {
            attributes.other.insert(text(IMAGE_COUNTER_NAME), AttributeValue::I32(counter));
        }
        attributes
    }
}

impl Attributes {
    /// Attribute of that name.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.0.get(name).map(String::as_str)
    }

    pub(super) fn from_header(header: &Header) -> Self {
        let named = header.all_named_attributes();
        Self(
            named
                .map(|(name, value)| (String::from_utf8_lossy(name).into_owned(), readable(&value)))
                .collect(),
        )
    }
}

/// Primaries and white point of ITU-R BT.709, for all colours of this program.
pub(super) const REC_709: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.3, 0.6),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.329),
};

/// Colour space of these primaries, with the id of the ASWF's Color Interop Forum.
pub(super) const COLOR_ID: &str = "lin_rec709_scene";

/// UTF-8 text; the crate's own conversion supports Latin-1 only.
pub(super) fn text(value: &str) -> Text {
    Text::from_slice_unchecked(value.as_bytes())
}

/// Matrix in EXR's convention: row vectors, and a left-handed camera that looks along +Z.
fn world_to_camera(camera_from_world: DAffine3) -> [f32; 16] {
    let flip = DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0));
    // Columns of a matrix for column vectors are rows of one for row vectors.
    (flip * DMat4::from(camera_from_world)).to_cols_array().map(|element| element as f32)
}

fn readable(value: &AttributeValue) -> String {
    match value {
        AttributeValue::Text(text) => String::from_utf8_lossy(text.bytes()).into_owned(),
        AttributeValue::I32(number) => number.to_string(),
        AttributeValue::F32(number) => number.to_string(),
        AttributeValue::F64(number) => number.to_string(),
        AttributeValue::Rational((numerator, denominator)) => format!("{numerator}/{denominator}"),
        AttributeValue::Matrix3x3(elements) => join(elements),
        AttributeValue::Matrix4x4(elements) => join(elements),
        AttributeValue::Chromaticities(c) => {
            join(&[c.red.0, c.red.1, c.green.0, c.green.1, c.blue.0, c.blue.1, c.white.0, c.white.1])
        }
        other => format!("{other:?}"),
    }
}

fn join(numbers: &[f32]) -> String {
    numbers.iter().map(f32::to_string).collect::<Vec<_>>().join(" ")
}
