//! Builds a scene in code, renders it with passes and writes what it sees:
//! `cargo run --release --example scene_in_code [FOLDER]`.
#![allow(clippy::print_stdout)]

use std::error::Error;
use std::path::PathBuf;
use sunfleck::{
    Animated, Camera, Fog, Leaves, Light, Material, Object, Pass, Renderer, Scene, Shape, Sun, Triangles,
};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("out/examples"), PathBuf::from);
    let scene = glade()?;
    for warning in scene.warnings() {
        println!("{warning}");
    }

    let frame = Renderer::new(&scene)
        .frame(12)
        .size(240, 135)
        .passes([Pass::Depth, Pass::Normal, Pass::Shafts])
        .samples(4)
        .render()?;

    let depth = frame.pass(Pass::Depth).ok_or("depth was asked for")?;
    let nearest = depth.values.iter().copied().fold(f32::INFINITY, f32::min);
    println!("{} x {} pixels, the nearest at {nearest:.2} {}", depth.width, depth.height, depth.unit);
    println!("mean radiance {:.3?} {}", frame.beauty().mean(), frame.beauty().unit);
    frame.write(folder.join("glade.exr"))?;
    frame.write_png(folder.join("glade.png"))?;
    println!("glade.exr and glade.png are in {}", folder.display());
    Ok(())
}

/// Leaves in the sun over a roof of two triangles, in thin fog; one of them turns.
fn glade() -> Result<Scene, sunfleck::LoadError> {
    let roof = Triangles::new(
        vec![[-2.0, 0.0, -1.0], [2.0, 0.0, -1.0], [0.0, 0.8, -1.0], [0.0, 0.0, 1.0]],
        vec![[0, 3, 2], [3, 1, 2]],
    );
    let leaf = Shape::leaf(0.3, 0.18).with(|leaf| {
        if let Shape::Leaf { curl_deg, fold_deg, .. } = leaf {
            (*curl_deg, *fold_deg) = (30.0.into(), 10.0.into());
        }
    });
    let turning = Object::of("leaf", "gold").with(|object| {
        object.translation_m = [0.3, 1.3, 1.8].into();
        object.rotation_deg = Some(Animated::cycle([(0.0, [20.0, 0.0, 10.0]), (2.0, [20.0, 360.0, 10.0])]));
    });
    let crown = Leaves::default().with(|leaves| {
        leaves.count = 120.into();
        leaves.seed = 7;
        leaves.meshes = vec!["leaf".into()];
        leaves.materials = vec!["gold".into()];
        leaves.min_m = Some([-1.5, 1.6, -1.0].into());
        leaves.max_m = Some([1.5, 2.4, 1.0].into());
    });
    let sun = Light::Sun(Sun::default().with(|sun| {
        sun.to_sun = Some([0.3, 1.0, -0.5].into());
        sun.irradiance_w_per_m2 = [8.0, 7.2, 6.0].into();
        sun.angular_diameter_deg = 0.5.into();
    }));
    let camera = Camera::default().with(|camera| {
        camera.position_m = [0.0, 1.2, 4.5].into();
        camera.look_at_m = Some([0.0, 1.1, 0.0].into());
        camera.fov_deg = Some(40.0.into());
    });
    Scene::builder()
        .shape("leaf", leaf)
        .mesh("roof", roof)
        .shape("ground", Shape::quad(8.0))
        .material(
            "gold",
            Material::matte([0.6, 0.4, 0.05]).with(|material| material.transmission = [0.3, 0.2, 0.0].into()),
        )
        .material("soil", Material::matte([0.2; 3]))
        .object("turning", turning)
        .object("roof", Object::of("roof", "soil"))
        .object("ground", Object::of("ground", "soil"))
        .leaves("crown", crown)
        .light("sun", sun)
        .fog(
            "haze",
            Fog::in_box([-4.0, 0.0, -4.0], [4.0, 3.0, 4.0], 0.15).with(|fog| fog.anisotropy = 0.5.into()),
        )
        .camera("main", camera)
        .build()
}
