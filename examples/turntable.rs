//! A camera goes around a leaf while a bar shows how far it is:
//! `cargo run --release --example turntable [FOLDER]`.
#![allow(clippy::print_stdout)]

use indicatif::{ProgressBar, ProgressStyle};
use std::error::Error;
use std::path::PathBuf;
use sunfleck::{Animated, Camera, Fog, Light, Material, Object, Progress, Renderer, Scene, Shape};

const FRAMES: i64 = 8;
/// Of the bar, for each frame.
const STEPS: u64 = 100;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("out/examples"), PathBuf::from);
    let scene = table()?;
    let style = ProgressStyle::with_template("[{bar:40}] {percent:>3} %  {msg}")?;
    let bar = ProgressBar::new(FRAMES as u64 * STEPS).with_style(style);
    // One exposure for all frames, so that the pictures do not flicker.
    let mut stops = None;
    for number in 0..FRAMES {
        bar.set_message(format!("frame {number}"));
        let before = number as u64 * STEPS;
        let tell = |progress: Progress| bar.set_position(before + (progress.fraction * STEPS as f64) as u64);
        let frame =
            Renderer::new(&scene).frame(number).size(160, 90).tolerance(0.1).progress(&tell).render()?;
        let stops = *stops.get_or_insert_with(|| frame.auto_exposure_stops());
        frame.write_png_at(folder.join(format!("turntable.{number:04}.png")), stops)?;
    }
    bar.finish_and_clear();
    println!("{FRAMES} pictures are in {}", folder.display());
    Ok(())
}

/// A leaf on a stand. The camera hangs on an arm that turns once in as many frames as there are, 24 a second.
fn table() -> Result<Scene, sunfleck::LoadError> {
    let turn_s = FRAMES as f64 / 24.0;
    let arm = Object::default().with(|object| {
        object.rotation_deg = Some(Animated::cycle([(0.0, [0.0; 3]), (turn_s, [0.0, 360.0, 0.0])]))
    });
    let placed = |mesh: &str, material: &str, height_m: f64| {
        Object::of(mesh, material).with(|object| object.translation_m = [0.0, height_m, 0.0].into())
    };
    let camera = Camera::default().with(|camera| {
        camera.parent = Some("arm".into());
        camera.position_m = [0.0, 1.2, 3.0].into();
        camera.look_at_m = Some([0.0, 0.6, 0.0].into());
    });
    let lamp = Light::Point {
        parent: None,
        position_m: [1.0, 2.2, 0.8].into(),
        intensity_w_per_sr: [12.0, 10.0, 8.0].into(),
        radius_m: 0.05.into(),
    };
    Scene::builder()
        .shape(
            "leaf",
            Shape::Leaf {
                length_m: 1.2.into(),
                width_m: 0.7.into(),
                curl_deg: 40.0.into(),
                fold_deg: 15.0.into(),
            },
        )
        .shape("table", Shape::Quad { size_m: 4.0.into() })
        .material(
            "gold",
            Material::matte([0.8, 0.5, 0.05]).with(|material| material.roughness = Some(0.5.into())),
        )
        .material("wood", Material::matte([0.3, 0.2, 0.1]))
        .object("arm", arm)
        .object("leaf", placed("leaf", "gold", 0.7))
        .object("table", placed("table", "wood", 0.0))
        .camera("arm's end", camera)
        .light("lamp", lamp)
        .fog("haze", Fog::in_box([-3.0, 0.0, -3.0], [3.0, 3.0, 3.0], 0.08))
        .build()
}
