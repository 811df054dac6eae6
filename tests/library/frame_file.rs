//! Frames to EXR files and back.

use crate::checkout;
use glam::{DAffine3, DVec3};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use sunfleck::color::Display;
use sunfleck::film::{Channel, Frame, Precision};
use sunfleck::frame_file::{self, FrameFileError, Provenance, compare, is_valid};
use sunfleck::scene::{FrameRate, Sampling, Size, Window};

fn provenance() -> Provenance {
    Provenance {
        frame: 7,
        sequence_frames: (-3, 48),
        frame_rate: FrameRate { numerator: 24000, denominator: 1001 },
        exposure_s: 0.02,
        camera_from_world: DAffine3::from_translation(DVec3::new(1.0, 2.0, 3.0)),
        scene_hash: String::from("5ce4e"),
        settings_hash: String::from("5e771465"),
        seed: u32::MAX,
        sampling: Sampling::Exactly(64),
        owner: Some(String::from("Zoë")),
        object_names: BTreeMap::new(),
        comments: None,
    }
}

/// Numbers of every size, as a rendering would not produce them.
fn frame(window: Window) -> Frame {
    let pixels = window.width * window.height;
    let ramp = |scale: f32| (0..pixels).map(|index| scale * (index as f32 - 7.3)).collect();
    Frame {
        full: Size { width: 60, height: 40 },
        window,
        channels: vec![
            Channel::new("R", Precision::Half, ramp(0.01)),
            Channel::new("G", Precision::Half, ramp(1e-6)),
            Channel::new("B", Precision::Half, ramp(1e9)),
            Channel::new("A", Precision::Half, ramp(0.0)),
            Channel::new("Z", Precision::Float, ramp(1e7)),
            Channel::new("Normal.X", Precision::Float, ramp(1.0 / 3.0)),
            Channel::new("leaf_id.X", Precision::Float, ramp(1.0)),
        ],
    }
}

const CROP: Window = Window { x: 3, y: 5, width: 37, height: 33 };

fn written(folder: &Path) -> PathBuf {
    let path = folder.join("name.0007.exr");
    frame_file::write(&path, &frame(CROP), &provenance()).unwrap();
    path
}

#[test]
fn what_is_read_is_what_was_stored_to_the_last_bit() {
    let folder = tempfile::tempdir().unwrap();
    let file = frame_file::read(&written(folder.path())).unwrap();
    let original = frame(CROP);
    assert_eq!((file.frame.full, file.frame.window), (original.full, original.window));
    assert_eq!(file.frame.channels.len(), original.channels.len());
    for channel in &original.channels {
        let read = file.frame.channel(&channel.name).unwrap();
        assert_eq!(read.precision, channel.precision, "{}", channel.name);
        for (&stored, &given) in read.pixels.iter().zip(&channel.pixels) {
            assert_eq!(stored.to_bits(), channel.precision.stored(given).to_bits(), "{}", channel.name);
        }
    }
    assert!(file.is_intact());
}

#[test]
fn attributes_say_where_the_frame_came_from() {
    let folder = tempfile::tempdir().unwrap();
    let attributes = frame_file::read(&written(folder.path())).unwrap().attributes;
    for (name, value) in [
        ("framesPerSecond", "24000/1001"),
        ("imageCounter", "7"),
        ("expTime", "0.02"),
        ("owner", "Zoë"),
        ("sunfleck:version", env!("CARGO_PKG_VERSION")),
        ("sunfleck:sceneHash", "5ce4e"),
        ("sunfleck:settingsHash", "5e771465"),
        ("sunfleck:sequenceFrames", "-3-48"),
        ("sunfleck:seed", "4294967295"),
        ("sunfleck:samples", "64"),
        ("chromaticities", "0.64 0.33 0.3 0.6 0.15 0.06 0.3127 0.329"),
        ("colorInteropID", "lin_rec709_scene"),
        ("worldToCamera", "1 0 0 0 0 1 0 0 0 0 -1 0 1 2 -3 1"),
    ] {
        assert_eq!(attributes.get(name), Some(value), "{name}");
    }
}

#[test]
fn equal_frames_are_equal_files() {
    let (one, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let bytes = |folder: &Path| std::fs::read(written(folder)).unwrap();
    let first = bytes(one.path());
    // Several times, for an order that is left to chance comes out right now and then.
    assert!((0..8).all(|_| bytes(other.path()) == first));
}

#[test]
fn a_file_is_valid_for_its_own_provenance_only() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(folder.path());
    assert!(is_valid(&path, &provenance()));
    for other in [
        Provenance { frame: 8, ..provenance() },
        Provenance { scene_hash: String::from("other"), ..provenance() },
        Provenance { settings_hash: String::from("other"), ..provenance() },
    ] {
        assert!(!is_valid(&path, &other));
    }
    assert!(!is_valid(&folder.path().join("missing.exr"), &provenance()));
}

#[test]
fn no_damage_goes_unnoticed_and_none_panics() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(folder.path());
    let whole = std::fs::read(&path).unwrap();
    for length in (0..whole.len()).step_by(97) {
        std::fs::write(&path, &whole[..length]).unwrap();
        assert!(!is_valid(&path, &provenance()), "cut to {length} bytes");
    }
    let pixels = frame_file::read(&written(folder.path())).unwrap().pixel_hash;
    for at in (0..whole.len()).step_by(13) {
        let mut damaged = whole.clone();
        damaged[at] ^= 0x55;
        std::fs::write(&path, damaged).unwrap();
        // Damage to what is not hashed, such as a comment, is harmless; the pixels must be right in any case.
        if let Ok(file) = frame_file::read(&path) {
            assert!(file.pixel_hash == pixels || !file.is_intact(), "byte {at}");
        }
    }
}

#[test]
fn a_header_cannot_claim_more_pixels_than_the_file_can_hold() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(folder.path());
    let mut bytes = std::fs::read(&path).unwrap();
    for name in [&b"dataWindow\0box2i\0"[..], b"displayWindow\0box2i\0"] {
        let at = bytes.windows(name.len()).position(|window| window == name).unwrap() + name.len() + 4 + 8;
        bytes[at..at + 4].copy_from_slice(&100_000_i32.to_le_bytes());
        bytes[at + 4..at + 8].copy_from_slice(&100_000_i32.to_le_bytes());
    }
    std::fs::write(&path, bytes).unwrap();
    let error = frame_file::read(&path).unwrap_err();
    assert!(matches!(error, FrameFileError::TooLarge { .. }), "{error}");
}

#[test]
fn a_frame_that_makes_no_png_is_not_held_against_exr() {
    let full = Size { width: 2, height: 1 };
    let colorless = Frame { full, window: Window::whole(full), channels: Vec::new() };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("preview.png");
    let error = frame_file::write_preview(&path, &colorless, &Display::default()).unwrap_err();
    assert!(matches!(error, FrameFileError::Encode { .. }), "{error}");
    assert!(!error.diagnostic().to_string().contains("EXR"), "{}", error.diagnostic());
}

#[test]
fn what_is_no_exr_is_said_to_be_none() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.exr");
    for bytes in [&b""[..], b"P6 1 1 255 ...", b"v/1\x01"] {
        std::fs::write(&path, bytes).unwrap();
        let error = frame_file::read(&path).unwrap_err();
        assert!(matches!(error, FrameFileError::Invalid { .. }), "{error}");
        assert!(error.to_string().contains("picture.exr"));
    }
}

#[test]
fn reference_pictures_are_the_original_arrays() {
    for (name, hash) in REFERENCES {
        let path = checkout::file(format!("tests/data/leaves500/{name}.exr"));
        let file = frame_file::read(&path).unwrap();
        assert_eq!(file.pixel_hash, hash, "{name}");
    }
}

#[test]
fn box_and_centre_references_differ_as_their_readme_says() {
    let read = |name: &str| {
        let path = checkout::file(format!("tests/data/leaves500/{name}.exr"));
        frame_file::read(&path).unwrap().frame
    };
    let color = compare(&read("box"), &read("center")).unwrap().color.unwrap();
    assert!((color.rmse - 0.0415).abs() < 1e-4, "{color}");
    assert_eq!(color.not_finite, 0);
}

/// SHA-256 of the arrays that the references were converted from, in the order of the pixel hash.
const REFERENCES: [(&str, &str); 3] = [
    ("box", "d6356c24807849768ae0eab7655e30080a6aa2f5d7402ec65f07642baaf27a32"),
    ("center", "829790f24ef999a3a5957c6b9677554bb700dbba07b968a0b950c7fda6d108ba"),
    ("box_mediumonly", "68f77da4dc8a95873aeb7dd8c21ee631bcb84733fda4b874ca1d0cda1f1b6fb1"),
];
