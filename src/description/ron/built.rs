//! Scenes from code. In go the parts of scene files, out comes a scene as if it had been read. Invariant: a
//! scene that a file cannot hold is refused, such as with a number out of range or a duplicate name.

use super::{LoadedScene, Named, SceneFile, Shape, references, walk};
use crate::description::obj::{ObjModel, Triangles};
use crate::description::{Files, LoadError};
use crate::diagnostic::{Diagnostic, Diagnostics, Place};
use serde::Serialize;
use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};

/// Contents of a scene from code.
#[derive(Clone, Debug, Default)]
pub struct BuiltScene {
    /// Scene file with the same contents.
    pub file: SceneFile,
    /// Meshes given by their triangles.
    pub triangles: Vec<(String, Triangles)>,
}

/// Name in errors in place of a file's. Paths of images are relative to the working directory.
pub const BUILT: &str = "SceneBuilder";

/// Validates the scene, and reads the files that it refers to.
pub fn load_built(built: BuiltScene, files: &mut Files) -> Result<LoadedScene, LoadError> {
    let BuiltScene { mut file, triangles } = built;
    let (mut check, mut models) = (Check::default(), BTreeMap::new());
    for (name, triangles) in triangles {
        let path = PathBuf::from(format!("triangles of {name}"));
        models.extend(check.model(&name, &triangles).map(|model| (path.clone(), model)));
        file.meshes.push(&name, Shape::Obj(path));
    }
    check.section("meshes", &file.meshes);
    check.section("materials", &file.materials);
    check.section("objects", &file.objects);
    check.section("leaves", &file.leaves);
    check.section("fall", &file.fall);
    check.section("cameras", &file.cameras);
    check.section("lights", &file.lights);
    check.section("fog", &file.fog);
    check.part("sky", &file.sky);
    check.part("background_w_per_m2_sr", &file.background_w_per_m2_sr);
    if check.problems.has_errors() {
        return Err(LoadError::Invalid(check.problems));
    }
    references::load(Path::new(BUILT), file, models, files)
}

/// Continues after invalid parts, so that all of them are reported.
#[derive(Default)]
struct Check {
    problems: Diagnostics,
}

impl Check {
    fn section<T: Serialize>(&mut self, section: &str, parts: &Named<T>) {
        let mut seen = HashSet::new();
        for (name, part) in parts.iter() {
            let path = format!("{section}.{name}");
            if name.is_empty() {
                self.refuse(&path, "the name is empty", "a name that is not empty");
            } else if !seen.insert(name) {
                self.refuse(&path, "the name occurs a second time", "every name once");
            } else {
                self.part(&path, part);
            }
        }
    }

    fn part(&mut self, path: &str, part: &impl Serialize) {
        let Some((field, said)) = walk::fault(part) else { return };
        let path = if field.is_empty() { path.to_owned() } else { format!("{path}.{field}") };
        let (found, expected) = said.split_once(", expected ").unwrap_or((&said, "what the format allows"));
        self.refuse(&path, found, expected);
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
