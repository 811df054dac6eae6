//! Statistics of frames. In go the events of a run, out come lines of JSON: first one of the input's losses,
//! then one a frame. Invariant: a frame's line is in the file once the frame is on the disk.

use super::CliError;
use super::inspect::losses;
use super::process::peak_memory_bytes;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use sunfleck::diagnostic::{Diagnostics, shown};
use sunfleck::frame_file;
use sunfleck::sequence::Event;

/// File of `--stats`, if it is requested.
pub(super) struct Stats {
    path: PathBuf,
    state: Option<Mutex<State>>,
}

struct State {
    file: File,
    /// Times of frames' stages by key, until the frame's line is written.
    stages: HashMap<i64, Vec<(&'static str, f64)>>,
    problem: Option<std::io::Error>,
}

impl Stats {
    /// Starts a new file with a line of the input's losses; without a path it does nothing.
    pub(super) fn new(path: Option<&Path>, remarks: &Diagnostics) -> Result<Self, CliError> {
        let path = path.map_or_else(PathBuf::new, Path::to_owned);
        let state = match path.as_os_str().is_empty() {
            true => None,
            false => {
                let start = || {
                    let mut file = File::create(&path)?;
                    writeln!(file, "{}", json!({ "losses": losses(remarks) }))?;
                    Ok(file)
                };
                let file = start().map_err(|error| failure(&path, &error))?;
                Some(Mutex::new(State { file, stages: HashMap::new(), problem: None }))
            }
        };
        Ok(Self { path, state })
    }

    /// Stores the time of a frame's stage.
    pub(super) fn took(&self, frame: i64, key: &'static str, time: Duration) {
        if let Some(state) = &self.state {
            let mut state = state.lock().unwrap_or_else(PoisonError::into_inner);
            state.stages.entry(frame).or_default().push((key, time.as_secs_f64()));
        }
    }

    /// Writes a line when a frame is finished. Any thread may call it.
    pub(super) fn report(&self, event: &Event) {
        let Some(state) = &self.state else { return };
        let mut state = state.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(mut line) = line(event) else { return };
        let stages = line["frame"].as_i64().and_then(|frame| state.stages.remove(&frame));
        for (key, seconds) in stages.into_iter().flatten() {
            line[key] = json!(seconds);
        }
        if let Err(error) = writeln!(state.file, "{line}") {
            state.problem.get_or_insert(error);
        }
    }

    /// Fails if any line could not be written.
    pub(super) fn finish(self) -> Result<(), CliError> {
        let state = self.state.map(|state| state.into_inner().unwrap_or_else(PoisonError::into_inner));
        match state.and_then(|state| state.problem) {
            Some(error) => Err(failure(&self.path, &error)),
            None => Ok(()),
        }
    }
}

fn line(event: &Event) -> Option<Value> {
    Some(match event {
        Event::FrameWritten { frame, seconds, write_seconds, clamped, dark, statistics, .. } => {
            let method = if statistics.from_slices { "slices" } else { "rays" };
            json!({
                "frame": frame, "outcome": "written", "render_seconds": seconds, "write_seconds": write_seconds,
                "method": method, "slices": statistics.slices, "segments": statistics.segments,
                "peak_memory_bytes": peak_memory_bytes(), "samples": statistics.samples,
                "rounds": statistics.rounds, "blocks": statistics.blocks,
                "unconverged_blocks": statistics.unconverged_blocks, "error": statistics.error,
                "noise": statistics.noise, "grid_error": statistics.grid_error,
                "endless_light": statistics.endless_light, "clamped": clamped, "dark": dark.is_some(),
            })
        }
        Event::FrameGivenUp { frame, seconds } => {
            json!({ "frame": frame, "outcome": "given up", "render_seconds": seconds })
        }
        Event::FrameSkipped { frame, reason } => {
            json!({ "frame": frame, "outcome": "skipped", "reason": reason.to_string() })
        }
        _ => return None,
    })
}

fn failure(path: &Path, error: &std::io::Error) -> CliError {
    let path = shown(path);
    let (expected, remedy) = match error.kind() {
        std::io::ErrorKind::FileTooLarge => (frame_file::WITHIN_LIMIT, frame_file::RAISE_LIMIT),
        _ => ("a file in a folder that exists", "name another with --stats"),
    };
    CliError::InputOutput(format!(
        "{path}: error: statistics cannot be written: {error}\n  expected: {expected}\n  remedy: {remedy}"
    ))
}
