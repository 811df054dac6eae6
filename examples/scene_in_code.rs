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
    let roof = Triangles {
        positions: vec![[-2.0, 0.0, -1.0], [2.0, 0.0, -1.0], [0.0, 0.8, -1.0], [0.0, 0.0, 1.0]],
        triangles: vec![[0, 3, 2], [3, 1, 2]],
        ..Triangles::default()
    };
    let leaf = Shape::Leaf {
        length_m: 0.3.into(),
        width_m: 0.18.into(),
        curl_deg: 30.0.into(),
        fold_deg: 10.0.into(),
    };
    let turning = Object {
        mesh: Some("leaf".into()),
        material: Some("gold".into()),
        translation_m: [0.3, 1.3, 1.8].into(),
        rotation_deg: Some(Animated::cycle([(0.0, [20.0, 0.0, 10.0]), (2.0, [20.0, 360.0, 10.0])])),
        ..Object::default()
    };
    let crown = Leaves {
        count: 120.into(),
        seed: 7,
        meshes: vec!["leaf".into()],
        materials: vec!["gold".into()],
        min_m: Some([-1.5, 1.6, -1.0].into()),
        max_m: Some([1.5, 2.4, 1.0].into()),
        ..Leaves::default()
    };
    let sun = Light::Sun(Sun {
        to_sun: Some([0.3, 1.0, -0.5].into()),
        irradiance_w_per_m2: [8.0, 7.2, 6.0].into(),
        angular_diameter_deg: 0.5.into(),
        ..Sun::default()
    });
    let camera = Camera {
        position_m: [0.0, 1.2, 4.5].into(),
        look_at_m: Some([0.0, 1.1, 0.0].into()),
        fov_deg: Some(40.0.into()),
        ..Camera::default()
    };
    Scene::builder()
        .shape("leaf", leaf)
        .mesh("roof", roof)
        .shape("ground", Shape::Quad { size_m: 8.0.into() })
        .material(
            "gold",
            Material {
                base_color: Some([0.6, 0.4, 0.05].into()),
                transmission: [0.3, 0.2, 0.0].into(),
                ..Material::default()
            },
        )
        .material("soil", Material { base_color: Some([0.2; 3].into()), ..Material::default() })
        .object("turning", turning)
        .object(
            "roof",
            Object { mesh: Some("roof".into()), material: Some("soil".into()), ..Object::default() },
        )
        .object(
            "ground",
            Object { mesh: Some("ground".into()), material: Some("soil".into()), ..Object::default() },
        )
        .leaves("crown", crown)
        .light("sun", sun)
        .fog("haze", Fog { anisotropy: 0.5.into(), ..Fog::in_box([-4.0, 0.0, -4.0], [4.0, 3.0, 4.0], 0.15) })
        .camera("main", camera)
        .build()
}
