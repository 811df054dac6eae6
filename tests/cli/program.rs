//! Runs the program in a folder of its own.

use crate::checkout;
use std::ffi::{OsStr, OsString};
use std::path::PathBuf;
use std::process::{Command, Output};
use sunfleck::frame_file::{self, FrameFile};
use tempfile::TempDir;

/// A leaf that turns in the sun above the ground, in fog; a camera that keeps still and one that does not.
const SCENE: &str = r#"Scene(
    version: 1,
    meshes: { "leaf": Leaf(length_m: 0.8, width_m: 0.5, curl_deg: 30.0), "ground": Quad(size_m: 8.0) },
    objects: {
        "leaf": (mesh: "leaf", translation_m: (0.0, 1.4, 0.0), rotation_deg: Keyed(
            keys: [(at_s: 0.0, value: (20.0, 0.0, 10.0)), (at_s: 2.0, value: (20.0, 360.0, 10.0))], extend: Cycle)),
        "ground": (mesh: "ground"),
    },
    cameras: {
        "main": (position_m: (0.0, 1.2, 4.5), look_at_m: (0.0, 1.1, 0.0), fov_deg: 40.0),
        "low": (position_m: (0.0, 0.3, 3.0), look_at_m: (0.0, 1.4, 0.0), fov_deg: 60.0),
    },
    lights: { "sun": Sun(to_sun: (0.4, 1.0, -0.6), irradiance_w_per_m2: (8.0, 7.2, 6.0)) },
    fog: { "haze": (min_m: (-4.0, 0.0, -4.0), max_m: (4.0, 3.0, 4.0), density_per_m: 0.15, anisotropy: 0.5) },
)"#;

/// Without light of higher orders, which takes most of the time: tests that look at it say `--bounces all`.
const SEQUENCE: &str = r#"Sequence(
    version: 1, scene: "scene.ron", frames: (1, 12), frame_rate: 24, size: (32, 18), samples: 2, bounces: 0,
)"#;

/// A folder with `scene.ron` and `tiny.ron`, a sequence of twelve frames of 32x18 pixels. Another is
/// for what the program keeps for later: nothing is found there, and nothing is left in the user's.
pub(crate) struct Studio {
    home: TempDir,
}

/// What a command did.
pub(crate) struct Outcome {
    pub(crate) code: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Studio {
    pub(crate) fn new() -> Self {
        let studio = Self { home: tempfile::tempdir().unwrap() };
        std::fs::create_dir(studio.path("")).unwrap();
        std::fs::write(studio.path("scene.ron"), SCENE).unwrap();
        std::fs::write(studio.path("tiny.ron"), SEQUENCE).unwrap();
        studio
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.home.path().join("studio").join(name)
    }

    /// The program, to be run in this folder with the words of `line` as arguments. A word `checkout:FILE` is
    /// that file of the checkout, which may lie anywhere: in a folder with spaces, too.
    pub(crate) fn command(&self, line: &str) -> Command {
        let placed = |word: &str| match word.strip_prefix("checkout:") {
            Some(file) => checkout::file(file).into(),
            None => OsString::from(word),
        };
        let mut command = self.here(checkout::program().as_os_str());
        command.args(line.split_whitespace().map(placed));
        command
    }

    /// A line of the shell, to be run in this folder, where `sunfleck` is the program.
    pub(crate) fn shell(&self, line: &str) -> Command {
        let (program, others) = (checkout::program(), std::env::var_os("PATH").unwrap_or_default());
        let own = program.parent().unwrap().to_owned();
        let path = std::env::join_paths([own].into_iter().chain(std::env::split_paths(&others))).unwrap();
        let mut command = self.here("sh".as_ref());
        command.args(["-c", line]).env("PATH", path);
        command
    }

    fn here(&self, program: &OsStr) -> Command {
        let mut command = Command::new(program);
        command.current_dir(self.path("")).env("XDG_CACHE_HOME", self.home.path().join("caches"));
        command
    }

    pub(crate) fn run(&self, line: &str) -> Outcome {
        outcome(self.command(line).output().unwrap())
    }

    /// Runs a command that is to succeed.
    pub(crate) fn succeed(&self, line: &str) -> Outcome {
        let outcome = self.run(line);
        assert_eq!(outcome.code, 0, "sunfleck {line}\n{}", outcome.err);
        outcome
    }

    /// Runs a command that is to fail with `code`; its message.
    pub(crate) fn fail(&self, line: &str, code: i32) -> String {
        let outcome = self.run(line);
        assert_eq!(outcome.code, code, "sunfleck {line}\n{}", outcome.err);
        outcome.err
    }

    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub(crate) fn frame(&self, name: &str) -> FrameFile {
        frame_file::read(&self.path(name)).unwrap()
    }

    /// Names in a folder, sorted; none if there is no such folder.
    pub(crate) fn names(&self, folder: &str) -> Vec<String> {
        let Ok(entries) = std::fs::read_dir(self.path(folder)) else { return Vec::new() };
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

pub(crate) fn outcome(output: Output) -> Outcome {
    Outcome {
        code: output.status.code().unwrap_or(-1),
        out: String::from_utf8(output.stdout).unwrap(),
        err: String::from_utf8(output.stderr).unwrap(),
    }
}
