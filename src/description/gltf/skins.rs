//! Skins and the joints of vertices. In go accessors, out come validated ones. Invariants: joints exist; the
//! weights of a vertex add up to 1; a node has a skin only if it covers all joints of its mesh's vertices.

use super::accessor::{Accessors, Component, Wanted};
use super::attributes::{At, UNSIGNED};
use super::json::{self, Document};
use super::report::Report;
use super::{GltfScene, Influences, Skin, named};
use crate::diagnostic::{Diagnostic, Loss};
use glam::{DAffine3, DMat4, DVec4};
use std::collections::BTreeMap;

const MATRICES: Wanted =
    Wanted { purpose: "inverse bind matrices", width: 16, components: &[Component::F32] };
const JOINTS: Wanted = Wanted { purpose: "joints", width: 4, components: &[Component::U8, Component::U16] };
const WEIGHTS: Wanted = Wanted { purpose: "weights of joints", width: 4, components: UNSIGNED };

/// Tolerance of the sum of a vertex's weights before a warning; 8-bit rounding of four weights gives 8e-3.
const SUM_TOLERANCE: f64 = 1e-2;

/// Reads all skins; an unreadable one has no joints.
pub(super) fn read(document: &Document, accessors: &Accessors<'_>, report: &mut Report) -> Vec<Skin> {
    let convert = |(index, skin): (usize, &json::Skin)| {
        let checked = checked(document, skin, &format!("skins[{index}]"), accessors);
        let (joints, inverse_bind) = report.spare(Loss::SkinDamaged, checked).unwrap_or_default();
        Skin { name: named(&skin.name, "skin", index), joints, inverse_bind }
    };
    document.skins.iter().enumerate().map(convert).collect()
}

/// Joints of a skin, and the transforms to their spaces.
fn checked(
    document: &Document,
    skin: &json::Skin,
    path: &str,
    accessors: &Accessors<'_>,
) -> Result<(Vec<usize>, Vec<DAffine3>), Diagnostic> {
    if skin.joints.is_empty() {
        return Err(accessors.invalid(format!("{path}.joints"), "the skin has no joints"));
    }
    if let Some(number) = skin.joints.iter().position(|joint| *joint >= document.nodes.len()) {
        let found = format!("node {} does not exist", skin.joints[number]);
        return Err(accessors.invalid(format!("{path}.joints[{number}]"), found));
    }
    let matrices = inverse_bind_matrices(skin, path, accessors)?;
    let identity = || vec![DAffine3::IDENTITY; skin.joints.len()];
    Ok((skin.joints.clone(), if matrices.is_empty() { identity() } else { matrices }))
}

fn inverse_bind_matrices(
    skin: &json::Skin,
    path: &str,
    accessors: &Accessors<'_>,
) -> Result<Vec<DAffine3>, Diagnostic> {
    let Some(index) = skin.inverse_bind_matrices else { return Ok(Vec::new()) };
    let path = format!("{path}.inverseBindMatrices");
    let numbers = accessors.read(index, MATRICES, &path)?;
    let (count, joints) = (numbers.len() / 16, skin.joints.len());
    if count < joints {
        let found = format!("there are {joints} joints and {count} inverse bind matrices");
        return Err(accessors.invalid(path, found).expected("a matrix for each joint"));
    }
    let affine = |(number, columns): (usize, &[f64])| {
        let matrix = DMat4::from_cols_slice(columns);
        if matrix.row(3).abs_diff_eq(DVec4::W, 1e-6) {
            return Ok(DAffine3::from_mat4(matrix));
        }
        Err(accessors
            .invalid(&path, format!("matrix {number} is not affine"))
            .expected("a last row of 0, 0, 0, 1"))
    };
    numbers.chunks_exact(16).take(joints).enumerate().map(affine).collect()
}

/// Joints and weights of a primitive's vertices; `None` if there are none.
pub(super) fn influences(
    attributes: &BTreeMap<String, usize>,
    vertices: usize,
    At { path, mesh }: At,
    accessors: &Accessors<'_>,
    report: &mut Report,
) -> Result<Option<Influences>, Diagnostic> {
    let mut sets = Vec::new();
    let mut is_uneven = false;
    // Four joints a vertex in each set.
    while let Some(&joints) = attributes.get(&format!("JOINTS_{}", sets.len())) {
        let set = sets.len();
        let user = |name: &str| format!("{path}.attributes.{name}_{set}");
        let Some(&weights) = attributes.get(&format!("WEIGHTS_{set}")) else {
            let found = "there are joints without weights";
            return Err(accessors.invalid(user("JOINTS"), found).expected(format!("WEIGHTS_{set}")));
        };
        let joints = accessors.read_for(vertices, joints, JOINTS, &user("JOINTS"))?;
        let weights = accessors.read_for(vertices, weights, WEIGHTS, &user("WEIGHTS"))?;
        is_uneven |= weights.iter().any(|&weight| weight < 0.0);
        sets.push((joints, weights.into_iter().map(|weight| weight.max(0.0)).collect::<Vec<_>>()));
    }
    if sets.is_empty() {
        return Ok(None);
    }
    let mut influences = Influences { per_vertex: 4 * sets.len(), ..Influences::default() };
    for vertex in 0..vertices {
        let own = 4 * vertex..4 * vertex + 4;
        let sum: f64 = sets.iter().flat_map(|(_, weights)| &weights[own.clone()]).sum();
        is_uneven |= (sum - 1.0).abs() > SUM_TOLERANCE;
        for (set, (joints, weights)) in sets.iter().enumerate() {
            for (place, at) in own.clone().enumerate() {
                // A vertex without weights follows its first joint.
                let first = f64::from(u8::from(set == 0 && place == 0));
                let weight = if sum > 0.0 { weights[at] / sum } else { first };
                influences.joints.push(if weight > 0.0 { joints[at] as u16 } else { 0 });
                influences.weights.push(weight as f32);
            }
        }
    }
    if is_uneven {
        report.not_honoured(Loss::JointWeights, mesh);
    }
    Ok(Some(influences))
}

/// Validates each node's skin against its mesh.
pub(super) fn check_nodes(scene: &mut GltfScene, report: &mut Report) {
    for (index, node) in scene.nodes.iter_mut().enumerate() {
        let (skin, mesh) =
            (node.skin.map(|skin| &scene.skins[skin]), node.mesh.map(|mesh| &scene.meshes[mesh]));
        // A skin without joints is reported already.
        let pair = skin.zip(mesh).filter(|(skin, _)| !skin.joints.is_empty());
        let fits = pair.is_some_and(|(skin, mesh)| {
            let influences = || mesh.primitives.iter().map(|primitive| primitive.influences.as_ref());
            let mut joints = influences().flatten().flat_map(|influences| &influences.joints);
            let count = skin.joints.len();
            if let Some(joint) = joints.find(|joint| usize::from(**joint) >= count) {
                let found = format!("the mesh hangs on joint {joint} of `{}`, which has {count}", skin.name);
                report.put_right(Loss::SkinDamaged, &format!("nodes[{index}].skin"), found);
                return false;
            }
            let is_bound = !mesh.primitives.is_empty() && influences().all(|influences| influences.is_some());
            if !is_bound {
                report.not_honoured(Loss::SkinWithoutJoints, &node.name);
            }
            is_bound
        });
        node.skin = node.skin.filter(|_| fits);
    }
}
