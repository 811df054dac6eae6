//! Progress of a run. In go events, out come lines for a terminal, a log or a render farm. Invariant:
//! standard output has only lines for programs (`jsonl`, `openjd`); text for people goes to standard error.

use super::words::ProgressArgument;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use signal_hook::consts::SIGTERM;
use std::collections::BTreeMap;
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;
use sunfleck::diagnostic::shown;
use sunfleck::render::Statistics;
use sunfleck::sequence::{Event, Summary};

/// Steps of the bar for each frame, so that it also moves within frames.
const STEPS_PER_FRAME: f64 = 1000.0;
/// Share of a frame before which no time is predicted, as indirect light is solved before the first sample.
const LEAST_BASIS: f64 = 0.05;

/// Prints the reason of a failure on standard output, as Open Job Description expects it.
pub(super) fn fail(reason: &str) {
    let reason = reason.lines().map(str::trim).collect::<Vec<_>>().join("; ");
    // A closed pipe is ignored; standard error has the message as well.
    let _ = writeln!(std::io::stdout(), "openjd_fail: {}", reason.trim_start_matches("error: "));
}

/// Reports a run's progress.
pub(super) struct Progress {
    style: ProgressArgument,
    /// Bar with the remaining time, for terminals.
    bar: Option<ProgressBar>,
    state: Mutex<State>,
    out: Mutex<Box<dyn Write + Send>>,
}

#[derive(Default)]
struct State {
    frames: usize,
    skipped: usize,
    /// Number of frames begun, those in progress included.
    begun: usize,
    /// Fraction done of each frame in progress.
    in_progress: BTreeMap<i64, f64>,
    /// Numbers of frames given up, and of frames on the disk.
    given_up: usize,
    written: usize,
    most_noise: Option<f64>,
    first_begun: Option<Instant>,
    /// Last whole per cent reported, to limit the number of lines.
    percent_told: Option<u64>,
}

impl Progress {
    /// Progress for people on standard error, or for programs on standard output.
    pub(super) fn new(style: ProgressArgument) -> Self {
        match style {
            ProgressArgument::Jsonl | ProgressArgument::Openjd => {
                Self::to(style, Box::new(std::io::stdout()))
            }
            ProgressArgument::Auto if !std::io::stderr().is_terminal() => Self::new(ProgressArgument::Plain),
            _ => Self::to(style, Box::new(std::io::stderr())),
        }
    }

    fn to(style: ProgressArgument, out: Box<dyn Write + Send>) -> Self {
        let bar = (style == ProgressArgument::Auto).then(|| {
            let bar = ProgressBar::new(0);
            match ProgressStyle::with_template("[{bar:30}] {percent:>3} %  {msg}") {
                Ok(bar_style) => bar.with_style(bar_style),
                Err(_) => bar,
            }
        });
        Self { style, bar, state: Mutex::default(), out: Mutex::new(out) }
    }

    /// Reports an event. Any thread may call it.
    pub(super) fn report(&self, event: &Event) {
        // The state is valid even if a thread panicked with the lock.
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.count(event);
        match self.style {
            ProgressArgument::Auto => self.draw(&mut state, event),
            ProgressArgument::Plain => {
                if let Some(line) = state.sentence(event) {
                    self.line(&line);
                }
            }
            ProgressArgument::Jsonl => {
                if !matches!(event, Event::FrameProgress { .. }) || state.percent_is_new() {
                    self.line(&as_json(event).to_string());
                }
            }
            ProgressArgument::Openjd => {
                if state.percent_is_new() {
                    self.line(&format!("openjd_progress: {}", state.percent()));
                }
                if let Some(sentence) = state.sentence(event) {
                    self.line(&format!("openjd_status: {sentence}"));
                }
            }
            ProgressArgument::None => {}
        }
    }

    fn draw(&self, state: &mut State, event: &Event) {
        let Some(bar) = &self.bar else { return };
        match event {
            Event::Started { frames } => bar.set_length((*frames as f64 * STEPS_PER_FRAME) as u64),
            Event::FrameStarted { .. } | Event::FrameProgress { .. } | Event::FrameSkipped { .. } => {
                bar.set_position((state.done() * STEPS_PER_FRAME) as u64);
                let frame = state.skipped + state.begun;
                bar.set_message(format!("frame {frame} of {}{}", state.frames, state.time_left()));
            }
            Event::FrameWritten { clamped: 0, .. } => {}
            Event::FrameWritten { .. }
            | Event::FrameGivenUp { .. }
            | Event::PreviewOmitted { .. }
            | Event::AbandonedRemoved { .. } => {
                if let Some(line) = state.sentence(event) {
                    bar.println(line);
                }
            }
            Event::Finished(_) => {
                bar.finish_and_clear();
                if let Some(line) = state.sentence(event) {
                    self.line(&line);
                }
            }
        }
    }

    fn line(&self, line: &str) {
        let mut out = self.out.lock().unwrap_or_else(PoisonError::into_inner);
        let written = writeln!(out, "{line}").and_then(|()| out.flush());
        // The program that reads, such as a killed Blender, is gone, and nobody else knows of this run.
        if self.is_for_programs() && written.is_err_and(|error| error.kind() == ErrorKind::BrokenPipe) {
            let _ = signal_hook::low_level::raise(SIGTERM);
        }
    }

    fn is_for_programs(&self) -> bool {
        matches!(self.style, ProgressArgument::Jsonl | ProgressArgument::Openjd)
    }
}

impl Drop for Progress {
    /// Removes the bar before a failure is reported.
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

impl State {
    fn count(&mut self, event: &Event) {
        match event {
            Event::Started { frames } => self.frames = *frames,
            Event::FrameSkipped { .. } => self.skipped += 1,
            Event::FrameStarted { frame } => {
                self.begun += 1;
                self.in_progress.insert(*frame, 0.0);
                self.first_begun.get_or_insert_with(Instant::now);
            }
            Event::FrameProgress { frame, progress } => {
                // Threads may report out of order.
                let fraction = self.in_progress.entry(*frame).or_default();
                *fraction = fraction.max(progress.fraction);
            }
            Event::FrameWritten { frame, statistics, .. } => {
                self.written += 1;
                self.in_progress.remove(frame);
                let noises = self.most_noise.into_iter().chain(statistics.noise);
                self.most_noise = noises.reduce(f64::max);
            }
            Event::FrameGivenUp { frame, .. } => {
                self.given_up += 1;
                self.in_progress.remove(frame);
            }
            Event::AbandonedRemoved { .. } | Event::PreviewOmitted { .. } | Event::Finished(_) => {}
        }
    }

    /// Number of frames done, with the fractions of those in progress.
    fn done(&self) -> f64 {
        self.skipped as f64 + self.rendered()
    }

    fn rendered(&self) -> f64 {
        (self.written + self.given_up) as f64 + self.in_progress.values().sum::<f64>()
    }

    fn percent(&self) -> u64 {
        if self.frames == 0 { 100 } else { (100.0 * self.done() / self.frames as f64) as u64 }
    }

    fn percent_is_new(&mut self) -> bool {
        let percent = Some(self.percent());
        std::mem::replace(&mut self.percent_told, percent) != percent
    }

    /// `, about 3 min left`, estimated from the frames rendered so far; empty before there are any, and at
    /// the end. Within the first frame it is an upper bound, as most pixels need fewer samples than the
    /// maximum.
    fn time_left(&self) -> String {
        let is_under_way = self.rendered() >= LEAST_BASIS && self.skipped + self.written < self.frames;
        let Some(first_begun) = self.first_begun.filter(|_| is_under_way) else {
            return String::new();
        };
        let seconds_per_frame = first_begun.elapsed().as_secs_f64() / self.rendered();
        let seconds = seconds_per_frame * (self.frames as f64 - self.done()).max(0.0);
        let bound = if self.rendered() < 1.0 { "at most" } else { "about" };
        format!(", {bound} {} left", duration(seconds))
    }

    fn sentence(&self, event: &Event) -> Option<String> {
        Some(match event {
            Event::FrameSkipped { frame, reason } => format!("frame {frame} skipped: {reason}"),
            Event::PreviewOmitted { frame, reason } => format!("frame {frame} gets no preview: {reason}"),
            Event::FrameGivenUp { frame, seconds } => {
                format!("frame {frame} given up after {seconds:.1} s")
            }
            Event::FrameWritten { frame, path, seconds, clamped, statistics, .. } => {
                let clamping = match clamped {
                    0 => String::new(),
                    _ => format!("; {clamped} values too bright for half precision were clamped to 65504"),
                };
                let count = format!("{} of {} frames", self.skipped + self.written, self.frames);
                let path = shown(path);
                format!(
                    "frame {frame} written to {path} in {seconds:.1} s{} ({count}{}){clamping}",
                    quality(statistics),
                    self.time_left()
                )
            }
            Event::AbandonedRemoved { path } => {
                format!("removed {}, left behind by a run that was killed", shown(path))
            }
            Event::Finished(summary) => match self.most_noise {
                Some(most) if summary.written > 1 => {
                    format!("{summary}; noise up to {} of the mean brightness", percent(most))
                }
                Some(most) => format!("{summary}; noise {} of the mean brightness", percent(most)),
                None => summary.to_string(),
            },
            Event::Started { .. } | Event::FrameStarted { .. } | Event::FrameProgress { .. } => return None,
        })
    }
}

/// Path as text; bytes that are not valid text are escaped, as JSON cannot hold them.
fn text_of(path: &Path) -> String {
    path.to_str().map_or_else(|| shown(path).to_string(), str::to_owned)
}

fn as_json(event: &Event) -> Value {
    match event {
        Event::Started { frames } => json!({ "event": "started", "frames": frames }),
        Event::AbandonedRemoved { path } => {
            json!({ "event": "abandoned_removed", "path": text_of(path) })
        }
        Event::FrameSkipped { frame, reason } => {
            json!({ "event": "frame_skipped", "frame": frame, "reason": reason.to_string() })
        }
        Event::PreviewOmitted { frame, reason } => {
            json!({ "event": "preview_omitted", "frame": frame, "reason": reason })
        }
        Event::FrameStarted { frame } => json!({ "event": "frame_started", "frame": frame }),
        Event::FrameProgress { frame, progress } => json!({
            "event": "frame_progress", "frame": frame, "fraction": progress.fraction, "error": progress.error,
        }),
        Event::FrameGivenUp { frame, seconds } => {
            json!({ "event": "frame_given_up", "frame": frame, "seconds": seconds })
        }
        Event::FrameWritten { frame, path, seconds, clamped, dark, statistics, .. } => json!({
            "event": "frame_written", "frame": frame, "path": text_of(path), "seconds": seconds,
            "clamped": clamped, "error": statistics.error, "noise": statistics.noise,
            "grid_error": statistics.grid_error, "endless_light": statistics.endless_light, "dark": dark.is_some(),
        }),
        Event::Finished(Summary {
            written,
            skipped_valid,
            skipped_existing,
            given_up,
            not_reached,
            seconds,
            folder,
            stopped,
        }) => {
            json!({
                "event": "finished", "written": written, "skipped_valid": skipped_valid,
                "skipped_existing": skipped_existing, "given_up": given_up, "not_reached": not_reached, "seconds": seconds,
                "folder": text_of(folder), "stopped": stopped,
            })
        }
    }
}

/// `, noise 1.8 %`, if it is estimated, and the share of the frame that reached the maximum of samples.
fn quality(statistics: &Statistics) -> String {
    let Statistics { blocks, unconverged_blocks, noise, grid_error, endless_light, .. } = statistics;
    let told = |what: &str, error: Option<f64>| {
        error.map_or_else(String::new, |error| format!(", {what} {}", percent(error)))
    };
    let mut noise = told("noise", *noise) + &told("indirect light within", *grid_error);
    if *endless_light {
        noise += ", darker than it is: surfaces and fog absorb next to none of its light";
    }
    match unconverged_blocks {
        0 => noise,
        _ => {
            let part = percent(*unconverged_blocks as f64 / *blocks as f64);
            format!("{noise}, {part} of the picture noisier than asked for: it had all --samples it may have")
        }
    }
}

/// Percentage for people.
fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

fn duration(seconds: f64) -> String {
    if seconds < 90.0 {
        format!("{seconds:.0} s")
    } else if seconds < 5400.0 {
        format!("{:.0} min", seconds / 60.0)
    } else {
        format!("{:.1} h", seconds / 3600.0)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use std::sync::{Arc, mpsc};
    use sunfleck::render::Progress as RenderProgress;
    use sunfleck::sequence::SkipReason;

    /// Passes on what is written to it.
    struct Wire(mpsc::Sender<Vec<u8>>);

    impl Write for Wire {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0.send(bytes.to_vec()).map_err(|_| std::io::ErrorKind::BrokenPipe)?;
            Ok(bytes.len())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    /// A run of four frames: one skipped, two written, stopped before the last.
    fn lines(style: ProgressArgument) -> Vec<String> {
        let (sender, receiver) = mpsc::channel();
        let progress = Arc::new(Progress::to(style, Box::new(Wire(sender))));
        let mut statistics = Statistics::default();
        (statistics.error, statistics.noise) = (Some(0.3), Some(0.018));
        (statistics.blocks, statistics.unconverged_blocks) = (9, 2);
        let written = |frame| Event::FrameWritten {
            frame,
            path: format!("x.{frame}.exr").into(),
            seconds: 0.5,
            write_seconds: 0.1,
            clamped: 0,
            dark: None,
            statistics,
        };
        for event in [
            Event::Started { frames: 4 },
            Event::FrameSkipped { frame: 1, reason: SkipReason::Valid },
            Event::FrameStarted { frame: 2 },
            Event::FrameProgress { frame: 2, progress: RenderProgress::new(0.5, None) },
            Event::FrameProgress { frame: 2, progress: RenderProgress::new(0.501, Some(0.1)) },
            Event::FrameStarted { frame: 3 },
            written(2),
            written(3),
            Event::Finished(Summary {
                written: 2,
                skipped_valid: 1,
                skipped_existing: 0,
                given_up: Vec::new(),
                not_reached: 1,
                seconds: 1.0,
                folder: "x".into(),
                stopped: true,
            }),
        ] {
            progress.report(&event);
        }
        drop(progress);
        let bytes: Vec<u8> = receiver.into_iter().flatten().collect();
        String::from_utf8(bytes).unwrap().lines().map(str::to_owned).collect()
    }

    #[test]
    fn plain_lines_end_with_the_summary() {
        let lines = lines(ProgressArgument::Plain);
        assert_eq!(lines.len(), 4, "{lines:#?}");
        assert_eq!(lines[0], "frame 1 skipped: there already, and valid");
        let start = "frame 2 written to x.2.exr in 0.5 s, noise 1.8 %, 22.2 % of the picture noisier than asked for: it had all --samples it may have (2 of 4 frames, about ";
        assert!(lines[1].starts_with(start), "{}", lines[1]);
        assert_eq!(
            lines[3],
            "2 frames written to x in 1.0 s; 1 skipped (there already, and valid); stopped with 1 to go; noise up to 1.8 % of the mean brightness"
        );
    }

    #[test]
    fn json_lines_are_json_and_tell_each_per_cent_once() {
        let lines = lines(ProgressArgument::Jsonl);
        let values: Vec<Value> = lines.iter().map(|line| serde_json::from_str(line).unwrap()).collect();
        let events: Vec<&str> = values.iter().map(|value| value["event"].as_str().unwrap()).collect();
        assert_eq!(
            events,
            [
                "started",
                "frame_skipped",
                "frame_started",
                "frame_progress",
                "frame_started",
                "frame_written",
                "frame_written",
                "finished"
            ]
        );
    }

    #[test]
    fn open_job_description_hears_of_whole_per_cents() {
        let lines = lines(ProgressArgument::Openjd);
        let told: Vec<&str> =
            lines.iter().filter_map(|line| line.strip_prefix("openjd_progress: ")).collect();
        assert_eq!(told, ["0", "25", "37", "50", "75"]);
        assert!(lines.iter().any(|line| line.starts_with("openjd_status: frame 3 written")));
    }

    #[test]
    fn none_is_silent() {
        assert_eq!(lines(ProgressArgument::None), [""; 0]);
    }

    #[test]
    fn the_time_left_is_a_bound_within_the_first_frame() {
        let told = |written: usize, fractions: &[f64]| {
            let first_begun = Instant::now().checked_sub(std::time::Duration::from_secs(10));
            let mut state = State { first_begun, ..State::default() };
            (state.frames, state.written) = (4, written);
            state.in_progress = (2..).zip(fractions.iter().copied()).collect();
            state.time_left()
        };
        assert_eq!(told(0, &[0.04]), "");
        assert_eq!(told(0, &[0.5]), ", at most 70 s left");
        assert_eq!(told(1, &[0.0]), ", about 30 s left");
        assert_eq!(told(1, &[0.75, 0.25]), ", about 10 s left");
    }

    #[test]
    fn times_are_told_as_people_do() {
        assert_eq!([12.4, 600.0, 7200.0].map(duration), ["12 s", "10 min", "2.0 h"]);
    }
}
