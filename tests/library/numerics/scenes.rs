//! Scenes of the stress tests: a cloud of leaves above a ground, in fog, with one light. They are placed,
//! scaled and lit as a test asks.

use crate::common::{add_fog, add_light, camera_at, place};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use sunfleck::color::Rgb;
use sunfleck::math::Sampler;
use sunfleck::scene::{Instance, LightKind, Material, Mesh, Scene, Triangle};

/// A sun that stands high, beside the picture.
pub(crate) const HIGH_SUN: Lamp = Lamp::Sun { to_sun: DVec3::new(0.35, 0.9, -0.4) };

/// A lamp among the leaves.
pub(crate) const LAMP: Lamp = Lamp::Point { position: DVec3::new(0.4, 1.1, -4.3) };

/// The light of a scene.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Lamp {
    Sun { to_sun: DVec3 },
    Point { position: DVec3 },
}

/// A scene is described in its own metres and then scaled and moved as a whole.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub(crate) scale: f64,
    pub(crate) offset: DVec3,
}

impl Frame {
    pub(crate) const HERE: Self = Self { scale: 1.0, offset: DVec3::ZERO };

    pub(crate) fn point(&self, p: DVec3) -> DVec3 {
        self.offset + self.scale * p
    }

    fn placed(&self, local: DAffine3) -> DAffine3 {
        DAffine3::from_translation(self.offset) * DAffine3::from_scale(DVec3::splat(self.scale)) * local
    }
}

/// A camera at the frame's origin with a right angle of view along -Z, and nothing else.
pub(crate) fn empty(frame: &Frame) -> Scene {
    let mut scene = camera_at(frame.offset);
    scene.materials.push(Material { base_color: Rgb::new(0.8, 0.5, 0.2), ..Material::default() });
    scene
}

/// Adds a mesh; returns its index.
pub(crate) fn add_mesh(scene: &mut Scene, positions: Vec<Vec3>, triangles: &[[u32; 3]]) -> usize {
    let triangles = triangles.iter().map(|vertices| Triangle { vertices: *vertices, material: 0 }).collect();
    scene.meshes.push(Mesh { positions, triangles, ..Mesh::default() });
    scene.meshes.len() - 1
}

/// Places a mesh in a frame.
pub(crate) fn add_instance(scene: &mut Scene, mesh: usize, frame: &Frame, local: DAffine3) {
    let node = place(scene, frame.placed(local));
    let leaf_id = scene.instances.len() as u32 + 1;
    scene.instances.push(Instance { node, mesh, material: None, leaf_id, deformation: None });
}

/// A mesh of its own for some triangles, placed as they are.
pub(crate) fn add_triangles(scene: &mut Scene, frame: &Frame, triangles: &[[Vec3; 3]]) {
    let positions = triangles.iter().flatten().copied().collect();
    let indices: Vec<[u32; 3]> = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mesh = add_mesh(scene, positions, &indices);
    add_instance(scene, mesh, frame, DAffine3::IDENTITY);
}

/// Grey fog between two corners.
pub(crate) fn fog(scene: &mut Scene, frame: &Frame, low: DVec3, high: DVec3, sigma_t: f64, g: f64) {
    let sigma_t = Rgb::splat(sigma_t / frame.scale);
    add_fog(scene, frame.point(low), frame.point(high), sigma_t, Rgb::splat(0.8), g);
}

/// Adds the light, of a power that gives the same radiance in every frame.
pub(crate) fn light(scene: &mut Scene, frame: &Frame, lamp: Lamp) {
    match lamp {
        Lamp::Sun { to_sun } => {
            add_light(scene, LightKind::Sun, frame.offset, -to_sun, Rgb::new(5.0, 4.0, 3.0));
        }
        Lamp::Point { position } => {
            let power = Rgb::new(5.0, 4.0, 3.0) * frame.scale * frame.scale;
            add_light(scene, LightKind::Point, frame.point(position), DVec3::NEG_Z, power);
        }
    }
}

/// A curled leaf of 28 triangles, a metre long, folded along the middle.
pub(crate) fn leaf() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let rows = 8_u32;
    let mut positions = Vec::new();
    for row in 0..=rows {
        let along = row as f32 / rows as f32;
        let width =
            0.3 * (std::f32::consts::PI * along).sin() + if row == 0 || row == rows { 0.0 } else { 0.02 };
        let height = 0.2 * (2.0 * along).sin();
        for side in [-1.0, 0.0, 1.0_f32] {
            positions.push(Vec3::new(side * width, height + 0.1 * side.abs() * width, along - 0.5));
        }
    }
    let mut triangles = Vec::new();
    for row in 0..rows {
        for side in 0..2 {
            let corner = 3 * row + side;
            triangles.extend([[corner, corner + 1, corner + 4], [corner, corner + 4, corner + 3]]);
        }
    }
    (positions, triangles)
}

/// Forty leaves above a ground, in fog that holds the camera.
pub(crate) fn grove(frame: &Frame, lamp: Lamp) -> Scene {
    let mut scene = empty(frame);
    let (positions, triangles) = leaf();
    let mesh = add_mesh(&mut scene, positions, &triangles);
    for number in 0..40 {
        let mut random = Sampler::new(5, number, 0, 0);
        let ((x, z), y) = (random.next_2d(), random.next_1d());
        let at = DVec3::new(8.0 * x - 4.0, 4.0 * y - 1.0, -2.0 - 6.0 * z);
        let axis = vector(&mut random);
        let turned = DAffine3::from_scale_rotation_translation(
            DVec3::splat(0.4 + 0.6 * random.next_1d()),
            DQuat::from_scaled_axis(3.0 * axis),
            at,
        );
        add_instance(&mut scene, mesh, frame, turned);
    }
    let ground = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]].map(|[x, z]| Vec3::new(x, -1.5, z));
    let ground = add_mesh(&mut scene, ground.into(), &[[0, 1, 2], [0, 2, 3]]);
    add_instance(&mut scene, ground, frame, DAffine3::IDENTITY);
    fog(&mut scene, frame, DVec3::new(-6.0, -1.5, -10.0), DVec3::new(6.0, 4.0, 1.0), 0.15, 0.6);
    light(&mut scene, frame, lamp);
    scene
}

/// A vector of the cube `[-1, 1]^3`.
pub(crate) fn vector(random: &mut Sampler) -> DVec3 {
    let ((x, y), z) = (random.next_2d(), random.next_1d());
    2.0 * DVec3::new(x, y, z) - 1.0
}

/// Places spread evenly over the film.
pub(crate) fn spread(count: u32) -> impl Iterator<Item = (f64, f64)> {
    (0..count).map(|index| Sampler::new(9, 0, 0, index).next_2d())
}
