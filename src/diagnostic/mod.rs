//! Diagnostics: a finding, its place and its remedy. In go problems, out come messages. Invariant: every
//! diagnostic has a finding. A warning is a [`Loss`], with a permanent id. An error also has an expectation
//! and a remedy.

mod loss;
mod printable;

pub use loss::Loss;
use printable::Printable;
pub use printable::shown;
use std::fmt::{self, Write as _};
use std::path::{Component, Path, PathBuf};

/// Severity of a diagnostic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Severity {
    /// Information without consequence; only `inspect` shows it.
    Note,
    /// Assumption of the program where the input is silent; rendering shows it too.
    Choice,
    /// A request of the file that is not honoured, or only approximated.
    Warning,
    /// The input cannot be used.
    Error,
}

/// Place in the input.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Place {
    /// Nowhere in particular (a command-line value, say).
    Nowhere,
    /// The file as a whole.
    File(PathBuf),
    /// A line and column of a text file, both from 1. RON gives both, OBJ gives column 1.
    Text {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
    },
    /// Path to a value in a structured file, such as `leaves[3].mesh` or `nodes[4].camera`.
    Field {
        /// The file.
        file: PathBuf,
        /// Path of the value.
        path: String,
    },
}

/// Message for the user.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Diagnostic {
    /// Severity.
    pub severity: Severity,
    /// Loss that a warning reports.
    pub loss: Option<Loss>,
    /// Number of objects of the input that it concerns, at least 1.
    pub count: usize,
    /// Place.
    pub place: Place,
    /// Finding, as a sentence without a full stop.
    pub found: String,
    /// Expectation that was not met.
    pub expected: Option<Box<str>>,
    /// Remedy for the author.
    pub remedy: Option<Box<str>>,
}

impl Diagnostic {
    /// Creates an error: the input cannot be used.
    pub fn error(place: Place, found: impl Into<String>) -> Self {
        Self::new(Severity::Error, place, found)
    }

    /// Creates a warning: a request that is not honoured.
    pub fn warning(loss: Loss, place: Place, found: impl Into<String>) -> Self {
        Self { loss: Some(loss), ..Self::new(Severity::Warning, place, found) }
    }

    /// Creates a diagnostic of an assumption where the input is silent.
    pub fn choice(place: Place, found: impl Into<String>) -> Self {
        Self::new(Severity::Choice, place, found)
    }

    /// Creates a note without consequence.
    pub fn note(place: Place, found: impl Into<String>) -> Self {
        Self::new(Severity::Note, place, found)
    }

    fn new(severity: Severity, place: Place, found: impl Into<String>) -> Self {
        Self { severity, loss: None, count: 1, place, found: found.into(), expected: None, remedy: None }
    }

    /// Sets the number of objects that it concerns.
    #[must_use]
    pub fn counting(mut self, count: usize) -> Self {
        self.count = count;
        self
    }

    /// Adds the expectation.
    #[must_use]
    pub fn expected(mut self, expected: impl Into<String>) -> Self {
        self.expected = Some(expected.into().into_boxed_str());
        self
    }

    /// Adds the remedy for the author.
    #[must_use]
    pub fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.remedy = Some(remedy.into().into_boxed_str());
        self
    }

    /// Place and finding, in one line.
    pub fn line(&self) -> String {
        let mut line = self.place.to_string();
        // Writing to a string cannot fail.
        let _ = Printable(&mut line).write_str(&self.found.replace('\n', " "));
        line
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut printable = Printable(f);
        match self {
            Self::Nowhere => Ok(()),
            Self::File(file) => write!(printable, "{}: ", shown(&readable(file))),
            Self::Text { file, line, column } => {
                write!(printable, "{}:{line}:{column}: ", shown(&readable(file)))
            }
            Self::Field { file, path } => write!(printable, "{}: {path}: ", shown(&readable(file))),
        }
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let severity = match self.severity {
            Severity::Note | Severity::Choice => "note",
            Severity::Warning => "warning",
            Severity::Error => "error",
        };
        write!(f, "{}{severity}", self.place)?;
        if let Some(loss) = self.loss {
            write!(f, "[{loss}]")?;
        }
        write!(Printable(f), ": {}", self.found)?;
        if let Some(expected) = &self.expected {
            write!(Printable(f), "\n  expected: {expected}")?;
        }
        if let Some(remedy) = &self.remedy {
            write!(Printable(f), "\n  remedy: {remedy}")?;
        }
        Ok(())
    }
}

/// Shortened path for messages: `sequences/../scenes/x` becomes `scenes/x`. With symbolic links the two may
/// differ.
pub fn readable(path: &Path) -> PathBuf {
    let mut readable = PathBuf::new();
    for component in path.components() {
        match component {
            Component::ParentDir
                if matches!(readable.components().next_back(), Some(Component::Normal(_))) =>
            {
                readable.pop();
            }
            Component::CurDir => {}
            other => readable.push(other),
        }
    }
    if readable.as_os_str().is_empty() { path.to_owned() } else { readable }
}

/// All problems of one input, in the order found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Diagnostics(pub Vec<Diagnostic>);

impl Diagnostics {
    /// Adds a diagnostic.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.0.push(diagnostic);
    }

    /// True if any of them is an error.
    pub fn has_errors(&self) -> bool {
        self.0.iter().any(|diagnostic| diagnostic.severity == Severity::Error)
    }

    /// Diagnostics that rendering shows, worst last: assumptions and losses.
    pub fn reported(&self) -> impl Iterator<Item = &Diagnostic> {
        self.0.iter().filter(|diagnostic| matches!(diagnostic.severity, Severity::Choice | Severity::Warning))
    }

    /// Losses with their diagnostics.
    pub fn losses(&self) -> impl Iterator<Item = (Loss, &Diagnostic)> {
        self.0.iter().filter_map(|diagnostic| Some((diagnostic.loss?, diagnostic)))
    }

    /// All losses as errors, for `--strict`; `None` without losses.
    pub fn refusing_losses(&self) -> Option<Self> {
        let refused = self.losses().map(|(_, loss)| {
            let mut error = Diagnostic { severity: Severity::Error, ..loss.clone() };
            error.remedy.get_or_insert_with(|| "correct the input, or leave --strict out".into());
            error
        });
        let refused: Vec<Diagnostic> = refused.collect();
        (!refused.is_empty()).then_some(Self(refused))
    }

    /// The errors alone, if there are any, as nothing else matters then.
    #[must_use]
    pub fn worst(mut self) -> Self {
        if self.has_errors() {
            self.0.retain(|diagnostic| diagnostic.severity == Severity::Error);
        }
        self
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, diagnostic) in self.0.iter().enumerate() {
            if index > 0 {
                writeln!(f)?;
            }
            write!(f, "{diagnostic}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_told_without_detours() {
        for (path, told) in [
            ("sequences/../scenes/a/scene.ron", "scenes/a/scene.ron"),
            ("../scenes/./b.ron", "../scenes/b.ron"),
            ("../../b.ron", "../../b.ron"),
            ("/a/b/../../c", "/c"),
            (".", "."),
        ] {
            assert_eq!(readable(Path::new(path)), Path::new(told));
        }
    }

    #[test]
    fn terminals_are_not_told_what_to_do() {
        let name = "a\u{1b}[2J\u{202e}b\r";
        let place = Place::Field { file: PathBuf::from(name), path: name.into() };
        let said = Diagnostic::error(place, format!("`{name}` is red\nand green")).remedy(name).to_string();
        assert!(!said.contains(['\u{1b}', '\u{202e}', '\r']), "{said:?}");
        assert!(said.contains("`a\\u{1b}[2J\\u{202e}b\\r` is red\nand green"), "{said:?}");
    }

    #[test]
    fn warnings_do_not_stand_in_the_way_of_errors() {
        let warning = Diagnostic::warning(Loss::NoLight, Place::Nowhere, "a");
        let error = Diagnostic::error(Place::Nowhere, "b");
        let both = Diagnostics(vec![warning.clone(), error.clone()]);
        assert_eq!(both.worst().0, [error]);
        assert_eq!(Diagnostics(vec![warning.clone()]).worst().0, [warning]);
    }

    #[test]
    fn losses_are_refused_and_notes_are_not() {
        let loss = Diagnostic::warning(Loss::NoLight, Place::Nowhere, "a").counting(3);
        let told = Diagnostic::choice(Place::Nowhere, "b");
        let note = Diagnostic::note(Place::Nowhere, "c");
        let all = Diagnostics(vec![loss.clone(), told.clone(), note.clone()]);
        let refused = all.refusing_losses().expect("a loss");
        assert!(refused.has_errors() && refused.0.len() == 1);
        assert!(refused.to_string().starts_with("error[no-light]: a\n  remedy: "), "{refused}");
        assert_eq!(all.reported().collect::<Vec<_>>(), [&loss, &told]);
        assert_eq!(Diagnostics(vec![told, note]).refusing_losses(), None);
    }

    #[test]
    fn ids_are_unlike_and_written_alike() {
        let mut ids: Vec<&str> = Loss::ALL.iter().map(|loss| loss.id()).collect();
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), Loss::ALL.len());
        assert!(ids.iter().all(|id| id.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'-')));
    }
}
