//! Export to glTF 2.0. In goes a [`Scene`], out comes a `.glb` file: meshes shared, the same nodes, motion as
//! keys. Properties that glTF lacks become custom properties, which `scene/from_gltf` reads. Invariant: read
//! back, the file gives the same pictures, or [`Exported::remarks`] lists the differences.

mod beside;
mod binary;
mod controls;
mod deformations;
mod key_times;
mod keys;
mod layers;
mod lights;
mod material_changes;
mod materials;
mod meshes;
mod nodes;
mod surroundings;

use crate::diagnostic::{Diagnostic, Diagnostics, Loss, Place};
use crate::scene::{RenderSettings, Scene};
use binary::Binary;
use serde_json::{Map, Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Parts of a `.glb` file, to be written in this order.
#[derive(Debug)]
pub struct Exported {
    /// Header and JSON.
    pub head: Vec<u8>,
    /// Meshes, keys and images.
    pub binary: Vec<u8>,
    /// Number of keyed values.
    pub channels: usize,
    /// External files that it refers to.
    pub files: BTreeSet<String>,
    /// Losses: what the file cannot carry.
    pub remarks: Diagnostics,
}

/// Writer of a file under construction.
struct Writer<'a> {
    scene: &'a Scene,
    folder: &'a Path,
    /// Moments at which motion without keys of its own is sampled, seconds, increasing, none negative.
    moments: keys::Moments,
    binary: Binary,
    nodes: Vec<Map<String, Value>>,
    children: Vec<Vec<usize>>,
    /// Index in `nodes` of each node of the scene.
    node_numbers: Vec<usize>,
    channels: Vec<Value>,
    samplers: Vec<Value>,
    lights: Vec<Value>,
    cameras: Vec<Value>,
    skins: Vec<Value>,
    skin_numbers: BTreeMap<deformations::JointKey, usize>,
    extensions: BTreeSet<&'static str>,
    files: BTreeSet<String>,
    remarks: Diagnostics,
}

/// The file's `generator`.
const GENERATOR: &str = concat!("sunfleck ", env!("CARGO_PKG_VERSION"));
/// Maximum size of the binary part, as glTF has 32-bit lengths.
const MOST_BYTES: usize = u32::MAX as usize;

/// Writes a scene as glTF for a folder, motion over the settings' frames.
///
/// # Errors
/// If the file would be too large for glTF.
pub fn glb(scene: &Scene, settings: &RenderSettings, folder: &Path) -> Result<Exported, Diagnostic> {
    let mut writer = Writer {
        scene,
        folder,
        moments: keys::Moments::new(settings),
        binary: Binary::default(),
        nodes: Vec::new(),
        children: Vec::new(),
        node_numbers: Vec::new(),
        channels: Vec::new(),
        samplers: Vec::new(),
        lights: Vec::new(),
        cameras: Vec::new(),
        skins: Vec::new(),
        skin_numbers: BTreeMap::new(),
        extensions: BTreeSet::new(),
        files: BTreeSet::new(),
        remarks: Diagnostics::default(),
    };
    writer.warn_of_negative_frames(settings);
    writer.add_nodes();
    let (meshes, mesh_numbers) = writer.meshes();
    writer.place_meshes(&mesh_numbers);
    let (materials, textures) = writer.materials()?;
    writer.add_lights()?;
    writer.add_cameras(settings);
    writer.add_fogs();
    let extras = writer.scene_extras(settings)?;
    writer.into_file(settings, extras, meshes, materials, textures)
}

impl Writer<'_> {
    fn lost(&mut self, loss: Loss, found: impl Into<String>) {
        self.remarks.push(Diagnostic::warning(loss, Place::Nowhere, found));
    }

    fn warn_of_negative_frames(&mut self, settings: &RenderSettings) {
        if *settings.frames.start() < 0 && !self.scene.is_still() {
            self.lost(
                Loss::ExportNegativeTimes,
                "glTF has no times before 0: motion before frame 0 is not carried",
            );
        }
    }

    fn into_file(
        self,
        settings: &RenderSettings,
        extras: Value,
        meshes: Vec<Value>,
        materials: Vec<Value>,
        textures: materials::Images,
    ) -> Result<Exported, Diagnostic> {
        let mut is_child = vec![false; self.nodes.len()];
        self.children.iter().flatten().for_each(|&child| is_child[child] = true);
        let roots: Vec<usize> = (0..self.nodes.len()).filter(|&node| !is_child[node]).collect();
        let with_children = |(mut node, children): (Map<String, Value>, Vec<usize>)| {
            if !children.is_empty() {
                node.insert(String::from("children"), json!(children));
            }
            Value::Object(node)
        };
        let nodes: Vec<Value> = self.nodes.into_iter().zip(self.children).map(with_children).collect();
        let Binary { bytes, views, accessors } = self.binary;

        let mut document = Map::new();
        // glTF forbids empty lists.
        let mut list = |name: &str, values: Vec<Value>| {
            if !values.is_empty() {
                document.insert(name.to_owned(), Value::Array(values));
            }
        };
        let buffer = (!bytes.is_empty()).then(|| json!({ "byteLength": bytes.len() }));
        let channels = self.channels.len();
        if channels > 0 {
            list(
                "animations",
                vec![json!({ "name": settings.name, "channels": self.channels, "samplers": self.samplers })],
            );
        }
        list("nodes", nodes);
        list("meshes", meshes);
        list("materials", materials);
        list("textures", textures.textures);
        list("images", textures.images);
        list("samplers", textures.samplers);
        list("cameras", self.cameras);
        list("skins", self.skins);
        list("accessors", accessors);
        list("bufferViews", views);
        list("buffers", buffer.into_iter().collect());
        list("extensionsUsed", self.extensions.iter().map(|&name| json!(name)).collect());
        list("scenes", vec![json!({ "name": settings.name, "nodes": roots, "extras": extras })]);
        document.insert(String::from("scene"), json!(0));
        document.insert(String::from("asset"), json!({ "version": "2.0", "generator": GENERATOR }));
        if !self.lights.is_empty() {
            let lights = json!({ "KHR_lights_punctual": { "lights": self.lights } });
            document.insert(String::from("extensions"), lights);
        }
        let json = Value::Object(document).to_string().into_bytes();
        let head = head(json, bytes.len())?;
        Ok(Exported { head, binary: bytes, channels, files: self.files, remarks: self.remarks })
    }
}

/// Container up to the bytes of the binary part (specification, 4.4).
fn head(mut json: Vec<u8>, binary_bytes: usize) -> Result<Vec<u8>, Diagnostic> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let with_binary = if binary_bytes > 0 { 8 + binary_bytes } else { 0 };
    let length = 12 + 8 + json.len() + with_binary;
    if length > MOST_BYTES {
        return Err(Diagnostic::error(Place::Nowhere, format!("the file would have {length} bytes"))
            .expected("at most 4294967295, which is what glTF can count")
            .remedy("export fewer frames at a time with --frames"));
    }
    let word = |number: usize| (number as u32).to_le_bytes();
    let mut head = Vec::with_capacity(length - binary_bytes);
    head.extend(b"glTF");
    head.extend(word(2));
    head.extend(word(length));
    head.extend(word(json.len()));
    head.extend(b"JSON");
    head.append(&mut json);
    if binary_bytes > 0 {
        head.extend(word(binary_bytes));
        head.extend(b"BIN\0");
    }
    Ok(head)
}
