//! What `benches/figures/` measures, on small pictures.

use crate::growth::{self, ladder_of, with_leaves, with_lights};
use crate::skips::{self, measure};
use crate::{all_light, inputs};
use sunfleck::bench::Stage;
use sunfleck::description;
use sunfleck::scene::{self, Bounces, Scene, Size};
use sunfleck::snapshot::{Exposure, MeshTrees, Shutter};

/// A leaf in the sun above the ground, in fog.
fn leaf_in_fog() -> Scene {
    const SCENE: &str = r#"Scene(
        version: 1,
        meshes: { "leaf": Leaf(length_m: 0.8, width_m: 0.5, curl_deg: 30.0), "ground": Quad(size_m: 8.0) },
        objects: {
            "leaf": (mesh: "leaf", translation_m: (0.0, 1.4, 0.0), rotation_deg: (20.0, 7.5, 10.0)),
            "ground": (mesh: "ground"),
        },
        cameras: { "main": (position_m: (0.0, 1.2, 4.5), look_at_m: (0.0, 1.1, 0.0), fov_deg: 40.0) },
        lights: { "sun": Sun(to_sun: (0.4, 1.0, -0.6), irradiance_w_per_m2: (8.0, 7.2, 6.0)) },
        fog: { "haze": (min_m: (-4.0, 0.0, -4.0), max_m: (4.0, 3.0, 4.0), density_per_m: 0.15, anisotropy: 0.5) },
    )"#;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    std::fs::write(&path, SCENE).unwrap();
    scene::resolve(description::load(&path).unwrap(), None).unwrap().0
}

#[test]
fn whatever_is_skipped_changes_no_bit() {
    let scene = leaf_in_fog();
    let folder = tempfile::tempdir().unwrap();
    let plan = skips::Plan::new(&scene, Size { width: 8, height: 6 }, 1, folder.path());
    let found = measure(&plan).unwrap();
    assert!(found.len() >= 14, "{found:?}");
    for skip in found {
        let bound = match skip.name {
            "samples of pixels that are good enough" => 0.02,
            // Numbers that differ in the last bit; a light of a picometre; rays by themselves, not from
            // slices.
            name if ["grey fog", "lights without extent", "nothing to see through"]
                .iter()
                .any(|start| name.starts_with(start)) =>
            {
                1e-5
            }
            _ => 0.0,
        };
        assert!(skip.difference <= bound, "{skip:?}");
    }
}

/// Walks come to their own reference with more samples; the grid is as near as grids are.
#[test]
fn all_light_comes_both_ways() {
    let scene = leaf_in_fog();
    let trees = MeshTrees::new(&scene);
    let shutter = Shutter { open_s: 0.0, close_s: 0.0 };
    let exposure = Exposure::new(&scene, &trees, 0, 4.0 / 3.0, shutter);
    let size = Size { width: 24, height: 18 };
    let stage =
        Stage { exposure: &exposure, size, mirror_depth: 4, bounces: Bounces::All, planes: (1.0, 1.0) };
    let plan = all_light::Plan { stage, reference_samples: 256, most_samples: 64, rounds: 1 };
    let rows = all_light::measure(&plan).rows;
    let row =
        |way: &str, samples: u32| rows.iter().find(|row| (row.way, row.samples) == (way, samples)).unwrap();
    let (few, many, grid) = (row("paths", 1), row("paths", 64), row("grid", 64));
    assert!(many.errors[0] < 0.5 * few.errors[0], "{rows:?}");
    assert!(many.cpu_s > few.cpu_s && few.cpu_s > 0.0, "{rows:?}");
    assert!((many.mean_ratio - 1.0).abs() < 0.02 && (grid.mean_ratio - 1.0).abs() < 0.1, "{rows:?}");
}

fn plan(scene: &Scene) -> growth::Plan<'_> {
    growth::Plan { scene, size: Size { width: 8, height: 6 }, rounds: 2, longest_s: 5.0 }
}

/// Sum of the squares of the scales of the mesh that is placed most often.
fn area(scene: &Scene) -> (usize, f64) {
    let placements = scene.placements(0.0);
    let mesh = scene.instances[1].mesh;
    let leaves = scene.instances.iter().filter(|instance| instance.mesh == mesh);
    leaves.fold((0, 0.0), |(count, sum), leaf| {
        let scale = placements[leaf.node].world_from_node.matrix3.determinant().cbrt();
        (count + 1, sum + scale * scale)
    })
}

#[test]
fn more_leaves_have_the_same_area_and_leave_the_rest_alone() {
    let scene = inputs::load("leaves500/leaves500.glb");
    let (few, before) = area(&scene);
    let grown = with_leaves(&plan(&scene), 3000);
    let instances = grown.instances.len();
    let (_, after) =
        area(&Scene { instances: grown.instances[instances - 3000..].to_vec(), ..grown.clone() });
    assert_eq!(instances, scene.instances.len() - few + 3000);
    assert!((after / before - 1.0).abs() < 1e-9, "{before} {after}");
}

#[test]
fn lights_share_the_power_of_one() {
    let scene = inputs::load("leaves500/leaves500.glb");
    let many = with_lights(&plan(&scene), 5);
    let power = |scene: &Scene| scene.lights.iter().map(|light| light.power.at(0.0).x).sum::<f64>();
    assert_eq!(many.lights.len(), 5);
    assert!((power(&many) / power(&scene) - 1.0).abs() < 1e-12);
}

#[test]
fn ladders_end_in_time() {
    let scene = inputs::load("leaves500/leaves500.glb");
    let mut asked = Vec::new();
    let points = ladder_of(&plan(&scene), &[1.0, 2.0, 4.0, 8.0], |value| {
        asked.push(value);
        value + if asked.len() < 4 { 1.0 } else { 0.0 }
    });
    // 4 would take 3 * 4 / 2 = 6 seconds.
    assert_eq!(asked, [1.0, 2.0, 1.0, 2.0]);
    assert_eq!(points, [(1.0, 2.0), (2.0, 2.0)]);
}
