//! Measurements of other renderers for `bench --peers`. In goes a CSV file, out come its rows. Invariant:
//! every number is positive and finite.

use super::{Files, LoadError};
use crate::diagnostic::{Diagnostic, Diagnostics, Place};
use std::path::Path;

/// Required columns, and optional ones.
const NEEDED: [&str; 4] = ["renderer", "spp", "cpu_s", "rmse"];
const WELCOME: [&str; 3] = ["version", "date", "machine"];

/// Maximum number of reported faults, as all lines of an unrelated table are wrong alike.
const MOST_PROBLEMS: usize = 20;

/// Measurement of one picture of another renderer.
#[derive(Clone, Debug, PartialEq)]
pub struct PeerRow {
    /// Name of the renderer, with its version.
    pub renderer: String,
    /// Samples a pixel.
    pub samples: u32,
    /// CPU time without loading, seconds.
    pub cpu_s: f64,
    /// Root mean square error against the converged picture, in its units.
    pub rmse: f64,
}

/// Reads a table: a heading, then a row a measurement; lines with `#` at the start are comments.
pub fn load_peers(path: &Path) -> Result<Vec<PeerRow>, LoadError> {
    let bytes = Files::default().read(path, Some("--peers"))?;
    let mut lines = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(&bytes[..]);
    let mut table = Table { path, headings: csv::StringRecord::new(), problems: Vec::new() };
    match lines.headers() {
        Ok(headings) => table.headings = headings.clone(),
        Err(error) => table.refuse(1, error.to_string(), "text in UTF-8"),
    }
    table.check_headings();
    let mut rows = Vec::new();
    for record in lines.records() {
        if table.problems.len() >= MOST_PROBLEMS {
            break;
        }
        match record {
            Ok(record) => rows.extend(table.row(&record)),
            Err(error) => {
                let line = error.position().map_or(1, csv::Position::line);
                table.refuse(line, error.to_string(), "a row of values separated by commas");
            }
        }
    }
    if table.problems.is_empty() { Ok(rows) } else { Err(LoadError::Invalid(Diagnostics(table.problems))) }
}

/// Table during reading.
struct Table<'a> {
    path: &'a Path,
    headings: csv::StringRecord,
    problems: Vec<Diagnostic>,
}

impl Table<'_> {
    fn refuse(&mut self, line: u64, found: String, expected: &str) {
        let place = Place::Text { file: self.path.to_owned(), line: line as usize, column: 1 };
        let remedy = "correct the line; docs/command-line.md says what a table of peers holds";
        self.problems.push(Diagnostic::error(place, found).expected(expected).remedy(remedy));
    }

    fn check_headings(&mut self) {
        let headings = self.headings.clone();
        for heading in headings.iter().filter(|name| !NEEDED.contains(name) && !WELCOME.contains(name)) {
            let expected = format!("one of {}", [&NEEDED[..], &WELCOME].concat().join(", "));
            self.refuse(1, format!("there is no column `{heading}`"), &expected);
        }
        for missing in NEEDED.into_iter().filter(|name| !headings.iter().any(|heading| heading == *name)) {
            let expected = "a heading with renderer, spp, cpu_s and rmse";
            self.refuse(1, format!("the column `{missing}` is missing"), expected);
        }
    }

    fn row(&mut self, record: &csv::StringRecord) -> Option<PeerRow> {
        let line = record.position().map_or(1, csv::Position::line);
        if record.len() != self.headings.len() {
            let found = format!("{} values below {} headings", record.len(), self.headings.len());
            self.refuse(line, found, "as many values as headings");
            return None;
        }
        let (samples, cpu_s, rmse) = (
            self.positive(record, line, "spp"),
            self.positive(record, line, "cpu_s"),
            self.positive(record, line, "rmse"),
        );
        let [name, version] = ["renderer", "version"].map(|heading| self.value(record, heading));
        Some(PeerRow {
            renderer: format!("{name} {version}").trim_end().to_owned(),
            samples: samples? as u32,
            cpu_s: cpu_s?,
            rmse: rmse?,
        })
    }

    /// Value in the column of a heading; empty if there is none.
    fn value<'r>(&self, record: &'r csv::StringRecord, heading: &str) -> &'r str {
        let column = self.headings.iter().position(|name| name == heading);
        column.and_then(|column| record.get(column)).unwrap_or("")
    }

    fn positive(&mut self, record: &csv::StringRecord, line: u64, heading: &str) -> Option<f64> {
        let value = self.value(record, heading);
        let number = value.parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0);
        if number.is_none() {
            self.refuse(line, format!("{heading} is `{value}`"), "a number above 0");
        }
        number
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn load(text: &str) -> Result<Vec<PeerRow>, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("peers.csv");
        std::fs::write(&path, text).unwrap();
        load_peers(&path).map_err(|error| error.diagnostics().to_string())
    }

    #[test]
    fn columns_stand_in_any_order_and_remarks_are_passed_over() {
        let told = |headings: &str, version: &str| {
            let heading = format!("# measured on a Tuesday\nrmse, renderer, cpu_s, spp{headings}");
            load(&format!("{heading}\n0.05, Some Tracer, 3.5, 16{version}\n")).unwrap()
        };
        let row = |renderer: &str| PeerRow { renderer: renderer.into(), samples: 16, cpu_s: 3.5, rmse: 0.05 };
        assert_eq!(told("", ""), [row("Some Tracer")]);
        assert_eq!(told(", version", ", 1.2"), [row("Some Tracer 1.2")]);
    }

    #[test]
    fn everything_wrong_is_said_at_once_with_its_line() {
        let said = load("renderer,spp,cpu_s,colour\nA,1,-2,red\nB,1\nC,x,1,blue\n").unwrap_err();
        for part in [
            "peers.csv:1:1: error: there is no column `colour`",
            "the column `rmse` is missing",
            "peers.csv:2:1: error: cpu_s is `-2`",
            "peers.csv:3:1: error: 2 values below 4 headings",
            "peers.csv:4:1: error: spp is `x`",
        ] {
            assert!(said.contains(part), "`{part}` is not in\n{said}");
        }
    }

    #[test]
    fn no_table_is_no_table() {
        assert!(load("").unwrap_err().contains("the column `renderer` is missing"));
        assert!(load("\u{0}\u{0}").is_err());
    }
}
