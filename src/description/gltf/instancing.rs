//! Instances of nodes (EXT_mesh_gpu_instancing). In go attributes, out come transforms. Invariant: all
//! attributes have the same length, which is the number of instances.

use super::accessor::{Accessors, Component, Wanted};
use super::attributes::UNSIGNED;
use super::json::{self, Document};
use super::report::Report;
use super::{Node, named};
use crate::diagnostic::{Diagnostic, Loss};
use glam::{DAffine3, DQuat, DVec3};

const VECTORS: Wanted =
    Wanted { purpose: "places and sizes of instances", width: 3, components: &[Component::F32] };
const ROTATIONS: Wanted = Wanted {
    purpose: "rotations of instances",
    width: 4,
    components: &[Component::F32, Component::I8, Component::I16],
};

/// Attribute of colours, as three.js and Babylon.js name it.
const COLOR: &str = "_COLOR_0";
const COLORS: Wanted = Wanted { purpose: "colours of instances", width: 3, components: UNSIGNED };

/// Sets the transforms of every node's instances, in the node's space.
pub(super) fn read(document: &Document, nodes: &mut [Node], accessors: &Accessors<'_>, report: &mut Report) {
    for (index, (node, source)) in nodes.iter_mut().zip(&document.nodes).enumerate() {
        let Some(instancing) = &source.extensions.instancing else { continue };
        let name = named(&source.name, "node", index);
        if node.mesh.is_none() {
            report.not_honoured(Loss::InstancesWithoutMesh, &name);
            continue;
        }
        if node.skin.take().is_some() {
            report.not_honoured(Loss::InstancesOfSkins, &name);
        }
        for attribute in instancing.attributes.keys() {
            if !["TRANSLATION", "ROTATION", "SCALE", COLOR].contains(&attribute.as_str()) {
                let name = format!("{attribute}` of `{name}");
                report.not_honoured(Loss::InstanceAttributes, &name);
            }
        }
        node.instances = report.spare(Loss::InstancesDamaged, places(instancing, index, accessors));
        let count = node.instances.as_ref().map_or(0, Vec::len);
        let colors = colors(document, instancing, (index, count), accessors);
        node.instance_colors = report.spare(Loss::InstancesDamaged, colors).unwrap_or_default();
    }
}

/// Colours of the instances of a node; without alpha.
fn colors(
    document: &Document,
    instancing: &json::Instancing,
    (index, count): (usize, usize),
    accessors: &Accessors<'_>,
) -> Result<Vec<DVec3>, Diagnostic> {
    let Some(&accessor) = instancing.attributes.get(COLOR) else { return Ok(Vec::new()) };
    let path = format!("nodes[{index}].extensions.EXT_mesh_gpu_instancing.attributes.{COLOR}");
    let has_alpha = document.accessors.get(accessor).is_some_and(|accessor| accessor.shape == "VEC4");
    let width = if has_alpha { 4 } else { 3 };
    let numbers = accessors.read(accessor, Wanted { width, ..COLORS }, &path)?;
    if numbers.len() != width * count {
        let found = format!("{} colours for {count} instances", numbers.len() / width);
        return Err(accessors.invalid(path, found).expected("one element an instance"));
    }
    let color = |numbers: &[f64]| DVec3::from_slice(numbers).clamp(DVec3::ZERO, DVec3::ONE);
    Ok(numbers.chunks_exact(width).map(color).collect())
}

fn places(
    instancing: &json::Instancing,
    index: usize,
    accessors: &Accessors<'_>,
) -> Result<Vec<DAffine3>, Diagnostic> {
    let path = format!("nodes[{index}].extensions.EXT_mesh_gpu_instancing.attributes");
    let read = |name: &str, wanted: Wanted| match instancing.attributes.get(name) {
        Some(&accessor) => accessors.read(accessor, wanted, &format!("{path}.{name}")).map(Some),
        None => Ok(None),
    };
    let translations = read("TRANSLATION", VECTORS)?;
    let rotations = read("ROTATION", ROTATIONS)?;
    let scales = read("SCALE", VECTORS)?;
    let counts = [(&translations, 3), (&rotations, 4), (&scales, 3)]
        .map(|(numbers, width)| numbers.as_ref().map(|numbers| numbers.len() / width));
    let Some(count) = counts.into_iter().flatten().max() else { return Ok(vec![DAffine3::IDENTITY]) };
    if counts.into_iter().flatten().any(|other| other != count) {
        let found = "the attributes have different numbers of instances";
        return Err(accessors.invalid(path, found).expected("one element an instance in each of them"));
    }
    let vector = |numbers: &Option<Vec<f64>>, at: usize, otherwise: DVec3| {
        numbers.as_ref().map_or(otherwise, |numbers| DVec3::from_slice(&numbers[3 * at..]))
    };
    let place = |at: usize| {
        let rotation = match &rotations {
            Some(numbers) => DQuat::from_slice(&numbers[4 * at..]),
            None => DQuat::IDENTITY,
        };
        if rotation.length() < 1e-6 {
            let found = format!("rotation {at} has no length");
            return Err(accessors.invalid(format!("{path}.ROTATION"), found).expected("unit quaternions"));
        }
        Ok(DAffine3::from_scale_rotation_translation(
            vector(&scales, at, DVec3::ONE),
            rotation.normalize(),
            vector(&translations, at, DVec3::ZERO),
        ))
    };
    (0..count).map(place).collect()
}
