//! Custom properties of a Blender scene for features that glTF lacks. In goes JSON, out come typed
//! properties. Invariant: a property named `sunfleck...` is honoured, reported or refused, never ignored in
//! silence.

use super::Builder;
use crate::color::Rgb;
use crate::description::gltf::GltfScene;
use crate::description::gltf::report::Report;
use crate::diagnostic::{Diagnostic, Loss};
use crate::scene::{Property, RayVisibility};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::collections::BTreeMap;

/// Unknown fields of a property.
pub(super) type Unknown = BTreeMap<String, Value>;

/// `sunfleck`: render settings.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Sunfleck {
    pub(super) version: Option<f64>,
    pub(super) fps: Option<f64>,
    pub(super) fps_base: Option<f64>,
    pub(super) frame_start: Option<f64>,
    pub(super) frame_end: Option<f64>,
    pub(super) frame_at_zero: Option<f64>,
    pub(super) resolution: Option<[f64; 2]>,
    pub(super) camera: Option<String>,
    pub(super) light_units: Option<String>,
    pub(super) samples: Option<f64>,
    pub(super) tolerance: Option<f64>,
    /// Filter, with its name on the command line.
    pub(super) filter: Option<String>,
    /// Exposure of pictures for viewing, in stops.
    pub(super) exposure: Option<f64>,
    /// Look, with its name on the command line.
    pub(super) look: Option<String>,
    pub(super) seed: Option<f64>,
    pub(super) mirror_depth: Option<f64>,
    /// Number, or `all`.
    pub(super) bounces: Option<Value>,
    /// Passes, with their names on the command line.
    pub(super) passes: Option<Vec<String>>,
    pub(super) shutter: Option<f64>,
    /// Offset from the frame to the opening of the shutter, in frames.
    pub(super) shutter_offset: Option<f64>,
    pub(super) unit_scale: Option<f64>,
    #[serde(flatten)]
    unknown: Unknown,
}

/// `sunfleck_fog` of a scene or `sunfleck_fog_volume` of a node.
#[derive(Debug, Deserialize)]
pub(super) struct Fog {
    pub(super) shape: Option<String>,
    pub(super) density: Channels,
    #[serde(default = "white")]
    pub(super) albedo: Channels,
    #[serde(default)]
    pub(super) anisotropy: f64,
    /// 1/m.
    pub(super) height_falloff: Option<f64>,
    /// Metres; its reciprocal.
    pub(super) scale_height: Option<f64>,
    pub(super) base_height: Option<f64>,
    /// Opposite corners of a box in glTF's space, for the scene's fog alone.
    pub(super) bounds: Option<[[f64; 3]; 2]>,
    /// OpenVDB file beside the glTF file, in place of the five fields above.
    pub(super) vdb: Option<String>,
    /// Name of its density grid.
    pub(super) grid: Option<String>,
    /// Name of its grid of colours that multiply `albedo`.
    pub(super) albedo_grid: Option<String>,
    /// Name of its emission grid.
    pub(super) emission_grid: Option<String>,
    /// Emission where that grid is 1, W m^-3 sr^-1.
    pub(super) emission: Option<Channels>,
    /// Temperature where that grid is 1, kelvin, for blackbody emission.
    pub(super) emission_kelvin: Option<f64>,
    /// Whether blackbody emission is that of Blender's Principled Volume.
    #[serde(default)]
    pub(super) emission_principled: bool,
    /// Drifting mist in the box of a node.
    pub(super) mist: Option<Mist>,
    #[serde(flatten)]
    pub(super) unknown: Unknown,
}

/// `mist` of a node's fog, with the names and defaults of a scene file; lengths are metres along the box's
/// axes.
#[derive(Debug, Deserialize)]
pub(super) struct Mist {
    pub(super) size: f64,
    pub(super) octaves: Option<u32>,
    pub(super) cover: Option<f64>,
    pub(super) wind: Option<[f64; 3]>,
    pub(super) evolution_turns: Option<f64>,
    pub(super) shape: Option<String>,
    pub(super) edge: Option<f64>,
    pub(super) seed: Option<u32>,
    #[serde(flatten)]
    pub(super) unknown: Unknown,
}

/// `sunfleck_leaf` of a material: diffuse transmission.
#[derive(Debug, Deserialize)]
pub(super) struct Leaf {
    /// Share that is transmitted; the rest is reflected.
    pub(super) translucency: f64,
    /// Colour of transmitted light; by default the surface's.
    pub(super) transmit_color: Option<Channels>,
    #[serde(flatten)]
    pub(super) unknown: Unknown,
}

/// `sunfleck_object` of a node: ray visibility of its mesh.
#[derive(Debug, Deserialize)]
#[serde(default)]
pub(super) struct ObjectRays {
    visible_to_camera: bool,
    casts_shadow: bool,
    holdout: bool,
    #[serde(flatten)]
    unknown: Unknown,
}

impl Default for ObjectRays {
    fn default() -> Self {
        let RayVisibility { visible_to_camera, casts_shadow, holdout } = RayVisibility::USUAL;
        Self { visible_to_camera, casts_shadow, holdout, unknown: Unknown::new() }
    }
}

/// One number for all colour channels, or three.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(untagged, expecting = "neither a number nor three, for red, green and blue")]
pub(super) enum Channels {
    Same(f64),
    Each([f64; 3]),
}

impl From<Channels> for Rgb {
    fn from(channels: Channels) -> Self {
        match channels {
            Channels::Same(value) => Self::splat(value),
            Channels::Each(values) => Self::from(values),
        }
    }
}

fn white() -> Channels {
    Channels::Same(1.0)
}

/// Property `key` of the `extras` at `path`; a malformed one is reported.
pub(super) fn read<T: DeserializeOwned>(
    extras: &Value,
    key: &str,
    path: &str,
    report: &mut Report,
) -> Option<T> {
    let value = extras.get(key)?;
    let path = format!("{path}.extras.{key}");
    let read = serde_path_to_error::deserialize(value).map_err(|error| {
        let at = match error.path().to_string() {
            whole if whole == "." => path,
            part => format!("{path}.{part}"),
        };
        let found = error.into_inner().to_string();
        // Names of Rust structs mean nothing to authors.
        let (found, expected) = match found.split_once(", expected struct") {
            Some((found, _)) => (found, "fields in curly brackets, `{\"field\": value, ..}`"),
            None => (found.as_str(), "a custom property as sunfleck defines it"),
        };
        Diagnostic::error(report.at(at), found)
            .expected(expected)
            .remedy("correct this custom property and export the file again")
    });
    report.keep(read)
}

/// Reports unknown fields of a property; `name` is the field's full name.
pub(super) fn tell_unknown(unknown: &Unknown, report: &mut Report, name: impl Fn(&str) -> String) {
    unknown.keys().for_each(|field| report.not_honoured(Loss::UnknownField, &name(field)));
}

/// Properties in the scene's extras.
pub(super) fn scene_extras(source: &GltfScene, report: &mut Report) -> (Sunfleck, Option<Fog>) {
    let path = format!("scenes[{}]", source.scene);
    let sunfleck: Sunfleck = read(&source.extras, "sunfleck", &path, report).unwrap_or_default();
    tell_unknown(&sunfleck.unknown, report, |field| format!("sunfleck.{field}"));
    if sunfleck.version.is_some_and(|version| version != 1.0) {
        report.error(format!("{path}.extras.sunfleck.version"), "this version is not known", "version 1");
    }
    if sunfleck.unit_scale.is_some_and(|scale| scale != 1.0) {
        report.not_honoured(Loss::UnitScale, "sunfleck.unit_scale");
    }
    let fog = read(&source.extras, "sunfleck_fog", &path, report);
    report_unknown(&source.extras, &["sunfleck", "sunfleck_fog", "sunfleck_env"], "the scene", report);
    (sunfleck, fog)
}

/// Reports unknown properties with this program's prefix.
fn report_unknown(extras: &Value, known: &[&str], owner: &str, report: &mut Report) {
    let names = extras.as_object().into_iter().flat_map(|map| map.keys());
    for name in names.filter(|name| name.starts_with("sunfleck") && !known.contains(&name.as_str())) {
        report.not_honoured(Loss::UnknownProperty, &format!("{name}` of `{owner}"));
    }
}

impl Builder<'_> {
    /// Ray visibility of the mesh of a node, by the file's index.
    pub(super) fn ray_visibility(&mut self, node: usize) -> RayVisibility {
        let extras = &self.source.nodes[node].extras;
        let read: Option<ObjectRays> =
            read(extras, "sunfleck_object", &format!("nodes[{node}]"), &mut self.report);
        let ObjectRays { visible_to_camera, casts_shadow, holdout, unknown } = read.unwrap_or_default();
        tell_unknown(&unknown, &mut self.report, |field| format!("sunfleck_object.{field}"));
        RayVisibility { visible_to_camera, casts_shadow, holdout }
    }

    /// Reports properties of all owners but the scene that are not honoured there.
    pub(super) fn report_other_extras(&mut self) {
        for (kind, name, extras) in self.owners() {
            report_unknown(extras, known(kind), &format!("{kind} {name}"), &mut self.report);
        }
    }

    pub(super) fn keep_properties(&mut self) {
        let owners = self.owners().into_iter();
        let owners = owners.map(|(kind, name, extras)| (format!("{kind} `{name}`"), extras));
        for (owner, extras) in [(String::from("the scene"), &self.source.extras)].into_iter().chain(owners) {
            let ours =
                extras.as_object().into_iter().flatten().filter(|(name, _)| name.starts_with("sunfleck"));
            self.scene.properties.extend(ours.map(|(name, value)| Property {
                owner: owner.clone(),
                name: name.clone(),
                value: shortened(value),
            }));
        }
    }
}

impl<'a> Builder<'a> {
    /// Kinds, names and extras of the scene's nodes, and of all that nodes may refer to.
    fn owners(&self) -> Vec<(&'static str, &'a str, &'a Value)> {
        let source = self.source;
        let nodes = source.nodes.iter().zip(&self.node_numbers).filter(|(_, number)| number.is_some());
        let nodes = nodes.map(|(node, _)| ("object", &*node.name, &node.extras));
        let cameras = source.cameras.iter().map(|camera| ("camera", &*camera.name, &camera.extras));
        let materials =
            source.materials.iter().map(|material| ("material", &*material.name, &material.extras));
        // Blender writes properties of a mesh or a lamp there, which is another place than its object's.
        let meshes = source.meshes.iter().map(|mesh| ("mesh", &*mesh.name, &mesh.extras));
        let lights = source.lights.iter().map(|light| ("light", &*light.name, &light.extras));
        nodes.chain(cameras).chain(materials).chain(meshes).chain(lights).collect()
    }
}

/// Properties that a kind of owner has.
fn known(kind: &str) -> &'static [&'static str] {
    match kind {
        "object" => &["sunfleck_fog_volume", "sunfleck_light", "sunfleck_object", "sunfleck_ctl"],
        "camera" => &["sunfleck_camera"],
        "material" => &["sunfleck_leaf", "sunfleck_material"],
        _ => &[],
    }
}

/// Value without the bytes of images.
fn shortened(value: &Value) -> Value {
    match value {
        Value::String(text) => match text.split_once(";base64,") {
            Some((kind, data)) if text.starts_with("data:") => {
                Value::String(format!("{kind}, {} bytes", data.len() / 4 * 3))
            }
            _ => value.clone(),
        },
        Value::Object(fields) => {
            fields.iter().map(|(name, value)| (name.clone(), shortened(value))).collect()
        }
        _ => value.clone(),
    }
}
