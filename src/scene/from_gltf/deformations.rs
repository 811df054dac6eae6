//! Morph targets and skins. In go a mesh's primitives and a node, out comes the deformation of its instance.
//! Invariant: an instance whose shape never changes is an undeformed mesh.

use super::Builder;
use super::nodes::track;
use crate::description::gltf::{Interpolation, Primitive, Property};
use crate::diagnostic::Loss;
use crate::scene::outline::Between;
use crate::scene::{Deformation, Influences, InnerVertex, Joint, MeshIndex, MorphTarget, Pose, Skin, Track};
use glam::Vec3;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Mesh of the scene with its possible deformation.
#[derive(Clone)]
pub(super) struct Converted {
    pub(super) mesh: MeshIndex,
    targets: Arc<[MorphTarget]>,
    influences: Option<Arc<Influences>>,
    inner: Arc<[InnerVertex]>,
}

/// Primitive within a merged mesh.
pub(super) struct Part<'a> {
    pub(super) primitive: &'a Primitive,
    /// Index of its first vertex.
    pub(super) first: usize,
    /// New vertices from cutting, by its own indices.
    pub(super) cuts: Vec<Between>,
}

/// Meshes with constant weights, by the mesh and the bits of its weights.
pub(super) type Baked = BTreeMap<(MeshIndex, Vec<u64>), MeshIndex>;

impl Converted {
    /// Deformation of mesh number `mesh`, from its parts.
    pub(super) fn new(mesh: MeshIndex, vertices: usize, parts: &[Part<'_>]) -> Self {
        let influences = influences(parts, vertices).map(Arc::new);
        let targets = targets(parts, vertices);
        let is_rigid = targets.is_empty() && influences.is_none();
        let inner = if is_rigid { [].into() } else { parts.iter().flat_map(inner).collect() };
        Self { mesh, targets, influences, inner }
    }
}

/// Targets of all parts, which have the same number of them.
fn targets(parts: &[Part<'_>], vertices: usize) -> Arc<[MorphTarget]> {
    let count = parts.first().map_or(0, |part| part.primitive.targets.len());
    let target = |index: usize| {
        let mut target = MorphTarget::default();
        for Part { primitive, first, .. } in parts {
            let MorphTarget { positions, normals, tangents } = &mut target;
            put(positions, &primitive.targets[index].positions, *first, vertices);
            if !primitive.normals.is_empty() {
                put(normals, &primitive.targets[index].normals, *first, vertices);
            }
            if !primitive.tangents.is_empty() {
                put(tangents, &primitive.targets[index].tangents, *first, vertices);
            }
        }
        target
    };
    (0..count).map(target).collect()
}

/// Copies displacements to their place among those of all vertices, with zeros elsewhere; nothing if there
/// are none.
fn put(all: &mut Vec<Vec3>, differences: &[Vec3], first: usize, vertices: usize) {
    if !differences.is_empty() {
        all.resize(vertices, Vec3::ZERO);
        all[first..first + differences.len()].copy_from_slice(differences);
    }
}

/// Joints and weights of all parts; `None` unless all have them.
fn influences(parts: &[Part<'_>], vertices: usize) -> Option<Influences> {
    let own: Vec<_> = parts.iter().map(|part| part.primitive.influences.as_ref()).collect::<Option<_>>()?;
    let per_vertex = own.iter().map(|own| own.per_vertex).max()?;
    let count = vertices * per_vertex;
    let mut all = Influences { per_vertex, joints: vec![0; count], weights: vec![0.0; count] };
    for (part, own) in parts.iter().zip(own) {
        let vertices = own.joints.chunks(own.per_vertex).zip(own.weights.chunks(own.per_vertex));
        for (vertex, (joints, weights)) in vertices.enumerate() {
            let at = (part.first + vertex) * per_vertex;
            all.joints[at..at + joints.len()].copy_from_slice(joints);
            all.weights[at..at + weights.len()].copy_from_slice(weights);
        }
    }
    Some(all)
}

/// Vertices of a part that cutting created.
fn inner<'a>(part: &'a Part<'_>) -> impl Iterator<Item = InnerVertex> + 'a {
    let (first, own) = (part.first as u32, part.primitive.positions.len() as u32);
    part.cuts.iter().zip(first + own..).map(move |(cut, vertex)| InnerVertex {
        vertex,
        corners: cut.corners.map(|corner| first + corner),
        weights: cut.weights,
    })
}

impl Builder<'_> {
    /// Mesh of a node and its deformation; `node` is the file's index.
    pub(super) fn bend(
        &mut self,
        part: &Converted,
        node: usize,
        baked: &mut Baked,
    ) -> (MeshIndex, Option<Arc<Deformation>>) {
        let weights = if part.targets.is_empty() { Vec::new() } else { self.weights(node) };
        let targets = Arc::clone(&part.targets);
        let (skin, inner) = (self.skin(part, node), Arc::clone(&part.inner));
        let deformation = Deformation { targets, weights, skin, inner };
        if deformation.skin.is_some() || !deformation.is_constant() {
            return (part.mesh, Some(Arc::new(deformation)));
        }
        let weights: Vec<f64> = deformation.weights.iter().map(|weight| weight.at(0.0)).collect();
        if weights.iter().all(|weight| *weight == 0.0) {
            return (part.mesh, None);
        }
        let key = (part.mesh, weights.iter().map(|weight| weight.to_bits()).collect());
        let mesh = *baked.entry(key).or_insert_with(|| {
            let mut mesh = self.scene.meshes[part.mesh].clone();
            let shape = deformation.shape(&mesh, &Pose { weights, shape_from_rest: Vec::new() });
            (mesh.positions, mesh.normals, mesh.tangents) = (shape.positions, shape.normals, shape.tangents);
            self.scene.meshes.push(mesh);
            self.scene.meshes.len() - 1
        });
        (mesh, None)
    }

    /// Weights of a node's mesh: animated, else the node's, else the mesh's.
    fn weights(&self, node: usize) -> Vec<Track<f64>> {
        let source = &self.source.nodes[node];
        let of_mesh = || source.mesh.map(|mesh| self.source.meshes[mesh].weights.clone()).unwrap_or_default();
        let still = source.weights.clone().unwrap_or_else(of_mesh);
        let count = still.len();
        let Some(channel) = self.property(Property::Weights, node) else {
            return still.into_iter().map(Track::from).collect();
        };
        let parts = if channel.interpolation == Interpolation::Cubic { 3 } else { 1 };
        let own = |index: usize| -> Vec<f64> {
            (0..channel.times_s.len() * parts).map(|at| channel.values[at * count + index]).collect()
        };
        let keyed = |(index, still): (usize, f64)| {
            track(&channel.times_s, channel.interpolation, &own(index), &self.clock)
                .unwrap_or(Track::from(still))
        };
        still.into_iter().enumerate().map(keyed).collect()
    }

    fn skin(&mut self, part: &Converted, node: usize) -> Option<Skin> {
        let index = self.source.nodes[node].skin?;
        let influences = Arc::clone(part.influences.as_ref()?);
        let source = &self.source.skins[index];
        let mut joints = Vec::with_capacity(source.joints.len());
        for (number, (&joint, &joint_from_rest)) in source.joints.iter().zip(&source.inverse_bind).enumerate()
        {
            match self.node_numbers[joint] {
                Some(node) => joints.push(Joint { node, joint_from_rest }),
                None => {
                    let path = format!("skins[{index}].joints[{number}]");
                    let found = format!("node {joint} is not in the scene that is shown");
                    self.report.put_right(Loss::SkinDamaged, &path, found);
                    return None;
                }
            }
        }
        Some(Skin { joints: joints.into(), influences })
    }
}
