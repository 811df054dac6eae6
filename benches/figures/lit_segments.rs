//! Lit segments against the slow truth: relative RMSE of the in-scattered light over random pixels.

use crate::brute_force::{Place, shadows, triangles};
use crate::inputs::{self, Named};
use glam::DVec3;
use rayon::prelude::*;
use sunfleck::color::Rgb;
use sunfleck::math::Sampler;
use sunfleck::scattering::Source;
use sunfleck::scene::{Light, LightKind, Motion, Node, Track};
use sunfleck::snapshot::{FrozenLight, MeshTrees, Shutter, Snapshot};
use sunfleck::transport::LitSegments;

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
    }
}

fn row(scene_name: &str, light_name: &str, scene: &sunfleck::scene::Scene, rays: u32) {
    let trees = MeshTrees::new(scene);
    let shutter = Shutter { open_s: 0.0, close_s: 0.0 };
    let snapshot = Snapshot::new(scene, &trees, 0, 16.0 / 9.0, shutter);
    let light = snapshot.lights[0].centre();
    let place = match light {
        FrozenLight::Sun { to_light, .. } => Place::Towards(to_light),
        FrozenLight::Point { position, .. } => Place::At(position),
    };
    let triangles = triangles(scene, snapshot.view.eye);
    let pairs: Vec<(f64, f64)> = (0..rays)
        .into_par_iter()
        .filter_map(|index| {
            let (x, y) = Sampler::new(1, 0, 0, index).next_2d();
            let ray = snapshot.view.ray(x, y);
            let hit = snapshot.tree.nearest_hit(&ray, f64::INFINITY, None);
            let distance = hit.map_or(f64::INFINITY, |hit| hit.t);
            let range = snapshot.medium.range(&ray, distance)?;
            let (mut cuts, mut stretches) = (Vec::new(), Vec::new());
            let source: Source = light.source();
            snapshot.medium.stretches(&ray, distance, source, &mut cuts, &mut stretches);
            let mut found = LitSegments::default();
            found.find(&snapshot, &ray, &light, range);
            let truth = LitSegments::from_shadows(shadows(&triangles, &ray, place, range), range);
            let value = |lit: &LitSegments| {
                lit.integrate(&snapshot.medium, &stretches, &ray, &light).element_sum() / 3.0
            };
            Some((value(&found), value(&truth)))
        })
        .collect();
    let mean = pairs.iter().map(|pair| pair.1).sum::<f64>() / pairs.len() as f64;
    let square = pairs.iter().map(|pair| (pair.0 - pair.1).powi(2)).sum::<f64>() / pairs.len() as f64;
    let largest = pairs.iter().map(|pair| (pair.0 - pair.1).abs()).fold(0.0, f64::max);
    println!(
        "{scene_name:<12} {light_name:<6} {:>6} {:>12.2e} {:>12.2e}",
        pairs.len(),
        square.sqrt() / mean,
        largest / mean
    );
}
