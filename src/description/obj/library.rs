//! Material libraries. In go the names after `mtllib`, out come the materials of those files. Invariant: a
//! file is read once, and an unreadable one is reported.

use super::material::{self, ObjMaterial};
use super::tally::Tally;
use super::text::{self, statements};
use super::texture::beside;
use crate::description::Files;
use crate::diagnostic::Loss;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Materials of one or more MTL files.
#[derive(Default)]
pub(super) struct Library {
    pub(super) materials: Vec<ObjMaterial>,
    by_name: BTreeMap<String, usize>,
    by_name_without_comment: BTreeMap<String, usize>,
}

impl Library {
    /// Reads the files that `mtllib` statements of an OBJ file name, anywhere in it.
    pub(super) fn of(obj_text: &str, path: &Path, files: &mut Files, tally: &mut Tally) -> Self {
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut library = Self::default();
        let mut known = BTreeSet::new();
        for statement in statements(obj_text).filter(|statement| statement.keyword() == "mtllib") {
            for mtl in paths(folder, statement.rest()) {
                if !known.insert(mtl.clone()) {
                    continue;
                }
                if let Some(bytes) = files.read_if_there(&mtl) {
                    library.add(material::read(&text::decoded(bytes), &mtl, tally));
                } else {
                    let name = mtl.strip_prefix(folder).unwrap_or(&mtl).display().to_string();
                    tally.add_at(Loss::MtlMissing, &name, (path, statement.line));
                }
            }
        }
        library
    }

    fn add(&mut self, materials: Vec<ObjMaterial>) {
        for material in materials {
            let number = self.materials.len();
            self.by_name_without_comment.insert(without_comment(&material.name).to_owned(), number);
            self.by_name.insert(material.name.clone(), number);
            self.materials.push(material);
        }
    }

    /// Index of the material with that name, or else with that name before a comment.
    pub(super) fn find(&self, name: &str) -> Option<usize> {
        let like_it = || self.by_name_without_comment.get(without_comment(name));
        self.by_name.get(name).or_else(like_it).copied()
    }
}

/// Name without a comment. Names may contain the sign (`Material #25`), so this is the second choice.
fn without_comment(name: &str) -> &str {
    name.split(" #").next().unwrap_or_default().trim_end()
}

/// One path with spaces if that file exists, otherwise one path a word.
fn paths(folder: &Path, names: &str) -> Vec<PathBuf> {
    let whole = beside(folder, names);
    let words = || names.split_whitespace().take_while(|word| !word.starts_with('#'));
    let each: Vec<PathBuf> = words().filter_map(|word| beside(folder, word)).collect();
    match whole {
        Some(whole) if whole.is_file() || !each.iter().any(|path| path.is_file()) => vec![whole],
        _ => each,
    }
}
