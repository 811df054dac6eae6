//! Meshes and their instances. In go nodes and primitives, out come both. Invariant: a mesh is converted
//! once, however many nodes show it. Every instance has its own leaf id, unless the author gave two the same.

use super::Builder;
use super::deformations::{Baked, Converted, Part};
use crate::description::gltf::{self, Primitive};
use crate::diagnostic::{Diagnostic, Loss};
use crate::scene::outline::Between;
use crate::scene::{Instance, MaterialIndex, Mesh, Motion, Triangle};
use glam::{DVec3, Vec2, Vec3, Vec4};

impl Builder<'_> {
    /// Adds an instance for every node of the scene with a mesh, and the meshes.
    pub(super) fn add_meshes_and_instances(&mut self) {
        let mut converted: Vec<Option<Vec<Converted>>> = vec![None; self.source.meshes.len()];
        let mut baked = Baked::new();
        let mut material_used = vec![false; self.source.materials.len()];
        let mut shown = Vec::new();
        for (index, node) in self.source.nodes.iter().enumerate() {
            let (Some(number), Some(mesh)) = (self.node_numbers[index], node.mesh) else { continue };
            // The mesh of a fog volume only shows its place to the author.
            if node.extras.get("sunfleck_fog_volume").is_some() {
                continue;
            }
            if converted[mesh].is_none() {
                let mesh_source = &self.source.meshes[mesh];
                for material in mesh_source.primitives.iter().filter_map(|primitive| primitive.material) {
                    material_used[material] = true;
                }
                converted[mesh] = Some(self.add_mesh(mesh_source));
            }
            match &node.instances {
                None => shown.push((index, number, mesh, None)),
                Some(places) => shown.extend(places.iter().enumerate().map(|(copy, &place)| {
                    let name = format!("{}[{copy}]", node.name);
                    let motion = Motion::Still(place);
                    let own = self.scene.add_node(name, Some(number), motion);
                    (index, own, mesh, node.instance_colors.get(copy).copied())
                })),
            }
        }
        for (material, used) in self.source.materials.iter().zip(material_used) {
            if used && !material.double_sided {
                self.report.not_honoured(Loss::BackfaceCulling, &material.name);
            }
        }
        let leaf_ids = self.leaf_ids(&shown.iter().map(|&(node, ..)| node).collect::<Vec<_>>());
        for ((index, node, source, color), leaf_id) in shown.into_iter().zip(leaf_ids) {
            let rays = self.ray_visibility(index);
            self.scene.set_ray_visibility(node, rays);
            for part in converted[source].iter().flatten() {
                let (mesh, deformation) = self.bend(part, index, &mut baked);
                let material = color.and_then(|color| self.in_color(index, mesh, color));
                self.scene.instances.push(Instance { node, mesh, material, leaf_id, deformation });
            }
        }
    }

    /// Material of a mesh with an instance's colour. A mesh of several materials, or with an animated one,
    /// keeps its own, and the loss is reported.
    fn in_color(&mut self, node: usize, mesh: usize, color: DVec3) -> Option<MaterialIndex> {
        let triangles = &self.scene.meshes[mesh].triangles;
        let material = triangles.first()?.material;
        let is_one = triangles.iter().all(|triangle| triangle.material == material);
        if !is_one || self.scene.materials[material].changes.is_some() {
            let name = format!("_COLOR_0` of `{}", self.source.nodes[node].name);
            self.report.not_honoured(Loss::InstanceAttributes, &name);
            return None;
        }
        let key = (material, color.to_array().map(f64::to_bits));
        if let Some(&known) = self.colored.get(&key) {
            return Some(known);
        }
        let mut made = self.scene.materials[material].tinted(color);
        made.name = format!("{} {}", made.name, self.colored.len() + 1);
        self.scene.materials.push(made);
        self.colored.insert(key, self.scene.materials.len() - 1);
        Some(self.scene.materials.len() - 1)
    }

    /// Adds a mesh of the file as one or two: primitives with normals, and those without.
    fn add_mesh(&mut self, source: &gltf::Mesh) -> Vec<Converted> {
        let (smooth, flat): (Vec<_>, Vec<_>) =
            source.primitives.iter().partition(|primitive| !primitive.normals.is_empty());
        let mut added = Vec::new();
        for primitives in [smooth, flat].iter().filter(|primitives| !primitives.is_empty()) {
            let (mesh, parts) = self.merged(&source.name, primitives);
            if mesh.triangles.is_empty() {
                continue;
            }
            added.push(Converted::new(self.scene.meshes.len(), mesh.positions.len(), &parts));
            self.scene.meshes.push(mesh);
        }
        if added.is_empty() {
            self.report.not_honoured(Loss::MeshWithoutTriangles, &source.name);
        }
        added
    }

    /// Primitives as one mesh, and their places in it.
    fn merged<'p>(&mut self, name: &str, primitives: &[&'p Primitive]) -> (Mesh, Vec<Part<'p>>) {
        let mut mesh = Mesh { name: name.to_owned(), ..Mesh::default() };
        let mut parts = Vec::new();
        let textured = primitives.iter().any(|primitive| !primitive.uvs.is_empty());
        let colored = primitives.iter().any(|primitive| !primitive.colors.is_empty());
        let mapped = primitives.iter().any(|primitive| !primitive.tangents.is_empty());
        let layers = primitives.iter().map(|primitive| primitive.more_uvs.len()).max().unwrap_or_default();
        mesh.more_uvs.resize(layers, Vec::new());
        for primitive in primitives {
            let (part, cuts) = self.part(name, primitive);
            parts.push(Part { primitive, first: mesh.positions.len(), cuts });
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(part.positions);
            mesh.normals.extend(part.normals);
            if textured {
                mesh.uvs.extend(part.uvs);
                mesh.uvs.resize(mesh.positions.len(), Vec2::ZERO);
            }
            if colored {
                mesh.colors.extend(part.colors);
                mesh.colors.resize(mesh.positions.len(), Vec3::ONE);
            }
            // A mesh cut by a mask is opaque.
            if !part.alphas.is_empty() || !mesh.alphas.is_empty() {
                mesh.alphas.resize(first as usize, 1.0);
                mesh.alphas.extend(part.alphas);
                mesh.alphas.resize(mesh.positions.len(), 1.0);
            }
            if mapped {
                mesh.tangents.extend(part.tangents);
                mesh.tangents.resize(mesh.positions.len(), Vec4::X + Vec4::W);
            }
            let mut more_uvs = part.more_uvs.into_iter();
            for uvs in &mut mesh.more_uvs {
                uvs.extend(more_uvs.next().unwrap_or_default());
                uvs.resize(mesh.positions.len(), Vec2::ZERO);
            }
            let moved = |Triangle { vertices, material }| Triangle {
                vertices: vertices.map(|v| first + v),
                material,
            };
            mesh.triangles.extend(part.triangles.into_iter().map(moved));
        }
        (mesh, parts)
    }

    /// Visible part of a primitive as a mesh, and its new vertices.
    fn part(&mut self, name: &str, primitive: &Primitive) -> (Mesh, Vec<Between>) {
        let material = self.material_of(primitive.material);
        let triangle = |&vertices: &[u32; 3]| Triangle { vertices, material };
        let whole = Mesh {
            name: name.to_owned(),
            positions: primitive.positions.clone(),
            normals: primitive.normals.clone(),
            uvs: primitive.uvs.clone(),
            more_uvs: primitive.more_uvs.clone(),
            colors: primitive.colors.clone(),
            alphas: primitive.alphas.clone(),
            tangents: primitive.tangents.clone(),
            triangles: primitive.triangles.iter().map(triangle).collect(),
        };
        self.cut_out(whole, primitive.material)
    }

    /// Leaf ids: the authors', and consecutive numbers from 1 for other nodes.
    fn leaf_ids(&mut self, nodes: &[usize]) -> Vec<u32> {
        let given: Vec<Option<u32>> = nodes.iter().map(|&node| self.given_leaf_id(node)).collect();
        // 0 is the background. Ids that begin at 0 are raised by 1.
        let shift = u32::from(given.contains(&Some(0)));
        if shift == 1 {
            self.report.push(Diagnostic::note(
                self.report.at("nodes"),
                "leaf ids start at 0, which stands for the background: all of them are raised by 1",
            ));
        }
        let mut next = given.iter().flatten().max().map_or(1, |&largest| largest + shift + 1);
        let mut id = |given: Option<u32>| {
            given.map(|id| id + shift).unwrap_or_else(|| {
                next += 1;
                next - 1
            })
        };
        given.into_iter().map(&mut id).collect()
    }

    fn given_leaf_id(&mut self, node: usize) -> Option<u32> {
        let value = self.source.nodes[node].extras.get("leaf_id")?;
        // At most half of all numbers, so that raising and counting never overflow.
        let id = value.as_u64().and_then(|id| u32::try_from(id).ok()).filter(|&id| id <= u32::MAX / 2);
        if id.is_none() {
            let path = format!("nodes[{node}].extras.leaf_id");
            self.report.error(path, format!("{value} is no leaf id"), "a whole number from 0 to 2147483647");
        }
        id
    }
}
