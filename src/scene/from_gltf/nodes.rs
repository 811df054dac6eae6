//! Nodes, parents before children, each with its motion. Invariant: a node moves if a channel says
//! so, else it stands where the file puts it.

use super::Builder;
use super::clock::Clock;
use crate::description::gltf::{self, Channel, Interpolation, Transform, Values};
use crate::diagnostic::Loss;
use crate::scene::{Animate, Extend, Key, Motion, Node, NodeIndex, Rotation, Segment, Track};
use glam::{DAffine3, DQuat, DVec3};

#[derive(Clone, Copy, Default)]
struct Channels<'a> {
    translation: Option<&'a Channel>,
    rotation: Option<&'a Channel>,
    scale: Option<&'a Channel>,
}

impl<'a> Builder<'a> {
    pub(super) fn add_nodes(&mut self) {
        let channels = self.channels_by_node();
        let mut waiting: Vec<(usize, Option<NodeIndex>)> =
            self.source.roots.iter().rev().map(|&root| (root, None)).collect();
        while let Some((index, parent)) = waiting.pop() {
            let node = &self.source.nodes[index];
            let number = self.scene.nodes.len();
            self.node_numbers[index] = Some(number);
            self.scene.nodes.push(Node {
                name: node.name.clone(),
                parent,
                motion: self.motion(node, channels[index]),
                visible: self.visible(index),
            });
            waiting.extend(node.children.iter().rev().map(|&child| (child, Some(number))));
        }
        let left_out =
            self.source.nodes.iter().zip(&self.node_numbers).filter(|(_, number)| number.is_none());
        for (node, _) in left_out {
            self.report.not_honoured(Loss::NodesOutsideScene, &node.name);
        }
    }

    fn channels_by_node(&mut self) -> Vec<Channels<'a>> {
        let mut by_node = vec![Channels::default(); self.source.nodes.len()];
        for channel in &self.source.channels {
            let channels = &mut by_node[channel.node];
            let property = match channel.values {
                Values::Translation(_) => &mut channels.translation,
                Values::Rotation(_) => &mut channels.rotation,
                Values::Scale(_) => &mut channels.scale,
                Values::Weights(_) => &mut self.weight_channels[channel.node],
            };
            if property.replace(channel).is_some() {
                self.report.not_honoured(Loss::AnimationsConflict, &self.source.nodes[channel.node].name);
            }
        }
        by_node
    }

    fn motion(&self, node: &gltf::Node, channels: Channels<'_>) -> Motion {
        let (translation, rotation, scale) = match node.transform {
            Transform::Matrix(matrix) => return Motion::Still(matrix),
            Transform::Parts { translation, rotation, scale } => (translation, rotation, scale),
        };
        let Channels { translation: None, rotation: None, scale: None } = channels else {
            let keyed = |channel: Option<&Channel>, still: DVec3| match channel.map(|c| (c, &c.values)) {
                Some((channel, Values::Translation(values) | Values::Scale(values))) => {
                    track(&channel.times_s, channel.interpolation, values, &self.clock)
                        .unwrap_or(Track::from(still))
                }
                _ => Track::from(still),
            };
            let turning = match channels.rotation.map(|c| (c, &c.values)) {
                Some((channel, Values::Rotation(values))) => {
                    track(&channel.times_s, channel.interpolation, values, &self.clock)
                }
                _ => None,
            };
            return Motion::Keyed {
                translation: keyed(channels.translation, translation),
                rotation: Rotation::Quaternion(turning.unwrap_or(Track::<DQuat>::from(rotation))),
                scale: keyed(channels.scale, scale),
            };
        };
        Motion::Still(DAffine3::from_scale_rotation_translation(scale, rotation, translation))
    }
}

/// A channel as a track; `None` only if its times do not increase, which reading the file excludes.
pub(super) fn track<T: Animate>(
    times_s: &[f32],
    interpolation: Interpolation,
    values: &[T],
    clock: &Clock,
) -> Option<Track<T>> {
    let keys = times_s.iter().enumerate().map(|(index, &time_s)| {
        let (value, to_next) = match interpolation {
            Interpolation::Step => (values[index], Segment::Step),
            Interpolation::Linear => (values[index], Segment::Linear),
            Interpolation::Cubic => {
                let arrive = values.get(3 * index + 3).copied().unwrap_or(T::ZERO);
                (values[3 * index + 1], Segment::Hermite { leave: values[3 * index + 2], arrive })
            }
        };
        Key { time_s: clock.seconds(time_s), value, to_next }
    });
    Track::new(keys.collect(), Extend::Hold)
}
