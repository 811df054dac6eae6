//! All problems of a file. In go faults by field, out come diagnostics. Invariant: every problem has its
//! field's path.

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

    /// Place of a field, such as `objects.leaf.mesh`.
    pub(super) fn place(&self, field: &str) -> Place {
        Place::Field { file: self.file.clone(), path: field.to_owned() }
    }

    pub(super) fn error(&mut self, field: &str, found: impl Into<String>, expected: &str, remedy: &str) {
        let place = self.place(field);
        self.errors.push(Diagnostic::error(place, found).expected(expected).remedy(remedy));
    }

    /// Value of `name`; an unknown name is a problem of `field`.
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

    /// Returns `value`, unless there was an error.
    pub(super) fn unless_any<T>(self, value: T) -> Result<T, Diagnostics> {
        if self.errors.has_errors() { Err(self.errors) } else { Ok(value) }
    }
}
