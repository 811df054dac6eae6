//! Meshes that change their shape, vertex by vertex.

use crate::blender::samples;
use crate::blender::truth::Truth;
use glam::DVec3;
use serde_json::Value;
use std::collections::BTreeSet;
use sunfleck::{description, scene};

/// Metres, at whole frames; between them exporter's samples are joined by straight lines.
const AT_WHOLE_FRAMES: f64 = 1e-5;
const BETWEEN_FRAMES: f64 = 1e-2;

fn point(numbers: &Value) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|axis| numbers[axis].as_f64().unwrap()))
}

#[test]
fn skinned_and_morphed_vertices_are_where_blender_has_them() {
    for (file, truth, meshes) in [("c_morph.glb", "c_morph.gt.json", 2), ("d_skin.glb", "d_skin.gt.json", 1)]
    {
        let description = description::load(&samples::path(file)).unwrap();
        let (scene, settings) = scene::resolve(description, None).unwrap();
        let mut compared = 0;
        let mut moved = 0.0_f64;
        for frame in Truth::read(truth).frames() {
            let number = frame["frame"].as_f64().unwrap();
            let bar = if number.fract() == 0.0 { AT_WHOLE_FRAMES } else { BETWEEN_FRAMES };
            let time_s = settings.frame_rate.seconds(number);
            let placements = scene.placements(time_s);
            for (name, object) in frame["objects"].as_object().unwrap() {
                let Some(expected) = object.get("verts_world") else { continue };
                let instance = scene.instances.iter().find(|i| scene.nodes[i.node].name == *name).unwrap();
                let (positions, world_from_shape) = scene.vertices(instance, &placements, time_s);
                let ours: Vec<DVec3> =
                    positions.iter().map(|p| world_from_shape.transform_point3(p.as_dvec3())).collect();
                for theirs in expected["pos"].as_object().unwrap().values().map(point) {
                    let nearest = ours.iter().map(|ours| ours.distance(theirs)).fold(f64::INFINITY, f64::min);
                    assert!(nearest <= bar, "{file}, frame {number}, `{name}`: {nearest:.1e}");
                    compared += 1;
                }
                // Exporters split vertices: those that lie in one place at rest are one of Blender's.
                let mut seen = BTreeSet::new();
                let rest = &scene.meshes[instance.mesh].positions;
                let distinct: Vec<DVec3> = rest
                    .iter()
                    .zip(&ours)
                    .filter(|(rest, _)| seen.insert(rest.to_array().map(f32::to_bits)))
                    .map(|(_, ours)| *ours)
                    .collect();
                assert_eq!(distinct.len() as u64, expected["n"].as_u64().unwrap());
                let low = ours.iter().copied().reduce(DVec3::min).unwrap();
                let high = ours.iter().copied().reduce(DVec3::max).unwrap();
                let centre = distinct.iter().sum::<DVec3>() / distinct.len() as f64;
                for (ours, theirs) in [(low, "bbox_min"), (high, "bbox_max"), (centre, "centroid")] {
                    let difference = (ours - point(&expected[theirs])).abs().max_element();
                    assert!(
                        difference <= bar,
                        "{file}, frame {number}, {theirs} of `{name}`: {difference:.1e}"
                    );
                }
                let still =
                    |p: &glam::Vec3| placements[instance.node].world_from_node.transform_point3(p.as_dvec3());
                let bent = rest.iter().zip(&ours).map(|(rest, ours)| still(rest).distance(*ours));
                moved = moved.max(bent.fold(0.0, f64::max));
            }
        }
        assert!(compared >= 5 * 7 * meshes, "{file}: {compared} compared");
        assert!(moved > 1e-2, "{file}: nothing bends");
    }
}
