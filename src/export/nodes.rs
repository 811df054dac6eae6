//! Nodes and what they carry. In goes the hierarchy, out come glTF's nodes. Invariant: every node has the
//! scene's placement in the world. A shear needs two nodes, as glTF's and Blender's nodes cannot shear.

use super::Writer;
use super::meshes::Placed;
use crate::scene::{Clip, Lens, Motion, RayVisibility, RenderSettings, Rotation};
use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};
use serde_json::{Map, Value, json};

/// Maximum deviation of a matrix from its decomposition, relative to its largest element.
const PARTS_TOLERANCE: f64 = 1e-9;

/// Clipping distances for cameras without clipping, metres. glTF's perspective cameras need a near plane, its
/// orthographic ones a far plane.
const NEAREST_M: f64 = 1e-4;
const FARTHEST_M: f64 = 1e6;

impl Writer<'_> {
    pub(super) fn add_nodes(&mut self) {
        for node in &self.scene.nodes {
            let parent = node.parent.map(|parent| self.node_numbers[parent]);
            let number = match &node.motion {
                Motion::Still(affine) => self.add_still(&node.name, parent, *affine),
                motion => self.add_moving(&node.name, parent, motion),
            };
            self.node_numbers.push(number);
            if !node.visible.is_constant() {
                self.carry_switch(format!("{}.sunfleck_node.visible", node.name), &node.visible);
            } else if !node.visible.at(self.moments.start_s) {
                self.extensions.insert("KHR_node_visibility");
                self.extend_node(number, "KHR_node_visibility", json!({ "visible": false }));
            }
        }
    }

    /// Adds a node; all its children are added later.
    pub(super) fn add_node(&mut self, name: &str, parent: Option<usize>) -> usize {
        let number = self.nodes.len();
        let mut node = Map::new();
        node.insert(String::from("name"), json!(name));
        self.nodes.push(node);
        self.children.push(Vec::new());
        if let Some(parent) = parent {
            self.children[parent].push(number);
        }
        number
    }

    fn add_still(&mut self, name: &str, parent: Option<usize>, affine: DAffine3) -> usize {
        let (scale, rotation, translation) = affine.to_scale_rotation_translation();
        let again = DAffine3::from_scale_rotation_translation(scale, rotation, translation);
        let largest = affine.matrix3.to_cols_array().into_iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        if again.matrix3.abs_diff_eq(affine.matrix3, PARTS_TOLERANCE * largest) {
            let node = self.add_node(name, parent);
            self.set_parts(node, translation, rotation, scale);
            return node;
        }
        let (first, scale, last) = turn_scale_turn(affine.matrix3);
        let outer = self.add_node(&format!("{name} (shear)"), parent);
        self.set_parts(outer, translation, first, scale);
        let inner = self.add_node(name, Some(outer));
        self.set_parts(inner, DVec3::ZERO, last, DVec3::ONE);
        inner
    }

    fn add_moving(&mut self, name: &str, parent: Option<usize>, motion: &Motion) -> usize {
        let node = self.add_node(name, parent);
        let start_s = self.moments.start_s;
        match motion {
            Motion::Keyed { translation, rotation, scale } => {
                self.set_parts(node, translation.at(start_s), rotation.at(start_s), scale.at(start_s));
                let turn = match rotation {
                    Rotation::Quaternion(track) => self.moments.of_track(track),
                    Rotation::EulerXyz(_) => self.moments.sampled(|time_s| rotation.at(time_s)),
                };
                let (translation, scale) = (self.moments.of_track(translation), self.moments.of_track(scale));
                self.add_channel(node, "translation", translation);
                self.add_channel(node, "rotation", turn);
                self.add_channel(node, "scale", scale);
            }
            Motion::Aimed { .. } | Motion::Still(_) => {
                let parts = |time_s: f64| motion.parent_from_node(time_s).to_scale_rotation_translation();
                let (scale, rotation, translation) = parts(start_s);
                self.set_parts(node, translation, rotation, scale);
                let place = match motion {
                    Motion::Aimed { position, .. } => self.moments.of_track(position),
                    _ => self.moments.sampled(|time_s| parts(time_s).2),
                };
                let turn = self.moments.sampled(|time_s| parts(time_s).1);
                self.add_channel(node, "translation", place);
                self.add_channel(node, "rotation", turn);
            }
        }
        node
    }

    /// Sets a node's transform; identity parts are left out.
    fn set_parts(&mut self, node: usize, translation: DVec3, rotation: DQuat, scale: DVec3) {
        let mut set = |name: &str, value: Value| self.nodes[node].insert(name.to_owned(), value);
        if translation != DVec3::ZERO {
            set("translation", json!(translation.to_array()));
        }
        if rotation != DQuat::IDENTITY {
            set("rotation", json!(rotation.to_array()));
        }
        if scale != DVec3::ONE {
            set("scale", json!(scale.to_array()));
        }
    }

    /// Sets a value under `key` of a node's object `group`.
    fn extend(&mut self, node: usize, group: &str, key: &str, value: Value) {
        let group = self.nodes[node].entry(group).or_insert_with(|| json!({}));
        group[key] = value;
    }

    pub(super) fn extend_node(&mut self, node: usize, extension: &str, value: Value) {
        self.extend(node, "extensions", extension, value);
    }

    pub(super) fn set_extra(&mut self, node: usize, name: &str, value: Value) {
        self.extend(node, "extras", name, value);
    }

    /// The node itself, or a new child if it already carries something of this kind.
    pub(super) fn free_node(&mut self, node: usize, is_taken: impl Fn(&Map<String, Value>) -> bool) -> usize {
        if !is_taken(&self.nodes[node]) {
            return node;
        }
        let name = self.nodes[node].get("name").and_then(Value::as_str).unwrap_or_default().to_owned();
        self.add_node(&name, Some(node))
    }

    /// Puts meshes and their leaf ids at their nodes.
    pub(super) fn place_meshes(&mut self, placed: &Placed) {
        let scene = self.scene;
        for (&(node, leaf_id, bent), &mesh) in placed {
            let number = self.free_node(self.node_numbers[node], |node| node.contains_key("mesh"));
            self.nodes[number].insert(String::from("mesh"), json!(mesh));
            self.set_extra(number, "leaf_id", json!(leaf_id));
            if let Some(rays) = scene.ray_visibility.get(&node) {
                self.set_extra(number, "sunfleck_object", said(*rays));
            }
            if let Some(deformation) =
                bent.and_then(|instance| scene.instances[instance].deformation.as_ref())
            {
                self.bend(number, deformation);
            }
        }
    }

    pub(super) fn add_cameras(&mut self, settings: &RenderSettings) {
        let aspect = settings.size.width as f64 / settings.size.height as f64;
        let start_s = self.moments.start_s;
        for camera in &self.scene.cameras {
            let owner = format!("{}.sunfleck_camera", self.scene.nodes[camera.node].name);
            let seen = if matches!(camera.lens, Lens::Perspective { .. }) { "yfov" } else { "height" };
            self.carry_number(format!("{owner}.{seen}"), camera.lens.number());
            let Clip { start_m, end_m } = camera.clip;
            let near = if start_m > 0.0 { start_m } else { NEAREST_M };
            let far = if end_m.is_finite() { end_m } else { FARTHEST_M };
            let mut written = match &camera.lens {
                Lens::Perspective { fov_y } => json!({
                    "type": "perspective",
                    "perspective": { "yfov": fov_y.at(start_s), "aspectRatio": aspect, "znear": near },
                }),
                Lens::Orthographic { height_m } => {
                    let half = 0.5 * height_m.at(start_s);
                    let size = json!({ "xmag": half * aspect, "ymag": half, "znear": start_m, "zfar": far });
                    json!({ "type": "orthographic", "orthographic": size })
                }
            };
            if let Some(perspective) = written.get_mut("perspective").filter(|_| end_m.is_finite()) {
                perspective["zfar"] = json!(end_m);
            }
            written["name"] = json!(camera.name);
            let mut ours = json!({});
            if camera.shift != DVec2::ZERO {
                ours["shift"] = json!(camera.shift.to_array());
            }
            if let Some(aperture) = &camera.aperture {
                ours["fstop"] = json!(aperture.f_stop.at(start_s));
                ours["focus_distance"] = json!(aperture.focus_distance_m.at(start_s));
                ours["sensor_width_mm"] = json!(1e3 * aperture.sensor_width_m);
                if aperture.blades > 0 {
                    ours["blades"] = json!(aperture.blades);
                }
                self.carry_number(format!("{owner}.fstop"), &aperture.f_stop);
                self.carry_number(format!("{owner}.focus_distance"), &aperture.focus_distance_m);
            }
            if ours != json!({}) {
                written["extras"] = json!({ "sunfleck_camera": ours });
            }
            self.cameras.push(written);
            let number = self.cameras.len() - 1;
            let node = self.free_node(self.node_numbers[camera.node], |node| node.contains_key("camera"));
            self.nodes[node].insert(String::from("camera"), json!(number));
        }
    }
}

/// Fields of a ray visibility that differ from the default.
fn said(rays: RayVisibility) -> Value {
    let RayVisibility { visible_to_camera, casts_shadow, holdout } = rays;
    let fields = [
        ("visible_to_camera", visible_to_camera, true),
        ("casts_shadow", casts_shadow, true),
        ("holdout", holdout, false),
    ];
    let unusual = fields.into_iter().filter(|(_, value, usual)| value != usual);
    unusual.map(|(name, value, _)| (name.to_owned(), json!(value))).collect::<Map<_, _>>().into()
}

/// Singular value decomposition: rotation, scale along the axes, rotation, `matrix = first * scale * last`.
/// Pairs of columns are rotated until all are orthogonal (Hestenes 1958; Golub and Van Loan, Matrix
/// Computations, 8.6.3).
fn turn_scale_turn(matrix: DMat3) -> (DQuat, DVec3, DQuat) {
    let (mut columns, mut turned) = (matrix, DMat3::IDENTITY);
    // Each pass squares the remaining error of the angles.
    for _ in 0..16 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let (a, b) = (columns.col(p), columns.col(q));
            if a.dot(b) == 0.0 {
                continue;
            }
            let zeta = (b.length_squared() - a.length_squared()) / (2.0 * a.dot(b));
            let tangent = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
            let cosine = tangent.hypot(1.0).recip();
            for matrix in [&mut columns, &mut turned] {
                let (a, b) = (matrix.col(p), matrix.col(q));
                *matrix.col_mut(p) = cosine * (a - tangent * b);
                *matrix.col_mut(q) = cosine * (b + tangent * a);
            }
        }
    }
    let mut scale = DVec3::new(columns.x_axis.length(), columns.y_axis.length(), columns.z_axis.length());
    // A column of length 0 may have any direction; with two of them nothing is visible.
    let x = columns.x_axis.try_normalize();
    let y = columns.y_axis.try_normalize();
    let z = columns.z_axis.try_normalize();
    let (x, y) = match (x, y, z) {
        (Some(x), Some(y), _) => (x, y),
        (Some(x), None, Some(z)) => (x, z.cross(x)),
        (None, Some(y), Some(z)) => (y.cross(z), y),
        (x, y, z) => {
            let x = x.unwrap_or_else(|| y.or(z).unwrap_or(DVec3::X).any_orthonormal_vector());
            (x, y.unwrap_or_else(|| x.any_orthonormal_vector()))
        }
    };
    let first = DMat3::from_cols(x, y, x.cross(y));
    if columns.z_axis.dot(first.z_axis) < 0.0 {
        scale.z = -scale.z;
    }
    (DQuat::from_mat3(&first), scale, DQuat::from_mat3(&turned.transpose()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Sampler;

    #[test]
    fn every_matrix_is_a_turn_a_scale_and_a_turn() {
        let numbers = |index: u32| {
            let mut sampler = Sampler::new(3, 0, 0, index);
            std::array::from_fn::<f64, 9, _>(|_| 4.0 * sampler.next_1d() - 2.0)
        };
        let flat = DMat3::from_cols(DVec3::X, DVec3::new(0.5, 1.0, 0.0), DVec3::ZERO);
        let random = (0..200).map(|index| DMat3::from_cols_array(&numbers(index)));
        for matrix in random.chain([flat, DMat3::IDENTITY, -DMat3::IDENTITY]) {
            let (first, scale, last) = turn_scale_turn(matrix);
            let again = DMat3::from_quat(first) * DMat3::from_diagonal(scale) * DMat3::from_quat(last);
            assert!(again.abs_diff_eq(matrix, 1e-13), "{matrix} {again}");
        }
    }
}
