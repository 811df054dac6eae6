//! A glTF 2.0 file in (`.glb`, or `.gltf` with its buffers and images), plain typed data out. Invariant: in a
//! [`GltfScene`] every index points somewhere, nodes form trees and every number is finite. What the file
//! asks for that is not here stands in [`GltfScene::remarks`].
//!
//! The container is taken apart by the `gltf` crate, or here where that refuses chunks that readers have to
//! pass over. Its JSON types and accessors are not used: they refuse files that Blender writes (animation
//! pointers) and panic on damaged ones. So everything is checked here, before any value is read.

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

/// A glTF file, checked, in its own units and terms.
#[derive(Clone, Debug, Default)]
pub struct GltfScene {
    /// The file.
    pub path: PathBuf,
    /// The program that wrote it, as it names itself.
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
    /// All skeletons.
    pub skins: Vec<Skin>,
    /// All cameras.
    pub cameras: Vec<Camera>,
    /// All lights (KHR_lights_punctual).
    pub lights: Vec<Light>,
    /// Image of the sky in the scene's extras, if it has one.
    pub sky_image: Option<DecodedImage>,
    /// Image of what the camera sees in place of the sky.
    pub backdrop_image: Option<DecodedImage>,
    /// Images that the extras of suns name, by those names.
    pub sun_images: BTreeMap<String, DecodedImage>,
    /// OpenVDB files that the extras of fog name, by those names.
    pub grids: BTreeMap<String, vdb::GridFiles>,
    /// Names of all animations: the author's, else `animation N`.
    pub animations: Vec<String>,
    /// All channels of all animations, in the file's order.
    pub channels: Vec<Channel>,
    /// Requests of the file that are not met, or only nearly.
    pub remarks: Diagnostics,
}

/// A place in the hierarchy and what stands there.
#[derive(Clone, Debug)]
pub struct Node {
    /// The author's name, else `node N`.
    pub name: String,
    /// Nodes below it.
    pub children: Vec<usize>,
    /// Parent from node, where no animation says otherwise.
    pub transform: Transform,
    /// Index into [`GltfScene::meshes`].
    pub mesh: Option<usize>,
    /// Index into [`GltfScene::skins`]: what its mesh follows instead of the node.
    pub skin: Option<usize>,
    /// Weights of its mesh's morph targets, instead of the mesh's own.
    pub weights: Option<Vec<f64>>,
    /// Transforms in the node's space at which its mesh is drawn instead (EXT_mesh_gpu_instancing).
    pub instances: Option<Vec<DAffine3>>,
    /// Linear colours of these, which multiply those of their materials; none, or one for each.
    pub instance_colors: Vec<DVec3>,
    /// Whether it and what is below it is shown (KHR_node_visibility).
    pub visible: bool,
    /// Index into [`GltfScene::cameras`].
    pub camera: Option<usize>,
    /// Index into [`GltfScene::lights`].
    pub light: Option<usize>,
    /// Whatever the author attached.
    pub extras: Value,
}

/// A node's own transform.
#[derive(Clone, Copy, Debug)]
pub enum Transform {
    /// Given as a matrix; never animated.
    Matrix(DAffine3),
    /// Given in parts; what is not given is the identity.
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
    /// Parts; none if nothing in the mesh is a triangle.
    pub primitives: Vec<Primitive>,
    /// Weights of the morph targets, one each.
    pub weights: Vec<f64>,
}

/// A skeleton.
#[derive(Clone, Debug)]
pub struct Skin {
    /// The author's name, else `skin N`.
    pub name: String,
    /// Indices into [`GltfScene::nodes`], at least one.
    pub joints: Vec<usize>,
    /// Transforms from the mesh at rest to each joint's space.
    pub inverse_bind: Vec<DAffine3>,
}

/// Differences that a weight mixes into a primitive.
#[derive(Clone, Debug, Default)]
pub struct MorphTarget {
    /// One a position, or none at all.
    pub positions: Vec<Vec3>,
    /// One a position, or none at all.
    pub normals: Vec<Vec3>,
    /// One a position, or none at all.
    pub tangents: Vec<Vec3>,
}

/// The joints that move each vertex.
#[derive(Clone, Debug, Default)]
pub struct Influences {
    /// Joints a vertex.
    pub per_vertex: usize,
    /// Indices into [`Skin::joints`], `per_vertex` for each position.
    pub joints: Vec<u16>,
    /// Their shares, at least 0; those of a vertex add up to 1.
    pub weights: Vec<f32>,
}

/// Triangles in one material.
#[derive(Clone, Debug)]
pub struct Primitive {
    /// Metres.
    pub positions: Vec<Vec3>,
    /// Unit length, one a position, or none at all.
    pub normals: Vec<Vec3>,
    /// Texture coordinates of the base colour texture or else of the first there is, its
    /// KHR_texture_transform applied; one a position, or none at all.
    pub uvs: Vec<Vec2>,
    /// Texture coordinates of textures with others: layers 1, 2 and so on.
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
    /// Shapes that may be mixed in.
    pub targets: Vec<MorphTarget>,
    /// Skin and morph targets that move its vertices, if any do.
    pub influences: Option<Influences>,
}

/// An animated value: of a node, or of whatever a pointer names (KHR_animation_pointer).
#[derive(Clone, Debug)]
pub struct Channel {
    /// Place in the file: `animations[0].channels[3]`.
    pub place: String,
    /// Index into [`GltfScene::animations`].
    pub animation: usize,
    /// Property that it animates.
    pub property: Property,
    /// Whose: an index into nodes, lights, cameras or materials.
    pub index: usize,
    /// Strictly increasing, at least one, seconds.
    pub times_s: Vec<f32>,
    /// Interpolation from key to key.
    pub interpolation: Interpolation,
    /// Numbers of a value a time, or of three (derivative before, value, derivative after) if cubic.
    pub values: Vec<f64>,
}

/// Interpolation from key to key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Stays until the next key.
    Step,
    /// Straight, or along the shortest arc.
    Linear,
    /// Hermite spline.
    Cubic,
}

impl GltfScene {
    fn shown_meshes(&self) -> BTreeSet<usize> {
        pictures::shown_nodes(self).into_iter().filter_map(|node| self.nodes[node].mesh).collect()
    }

    /// The numbers of the animations with a name, else of the one with that number, counted from 0.
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
///
/// # Errors
/// [`LoadError::Io`] if a file cannot be read, [`LoadError::Invalid`] with everything wrong that was found.
pub fn load(path: &Path, files: &mut Files) -> Result<GltfScene, LoadError> {
    let bytes = files.read(path, None)?;
    parse(&bytes, path, files)
}

/// Parses a file whose bytes are at hand; other files that it refers to are read through `files`.
///
/// # Errors
/// As [`load`].
pub fn parse(bytes: &[u8], path: &Path, files: &mut Files) -> Result<GltfScene, LoadError> {
    let mut report = Report::new(path);
    let (mut document, binary) = container::open(bytes, path, &mut report)?;
    container::check_version(&document, path)?;
    extensions::check(&document, &mut report);
    if report.has_errors() {
        // What an unknown extension changes cannot be told from damage.
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
    let shown = scene.shown_meshes();
    (scene.materials, scene.textures) =
        materials::read(&document, &shown, Textures::new(&document, &buffers, path, files), &mut report);
    if scene.meshes.iter().all(|mesh| mesh.primitives.is_empty())
        && !shown.is_empty()
        && let Some(damage) = report.first_damage(Loss::PrimitiveDamaged).cloned()
    {
        // Without its only meshes a file would be a picture of nothing.
        if let Some(missing) = buffers.missing() {
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

/// Error at a place in a file. Expectation and remedy are those for damage; the caller may put better
/// ones.
fn invalid(file: &Path, path: impl Into<String>, found: impl Into<String>) -> Diagnostic {
    Diagnostic::error(field(file, path), found)
        .expected("what the glTF 2.0 specification describes")
        .remedy("export the file again; the Khronos glTF validator says more")
}

/// The author's name, else what it is and which.
fn named(name: &Option<String>, what: &str, index: usize) -> String {
    name.clone().filter(|name| !name.is_empty()).unwrap_or_else(|| format!("{what} {index}"))
}
