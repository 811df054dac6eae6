//! The same scene as Blender writes it plain, with Draco, and through gltfpack (meshopt and quantised
//! numbers). The same leaves are in the same places, to what the compression keeps. And damaged streams.

use crate::checkout;
use glam::{DVec2, DVec3};
use proptest::prelude::*;
use std::path::PathBuf;
use sunfleck::description::{self, Files, SceneSource, gltf};
use sunfleck::scene::{self, Scene};

/// Corners are kept to 14 bits of the leaf's 0.1 m, in each axis.
const TOLERANCE_M: f64 = 1e-5;
/// Texture coordinates are kept to 12 bits.
const TOLERANCE_UV: f64 = 3e-4;

fn sample(name: &str) -> PathBuf {
    checkout::file("tests/data/blender").join(name)
}

/// The scene with its triangles as the file has them: an outline would follow its mask's texture
/// coordinates, and they are kept to fewer bits.
fn load(name: &str) -> Scene {
    let mut description = description::load(&sample(name)).unwrap();
    let SceneSource::Gltf(file) = &mut description.scene else { panic!("{name} is no glTF file") };
    file.materials.iter_mut().for_each(|material| material.alpha_mode = gltf::AlphaMode::Opaque);
    scene::resolve(description, None).unwrap().0
}

/// The middle of every triangle in the world at a moment, and that of its texture coordinates.
fn middles(scene: &Scene, time_s: f64) -> Vec<(DVec3, DVec2)> {
    let placements = scene.placements(time_s);
    let mut middles = Vec::new();
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh];
        for triangle in &mesh.triangles {
            let corners = triangle.vertices.map(|vertex| vertex as usize);
            let position: DVec3 = corners.iter().map(|&at| mesh.positions[at].as_dvec3()).sum();
            let uv: DVec2 = corners.iter().map(|&at| mesh.uvs[at].as_dvec2()).sum();
            let world = placements[instance.node].world_from_node.transform_point3(position / 3.0);
            middles.push((world, uv / 3.0));
        }
    }
    middles
}

/// How far triangles are from their counterparts in the plain file at most, metres and texture coordinates.
fn worst_difference(name: &str, frame: f64) -> (f64, f64) {
    let (expected, mut found) =
        (middles(&load("f_plain.glb"), frame / 24.0), middles(&load(name), frame / 24.0));
    assert_eq!(found.len(), expected.len(), "{name}");
    let mut worst = (0.0_f64, 0.0_f64);
    for (position, uv) in expected {
        let distances = found.iter().map(|other| other.0.distance(position));
        let (at, distance) = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        // Each triangle has one of its own.
        let (_, other_uv) = found.swap_remove(at);
        worst = (worst.0.max(distance), worst.1.max(other_uv.distance(uv)));
    }
    println!("{name}, frame {frame}: {:.2e} m, texture coordinates {:.2e}", worst.0, worst.1);
    worst
}

#[test]
fn draco_leaves_are_where_the_plain_ones_are() {
    for frame in [1.0, 5.5, 12.0] {
        let (metres, uv) = worst_difference("f_draco.glb", frame);
        assert!(metres < TOLERANCE_M && uv < TOLERANCE_UV);
    }
}

#[test]
fn gltfpack_leaves_are_where_the_plain_ones_are() {
    // gltfpack keeps 30 poses a second: the first frame is among them, later ones lie in between.
    let (metres, uv) = worst_difference("f_meshopt_quant.glb", 1.0);
    assert!(metres < TOLERANCE_M && uv < TOLERANCE_UV);
}

/// Where the compressed bytes of a file begin and end: after the JSON, and before the animation.
fn compressed_bytes(bytes: &[u8]) -> std::ops::Range<usize> {
    let glb = ::gltf::Glb::from_slice(bytes).unwrap();
    let binary = glb.bin.unwrap();
    bytes.len() - binary.len()..bytes.len()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_streams_never_panic(
        draco in any::<bool>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let path = sample(if draco { "f_draco.glb" } else { "f_meshopt_quant.glb" });
        let mut bytes = std::fs::read(&path).unwrap();
        let range = compressed_bytes(&bytes);
        for (at, byte) in changes {
            bytes[range.start + at.index(range.len())] = byte;
        }
        // Either is right; that there is an answer is what counts.
        let _ = gltf::parse(&bytes, &path, &mut Files::default());
    }
}
