//! Problems of a file, all of them. Invariant: every problem names the field by its path.

use crate::description::ron::suggest;
use crate::diagnostic::{Diagnostic, Diagnostics, Place};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

pub(super) struct Problems {
    file: PathBuf,
    errors: Diagnostics,
}

impl Problems {
    pub(super) fn of(file: &Path) -> Self {
        Self { file: file.to_owned(), errors: Diagnostics::default() }
    }

    /// The place of a field, such as `objects.leaf.mesh`.
    pub(super) fn place(&self, field: &str) -> Place {
        Place::Field { file: self.file.clone(), path: field.to_owned() }
    }

    pub(super) fn error(&mut self, field: &str, found: impl Into<String>, expected: &str, remedy: &str) {
        let place = self.place(field);
        self.errors.push(Diagnostic::error(place, found).expected(expected).remedy(remedy));
    }

    /// Looks `name` up; a name that is not there is a problem of `field`.
    pub(super) fn find<V: Copy>(
        &mut self,
        field: &str,
        kind: &str,
        name: &str,
        known: &BTreeMap<&str, V>,
    ) -> Option<V> {
        let found = known.get(name).copied();
        if found.is_none() {
            let expected = match known.len() {
                0 => format!("the name of a {kind}; the scene has none"),
                _ => format!("one of {}", suggest::list(known.keys().copied())),
            };
            let remedy = suggest::remedy(name, known.keys().copied());
            self.error(field, format!("there is no {kind} named `{name}`"), &expected, &remedy);
        }
        found
    }

    /// `value`, unless there was a problem.
    pub(super) fn unless_any<T>(self, value: T) -> Result<T, Diagnostics> {
        if self.errors.has_errors() { Err(self.errors) } else { Ok(value) }
    }
}
