//! A glTF file under construction. A square of 2 m hangs 3 m before a camera at the origin, lit from there.

use base64::prelude::{BASE64_STANDARD, Engine};
use glam::DVec3;
use serde_json::{Value, json};
use sunfleck::color::Rgb;
use sunfleck::description;
use sunfleck::math::{Ray, Sampler};
use sunfleck::scene::{self, RenderSettings, Scene};
use sunfleck::snapshot::{MeshTrees, Shutter, Snapshot};
use sunfleck::transport::{Sample, Scratch, Transport, VolumeMethod, radiance};

pub(crate) struct File {
    pub(crate) json: Value,
    bytes: Vec<u8>,
}

pub(crate) const SQUARE: usize = 0;
pub(crate) const CAMERA: usize = 1;
const EXACT: Transport<'static> =
    Transport { volume: VolumeMethod::Segments, mirror_depth: 2, indirect: None, features: true };

impl File {
    pub(crate) fn new() -> Self {
        let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
        let mut file = Self { json: json!({}), bytes: Vec::new() };
        let positions = file.floats("VEC3", corners.as_flattened());
        let normals = file.floats("VEC3", [[0.0, 0.0, 1.0]; 4].as_flattened());
        let uvs = file.floats("TEXCOORD", &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
        let indices =
            file.numbers("SCALAR", 5123, [0_u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()), 6);
        let attributes = json!({ "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs });
        let defaults = json!({
            "asset": { "version": "2.0" }, "scene": 0,
            "scenes": [{ "nodes": [0, 1, 2], "extras": { "sunfleck": {
                "version": 1, "fps": 24, "light_units": "spec", "resolution": [32, 32] } } }],
            "nodes": [
                { "name": "square", "mesh": 0, "translation": [0, 0, -3] },
                { "name": "camera", "camera": 0 },
                { "name": "sun", "extensions": { "KHR_lights_punctual": { "light": 0 } } },
            ],
            "cameras": [{ "type": "perspective", "perspective": { "yfov": 1.5, "znear": 0.1, "aspectRatio": 1 } }],
            "meshes": [{ "primitives": [{ "attributes": attributes, "indices": indices, "material": 0 }] }],
            "materials": [{ "name": "made", "doubleSided": true, "extensions": { "KHR_materials_specular": { "specularFactor": 0 } },
                "pbrMetallicRoughness": { "metallicFactor": 0 } }],
            "extensionsUsed": ["KHR_lights_punctual", "KHR_animation_pointer", "KHR_materials_specular",
                "KHR_materials_emissive_strength", "KHR_node_visibility"],
            "extensions": { "KHR_lights_punctual": { "lights": [
                { "type": "directional", "intensity": 683.0 * 4.0, "color": [1, 0.5, 0.25] }] } },
            "animations": [{ "channels": [], "samplers": [] }],
        });
        for (name, value) in defaults.as_object().unwrap() {
            file.json[name] = value.clone();
        }
        file
    }

    /// An accessor of floats.
    pub(crate) fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let kind = if kind == "TEXCOORD" { "VEC2" } else { kind };
        let width = match kind {
            "SCALAR" => 1,
            "MAT4" => 16,
            vector => usize::from(vector.as_bytes()[3] - b'0'),
        };
        self.numbers(kind, 5126, values.iter().flat_map(|value| value.to_le_bytes()), values.len() / width)
    }

    /// An accessor of whatever component type.
    pub(crate) fn numbers(
        &mut self,
        kind: &str,
        component: u32,
        bytes: impl IntoIterator<Item = u8>,
        count: usize,
    ) -> usize {
        let start = self.bytes.len();
        self.bytes.extend(bytes);
        let length = self.bytes.len() - start;
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let is_short = matches!(component, 5121 | 5123) && kind != "SCALAR";
        let views = list(&mut self.json, "bufferViews");
        views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": length }));
        let view = views.len() - 1;
        let accessors = list(&mut self.json, "accessors");
        accessors
            .push(json!({ "bufferView": view, "componentType": component, "count": count, "type": kind }));
        if is_short {
            accessors.last_mut().unwrap()["normalized"] = json!(false);
        }
        accessors.len() - 1
    }

    /// The square's only primitive.
    pub(crate) fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    pub(crate) fn material(&mut self) -> &mut Value {
        &mut self.json["materials"][0]
    }

    /// A channel; `target` is a pointer, or a node's number and a path with a space between.
    pub(crate) fn animate(&mut self, target: &str, kind: &str, way: &str, keys: &[f32], values: &[f32]) {
        let (input, output) = (self.floats("SCALAR", keys), self.floats(kind, values));
        let animation = &mut self.json["animations"][0];
        list(animation, "samplers").push(json!({ "input": input, "output": output, "interpolation": way }));
        let sampler = list(animation, "samplers").len() - 1;
        let target = match target.split_once(' ') {
            Some((node, path)) => json!({ "node": node.parse::<usize>().unwrap(), "path": path }),
            None => {
                json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": { "pointer": target } } })
            }
        };
        list(animation, "channels").push(json!({ "sampler": sampler, "target": target }));
    }

    /// An image of one row as a texture.
    pub(crate) fn texture(&mut self, texels: &[[u8; 4]]) -> usize {
        let pixels = texels.as_flattened().to_vec();
        let image = image::RgbaImage::from_raw(texels.len() as u32, 1, pixels).unwrap();
        let mut png = std::io::Cursor::new(Vec::new());
        image.write_to(&mut png, image::ImageFormat::Png).unwrap();
        let uri = format!("data:image/png;base64,{}", BASE64_STANDARD.encode(png.into_inner()));
        list(&mut self.json, "images").push(json!({ "uri": uri }));
        let textures = list(&mut self.json, "textures");
        textures.push(json!({ "source": textures.len() }));
        textures.len() - 1
    }

    /// The file as text.
    pub(crate) fn text(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if json["animations"][0]["channels"].as_array().unwrap().is_empty() {
            json.as_object_mut().unwrap().remove("animations");
        }
        let uri = format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(&self.bytes));
        json["buffers"] = json!([{ "byteLength": self.bytes.len(), "uri": uri }]);
        serde_json::to_vec(&json).unwrap()
    }

    pub(crate) fn load(&self) -> (Scene, RenderSettings) {
        load(&self.text(), "made.gltf")
    }

    pub(crate) fn scene(&self) -> Scene {
        self.load().0
    }
}

/// The scene of a file with these bytes.
pub(crate) fn load(bytes: &[u8], name: &str) -> (Scene, RenderSettings) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    let description = description::load(&path).unwrap_or_else(|error| panic!("{error}"));
    scene::resolve(description, None).unwrap_or_else(|problems| panic!("{problems}"))
}

fn list<'a>(value: &'a mut Value, name: &str) -> &'a mut Vec<Value> {
    if value.get(name).is_none() {
        value[name] = json!([]);
    }
    value[name].as_array_mut().unwrap()
}

/// What a ray from the first camera through a place of its picture finds at a time.
pub(crate) fn sample(scene: &Scene, time_s: f64, film: (f64, f64)) -> Sample {
    let shutter = Shutter { open_s: time_s, close_s: time_s };
    let snapshot = Snapshot::new(scene, &MeshTrees::new(scene), 0, 1.0, shutter);
    let ray: Ray = snapshot.view.ray(film.0, film.1);
    radiance(&snapshot, &EXACT, &ray, &mut Sampler::new(0, 0, 0, 0), &mut Scratch::default())
}

pub(crate) fn seen(scene: &Scene, time_s: f64, film: (f64, f64)) -> Rgb {
    sample(scene, time_s, film).radiance
}

/// Positions in the world of the only mesh at a time.
pub(crate) fn vertices(scene: &Scene, time_s: f64) -> Vec<DVec3> {
    let placements = scene.placements(time_s);
    let (positions, world) = scene.vertices(&scene.instances[0], &placements, time_s);
    positions.iter().map(|position| world.transform_point3(position.as_dvec3())).collect()
}

pub(crate) fn assert_near(found: Rgb, expected: Rgb, what: impl std::fmt::Debug) {
    let error = (found - expected).abs().max_element();
    assert!(error <= 1e-6 * expected.abs().max_element().max(1e-3), "{what:?}: {found} {expected}");
}
