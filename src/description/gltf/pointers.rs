//! Animated properties, by paths and pointers (KHR_animation_pointer), with their ranges. In go names, out
//! come properties. Invariant: a [`Channel`] refers to an existing object, and its values stay in range at
//! and between its keys.

use super::accessor::{Component, Wanted};
use super::attributes::SIGNED_OR_NOT;
use super::json::Document;
use super::{Channel, Interpolation};
use std::ops::RangeInclusive;

/// Property that may be animated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Property {
    /// Node: metres.
    Translation,
    /// Node: a quaternion; unit length except where it is a derivative.
    Rotation,
    /// Node: factors.
    Scale,
    /// Node: weights of its mesh's morph targets, one for each of them.
    Weights,
    /// Light: colour.
    LightColor,
    /// Light: intensity, in the file's units.
    LightIntensity,
    /// Spot: half angle of full intensity, radians.
    SpotInnerAngle,
    /// Spot: half angle beyond which there is no light, radians.
    SpotOuterAngle,
    /// Perspective camera: vertical field of view, radians.
    CameraFovY,
    /// Orthographic camera: half the picture's height, metres.
    CameraHalfHeight,
    /// Node: visibility, its descendants included.
    NodeVisible,
    /// Material: colour, with its alpha.
    BaseColor,
    /// Material: metallic factor.
    Metallic,
    /// Material: roughness factor.
    Roughness,
    /// Material: `emissiveFactor`.
    Emission,
    /// Material: factor of its emission.
    EmissionStrength,
    /// Material: scale of its normal map.
    NormalScale,
}

impl Property {
    /// Properties of a material.
    pub const OF_MATERIALS: [Self; 6] = [
        Self::BaseColor,
        Self::Metallic,
        Self::Roughness,
        Self::Emission,
        Self::EmissionStrength,
        Self::NormalScale,
    ];

    /// Property of a node that a channel's path names.
    pub(super) fn of_path(path: &str) -> Option<Self> {
        Some(match path {
            "translation" => Self::Translation,
            "rotation" => Self::Rotation,
            "scale" => Self::Scale,
            "weights" => Self::Weights,
            _ => return None,
        })
    }

    /// Whether it moves a node or deforms its mesh.
    pub fn is_of_transform(self) -> bool {
        matches!(self, Self::Translation | Self::Rotation | Self::Scale | Self::Weights)
    }
}

pub(super) enum Target {
    /// Property of the object with an index.
    Property(Property, usize),
    /// An existing property that is not supported.
    Unused,
    /// An object that does not exist.
    Missing,
}

pub(super) fn resolve(document: &Document, pointer: &str) -> Target {
    // Blender 5.0 writes a dot before the angles of spots.
    let pointer = pointer.replace("/spot.", "/spot/");
    let steps: Vec<&str> = pointer.split('/').skip(1).collect();
    let lights = &document.extensions.lights_punctual.lights;
    let (number, count, path) = match steps.as_slice() {
        ["extensions", "KHR_lights_punctual", "lights", number, path @ ..] => (number, lights.len(), path),
        ["cameras", number, path @ ..] => (number, document.cameras.len(), path),
        ["materials", number, path @ ..] => (number, document.materials.len(), path),
        ["nodes", number, path @ ..] => (number, document.nodes.len(), path),
        _ => return Target::Unused,
    };
    let Some(number) = number.parse::<usize>().ok().filter(|number| *number < count) else {
        return Target::Missing;
    };
    let property = match (steps[0], path) {
        ("extensions", ["color"]) => Property::LightColor,
        ("extensions", ["intensity"]) => Property::LightIntensity,
        ("extensions", ["spot", "innerConeAngle"]) => Property::SpotInnerAngle,
        ("extensions", ["spot", "outerConeAngle"]) => Property::SpotOuterAngle,
        ("cameras", ["perspective", "yfov"]) => Property::CameraFovY,
        ("cameras", ["orthographic", "ymag"]) => Property::CameraHalfHeight,
        ("nodes", ["extensions", "KHR_node_visibility", "visible"]) => Property::NodeVisible,
        ("materials", ["pbrMetallicRoughness", "baseColorFactor"]) => Property::BaseColor,
        ("materials", ["pbrMetallicRoughness", "metallicFactor"]) => Property::Metallic,
        ("materials", ["pbrMetallicRoughness", "roughnessFactor"]) => Property::Roughness,
        ("materials", ["emissiveFactor"]) => Property::Emission,
        ("materials", ["extensions", "KHR_materials_emissive_strength", "emissiveStrength"]) => {
            Property::EmissionStrength
        }
        ("materials", ["normalTexture", "scale"]) => Property::NormalScale,
        ("nodes", [path]) => match Property::of_path(path) {
            Some(property) => property,
            None => return Target::Unused,
        },
        _ => return Target::Unused,
    };
    Target::Property(property, number)
}

impl Property {
    pub(super) fn wanted(self) -> Wanted {
        let (purpose, width, components) = match self {
            Self::Translation | Self::Scale => ("translations and scales", 3, &[Component::F32][..]),
            Self::Rotation => ("rotations", 4, SIGNED_OR_NOT),
            Self::Weights => ("weights of morph targets", 1, SIGNED_OR_NOT),
            Self::BaseColor => ("animated values", 4, SIGNED_OR_NOT),
            Self::LightColor | Self::Emission => ("animated values", 3, SIGNED_OR_NOT),
            _ => ("animated values", 1, SIGNED_OR_NOT),
        };
        Wanted { purpose, width, components }
    }

    /// Allowed range of its values.
    pub(super) fn range(self) -> RangeInclusive<f64> {
        const LEAST: f64 = 1e-15;
        match self {
            Self::Translation | Self::Rotation | Self::Scale | Self::Weights => {
                f64::NEG_INFINITY..=f64::INFINITY
            }
            Self::LightColor | Self::LightIntensity | Self::EmissionStrength => 0.0..=1e30,
            Self::NodeVisible | Self::BaseColor | Self::Metallic | Self::Roughness | Self::Emission => {
                0.0..=1.0
            }
            Self::NormalScale => -1e15..=1e15,
            Self::SpotInnerAngle => 0.0..=std::f64::consts::FRAC_PI_2 + 1e-6,
            Self::SpotOuterAngle => LEAST..=std::f64::consts::FRAC_PI_2 + 1e-6,
            Self::CameraFovY => LEAST..=std::f64::consts::PI - LEAST,
            Self::CameraHalfHeight => LEAST..=1e15,
        }
    }
}

impl Channel {
    /// Numbers a value; for weights 1.
    pub fn width(&self) -> usize {
        self.property.wanted().width
    }

    /// First value out of range, at a key or as an inner Bezier control point. The curve lies in the hull of
    /// its control points.
    pub(super) fn out_of_range(&self) -> Option<f64> {
        let range = self.property.range();
        let width = self.property.wanted().width;
        let is_out = |value: &f64| !range.contains(value);
        if self.interpolation != Interpolation::Cubic {
            return self.values.iter().copied().find(is_out);
        }
        let value = |key: usize, part: usize, at: usize| self.values[(3 * key + part) * width + at];
        let places = || (0..self.times_s.len()).flat_map(|key| (0..width).map(move |at| (key, at)));
        let keys = places().map(|(key, at)| value(key, 1, at));
        let controls = places().filter(|(key, _)| key + 1 < self.times_s.len()).flat_map(|(key, at)| {
            let third_s = f64::from(self.times_s[key + 1] - self.times_s[key]) / 3.0;
            let leave = value(key, 1, at) + third_s * value(key, 2, at);
            let arrive = value(key + 1, 1, at) - third_s * value(key + 1, 0, at);
            [leave, arrive]
        });
        keys.chain(controls).find(is_out)
    }
}
