//! All channels of all animations, to be played together. Invariant: a channel's key times strictly
//! increase and it has a value for each of them, or three.

use super::accessor::{Accessors, Component, Wanted};
use super::attributes::SIGNED_OR_NOT;
use super::json::{self, Animation, Document, Node};
use super::pointers::{self, Property, Target};
use super::report::Report;
use super::{Channel, Interpolation, PropertyChannel, Values, named};
use crate::diagnostic::{Diagnostic, Loss};
use glam::{DQuat, DVec3};

const TIMES: Wanted = Wanted { purpose: "key times", width: 1, components: &[Component::F32] };
const VECTORS: Wanted =
    Wanted { purpose: "translations and scales", width: 3, components: &[Component::F32] };
const WEIGHTS: Wanted = Wanted { purpose: "weights of morph targets", width: 1, components: SIGNED_OR_NOT };
const ROTATIONS: Wanted = Wanted { purpose: "rotations", width: 4, components: SIGNED_OR_NOT };

/// Meaning of a channel.
enum Read {
    Moves(Channel),
    Changes(PropertyChannel),
    Nothing,
}

pub(super) fn names(document: &Document) -> Vec<String> {
    let name = |(index, animation): (usize, &Animation)| named(&animation.name, "animation", index);
    document.animations.iter().enumerate().map(name).collect()
}

/// Every channel that moves a node, and every one that changes something else.
pub(super) fn read(
    document: &Document,
    accessors: &Accessors<'_>,
    report: &mut Report,
) -> (Vec<Channel>, Vec<PropertyChannel>) {
    let (mut channels, mut properties) = (Vec::new(), Vec::new());
    for (index, animation) in document.animations.iter().enumerate() {
        let reader = ChannelReader { document, animation, accessors };
        for number in 0..animation.channels.len() {
            let place = format!("animations[{index}].channels[{number}]");
            let channel = reader.read_channel(number, place, report);
            let channel = if is_misnumbered(document, &animation.channels[number]) {
                // The other numbers are wrong as well: something would move that should not.
                report.keep(channel)
            } else {
                report.spare(Loss::AnimationDamaged, channel)
            };
            match channel {
                Some(Read::Moves(channel)) => channels.push(Channel { animation: index, ..channel }),
                Some(Read::Changes(channel)) => {
                    properties.push(PropertyChannel { animation: index, ..channel });
                }
                Some(Read::Nothing) | None => {}
            }
        }
    }
    (channels, properties)
}

/// Whether a channel shows that all of them target wrong nodes, as Blender's exporter makes them
/// beside GPU instances.
fn is_misnumbered(document: &Document, channel: &json::Channel) -> bool {
    let has_instances = document.nodes.iter().any(|node| node.extensions.instancing.is_some());
    has_instances && channel.target.node.is_some_and(|node| node >= document.nodes.len())
}

struct ChannelReader<'a> {
    document: &'a Document,
    animation: &'a Animation,
    accessors: &'a Accessors<'a>,
}

impl ChannelReader<'_> {
    fn read_channel(&self, number: usize, place: String, report: &mut Report) -> Result<Read, Diagnostic> {
        let Self { document, animation, accessors } = *self;
        let channel = &animation.channels[number];
        let target = &channel.target;
        if let Some(pointer) = &target.extensions.pointer {
            let pointer = pointer.pointer.as_str();
            if pointer.contains("/spot.") {
                report.not_honoured(Loss::SpotAnglePointer, pointer);
            }
            return match pointers::resolve(document, pointer) {
                Target::Node(node, path) => self.node_channel(channel.sampler, (node, path), place, report),
                Target::Property(property, index) => {
                    self.property_channel(channel.sampler, (property, index), place)
                }
                Target::Unused => {
                    report.not_honoured(Loss::AnimationPointer, pointer);
                    Ok(Read::Nothing)
                }
                Target::Missing => Err(accessors
                    .invalid(
                        format!("{place}.target.extensions.KHR_animation_pointer.pointer"),
                        format!("`{pointer}` points at nothing in the file"),
                    )
                    .expected("a pointer to a light, camera, material or node that the file has")),
            };
        }
        // The specification says to pass over channels without a node.
        let Some(node) = target.node else {
            report.not_honoured(Loss::AnimationWithoutTarget, &place);
            return Ok(Read::Nothing);
        };
        self.node_channel(channel.sampler, (node, &target.path), place, report)
    }

    fn property_channel(
        &self,
        sampler: usize,
        (property, index): (Property, usize),
        place: String,
    ) -> Result<Read, Diagnostic> {
        let wanted = property.wanted();
        let Sampled { times_s, interpolation, values } = self.sampled(sampler, wanted, 1, &place)?;
        let channel =
            PropertyChannel { place, animation: 0, property, index, times_s, interpolation, values };
        match channel.out_of_range() {
            None => Ok(Read::Changes(channel)),
            Some(value) => Err(self
                .accessors
                .invalid(channel.place, format!("an animated value is {value}, or passes it on its way"))
                .expected(format!("values in {:?} at and between keys", property.range()))),
        }
    }

    fn node_channel(
        &self,
        sampler: usize,
        (node, path): (usize, &str),
        place: String,
        report: &mut Report,
    ) -> Result<Read, Diagnostic> {
        let Self { document, animation, accessors } = *self;
        let Some(target_node) = document.nodes.get(node) else {
            return Err(accessors
                .invalid(format!("{place}.target.node"), format!("node {node} does not exist"))
                .expected(format!("a number below {}, the number of nodes in the file", document.nodes.len()))
                .remedy("export without GPU instances: together with animation Blender's exporter numbers nodes wrongly"));
        };
        let wanted = match path {
            "translation" | "scale" => VECTORS,
            "rotation" => ROTATIONS,
            "weights" if targets_of(document, target_node) == 0 => {
                let name = named(&target_node.name, "node", node);
                report.not_honoured(Loss::MorphWeightsWithoutTargets, &name);
                return Ok(Read::Nothing);
            }
            "weights" => WEIGHTS,
            other => {
                return Err(accessors
                    .invalid(format!("{place}.target.path"), format!("`{other}` cannot be animated"))
                    .expected("translation, rotation, scale or weights"));
            }
        };
        if target_node.matrix.is_some() && path != "weights" {
            return Err(accessors
                .invalid(format!("{place}.target.node"), format!("node {node} is animated and has a matrix"))
                .expected("translation, rotation and scale on nodes that are animated"));
        }
        let a_time = if path == "weights" { targets_of(document, target_node) } else { 1 };
        let Sampled { times_s, interpolation, values } = self.sampled(sampler, wanted, a_time, &place)?;
        let vectors = || values.chunks_exact(3).map(DVec3::from_slice).collect();
        let values = match path {
            "translation" => Values::Translation(vectors()),
            "scale" => Values::Scale(vectors()),
            "weights" => Values::Weights(values),
            _ => Values::Rotation(rotations(&values, interpolation).map_err(|key| {
                let output = animation.samplers.get(sampler).map_or(0, |sampler| sampler.output);
                accessors
                    .invalid(format!("accessors[{output}]"), format!("rotation {key} has no length"))
                    .expected("unit quaternions")
            })?),
        };
        Ok(Read::Moves(Channel { place, animation: 0, node, times_s, interpolation, values }))
    }

    /// Sampler number `sampler`, with `a_time` elements at a time.
    fn sampled(
        &self,
        sampler: usize,
        wanted: Wanted,
        a_time: usize,
        place: &str,
    ) -> Result<Sampled, Diagnostic> {
        let Self { animation, accessors, .. } = *self;
        let Some(source) = animation.samplers.get(sampler) else {
            return Err(
                accessors.invalid(format!("{place}.sampler"), format!("sampler {sampler} does not exist"))
            );
        };
        let interpolation = match source.interpolation.as_deref() {
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
            accessors.read(source.input, TIMES, place)?.into_iter().map(|time| time as f32).collect();
        if let Some(at) = times_s.windows(2).position(|pair| pair[0] >= pair[1]) {
            return Err(accessors
                .invalid(
                    format!("accessors[{}]", source.input),
                    format!("key time {} is not after the one before it", at + 1),
                )
                .expected("key times that strictly increase"));
        }
        let values = accessors.read(source.output, wanted, place)?;
        let expected = times_s.len() * a_time * if interpolation == Interpolation::Cubic { 3 } else { 1 };
        if values.len() / wanted.width != expected {
            return Err(accessors
                .invalid(
                    format!("accessors[{}].count", source.output),
                    format!("{} keys cannot have {} values", times_s.len(), values.len() / wanted.width),
                )
                .expected(format!("{expected} values")));
        }
        Ok(Sampled { times_s, interpolation, values })
    }
}

struct Sampled {
    times_s: Vec<f32>,
    interpolation: Interpolation,
    values: Vec<f64>,
}

/// Number of morph targets of a node's mesh.
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
