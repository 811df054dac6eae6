//! Walks a glTF scene through time and says where things are and how bright it is:
//! `cargo run --release --example walk_gltf [FOLDER [FILE.glb]]`.
#![allow(clippy::print_stdout)]

use std::error::Error;
use std::path::PathBuf;
use sunfleck::{NodePlace, Renderer, Scene};

const LEAVES: &str = "tests/data/blender/a_leaves40_scene.glb";

/// Frames that are looked at.
const STEPS: i64 = 5;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let folder = arguments.next().unwrap_or_else(|| PathBuf::from("out/examples"));
    // Cargo says where the checkout lies.
    let checkout = std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from).unwrap_or_default();
    let input = arguments.next().unwrap_or_else(|| checkout.join(LEAVES));
    let scene = Scene::options().default_light(true).load(input)?;
    let (first, last) = scene.frames().into_inner();
    let place = |node: &str, frame: i64| scene.place(node, frame as f64);
    let way_m = |node: &&str| {
        place(node, first).zip(place(node, last)).map_or(0.0, |(from, to)| distance(&from, &to))
    };
    let farthest = scene.nodes().max_by(|a, b| way_m(a).total_cmp(&way_m(b)));
    let node = farthest.ok_or("a scene of nothing")?;

    println!("`{node}` goes farthest in frames {first} to {last}: {:.2} m", way_m(&node));
    for step in 0..STEPS {
        let number = first + (last - first) * step / (STEPS - 1);
        let here = place(node, number).ok_or("a node of that name")?;
        let frame = Renderer::new(&scene).frame(number).size(96, 54).passes([]).samples(1).render()?;
        let [x, y, z] = here.position_m;
        let seen = if here.visible { "visible" } else { "hidden" };
        let brightness = frame.beauty().mean();
        println!("frame {number:4}: at {x:.2} {y:.2} {z:.2} m, {seen}; mean radiance {brightness:.3?}");
        if step == 0 {
            frame.write_png(folder.join("walk.png"))?;
        }
    }
    Ok(())
}

fn distance(a: &NodePlace, b: &NodePlace) -> f64 {
    (0..3).map(|axis| (a.position_m[axis] - b.position_m[axis]).powi(2)).sum::<f64>().sqrt()
}
