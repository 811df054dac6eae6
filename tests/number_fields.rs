//! Every number of RON scenes, sequences and glTF files, at its ends and far beyond: each input is rendered or refused with its
//! place, in little time and memory. The files in tests/data/numbers hold what the good files beside them have no room for.
#![allow(clippy::unwrap_used)]

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use rayon::prelude::*;
use serde_json::{Number, Value};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use sunfleck::render::{Job, Method, Watch, render};
use sunfleck::scene::{RenderSettings, Sampling, Size, Window};
use sunfleck::snapshot::{Exposure, MeshTrees, Shutter};
use sunfleck::transport::MarchSteps;
use sunfleck::{description, scene};
use tempfile::TempDir;

/// What takes the place of every number: the ends of what is allowed, the smallest and largest of both precisions.
const NUMBERS: [&str; 9] =
    ["0", "-1", "5e-324", "1e-30", "1e15", "-1e15", "1e30", "3.4028235e38", "1.7976931348623157e308"];

/// And of every whole one: the largest of 32 and 64 bits.
const WHOLE_NUMBERS: [&str; 2] = ["4294967295", "18446744073709551615"];

/// And of every float of a buffer.
const FLOATS: [f32; 10] =
    [-1.0, 1e-30, 1e-45, 1e15, -1e15, 1e30, f32::MAX, f32::MIN, f32::NAN, f32::INFINITY];

/// What takes longer, or lets the whole test grow larger, ends it.
const LONGEST: Duration = Duration::from_secs(20);
const LARGEST_KIB: u64 = 2 << 20;

/// A copy of the good files to put changed ones beside.
struct Bench {
    folder: TempDir,
    /// What is under way, and since when.
    running: Mutex<BTreeMap<usize, (Instant, String)>>,
    is_done: AtomicBool,
}

/// A file of which one number is changed.
struct Case {
    /// Beside which of the good files it lies.
    beside: &'static str,
    /// Which number, and what it is changed to.
    what: String,
    content: Vec<u8>,
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
        Self { folder, running: Mutex::default(), is_done: AtomicBool::new(false) }
    }

    fn assert_all_answered(&self, cases: &[Case]) {
        let complaints: Vec<String> = std::thread::scope(|threads| {
            threads.spawn(|| self.watch());
            let numbered = cases.par_iter().enumerate();
            let complaints = numbered.filter_map(|(number, case)| self.complaint(number, case)).collect();
            self.is_done.store(true, Ordering::Relaxed);
            complaints
        });
        let count = complaints.len();
        assert!(complaints.is_empty(), "{count} of {}:\n{}", cases.len(), complaints.join("\n"));
    }

    /// Ends the test, by name of what is under way, when something takes too long or too much memory.
    fn watch(&self) {
        while !self.is_done.load(Ordering::Relaxed) {
            std::thread::sleep(Duration::from_millis(50));
            let running = self.running.lock().unwrap();
            let is_slow = running.values().any(|(since, _)| since.elapsed() > LONGEST);
            if is_slow || resident_kib() > LARGEST_KIB {
                eprintln!("too slow, or {} KiB are too many: {running:#?}", resident_kib());
                std::process::exit(1);
            }
        }
    }

    /// What is wrong with what becomes of a case, if anything is.
    fn complaint(&self, number: usize, case: &Case) -> Option<String> {
        let beside = self.folder.path().join(case.beside);
        let name = format!("case{number}.{}", beside.extension().unwrap().to_str().unwrap());
        let input = beside.with_file_name(&name);
        std::fs::write(&input, &case.content).unwrap();
        let what = format!("{} {}", case.beside, case.what);
        self.running.lock().unwrap().insert(number, (Instant::now(), what.clone()));
        let answer = std::panic::catch_unwind(|| shown(&input));
        self.running.lock().unwrap().remove(&number);
        std::fs::remove_file(&input).unwrap();
        let wrong = match answer {
            Err(_) => String::from("a panic"),
            Ok(Ok(())) => return None,
            Ok(Err(refusal)) if refusal.contains(&name) && refusal.contains("error: ") => return None,
            Ok(Err(other)) => other,
        };
        Some(format!("{what}: {wrong}"))
    }
}

/// Renders the first frame of a file in all its cameras, by slices or rays as is best, and by marching; or says what is wrong.
fn shown(input: &Path) -> Result<(), String> {
    let description = description::load(input).map_err(|error| error.to_string())?;
    let (scene, settings) = scene::resolve(description, None).map_err(|errors| errors.to_string())?;
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
            method,
        };
        let exposure = Exposure::new(&scene, &trees, camera, 2.0, shutter);
        let frame = render(&exposure, &job, &Watch::NOBODY).frame;
        let defects = frame.check();
        if defects.are_fatal() {
            return Err(format!("{defects:?}"));
        }
    }
    Ok(())
}

/// Memory of this process; 0 where the system does not say.
fn resident_kib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|line| line.trim().trim_end_matches(" kB").parse().ok()).unwrap_or(0)
}

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// Where a RON file has its numbers: not in names, strings and comments.
fn numbers_of_ron(text: &str) -> Vec<Range<usize>> {
    let bytes = text.as_bytes();
    let mut found = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let rest = &bytes[at..];
        let length = |is_within: &dyn Fn(&u8) -> bool| rest.iter().take_while(|byte| is_within(byte)).count();
        at += match rest {
            [b'"', after @ ..] => 2 + after.iter().take_while(|byte| **byte != b'"').count(),
            [b'/', b'/', ..] => length(&|byte| *byte != b'\n'),
            [b'a'..=b'z' | b'A'..=b'Z' | b'_', ..] => {
                length(&|byte| byte.is_ascii_alphanumeric() || *byte == b'_')
            }
            [b'-' | b'0'..=b'9', ..] => {
                let length = length(&|byte| byte.is_ascii_alphanumeric() || b"+-.".contains(byte));
                found.push(at..at + length);
                length
            }
            _ => 1,
        };
    }
    found
}

/// All changes of a RON file's numbers but its version's.
fn cases_of_ron(beside: &'static str) -> Vec<Case> {
    let text = std::fs::read_to_string(data(beside)).unwrap();
    let mut cases = Vec::new();
    for place in numbers_of_ron(&text) {
        let (before, number) = (&text[..place.start], &text[place.clone()]);
        if before.ends_with("version: ") {
            continue;
        }
        let whole = number.parse::<i64>().ok().map(|_| WHOLE_NUMBERS);
        for to in NUMBERS.into_iter().chain(whole.into_iter().flatten()).filter(|to| *to != number) {
            let (line, column) = (before.lines().count(), before.len() - before.rfind('\n').unwrap_or(0));
            let what = format!("{line}:{column}: {number} -> {to}");
            let content = format!("{before}{to}{}", &text[place.end..]).into_bytes();
            cases.push(Case { beside, what, content });
        }
    }
    cases
}

/// JSON pointers to all numbers, but for the version that the file has to say.
fn numbers_of_json(value: &Value, pointer: String, found: &mut Vec<String>) {
    match value {
        Value::Number(_) => found.push(pointer),
        Value::Array(items) => {
            let items = items.iter().enumerate();
            items.for_each(|(index, item)| numbers_of_json(item, format!("{pointer}/{index}"), found));
        }
        Value::Object(fields) => fields.iter().for_each(|(name, field)| {
            numbers_of_json(field, format!("{pointer}/{}", name.replace('/', "~1")), found);
        }),
        _ => {}
    }
}

/// All changes of a glTF file's numbers, in its JSON and in its buffer, that were not made of another file.
fn cases_of_gltf(beside: &'static str, made: &mut BTreeSet<(String, String)>) -> Vec<Case> {
    let json: Value = serde_json::from_slice(&std::fs::read(data(beside)).unwrap()).unwrap();
    let mut cases = Vec::new();
    let mut pointers = Vec::new();
    numbers_of_json(&json, String::new(), &mut pointers);
    for pointer in pointers {
        let number = json.pointer(&pointer).unwrap();
        if !made.insert((pointer.clone(), number.to_string())) {
            continue;
        }
        let whole = number.is_u64().then_some(WHOLE_NUMBERS);
        for to in NUMBERS.into_iter().chain(whole.into_iter().flatten()) {
            let to: Number = serde_json::from_str(to).unwrap();
            let what = format!("{pointer}: {number} -> {to}");
            let mut changed = json.clone();
            *changed.pointer_mut(&pointer).unwrap() = Value::Number(to);
            cases.push(Case { beside, what, content: changed.to_string().into_bytes() });
        }
    }
    cases.extend(cases_of_buffer(beside, &json));
    cases
}

/// The first, the middle and the last float of every accessor.
fn cases_of_buffer(beside: &'static str, json: &Value) -> Vec<Case> {
    const FLOAT: u64 = 5126;
    let at = |value: &Value, field: &str| value.get(field).and_then(Value::as_u64).unwrap_or(0) as usize;
    let uri = json["buffers"][0]["uri"].as_str().unwrap();
    let (head, encoded) = uri.split_once(',').unwrap();
    let bytes = BASE64_STANDARD.decode(encoded).unwrap();
    let mut cases = Vec::new();
    let accessors = json["accessors"].as_array().unwrap().iter().enumerate();
    for (index, accessor) in accessors.filter(|(_, accessor)| accessor["componentType"] == FLOAT) {
        let view = &json["bufferViews"][at(accessor, "bufferView")];
        let (start, floats) = (at(view, "byteOffset"), at(view, "byteLength") / 4);
        for (float, to) in
            [0, floats / 2, floats - 1].into_iter().flat_map(|float| FLOATS.map(|to| (float, to)))
        {
            let mut changed = bytes.clone();
            changed[start + 4 * float..][..4].copy_from_slice(&to.to_le_bytes());
            let mut json = json.clone();
            json["buffers"][0]["uri"] = format!("{head},{}", BASE64_STANDARD.encode(changed)).into();
            let what = format!("float {float} of accessor {index} -> {to:e}");
            cases.push(Case { beside, what, content: json.to_string().into_bytes() });
        }
    }
    cases
}

#[test]
fn every_number_of_ron_is_answered() {
    let cases = [
        cases_of_ron("valid/ron/everything.ron"),
        cases_of_ron("numbers/everything_else.ron"),
        cases_of_ron("numbers/everything_else_shots.ron"),
        cases_of_ron("numbers/march.ron"),
    ];
    let cases: Vec<Case> = cases.into_iter().flatten().collect();
    assert!(cases.len() > 3000, "{}", cases.len());
    Bench::new().assert_all_answered(&cases);
}

#[test]
fn every_number_of_gltf_is_answered() {
    let mut made = BTreeSet::new();
    let files = ["numbers/everything.gltf", "numbers/orthographic.gltf", "numbers/coats.gltf"];
    let cases: Vec<Case> = files.into_iter().flat_map(|file| cases_of_gltf(file, &mut made)).collect();
    assert!(cases.len() > 3000, "{}", cases.len());
    Bench::new().assert_all_answered(&cases);
}
