//! Command `serve`: pictures of a loaded scene on request. In go requests on standard input, a line each; out
//! come events, as of `render --progress jsonl`, and an answer to each request. Invariant: every request is
//! answered once and in order; a newer one cancels the current one.
//!
//! Trees, textures and indirect light are kept while only the camera changes.

use super::arguments::{Arguments, Command, ProgressArgument, RenderArguments, ServeArguments};
use super::signals::Stop;
use super::{CliError, answer, loading, render, threads};
use clap::Parser as _;
use rayon::ThreadPool;
use serde::Deserialize;
use serde_json::{Value, json};
use std::io::BufRead as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use sunfleck::api::{Scene, VIEWER, Viewer};
use sunfleck::description;

/// Request: one line of standard input.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Request {
    /// Returned with the answer.
    #[serde(default)]
    id: Value,
    /// Flags of `render`; without them the request only cancels the current one.
    #[serde(default)]
    render: Option<Vec<String>>,
    /// Camera, unless it is one of the scene's.
    #[serde(default)]
    camera: Option<Viewer>,
}

/// State shared by the reading and the rendering thread.
#[derive(Default)]
struct Desk {
    /// Number of unanswered requests.
    waiting: usize,
    /// Cancels the current request.
    stop: Arc<AtomicBool>,
    is_closed: bool,
}

impl Desk {
    /// Changes the state, and cancels the current request if newer ones are waiting.
    fn change(desk: &Mutex<Self>, change: impl FnOnce(&mut Self)) {
        let mut desk = desk.lock().unwrap_or_else(PoisonError::into_inner);
        change(&mut desk);
        if desk.waiting > 1 || desk.is_closed {
            desk.stop.store(true, Ordering::Relaxed);
        }
    }
}

/// Server of a loaded scene.
struct Server<'a> {
    arguments: &'a ServeArguments,
    scene: Scene,
    pool: ThreadPool,
}

pub(super) fn run(arguments: &ServeArguments) -> Result<(), CliError> {
    let pool = threads::pool(arguments.threads)?;
    let scene = pool.install(|| {
        let description = description::load(&arguments.input)?;
        loading::seen(description, &arguments.scene, arguments.size, arguments.camera.as_ref(), false)
    })?;
    let mut server = Server { arguments, scene, pool };
    let desk = Arc::new(Mutex::new(Desk::default()));
    let lines = listen(&desk)?;
    answer(&json!({ "event": "ready" }).to_string())?;
    for line in lines {
        let stop = Stop::default();
        Desk::change(&desk, |desk| desk.stop = Arc::clone(&stop.flag));
        let answered = server.answer(&line, &stop);
        Desk::change(&desk, |desk| desk.waiting -= 1);
        answer(&answered.to_string())?;
    }
    Ok(())
}

/// Reads requests on a thread of its own.
fn listen(desk: &Arc<Mutex<Desk>>) -> Result<Receiver<String>, CliError> {
    let (to_server, from_client) = channel();
    let desk = Arc::clone(desk);
    let read = move || read(&desk, &to_server);
    let failure = |error| CliError::InputOutput(format!("error: requests cannot be read: {error}"));
    thread::Builder::new().spawn(read).map_err(failure)?;
    Ok(from_client)
}

/// Reads requests until the stream ends, or the server is gone.
fn read(desk: &Mutex<Desk>, to_server: &Sender<String>) {
    for line in std::io::stdin().lock().split(b'\n').map_while(Result::ok) {
        // Invalid text gets an answer as an invalid request.
        let line = String::from_utf8_lossy(&line).into_owned();
        if line.trim().is_empty() {
            continue;
        }
        Desk::change(desk, |desk| desk.waiting += 1);
        if to_server.send(line).is_err() {
            return;
        }
    }
    Desk::change(desk, |desk| desk.is_closed = true);
}

impl Server<'_> {
    fn answer(&mut self, line: &str, stop: &Stop) -> Value {
        let refused = |id: &Value, error| answered(id, "refused", &format!("no request: {error}"));
        let request: Value = match serde_json::from_str(line) {
            Ok(request) => request,
            Err(error) => return refused(&Value::Null, error),
        };
        let request = match Request::deserialize(&request) {
            Ok(request) => request,
            Err(error) => return refused(request.get("id").unwrap_or(&Value::Null), error),
        };
        let Request { id, render, camera } = request;
        let Some(flags) = render else { return answered(&id, "ended", "") };
        let outcome = self.arguments_of(&flags, camera.as_ref()).and_then(|arguments| {
            self.scene.look_from(camera.as_ref());
            render::of_scene(&arguments, &self.scene, &self.pool, stop).map_err(|error| error.to_string())
        });
        match outcome {
            _ if stop.flag.load(Ordering::Relaxed) => answered(&id, "ended", ""),
            Ok(()) => answered(&id, "rendered", ""),
            Err(error) => answered(&id, "refused", &error),
        }
    }

    /// Arguments of `render`, which may concern only the picture, and not the scene.
    fn arguments_of(&self, flags: &[String], camera: Option<&Viewer>) -> Result<RenderArguments, String> {
        let input = self.arguments.input.as_os_str();
        let line = ["sunfleck", "render"].map(Into::into).into_iter().chain([input.to_owned()]);
        let line = line.chain(flags.iter().map(Into::into));
        let parsed = Arguments::try_parse_from(line).map_err(|error| error.to_string())?;
        let Command::Render(mut arguments) = parsed.command else {
            return Err(String::from("`render` has flags of the command of that name"));
        };
        let plain = Arguments::try_parse_from(["sunfleck", "render", "input"]).map(|plain| plain.command);
        let is_plain = matches!(&plain, Ok(Command::Render(plain))
            if plain.scene == arguments.scene);
        if !is_plain || arguments.threads.is_some() {
            return Err(String::from("flags of the scene and --threads are said to `serve` itself"));
        }
        let is_told = matches!(arguments.progress, ProgressArgument::Auto | ProgressArgument::Jsonl);
        if arguments.dry_run || !is_told {
            return Err(String::from("--dry-run and other --progress than jsonl are no requests"));
        }
        if let Some(camera) = camera {
            if let Some(fault) = camera.fault() {
                return Err(format!("camera: {fault}"));
            }
            arguments.camera = Some(VIEWER.into());
        }
        arguments.progress = ProgressArgument::Jsonl;
        arguments.scene = self.arguments.scene.clone();
        Ok(arguments)
    }
}

fn answered(id: &Value, outcome: &str, error: &str) -> Value {
    let mut said = json!({ "event": "answered", "id": id, "outcome": outcome });
    if !error.is_empty() {
        said["error"] = error.into();
    }
    said
}
