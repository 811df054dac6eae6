//! Sunfleck's scene format. In go RON files, out come typed descriptions with their meshes and textures.
//! Invariant: a file is read only if the picture uses it, and then once.
//!
//! docs/scene-format.md describes these types for authors. A new field goes here, there and into
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

/// Sequence file.
#[derive(Debug)]
pub struct SequenceFile {
    /// The file itself.
    pub path: PathBuf,
    /// The scene to render.
    pub scene_path: PathBuf,
    /// Fields of the file.
    pub fields: SequenceFields,
}

/// Scene file with the meshes and textures that its picture needs.
#[derive(Debug)]
pub struct LoadedScene {
    /// The file itself.
    pub path: PathBuf,
    /// Contents of the file.
    pub file: SceneFile,
    /// OBJ files, by their paths in the scene.
    pub models: BTreeMap<PathBuf, ObjModel>,
    /// Images of the scene's materials, by their paths in the scene.
    pub images: BTreeMap<PathBuf, DecodedImage>,
    /// Images of MTL materials.
    pub obj_pictures: ObjPictures,
    /// Images of suns, by their paths in the scene.
    pub sun_images: BTreeMap<PathBuf, DecodedImage>,
    /// Normal maps, by their paths in the scene.
    pub normal_maps: BTreeMap<PathBuf, DecodedImage>,
    /// Grids of fog, by their files' paths in the scene.
    pub grids: BTreeMap<PathBuf, vdb::GridFiles>,
    /// Image of the sky.
    pub sky_image: Option<DecodedImage>,
    /// Whether the input is a mesh without a scene file. It then has no camera and no light.
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

/// Reads a RON scene with all files that it refers to.
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

/// Creates a scene of a single OBJ file, untransformed.
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

/// Path in `file`, relative to its folder.
fn beside(file: &Path, path: &Path) -> PathBuf {
    files::beside(file.parent().unwrap_or(Path::new("")), path)
}
