//! Lit segments against the slow truth: relative RMSE of the in-scattered light over random pixels.

use crate::inputs::{self, Named};
use glam::DVec3;
use sunfleck::bench::brute_force::{deviation, triangles};
use sunfleck::color::Rgb;
use sunfleck::scene::{Light, LightKind, Motion, Node, Track};
use sunfleck::snapshot::{MeshTrees, Shutter, Snapshot};

/// Prints a row for each scene and light: rays, relative RMSE, largest relative error.
pub fn run(rays: u32) {
    println!("{:<12} {:<6} {:>6} {:>12} {:>12}", "scene", "light", "rays", "relRMSE", "largest");
    for Named { name, mut scene } in inputs::reference_scenes() {
        row(&name, "sun", &scene, rays);
        // A lamp among the leaves instead of the sun.
        let lamp = DVec3::new(1.5, 4.0, -1.0);
        scene.nodes.push(Node {
            name: "lamp".into(),
            parent: None,
            motion: Motion::Still(glam::DAffine3::from_translation(lamp)),
            visible: Track::from(true),
        });
        let node = scene.nodes.len() - 1;
        let power = Track::from(Rgb::splat(100.0));
        scene.lights = vec![Light { name: "lamp".into(), node, power, kind: LightKind::Point }];
        row(&name, "point", &scene, rays);
        // The same in fog that scatters almost straight on, where the phase function is sharpest.
        for fog in &mut scene.fogs {
            fog.anisotropy = Track::from(0.99);
        }
        row(&name, "g .99", &scene, rays);
    }
}

fn row(scene_name: &str, light_name: &str, scene: &sunfleck::scene::Scene, rays: u32) {
    let trees = MeshTrees::new(scene);
    let shutter = Shutter { open_s: 0.0, close_s: 0.0 };
    let snapshot = Snapshot::new(scene, &trees, 0, 16.0 / 9.0, shutter);
    let triangles = triangles(scene, snapshot.view.eye, 0.0);
    let found = deviation(&snapshot, &triangles, &snapshot.lights[0], rays, 1);
    println!(
        "{scene_name:<12} {light_name:<6} {:>6} {:>12.2e} {:>12.2e}",
        found.rays, found.relative_rmse, found.largest
    );
}
