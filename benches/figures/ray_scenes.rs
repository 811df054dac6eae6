//! The scenes that rays are timed on, made from the plain numbers of `tests/data/leaves500`.

use crate::checkout;
use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use serde::Deserialize;
use std::sync::Arc;
use sunfleck::accel::{InstanceTree, MeshTree, PlacedMesh};
use sunfleck::math::{Ray, Sampler};

/// The numbers of the reference scene.
#[derive(Deserialize)]
struct Numbers {
    leaf_vertices: Vec<[f64; 3]>,
    leaf_faces: Vec<[u32; 3]>,
    /// Row-major 4x4 matrices.
    instances: Vec<[[f64; 4]; 4]>,
    ground: Ground,
    camera: Camera,
    sun: Sun,
}

#[derive(Deserialize)]
struct Ground {
    half: f32,
}

#[derive(Deserialize)]
struct Camera {
    origin: [f64; 3],
    target: [f64; 3],
    vfov_deg: f64,
}

#[derive(Deserialize)]
struct Sun {
    to_sun: [f64; 3],
}

/// A scene to send rays into, in relative space.
pub struct RayScene {
    /// For tables.
    pub name: &'static str,
    /// Everything.
    pub tree: InstanceTree,
    /// Unit vector.
    pub to_sun: DVec3,
    /// A lamp among the leaves.
    pub lamp: DVec3,
    camera: (DVec3, DMat3, f64),
}

impl RayScene {
    /// The camera ray through a film position in `[0, 1]^2`, on a film of 16 to 9.
    pub fn camera_ray(&self, x: f64, y: f64) -> Ray {
        let (_, axes, half_height) = self.camera;
        let film =
            DVec3::new((2.0 * x - 1.0) * half_height * 16.0 / 9.0, (1.0 - 2.0 * y) * half_height, -1.0);
        Ray { origin: DVec3::ZERO, direction: (axes * film).normalize() }
    }

    /// A point in the air among the leaves, from three numbers in `[0, 1]`.
    pub fn in_air(&self, x: f64, y: f64, z: f64) -> DVec3 {
        DVec3::new(-9.0 + 18.0 * x, 0.1 + 6.9 * y, -9.0 + 18.0 * z) - self.camera.0
    }
}

/// 500 leaves of 132 triangles above a ground, and 20,000 of them.
pub fn both() -> Vec<RayScene> {
    let path = checkout::file("tests/data/leaves500/leaves500.json");
    let numbers: Numbers = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let few = numbers.instances.iter().map(|rows| {
        let column = |j: usize| DVec3::new(rows[0][j], rows[1][j], rows[2][j]);
        DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) }
    });
    let few: Vec<DAffine3> = few.collect();
    let many = (0..20_000).map(|leaf| {
        let mut random = Sampler::new(20, leaf, 0, 0);
        let ((x, z), y) = (random.next_2d(), random.next_1d());
        let at = DVec3::new(-9.0 + 18.0 * x, 3.5 + 3.5 * y, -9.0 + 14.0 * z);
        let scale = 0.35 * (0.7 + 0.6 * random.next_1d());
        // Shoemake's uniform rotation.
        let ((u, v), w) = (random.next_2d(), random.next_1d());
        let (s, t) = (std::f64::consts::TAU * v, std::f64::consts::TAU * w);
        let (a, b) = ((1.0 - u).sqrt(), u.sqrt());
        let rotation = DQuat::from_xyzw(a * s.sin(), a * s.cos(), b * t.sin(), b * t.cos());
        DAffine3::from_scale_rotation_translation(DVec3::splat(scale), rotation, at)
    });
    let many: Vec<DAffine3> = many.collect();
    vec![scene("leaves500", &numbers, &few), scene("canopy20k", &numbers, &many)]
}

fn scene(name: &'static str, numbers: &Numbers, world_from_leaf: &[DAffine3]) -> RayScene {
    let positions: Vec<Vec3> =
        numbers.leaf_vertices.iter().map(|v| DVec3::from_array(*v).as_vec3()).collect();
    let leaf = Arc::new(MeshTree::new(&positions, &numbers.leaf_faces));
    let half = numbers.ground.half;
    let corners = [(-half, -half), (half, -half), (half, half), (-half, half)];
    let corners = corners.map(|(x, z)| Vec3::new(x, 0.0, z));
    let ground = Arc::new(MeshTree::new(&corners, &[[0, 1, 2], [0, 2, 3]]));
    let origin = DVec3::from_array(numbers.camera.origin);
    let relative_from_world = DAffine3::from_translation(-origin);
    let mut placed: Vec<PlacedMesh> = world_from_leaf
        .iter()
        .map(|world_from_leaf| PlacedMesh {
            mesh: leaf.clone(),
            relative_from_mesh: relative_from_world * *world_from_leaf,
        })
        .collect();
    placed.push(PlacedMesh { mesh: ground, relative_from_mesh: relative_from_world });
    let backwards = (origin - DVec3::from_array(numbers.camera.target)).normalize();
    let right = DVec3::Y.cross(backwards).normalize();
    let axes = DMat3::from_cols(right, backwards.cross(right), backwards);
    RayScene {
        name,
        tree: InstanceTree::new(placed),
        to_sun: DVec3::from_array(numbers.sun.to_sun).normalize(),
        lamp: DVec3::new(1.5, 4.0, -1.0) - origin,
        camera: (origin, axes, (numbers.camera.vfov_deg.to_radians() / 2.0).tan()),
    }
}
