//! Nodes, cameras and lights. In goes JSON, out come validated ones. Invariant: every node has at most one
//! parent and none is its own ancestor.

use super::json::{self, Document};
use super::report::Report;
use super::{Camera, GltfScene, Lens, Light, LightKind, Node, Transform, named};
use crate::description::ron::FIELDS_OF_VIEW_DEG;
use crate::diagnostic::Loss;
use glam::{DAffine3, DMat4, DQuat, DVec3};
use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use std::ops::RangeInclusive;

/// Tolerance of a quaternion's length; Blender's are accurate to 1e-7.
const UNIT_TOLERANCE: f64 = 1e-2;
/// Shorter quaternions have no direction.
const LEAST_LENGTH: f64 = 1e-6;

/// Tolerance of angles, radians: exporters round to single precision, and half of 180 degrees is a little
/// above pi/2.
const ROUNDING: f64 = 1e-6;

/// Allowed fields of view in radians: 0.0001 to 179.9 degrees.
const FIELDS_OF_VIEW: RangeInclusive<f64> =
    FIELDS_OF_VIEW_DEG.start().to_radians()..=FIELDS_OF_VIEW_DEG.end().to_radians();

/// Reads all nodes; the first node that lists a child is its parent.
pub(super) fn nodes(document: &Document, report: &mut Report) -> Vec<Node> {
    let convert = |(index, node): (usize, &json::Node)| convert(document, index, node, report);
    let mut nodes: Vec<Node> = document.nodes.iter().enumerate().map(convert).collect();
    for (node, children) in nodes.iter_mut().zip(children(document, report)) {
        node.children = children;
    }
    nodes
}

fn convert(document: &Document, index: usize, node: &json::Node, report: &mut Report) -> Node {
    let path = format!("nodes[{index}]");
    let name = named(&node.name, "node", index);
    let mut existing = |at: &str, index: Option<usize>, count: usize, what: &str| {
        index.filter(|&index| report.index_exists(&format!("{path}.{at}"), index, count, what))
    };
    let mesh = existing("mesh", node.mesh, document.meshes.len(), "mesh");
    let skin = existing("skin", node.skin, document.skins.len(), "skin");
    let camera = existing("camera", node.camera, document.cameras.len(), "camera");
    let lights = &document.extensions.lights_punctual.lights;
    let light = node.extensions.light.as_ref().map(|reference| reference.light);
    let light = existing("extensions.KHR_lights_punctual.light", light, lights.len(), "light");
    Node {
        transform: transform(node, &path, report),
        children: Vec::new(),
        mesh,
        skin,
        weights: None,
        instances: None,
        instance_colors: Vec::new(),
        visible: node.extensions.visibility.visible.unwrap_or(true),
        camera,
        light,
        extras: node.extras.clone(),
        name,
    }
}

/// Transform of a node to its parent's space.
fn transform(node: &json::Node, path: &str, report: &mut Report) -> Transform {
    if let Some(matrix) = node.matrix {
        if node.translation.is_some() || node.rotation.is_some() || node.scale.is_some() {
            let found = "the node has a matrix and its parts as well, the matrix counts";
            report.put_right(Loss::TransformRepaired, path, found);
        }
        let matrix = DMat4::from_cols_array(&matrix);
        if !matrix.row(3).abs_diff_eq(glam::DVec4::W, 1e-6) {
            report.put_right(Loss::TransformRepaired, &format!("{path}.matrix"), "the matrix is not affine");
        }
        return Transform::Matrix(DAffine3::from_mat4(matrix));
    }
    let rotation = DQuat::from_array(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
    if (rotation.length() - 1.0).abs() > UNIT_TOLERANCE {
        let found = format!("the rotation has length {}", rotation.length());
        report.put_right(Loss::TransformRepaired, &format!("{path}.rotation"), found);
    }
    Transform::Parts {
        translation: DVec3::from(node.translation.unwrap_or_default()),
        rotation: if rotation.length() > LEAST_LENGTH { rotation.normalize() } else { DQuat::IDENTITY },
        scale: DVec3::from(node.scale.unwrap_or([1.0; 3])),
    }
}

/// Children of each node: those that it lists, unless they have a parent already or are its ancestors.
fn children(document: &Document, report: &mut Report) -> Vec<Vec<usize>> {
    let count = document.nodes.len();
    let roots = roots(document);
    let mut has_parent = vec![false; count];
    let mut above: Vec<usize> = (0..count).collect();
    let mut children = vec![Vec::new(); count];
    for (index, node) in document.nodes.iter().enumerate() {
        for (position, &child) in node.children.iter().enumerate() {
            let path = format!("nodes[{index}].children[{position}]");
            if !report.index_exists(&path, child, count, "node") {
                continue;
            }
            let found = if has_parent[child] {
                "is a child of a node before it"
            } else if roots.contains(&child) {
                "is a root of the scene that is shown"
            } else if top(&mut above, index) == child {
                "would be its own ancestor"
            } else {
                (has_parent[child], above[child]) = (true, index);
                children[index].push(child);
                continue;
            };
            report.put_right(Loss::HierarchyRepaired, &path, format!("node {child} {found}"));
        }
    }
    children
}

/// Root of a node, with path halving (Tarjan and van Leeuwen 1984).
fn top(above: &mut [usize], mut node: usize) -> usize {
    while above[node] != node {
        above[node] = above[above[node]];
        node = above[node];
    }
    node
}

/// Roots of the shown scene, if there is one.
fn roots(document: &Document) -> BTreeSet<usize> {
    let shown = document.scenes.get(shown_scene(document));
    shown.map(|scene| scene.nodes.iter().copied().collect()).unwrap_or_default()
}

/// Default scene of the file, else the first.
fn shown_scene(document: &Document) -> usize {
    document.scene.filter(|&scene| scene < document.scenes.len()).unwrap_or(0)
}

pub(super) fn choose_scene(document: &Document, scene: &mut GltfScene, report: &mut Report) {
    if let Some(named) = document.scene {
        report.index_exists("scene", named, document.scenes.len(), "scene");
    }
    scene.scene = shown_scene(document);
    let Some(shown) = document.scenes.get(scene.scene) else {
        // A file without scenes shows all its nodes.
        let children: BTreeSet<usize> =
            scene.nodes.iter().flat_map(|node| node.children.iter().copied()).collect();
        scene.roots = (0..scene.nodes.len()).filter(|node| !children.contains(node)).collect();
        return;
    };
    for (index, other) in document.scenes.iter().enumerate().filter(|(index, _)| *index != scene.scene) {
        report.not_honoured(Loss::OtherScenes, &named(&other.name, "scene", index));
    }
    scene.extras = shown.extras.clone();
    let mut listed = BTreeSet::new();
    for (position, &root) in shown.nodes.iter().enumerate() {
        let path = format!("scenes[{}].nodes[{position}]", scene.scene);
        if !report.index_exists(&path, root, scene.nodes.len(), "node") {
            continue;
        }
        if listed.insert(root) {
            scene.roots.push(root);
        } else {
            report.put_right(Loss::HierarchyRepaired, &path, format!("node {root} is listed twice"));
        }
    }
}

/// Reads all cameras; nodes lose those without a usable lens.
pub(super) fn cameras(document: &Document, nodes: &mut [Node], report: &mut Report) -> Vec<Camera> {
    let mut convert = |(index, camera): (usize, &json::Camera)| {
        let name = named(&camera.name, "camera", index);
        let lens = lens(camera, &format!("cameras[{index}]"), report).unwrap_or_else(|| {
            nodes.iter_mut().for_each(|node| node.camera = node.camera.filter(|&camera| camera != index));
            Lens::Perspective { fov_y: 1.0, aspect: None }
        });
        let clip_m = clip_m(camera, &name, report);
        Camera { name, lens, clip_m, extras: camera.extras.clone() }
    };
    document.cameras.iter().enumerate().map(&mut convert).collect()
}

/// Lens of a camera; `None` if it is not usable.
fn lens(camera: &json::Camera, path: &str, report: &mut Report) -> Option<Lens> {
    let mut unusable = |path: &str, found: String| report.put_right(Loss::CameraUnusable, path, found);
    match (&camera.perspective, &camera.orthographic) {
        (Some(json::Perspective { yfov, aspect_ratio, .. }), None) => {
            let path = format!("{path}.perspective");
            if !FIELDS_OF_VIEW.contains(yfov) {
                let found =
                    format!("the vertical field of view is {yfov} radians, not from 0.0001 to 179.9 degrees");
                unusable(&format!("{path}.yfov"), found);
                return None;
            }
            let aspect = aspect_ratio.filter(|aspect| *aspect > 0.0);
            if aspect != *aspect_ratio {
                let found = "the aspect ratio is not positive, the picture's counts";
                report.put_right(Loss::ValueOutOfRange, &format!("{path}.aspectRatio"), found);
            }
            Some(Lens::Perspective { fov_y: *yfov, aspect })
        }
        (None, Some(json::Orthographic { xmag, ymag, .. })) => {
            // Sizes outside this range do not survive single precision.
            for (name, size) in [("xmag", *xmag), ("ymag", *ymag)] {
                if !(1e-15..1e15).contains(&size) {
                    let found = format!("half the picture's extent is {size}, not above 0");
                    unusable(&format!("{path}.orthographic.{name}"), found);
                    return None;
                }
            }
            Some(Lens::Orthographic { half_width: *xmag, half_height: *ymag })
        }
        _ => {
            unusable(path, String::from("the camera is not of one kind"));
            None
        }
    }
}

/// Clipping distances of a camera; unlimited where they are missing or out of order.
fn clip_m(camera: &json::Camera, name: &str, report: &mut Report) -> (f64, f64) {
    let (znear, zfar) = match (&camera.perspective, &camera.orthographic) {
        (Some(lens), _) => (lens.znear, lens.zfar),
        (None, Some(lens)) => (lens.znear, lens.zfar),
        (None, None) => (None, None),
    };
    let (start, end) = (znear.unwrap_or(0.0), zfar.unwrap_or(f64::INFINITY));
    if start >= 0.0 && start < end {
        return (start, end);
    }
    report.not_honoured(Loss::ClippingPlanes, name);
    (0.0, f64::INFINITY)
}

/// Reads all lights; nodes lose those that cannot shine.
pub(super) fn lights(document: &Document, nodes: &mut [Node], report: &mut Report) -> Vec<Light> {
    let mut convert = |(index, light): (usize, &json::Light)| {
        let path = format!("extensions.KHR_lights_punctual.lights[{index}]");
        let name = named(&light.name, "light", index);
        let (color, intensity) = (light.color.unwrap_or([1.0; 3]), light.intensity.unwrap_or(1.0));
        if DVec3::from(color).min_element() < 0.0 {
            let found = format!("the colour is {color:?}");
            report.put_right(Loss::ValueOutOfRange, &format!("{path}.color"), found);
        }
        if intensity < 0.0 {
            let found = format!("the intensity is {intensity}");
            report.put_right(Loss::ValueOutOfRange, &format!("{path}.intensity"), found);
        }
        let kind = light_kind(light, &name, report).unwrap_or_else(|(field, found)| {
            report.put_right(Loss::LightUnusable, &format!("{path}.{field}"), found);
            nodes.iter_mut().for_each(|node| node.light = node.light.filter(|&light| light != index));
            LightKind::Point
        });
        let color = DVec3::from(color).max(DVec3::ZERO);
        let extras = light.extras.clone();
        Light { name, color, intensity: intensity.max(0.0), range_m: light.range, kind, extras }
    };
    document.extensions.lights_punctual.lights.iter().enumerate().map(&mut convert).collect()
}

/// Kind of a light, or the invalid field and its finding. A spot's angles may be equal, as for Blender's hard
/// edges, although glTF wants the inner one to be less.
fn light_kind(
    light: &json::Light,
    name: &str,
    report: &mut Report,
) -> Result<LightKind, (&'static str, String)> {
    match light.kind.as_str() {
        "directional" => return Ok(LightKind::Directional),
        "point" => return Ok(LightKind::Point),
        "spot" => {}
        other => return Err(("type", format!("`{other}` is no kind of light"))),
    }
    let (inner, outer) = (light.spot.inner_cone_angle, light.spot.outer_cone_angle.unwrap_or(FRAC_PI_4));
    if outer <= 0.0 {
        return Err(("spot.outerConeAngle", format!("the cone's outer angle is {outer}")));
    }
    if inner < 0.0 || inner > outer + ROUNDING || outer > FRAC_PI_2 + ROUNDING {
        report.not_honoured(Loss::SpotAngles, name);
    }
    let outer_angle = outer.min(FRAC_PI_2);
    Ok(LightKind::Spot { inner_angle: inner.clamp(0.0, outer_angle), outer_angle })
}
