//! Deformation of an instance's mesh: morph targets first, then a skin. In go the mesh at rest and a time,
//! out come its vertices. Invariants: targets and influences have a value for every vertex of the mesh;
//! every joint's node exists.

use super::{Mesh, NodeIndex, Placement, Track};
pub use crate::description::gltf::{Influences, MorphTarget};
use glam::{DAffine3, DMat3, DVec3, Vec3, Vec4};
use std::sync::Arc;

/// Deformation of one instance's mesh.
#[derive(Clone, Debug)]
pub struct Deformation {
    /// Morph targets, shared by all instances of the mesh.
    pub targets: Arc<[MorphTarget]>,
    /// Weight of each target; any number, also below 0.
    pub weights: Vec<Track<f64>>,
    /// Skin that it follows.
    pub skin: Option<Skin>,
    /// Vertices that lie on triangles of the mesh before cutting, and stay there.
    pub inner: Arc<[InnerVertex]>,
}

/// Vertex on a triangle of three others.
#[derive(Clone, Copy, Debug)]
pub struct InnerVertex {
    /// Vertex of the mesh.
    pub vertex: u32,
    /// Corners of the triangle, none of which is an inner vertex.
    pub corners: [u32; 3],
    /// Weights of the corners; 1 in sum.
    pub weights: [f64; 3],
}

/// Joints and their influences on vertices.
#[derive(Clone, Debug)]
pub struct Skin {
    /// Joints, at least one.
    pub joints: Arc<[Joint]>,
    /// Influences of the joints on vertices.
    pub influences: Arc<Influences>,
}

/// Node that moves vertices.
#[derive(Clone, Copy, Debug)]
pub struct Joint {
    /// Node of the joint.
    pub node: NodeIndex,
    /// Transform from the mesh at rest to the joint's space.
    pub joint_from_rest: DAffine3,
}

/// Parameters of a mesh's shape at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// Weights of the morph targets.
    pub weights: Vec<f64>,
    /// Transforms of the joints to the space of the shape.
    pub shape_from_rest: Vec<DAffine3>,
}

/// Vertices of a mesh at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape {
    /// Positions, one a vertex.
    pub positions: Vec<Vec3>,
    /// Normals, one a vertex, or none at all; unit length.
    pub normals: Vec<Vec3>,
    /// Tangents of the mesh, transformed.
    pub tangents: Vec<Vec4>,
}

impl Deformation {
    /// Whether its weights are constant; joints may still move.
    pub fn is_constant(&self) -> bool {
        self.weights.iter().all(Track::is_constant)
    }

    /// Pose at a time, and the space of its shape: that of the node, or, with a skin, that of its first joint
    /// without rotation. So single precision need not span the scene.
    pub fn pose(&self, placements: &[Placement], node: NodeIndex, time_s: f64) -> (Pose, DAffine3) {
        let weights = self.weights.iter().map(|weight| weight.at(time_s)).collect();
        let Some(skin) = &self.skin else {
            let pose = Pose { weights, shape_from_rest: Vec::new() };
            return (pose, placements[node].world_from_node);
        };
        let world_from_joint = |joint: &Joint| placements[joint.node].world_from_node;
        let anchor = skin.joints.first().map_or(DVec3::ZERO, |joint| world_from_joint(joint).translation);
        let shape_from_rest = |joint: &Joint| {
            let mut shape_from_joint = world_from_joint(joint);
            shape_from_joint.translation -= anchor;
            shape_from_joint * joint.joint_from_rest
        };
        let shape_from_rest = skin.joints.iter().map(shape_from_rest).collect();
        (Pose { weights, shape_from_rest }, DAffine3::from_translation(anchor))
    }

    /// Shape of `mesh` in a pose; the deformation has to belong to this mesh.
    pub fn shape(&self, mesh: &Mesh, pose: &Pose) -> Shape {
        let mut positions: Vec<DVec3> = mesh.positions.iter().map(|position| position.as_dvec3()).collect();
        let mut normals: Vec<DVec3> = mesh.normals.iter().map(|normal| normal.as_dvec3()).collect();
        let mut tangents: Vec<DVec3> =
            mesh.tangents.iter().map(|tangent| tangent.truncate().as_dvec3()).collect();
        let mut sides: Vec<f32> = mesh.tangents.iter().map(|tangent| tangent.w).collect();
        for (target, &weight) in self.targets.iter().zip(&pose.weights).filter(|(_, weight)| **weight != 0.0)
        {
            add(&mut positions, &target.positions, weight);
            add(&mut normals, &target.normals, weight);
            add(&mut tangents, &target.tangents, weight);
        }
        if let Some(skin) = &self.skin {
            for (vertex, position) in positions.iter_mut().enumerate() {
                let shape_from_rest = skin.influences.blend(vertex, &pose.shape_from_rest);
                *position = shape_from_rest.transform_point3(*position);
                // Mirroring keeps the front side, and flips bitangents.
                let mirrored = if shape_from_rest.matrix3.determinant() < 0.0 { -1.0 } else { 1.0 };
                if let Some(normal) = normals.get_mut(vertex) {
                    *normal = mirrored * (cofactor(shape_from_rest.matrix3) * *normal);
                }
                if let Some(side) = sides.get_mut(vertex) {
                    *side *= mirrored as f32;
                }
                if let Some(tangent) = tangents.get_mut(vertex) {
                    *tangent = shape_from_rest.matrix3 * *tangent;
                }
            }
        }
        for InnerVertex { vertex, corners, weights } in self.inner.iter() {
            let between = |values: &[DVec3]| -> DVec3 {
                (0..3).map(|corner| weights[corner] * values[corners[corner] as usize]).sum()
            };
            positions[*vertex as usize] = between(&positions);
            if !normals.is_empty() {
                normals[*vertex as usize] = between(&normals);
            }
            if !tangents.is_empty() {
                tangents[*vertex as usize] = between(&tangents);
            }
        }
        // Where a normal vanishes, that of the mesh at rest is used.
        let unit =
            |(normal, rest): (&DVec3, &Vec3)| normal.try_normalize().map_or(*rest, |normal| normal.as_vec3());
        let tangent = |vertex: usize| {
            let normal = normals.get(vertex).and_then(|normal| normal.try_normalize());
            let tangent =
                normal.map_or(tangents[vertex], |normal| tangents[vertex].reject_from_normalized(normal));
            let rest = mesh.tangents[vertex].truncate();
            tangent.try_normalize().map_or(rest, |tangent| tangent.as_vec3()).extend(sides[vertex])
        };
        Shape {
            positions: positions.iter().map(|position| position.as_vec3()).collect(),
            normals: normals.iter().zip(&mesh.normals).map(unit).collect(),
            tangents: (0..tangents.len()).map(tangent).collect(),
        }
    }
}

impl Influences {
    /// Linear blend skinning (glTF specification, 3.7.3.3): the weighted mean of the joints' matrices.
    fn blend(&self, vertex: usize, matrices: &[DAffine3]) -> DAffine3 {
        let own = vertex * self.per_vertex..(vertex + 1) * self.per_vertex;
        let mut sum = DAffine3::from_mat3_translation(DMat3::ZERO, DVec3::ZERO);
        for (&joint, &weight) in self.joints[own.clone()].iter().zip(&self.weights[own]) {
            let (matrix, weight) = (matrices[usize::from(joint)], f64::from(weight));
            sum.matrix3 += matrix.matrix3 * weight;
            sum.translation += matrix.translation * weight;
        }
        sum
    }
}

fn add(values: &mut [DVec3], differences: &[Vec3], weight: f64) {
    for (value, difference) in values.iter_mut().zip(differences) {
        *value += difference.as_dvec3() * weight;
    }
}

/// Cofactor matrix, the inverse transpose times the determinant. It transforms normals and exists for every
/// matrix.
fn cofactor(m: DMat3) -> DMat3 {
    DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter turn about z of one joint takes half of a vertex that hangs on two with it.
    #[test]
    fn skins_blend_the_matrices_of_joints() {
        let mesh =
            Mesh { positions: vec![Vec3::X, Vec3::X], normals: vec![Vec3::X, Vec3::Z], ..Mesh::default() };
        let joint = |node| Joint { node, joint_from_rest: DAffine3::IDENTITY };
        let influences =
            Influences { per_vertex: 2, joints: vec![1, 0, 0, 1], weights: vec![1.0, 0.0, 0.5, 0.5] };
        let skin = Some(Skin { joints: [joint(0), joint(1)].into(), influences: Arc::new(influences) });
        let deformation = Deformation { targets: [].into(), weights: Vec::new(), skin, inner: [].into() };
        let far = DVec3::new(1e6, 0.0, 0.0);
        let turn = DAffine3::from_rotation_z(std::f64::consts::FRAC_PI_2);
        let placements = [DAffine3::IDENTITY, turn]
            .map(|m| Placement { world_from_node: DAffine3::from_translation(far) * m, visible: true });
        let (pose, world_from_shape) = deformation.pose(&placements, 0, 0.0);
        assert_eq!(world_from_shape, DAffine3::from_translation(far));
        let shape = deformation.shape(&mesh, &pose);
        assert!(shape.positions[0].distance(Vec3::Y) < 1e-7);
        assert!(shape.positions[1].distance(Vec3::new(0.5, 0.5, 0.0)) < 1e-7);
        assert!(shape.normals[0].distance(Vec3::Y) < 1e-7);
        assert!(shape.normals[1].distance(Vec3::Z) < 1e-7);
    }

    #[test]
    fn morph_targets_add_up_with_any_weights() {
        let mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::ZERO],
            normals: vec![Vec3::Z; 3],
            ..Mesh::default()
        };
        let raised = MorphTarget {
            positions: vec![Vec3::Y, Vec3::ZERO, Vec3::ZERO],
            normals: vec![Vec3::X, Vec3::ZERO, Vec3::ZERO],
            tangents: Vec::new(),
        };
        let wide = MorphTarget { positions: vec![Vec3::ZERO, Vec3::X, Vec3::ZERO], ..MorphTarget::default() };
        let weights = vec![Track::from(2.0), Track::from(-0.5)];
        let inner = [InnerVertex { vertex: 2, corners: [0, 1, 1], weights: [0.25, 0.5, 0.25] }].into();
        let deformation = Deformation { targets: [raised, wide].into(), weights, skin: None, inner };
        let turned = Placement { world_from_node: DAffine3::from_rotation_x(1.0), visible: true };
        let (pose, world_from_shape) = deformation.pose(&[turned], 0, 0.0);
        assert_eq!(world_from_shape, turned.world_from_node);
        let shape = deformation.shape(&mesh, &pose);
        assert_eq!(shape.positions, [Vec3::Y * 2.0, Vec3::X * 0.5, Vec3::new(0.375, 0.5, 0.0)]);
        assert!(shape.normals[0].distance(Vec3::new(2.0, 0.0, 1.0).normalize()) < 1e-7);
        assert_eq!(shape.normals[1], Vec3::Z);
    }
}
