//! Meshes that change their shape look, at every moment, like the same meshes made in that shape.

use crate::checkout;
use glam::DVec3;
use std::sync::Arc;
use sunfleck::color::Rgb;
use sunfleck::math::Sampler;
use sunfleck::scene::{self, LightKind, Mesh, Motion, Scene};
use sunfleck::snapshot::{Exposure, MeshTrees, Shutter, Snapshot};
use sunfleck::transport::{Scratch, radiance};

/// A sample from Blender in the sun and in fog.
fn foggy(file: &str) -> Scene {
    let path = checkout::file("tests/data/blender").join(file);
    let (mut scene, _) = scene::resolve(sunfleck::description::load(&path).unwrap(), None).unwrap();
    crate::common::add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::new(-0.3, -1.0, -0.2), Rgb::ONE);
    let extent = DVec3::splat(3.0);
    crate::common::add_fog(&mut scene, -extent, extent, Rgb::splat(0.1), Rgb::ONE, 0.3);
    // Close to what bends.
    let (centre, size) = bounds(&scene, 0.5);
    let camera = &scene.cameras[0];
    scene.nodes[camera.node].motion = Motion::Aimed {
        position: (centre + DVec3::splat(size)).into(),
        target: centre.into(),
        up: DVec3::Y.into(),
    };
    scene
}

/// Middle and extent of the first that bends.
fn bounds(scene: &Scene, time_s: f64) -> (DVec3, f64) {
    let placements = scene.placements(time_s);
    let bent = scene.instances.iter().filter(|instance| instance.deformation.is_some()).take(1);
    let points: Vec<DVec3> = bent
        .flat_map(|instance| {
            let (positions, world) = scene.vertices(instance, &placements, time_s);
            positions.iter().map(|p| world.transform_point3(p.as_dvec3())).collect::<Vec<_>>()
        })
        .collect();
    let low = points.iter().copied().reduce(DVec3::min).unwrap();
    let high = points.iter().copied().reduce(DVec3::max).unwrap();
    (0.5 * (low + high), (high - low).length())
}

/// The scene at a time, with nothing in it that bends.
fn frozen(scene: &Scene, time_s: f64) -> Scene {
    let mut frozen = scene.clone();
    let placements = scene.placements(time_s);
    for (node, placement) in frozen.nodes.iter_mut().zip(&placements) {
        (node.parent, node.motion) = (None, Motion::Still(placement.world_from_node));
    }
    for index in 0..scene.instances.len() {
        let instance = &scene.instances[index];
        let Some(deformation) = &instance.deformation else { continue };
        let mesh = &scene.meshes[instance.mesh];
        let (pose, world_from_shape) = deformation.pose(&placements, instance.node, time_s);
        let shape = deformation.shape(mesh, &pose);
        frozen.meshes.push(Mesh { positions: shape.positions, normals: shape.normals, ..mesh.clone() });
        let node = crate::common::place(&mut frozen, world_from_shape);
        let placed = &mut frozen.instances[index];
        (placed.mesh, placed.node, placed.deformation) = (frozen.meshes.len() - 1, node, None);
    }
    frozen
}

/// Every value that rays through the picture have.
fn values(snapshot: &Snapshot) -> Vec<(Rgb, f64)> {
    let rays = (0..40 * 30).map(|index| ((index % 40) as f64 / 40.0, (index / 40) as f64 / 30.0));
    rays.map(|(x, y)| {
        let ray = snapshot.view.ray(x, y);
        let mut sampler = Sampler::new(0, 0, 0, 0);
        let sample = radiance(snapshot, &crate::common::EXACT, &ray, &mut sampler, &mut Scratch::default());
        (sample.radiance, sample.alpha)
    })
    .collect()
}

#[test]
fn every_moment_is_the_picture_of_the_mesh_made_in_that_shape() {
    for file in ["c_morph.glb", "d_skin.glb"] {
        let scene = foggy(file);
        let trees = MeshTrees::new(&scene);
        let shutter = Shutter { open_s: 0.46875, close_s: 0.53125 };
        let exposure = Exposure::new(&scene, &trees, 0, 4.0 / 3.0, shutter);
        let count = exposure.moments().len();
        let mut pictures = Vec::new();
        for moment in [0, 7, count - 1] {
            let time_s = 0.46875 + 0.0625 * (moment as f64 + 0.5) / count as f64;
            let frozen = frozen(&scene, time_s);
            let instant = Shutter { open_s: time_s, close_s: time_s };
            let expected = Snapshot::new(&frozen, &MeshTrees::new(&frozen), 0, 4.0 / 3.0, instant);
            let picture = values(&exposure.moments()[moment]);
            assert!(picture == values(&expected), "{file}: moment {moment} differs");
            assert!(
                picture.iter().filter(|(_, alpha)| *alpha == 1.0).count() > 20,
                "{file}: nothing is seen"
            );
            pictures.push(picture);
        }
        assert!(pictures[0] != pictures[1] && pictures[1] != pictures[2], "{file}: nothing bends");
    }
}

#[test]
fn nodes_that_share_a_mesh_bend_it_each_in_its_own_way() {
    let mut scene = foggy("c_morph.glb");
    let first = scene.instances.iter().position(|instance| instance.deformation.is_some()).unwrap();
    let mut other = scene.instances[first].clone();
    let deformation = Arc::make_mut(other.deformation.as_mut().unwrap());
    deformation.weights = vec![0.0.into(); deformation.weights.len()];
    let mesh = scene.meshes[other.mesh].clone();
    scene.instances.push(other);
    let placements = scene.placements(1.0);
    let shape = |index: usize| scene.vertices(&scene.instances[index], &placements, 1.0).0.into_owned();
    assert_eq!(shape(scene.instances.len() - 1), mesh.positions);
    assert_ne!(shape(first), mesh.positions);
}
