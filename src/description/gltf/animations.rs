//! All channels of all animations, to be played together. Invariant: a channel's key times strictly
//! increase and it has a value for each of them, or three.

use super::accessor::{Accessors, Component, Wanted};
use super::json::{Animation, Document, Node};
use super::report::Report;
use super::{Channel, Interpolation, Values, named};
use crate::diagnostic::Diagnostic;
use glam::{DQuat, DVec3};

const TIMES: Wanted = Wanted { purpose: "key times", width: 1, components: &[Component::F32] };
const VECTORS: Wanted =
    Wanted { purpose: "translations and scales", width: 3, components: &[Component::F32] };
const WEIGHTS: Wanted = Wanted {
    purpose: "weights of morph targets",
    width: 1,
    components: &[Component::F32, Component::I8, Component::U8, Component::I16, Component::U16],
};
const ROTATIONS: Wanted = Wanted {
    purpose: "rotations",
    width: 4,
    components: &[Component::F32, Component::I8, Component::U8, Component::I16, Component::U16],
};

/// Every channel that moves a node.
pub(super) fn read(document: &Document, accessors: &Accessors<'_>, report: &mut Report) -> Vec<Channel> {
    let mut channels = Vec::new();
    for (index, animation) in document.animations.iter().enumerate() {
        for number in 0..animation.channels.len() {
            let place = format!("animations[{index}].channels[{number}]");
            let channel = read_channel(document, animation, number, place, accessors, report);
            channels.extend(report.keep(channel).flatten());
        }
    }
    channels
}

fn read_channel(
    document: &Document,
    animation: &Animation,
    number: usize,
    place: String,
    accessors: &Accessors<'_>,
    report: &mut Report,
) -> Result<Option<Channel>, Diagnostic> {
    let channel = &animation.channels[number];
    let target = &channel.target;
    if let Some(pointer) = &target.extensions.pointer {
        report
            .not_honoured("KHR_animation_pointer is not honoured, these values keep still", &pointer.pointer);
        return Ok(None);
    }
    // The specification says to pass over channels without a node.
    let Some(node) = target.node else {
        report.not_honoured("channels that target no node are passed over", &place);
        return Ok(None);
    };
    let Some(target_node) = document.nodes.get(node) else {
        return Err(accessors
            .invalid(format!("{place}.target.node"), format!("node {node} does not exist"))
            .expected(format!("a number below {}, the number of nodes in the file", document.nodes.len()))
            .remedy("export without GPU instances: together with animation Blender's exporter numbers nodes wrongly"));
    };
    let wanted = match target.path.as_str() {
        "translation" | "scale" => VECTORS,
        "rotation" => ROTATIONS,
        "weights" if targets_of(document, target_node) == 0 => {
            let name = named(&target_node.name, "node", node);
            report.not_honoured("weights of meshes without morph targets are passed over", &name);
            return Ok(None);
        }
        "weights" => WEIGHTS,
        other => {
            return Err(accessors
                .invalid(format!("{place}.target.path"), format!("`{other}` cannot be animated"))
                .expected("translation, rotation, scale or weights"));
        }
    };
    if target_node.matrix.is_some() && target.path != "weights" {
        return Err(accessors
            .invalid(format!("{place}.target.node"), format!("node {node} is animated and has a matrix"))
            .expected("translation, rotation and scale on nodes that are animated"));
    }
    let Some(sampler) = animation.samplers.get(channel.sampler) else {
        return Err(accessors
            .invalid(format!("{place}.sampler"), format!("sampler {} does not exist", channel.sampler)));
    };
    let interpolation = match sampler.interpolation.as_deref() {
        None | Some("LINEAR") => Interpolation::Linear,
        Some("STEP") => Interpolation::Step,
        Some("CUBICSPLINE") => Interpolation::Cubic,
        Some(other) => {
            return Err(accessors
                .invalid(place, format!("`{other}` is no interpolation"))
                .expected("STEP, LINEAR or CUBICSPLINE"));
        }
    };
    let times_s: Vec<f32> =
        accessors.read(sampler.input, TIMES, &place)?.into_iter().map(|time| time as f32).collect();
    if let Some(at) = times_s.windows(2).position(|pair| pair[0] >= pair[1]) {
        return Err(accessors
            .invalid(
                format!("accessors[{}]", sampler.input),
                format!("key time {} is not after the one before it", at + 1),
            )
            .expected("key times that strictly increase"));
    }
    let values = accessors.read(sampler.output, wanted, &place)?;
    let a_time = if target.path == "weights" { targets_of(document, target_node) } else { 1 };
    let expected = times_s.len() * a_time * if interpolation == Interpolation::Cubic { 3 } else { 1 };
    if values.len() / wanted.width != expected {
        return Err(accessors
            .invalid(
                format!("accessors[{}].count", sampler.output),
                format!("{} keys cannot have {} values", times_s.len(), values.len() / wanted.width),
            )
            .expected(format!("{expected} values")));
    }
    let vectors = || values.chunks_exact(3).map(DVec3::from_slice).collect();
    let values = match target.path.as_str() {
        "translation" => Values::Translation(vectors()),
        "scale" => Values::Scale(vectors()),
        "weights" => Values::Weights(values),
        _ => Values::Rotation(rotations(&values, interpolation).map_err(|key| {
            accessors
                .invalid(format!("accessors[{}]", sampler.output), format!("rotation {key} has no length"))
                .expected("unit quaternions")
        })?),
    };
    Ok(Some(Channel { place, node, times_s, interpolation, values }))
}

/// How many morph targets a node's mesh has.
fn targets_of(document: &Document, node: &Node) -> usize {
    let mesh = node.mesh.and_then(|mesh| document.meshes.get(mesh));
    mesh.and_then(|mesh| mesh.primitives.first()).map_or(0, |primitive| primitive.targets.len())
}

/// Quaternions at unit length, derivatives as they are; or the number of one that has no length.
fn rotations(values: &[f64], interpolation: Interpolation) -> Result<Vec<DQuat>, usize> {
    let convert = |(index, value): (usize, &[f64])| {
        let quaternion = DQuat::from_slice(value);
        let is_derivative = interpolation == Interpolation::Cubic && index % 3 != 1;
        if is_derivative {
            Ok(quaternion)
        } else if quaternion.length() < 1e-6 {
            Err(index)
        } else {
            Ok(quaternion.normalize())
        }
    };
    values.chunks_exact(4).enumerate().map(convert).collect()
}
