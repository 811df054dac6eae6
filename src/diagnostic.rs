//! What went wrong or was not honoured, where, and what to do about it. Invariant: a diagnostic
//! always says what was found; errors also say what was expected and how to get there.

use std::fmt;
use std::path::{Component, Path, PathBuf};

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Something worth knowing that changes nothing.
    Note,
    /// The file asks for something that is not honoured, or only nearly.
    Warning,
    /// The input cannot be used.
    Error,
}

/// Where in the input it is.
#[derive(Clone, Debug, PartialEq, Eq)]
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
    /// A path to a value in a structured file, such as `leaves[3].mesh` or `nodes[4].camera`.
    Field {
        /// The file.
        file: PathBuf,
        /// Path of the value.
        path: String,
    },
}

/// One thing to tell the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// Where it is.
    pub place: Place,
    /// What was found, as a sentence without a full stop.
    pub found: String,
    /// What was expected instead.
    pub expected: Option<Box<str>>,
    /// What the author can do.
    pub remedy: Option<Box<str>>,
}

impl Diagnostic {
    /// An error: the input cannot be used.
    pub fn error(place: Place, found: impl Into<String>) -> Self {
        Self::new(Severity::Error, place, found)
    }

    /// A warning: something asked for is not honoured.
    pub fn warning(place: Place, found: impl Into<String>) -> Self {
        Self::new(Severity::Warning, place, found)
    }

    /// A note: worth knowing, changes nothing.
    pub fn note(place: Place, found: impl Into<String>) -> Self {
        Self::new(Severity::Note, place, found)
    }

    fn new(severity: Severity, place: Place, found: impl Into<String>) -> Self {
        Self { severity, place, found: found.into(), expected: None, remedy: None }
    }

    /// Adds what was expected.
    #[must_use]
    pub fn expected(mut self, expected: impl Into<String>) -> Self {
        self.expected = Some(expected.into().into_boxed_str());
        self
    }

    /// Adds what the author can do.
    #[must_use]
    pub fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.remedy = Some(remedy.into().into_boxed_str());
        self
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nowhere => Ok(()),
            Self::File(file) => write!(f, "{}: ", readable(file).display()),
            Self::Text { file, line, column } => {
                write!(f, "{}:{line}:{column}: ", readable(file).display())
            }
            Self::Field { file, path } => write!(f, "{}: {path}: ", readable(file).display()),
        }
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let severity = match self.severity {
            Severity::Note => "note",
            Severity::Warning => "warning",
            Severity::Error => "error",
        };
        write!(f, "{}{severity}: {}", self.place, self.found)?;
        if let Some(expected) = &self.expected {
            write!(f, "\n  expected: {expected}")?;
        }
        if let Some(remedy) = &self.remedy {
            write!(f, "\n  remedy: {remedy}")?;
        }
        Ok(())
    }
}

/// The path as a person would write it: `sequences/../scenes/x` is `scenes/x`. For reading only, as
/// a symbolic link may make the two differ.
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
    readable
}

/// Every problem found in one input, in the order found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Diagnostics(pub Vec<Diagnostic>);

impl Diagnostics {
    /// Adds one.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.0.push(diagnostic);
    }

    /// True if any of them is an error.
    pub fn has_errors(&self) -> bool {
        self.0.iter().any(|diagnostic| diagnostic.severity == Severity::Error)
    }
}

impl Diagnostics {
    /// The errors alone, if there are any: who has to put something right need not read the rest.
    #[must_use]
    pub fn worst(mut self) -> Self {
        if self.has_errors() {
            self.0.retain(|diagnostic| diagnostic.severity == Severity::Error);
        }
        self
    }
}

impl std::error::Error for Diagnostics {}

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
        ] {
            assert_eq!(readable(Path::new(path)), Path::new(told));
        }
    }

    #[test]
    fn warnings_do_not_stand_in_the_way_of_errors() {
        let warning = Diagnostic::warning(Place::Nowhere, "a");
        let error = Diagnostic::error(Place::Nowhere, "b");
        let both = Diagnostics(vec![warning.clone(), error.clone()]);
        assert_eq!(both.worst().0, [error]);
        assert_eq!(Diagnostics(vec![warning.clone()]).worst().0, [warning]);
    }
}
