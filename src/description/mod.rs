//! Input of the author. In go files, out come typed descriptions. Invariant: input files are opened only
//! here, through [`Files`], so the content hash covers all of them.

mod decoded_image;
pub mod exr;
mod files;
pub mod gltf;
pub mod image;
mod ktx2;
mod numbered;
pub mod obj;
#[cfg(feature = "program")]
mod peers;
mod radiances;
pub mod ron;
pub(crate) mod tangents;
pub mod vdb;

use crate::diagnostic::{Diagnostic, Diagnostics, Place, readable, shown};
use std::path::{Path, PathBuf};

pub use files::{Files, open_regular, read_regular};
pub use numbered::signs;
#[cfg(feature = "program")]
pub use peers::{PeerRow, load_peers};

/// Largest magnitude in every format, so that squares stay finite in the `f32` of the kernels.
pub const LARGEST_NUMBER: f64 = 1e15;

/// Input as read: a scene, and the sequence that refers to it, if there is one.
#[derive(Debug)]
pub struct Description {
    /// The file named on the command line.
    pub path: PathBuf,
    /// Scene to render.
    pub scene: SceneSource,
    /// Settings of a sequence, if the input is one.
    pub sequence: Option<ron::SequenceFile>,
    /// SHA-256 over every file read, in hexadecimal.
    pub content_hash: String,
    /// Every file read.
    pub files: Vec<PathBuf>,
}

/// Scene in one of the supported formats.
#[derive(Debug)]
pub enum SceneSource {
    /// Sunfleck's own format, with its meshes and textures.
    Ron(ron::LoadedScene),
    /// A glTF file, with its buffers and images.
    Gltf(gltf::GltfScene),
}

impl SceneSource {
    /// The scene's own file.
    pub fn path(&self) -> &Path {
        match self {
            Self::Ron(scene) => &scene.path,
            Self::Gltf(scene) => &scene.path,
        }
    }

    /// Whether files of its format usually hold only shapes, so that a scene without light gets a default
    /// one.
    pub fn is_bare(&self) -> bool {
        match self {
            Self::Ron(scene) => scene.is_mesh_alone,
            Self::Gltf(_) => true,
        }
    }

    /// Whether the file describes surroundings, as a black sky is dark on purpose.
    pub fn says_surroundings(&self) -> bool {
        matches!(self, Self::Gltf(scene) if scene.extras.get("sunfleck_env").is_some())
    }
}

impl Description {
    /// Description of a scene from code. Its hash covers all of its contents.
    pub fn built(built: ron::BuiltScene) -> Result<Self, LoadError> {
        let mut files = Files::default();
        files.count(format!("{built:?}").as_bytes());
        let scene = SceneSource::Ron(ron::load_built(built, &mut files)?);
        let content_hash = files.content_hash();
        let path = PathBuf::from(ron::BUILT);
        Ok(Self { path, scene, sequence: None, content_hash, files: files.into_paths() })
    }

    /// Checks that an animation exists.
    ///
    /// # Errors
    /// With the names of the existing ones.
    pub fn check_animation(&self, wanted: Option<&str>) -> Result<(), String> {
        let Some(wanted) = wanted else { return Ok(()) };
        match &self.scene {
            _ if wanted == "all" => Ok(()),
            SceneSource::Gltf(scene) if !scene.animations_called(wanted).is_empty() => Ok(()),
            SceneSource::Gltf(scene) => Err(scene.animation_names()),
            SceneSource::Ron(_) => Err(String::from("a glTF file: in RON everything that moves is one")),
        }
    }
}

/// Error of loading an input.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    /// A file is missing or cannot be read.
    #[error("{}: cannot be read: {source}", shown(&readable(path)))]
    Io {
        /// The file.
        path: PathBuf,
        /// File and field that refer to it.
        referrer: Option<String>,
        /// Error of the system.
        source: std::io::Error,
    },
    /// The files can be read but not used.
    #[error("{}", first_of(.0))]
    Invalid(Diagnostics),
}

/// First diagnostic, and the number of further ones.
fn first_of(Diagnostics(found): &Diagnostics) -> String {
    let first = found.first().map(Diagnostic::line).unwrap_or_default();
    match found.len() {
        0 | 1 => first,
        count => format!("{first} (and {} more)", count - 1),
    }
}

impl LoadError {
    /// Diagnostics of all faults, with expectations and remedies.
    pub fn diagnostics(&self) -> Diagnostics {
        match self {
            Self::Io { path, referrer, source } => {
                let place = referrer.as_deref().map(|place| format!(" in {place}")).unwrap_or_default();
                let found = Diagnostic::error(Place::File(path.clone()), format!("cannot be read: {source}"));
                let found = found.expected("a readable file").remedy(format!("check the path{place}"));
                Diagnostics(vec![found])
            }
            Self::Invalid(diagnostics) => diagnostics.clone(),
        }
    }

    /// Remedy of the first fault.
    pub fn remedy(&self) -> String {
        let Diagnostics(found) = self.diagnostics();
        found.into_iter().find_map(|found| found.remedy).map(String::from).unwrap_or_default()
    }

    /// Sets the referrer of a file that cannot be read, unless it is known already.
    fn asked_for_by(mut self, asker: &str) -> Self {
        if let Self::Io { referrer, .. } = &mut self {
            referrer.get_or_insert_with(|| asker.to_owned());
        }
        self
    }
}

impl From<Diagnostics> for LoadError {
    fn from(diagnostics: Diagnostics) -> Self {
        Self::Invalid(diagnostics.worst())
    }
}

impl From<Diagnostic> for LoadError {
    fn from(diagnostic: Diagnostic) -> Self {
        Self::Invalid(Diagnostics(vec![diagnostic]))
    }
}

/// Loads a scene or sequence by its extension: `.ron`, `.glb`, `.gltf`, `.obj`.
pub fn load(path: &Path) -> Result<Description, LoadError> {
    let mut files = Files::default();
    let (scene, sequence) = match extension(path).as_str() {
        "ron" => match ron::load(path, &mut files)? {
            ron::RonFile::Scene(scene) => (SceneSource::Ron(*scene), None),
            ron::RonFile::Sequence(sequence) => {
                let scene = load_scene(&sequence.scene_path, &mut files)
                    .map_err(|error| error.asked_for_by(&format!("{}: scene", path.display())))?;
                (scene, Some(*sequence))
            }
        },
        _ => (load_scene(path, &mut files)?, None),
    };
    let content_hash = files.content_hash();
    Ok(Description { path: path.to_owned(), scene, sequence, content_hash, files: files.into_paths() })
}

fn load_scene(path: &Path, files: &mut Files) -> Result<SceneSource, LoadError> {
    match extension(path).as_str() {
        "ron" => ron::load_scene(path, files).map(SceneSource::Ron),
        "glb" | "gltf" => gltf::load(path, files).map(SceneSource::Gltf),
        "obj" => ron::load_mesh_alone(path, files).map(SceneSource::Ron),
        other => Err(not_a_scene(path, other)),
    }
}

fn not_a_scene(path: &Path, extension: &str) -> LoadError {
    let found = match std::fs::metadata(path) {
        Ok(metadata) if metadata.is_dir() => String::from("this is a folder"),
        Ok(_) if extension.is_empty() => {
            String::from("the name has no extension that says what is in the file")
        }
        Err(source) if extension.is_empty() => {
            return LoadError::Io { path: path.to_owned(), referrer: None, source };
        }
        _ => format!("the extension `{extension}` is not one that is read"),
    };
    Diagnostic::error(Place::File(path.to_owned()), found)
        .expected("a .ron, .glb, .gltf or .obj file")
        .remedy("name such a file; export a scene as .glb, or describe it in RON (docs/scene-format.md)")
        .into()
}

fn extension(path: &Path) -> String {
    path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default()
}
