//! A scene that a program writes in place of a file. In go parts as values under the names that the
//! format has for their fields, out comes a scene as if it had been read. Invariant: every part is read
//! by the reader of files. So a number out of range, a name that occurs twice and a field that does not
//! exist are refused here too.

use super::{LoadedScene, Named, SceneFile, Version, defaults, references};
use crate::description::obj::{ObjModel, Triangles};
use crate::description::{Files, LoadError};
use crate::diagnostic::{Diagnostic, Diagnostics, Place};
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};

/// Parts of one kind, by name.
pub type Parts = Vec<(String, Value)>;

/// Everything that a program wants of a scene, section by section as in a file.
#[derive(Clone, Debug, Default)]
pub struct BuiltScene {
    /// Shapes by their size.
    pub meshes: Parts,
    /// Shapes by their triangles.
    pub triangles: Vec<(String, Triangles)>,
    /// What surfaces are made of.
    pub materials: Parts,
    /// Meshes and groups.
    pub objects: Parts,
    /// Leaves by the hundred.
    pub leaves: Parts,
    /// Leaves that fall.
    pub fall: Parts,
    /// Cameras.
    pub cameras: Parts,
    /// Lights.
    pub lights: Parts,
    /// Banks of fog.
    pub fog: Parts,
    /// What lies behind the scene and lights it.
    pub sky: Option<Value>,
    /// Radiance of what lies beyond the scene; none is black.
    pub background: Option<Value>,
}

/// What errors name in place of a file; images lie relative to the folder that the program runs in.
pub const BUILT: &str = "SceneBuilder";

/// Reads it.
///
/// # Errors
/// [`LoadError`] with everything that is wrong, by the path of its field; if an image cannot be read.
pub fn load_built(built: BuiltScene, files: &mut Files) -> Result<LoadedScene, LoadError> {
    let mut reader = Reader::default();
    let (mut meshes, mut models) = (built.meshes, BTreeMap::new());
    for (name, triangles) in built.triangles {
        let path = PathBuf::from(format!("triangles of {name}"));
        if let Some(model) = reader.model(&name, &triangles) {
            models.insert(path.clone(), model);
        }
        meshes.push((name, serde_json::json!({ "Obj": path })));
    }
    let background = built.background.map(|value| reader.part("background_w_per_m2_sr", value));
    let file = SceneFile {
        version: Version,
        meshes: reader.section("meshes", meshes),
        materials: reader.section("materials", built.materials),
        objects: reader.section("objects", built.objects),
        leaves: reader.section("leaves", built.leaves),
        fall: reader.section("fall", built.fall),
        cameras: reader.section("cameras", built.cameras),
        lights: reader.section("lights", built.lights),
        fog: reader.section("fog", built.fog),
        sky: built.sky.and_then(|value| reader.part("sky", value)),
        background_w_per_m2_sr: background.flatten().unwrap_or_else(defaults::zero),
    };
    if reader.problems.has_errors() {
        return Err(LoadError::Invalid(reader.problems));
    }
    references::load(Path::new(BUILT), file, models, files)
}

/// Reads parts and goes on after invalid ones, so that all of them are reported.
#[derive(Default)]
struct Reader {
    problems: Diagnostics,
}

impl Reader {
    fn section<T: DeserializeOwned>(&mut self, section: &str, parts: Parts) -> Named<T> {
        let mut seen = HashSet::new();
        let mut things = Vec::new();
        for (name, value) in parts {
            let path = format!("{section}.{name}");
            if name.is_empty() {
                self.refuse(&path, "the name is empty", "a name that is not empty");
            } else if !seen.insert(name.clone()) {
                self.refuse(&path, "the name occurs a second time", "every name once");
            } else if let Some(thing) = self.part(&path, value) {
                things.push((name, thing));
            }
        }
        Named::of(things)
    }

    fn part<T: DeserializeOwned>(&mut self, path: &str, value: Value) -> Option<T> {
        serde_path_to_error::deserialize(value)
            .map_err(|error| {
                let field = error.path().to_string();
                let path = if field == "." { path.to_owned() } else { format!("{path}.{field}") };
                let said = error.inner().to_string();
                let (found, expected) =
                    said.split_once(", expected ").unwrap_or((&said, "what the format allows"));
                self.refuse(&path, found, expected);
            })
            .ok()
    }

    fn model(&mut self, name: &str, triangles: &Triangles) -> Option<ObjModel> {
        let refuse = |[field, found, expected]: [String; 3]| {
            self.refuse(&format!("meshes.{name}.{field}"), &found, &expected);
        };
        triangles.model().map_err(refuse).ok()
    }

    fn refuse(&mut self, path: &str, found: &str, expected: &str) {
        let place = Place::Field { file: PathBuf::from(BUILT), path: path.to_owned() };
        let remedy = "change the value; docs/scene-format.md has every field's unit and range";
        self.problems.push(Diagnostic::error(place, found).expected(expected).remedy(remedy));
    }
}
