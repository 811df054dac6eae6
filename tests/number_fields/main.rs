//! Every number of RON scenes, sequences and glTF files, at its ends and far beyond. Each input is rendered
//! or refused with its place, in little time and memory. The files in tests/data/numbers hold what the good
//! files beside them have no room for.
#![allow(clippy::unwrap_used)]

#[path = "../checkout/mod.rs"]
mod checkout;
mod fields;

use fields::{Field, data, of_gltf, of_ron};
use rayon::ThreadPoolBuilder;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::num::NonZero;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};
use sunfleck::description::LoadError;
use sunfleck::diagnostic::{Diagnostic, Diagnostics, Place, Severity};
use sunfleck::render::{Job, Method, Watch, render};
use sunfleck::scene::{RenderSettings, Sampling, Size, Window};
use sunfleck::snapshot::{Exposure, MeshTrees, Shutter};
use sunfleck::transport::MarchSteps;
use sunfleck::{description, scene};
use tempfile::TempDir;

/// What takes longer, or lets the whole test grow larger, ends it.
const LONGEST: Duration = Duration::from_secs(20);
const LARGEST_KIB: u64 = 2 << 20;

/// What takes longer is said, for whoever makes the test faster.
const WORTH_SAYING: Duration = Duration::from_secs(1);

/// A copy of the good files to put changed ones beside. What ends the process leaves the changed file there.
struct Bench {
    folder: TempDir,
    /// What is under way, by file, and since when.
    running: Mutex<BTreeMap<String, (Instant, String)>>,
    cases: AtomicUsize,
    is_done: AtomicBool,
}

/// What becomes of an input.
enum Answer {
    Picture,
    Refusal(Diagnostics),
    /// A picture that none should get, or a file that cannot be read.
    Wrong(String),
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        for name in ["valid/ron", "valid/obj", "numbers"] {
            let to = folder.path().join(name);
            std::fs::create_dir_all(&to).unwrap();
            for file in std::fs::read_dir(data(name)).unwrap().map(|entry| entry.unwrap().path()) {
                std::fs::copy(&file, to.join(file.file_name().unwrap())).unwrap();
            }
        }
        Self {
            folder,
            running: Mutex::default(),
            cases: AtomicUsize::new(0),
            is_done: AtomicBool::new(false),
        }
    }

    /// Every thread takes one field after the other, and renders alone: what is slow is told from what waits.
    /// How many files were tried.
    fn assert_all_answered(&self, fields: &[Field]) -> usize {
        let since = Instant::now();
        let next = AtomicUsize::new(0);
        let complaints = Mutex::new(Vec::new());
        let work = || {
            let alone = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
            while let Some(field) = fields.get(next.fetch_add(1, Ordering::Relaxed)) {
                let found = alone.install(|| self.complaints(field));
                complaints.lock().unwrap().extend(found);
            }
        };
        std::thread::scope(|threads| {
            threads.spawn(|| self.watch());
            let threads: Vec<_> = (0..cores()).map(|_| threads.spawn(work)).collect();
            threads.into_iter().for_each(|thread| thread.join().unwrap());
            self.is_done.store(true, Ordering::Relaxed);
        });
        let (cases, complaints) = (self.cases.load(Ordering::Relaxed), complaints.into_inner().unwrap());
        say(&format!("{} numbers, {cases} files: {:.1} s", fields.len(), since.elapsed().as_secs_f64()));
        assert!(complaints.is_empty(), "{} of {cases}:\n{}", complaints.len(), complaints.join("\n"));
        cases
    }

    /// Ends the test, by name of what is under way, when something takes too long or too much memory.
    fn watch(&self) {
        while !self.is_done.load(Ordering::Relaxed) {
            std::thread::sleep(Duration::from_millis(50));
            let running = self.running.lock().unwrap();
            let is_slow = running.values().any(|(since, _)| since.elapsed() > LONGEST);
            if is_slow || resident_kib() > LARGEST_KIB {
                say(&format!("too slow, or {} KiB are too many: {running:#?}", resident_kib()));
                std::process::exit(1);
            }
        }
    }

    /// What is wrong with what becomes of a field's numbers, and of the ends of its range that refusals name.
    fn complaints(&self, field: &Field) -> Vec<String> {
        let mut complaints = Vec::new();
        let mut ends = BTreeSet::new();
        for number in &field.numbers {
            match self.answer(field, number) {
                Ok(_) if field.is_count => {}
                Ok(expected) => ends.extend(ends_named_in(&expected, field)),
                Err(complaint) => complaints.push(complaint),
            }
        }
        complaints.extend(ends.into_iter().filter_map(|end| self.answer(field, &end).err()));
        complaints
    }

    /// What the refusal expects instead, if a number is refused; or what is wrong with what becomes of it.
    fn answer(&self, field: &Field, number: &str) -> Result<String, String> {
        let beside = self.folder.path().join(field.file);
        let case = self.cases.fetch_add(1, Ordering::Relaxed);
        let name = format!("case{case}.{}", beside.extension().unwrap().to_str().unwrap());
        let input = beside.with_file_name(&name);
        std::fs::write(&input, (field.file_with)(number)).unwrap();
        let what = format!("{} {} -> {number}", field.file, field.name);
        self.running.lock().unwrap().insert(name.clone(), (Instant::now(), what.clone()));
        let answer = std::panic::catch_unwind(|| shown(&input));
        let (since, _) = self.running.lock().unwrap().remove(&name).unwrap();
        if since.elapsed() > WORTH_SAYING {
            say(&format!("{what}: {:.1} s", since.elapsed().as_secs_f64()));
        }
        std::fs::remove_file(&input).unwrap();
        let wrong = match answer {
            Ok(Answer::Picture) => return Ok(String::new()),
            Ok(Answer::Refusal(errors))
                if errors.has_errors() && errors.0.iter().all(|error| is_helpful(error, &input)) =>
            {
                return Ok(errors.0.iter().filter_map(|error| error.expected.as_deref()).collect());
            }
            Ok(Answer::Refusal(errors)) => errors.to_string(),
            Ok(Answer::Wrong(wrong)) => wrong,
            Err(_) => String::from("a panic"),
        };
        let complaint = format!("{what}: {wrong}");
        say(&complaint);
        Err(complaint)
    }
}

/// Whether an error, if it is one, tells where in the file the number is, what belongs there
/// and how to get there.
fn is_helpful(error: &Diagnostic, input: &Path) -> bool {
    let is_placed = match &error.place {
        Place::Text { file, .. } | Place::Field { file, .. } => file.file_name() == input.file_name(),
        _ => false,
    };
    error.severity != Severity::Error || is_placed && error.expected.is_some() && error.remedy.is_some()
}

/// The numbers in what a refusal expects, such as `a number from 0 to 1`, and their neighbours on either
/// side; but not those that are tried in any case.
fn ends_named_in(expected: &str, field: &Field) -> Vec<String> {
    let words = expected.split(|c: char| !c.is_ascii_alphanumeric() && !"+-.".contains(c));
    let ends = words.filter(|word| word.starts_with(|c: char| c == '-' || c.is_ascii_digit()));
    let ends = ends.filter_map(|word| word.trim_end_matches('.').parse::<f64>().ok());
    let is_new = |end: &f64| !field.numbers.iter().any(|number| number.parse() == Ok(*end));
    ends.filter(is_new)
        .flat_map(|end| match field.is_whole {
            true => vec![format!("{end}")],
            false => [end.next_down(), end, end.next_up()].map(|end| format!("{end:e}")).to_vec(),
        })
        .collect()
}

/// Renders the first frame of a file in all its cameras, by slices or rays as is best, and by marching.
fn shown(input: &Path) -> Answer {
    let description = match description::load(input) {
        Ok(description) => description,
        Err(LoadError::Invalid(errors)) => return Answer::Refusal(errors),
        Err(error) => return Answer::Wrong(error.to_string()),
    };
    let (scene, settings) = match scene::resolve(description, None) {
        Ok(resolved) => resolved,
        Err(errors) => return Answer::Refusal(errors),
    };
    let size = Size { width: 4, height: 2 };
    let trees = MeshTrees::new(&scene);
    let shutter = Shutter::of(&settings, *settings.frames.start() as f64);
    let RenderSettings { march_depth_m: depth_m, march_step_m: step_m, .. } = settings;
    let mut methods = vec![Method::Auto];
    if step_m != RenderSettings::default().march_step_m {
        methods.push(Method::March(MarchSteps::Planes { depth_m, step_m }));
    }
    let cameras = 0..scene.cameras.len();
    for (method, camera) in
        methods.into_iter().flat_map(|method| cameras.clone().map(move |camera| (method, camera)))
    {
        let job = Job {
            size,
            window: Window::whole(size),
            passes: settings.passes.clone(),
            sampling: Sampling::Exactly(1),
            filter: settings.filter,
            seed: settings.seed,
            mirror_depth: settings.mirror_depth,
            bounces: sunfleck::scene::Bounces::NONE,
            method,
        };
        let exposure = Exposure::new(&scene, &trees, camera, 2.0, shutter);
        let defects = render(&exposure, &job, &Watch::NOBODY).frame.check();
        if defects.are_fatal() {
            return Answer::Wrong(format!("{defects:?}"));
        }
    }
    Answer::Picture
}

/// At once, past what keeps the output of tests that pass: the process may end.
fn say(what: &str) {
    let mut errors = std::io::stderr();
    writeln!(errors, "{what}").unwrap();
}

fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, NonZero::get)
}

/// Memory of this process; 0 where the system does not say.
fn resident_kib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|line| line.trim().trim_end_matches(" kB").parse().ok()).unwrap_or(0)
}

#[test]
fn every_number_of_ron_is_answered() {
    let files = ["valid/ron/everything.ron", "numbers/everything_else.ron", "numbers/sun.ron"];
    let shots = ["numbers/mist.ron", "numbers/everything_else_shots.ron", "numbers/march.ron"];
    let fields: Vec<Field> = files.into_iter().chain(shots).flat_map(of_ron).collect();
    let cases = Bench::new().assert_all_answered(&fields);
    assert!(fields.len() >= 360 && cases >= 3700, "{} {cases}", fields.len());
}

#[test]
fn every_number_of_gltf_is_answered() {
    let mut seen = BTreeSet::new();
    let files = ["numbers/everything.gltf", "numbers/orthographic.gltf", "numbers/coats.gltf"];
    let fields: Vec<Field> = files.into_iter().flat_map(|file| of_gltf(file, &mut seen)).collect();
    let cases = Bench::new().assert_all_answered(&fields);
    assert!(fields.len() >= 450 && cases >= 5100, "{} {cases}", fields.len());
}
