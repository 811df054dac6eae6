//! How long 20,000 falling leaves take from the file to their keys, baked and out of a store. How
//! many keys they have.

use cpu_time::ProcessTime;
use std::cell::RefCell;
use std::io::{Cursor, Read};
use std::time::Instant;
use sunfleck::description;
use sunfleck::scene::{self, Baking, Motion, ResolveOptions, Rotation};

const SCENE: &str = r#"Scene(version: 1, cameras: { "main": () }, meshes: { "leaf": Leaf(length_m: 0.1, width_m: 0.06) },
    fall: { "storm": (
        count: 20000, species: [(meshes: ["leaf"], length_m: (0.06, 0.12))], release_s: (0.0, 10.0),
        emitter: Box(min_m: (-10.0, 4.0, -10.0), max_m: (10.0, 10.0, 10.0)), wind: WIND,
        motion: (steady: 1.0, flutter: 3.0, tumble: 2.0, chaotic: 2.0, helical: 1.0, spiral: 1.0),
    ) })"#;

const WINDS: [(&str, &str); 2] = [
    ("calm", "()"),
    ("storm", "(mean_m_per_s: (3.0, 0.0, 1.0), gust_m_per_s: (3.0, 0.0, 0.0), eddy_m_per_s: 1.0)"),
];

/// Prints the times.
pub fn run(rounds: usize) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    println!("20,000 leaves that fall 4 to 10 m, on {} threads", rayon::current_num_threads());
    for (name, wind) in WINDS {
        std::fs::write(&path, SCENE.replace("WIND", wind)).unwrap();
        for _ in 0..rounds {
            let kept = RefCell::new(None);
            let keep = |_: &str, parts: &[&[u8]]| *kept.borrow_mut() = Some(parts.concat());
            let recall = |_: &str| {
                let bytes: Vec<u8> = kept.borrow().clone()?;
                Some(Box::new(Cursor::new(bytes)) as Box<dyn Read>)
            };
            let baking = Baking { recall: &recall, keep: &keep, ..Baking::ALONE };
            let resolve = || {
                let (started, processor) = (Instant::now(), ProcessTime::now());
                let (description, options) = (description::load(&path).unwrap(), ResolveOptions::default());
                let (scene, _) = scene::resolve_telling(description, &options, &baking).unwrap();
                (scene, started.elapsed().as_secs_f64(), processor.elapsed().as_secs_f64())
            };
            let (scene, seconds, processor_s) = resolve();
            let (_, again_s, again_processor_s) = resolve();
            let (mut places, mut turns, mut in_the_air_s) = (0, 0, 0.0);
            for node in &scene.nodes {
                if let Motion::Keyed { translation, rotation: Rotation::Quaternion(rotation), .. } =
                    &node.motion
                {
                    let (first_s, last_s) = translation.span_s();
                    places += translation.times_s().len();
                    turns += rotation.times_s().len();
                    in_the_air_s += last_s - first_s;
                }
            }
            println!(
                "{name}: {seconds:.2} s ({processor_s:.1} s of processors); {in_the_air_s:.0} leaf-seconds, {:.1} keys of places and {:.1} of turns \
                 a leaf-second, {:.0} MB; out of a store of {:.0} MB in {again_s:.2} s ({again_processor_s:.1} s)",
                places as f64 / in_the_air_s,
                turns as f64 / in_the_air_s,
                // Of a place and of a turn: time, value and slope.
                (places as f64 * 22.0 + turns as f64 * 20.0) / 1e6,
                kept.borrow().as_ref().map_or(0, Vec::len) as f64 / 1e6
            );
        }
    }
}
