//! Channels of all animations. In goes JSON, out come keys. Invariant: a channel's key times strictly
//! increase, and each has one value, or three for cubic splines.

use super::accessor::{Accessors, Component, Wanted};
use super::json::{self, Animation, Document};
use super::pointers::{self, Property, Target};
use super::report::Report;
use super::{Channel, Interpolation, named};
use crate::diagnostic::{Diagnostic, Loss};
use glam::DQuat;

const TIMES: Wanted = Wanted { purpose: "key times", width: 1, components: &[Component::F32] };

pub(super) fn names(document: &Document) -> Vec<String> {
    let name = |(index, animation): (usize, &Animation)| named(&animation.name, "animation", index);
    document.animations.iter().enumerate().map(name).collect()
}

/// Reads the channels of all animations whose properties are supported.
pub(super) fn read(document: &Document, accessors: &Accessors<'_>, report: &mut Report) -> Vec<Channel> {
    let mut channels = Vec::new();
    for (index, animation) in document.animations.iter().enumerate() {
        let reader = ChannelReader { document, animation, accessors };
        for (number, source) in animation.channels.iter().enumerate() {
            let place = format!("animations[{index}].channels[{number}]");
            let channel = reader.read_channel(source, place, report);
            let channel = if is_misnumbered(document, source) {
                // Drops all of them: other node indices are then shifted as well, and wrong nodes would move.
                report.keep(channel)
            } else {
                report.spare(Loss::AnimationDamaged, channel)
            };
            channels.extend(channel.flatten().map(|channel| Channel { animation: index, ..channel }));
        }
    }
    channels
}

/// Whether a channel's node does not exist beside GPU instances. Blender's exporter then shifts all node
/// indices.
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
    /// Reads a channel; `None` if its property is not supported.
    fn read_channel(
        &self,
        channel: &json::Channel,
        place: String,
        report: &mut Report,
    ) -> Result<Option<Channel>, Diagnostic> {
        let Self { document, accessors, .. } = *self;
        let target = &channel.target;
        let Some(pointer) = &target.extensions.pointer else {
            // The specification says to ignore channels without a node.
            let Some(node) = target.node else {
                report.not_honoured(Loss::AnimationWithoutTarget, &place);
                return Ok(None);
            };
            let property = self.property_of(node, &target.path, &place)?;
            return self.keyed(channel.sampler, (property, node), place, report);
        };
        let pointer = pointer.pointer.as_str();
        if pointer.contains("/spot.") {
            report.not_honoured(Loss::SpotAnglePointer, pointer);
        }
        match pointers::resolve(document, pointer) {
            Target::Property(property, index) => {
                self.keyed(channel.sampler, (property, index), place, report)
            }
            Target::Unused => {
                report.not_honoured(Loss::AnimationPointer, pointer);
                Ok(None)
            }
            Target::Missing => Err(accessors
                .invalid(
                    format!("{place}.target.extensions.KHR_animation_pointer.pointer"),
                    format!("`{pointer}` points at nothing in the file"),
                )
                .expected("a pointer to a light, camera, material or node that the file has")),
        }
    }

    /// Property of a node that a path names.
    fn property_of(&self, node: usize, path: &str, place: &str) -> Result<Property, Diagnostic> {
        let count = self.document.nodes.len();
        if node >= count {
            return Err(self
                .accessors
                .invalid(format!("{place}.target.node"), format!("node {node} does not exist"))
                .expected(format!("a number below {count}, the number of nodes in the file"))
                .remedy("export without GPU instances: together with animation Blender's exporter numbers nodes wrongly"));
        }
        Property::of_path(path).ok_or_else(|| {
            self.accessors
                .invalid(format!("{place}.target.path"), format!("`{path}` cannot be animated"))
                .expected("translation, rotation, scale or weights")
        })
    }

    fn keyed(
        &self,
        sampler: usize,
        (property, index): (Property, usize),
        place: String,
        report: &mut Report,
    ) -> Result<Option<Channel>, Diagnostic> {
        let Self { document, animation, accessors } = *self;
        let mut a_time = 1;
        if property == Property::Weights {
            let node = &document.nodes[index];
            let mesh = node.mesh.and_then(|mesh| document.meshes.get(mesh));
            let primitive = mesh.and_then(|mesh| mesh.primitives.first());
            a_time = primitive.map_or(0, |primitive| primitive.targets.len());
            if a_time == 0 {
                let name = named(&node.name, "node", index);
                report.not_honoured(Loss::MorphWeightsWithoutTargets, &name);
                return Ok(None);
            }
        } else if property.is_of_transform() && document.nodes[index].matrix.is_some() {
            return Err(accessors
                .invalid(format!("{place}.target.node"), format!("node {index} is animated and has a matrix"))
                .expected("translation, rotation and scale on nodes that are animated"));
        }
        let Sampled { times_s, interpolation, mut values } =
            self.sampled(sampler, property.wanted(), a_time, &place)?;
        if property == Property::Rotation {
            normalize(&mut values, interpolation).map_err(|key| {
                let output = animation.samplers.get(sampler).map_or(0, |sampler| sampler.output);
                accessors
                    .invalid(format!("accessors[{output}]"), format!("rotation {key} has no length"))
                    .expected("unit quaternions")
            })?;
        }
        let channel = Channel { place, animation: 0, property, index, times_s, interpolation, values };
        match channel.out_of_range() {
            None => Ok(Some(channel)),
            Some(value) => Err(accessors
                .invalid(channel.place, format!("an animated value is {value}, or passes it on its way"))
                .expected(format!("values in {:?} at and between keys", property.range()))),
        }
    }

    /// Reads sampler number `sampler`, with `a_time` elements at a time.
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

/// Normalizes quaternions, except derivatives; fails with the index of one of length 0.
fn normalize(values: &mut [f64], interpolation: Interpolation) -> Result<(), usize> {
    for (index, value) in values.chunks_exact_mut(4).enumerate() {
        if interpolation == Interpolation::Cubic && index % 3 != 1 {
            continue;
        }
        let quaternion = DQuat::from_slice(value);
        if quaternion.length() < 1e-6 {
            return Err(index);
        }
        value.copy_from_slice(&quaternion.normalize().to_array());
    }
    Ok(())
}
