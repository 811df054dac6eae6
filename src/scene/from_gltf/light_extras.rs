//! Properties of lights in `sunfleck_light` that glTF lacks: sizes, and area lights. In go the custom
//! property and glTF's light, out comes the complete light. Invariant: sizes are finite and in range; any
//! other is an error at its own JSON path.

use super::Builder;
use super::extras::{self, Channels, Unknown};
use crate::color::Rgb;
use crate::description::LARGEST_NUMBER;
use crate::description::gltf;
use crate::diagnostic::Loss;
use crate::scene::{AreaShape, LampTraits, Light, LightKind, NodeIndex, SunDisc, Track};
use serde::Deserialize;
use std::f64::consts::PI;
use std::ops::RangeBounds;

/// Minimum spread of an area light, radians; the maximum is pi, in single precision.
pub(super) const NARROWEST_SPREAD: f64 = 0.01;
pub(super) const WIDEST_SPREAD: f64 = PI + 1e-6;

/// Julia set: its constant and the maximum number of iterations.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Fractal {
    pub(super) real: f64,
    pub(super) imaginary: f64,
    #[serde(default = "iterations")]
    pub(super) iterations: f64,
}

fn iterations() -> f64 {
    100.0
}

/// `sunfleck_light` of a node. Angles are in radians, as in Blender's Python.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct LightExtras {
    /// Full angle of a sun's disc.
    angle: Option<f64>,
    /// Radius of a point or spot, metres.
    radius: Option<f64>,
    /// `area` for an area light, at a node without a light.
    #[serde(rename = "type")]
    kind: Option<String>,
    shape: Option<String>,
    /// Size of an area light, metres before the node's scale.
    size: Option<Size>,
    /// Radiant power of an area light in W, as in Blender; others have their power in glTF's light.
    power_w: Option<f64>,
    color: Option<Channels>,
    /// Full angle of the beam of an area light.
    spread: Option<f64>,
    casts_shafts: Option<bool>,
    /// Whether the camera sees it; for a sun, mirrors too.
    visible_to_camera: bool,
    /// Whether smooth surfaces reflect it visibly.
    visible_in_mirrors: bool,
    /// Soft falloff of a point or spot.
    soft_falloff: bool,
    /// Whether a sphere also emits inward.
    shines_inward: bool,
    /// Picture on a sun's disc: a file beside the glTF file or a data URI, or a Julia set, and its limb
    /// darkening.
    pub(super) image: Option<String>,
    pub(super) fractal: Option<Fractal>,
    pub(super) limb_darkening: Option<f64>,
    /// Rotation of the picture, anticlockwise.
    pub(super) picture_rotation: Option<f64>,
    #[serde(flatten)]
    unknown: Unknown,
}

/// One number for both, or width and height.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(untagged, expecting = "neither a number nor two, width and height")]
enum Size {
    Square(f64),
    Each([f64; 2]),
}

impl Builder<'_> {
    /// Reads `sunfleck_light` of a node.
    pub(super) fn light_extras(&mut self, index: usize, node: &gltf::Node) -> Option<LightExtras> {
        let path = format!("nodes[{index}]");
        let mut extras: LightExtras = extras::read(&node.extras, "sunfleck_light", &path, &mut self.report)?;
        // A sun's power is in glTF's light; Blender's own number is informative.
        extras.unknown.remove("strength_w_m2");
        let name = |field: &str| format!("{path}.extras.sunfleck_light.{field}");
        extras::tell_unknown(&extras.unknown, &mut self.report, name);
        if extras.casts_shafts == Some(false) {
            self.report.not_honoured(Loss::LightWithoutShafts, &node.name);
        }
        Some(extras)
    }

    /// Sets the traits of a node's lamp.
    pub(super) fn set_traits(&mut self, node: NodeIndex, extras: &LightExtras) {
        let &LightExtras { soft_falloff, shines_inward, visible_to_camera, visible_in_mirrors, .. } = extras;
        let traits = LampTraits { soft_falloff, shines_inward, visible_to_camera, visible_in_mirrors };
        self.scene.set_lamp_traits(node, traits);
    }

    /// Adds the properties to glTF's light.
    pub(super) fn extend(&mut self, kind: LightKind, extras: &LightExtras, path: &str) -> LightKind {
        if extras.kind.as_deref() == Some("area") {
            let found = "the node is an area light and has another light as well";
            self.report.error(format!("{path}.type"), found, "one light a node");
        }
        let angle = extras.angle.filter(|angle| {
            self.is_in_range(path, "angle", *angle, 0.0..PI, "radians, at least 0 and less than pi")
        });
        let radius = extras.radius.filter(|radius| {
            self.is_in_range(path, "radius", *radius, 0.0..LARGEST_NUMBER, "metres, at least 0")
        });
        let is_sun = matches!(kind, LightKind::Sun);
        if if is_sun { radius.is_some() } else { angle.is_some() } {
            self.report.not_honoured(Loss::LightSize, path);
        }
        let picture = self.sun_picture(is_sun, extras, path);
        let picture_rotation = Track::from(extras.picture_rotation.unwrap_or(0.0));
        let visible_to_camera = extras.visible_to_camera;
        match (kind, angle.unwrap_or(0.0), radius) {
            // The size may be 0 at first and animated later.
            (LightKind::Sun, angle, _) if angle > 0.0 || picture.is_some() || visible_to_camera => {
                let angular_diameter = Track::from(angle);
                LightKind::SunDisc(SunDisc { angular_diameter, picture, picture_rotation, visible_to_camera })
            }
            (LightKind::Point, _, Some(radius)) if radius > 0.0 => {
                LightKind::Sphere { radius: Track::from(radius) }
            }
            (LightKind::Spot { outer_angle, blend, .. }, _, Some(radius)) => {
                LightKind::Spot { outer_angle, blend, radius: Track::from(radius) }
            }
            (kind, ..) => kind,
        }
    }

    /// Adds the area light of a node without a glTF light.
    pub(super) fn add_area_light(&mut self, name: &str, node: NodeIndex, extras: &LightExtras, path: &str) {
        if extras.kind.as_deref() != Some("area") {
            self.report.not_honoured(Loss::LightOfNoFile, name);
            return;
        }
        let shape = match extras.shape.as_deref().map(str::to_lowercase).as_deref() {
            None | Some("rectangle" | "square") => AreaShape::Rectangle,
            Some("disk" | "disc" | "ellipse") => AreaShape::Ellipse,
            Some(other) => {
                let found = format!("`{other}` is no shape of light");
                self.report.error(format!("{path}.shape"), found, "square, rectangle, disk or ellipse");
                return;
            }
        };
        let [width, height] = match extras.size {
            Some(Size::Square(size)) => [size; 2],
            Some(Size::Each(sizes)) => sizes,
            None => {
                let found = "the area light has no size";
                self.report.error(path, found, "`size`: width and height in metres");
                return;
            }
        };
        for size in [width, height] {
            self.is_in_range(path, "size", size, f64::MIN_POSITIVE..LARGEST_NUMBER, "metres, more than 0");
        }
        let color = extras.color.map_or(Rgb::ONE, Rgb::from);
        let Some(power_w) = extras.power_w else {
            self.report.error(path, "the area light has no power", "`power_w`: Blender's watts");
            return;
        };
        let power = color * power_w;
        if !power.is_finite() || power.min_element() < 0.0 {
            let found = format!("{power_w} W times {color} is no power");
            self.report.error(format!("{path}.power_w"), found, "finite numbers of at least 0");
        }
        let spread = extras.spread.unwrap_or(PI);
        self.is_in_range(path, "spread", spread, 0.0..=WIDEST_SPREAD, "radians, 0 to pi");
        if spread < NARROWEST_SPREAD {
            self.report.not_honoured(Loss::AreaLightSpread, name);
        }
        let [width, height, spread] = [width, height, spread.max(NARROWEST_SPREAD)].map(Track::from);
        let kind = LightKind::Area { shape, width, height, spread };
        self.scene.lights.push(Light { name: name.to_owned(), node, power: Track::from(power), kind });
    }

    pub(super) fn is_in_range(
        &mut self,
        path: &str,
        field: &str,
        value: f64,
        range: impl RangeBounds<f64>,
        expected: &str,
    ) -> bool {
        let is_in_range = range.contains(&value);
        if !is_in_range {
            self.report.error(format!("{path}.{field}"), format!("the {field} is {value}"), expected);
        }
        is_in_range
    }
}
