//! Reader of glTF 2.0. In goes a `.glb`, or a `.gltf` with its buffers and images, out come plain typed data.
//! Invariant: in a [`GltfScene`] every index is valid, nodes form trees and every number is finite.
//! [`GltfScene::remarks`] lists what the file requests in vain.
//!
//! The `gltf` crate splits the container, or `container.rs` where the crate refuses chunks that readers have
//! to ignore. The crate's JSON and its readers are not used: they refuse Blender's animation pointers and
//! panic on damaged files. So everything is validated here, before any value is read.

mod accessor;
mod animations;
mod attributes;
mod buffers;
mod container;
mod draco;
mod extensions;
mod grids;
mod instancing;
mod json;
mod json_buffers;
mod json_materials;
mod materials;
mod meshes;
mod meshopt;
mod morphs;
mod nodes;
mod optics;
mod pictures;
mod pointers;
pub(crate) mod report;
mod skins;
mod specular_glossiness;
mod surfaces;
mod texture_maps;
mod textures;

use self::textures::Textures;
use super::image::DecodedImage;
use super::{Files, LoadError, vdb};
use crate::diagnostic::{Diagnostic, Diagnostics, Loss, Place};
use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3, Vec4};
pub use optics::{Camera, Lens, Light, LightKind};
pub use pointers::Property;
use report::Report;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
pub use surfaces::{AlphaMode, Clearcoat, Material, Sheen, Texture, TextureMap, Wrap};

/// glTF file, validated, in its own units and terms.
#[derive(Clone, Debug, Default)]
pub struct GltfScene {
    /// The file.
    pub path: PathBuf,
    /// Program that wrote the file, as it names itself.
    pub generator: String,
    /// Index of the scene that is shown.
    pub scene: usize,
    /// Extras of that scene.
    pub extras: Value,
    /// Nodes without parents.
    pub roots: Vec<usize>,
    /// All nodes of the file.
    pub nodes: Vec<Node>,
    /// All meshes.
    pub meshes: Vec<Mesh>,
    /// All materials.
    pub materials: Vec<Material>,
    /// Textures that the meshes need.
    pub textures: Vec<Texture>,
    /// All skins.
    pub skins: Vec<Skin>,
    /// All cameras.
    pub cameras: Vec<Camera>,
    /// All lights (KHR_lights_punctual).
    pub lights: Vec<Light>,
    /// Image of the sky in the scene's extras.
    pub sky_image: Option<DecodedImage>,
    /// Image that the camera sees in place of the sky.
    pub backdrop_image: Option<DecodedImage>,
    /// Images in the extras of suns, by their names there.
    pub sun_images: BTreeMap<String, DecodedImage>,
    /// OpenVDB files in the extras of fog, by their names there.
    pub grids: BTreeMap<String, vdb::GridFiles>,
    /// Names of all animations: the author's, else `animation N`.
    pub animations: Vec<String>,
    /// Channels of all animations, in the file's order.
    pub channels: Vec<Channel>,
    /// Requests of the file that are not honoured, or only approximated.
    pub remarks: Diagnostics,
}

/// Node of the hierarchy with its contents.
#[derive(Clone, Debug)]
pub struct Node {
    /// The author's name, else `node N`.
    pub name: String,
    /// Nodes below it.
    pub children: Vec<usize>,
    /// Transform to the parent's space, unless an animation replaces it.
    pub transform: Transform,
    /// Index into [`GltfScene::meshes`].
    pub mesh: Option<usize>,
    /// Index into [`GltfScene::skins`]; the skin's joints then move the mesh in place of the node.
    pub skin: Option<usize>,
    /// Weights of its mesh's morph targets, in place of the mesh's own.
    pub weights: Option<Vec<f64>>,
    /// Transforms in the node's space of the instances of its mesh, which replace the mesh itself
    /// (EXT_mesh_gpu_instancing).
    pub instances: Option<Vec<DAffine3>>,
    /// Linear colours of the instances, which multiply those of their materials; one each, or none.
    pub instance_colors: Vec<DVec3>,
    /// Whether the node and its descendants are visible (KHR_node_visibility).
    pub visible: bool,
    /// Index into [`GltfScene::cameras`].
    pub camera: Option<usize>,
    /// Index into [`GltfScene::lights`].
    pub light: Option<usize>,
    /// Custom properties.
    pub extras: Value,
}

/// Transform of a node in its parent's space.
#[derive(Clone, Copy, Debug)]
pub enum Transform {
    /// Given as a matrix; never animated.
    Matrix(DAffine3),
    /// Given as parts, with the identity for missing ones.
    Parts {
        /// Metres.
        translation: DVec3,
        /// Unit quaternion.
        rotation: DQuat,
        /// Factors.
        scale: DVec3,
    },
}

/// Triangles in one or more materials.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// The author's name, else `mesh N`.
    pub name: String,
    /// Primitives; none if the mesh has no triangles.
    pub primitives: Vec<Primitive>,
    /// Weights of the morph targets, one each.
    pub weights: Vec<f64>,
    /// Custom properties.
    pub extras: Value,
}

/// Skin.
#[derive(Clone, Debug)]
pub struct Skin {
    /// The author's name, else `skin N`.
    pub name: String,
    /// Indices into [`GltfScene::nodes`], at least one.
    pub joints: Vec<usize>,
    /// Transforms from the mesh at rest to each joint's space.
    pub inverse_bind: Vec<DAffine3>,
}

/// Displacements that a weight adds to a primitive.
#[derive(Clone, Debug, Default)]
pub struct MorphTarget {
    /// One a position, or none at all.
    pub positions: Vec<Vec3>,
    /// One a position, or none at all.
    pub normals: Vec<Vec3>,
    /// One a position, or none at all.
    pub tangents: Vec<Vec3>,
}

/// Joints of each vertex, with weights.
#[derive(Clone, Debug, Default)]
pub struct Influences {
    /// Joints a vertex.
    pub per_vertex: usize,
    /// Indices into [`Skin::joints`], `per_vertex` for each position.
    pub joints: Vec<u16>,
    /// Weights, at least 0; those of a vertex add up to 1.
    pub weights: Vec<f32>,
}

/// Triangles in one material.
#[derive(Clone, Debug)]
pub struct Primitive {
    /// Metres.
    pub positions: Vec<Vec3>,
    /// Unit length, one a position, or none at all.
    pub normals: Vec<Vec3>,
    /// Texture coordinates of the base colour texture, or else of the first texture, after
    /// KHR_texture_transform; one a position, or none at all.
    pub uvs: Vec<Vec2>,
    /// Other texture coordinates: layers 1, 2 and so on.
    pub more_uvs: Vec<Vec<Vec2>>,
    /// Linear, in `0..=1`, one a position, or none at all; they multiply the base colour.
    pub colors: Vec<Vec3>,
    /// Alphas in `0..=1`, one a position, or none at all; they multiply the base colour's alpha.
    pub alphas: Vec<f32>,
    /// Tangents for its normal map, one a position; none without a normal map. Unit length, and in `w` the
    /// side on which the bitangent `w * normal x tangent` lies, 1 or -1.
    pub tangents: Vec<Vec4>,
    /// Indices of positions.
    pub triangles: Vec<[u32; 3]>,
    /// Index into [`GltfScene::materials`].
    pub material: Option<usize>,
    /// Morph targets.
    pub targets: Vec<MorphTarget>,
    /// Joints of its vertices, if the mesh has a skin.
    pub influences: Option<Influences>,
}

/// Animated property of a node, or of an object that a pointer names (KHR_animation_pointer).
#[derive(Clone, Debug)]
pub struct Channel {
    /// Place in the file: `animations[0].channels[3]`.
    pub place: String,
    /// Index into [`GltfScene::animations`].
    pub animation: usize,
    /// Property that it animates.
    pub property: Property,
    /// Index of its owner among nodes, lights, cameras or materials.
    pub index: usize,
    /// Strictly increasing, at least one, seconds.
    pub times_s: Vec<f32>,
    /// Interpolation from key to key.
    pub interpolation: Interpolation,
    /// Values, one a time, or for cubic splines three: derivative before, value, derivative after.
    pub values: Vec<f64>,
}

/// Interpolation from key to key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Constant until the next key.
    Step,
    /// Linear, or along the shortest arc.
    Linear,
    /// Cubic Hermite spline.
    Cubic,
}

impl GltfScene {
    /// Indices of the animations with a name, else of the one with that number, counted from 0.
    pub fn animations_called(&self, wanted: &str) -> Vec<usize> {
        let named =
            |name: &str| (0..self.animations.len()).filter(|&index| self.animations[index] == name).collect();
        let called: Vec<usize> = named(wanted);
        let number = wanted.parse().ok().filter(|number| *number < self.animations.len());
        if called.is_empty() { number.into_iter().collect() } else { called }
    }

    /// Names of all animations, for a message.
    pub fn animation_names(&self) -> String {
        let names: Vec<String> = self.animations.iter().map(|name| format!("`{name}`")).collect();
        match names.len() {
            0 => String::from("no animation, as the file has none"),
            _ => format!("`all`, or one of {}", names.join(", ")),
        }
    }
}

/// Loads a `.glb` or `.gltf` file with everything it refers to.
pub fn load(path: &Path, files: &mut Files) -> Result<GltfScene, LoadError> {
    let bytes = files.read(path, None)?;
    parse(&bytes, path, files)
}

/// Parses the bytes of a file; other files that it refers to are read through `files`.
pub fn parse(bytes: &[u8], path: &Path, files: &mut Files) -> Result<GltfScene, LoadError> {
    let mut report = Report::new(path);
    let (mut document, binary) = container::open(bytes, path, &mut report)?;
    container::check_version(&document, path)?;
    extensions::check(&document, &mut report);
    if report.has_errors() {
        // With an unknown extension, a valid file may look damaged.
        return Err(LoadError::Invalid(report.into_diagnostics()));
    }
    specular_glossiness::convert(&mut document, &mut report);
    let buffers = buffers::load(&document, binary, path, files, &mut report);
    let (unpacked, damaged) = draco::unpack(&document, &buffers, path);
    let accessors = accessor::Accessors::new(&document, &buffers, unpacked);

    let mut scene = GltfScene {
        path: path.to_owned(),
        generator: document.asset.generator.clone(),
        nodes: nodes::nodes(&document, &mut report),
        meshes: meshes::read(&document, &accessors, damaged, &mut report),
        skins: skins::read(&document, &accessors, &mut report),
        animations: animations::names(&document),
        ..GltfScene::default()
    };
    scene.cameras = nodes::cameras(&document, &mut scene.nodes, &mut report);
    scene.lights = nodes::lights(&document, &mut scene.nodes, &mut report);
    scene.channels = animations::read(&document, &accessors, &mut report);
    instancing::read(&document, &mut scene.nodes, &accessors, &mut report);
    let targets: Vec<usize> = scene.meshes.iter().map(|mesh| mesh.weights.len()).collect();
    morphs::check_nodes(&document, &mut scene.nodes, &targets, &mut report);
    skins::check_nodes(&mut scene, &mut report);
    nodes::choose_scene(&document, &mut scene, &mut report);
    pictures::read(&mut scene, files, &mut report)?;
    grids::read(&mut scene, files, &mut report)?;
    let shown = pictures::shown_nodes(&scene).into_iter().filter_map(|node| scene.nodes[node].mesh);
    let shown: BTreeSet<usize> = shown.collect();
    (scene.materials, scene.textures) =
        materials::read(&document, &shown, Textures::new(&document, &buffers, path, files), &mut report);
    if scene.meshes.iter().all(|mesh| mesh.primitives.is_empty())
        && !shown.is_empty()
        && let Some(damage) = report.first_damage(Loss::PrimitiveDamaged).cloned()
    {
        // A file whose only meshes are missing would give an empty picture.
        if let Some(missing) = buffers.missing {
            return Err(missing);
        }
        report.push(report.first_damage(Loss::BufferUnreadable).cloned().unwrap_or(damage));
    }
    if report.has_errors() {
        return Err(LoadError::Invalid(report.into_diagnostics()));
    }
    scene.remarks = report.into_diagnostics();
    Ok(scene)
}

fn field(file: &Path, path: impl Into<String>) -> Place {
    Place::Field { file: file.to_owned(), path: path.into() }
}

/// Error at a place in a file, with the expectation and remedy for damage; callers may replace them.
fn invalid(file: &Path, path: impl Into<String>, found: impl Into<String>) -> Diagnostic {
    Diagnostic::error(field(file, path), found)
        .expected("what the glTF 2.0 specification describes")
        .remedy("export the file again; the Khronos glTF validator says more")
}

/// The author's name, else the kind and the index.
fn named(name: &Option<String>, what: &str, index: usize) -> String {
    name.clone().filter(|name| !name.is_empty()).unwrap_or_else(|| format!("{what} {index}"))
}
