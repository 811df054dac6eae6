//! Walks a glTF scene through time and says where things are and how bright it is: `cargo run --release --example walk_gltf [FOLDER [FILE.glb]]`.
#![allow(clippy::print_stdout)]

use std::error::Error;
use std::path::PathBuf;
use sunfleck::{Renderer, Scene};

const LEAVES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/leaves500/leaves500.glb");

/// Frames that are looked at.
const STEPS: i64 = 5;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let folder = arguments.next().unwrap_or_else(|| PathBuf::from("out/examples"));
    let scene =
        Scene::options().default_light(true).load(arguments.next().unwrap_or_else(|| LEAVES.into()))?;
    let (first, last) = scene.frames().into_inner();
    let place = |node: &str, frame: i64| scene.place(node, frame as f64);
    let moves = |node: &&str| place(node, first) != place(node, last);
    let node = scene.nodes().find(moves).or_else(|| scene.nodes().next()).ok_or("a scene of nothing")?;

    println!("`{node}` in frames {first} to {last}");
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
