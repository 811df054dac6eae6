//! Tangents against those that Blender computes, smooth, and flat in a mirrored place. The left half of the
//! mesh has the texture of its right half, mirrored.

use crate::blender::samples::path;
use glam::Vec3;
use serde_json::Value;
use sunfleck::description;
use sunfleck::math::Sampler;
use sunfleck::scene::{self, Mesh, Scene};
use sunfleck::snapshot::{MeshTrees, Shutter, Snapshot};
use sunfleck::transport::{Scratch, Transport, VolumeMethod, radiance};

/// Of unit vectors.
const BAR: f32 = 1e-5;
/// Where a corner stands and what it shows, to tell it from others.
const SAME_CORNER: f32 = 2e-6;

fn load(name: &str) -> Scene {
    let description = description::load(&path(name)).unwrap();
    scene::resolve(description, None).unwrap().0
}

/// Position, normal, texture coordinates, tangent and side of every corner, three a triangle.
fn truth() -> Value {
    serde_json::from_slice(&std::fs::read(path("j_tangents.gt.json")).unwrap()).unwrap()
}

/// How far the tangents of a mesh are from Blender's, and how many were compared.
fn compare(mesh: &Mesh, corners: &[Vec<f32>]) -> (f32, usize) {
    let (mut worst, mut compared) = (0.0_f32, 0);
    for triangle in &mesh.triangles {
        let is_same = |vertex: u32, corner: &[f32]| {
            let (position, uv) = (mesh.positions[vertex as usize], mesh.uvs[vertex as usize]);
            let shown = [position.x, position.y, position.z, uv.x, uv.y];
            let known = [corner[0], corner[1], corner[2], corner[6], corner[7]];
            shown.iter().zip(known).all(|(a, b)| (a - b).abs() <= SAME_CORNER)
        };
        let find = |vertex: u32, of: &[Vec<f32>]| of.iter().position(|corner| is_same(vertex, corner));
        let theirs = corners
            .chunks_exact(3)
            .find(|theirs| triangle.vertices.iter().all(|vertex| find(*vertex, theirs).is_some()))
            .unwrap_or_else(|| panic!("{triangle:?} is none of Blender's"));
        for vertex in triangle.vertices {
            let corner = &theirs[find(vertex, theirs).unwrap()];
            let ours = mesh.tangents[vertex as usize];
            worst = worst.max(ours.truncate().distance(Vec3::from_slice(&corner[8..11])));
            assert_eq!(ours.w, corner[11], "{corner:?}");
            compared += 1;
        }
    }
    (worst, compared)
}

#[test]
fn tangents_are_blenders() {
    let truth = truth();
    for file in ["j_tangents.glb", "j_tangents_given.glb"] {
        let scene = load(file);
        for (name, corners) in truth.as_object().unwrap() {
            let corners: Vec<Vec<f32>> = serde_json::from_value(corners.clone()).unwrap();
            let mesh = scene.meshes.iter().find(|mesh| mesh.name == *name).unwrap();
            let (worst, compared) = compare(mesh, &corners);
            assert_eq!(compared, corners.len(), "{file}, {name}");
            assert!(worst <= BAR, "{file}, {name}: {worst:.1e}");
        }
        let sides = |side: f32| scene.meshes[0].tangents.iter().filter(|tangent| tangent.w == side).count();
        assert!(sides(1.0) > 10 && sides(-1.0) > 10, "the texture is mirrored");
    }
}

/// What rays see of the file, which asks for tangents to be made, and of the same with Blender's own.
#[test]
fn made_and_given_tangents_show_the_same() {
    let transport =
        Transport { volume: VolumeMethod::Segments, mirror_depth: 0, indirect: None, features: true };
    let picture = |scene: &Scene| {
        let trees = MeshTrees::new(scene);
        let snapshot = Snapshot::new(scene, &trees, 0, 1.5, Shutter { open_s: 0.0, close_s: 0.0 });
        let look = |pixel: usize| {
            let film = (((pixel % 48) as f64 + 0.437) / 48.0, ((pixel / 48) as f64 + 0.561) / 32.0);
            let mut sampler = Sampler::new(0, 0, 0, 0);
            let sample = radiance(
                &snapshot,
                &transport,
                &snapshot.view.ray(film.0, film.1),
                &mut sampler,
                &mut Scratch::default(),
            );
            sample.surface.map(|surface| (surface.normal, sample.radiance))
        };
        (0..48 * 32).map(look).collect::<Vec<_>>()
    };
    let made = load("j_tangents.glb");
    let mut plain = made.clone();
    plain.meshes.iter_mut().for_each(|mesh| mesh.tangents.clear());
    let (pictures, plain) = ([picture(&made), picture(&load("j_tangents_given.glb"))], picture(&plain));
    let (mut seen, mut bent) = (0, 0);
    for ((made, given), plain) in pictures[0].iter().zip(&pictures[1]).zip(&plain) {
        let (Some(made), Some(given), Some(plain)) = (made, given, plain) else {
            assert_eq!(made.is_some(), given.is_some());
            continue;
        };
        seen += 1;
        bent += usize::from(made.0.dot(plain.0) < 0.99);
        assert!(made.0.distance(given.0) < 1e-4, "{made:?} {given:?}");
        assert!((made.1 - given.1).abs().max_element() < 1e-4, "{made:?} {given:?}");
    }
    assert!(seen > 200 && bent > seen / 2, "{bent} of {seen} rays see a bent normal");
}
