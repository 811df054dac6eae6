//! Loading of scenes, with a progress bar for falls and a folder that caches them. In goes an input, out
//! comes a scene. Invariant: it does not depend on the folder's contents or existence.

use super::CliError;
use super::arguments::{BakeArguments, SceneArguments};
use super::error::usage;
use super::parse::SizeArgument;
use super::saving::clear_folder;
use indicatif::{ProgressBar, ProgressStyle};
use std::collections::HashMap;
use std::env;
use std::fs::{self, DirEntry};
use std::io::{BufReader, IsTerminal as _, Read};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::SystemTime;
use sunfleck::api::Scene;
use sunfleck::description::{Description, open_regular};
use sunfleck::diagnostic::{readable, shown};
use sunfleck::frame_file;
use sunfleck::scene::{Baking, ResolveOptions};

/// Maximum bytes in the folder, before the oldest files are removed.
const MOST_BYTES: u64 = 4 << 30;
/// Minimum number of leaves for a progress bar.
const FEWEST: u32 = 1000;
const EXTENSION: &str = "bake";

/// Scene from a camera, by its name or the first, in a size.
pub(super) fn seen(
    description: Description,
    scene: &SceneArguments,
    size: Option<SizeArgument>,
    camera: Option<&String>,
    shows_progress: bool,
) -> Result<Scene, CliError> {
    resolve(description, &scene.seen(size, camera), &scene.bakes, shows_progress)
}

/// Resolves an input on the current rayon pool.
pub(super) fn resolve(
    description: Description,
    options: &ResolveOptions,
    bakes: &BakeArguments,
    shows_progress: bool,
) -> Result<Scene, CliError> {
    let animation = options.animation.as_deref();
    description.check_animation(animation).map_err(|names| {
        usage("--animation", format!("there is no animation `{}`", animation.unwrap_or_default()), &names)
    })?;
    let folder = match bakes.bake_cache.as_deref() {
        None => user_folder(),
        Some(folder) if folder == Path::new("off") => None,
        Some(folder) => Some(folder.to_owned()),
    };
    let path = |name: &str| folder.as_ref().map(|folder| folder.join(name).with_extension(EXTENSION));
    let bar = OnceLock::new();
    let shown = shows_progress && std::io::stderr().is_terminal();
    let tell = |done: u32, of: u32| {
        if shown && of >= FEWEST {
            let bar: &ProgressBar = bar.get_or_init(new_bar);
            bar.set_length(u64::from(of));
            bar.set_position(u64::from(done));
        }
    };
    let recall = |name: &str| {
        let path = path(name)?;
        let bake = open_regular(&path).ok()?;
        // Marks the file as used, as the oldest are removed first.
        let _ = fs::File::options()
            .append(true)
            .open(&path)
            .and_then(|file| file.set_modified(SystemTime::now()));
        Some(Box::new(BufReader::new(bake)) as Box<dyn Read>)
    };
    let keep = |name: &str, parts: &[&[u8]]| {
        let (Some(folder), Some(path)) = (&folder, path(name)) else { return };
        clear_folder(folder, is_bake);
        make_room(folder, parts.iter().map(|part| part.len() as u64).sum());
        let _ = frame_file::write_whole(&path, parts);
    };
    let scene = Scene::resolve(description, options, &Baking { tell: &tell, recall: &recall, keep: &keep });
    if let Some(bar) = bar.get() {
        bar.finish_and_clear();
    }
    Ok(scene?)
}

/// Refuses outputs that would overwrite the input's files.
pub(super) fn check_not_read<P: AsRef<Path>>(
    flag: &str,
    outputs: impl IntoIterator<Item = P>,
    inputs: &[PathBuf],
) -> Result<(), CliError> {
    let inputs: HashMap<PathBuf, &PathBuf> =
        inputs.iter().filter_map(|input| Some((input.canonicalize().ok()?, input))).collect();
    let read = |output: P| inputs.get(&output.as_ref().canonicalize().ok()?).copied();
    match outputs.into_iter().find_map(read) {
        None => Ok(()),
        Some(input) => Err(usage(
            flag,
            format!("{} is read by this very command, and would be lost", shown(&readable(input))),
            "a file of another name",
        )),
    }
}

fn new_bar() -> ProgressBar {
    let bar = ProgressBar::new(0);
    match ProgressStyle::with_template("[{bar:30}] {percent:>3} %  {pos} of {len} leaves have fallen") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

fn user_folder() -> Option<PathBuf> {
    let variable = |name: &str| env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let caches = if cfg!(windows) {
        variable("LOCALAPPDATA")
    } else if cfg!(target_os = "macos") {
        variable("HOME").map(|home| home.join("Library/Caches"))
    } else {
        variable("XDG_CACHE_HOME").or_else(|| variable("HOME").map(|home| home.join(".cache")))
    };
    caches.map(|caches| caches.join("sunfleck"))
}

/// Whether a name is that of a bake.
fn is_bake(name: &[u8]) -> bool {
    name.strip_suffix(EXTENSION.as_bytes()).is_some_and(|stem| stem.ends_with(b"."))
}

/// Removes the least recently used bakes until there is room for `bytes`. Bakes that other processes are
/// writing count too.
fn make_room(folder: &Path, bytes: u64) {
    let entries = || fs::read_dir(folder).into_iter().flatten().filter_map(Result::ok);
    let bake = |entry: &DirEntry| is_bake(entry.file_name().as_encoded_bytes());
    let unfinished =
        |entry: &DirEntry| frame_file::final_name(entry.file_name().as_encoded_bytes()).is_some_and(is_bake);
    let size = |entry: DirEntry| entry.metadata().map_or(0, |metadata| metadata.len());
    let age = |entry: DirEntry| {
        let metadata = entry.metadata().ok()?;
        Some((metadata.modified().ok()?, metadata.len(), entry.path()))
    };
    let mut bakes: Vec<_> = entries().filter(bake).filter_map(age).collect();
    bakes.sort();
    let others: u64 = entries().filter(unfinished).map(size).sum();
    let mut held = bytes + others + bakes.iter().map(|(_, bytes, _)| bytes).sum::<u64>();
    for (_, bytes, path) in bakes {
        if held <= MOST_BYTES {
            return;
        }
        if fs::remove_file(path).is_ok() {
            held -= bytes;
        }
    }
}
