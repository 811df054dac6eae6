//! Work that is left out because of what lies on the disk: files not read, frames not rendered. In goes
//! the plan, out come rows. Invariant: what is written lies in the folder of the plan.

use crate::skips::{AddRow, Plan, picture};
use std::collections::BTreeMap;
use std::path::Path;
use sunfleck::bench::timed;
use sunfleck::film::Frame;
use sunfleck::frame_file::{self, Provenance};
use sunfleck::math::Sampler;
use sunfleck::{description, scene};

/// Measures these skips.
pub(crate) fn measure(plan: &Plan, row: &mut AddRow) -> Result<(), String> {
    let (whole, _) = picture(plan, plan.scene, &[]);
    let path = plan.folder.join("frame.exr");
    let provenance = Provenance {
        frame: 1,
        sequence_frames: (1, 1),
        frame_rate: scene::FrameRate { numerator: 24, denominator: 1 },
        exposure_s: 0.0,
        camera_from_world: glam::DAffine3::IDENTITY,
        scene_hash: String::from("a scene"),
        settings_hash: String::from("settings"),
        seed: plan.job.seed,
        sampling: plan.job.sampling,
        owner: None,
        comments: None,
        object_names: BTreeMap::new(),
    };
    let write =
        || frame_file::write(&path, &whole, &provenance).map_err(|error| error.diagnostic().to_string());
    let read =
        || frame_file::read(&path).map(|file| file.frame).map_err(|error| error.diagnostic().to_string());
    write()?;
    row(
        "frames that are there already",
        "rendered and written again",
        &|| {
            let (is_valid, seconds) = timed(|| frame_file::is_valid(&path, &provenance));
            if is_valid {
                Ok((read()?, seconds))
            } else {
                Err(String::from("the frame just written is not valid"))
            }
        },
        &|| {
            let (_, picture_s) = picture(plan, plan.scene, &[]);
            let (written, write_s) = timed(write);
            written?;
            Ok((read()?, picture_s + write_s))
        },
    )?;
    row(
        "still scenes: one picture for all frames",
        "rendered again",
        &|| {
            let (frame, seconds) = timed(|| whole.clone());
            Ok((frame, seconds))
        },
        &|| Ok(picture(plan, plan.scene, &[])),
    )?;
    let [unused, used] = textured_scenes(plan.folder)?;
    row(
        "textures that no visible surface uses",
        "one such surface behind the camera",
        &|| loaded(plan, &unused),
        &|| loaded(plan, &used),
    )
}

/// The picture of a scene file by its own first camera, and the time of loading it.
fn loaded(plan: &Plan, path: &Path) -> Result<(Frame, f64), String> {
    let (scene, seconds) = timed(|| {
        let description = description::load(path).map_err(|error| error.to_string())?;
        scene::resolve(description, None).map(|(scene, _)| scene).map_err(|error| error.to_string())
    });
    let scene = scene?;
    let plan = Plan { scene: &scene, job: plan.job.clone(), ..*plan };
    Ok((picture(&plan, &scene, &[]).0, seconds))
}

/// Two scene files that show the same: a leaf, and a large texture on nothing or on a
/// surface behind the camera.
fn textured_scenes(folder: &Path) -> Result<[std::path::PathBuf; 2], String> {
    const SIDE: u32 = 1024;
    let noise = |x: u32, y: u32| {
        let value = Sampler::new(1, x, y, 0).next_1d();
        image::Rgb([(255.0 * value) as u8; 3])
    };
    let said = |error: &dyn std::fmt::Display| format!("error: {}: {error}", folder.display());
    image::RgbImage::from_fn(SIDE, SIDE, noise)
        .save(folder.join("bark.png"))
        .map_err(|error| said(&error))?;
    let scene = |behind: &str| {
        format!(
            r#"Scene(
    version: 1,
    meshes: {{ "leaf": Leaf(length_m: 1.0, width_m: 0.6), "quad": Quad(size_m: 1.0) }},
    materials: {{ "bark": (texture: "bark.png"), "plain": (base_color: 0.5) }},
    objects: {{ "leaf": (mesh: "leaf", material: "plain"), "behind": (mesh: "quad", material: "{behind}", translation_m: (0.0, 0.0, 9.0)) }},
    cameras: {{ "main": (position_m: (0.0, 1.0, 3.0), look_at_m: (0.0, 0.0, 0.0), fov_deg: 40.0) }},
    lights: {{ "sun": Sun(to_sun: (0.3, 1.0, 0.2), irradiance_w_per_m2: 3.0) }},
)"#
        )
    };
    let write = |name: &str, behind: &str| {
        let path = folder.join(name);
        std::fs::write(&path, scene(behind)).map_err(|error| said(&error))?;
        Ok::<_, String>(path)
    };
    Ok([write("unused.ron", "plain")?, write("used.ron", "bark")?])
}
