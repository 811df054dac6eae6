//! How long 20,000 falling leaves take from the file to their keys, and how many keys they have.

use std::time::Instant;
use sunfleck::description;
use sunfleck::scene::{self, Motion};

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
            let started = Instant::now();
            let (scene, _) = scene::resolve(description::load(&path).unwrap(), None).unwrap();
            let seconds = started.elapsed().as_secs_f64();
            let (mut keys, mut in_the_air_s) = (0, 0.0);
            for node in &scene.nodes {
                if let Motion::Keyed { translation, .. } = &node.motion
                    && let [first_s, .., last_s] = translation.times_s()
                {
                    keys += translation.times_s().len();
                    in_the_air_s += last_s - first_s;
                }
            }
            println!(
                "{name}: {seconds:.2} s; {in_the_air_s:.0} leaf-seconds, {:.1} keys a leaf-second, {:.0} MB of keys",
                keys as f64 / in_the_air_s,
                // Time, value and slope, of place and turn.
                keys as f64 * (7.0 * 8.0 + 9.0 * 8.0) / 1e6
            );
        }
    }
}
