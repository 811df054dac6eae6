//! What OpenVDB files say of fog beside its density: what shines, albedo by voxel, and velocities.

use crate::checkout;
use glam::DVec3;
use std::fs;
use std::path::{Path, PathBuf};
use sunfleck::render::{Job, Method, Watch, render};
use sunfleck::scene::{self, Bounces, FogShape, RenderSettings, Sampling, Scene, Size, Window};
use sunfleck::snapshot::{Exposure, MeshTrees, Shutter};
use sunfleck::{description, export};

/// The scene, or why there is none.
fn loaded(path: &Path) -> Result<(Scene, RenderSettings), String> {
    let description = description::load(path).map_err(|error| error.diagnostics().to_string())?;
    scene::resolve(description, None).map_err(|problems| problems.to_string())
}

/// A scene with a bank of fog, before which a light stands or none.
fn scene_with(folder: &Path, fog: &str, light: &str, files: &[&str]) -> PathBuf {
    for name in files {
        fs::copy(checkout::file("tests/data/vdb").join(name), folder.join(name)).unwrap();
    }
    let path = folder.join("scene.ron");
    let scene = format!(
        r#"Scene(version: 1, fog: {{ "fire": ({fog}) }}, lights: {{ {light} }},
            cameras: {{ "main": (position_m: (0.8, 3.5, 8.0), look_at_m: (0.8, 3.5, 3.0), fov_deg: 50.0) }})"#
    );
    fs::write(&path, scene).unwrap();
    path
}

const SUN: &str = r#""sun": Sun(to_sun: (0.5, 1.0, 0.4), irradiance_w_per_m2: (3.0, 2.0, 1.0))"#;

/// Red, green, blue and alpha of each pixel, of so many samples by a method.
fn rendered(
    scene: &Scene,
    settings: &RenderSettings,
    bounces: Bounces,
    (method, sampling): (Method, Sampling),
) -> Vec<[f32; 4]> {
    let size = Size { width: 48, height: 27 };
    let job = Job {
        size,
        window: Window::whole(size),
        passes: Vec::new(),
        sampling,
        filter: settings.filter,
        seed: settings.seed,
        mirror_depth: settings.mirror_depth,
        bounces,
        method,
    };
    let trees = MeshTrees::new(scene);
    let exposure = Exposure::new(scene, &trees, 0, 48.0 / 27.0, Shutter::of(settings, 1.0));
    let frame = render(&exposure, &job, &Watch::NOBODY).frame;
    let channels = ["R", "G", "B", "A"].map(|name| &frame.channel(name).unwrap().pixels);
    (0..channels[0].len()).map(|pixel| channels.map(|channel| channel[pixel])).collect()
}

fn pixels(scene: &Scene, settings: &RenderSettings, bounces: Bounces) -> Vec<[f32; 4]> {
    rendered(scene, settings, bounces, (Method::Auto, Sampling::Exactly(4)))
}

/// Where light is in proportion to extinction, a ray has as much of it as fog takes of what is behind.
#[test]
fn what_shines_has_its_closed_form_and_goes_through_gltf() {
    let folder = tempfile::tempdir().unwrap();
    let fog = r#"vdb: "thin.vdb", density_per_m: 4.0, albedo: 0.0,
        emission_grid: "density", emission_w_per_m3_sr: (8.0, 4.0, 2.0)"#;
    let (scene, settings) = loaded(&scene_with(folder.path(), fog, "", &["thin.vdb"])).unwrap();
    let exported = export::glb(&scene, &settings, folder.path()).unwrap();
    assert!(exported.remarks.0.is_empty(), "{}", exported.remarks);
    let path = folder.path().join("scene.glb");
    fs::write(&path, [exported.head, exported.binary].concat()).unwrap();
    let (again, settings_again) = loaded(&path).unwrap();
    for (scene, settings) in [(&scene, &settings), (&again, &settings_again)] {
        let mut most = 0.0_f32;
        for [red, green, blue, alpha] in pixels(scene, settings, Bounces::NONE) {
            for (found, expected) in [(red, 2.0 * alpha), (green, alpha), (blue, 0.5 * alpha)] {
                assert!((found - expected).abs() < 2e-3, "{found} for {expected}");
            }
            most = most.max(alpha);
        }
        assert!(most > 0.4, "{most}");
    }
}

/// A quarter of 6000 K is redder than all of it, and far darker.
#[test]
fn a_black_body_has_the_colour_of_its_temperature() {
    let folder = tempfile::tempdir().unwrap();
    let color = |kelvin: f64| {
        let fog = format!(
            r#"vdb: "thin.vdb", density_per_m: 0.0, emission_grid: "density",
                emission_w_per_m3_sr: 1.0, emission_kelvin: {kelvin:?}"#
        );
        let (scene, settings) = loaded(&scene_with(folder.path(), &fog, "", &["thin.vdb"])).unwrap();
        let pixels = pixels(&scene, &settings, Bounces::NONE);
        [0, 1, 2].map(|channel| pixels.iter().map(|pixel| f64::from(pixel[channel])).sum::<f64>())
    };
    let [cold, hot] = [6000.0, 24000.0].map(color);
    assert!(cold[0] > 4.0 * cold[2] && hot[2] > 0.8 * hot[0], "{cold:?} {hot:?}");
    assert!(hot[1] > 10.0 * cold[1], "{cold:?} {hot:?}");
}

/// Light of what shines is scattered: on grids as by random walks, and as walks correct it.
#[test]
fn what_shines_lights_fog() {
    let folder = tempfile::tempdir().unwrap();
    let fog = r#"vdb: "thin.vdb", density_per_m: 12.0, albedo: 0.9,
        emission_grid: "density", emission_w_per_m3_sr: 4.0"#;
    let (scene, settings) = loaded(&scene_with(folder.path(), fog, "", &["thin.vdb"])).unwrap();
    let mean = |bounces, way| {
        let pixels = rendered(&scene, &settings, bounces, way);
        pixels.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / pixels.len() as f64
    };
    let once = mean(Bounces::NONE, (Method::Segments, Sampling::Exactly(4)));
    let all = mean(Bounces::All, (Method::Segments, Sampling::Exactly(4)));
    let corrected = mean(Bounces::All, (Method::Segments, Sampling::Until { tolerance: 0.02, most: 4 }));
    let walked = mean(Bounces::All, (Method::Paths, Sampling::Exactly(256)));
    assert!(all > 1.3 * once, "{all} {once}");
    for found in [all, corrected] {
        assert!((found / walked - 1.0).abs() < 0.03, "{found} {walked}");
    }
}

#[test]
fn colours_of_one_value_are_that_albedo() {
    let folder = tempfile::tempdir().unwrap();
    let of = |fog: &str| {
        let (scene, settings) = loaded(&scene_with(folder.path(), fog, SUN, &["colours.vdb"])).unwrap();
        pixels(&scene, &settings, Bounces::All)
    };
    let by_voxel = of(r#"vdb: "colours.vdb", density_per_m: 2.0, albedo: 0.8, albedo_grid: "Cd""#);
    let plain = of(r#"vdb: "colours.vdb", density_per_m: 2.0, albedo: (0.2, 0.4, 0.8)"#);
    let colors =
        |pixels: &[[f32; 4]]| pixels.iter().flat_map(|pixel| pixel[..3].to_vec()).collect::<Vec<_>>();
    let (by_voxel, plain) = (colors(&by_voxel), colors(&plain));
    let most = plain.iter().copied().fold(0.0, f32::max);
    for (found, expected) in by_voxel.iter().zip(&plain) {
        assert!((found - expected).abs() < 0.01 * most, "{found} for {expected}");
    }
}

/// A block that has gone half of its way lies half way between its files.
#[test]
fn velocities_carry_fog_between_files() {
    for name in ["moving", "split", "staggered"] {
        carry_fog_between(&[1, 2].map(|number| format!("{name}.{number}.vdb")), name);
    }
}

fn carry_fog_between(files: &[String; 2], name: &str) {
    let folder = tempfile::tempdir().unwrap();
    let fog = format!(r#"vdb: "{name}.#.vdb", density_per_m: 1.0"#);
    let files: [&str; 2] = std::array::from_fn(|index| files[index].as_str());
    let (scene, settings) = loaded(&scene_with(folder.path(), &fog, SUN, &files)).unwrap();
    assert!(scene.held_fog(0.5).is_none());
    let FogShape::Voxels(grids) = &scene.fogs[0].shape else { panic!("it has voxels") };
    for (frame, middle) in [(1.0, 9.5), (1.25, 11.5), (1.5, 13.5), (2.0, 17.5), (3.0, 17.5)] {
        let voxels = grids.at(settings.frame_rate.seconds(frame)).unwrap();
        let (low, high) = voxels.parts[0].voxels.voxels.bounds();
        assert_eq!(0.5 * (low + high), DVec3::new(middle, 1.5, 1.5), "{frame}");
        let at_middle = voxels.parts[0].voxels.voxels.at(DVec3::new(middle, 1.5, 1.5));
        assert!((at_middle - 1.0).abs() < 1e-5, "{frame}: {at_middle}");
    }
}

/// Frames so long that fog would fly out of sight between two files.
#[test]
fn fog_that_is_too_fast_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let fog = r#"vdb: "moving.#.vdb", density_per_m: 1.0"#;
    scene_with(folder.path(), fog, SUN, &["moving.1.vdb", "moving.2.vdb"]);
    let path = folder.path().join("slow.ron");
    let said = |frame_rate: u32| {
        let text = format!(r#"Sequence(version: 1, scene: "scene.ron", frame_rate: {frame_rate})"#);
        fs::write(&path, text).unwrap();
        loaded(&path).unwrap().0.held_fog(0.5).map(|said| said.to_string())
    };
    assert_eq!(said(4), None);
    let said = said(2).unwrap();
    assert!(said.contains("fog-held") && said.contains("over 64 voxels"), "{said}");
}

/// Where files have none, an open shutter says so.
#[test]
fn fog_that_jumps_is_said() {
    let folder = tempfile::tempdir().unwrap();
    for number in 1..3 {
        let to = folder.path().join(format!("still.{number}.vdb"));
        fs::copy(checkout::file("tests/data/vdb/thin.vdb"), to).unwrap();
    }
    let fog = r#"vdb: "still.#.vdb", density_per_m: 1.0"#;
    let (scene, _) = loaded(&scene_with(folder.path(), fog, SUN, &[])).unwrap();
    let said = scene.held_fog(0.5).unwrap().to_string();
    assert!(said.contains("fog-held") && said.contains("`fire`") && said.contains("remedy"), "{said}");
    assert!(scene.held_fog(0.0).is_none());
}

#[test]
fn what_cannot_be_is_refused_with_its_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let files = ["several.vdb", "colours.vdb"];
    for (fog, found) in [
        (r#"vdb: "several.vdb", albedo_grid: "velocity""#, "has other voxels than"),
        (r#"vdb: "several.vdb", albedo_grid: "heat""#, "is a Tree_float_5_4_3"),
        (r#"vdb: "several.vdb", albedo_grid: "none""#, "there is no grid `none`"),
        (r#"vdb: "colours.vdb", emission_grid: "Cd", emission_w_per_m3_sr: 1.0"#, "is a Tree_vec3s_5_4_3"),
        (r#"vdb: "colours.vdb", emission_grid: "density""#, "what shines is said by halves"),
        (
            r#"vdb: "colours.vdb", emission_grid: "density", emission_w_per_m3_sr: 1.0, emission_kelvin: 9.0"#,
            "as if 1 were 9 K",
        ),
        (r#"scale_height_m: 1.0, emission_kelvin: 900.0"#, "is of a file that is not named"),
    ] {
        let fog = format!("{fog}, density_per_m: 1.0");
        let said = loaded(&scene_with(folder.path(), &fog, SUN, &files)).unwrap_err();
        assert!(said.contains(found) && said.contains("remedy"), "{found}: {said}");
    }
}
