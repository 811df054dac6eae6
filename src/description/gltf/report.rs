//! Collects what is wrong with one file. Invariant: things of the same kind end up in one message
//! that lists their names, however many there are.

use super::field;
use crate::diagnostic::{Diagnostic, Diagnostics, Loss, Place};
use std::path::{Path, PathBuf};

/// How many names one message lists.
const NAMES_LISTED: usize = 6;

/// Diagnostics of one file.
pub(crate) struct Report {
    file: PathBuf,
    diagnostics: Diagnostics,
    kinds: Vec<Kind>,
}

/// One kind of thing that is not honoured, and who asks for it.
struct Kind {
    loss: Loss,
    first_names: Vec<String>,
    more: usize,
}

impl Report {
    pub(crate) fn new(file: &Path) -> Self {
        Self { file: file.to_owned(), diagnostics: Diagnostics::default(), kinds: Vec::new() }
    }

    pub(crate) fn push(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }

    /// The value, or its error put on the list.
    pub(crate) fn keep<T>(&mut self, result: Result<T, Diagnostic>) -> Option<T> {
        result.map_err(|diagnostic| self.push(diagnostic)).ok()
    }

    /// A place in this file.
    pub(crate) fn at(&self, path: impl Into<String>) -> Place {
        field(&self.file, path)
    }

    /// An error at a place in this file.
    pub(crate) fn error(&mut self, path: impl Into<String>, found: impl Into<String>, expected: &str) {
        let error = Diagnostic::error(self.at(path), found)
            .expected(expected)
            .remedy("correct this in the scene and export it again");
        self.push(error);
    }

    /// Puts `name` on the list of those who lose what `loss` says.
    pub(crate) fn not_honoured(&mut self, loss: Loss, name: &str) {
        match self.kinds.iter_mut().find(|kind| kind.loss == loss) {
            Some(kind) if kind.first_names.len() < NAMES_LISTED => kind.first_names.push(name.to_owned()),
            Some(kind) => kind.more += 1,
            None => self.kinds.push(Kind { loss, first_names: vec![name.to_owned()], more: 0 }),
        }
    }

    /// True, with an error, unless `index` is one of `count` things called `what`.
    pub(crate) fn index_exists(&mut self, path: String, index: usize, count: usize, what: &str) -> bool {
        if index >= count {
            self.error(
                path,
                format!("{what} {index} does not exist"),
                &match count {
                    0 => format!("none, as there is no {what} in the file"),
                    1 => format!("0, as there is one {what} in the file"),
                    _ => format!("a number from 0 to {}, as counted in the file", count - 1),
                },
            );
        }
        index < count
    }

    pub(crate) fn has_errors(&self) -> bool {
        self.diagnostics.has_errors()
    }

    pub(crate) fn into_diagnostics(mut self) -> Diagnostics {
        for Kind { loss, first_names, more } in self.kinds {
            let names = first_names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
            let more_names = if more > 0 { format!(" and {more} more") } else { String::new() };
            let place = Place::File(self.file.clone());
            let found = format!("{}: {names}{}", loss.sentence(), more_names);
            self.diagnostics.push(Diagnostic::warning(loss, place, found).counting(first_names.len() + more));
        }
        self.diagnostics
    }
}
