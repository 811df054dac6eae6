//! Our own format: RON files in, typed descriptions with their meshes and textures out.
//! Invariant: a file is read only if something in the picture refers to it, and then once.
//!
//! docs/scene-format.md is the author's view of these types; a field is added here, there and in
//! `scene::from_ron`.

mod animated;
mod built;
mod camera;
mod defaults;
mod fall;
mod fog;
mod given;
mod leaves;
mod light;
mod material;
mod meant;
mod misplaced;
mod mist;
mod named;
mod number;
mod parse;
mod range;
mod references;
mod replacement;
mod scene_file;
mod sequence_file;
mod shape;
mod sky;
pub(crate) mod suggest;
mod version;
mod walk;

use super::image::DecodedImage;
use super::obj::{self, ObjModel, ObjPictures};
use super::{Files, LoadError, files, vdb};
use crate::diagnostic::{Diagnostic, Place};
use parse::Document;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

pub use animated::{Animated, Extend, Handle, Key, Keyable, Keys, NoRate, ToNext};
pub use built::{BUILT, BuiltScene, load_built};
pub use camera::{Aperture, Camera};
pub use fall::{Emitter, Fall, FallGround, FallMotion, MOST_FALLING, Species, Wind};
pub use fog::Fog;
pub use leaves::{Leaves, MAX_LEAVES};
pub use light::{Julia, Light, Sun};
pub use material::{Material, NormalMap};
pub use mist::{Mist, MistShape};
pub use named::Named;
pub use number::{
    AirSpeed, AirVelocity, Anisotropy, ArealMass, Degrees, Direction, DiscAngle, FStop, FieldOfView, Finite,
    FocusDistance, GustScale, HalfAngle, JuliaPart, LeafLength, NonNegative, Number, Point, Positive,
    Quaternion, QuaternionRate, Range, RelativeError, Span, SpeedGain, Stops, Three, Triple, UnitInterval,
    Vector, Whole,
};
pub use range::{FIELDS_OF_VIEW_DEG, NEAREST_FOCUS_M, SMALLEST_F_STOP};
pub use replacement::Replacement;
pub use scene_file::{Object, SceneFile};
pub use sequence_file::{Bounces, FrameRate, Frames, MAX_FRAME, March, PixelFilter, SequenceFields};
pub use shape::Shape;
pub use sky::{Sky, SkyLight};
pub use version::Version;

/// A sequence file as read.
#[derive(Debug)]
pub struct SequenceFile {
    /// The file itself.
    pub path: PathBuf,
    /// The scene to render.
    pub scene_path: PathBuf,
    /// Fields of the file.
    pub fields: SequenceFields,
}

/// A scene file with the meshes and textures that its picture needs.
#[derive(Debug)]
pub struct LoadedScene {
    /// The file itself.
    pub path: PathBuf,
    /// Contents of the file.
    pub file: SceneFile,
    /// OBJ files by their path as the scene writes it.
    pub models: BTreeMap<PathBuf, ObjModel>,
    /// Images that the scene's materials show, by their path as the scene writes it.
    pub images: BTreeMap<PathBuf, DecodedImage>,
    /// Pictures that the materials of MTL files show.
    pub obj_pictures: ObjPictures,
    /// Images that suns show, by their path as the scene writes it.
    pub sun_images: BTreeMap<PathBuf, DecodedImage>,
    /// Images of directions by their path as the scene writes it.
    pub normal_maps: BTreeMap<PathBuf, DecodedImage>,
    /// Grids that fog takes its density from, by their file's path as the scene writes it.
    pub grids: BTreeMap<PathBuf, vdb::GridFiles>,
    /// The image that the sky shows.
    pub sky_image: Option<DecodedImage>,
    /// Whether nobody wrote it: a mesh was to be rendered by itself. Then it has neither camera nor light.
    pub is_mesh_alone: bool,
}

/// Kind of a RON file, with its contents.
#[derive(Debug)]
pub enum RonFile {
    /// `Scene(..)`.
    Scene(Box<LoadedScene>),
    /// `Sequence(..)`.
    Sequence(Box<SequenceFile>),
}

/// Reads a RON file of either kind; a scene with everything that it refers to.
///
/// # Errors
/// [`LoadError`] if a file cannot be read, or does not hold what it should.
pub fn load(path: &Path, files: &mut Files) -> Result<RonFile, LoadError> {
    match parse::parse(path, &files.read_text(path, meant::meant)?)? {
        Document::Scene(file) => {
            references::load(path, file, BTreeMap::new(), files).map(|scene| RonFile::Scene(Box::new(scene)))
        }
        Document::Sequence(fields) => {
            let scene_path = beside(path, &fields.scene);
            let sequence = SequenceFile { path: path.to_owned(), scene_path, fields };
            Ok(RonFile::Sequence(Box::new(sequence)))
        }
    }
}

/// Reads a RON scene with everything that it refers to.
///
/// # Errors
/// [`LoadError`] if a file cannot be read, or does not hold what it should.
pub fn load_scene(path: &Path, files: &mut Files) -> Result<LoadedScene, LoadError> {
    match parse::parse(path, &files.read_text(path, meant::meant)?)? {
        Document::Scene(file) => references::load(path, file, BTreeMap::new(), files),
        Document::Sequence(_) => {
            Err(Diagnostic::error(Place::File(path.to_owned()), "this is a sequence, not a scene")
                .expected("a file that starts with `Scene(`")
                .remedy("name a scene in the sequence's field `scene`")
                .into())
        }
    }
}

/// A scene of nothing but an OBJ file, which is at the origin as it is.
///
/// # Errors
/// [`LoadError`] if a file cannot be read, or does not hold what it should.
pub fn load_mesh_alone(path: &Path, files: &mut Files) -> Result<LoadedScene, LoadError> {
    let name = obj::name(path);
    let mesh_path = PathBuf::from(path.file_name().unwrap_or_default());
    let model = obj::load_alone(path, files)?;
    let mut file = SceneFile::of_mesh(&name, Shape::Obj(mesh_path.clone()));
    if model.triangles.is_empty() {
        (file.meshes, file.objects) = (Named::default(), Named::default());
    }
    let scene = references::load(path, file, BTreeMap::from([(mesh_path, model)]), files)?;
    Ok(LoadedScene { is_mesh_alone: true, ..scene })
}

/// `path`, which `file` writes relative to its own folder.
fn beside(file: &Path, path: &Path) -> PathBuf {
    files::beside(file.parent().unwrap_or(Path::new("")), path)
}
