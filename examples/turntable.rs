//! A camera goes around a cube: `cargo run --release --example turntable [FOLDER]`.

use std::{env, error::Error, path::PathBuf};
use sunfleck::{Animated, Camera, Light, Material, Object, Renderer, Scene, Shape, Sun};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = env::args_os().nth(1).map_or_else(|| PathBuf::from("out/examples"), PathBuf::from);
    // The camera hangs on an arm that turns once in a second, which has 24 frames.
    let turn = Animated::cycle([(0.0, [0.0; 3]), (1.0, [0.0, 360.0, 0.0])]);
    let camera = Camera::default().with(|camera| {
        camera.parent = Some("arm".into());
        camera.position_m = [0.0, 1.0, 3.0].into();
        camera.look_at_m = Some([0.0; 3].into());
    });
    let scene = Scene::builder()
        .shape("cube", Shape::cube(1.0))
        .material("gold", Material::matte([0.8, 0.5, 0.05]))
        .object("cube", Object::of("cube", "gold"))
        .object("arm", Object::default().with(|arm| arm.rotation_deg = Some(turn)))
        .camera("camera", camera)
        .light("sun", Light::Sun(Sun::default().with(|sun| sun.to_sun = Some([1.0; 3].into()))))
        .build()?;
    for (number, frame) in Renderer::new(&scene).size(160, 90).sequence((0..24).step_by(3))?.enumerate() {
        // One exposure for all, so that the pictures do not flicker.
        frame?.write_png_at(folder.join(format!("turntable.{number:04}.png")), 0.0)?;
    }
    Ok(())
}
