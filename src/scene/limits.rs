//! Limits of a scene's size, and of its lenses. In goes a resolved scene, out come errors with places.
//! Invariant: in a valid scene, squares of lengths stay finite in single precision in trees and triangles.

use super::{Camera, Lens, Light, Motion, Scene, Track};
use crate::description::ron::{FIELDS_OF_VIEW_DEG, NEAREST_FOCUS_M, SMALLEST_F_STOP};
use crate::diagnostic::{Diagnostic, Diagnostics, Place};
use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;
use std::ops::RangeInclusive;
use std::path::Path;

/// Maximum distance of a vertex from its mesh's origin, metres: a tenth of a light year.
const FARTHEST_VERTEX_M: f32 = 1e15;
/// Maximum distance of anything from the world's origin, metres: room for sums and scales of such lengths.
const FARTHEST_M: f64 = 1e18;
/// Maximum power of lights in any of their units, beyond all measured lights.
const MOST_POWER: f64 = 1e20;

/// Refuses scenes that are too large, lights that are too bright, and impossible lenses.
pub(super) fn check(scene: &Scene, file: &Path) -> Result<(), Diagnostics> {
    let meshes = scene.meshes.iter().filter_map(|mesh| far_vertex(&mesh.name, &mesh.positions));
    let nodes = far_nodes(scene).into_iter();
    let lights = scene.lights.iter().filter_map(bright_light);
    let cameras = scene.cameras.iter().flat_map(impossible_lens);
    let errors = meshes.chain(nodes).chain(lights).chain(cameras);
    let errors: Vec<Diagnostic> = errors.map(|excess| excess.error(file)).collect();
    if errors.is_empty() { Ok(()) } else { Err(Diagnostics(errors)) }
}

struct Excess {
    path: String,
    found: String,
    expected: String,
    remedy: &'static str,
}

impl Excess {
    fn error(self, file: &Path) -> Diagnostic {
        let place = Place::Field { file: file.to_owned(), path: self.path };
        Diagnostic::error(place, self.found).expected(self.expected).remedy(self.remedy)
    }
}

fn far_vertex(mesh: &str, positions: &[Vec3]) -> Option<Excess> {
    let is_far = |position: &&Vec3| position.abs().max_element() > FARTHEST_VERTEX_M;
    let (index, position) = positions.iter().enumerate().find(|(_, position)| is_far(position))?;
    Some(Excess {
        path: format!("mesh `{mesh}`"),
        found: format!("vertex {index} is {:e} m away from the origin", position.abs().max_element()),
        expected: format!("coordinates of at most {FARTHEST_VERTEX_M:e} m"),
        remedy: "correct the vertex; one flipped bit of a file can send it there, so export again",
    })
}

/// Nodes that reach too far, with their meshes: the topmost of each branch of the hierarchy.
fn far_nodes(scene: &Scene) -> Vec<Excess> {
    let extent = |positions: &[Vec3]| {
        positions.iter().fold(0.0, |extent: f64, position| extent.max(position.as_dvec3().length()))
    };
    let extents: Vec<f64> = scene.meshes.iter().map(|mesh| extent(&mesh.positions)).collect();
    let mut extent_at = vec![0.0; scene.nodes.len()];
    for instance in &scene.instances {
        extent_at[instance.node] = extents[instance.mesh].max(extent_at[instance.node]);
    }
    let own: Vec<Reach> = scene.nodes.par_iter().map(|node| Reach::of(&node.motion)).collect();
    let mut reaches: Vec<Reach> = Vec::with_capacity(scene.nodes.len());
    let mut found = Vec::new();
    for ((node, own), extent) in scene.nodes.iter().zip(own).zip(extent_at) {
        let parent = node.parent.map_or(Reach { offset_m: 0.0, scale: 1.0 }, |parent| reaches[parent]);
        let reach = Reach {
            offset_m: parent.offset_m + parent.scale * own.offset_m,
            scale: parent.scale * own.scale,
        };
        let is_near = |reach: Reach, extent: f64| reach.offset_m + reach.scale * extent <= FARTHEST_M;
        if is_near(parent, 0.0) && !is_near(reach, extent) {
            found.push(Excess {
                path: format!("node `{}`", node.name),
                found: format!("it reaches {:e} m from the world's origin", reach.offset_m + reach.scale * extent),
                expected: format!("at most {FARTHEST_M:e} m, with the translations and scales of all its parents"),
                remedy: "correct its translation or scale; one flipped bit of a file can send it there, so export again",
            });
        }
        reaches.push(reach);
    }
    found
}

/// Bound on a node's distance at any time, for any rotation.
#[derive(Clone, Copy)]
struct Reach {
    offset_m: f64,
    scale: f64,
}

impl Reach {
    fn of(motion: &Motion) -> Self {
        let largest = |track: &Track<DVec3>, size: fn(DVec3) -> f64| {
            track.hull().into_iter().map(size).fold(0.0, f64::max)
        };
        match motion {
            Motion::Still(parent_from_node) => Self {
                offset_m: parent_from_node.translation.length(),
                scale: largest_stretch(parent_from_node.matrix3),
            },
            Motion::Keyed { translation, scale, .. } => Self {
                offset_m: largest(translation, DVec3::length),
                scale: largest(scale, |scale| scale.abs().max_element()),
            },
            Motion::Aimed { position, .. } => Self { offset_m: largest(position, DVec3::length), scale: 1.0 },
        }
    }
}

/// Bound on the factor by which a matrix stretches vectors, exact if its columns are orthogonal.
fn largest_stretch(matrix: DMat3) -> f64 {
    // The square of the stretch is an eigenvalue of the transpose times the matrix (Gershgorin's discs).
    let squared = matrix.transpose() * matrix;
    let rows = [squared.x_axis, squared.y_axis, squared.z_axis];
    rows.map(|row| row.abs().element_sum()).into_iter().fold(0.0, f64::max).sqrt()
}

fn bright_light(light: &Light) -> Option<Excess> {
    let powers = light.power.hull().into_iter().map(|power| power.abs().max_element());
    let most = powers.fold(0.0, f64::max);
    (most > MOST_POWER).then(|| Excess {
        path: format!("light `{}`", light.name),
        found: format!("it gives {most:e} W/m^2, W/sr or W"),
        expected: format!("at most {MOST_POWER:e}, colour and intensity multiplied"),
        remedy: "make the light dimmer",
    })
}

fn impossible_lens(camera: &Camera) -> Vec<Excess> {
    let mut found = Vec::new();
    let mut keep = |name: &str, track: &Track<f64>, limits: RangeInclusive<f64>, expected: String| {
        let outside = track.hull().into_iter().find(|value| !limits.contains(value));
        found.extend(outside.map(|value| Excess {
            path: format!("camera `{}`", camera.name),
            found: format!("its {name} is {value:e}"),
            expected,
            remedy: "correct the number, or take the property out",
        }));
    };
    if let Lens::Perspective { fov_y } = &camera.lens {
        let (low, high) = FIELDS_OF_VIEW_DEG.into_inner();
        let expected = format!("radians that are from {low} to {high} degrees");
        keep("vertical field of view", fov_y, low.to_radians()..=high.to_radians(), expected);
    }
    if let Some(aperture) = &camera.aperture {
        let expected = format!("at least {SMALLEST_F_STOP}");
        keep("f-stop", &aperture.f_stop, SMALLEST_F_STOP..=f64::MAX, expected);
        let expected = format!("at least {NEAREST_FOCUS_M} m");
        keep("focus distance", &aperture.focus_distance_m, NEAREST_FOCUS_M..=f64::MAX, expected);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::scene::{Aperture, Clip, LightKind, Mesh, Node};
    use glam::{DAffine3, DVec2};

    fn refusal(scene: &Scene) -> Option<String> {
        check(scene, Path::new("a.glb")).err().map(|errors| errors.to_string())
    }

    fn assert_refused(scene: &Scene, place_and_finding: &str) {
        let refused = refusal(scene).expect("too far");
        for part in [place_and_finding, "expected: ", "remedy: "] {
            assert!(refused.contains(part), "{refused}");
        }
    }

    fn scene_with(farthest: f32) -> Scene {
        let positions = vec![Vec3::ZERO, Vec3::new(0.0, -farthest, 0.0)];
        let mesh = Mesh { name: String::from("leaf"), positions, ..Mesh::default() };
        Scene { meshes: vec![mesh], ..Scene::default() }
    }

    fn node(name: &str, parent: Option<usize>, parent_from_node: DAffine3) -> Node {
        let motion = Motion::Still(parent_from_node);
        Node { name: String::from(name), parent, motion, visible: Track::from(true) }
    }

    #[test]
    fn only_meshes_that_reach_too_far_are_refused() {
        assert_eq!(refusal(&scene_with(1e15)), None);
        assert_refused(&scene_with(3e38), "a.glb: mesh `leaf`: error: vertex 1 is 3e38 m away");
    }

    #[test]
    fn scales_of_parents_count_and_children_are_not_told_again() {
        let translation = DAffine3::from_translation(DVec3::X);
        let scene = |scale: f64| Scene {
            nodes: vec![
                node("root", None, DAffine3::from_scale(DVec3::splat(scale))),
                node("child", Some(0), translation),
                node("grandchild", Some(1), translation),
            ],
            ..Scene::default()
        };
        assert_eq!(refusal(&scene(1e17)), None);
        assert_refused(&scene(1e19), "a.glb: node `child`: error: it reaches 1e19");
        assert!(!refusal(&scene(1e19)).expect("too far").contains("grandchild"));
    }

    #[test]
    fn rotations_do_not_add_up() {
        let turned = DAffine3::from_rotation_y(0.3) * DAffine3::from_rotation_x(1.0);
        let nodes = (0..500_usize).map(|index| node("turned", index.checked_sub(1), turned)).collect();
        assert_eq!(refusal(&Scene { nodes, ..Scene::default() }), None);
    }

    #[test]
    fn lights_and_lenses_have_limits() {
        let light = |power: f64| Light {
            name: String::from("sun"),
            node: 0,
            power: Track::from(Rgb::splat(power)),
            kind: LightKind::Sun,
        };
        let lit = |power: f64| Scene { lights: vec![light(power)], ..Scene::default() };
        assert_eq!(refusal(&lit(1e20)), None);
        assert_refused(&lit(1e30), "a.glb: light `sun`: error: it gives 1e30");
        let seen = |fov_deg: f64, f_stop: f64, focus_distance_m: f64| {
            let aperture = Aperture {
                f_stop: Track::from(f_stop),
                sensor_width_m: 0.036,
                focus_distance_m: Track::from(focus_distance_m),
                blades: 0,
            };
            let lens = Lens::Perspective { fov_y: Track::from(fov_deg.to_radians()) };
            let (name, clip) = (String::from("main"), Clip::NONE);
            let camera = Camera { name, node: 0, lens, shift: DVec2::ZERO, aperture: Some(aperture), clip };
            Scene { cameras: vec![camera], ..Scene::default() }
        };
        assert_eq!(refusal(&seen(40.0, 2.8, 3.0)), None);
        assert_refused(&seen(1e-5, 2.8, 3.0), "camera `main`: error: its vertical field of view is");
        assert_refused(&seen(40.0, 1e-30, 3.0), "camera `main`: error: its f-stop is 1e-30");
        assert_refused(&seen(40.0, 2.8, 1e-9), "camera `main`: error: its focus distance is 1e-9");
    }
}
