//! Nodes, cameras and lights, checked. Invariant: every node has at most one parent and none is
//! its own ancestor.

use super::json::{self, Document};
use super::report::Report;
use super::{Camera, GltfScene, Lens, Light, LightKind, Node, Transform, named};
use crate::diagnostic::Loss;
use glam::{DAffine3, DMat4, DQuat, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// How far from 1 the length of a rotation may be; Blender's are good to 1e-7.
const UNIT_TOLERANCE: f64 = 1e-2;

/// Exporters round angles, radians, to single precision: half of 180 degrees comes out a little above pi/2.
const ROUNDING: f64 = 1e-6;

/// All nodes.
pub(super) fn nodes(document: &Document, report: &mut Report) -> Vec<Node> {
    check_hierarchy(document, report);
    document.nodes.iter().enumerate().map(|(index, node)| convert(document, index, node, report)).collect()
}

fn convert(document: &Document, index: usize, node: &json::Node, report: &mut Report) -> Node {
    let path = format!("nodes[{index}]");
    let name = named(&node.name, "node", index);
    let mut existing = |at: &str, index: Option<usize>, count: usize, what: &str| {
        index.filter(|&index| report.index_exists(format!("{path}.{at}"), index, count, what))
    };
    let mesh = existing("mesh", node.mesh, document.meshes.len(), "mesh");
    let skin = existing("skin", node.skin, document.skins.len(), "skin");
    let camera = existing("camera", node.camera, document.cameras.len(), "camera");
    let lights = &document.extensions.lights_punctual.lights;
    let light = node.extensions.light.as_ref().map(|reference| reference.light);
    let light = existing("extensions.KHR_lights_punctual.light", light, lights.len(), "light");
    Node {
        transform: transform(node, &path, report),
        children: node.children.clone(),
        mesh,
        skin,
        weights: None,
        instances: None,
        visible: node.extensions.visibility.as_ref().is_none_or(|visibility| visibility.visible),
        camera,
        light,
        extras: node.extras.clone(),
        name,
    }
}

fn transform(node: &json::Node, path: &str, report: &mut Report) -> Transform {
    if let Some(matrix) = node.matrix {
        if node.translation.is_some() || node.rotation.is_some() || node.scale.is_some() {
            let found = "the node has a matrix and its parts as well";
            report.error(path, found, "a matrix, or translation, rotation and scale");
        }
        let matrix = DMat4::from_cols_array(&matrix);
        if matrix.row(3).abs_diff_eq(glam::DVec4::W, 1e-6) {
            return Transform::Matrix(DAffine3::from_mat4(matrix));
        }
        report.error(format!("{path}.matrix"), "the matrix is not affine", "a last row of 0, 0, 0, 1");
    }
    let rotation = DQuat::from_array(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
    if (rotation.length() - 1.0).abs() > UNIT_TOLERANCE {
        let found = format!("the rotation has length {}", rotation.length());
        report.error(format!("{path}.rotation"), found, "a unit quaternion");
    }
    Transform::Parts {
        translation: DVec3::from(node.translation.unwrap_or_default()),
        rotation: rotation.normalize(),
        scale: DVec3::from(node.scale.unwrap_or([1.0; 3])),
    }
}

fn check_hierarchy(document: &Document, report: &mut Report) {
    let count = document.nodes.len();
    let mut parents: Vec<Option<usize>> = vec![None; count];
    for (index, node) in document.nodes.iter().enumerate() {
        for (position, &child) in node.children.iter().enumerate() {
            let path = format!("nodes[{index}].children[{position}]");
            if !report.index_exists(path.clone(), child, count, "node") {
                continue;
            }
            match parents[child] {
                None => parents[child] = Some(index),
                Some(other) => report.error(
                    path,
                    format!("node {child} is a child of node {other} already"),
                    "every node below one parent only",
                ),
            }
        }
    }
    // Every node has one parent at most: following parents either ends or comes round.
    let mut ends = vec![false; count];
    for start in 0..count {
        let mut path = Vec::new();
        let mut at = Some(start);
        while let Some(node) = at.filter(|&node| !ends[node]) {
            if path.len() == count {
                report.error(
                    format!("nodes[{start}]"),
                    "the node is its own ancestor: the hierarchy runs in a circle",
                    "nodes that form trees",
                );
                return;
            }
            path.push(node);
            at = parents[node];
        }
        path.into_iter().for_each(|node| ends[node] = true);
    }
}

/// Which scene is shown, and its roots.
pub(super) fn choose_scene(document: &Document, scene: &mut GltfScene, report: &mut Report) {
    scene.scene = document.scene.unwrap_or(0);
    let Some(shown) = document.scenes.get(scene.scene) else {
        if document.scene.is_some() {
            report.index_exists(String::from("scene"), scene.scene, document.scenes.len(), "scene");
        }
        let mut is_child = vec![false; scene.nodes.len()];
        for &child in scene.nodes.iter().flat_map(|node| &node.children) {
            if let Some(is_child) = is_child.get_mut(child) {
                *is_child = true;
            }
        }
        scene.roots = (0..scene.nodes.len()).filter(|&node| !is_child[node]).collect();
        return;
    };
    for (index, other) in document.scenes.iter().enumerate().filter(|(index, _)| *index != scene.scene) {
        report.not_honoured(Loss::OtherScenes, &named(&other.name, "scene", index));
    }
    scene.extras = shown.extras.clone();
    let mut listed = vec![false; scene.nodes.len()];
    for (position, &root) in shown.nodes.iter().enumerate() {
        let path = format!("scenes[{}].nodes[{position}]", scene.scene);
        if !report.index_exists(path.clone(), root, scene.nodes.len(), "node") {
            continue;
        }
        if std::mem::replace(&mut listed[root], true) {
            report.error(path, format!("node {root} is listed twice"), "every node once");
            continue;
        }
        scene.roots.push(root);
    }
    for (index, node) in scene.nodes.iter().enumerate() {
        for (position, &child) in node.children.iter().enumerate() {
            if listed.get(child) == Some(&true) {
                report.error(
                    format!("nodes[{index}].children[{position}]"),
                    format!("node {child} is a root of the scene and a child too"),
                    "every node in one place of the hierarchy",
                );
            }
        }
    }
}

/// All cameras.
pub(super) fn cameras(document: &Document, report: &mut Report) -> Vec<Camera> {
    let convert = |(index, camera): (usize, &json::Camera)| {
        let name = named(&camera.name, "camera", index);
        let lens = lens(camera, &format!("cameras[{index}]"), report);
        let clip_m = clip_m(camera, &name, report);
        Camera { name, lens, clip_m, extras: camera.extras.clone() }
    };
    document.cameras.iter().enumerate().map(convert).collect()
}

fn lens(camera: &json::Camera, path: &str, report: &mut Report) -> Lens {
    match (&camera.perspective, &camera.orthographic) {
        (Some(json::Perspective { yfov, aspect_ratio, .. }), None) => {
            let path = format!("{path}.perspective");
            if !(*yfov > 0.0 && *yfov < PI) {
                let found = format!("the vertical field of view is {yfov}");
                report.error(format!("{path}.yfov"), found, "radians between 0 and pi");
            }
            if aspect_ratio.is_some_and(|aspect| aspect <= 0.0) {
                let found = "the aspect ratio is not positive";
                report.error(format!("{path}.aspectRatio"), found, "a number above 0");
            }
            Lens::Perspective { fov_y: *yfov, aspect: *aspect_ratio }
        }
        (None, Some(json::Orthographic { xmag, ymag, .. })) => {
            // Smaller or larger ones would not survive single precision.
            for (name, size) in [("xmag", *xmag), ("ymag", *ymag)] {
                if !(1e-15..1e15).contains(&size) {
                    let found = format!("half the picture's extent is {size}");
                    report.error(format!("{path}.orthographic.{name}"), found, "metres, more than 0");
                }
            }
            Lens::Orthographic { half_width: *xmag, half_height: *ymag }
        }
        _ => {
            let expected = "either `perspective` or `orthographic`";
            report.error(path, "the camera is not of one kind", expected);
            Lens::Perspective { fov_y: 1.0, aspect: None }
        }
    }
}

/// The clipping planes of a camera: all that lies before it shows where they are missing or out of order.
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

/// All lights.
pub(super) fn lights(document: &Document, report: &mut Report) -> Vec<Light> {
    let lights = &document.extensions.lights_punctual.lights;
    lights.iter().enumerate().map(|(index, light)| convert_light(index, light, report)).collect()
}

/// Inner and outer angle of a spot's cone. Both may be the same, which Blender's hard edges are, though glTF wants the
/// inner one to be less.
fn cone(spot: &json::Spot, path: &str, name: &str, report: &mut Report) -> [f64; 2] {
    let (inner, outer) = (spot.inner_cone_angle, spot.outer_cone_angle);
    if outer <= 0.0 {
        let found = format!("the cone's outer angle is {outer}");
        report.error(format!("{path}.spot.outerConeAngle"), found, "more than 0 and at most pi/2");
        return [0.0, FRAC_PI_2];
    }
    if inner < 0.0 || inner > outer + ROUNDING || outer > FRAC_PI_2 + ROUNDING {
        report.not_honoured(Loss::SpotAngles, name);
    }
    let outer = outer.min(FRAC_PI_2);
    [inner.clamp(0.0, outer), outer]
}

fn convert_light(index: usize, light: &json::Light, report: &mut Report) -> Light {
    let path = format!("extensions.KHR_lights_punctual.lights[{index}]");
    let color = DVec3::from(light.color);
    if color.min_element() < 0.0 {
        report.error(
            format!("{path}.color"),
            format!("the colour is {:?}", light.color),
            "numbers of at least 0",
        );
    }
    if light.intensity < 0.0 {
        report.error(
            format!("{path}.intensity"),
            format!("the intensity is {}", light.intensity),
            "at least 0",
        );
    }
    let kind = match (light.kind.as_str(), &light.spot) {
        ("directional", _) => LightKind::Directional,
        ("point", _) => LightKind::Point,
        ("spot", Some(spot)) => {
            let [inner_angle, outer_angle] = cone(spot, &path, &named(&light.name, "light", index), report);
            LightKind::Spot { inner_angle, outer_angle }
        }
        ("spot", None) => LightKind::Spot { inner_angle: 0.0, outer_angle: PI / 4.0 },
        (other, _) => {
            let found = format!("`{other}` is no kind of light");
            report.error(format!("{path}.type"), found, "directional, point or spot");
            LightKind::Point
        }
    };
    Light {
        name: named(&light.name, "light", index),
        color,
        intensity: light.intensity,
        range_m: light.range,
        kind,
    }
}
