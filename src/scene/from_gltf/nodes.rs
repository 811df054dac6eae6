//! Nodes, parents before children, with their motion. In go nodes and channels, out comes the hierarchy.
//! Invariant: a node without a channel stays where the file places it.

use super::Builder;
use super::clock::Clock;
use crate::description::gltf::{Interpolation, Property, Transform};
use crate::diagnostic::Loss;
use crate::scene::{Animate, Extend, Key, Motion, Node, NodeIndex, Rotation, Segment, Track};
use glam::{DAffine3, DQuat, DVec3};

impl Builder<'_> {
    pub(super) fn add_nodes(&mut self) {
        let mut waiting: Vec<(usize, Option<NodeIndex>)> =
            self.source.roots.iter().rev().map(|&root| (root, None)).collect();
        while let Some((index, parent)) = waiting.pop() {
            let node = &self.source.nodes[index];
            let number = self.scene.nodes.len();
            self.node_numbers[index] = Some(number);
            self.scene.nodes.push(Node {
                name: node.name.clone(),
                parent,
                motion: self.motion(index),
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

    fn motion(&self, index: usize) -> Motion {
        let (translation, rotation, scale) = match self.source.nodes[index].transform {
            Transform::Matrix(matrix) => return Motion::Still(matrix),
            Transform::Parts { translation, rotation, scale } => (translation, rotation, scale),
        };
        if !self.is_animated(&[Property::Translation, Property::Rotation, Property::Scale], index) {
            return Motion::Still(DAffine3::from_scale_rotation_translation(scale, rotation, translation));
        }
        let turn = self.keyed(Property::Rotation, index, rotation, DQuat::from_slice);
        Motion::Keyed {
            translation: self.keyed(Property::Translation, index, translation, DVec3::from_slice),
            rotation: Rotation::Quaternion(turn),
            scale: self.keyed(Property::Scale, index, scale, DVec3::from_slice),
        }
    }
}

/// Track of a channel; `None` only if its times do not increase, which the reader excludes.
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
