//! One leaf, said in every way that glTF 2.0 allows (tests/data/make_gltf.py). Each file must give the
//! picture of the plain one, seen by the same rays.

use crate::checkout;
use crate::common::{EXACT, INSTANT};
use std::collections::BTreeMap;
use std::path::PathBuf;
use sunfleck::color::Rgb;
use sunfleck::math::Sampler;
use sunfleck::snapshot::{MeshTrees, Snapshot};
use sunfleck::transport::{Scratch, radiance};
use sunfleck::{description, scene};

const WIDTH: usize = 32;
const HEIGHT: usize = 18;
/// Places are single precision, and some files scale them.
const TOLERANCE: f64 = 1e-5;

/// What a ray sees.
#[derive(Clone, Copy)]
struct Seen {
    depth_m: Option<f64>,
    radiance: Rgb,
}

impl Seen {
    fn differs_from(&self, other: &Self) -> bool {
        let depth = self.depth_m.unwrap_or(0.0) - other.depth_m.unwrap_or(0.0);
        self.depth_m.is_some() != other.depth_m.is_some()
            || depth.abs() > TOLERANCE
            || (self.radiance - other.radiance).abs().max_element() > TOLERANCE
    }
}

fn folder() -> PathBuf {
    checkout::file("tests/data/valid/gltf/same")
}

fn picture(name: &str) -> Vec<Seen> {
    let description =
        description::load(&folder().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    let (scene, settings) =
        scene::resolve(description, None).unwrap_or_else(|error| panic!("{name}: {error}"));
    let camera = settings.camera.map_or(0, |name| {
        scene.cameras.iter().position(|camera| camera.name == name).expect("the camera that is asked for")
    });
    let aspect = WIDTH as f64 / HEIGHT as f64;
    let trees = MeshTrees::new(&scene);
    let snapshot = Snapshot::new(&scene, &trees, camera, aspect, INSTANT);
    let mut scratch = Scratch::default();
    let mut look = |x: usize, y: usize| {
        // Off the centres, so that no ray meets an edge.
        let film = ((x as f64 + 0.437) / WIDTH as f64, (y as f64 + 0.561) / HEIGHT as f64);
        let ray = snapshot.view.ray(film.0, film.1);
        let sample = radiance(&snapshot, &EXACT, &ray, &mut Sampler::new(0, 0, 0, 0), &mut scratch);
        Seen { depth_m: sample.surface.map(|surface| surface.depth_m), radiance: sample.radiance }
    };
    (0..HEIGHT * WIDTH).map(|pixel| look(pixel % WIDTH, pixel / WIDTH)).collect()
}

#[test]
fn every_way_to_say_it_gives_the_same_picture() {
    let plain = picture("plain.gltf");
    let lit = plain.iter().filter(|seen| seen.depth_m.is_some() && seen.radiance.min_element() > 0.0).count();
    assert!(lit > 50, "the leaf is hardly seen: {lit} rays");

    let mut files = 0;
    let mut wrong = BTreeMap::new();
    for entry in std::fs::read_dir(folder()).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        if name.ends_with(".bin") {
            continue;
        }
        files += 1;
        let rays = picture(&name).iter().zip(&plain).filter(|(a, b)| a.differs_from(b)).count();
        if rays > 0 {
            wrong.insert(name, rays);
        }
    }
    assert!(files >= 60, "{files} files");
    assert!(wrong.is_empty(), "rays that differ: {wrong:?}");
}
