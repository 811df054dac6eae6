//! Meshes, a primitive a material. Invariant: the triangles of a mesh are stored once, in however
//! many materials and places it is shown.

use super::Writer;
use super::binary::Target;
use crate::scene::{MaterialIndex, Mesh, MeshIndex, NodeIndex};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// A glTF mesh: meshes of ours, each perhaps in a material that replaces its own.
type Shown = Vec<(MeshIndex, Option<MaterialIndex>)>;

/// Triangles of a mesh as they are stored, and the material that they are in by themselves.
type Primitives = Vec<(Map<String, Value>, MaterialIndex)>;

/// Which glTF mesh stands at a node, and its leaf id.
pub(super) type Placed = BTreeMap<(NodeIndex, u32), usize>;

impl Writer<'_> {
    /// Every mesh that is shown, and where.
    pub(super) fn meshes(&mut self) -> (Vec<Value>, Placed) {
        // What stands at one node under one leaf id is one mesh to glTF.
        let mut shown: BTreeMap<(NodeIndex, u32), Shown> = BTreeMap::new();
        let bent = self.scene.instances.iter().filter(|instance| instance.deformation.is_some()).count();
        if bent > 0 {
            self.lost(format!(
                "skins and morph targets are not carried: {bent} meshes keep their shape at rest"
            ));
        }
        for instance in &self.scene.instances {
            let at = shown.entry((instance.node, instance.leaf_id)).or_default();
            at.push((instance.mesh, instance.material));
        }
        let mut numbers: BTreeMap<Shown, usize> = BTreeMap::new();
        let mut stored: BTreeMap<MeshIndex, Primitives> = BTreeMap::new();
        let mut meshes = Vec::new();
        let mut placed = Placed::new();
        for (place, shown) in shown {
            let number = *numbers.entry(shown).or_insert_with_key(|shown| {
                let mut primitives = Vec::new();
                for (mesh, replaced_by) in shown {
                    let parts =
                        stored.entry(*mesh).or_insert_with(|| self.primitives(&self.scene.meshes[*mesh]));
                    for (primitive, material) in parts.iter() {
                        let mut primitive = primitive.clone();
                        let material = replaced_by.unwrap_or(*material);
                        primitive.insert(String::from("material"), json!(material));
                        primitives.push(Value::Object(primitive));
                    }
                }
                let name = &self.scene.meshes[shown[0].0].name;
                meshes.push(json!({ "name": name, "primitives": primitives }));
                meshes.len() - 1
            });
            placed.insert(place, number);
        }
        (meshes, placed)
    }

    /// A primitive for each material of a mesh, with those vertices that it uses.
    fn primitives(&mut self, mesh: &Mesh) -> Primitives {
        let mut by_material: Vec<(MaterialIndex, Vec<u32>)> = Vec::new();
        for triangle in &mesh.triangles {
            let at = by_material.iter().position(|(material, _)| *material == triangle.material);
            let at = at.unwrap_or_else(|| {
                by_material.push((triangle.material, Vec::new()));
                by_material.len() - 1
            });
            by_material[at].1.extend(triangle.vertices);
        }
        by_material
            .into_iter()
            .map(|(material, corners)| {
                // Without normals they would mean nothing.
                let is_mapped = self.scene.materials[material].normal_map.is_some()
                    && !(mesh.tangents.is_empty() || mesh.normals.is_empty());
                (self.primitive(mesh, &corners, is_mapped), material)
            })
            .collect()
    }

    fn primitive(&mut self, mesh: &Mesh, corners: &[u32], is_mapped: bool) -> Map<String, Value> {
        let mut number = vec![u32::MAX; mesh.positions.len()];
        let mut used = Vec::new();
        let indices: Vec<u32> = corners
            .iter()
            .map(|&corner| {
                let corner = corner as usize;
                if number[corner] == u32::MAX {
                    number[corner] = used.len() as u32;
                    used.push(corner);
                }
                number[corner]
            })
            .collect();
        let vertices = Some(Target::Vertices);
        let positions: Vec<[f32; 3]> = used.iter().map(|&vertex| mesh.positions[vertex].to_array()).collect();
        let mut attributes = Map::new();
        let mut attribute = |name: &str, accessor: usize| attributes.insert(name.to_owned(), json!(accessor));
        attribute("POSITION", self.binary.floats(&positions, vertices, true));
        if !mesh.normals.is_empty() {
            let normals: Vec<[f32; 3]> = used.iter().map(|&vertex| mesh.normals[vertex].to_array()).collect();
            attribute("NORMAL", self.binary.floats(&normals, vertices, false));
        }
        if is_mapped {
            let tangents: Vec<[f32; 4]> =
                used.iter().map(|&vertex| mesh.tangents[vertex].to_array()).collect();
            attribute("TANGENT", self.binary.floats(&tangents, vertices, false));
        }
        if !mesh.uvs.is_empty() {
            let uvs: Vec<[f32; 2]> = used.iter().map(|&vertex| mesh.uvs[vertex].to_array()).collect();
            attribute("TEXCOORD_0", self.binary.floats(&uvs, vertices, false));
        }
        for (layer, uvs) in mesh.more_uvs.iter().enumerate() {
            let uvs: Vec<[f32; 2]> = used.iter().map(|&vertex| uvs[vertex].to_array()).collect();
            attribute(&format!("TEXCOORD_{}", layer + 1), self.binary.floats(&uvs, vertices, false));
        }
        if !mesh.colors.is_empty() {
            let colors: Vec<[f32; 3]> = used.iter().map(|&vertex| mesh.colors[vertex].to_array()).collect();
            attribute("COLOR_0", self.binary.floats(&colors, vertices, false));
        }
        let mut primitive = Map::new();
        primitive.insert(String::from("attributes"), Value::Object(attributes));
        primitive.insert(String::from("indices"), json!(self.binary.indices(&indices, used.len())));
        primitive
    }
}
