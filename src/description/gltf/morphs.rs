//! Morph targets. In go accessors, out come displacements and weights. Invariants: a target has a
//! displacement for every vertex, or none at all. All primitives of a mesh have as many targets as it has
//! weights, which may be none.

use super::accessor::{Accessors, Wanted};
use super::attributes::{At, SIGNED_OR_NOT, vectors};
use super::json::{self, Document};
use super::report::Report;
use super::{MorphTarget, Node, Primitive};
use crate::diagnostic::{Diagnostic, Loss};
use glam::Vec3;

const DIFFERENCES: Wanted =
    Wanted { purpose: "differences of morph targets", width: 3, components: SIGNED_OR_NOT };

/// Reads the targets of a primitive at `path`, with a displacement for each vertex.
pub(super) fn targets(
    primitive: &json::Primitive,
    vertices: usize,
    At { path, mesh }: At,
    accessors: &Accessors<'_>,
    report: &mut Report,
) -> Result<Vec<MorphTarget>, Diagnostic> {
    let mut targets = Vec::with_capacity(primitive.targets.len());
    for (number, attributes) in primitive.targets.iter().enumerate() {
        for name in
            attributes.keys().filter(|name| !["POSITION", "NORMAL", "TANGENT"].contains(&name.as_str()))
        {
            let name = format!("{name}` of `{mesh}");
            report.not_honoured(Loss::MorphTargetAttributes, &name);
        }
        let differences = |name: &str| -> Result<Vec<Vec3>, Diagnostic> {
            let Some(&index) = attributes.get(name) else { return Ok(Vec::new()) };
            let user = format!("{path}.targets[{number}].{name}");
            Ok(vectors(&accessors.read_for(vertices, index, DIFFERENCES, &user)?))
        };
        targets.push(MorphTarget {
            positions: differences("POSITION")?,
            normals: differences("NORMAL")?,
            tangents: differences("TANGENT")?,
        });
    }
    Ok(targets)
}

/// Weights of a mesh with these primitives, 0 by default. Primitives with different numbers of targets lose
/// them.
pub(super) fn weights(
    mesh: &json::Mesh,
    index: usize,
    primitives: &mut [Primitive],
    report: &mut Report,
) -> Vec<f64> {
    let path = format!("meshes[{index}]");
    let count = mesh.primitives.first().map_or(0, |primitive| primitive.targets.len());
    if primitives.iter().any(|primitive| primitive.targets.len() != count) {
        if mesh.primitives.iter().any(|primitive| primitive.targets.len() != count) {
            let found = "the primitives have different numbers of morph targets";
            report.put_right(Loss::MorphTargetsDamaged, &format!("{path}.primitives"), found);
        }
        primitives.iter_mut().for_each(|primitive| primitive.targets.clear());
        return Vec::new();
    }
    checked(&mesh.weights, count, &format!("{path}.weights"), report).unwrap_or(vec![0.0; count])
}

/// Validates the weights of nodes against the targets of their meshes.
pub(super) fn check_nodes(document: &Document, nodes: &mut [Node], counts: &[usize], report: &mut Report) {
    for (index, (node, source)) in nodes.iter_mut().zip(&document.nodes).enumerate() {
        let Some(&count) = node.mesh.and_then(|mesh| counts.get(mesh)) else { continue };
        node.weights = checked(&source.weights, count, &format!("nodes[{index}].weights"), report);
    }
}

fn checked(weights: &[f64], count: usize, path: &str, report: &mut Report) -> Option<Vec<f64>> {
    if weights.is_empty() {
        return None;
    }
    if count == 0 {
        report.not_honoured(Loss::MorphWeightsWithoutTargets, path);
        return None;
    }
    if weights.len() != count || weights.iter().any(|weight| weight.abs() > LARGEST_WEIGHT) {
        let found = format!("{weights:?} are no weights of {count} morph targets");
        report.put_right(Loss::MorphTargetsDamaged, path, found);
        return None;
    }
    Some(weights.to_vec())
}

/// Larger weights are ignored, so that products stay in single precision.
const LARGEST_WEIGHT: f64 = 1e6;
