//! Report of a file's problems. In go findings, out come diagnostics. Invariant: objects of one kind share
//! one message that lists their names. A dropped or corrected part is a warning; it is an error only if
//! nothing is left.

use super::field;
use crate::diagnostic::{Diagnostic, Diagnostics, Loss, Place, readable, shown};
use std::fmt;
use std::path::{Path, PathBuf};

/// Maximum number of names in one message.
const NAMES_LISTED: usize = 6;

pub(crate) struct Report {
    file: PathBuf,
    diagnostics: Diagnostics,
    kinds: Vec<Kind>,
}

/// Kind of loss, and the objects that it concerns.
struct Kind {
    loss: Loss,
    first_names: Vec<String>,
    more: usize,
    /// Diagnostic of the first one, if it has more than a name.
    first: Option<Diagnostic>,
}

impl Report {
    pub(crate) fn new(file: &Path) -> Self {
        Self { file: file.to_owned(), diagnostics: Diagnostics::default(), kinds: Vec::new() }
    }

    pub(crate) fn push(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }

    /// Value, or `None` with its error reported as this loss.
    pub(super) fn spare<T>(&mut self, loss: Loss, result: Result<T, Diagnostic>) -> Option<T> {
        result.map_err(|damage| self.leave_out(loss, damage)).ok()
    }

    /// Reports an error as this loss; the part concerned is dropped.
    pub(crate) fn leave_out(&mut self, loss: Loss, damage: Diagnostic) {
        let place = match &damage.place {
            Place::Field { path, .. } => format!("{path}: "),
            Place::File(file) if *file != self.file => format!("{}: ", shown(&readable(file))),
            _ => String::new(),
        };
        self.add(loss, format!("{place}{}", damage.found), Some(damage));
    }

    /// Reports a corrected value.
    pub(crate) fn put_right(&mut self, loss: Loss, path: &str, found: impl fmt::Display) {
        self.add(loss, format!("{path}: {found}"), None);
    }

    pub(super) fn first_damage(&self, loss: Loss) -> Option<&Diagnostic> {
        self.kinds.iter().find(|kind| kind.loss == loss)?.first.as_ref()
    }

    /// Value, or `None` with its error reported as an error.
    pub(crate) fn keep<T>(&mut self, result: Result<T, Diagnostic>) -> Option<T> {
        result.map_err(|diagnostic| self.push(diagnostic)).ok()
    }

    pub(crate) fn file(&self) -> Place {
        Place::File(self.file.clone())
    }

    pub(crate) fn at(&self, path: impl Into<String>) -> Place {
        field(&self.file, path)
    }

    /// Reports an error at a place in this file.
    pub(crate) fn error(&mut self, path: impl Into<String>, found: impl Into<String>, expected: &str) {
        let error = Diagnostic::error(self.at(path), found)
            .expected(expected)
            .remedy("correct this in the scene and export it again");
        self.push(error);
    }

    /// Adds `name` to the objects that a loss concerns.
    pub(crate) fn not_honoured(&mut self, loss: Loss, name: &str) {
        self.add(loss, format!("`{name}`"), None);
    }

    fn add(&mut self, loss: Loss, name: String, first: Option<Diagnostic>) {
        match self.kinds.iter_mut().find(|kind| kind.loss == loss) {
            Some(kind) if kind.first_names.len() < NAMES_LISTED => kind.first_names.push(name),
            Some(kind) => kind.more += 1,
            None => self.kinds.push(Kind { loss, first_names: vec![name], more: 0, first }),
        }
    }

    /// Whether `index` is less than `count`; otherwise reports a loss. `what` is the kind of object.
    pub(super) fn index_exists(&mut self, path: &str, index: usize, count: usize, what: &str) -> bool {
        if index >= count {
            let found = format!("there is no {what} {index}, only {count} of them");
            self.put_right(Loss::ReferenceMissing, path, found);
        }
        index < count
    }

    pub(crate) fn has_errors(&self) -> bool {
        self.diagnostics.has_errors()
    }

    pub(crate) fn into_diagnostics(mut self) -> Diagnostics {
        for Kind { loss, first_names, more, first } in self.kinds {
            let more_names = if more > 0 { format!(" and {more} more") } else { String::new() };
            let place = Place::File(self.file.clone());
            let found = format!("{}: {}{more_names}", loss.sentence(), first_names.join(", "));
            let warning = Diagnostic::warning(loss, place, found).counting(first_names.len() + more);
            let remedy = first.and_then(|first| first.remedy);
            self.diagnostics.push(Diagnostic { remedy, ..warning });
        }
        self.diagnostics
    }
}
