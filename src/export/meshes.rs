//! Meshes, one primitive a material. In goes a scene, out come glTF's meshes. Invariant: the triangles of a
//! mesh are stored once, however many materials and instances show it.

use super::Writer;
use super::binary::Target;
use crate::diagnostic::Loss;
use crate::scene::{Deformation, MaterialIndex, Mesh, MeshIndex, NodeIndex};
use glam::{DVec3, Vec3};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Part of a glTF mesh: a mesh of the scene, a material that replaces its own, and a deformation.
type Part = (MeshIndex, Option<MaterialIndex>, Option<Bending>);

/// Addresses of a deformation's targets and influences, which instances of one mesh share.
type Bending = (usize, Option<usize>);

/// Primitives of a mesh, each with its own material.
type Primitives = Vec<(Map<String, Value>, MaterialIndex)>;

/// Index of the glTF mesh by its node, its leaf id, and its instance if it deforms.
pub(super) type Placed = BTreeMap<(NodeIndex, u32, Option<usize>), usize>;

impl Writer<'_> {
    /// All meshes that are shown, and their places.
    pub(super) fn meshes(&mut self) -> (Vec<Value>, Placed) {
        let scene = self.scene;
        // Meshes at one node with one leaf id are one mesh in glTF; a deforming mesh has a node of its own.
        let mut shown: BTreeMap<(NodeIndex, u32, Option<usize>), Vec<Part>> = BTreeMap::new();
        for (number, instance) in scene.instances.iter().enumerate() {
            let bending = instance.deformation.as_deref().map(bending);
            let own = bending.map(|_| number);
            let at = shown.entry((instance.node, instance.leaf_id, own)).or_default();
            at.push((instance.mesh, instance.material, bending));
        }
        let is_cut = |deformation: &Deformation| !deformation.inner.is_empty();
        let cut =
            scene.instances.iter().filter(|instance| instance.deformation.as_deref().is_some_and(is_cut));
        if cut.clone().count() > 0 {
            self.lost(Loss::ExportShape, format!(
                "{} meshes that bend are cut out along a mask: where they are cut they bend only nearly as here",
                cut.count()
            ));
        }
        let mut numbers: BTreeMap<Vec<Part>, usize> = BTreeMap::new();
        let mut stored: BTreeMap<(MeshIndex, Option<Bending>), Primitives> = BTreeMap::new();
        let mut meshes = Vec::new();
        let mut placed = Placed::new();
        for (place, shown) in shown {
            let deformation = place.2.and_then(|instance| scene.instances[instance].deformation.as_deref());
            let number = *numbers.entry(shown).or_insert_with_key(|shown| {
                let mut primitives = Vec::new();
                for &(mesh, replaced_by, bending) in shown {
                    let parts = stored
                        .entry((mesh, bending))
                        .or_insert_with(|| self.primitives(&scene.meshes[mesh], deformation));
                    for (primitive, material) in parts.iter() {
                        let mut primitive = primitive.clone();
                        let material = replaced_by.unwrap_or(*material);
                        primitive.insert(String::from("material"), json!(material));
                        primitives.push(Value::Object(primitive));
                    }
                }
                let name = &scene.meshes[shown[0].0].name;
                meshes.push(json!({ "name": name, "primitives": primitives }));
                meshes.len() - 1
            });
            placed.insert(place, number);
        }
        (meshes, placed)
    }

    /// Primitives of a mesh, one a material, with the vertices that each uses.
    fn primitives(&mut self, mesh: &Mesh, deformation: Option<&Deformation>) -> Primitives {
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
                let is_mapped =
                    self.scene.materials[material].has_normal_map() && !mesh.tangents.is_empty();
                let is_flat = mesh.normals.is_empty();
                let primitive = match deformation {
                    // glTF ignores tangents without normals.
                    None if is_mapped && is_flat => {
                        let faceted = faceted(mesh, &corners);
                        let corners: Vec<u32> = (0..corners.len() as u32).collect();
                        self.primitive(&faceted, &corners, true, None)
                    }
                    _ => self.primitive(mesh, &corners, is_mapped && !is_flat, deformation),
                };
                if deformation.is_some() && is_mapped && is_flat {
                    self.lost(Loss::ExportShape, format!(
                        "`{}` bends and is flat: its normal map goes by the coordinates that it is looked up with",
                        mesh.name
                    ));
                }
                (primitive, material)
            })
            .collect()
    }

    fn primitive(
        &mut self,
        mesh: &Mesh,
        corners: &[u32],
        is_mapped: bool,
        deformation: Option<&Deformation>,
    ) -> Map<String, Value> {
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
        let color = |vertex: usize| mesh.colors.get(vertex).copied().unwrap_or(Vec3::ONE);
        if !mesh.alphas.is_empty() {
            let colors: Vec<[f32; 4]> =
                used.iter().map(|&vertex| color(vertex).extend(mesh.alphas[vertex]).to_array()).collect();
            attribute("COLOR_0", self.binary.floats(&colors, vertices, false));
        } else if !mesh.colors.is_empty() {
            let colors: Vec<[f32; 3]> = used.iter().map(|&vertex| color(vertex).to_array()).collect();
            attribute("COLOR_0", self.binary.floats(&colors, vertices, false));
        }
        let mut primitive = Map::new();
        primitive.insert(String::from("attributes"), Value::Object(attributes));
        primitive.insert(String::from("indices"), json!(self.binary.indices(&indices, used.len())));
        if let Some(deformation) = deformation {
            self.add_deformation(&mut primitive, mesh, deformation, &used, is_mapped);
        }
        primitive
    }
}

/// Triangles with vertices of their own and flat normals.
fn faceted(mesh: &Mesh, corners: &[u32]) -> Mesh {
    fn at<T: Copy>(values: &[T], corners: &[u32]) -> Vec<T> {
        corners.iter().filter_map(|&corner| values.get(corner as usize).copied()).collect()
    }
    let positions = at(&mesh.positions, corners);
    let normal = |[a, b, c]: &[Vec3; 3]| {
        let [a, b, c] = [a, b, c].map(|position| position.as_dvec3());
        // A degenerate triangle is never seen.
        (b - a).cross(c - a).try_normalize().unwrap_or(DVec3::Y).as_vec3()
    };
    Mesh {
        name: mesh.name.clone(),
        normals: positions.as_chunks().0.iter().flat_map(|triangle| [normal(triangle); 3]).collect(),
        positions,
        uvs: at(&mesh.uvs, corners),
        more_uvs: mesh.more_uvs.iter().map(|uvs| at(uvs, corners)).collect(),
        colors: at(&mesh.colors, corners),
        alphas: at(&mesh.alphas, corners),
        tangents: at(&mesh.tangents, corners),
        triangles: Vec::new(),
    }
}

fn bending(deformation: &Deformation) -> Bending {
    let influences = deformation.skin.as_ref().map(|skin| Arc::as_ptr(&skin.influences).addr());
    (Arc::as_ptr(&deformation.targets).addr(), influences)
}
