//! Morph targets and skins. In goes the deformation of an instance, out come attributes of its primitives,
//! weights of its node, and skins. Invariant: read back, every vertex has the same motion; vertices of masks
//! cut into deforming triangles have it approximately.

use super::Writer;
use super::binary::Target;
use crate::scene::{Animate, Deformation, Extend, InnerVertex, Joint, Mesh, NodeIndex, Segment, Skin, Track};
use glam::{DMat4, DVec3, Vec3};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// Joints in one attribute.
const PER_SET: usize = 4;

impl Writer<'_> {
    /// Adds the morph targets and influences of these vertices to a primitive.
    pub(super) fn add_deformation(
        &mut self,
        primitive: &mut Map<String, Value>,
        mesh: &Mesh,
        deformation: &Deformation,
        used: &[usize],
        is_mapped: bool,
    ) {
        let inner: BTreeMap<usize, &InnerVertex> =
            deformation.inner.iter().map(|inner| (inner.vertex as usize, inner)).collect();
        if let Some(skin) = &deformation.skin {
            self.add_influences(&mut primitive["attributes"], skin, &inner, used);
        }
        let mut differences = |values: &[Vec3], with_bounds: bool| {
            let of = |vertex: usize| values.get(vertex).map_or(DVec3::ZERO, |value| value.as_dvec3());
            let values: Vec<[f32; 3]> = used
                .iter()
                .map(|vertex| match inner.get(vertex) {
                    Some(InnerVertex { corners, weights, .. }) => {
                        (0..3).map(|corner| weights[corner] * of(corners[corner] as usize)).sum()
                    }
                    None => of(*vertex),
                })
                .map(|value: DVec3| value.as_vec3().to_array())
                .collect();
            json!(self.binary.floats(&values, Some(Target::Vertices), with_bounds))
        };
        let targets = deformation.targets.iter().map(|target| {
            let mut attributes = json!({ "POSITION": differences(&target.positions, true) });
            if !mesh.normals.is_empty() && !target.normals.is_empty() {
                attributes["NORMAL"] = differences(&target.normals, false);
            }
            if is_mapped && !target.tangents.is_empty() {
                attributes["TANGENT"] = differences(&target.tangents, false);
            }
            attributes
        });
        let targets: Vec<Value> = targets.collect();
        if !targets.is_empty() {
            primitive.insert(String::from("targets"), Value::Array(targets));
        }
    }

    /// Adds the joints of each vertex. A vertex inside a triangle has those of its corners.
    fn add_influences(
        &mut self,
        attributes: &mut Value,
        skin: &Skin,
        inner: &BTreeMap<usize, &InnerVertex>,
        used: &[usize],
    ) {
        let influences = &skin.influences;
        let of = |vertex: usize| {
            let own = vertex * influences.per_vertex..(vertex + 1) * influences.per_vertex;
            influences.joints[own.clone()].iter().copied().zip(influences.weights[own].iter().copied())
        };
        let merged = |vertex: &usize| -> Vec<(u16, f32)> {
            let Some(InnerVertex { corners, weights, .. }) = inner.get(vertex) else {
                return of(*vertex).filter(|(_, share)| *share > 0.0).collect();
            };
            let mut shares: BTreeMap<u16, f32> = BTreeMap::new();
            for (&corner, &weight) in corners.iter().zip(weights) {
                for (joint, share) in of(corner as usize) {
                    *shares.entry(joint).or_default() += weight as f32 * share;
                }
            }
            shares.into_iter().filter(|(_, share)| *share > 0.0).collect()
        };
        let all: Vec<Vec<(u16, f32)>> = used.iter().map(merged).collect();
        let sets = all.iter().map(Vec::len).max().unwrap_or_default().div_ceil(PER_SET).max(1);
        for set in 0..sets {
            // Unused slots have joint 0 with a weight of 0.
            let four = |shares: &Vec<(u16, f32)>| -> [(u16, f32); PER_SET] {
                std::array::from_fn(|at| shares.get(PER_SET * set + at).copied().unwrap_or_default())
            };
            let joints: Vec<[u16; PER_SET]> =
                all.iter().map(|shares| four(shares).map(|(joint, _)| joint)).collect();
            let weights: Vec<[f32; PER_SET]> =
                all.iter().map(|shares| four(shares).map(|(_, share)| share)).collect();
            attributes[format!("JOINTS_{set}")] = json!(self.binary.joints(&joints));
            attributes[format!("WEIGHTS_{set}")] =
                json!(self.binary.floats(&weights, Some(Target::Vertices), false));
        }
    }

    /// Sets the weights and the skin of a node's mesh.
    pub(super) fn bend(&mut self, node: usize, deformation: &Deformation) {
        if let Some(skin) = &deformation.skin {
            let number = self.skin(skin);
            self.nodes[node].insert(String::from("skin"), json!(number));
        }
        if deformation.weights.is_empty() {
            return;
        }
        let start_s = self.moments.start_s;
        let still: Vec<f64> = deformation.weights.iter().map(|weight| weight.at(start_s)).collect();
        self.nodes[node].insert(String::from("weights"), json!(still));
        if deformation.is_constant() {
            return;
        }
        let times_s = self.moments.of_tracks(&deformation.weights);
        let weights_at =
            |&time_s: &f64| deformation.weights.iter().map(move |weight| [weight.at(time_s) as f32]);
        let values: Vec<[f32; 1]> = times_s.iter().flat_map(weights_at).collect();
        let times: Vec<[f32; 1]> = times_s.iter().map(|&time_s| [time_s as f32]).collect();
        let input = self.binary.floats(&times, None, true);
        let output = self.binary.floats(&values, None, false);
        self.samplers.push(json!({ "input": input, "output": output, "interpolation": "LINEAR" }));
        let target = json!({ "node": node, "path": "weights" });
        self.channels.push(json!({ "sampler": self.samplers.len() - 1, "target": target }));
    }

    /// Index of a skin, which instances with the same joints share.
    fn skin(&mut self, skin: &Skin) -> usize {
        let bits = |joint: &Joint| joint.joint_from_rest.to_cols_array().map(f64::to_bits);
        let key: JointKey = skin.joints.iter().map(|joint| (joint.node, bits(joint))).collect();
        if let Some(number) = self.skin_numbers.get(&key) {
            return *number;
        }
        let joints: Vec<usize> = skin.joints.iter().map(|joint| self.node_numbers[joint.node]).collect();
        let matrix = |joint: &Joint| DMat4::from(joint.joint_from_rest).as_mat4().to_cols_array();
        let matrices: Vec<[f32; 16]> = skin.joints.iter().map(matrix).collect();
        let inverse_bind = self.binary.floats(&matrices, None, false);
        self.skins.push(json!({ "joints": joints, "inverseBindMatrices": inverse_bind }));
        self.skin_numbers.insert(key, self.skins.len() - 1);
        self.skins.len() - 1
    }
}

/// Key that tells skins apart: nodes, and the bits of their matrices.
pub(super) type JointKey = Vec<(NodeIndex, [u64; 12])>;

/// Whether a track is linear or constant between its keys, so that keys and the moments before jumps describe
/// it.
pub(super) fn is_straight<T: Animate>(track: &Track<T>) -> bool {
    track.extend() == Extend::Hold
        && track.keys().iter().all(|key| matches!(key.to_next, Segment::Linear | Segment::Step))
}
