//! Tally of the losses of OBJ and MTL files. In go losses one by one, out comes a warning a kind. Invariant:
//! a kind is reported once, with its first line and its count.

use crate::diagnostic::{Diagnostic, Diagnostics, Loss, Place};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Maximum number of names in a message, and their maximum length.
const NAMES_LISTED: usize = 6;
const LONGEST_NAME: usize = 60;

#[derive(Debug, Default)]
pub(super) struct Tally {
    kinds: BTreeMap<Loss, Kind>,
}

#[derive(Debug)]
struct Kind {
    first: Place,
    count: usize,
    names: BTreeSet<String>,
    more_names: bool,
}

impl Tally {
    /// Counts one loss; `name` is the object that is lost, or empty.
    pub(super) fn add(&mut self, loss: Loss, name: &str, place: Place) {
        let kind = self.kinds.entry(loss).or_insert_with(|| Kind {
            first: place,
            count: 0,
            names: BTreeSet::new(),
            more_names: false,
        });
        kind.count += 1;
        let name: String =
            name.chars().take(LONGEST_NAME).map(|c| if c.is_control() { '?' } else { c }).collect();
        if kind.names.len() < NAMES_LISTED {
            kind.names.insert(name);
        } else if !kind.names.contains(&name) {
            kind.more_names = true;
        }
    }

    pub(super) fn add_at(&mut self, loss: Loss, name: &str, (path, line): (&Path, usize)) {
        self.add(loss, name, Place::Text { file: path.to_owned(), line, column: 1 });
    }

    /// A warning a kind.
    pub(super) fn into_remarks(self) -> Diagnostics {
        let warning = |(loss, kind): (Loss, Kind)| {
            let names: Vec<String> =
                kind.names.iter().filter(|name| !name.is_empty()).map(|name| format!("`{name}`")).collect();
            let names = match (names.is_empty(), kind.more_names) {
                (true, _) => String::new(),
                (false, false) => format!(": {}", names.join(", ")),
                (false, true) => format!(": {} and others", names.join(", ")),
            };
            let found = format!("{}{names} ({} in all)", loss.sentence(), kind.count);
            Diagnostic::warning(loss, kind.first, found).counting(kind.count)
        };
        Diagnostics(self.kinds.into_iter().map(warning).collect())
    }
}
