//! How long large glTF files take to be read and resolved, and how much memory: many animated nodes, and one
//! mesh of many triangles. Each file is written here first, plain.

use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;
use sunfleck::{description, scene};

const NODES: usize = 20_000;
const KEYS: usize = 48;
/// Quads a side; two triangles each.
const SIDE: usize = 707;

/// Prints both, the fastest of some rounds.
pub fn run(rounds: usize) {
    let folder = tempfile::tempdir().expect("a folder");
    let files = [
        (format!("{NODES} nodes with {KEYS} keys of place and turn each"), animated_nodes(folder.path())),
        (format!("{} triangles in one mesh", 2 * SIDE * SIDE), one_mesh(folder.path())),
    ];
    println!("{:<52} {:>9} {:>9} {:>10}", "glTF file", "MB", "s", "peak MB");
    for (what, path) in files {
        let megabytes = path.metadata().expect("a file").len() as f64 / 1e6;
        let this = std::env::current_exe().expect("this program");
        // Each time in a process of its own: memory that one has given back may stay with it.
        let runs: Vec<(f64, Option<f64>)> = (0..rounds.max(1))
            .map(|_| {
                let output = Command::new(&this).arg("read").arg(&path).output().expect("this program runs");
                let text = String::from_utf8(output.stdout).expect("two numbers");
                let mut numbers = text.split_whitespace().map(|number| number.parse().ok());
                (numbers.next().flatten().expect("seconds"), numbers.next().flatten())
            })
            .collect();
        let seconds = runs.iter().map(|run| run.0).fold(f64::INFINITY, f64::min);
        let peak = runs[0].1.map_or(String::from("unknown"), |peak| format!("{peak:.0}"));
        println!("{what:<52} {megabytes:>9.1} {seconds:>9.2} {peak:>10}");
    }
}

/// Reads and resolves a file, and prints the seconds that it took and the process's peak memory in megabytes.
pub fn read(path: &Path) {
    let started = Instant::now();
    let description = description::load(path).expect("a good file");
    let (scene, _) = scene::resolve(description, None).expect("a good scene");
    let seconds = started.elapsed().as_secs_f64();
    println!("{seconds} {}", peak_memory_mb().map_or(String::new(), |peak| peak.to_string()));
    drop(scene);
}

/// A binary glTF file in the making.
#[derive(Default)]
struct Glb {
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Glb {
    fn accessor(&mut self, bytes: &[u8], component: u32, shape: &str, count: usize) -> usize {
        self.views.push(json!({ "buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len() }));
        self.binary.extend(bytes);
        let view = self.views.len() - 1;
        self.accessors
            .push(json!({ "bufferView": view, "componentType": component, "count": count, "type": shape }));
        view
    }

    fn floats(&mut self, numbers: &[f32], shape: &str, count: usize) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        self.accessor(&bytes, 5126, shape, count)
    }

    fn write(self, path: PathBuf, mut document: Value) -> PathBuf {
        document["asset"] = json!({ "version": "2.0" });
        document["buffers"] = json!([{ "byteLength": self.binary.len() }]);
        document["bufferViews"] = self.views.into();
        document["accessors"] = self.accessors.into();
        let mut text = document.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let chunk =
            |kind: &[u8; 4], data: &[u8]| [&(data.len() as u32).to_le_bytes()[..], kind, data].concat();
        let chunks = [chunk(b"JSON", &text), chunk(b"BIN\0", &self.binary)].concat();
        let length = (12 + chunks.len() as u32).to_le_bytes();
        std::fs::write(&path, [&b"glTF\x02\0\0\0"[..], &length, &chunks].concat()).expect("a file");
        path
    }
}

fn animated_nodes(folder: &Path) -> PathBuf {
    let mut glb = Glb::default();
    let times: Vec<f32> = (0..KEYS).map(|key| key as f32 / 24.0).collect();
    let input = glb.floats(&times, "SCALAR", KEYS);
    let corner = glb.floats(&[0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.1, 0.0], "VEC3", 3);
    let (mut nodes, mut channels, mut samplers) = (Vec::new(), Vec::new(), Vec::new());
    for node in 0..NODES {
        nodes.push(json!({ "name": format!("leaf {node}"), "mesh": 0 }));
        let phase = |key: usize| 0.01 * node as f32 + 0.2 * key as f32;
        let places: Vec<f32> = (0..KEYS).flat_map(|key| [phase(key), phase(key).sin(), -5.0]).collect();
        let turns: Vec<f32> =
            (0..KEYS).flat_map(|key| [phase(key).sin(), 0.0, 0.0, phase(key).cos()]).collect();
        for (path, output) in [
            ("translation", glb.floats(&places, "VEC3", KEYS)),
            ("rotation", glb.floats(&turns, "VEC4", KEYS)),
        ] {
            channels.push(json!({ "sampler": samplers.len(), "target": { "node": node, "path": path } }));
            samplers.push(json!({ "input": input, "output": output }));
        }
    }
    let document = json!({
        "nodes": nodes,
        "scenes": [{ "nodes": (0..NODES).collect::<Vec<_>>() }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": corner } }] }],
        "animations": [{ "channels": channels, "samplers": samplers }],
    });
    glb.write(folder.join("nodes.glb"), document)
}

fn one_mesh(folder: &Path) -> PathBuf {
    let mut glb = Glb::default();
    let row = SIDE + 1;
    let places: Vec<f32> = (0..row * row)
        .flat_map(|vertex| {
            let (x, z) = ((vertex % row) as f32 / SIDE as f32, (vertex / row) as f32 / SIDE as f32);
            [x, 0.05 * (20.0 * x).sin() * (20.0 * z).cos(), z]
        })
        .collect();
    let indices: Vec<u8> = (0..SIDE * SIDE)
        .flat_map(|quad| {
            let corner = (quad / SIDE * row + quad % SIDE) as u32;
            let below = corner + row as u32;
            [corner, below, corner + 1, corner + 1, below, below + 1]
        })
        .flat_map(u32::to_le_bytes)
        .collect();
    let positions = glb.floats(&places, "VEC3", row * row);
    let indices = glb.accessor(&indices, 5125, "SCALAR", 6 * SIDE * SIDE);
    let document = json!({
        "nodes": [{ "mesh": 0 }],
        "scenes": [{ "nodes": [0] }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": positions }, "indices": indices }] }],
    });
    glb.write(folder.join("mesh.glb"), document)
}

/// `VmHWM` (proc(5)), where there is such a thing.
fn peak_memory_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.split_whitespace().next()?.parse::<f64>().ok()? * 1024.0 / 1e6)
}
