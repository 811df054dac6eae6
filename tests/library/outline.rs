//! What lies between slices. Straight edges, those of leaves and those of shadows are held against the areas
//! of pixels that lie on either side of them.

use crate::common::{EXACT, INSTANT, add_light, camera_at, place};
use glam::{DAffine3, DVec2, DVec3};
use sunfleck::color::Rgb;
use sunfleck::film::Frame;
use sunfleck::render::{Job, Method, Watch, render};
use sunfleck::scene::{
    Instance, LightKind, Material, Mesh, PixelFilter, Sampling, Scene, Size, Triangle, Window,
};
use sunfleck::snapshot::{Exposure, MeshTrees};

const SIZE: Size = Size { width: 32, height: 16 };

/// The wall at `z = -1` shows as the whole picture, two metres high.
const WALL_M: f64 = -1.0;

const SUN: DVec3 = DVec3::new(0.3, 0.9, 0.6);
const LAMP: DVec3 = DVec3::new(0.4, 1.5, 1.0);

/// A line in the picture through a place; what lies to its right, where it does not lean, is dark.
#[derive(Clone, Copy, Debug)]
struct Edge {
    through_px: DVec2,
    leans_rad: f64,
}

impl Edge {
    /// The corners of the dark part on the wall, or enough of it.
    fn corners(self) -> [DVec3; 4] {
        let inwards = DVec2::from_angle(self.leans_rad);
        [(0.0, -99.0), (99.0, -99.0), (99.0, 99.0), (0.0, 99.0)].map(|(ahead, aside)| {
            let at_px = self.through_px + ahead * inwards + aside * inwards.perp();
            let at = (2.0 * at_px - DVec2::new(SIZE.width as f64, SIZE.height as f64)) / SIZE.height as f64;
            DVec3::new(at.x, -at.y, WALL_M)
        })
    }

    /// How much of a pixel is not dark, by points.
    fn bright(self, x: usize, y: usize) -> f64 {
        let steps = 50;
        let points =
            (0..steps * steps).map(|point| DVec2::new((point % steps) as f64, (point / steps) as f64));
        let is_bright = |point: &DVec2| {
            let at = DVec2::new(x as f64, y as f64) + (*point + 0.5) / steps as f64;
            (at - self.through_px).dot(DVec2::from_angle(self.leans_rad)) < 0.0
        };
        points.filter(is_bright).count() as f64 / (steps * steps) as f64
    }
}

/// Steep and flat, along slices and across them.
fn edges() -> impl Iterator<Item = Edge> {
    let through_px = DVec2::new(16.2, 8.3);
    (0..12).map(move |turn| Edge {
        through_px,
        leans_rad: 0.11 + f64::from(turn) * std::f64::consts::TAU / 12.0,
    })
}

/// A white wall before the camera and a light.
fn wall(kind: LightKind, at: DVec3) -> Scene {
    let mut scene = camera_at(DVec3::ZERO);
    add_light(&mut scene, kind, at, -at, Rgb::ONE);
    scene.materials.push(Material { base_color: Rgb::ONE, ..Material::default() });
    scene.materials.push(Material { base_color: Rgb::ZERO, ..Material::default() });
    let corner = |x: f64, y: f64| DVec3::new(x, y, WALL_M);
    add_quad(&mut scene, [corner(-9.0, -9.0), corner(9.0, -9.0), corner(9.0, 9.0), corner(-9.0, 9.0)], 0);
    scene
}

fn add_quad(scene: &mut Scene, corners: [DVec3; 4], material: usize) {
    let node = place(scene, DAffine3::IDENTITY);
    scene.meshes.push(Mesh {
        positions: corners.map(|corner| corner.as_vec3()).to_vec(),
        triangles: [[0, 1, 2], [0, 2, 3]].map(|vertices| Triangle { vertices, material }).to_vec(),
        ..Mesh::default()
    });
    let mesh = scene.meshes.len() - 1;
    scene.instances.push(Instance { node, mesh, material: None, leaf_id: 1, deformation: None });
}

fn picture(scene: &Scene, samples: u32) -> Vec<f64> {
    let trees = MeshTrees::new(scene);
    let exposure = Exposure::new(scene, &trees, 0, 2.0, INSTANT);
    let (window, sampling) = (Window::whole(SIZE), Sampling::Exactly(samples));
    let (filter, method) = (PixelFilter::Box, Method::Slices);
    let job = Job {
        size: SIZE,
        window,
        passes: Vec::new(),
        sampling,
        filter,
        seed: 3,
        mirror_depth: EXACT.mirror_depth,
        bounces: sunfleck::scene::Bounces::NONE,
        method,
    };
    let frame: Frame = render(&exposure, &job, &Watch::NOBODY).frame;
    frame.channel("R").expect("a colour").pixels.iter().map(|&value| f64::from(value)).collect()
}

/// Root of the mean square of how far pixels near the edge are off, and the most, as parts of what is bright.
fn errors(edge: Edge, with: &Scene, without: &Scene, samples: u32) -> (f64, f64) {
    let [with, without] = [with, without].map(|scene| picture(scene, samples));
    let (mut squares, mut most, mut count) = (0.0, 0.0_f64, 0);
    for (index, (x, y)) in Window::whole(SIZE).pixels().enumerate() {
        let bright = edge.bright(x, y);
        if bright > 0.0 && bright < 1.0 {
            let error = (with[index] / without[index] - bright).abs();
            squares += error * error;
            most = most.max(error);
            count += 1;
        }
    }
    ((squares / f64::from(count)).sqrt(), most)
}

fn assert_straight(name: &str, kind: LightKind, at: DVec3, caster: impl Fn([DVec3; 4]) -> [DVec3; 4]) {
    let without = wall(kind, at);
    for (samples, bound) in [(4, 0.015), (16, 0.008)] {
        let (mut squares, mut most, mut count) = (0.0, 0.0_f64, 0);
        for edge in edges() {
            let mut with = without.clone();
            add_quad(&mut with, caster(edge.corners()), 1);
            let (rms, most_here) = errors(edge, &with, &without, samples);
            println!("{name}, {samples} samples, {edge:?}: off by {rms:.4}, {most_here:.4} at most");
            squares += rms * rms;
            most = most.max(most_here);
            count += 1;
        }
        let rms = (squares / f64::from(count)).sqrt();
        println!("{name}, {samples} samples: off by {rms:.4}, {most:.4} at most");
        assert!(rms < bound, "{name}, {samples} samples: {rms}");
    }
}

fn sun() -> LightKind {
    LightKind::Sun
}

/// A little before the wall, so that its shadow hides behind it.
#[test]
fn an_edge_of_a_leaf_is_straight_between_slices() {
    let nearer = |corners: [DVec3; 4]| corners.map(|corner| 0.9999 * corner);
    assert_straight("leaf, sun", sun(), SUN, nearer);
}

#[test]
fn the_edge_of_a_shadow_of_the_sun_is_straight_between_slices() {
    let to_light = SUN.normalize();
    assert_straight("shadow, sun", sun(), SUN, |corners| {
        corners.map(|corner| corner + 1.5 / to_light.z * to_light)
    });
}

#[test]
fn the_edge_of_a_shadow_of_a_lamp_is_straight_between_slices() {
    let kind = LightKind::Point;
    assert_straight("shadow, lamp", kind, LAMP, |corners| corners.map(|corner| corner.lerp(LAMP, 0.75)));
}
