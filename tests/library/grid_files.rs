//! Fog whose density lies in OpenVDB files: named in RON and in glTF, of a frame or of many.

use crate::checkout;
use crate::export::picture;
use std::fs;
use std::path::Path;
use sunfleck::scene::{self, FogShape, RenderSettings, Scene, Size};
use sunfleck::{description, export};

/// The scene, or why there is none.
fn loaded(path: &Path) -> Result<(Scene, RenderSettings), String> {
    let description = description::load(path).map_err(|error| error.diagnostics().to_string())?;
    scene::resolve(description, None).map_err(|problems| problems.to_string())
}

/// A scene with a bank of fog, and OpenVDB files beside it: each a name and where it is from.
fn scene_with(folder: &Path, fog: &str, files: &[(&str, &str)]) -> std::path::PathBuf {
    for (name, from) in files {
        fs::copy(checkout::file("tests/data/vdb").join(from), folder.join(name)).unwrap();
    }
    let scene = format!(
        r#"Scene(version: 1, fog: {{ "mist": ({fog}) }},
            cameras: {{ "main": (position_m: (0.8, 3.5, 8.0), look_at_m: (0.8, 3.5, 3.0), fov_deg: 50.0) }},
            lights: {{ "sun": Sun(to_sun: (0.5, 1.0, 0.4), irradiance_w_per_m2: (3.0, 2.0, 1.0)) }})"#
    );
    let path = folder.join("scene.ron");
    fs::write(&path, scene).unwrap();
    path
}

fn pixels(scene: &Scene, settings: &RenderSettings, frame: i64) -> Vec<f32> {
    let small = RenderSettings { size: Size { width: 48, height: 27 }, ..settings.clone() };
    let frame = picture(scene, &small, frame);
    ["R", "G", "B"].iter().flat_map(|name| frame.channel(name).unwrap().pixels.clone()).collect()
}

fn mean(picture: &[f32]) -> f32 {
    picture.iter().sum::<f32>() / picture.len() as f32
}

/// The largest difference over the mean.
fn apart(a: &[f32], b: &[f32]) -> f32 {
    let mean = mean(a);
    assert!(mean > 1e-4, "{mean}");
    a.iter().zip(b).map(|(a, b)| (a - b).abs() / mean).fold(0.0, f32::max)
}

/// Writes a scene as glTF into a folder of its own, and reads it from there.
fn through_gltf(scene: &Scene, settings: &RenderSettings, folder: &Path) -> (Scene, RenderSettings) {
    fs::create_dir_all(folder).unwrap();
    let exported = export::glb(scene, settings, folder).unwrap();
    assert!(exported.remarks.0.is_empty(), "{}", exported.remarks);
    assert_eq!(exported.files.len(), 1, "{:?}", exported.files);
    let path = folder.join("scene.glb");
    fs::write(&path, [exported.head, exported.binary].concat()).unwrap();
    loaded(&path).unwrap()
}

#[test]
fn fog_by_a_file_goes_through_gltf() {
    let folder = tempfile::tempdir().unwrap();
    let fog =
        r#"vdb: "my mist.vdb", grid: "heat", density_per_m: (0.2, 0.3, 0.4), albedo: 0.9, anisotropy: 0.3"#;
    let path = scene_with(folder.path(), fog, &[("my mist.vdb", "several.vdb")]);
    let (scene, settings) = loaded(&path).unwrap();
    let (again, settings_again) = through_gltf(&scene, &settings, &folder.path().join("out/shot"));
    let (before, after) = (pixels(&scene, &settings, 1), pixels(&again, &settings_again, 1));
    assert!(apart(&before, &after) < 3e-5, "{}", apart(&before, &after));
    // And on from there.
    let (again, settings_again) = through_gltf(&again, &settings_again, &folder.path().join("other"));
    assert_eq!(pixels(&again, &settings_again, 1), after);
}

/// Each frame shows its own file, at any moment of its shutter; the first and the last one stay.
#[test]
fn a_sequence_shows_each_frame_its_own_file() {
    let folder = tempfile::tempdir().unwrap();
    let files = [("mist.0008.vdb", "several.vdb"), ("mist.0009.vdb", "thin.vdb")];
    let alone = |name: &str| {
        let folder = tempfile::tempdir().unwrap();
        let fog = format!(r#"vdb: "{name}", density_per_m: 0.2"#);
        let (scene, settings) = loaded(&scene_with(folder.path(), &fog, &[(name, name)])).unwrap();
        pixels(&scene, &settings, 1)
    };
    let [first, second] = ["several.vdb", "thin.vdb"].map(alone);
    assert!((mean(&second) / mean(&first) - 1.0).abs() > 0.2, "{} {}", mean(&first), mean(&second));
    for name in ["mist.####.vdb", "mist.%04d.vdb"] {
        let fog = format!(r#"vdb: "{name}", density_per_m: 0.2"#);
        let (scene, settings) = loaded(&scene_with(folder.path(), &fog, &files)).unwrap();
        let (again, of_again) = through_gltf(&scene, &settings, &folder.path().join("out"));
        assert!(!scene.is_still() && !again.is_still());
        for (frame, expected) in [(1, &first), (8, &first), (9, &second), (20, &second)] {
            for (scene, settings) in [(&scene, &settings), (&again, &of_again)] {
                let still = mean(&pixels(scene, settings, frame)) / mean(expected);
                assert!((still - 1.0).abs() < 1e-3, "{name}, frame {frame}: {still}");
                // Other moments are other samples.
                let open = RenderSettings { shutter: 0.9, ..settings.clone() };
                let blurred = mean(&pixels(scene, &open, frame)) / mean(expected);
                assert!((blurred - 1.0).abs() < 0.05, "{name}, frame {frame}: {blurred}");
            }
        }
    }
}

#[test]
fn a_missing_frame_is_refused_with_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let files = [("mist.1.vdb", "several.vdb"), ("mist.3.vdb", "several.vdb")];
    let path = scene_with(folder.path(), r#"vdb: "mist.#.vdb", density_per_m: 0.2"#, &files);
    let said = loaded(&path).unwrap_err();
    assert!(said.contains("mist.2.vdb: error: this file is missing in the sequence"), "{said}");
    assert!(said.contains("remedy"), "{said}");
    let of_gltf = gltf_with(folder.path(), r#""vdb": "mist.%23.vdb", "density": 0.2"#);
    let said = loaded(&of_gltf).unwrap_err();
    assert!(said.contains("mist.2.vdb: error: this file is missing in the sequence"), "{said}");
}

/// A glTF file with nothing but fog.
fn gltf_with(folder: &Path, fog: &str) -> std::path::PathBuf {
    let path = folder.join("scene.gltf");
    let text = format!(
        r#"{{ "asset": {{ "version": "2.0" }}, "scene": 0, "scenes": [{{ "nodes": [0] }}],
            "nodes": [{{ "name": "mist", "extras": {{ "sunfleck_fog_volume": {{ {fog} }} }} }}] }}"#
    );
    fs::write(&path, text).unwrap();
    path
}

#[test]
fn a_file_named_in_gltf_is_fog() {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(checkout::file("tests/data/vdb/several.vdb"), folder.path().join("a b.vdb")).unwrap();
    let path = gltf_with(folder.path(), r#""vdb": "a%20b.vdb", "density": 0.2"#);
    let (scene, _) = loaded(&path).unwrap();
    assert!(matches!(&scene.fogs[0].shape, FogShape::Voxels(grids) if grids.names.density == "density"));
}

/// What RON refuses, glTF does too: with place, what was expected and what helps.
#[test]
fn what_is_no_fog_is_refused_in_gltf() {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(checkout::file("tests/data/vdb/several.vdb"), folder.path().join("several.vdb")).unwrap();
    fs::write(folder.path().join("none.vdb"), b"no grid").unwrap();
    for (fog, found) in [
        (r#""vdb": "nowhere.vdb""#, "nowhere.vdb: error: cannot be read"),
        (r#""vdb": "none.vdb""#, "none.vdb: error"),
        (r#""vdb": "/several.vdb""#, "nodes[0].extras.sunfleck_fog_volume.vdb: error: `/several.vdb` is not"),
        (r#""vdb": "data:;base64,AQID""#, "is not a file beside this one"),
        (r#""vdb": 3"#, "sunfleck_fog_volume.vdb: error: invalid type"),
        (r#""vdb": "several.vdb", "grid": "smoke""#, "sunfleck_fog_volume.vdb: error"),
        (r#""vdb": "several.vdb", "grid": "smoke""#, "there is no grid `smoke`"),
        (r#""vdb": "several.vdb", "grid": "velocity""#, "grid `velocity` is a "),
        (
            r#""vdb": "several.vdb", "shape": "box""#,
            "sunfleck_fog_volume.shape: error: `shape` stands beside",
        ),
        (r#""vdb": "several.vdb", "scale_height": 1.0"#, "`scale_height` stands beside `vdb`"),
        (r#""grid": "density""#, "sunfleck_fog_volume.grid: error: `grid` names one of a file"),
    ] {
        let said = loaded(&gltf_with(folder.path(), &format!(r#"{fog}, "density": 1.0"#))).unwrap_err();
        assert!(said.contains(found), "{fog}: {said}");
        assert!(said.contains("remedy"), "{fog}: {said}");
    }
}
