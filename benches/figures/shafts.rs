//! What a sample costs: the ray, the light on its surface, and the shafts by each method. How far each method
//! is from the exact one on the same rays. One thread, pixel centres.

use crate::inputs::{self, Named};
use std::time::Instant;
use sunfleck::math::Sampler;
use sunfleck::scene::Scene;
use sunfleck::snapshot::{MeshTrees, Shutter, Snapshot};
use sunfleck::transport::{MarchSteps, Scratch, Transport, VolumeMethod, radiance};

const WIDTH: usize = 480;
const HEIGHT: usize = 270;

/// Prints a table for each scene; the methods take turns, and the median of `rounds` counts.
pub fn run(rounds: usize) {
    for Named { name, scene } in inputs::reference_scenes() {
        table(&name, &scene, rounds);
    }
}

fn table(name: &str, scene: &Scene, rounds: usize) {
    let mut clear = scene.clone();
    clear.fogs.clear();
    let trees = MeshTrees::new(scene);
    let instant = Shutter { open_s: 0.0, close_s: 0.0 };
    let aspect = WIDTH as f64 / HEIGHT as f64;
    let foggy = Snapshot::new(scene, &trees, 0, aspect, instant);
    let clear = Snapshot::new(&clear, &trees, 0, aspect, instant);
    let steps = |count| VolumeMethod::March(MarchSteps::Count(count));
    let methods = [
        ("segments", VolumeMethod::Segments),
        ("march 16", steps(16)),
        ("march 64", steps(64)),
        ("march 256", steps(256)),
        ("equiangular 16", VolumeMethod::Equiangular { points: 16 }),
    ];
    let mut primary_s = vec![];
    let mut surface_s = vec![];
    let mut method_s = vec![vec![]; methods.len()];
    let mut shafts = vec![vec![]; methods.len()];
    // The stepped methods need no more pixels than the clock does.
    let stride = if scene.instances.len() > 1000 { 8 } else { 2 };
    for _ in 0..rounds {
        primary_s.push(seconds(stride, |x, y| {
            let ray = foggy.view.ray(x, y);
            std::hint::black_box(foggy.tree.nearest_hit(&ray, f64::INFINITY, None));
        }));
        surface_s.push(render(&clear, VolumeMethod::Segments, stride, &mut vec![]));
        for (index, (_, method)) in methods.iter().enumerate() {
            shafts[index].clear();
            method_s[index].push(render(&foggy, *method, stride, &mut shafts[index]));
        }
    }
    let rays = (WIDTH.div_ceil(stride) * HEIGHT.div_ceil(stride)) as f64;
    let (primary, surface) = (median(&mut primary_s), median(&mut surface_s));
    println!("{name}: {rays} rays, one thread, median of {rounds} rounds");
    println!("{:<16} {:>10} {:>10} {:>12}", "", "ns a ray", "/ primary", "relRMSE");
    let row = |name: &str, seconds: f64, error: Option<f64>| {
        let error = error.map_or(String::new(), |error| format!("{error:.1e}"));
        println!("{name:<16} {:>10.0} {:>10.2} {error:>12}", seconds / rays * 1e9, seconds / primary);
    };
    row("primary ray", primary, None);
    row("light on it", surface - primary, None);
    let exact = shafts[0].clone();
    let mean = exact.iter().sum::<f64>() / exact.len() as f64;
    for (index, (name, _)) in methods.iter().enumerate() {
        let squares = shafts[index].iter().zip(&exact).map(|(a, b)| (a - b) * (a - b));
        let error = (squares.sum::<f64>() / exact.len() as f64).sqrt() / mean;
        row(name, median(&mut method_s[index]) - surface, Some(error));
    }
}

fn render(snapshot: &Snapshot, volume: VolumeMethod, stride: usize, shafts: &mut Vec<f64>) -> f64 {
    let transport = Transport { volume, mirror_depth: 0, indirect: None, features: false };
    let mut scratch = Scratch::default();
    seconds(stride, |x, y| {
        let mut sampler = Sampler::new(0, (x * 1e4) as u32, (y * 1e4) as u32, 0);
        let ray = snapshot.view.ray(x, y);
        let sample = radiance(snapshot, &transport, &ray, &mut sampler, &mut scratch);
        shafts.push(sample.shafts.element_sum() / 3.0);
    })
}

/// Wall time of one call for each pixel centre of a grid.
fn seconds(stride: usize, mut call: impl FnMut(f64, f64)) -> f64 {
    let started = Instant::now();
    for y in (0..HEIGHT).step_by(stride) {
        for x in (0..WIDTH).step_by(stride) {
            call((x as f64 + 0.5) / WIDTH as f64, (y as f64 + 0.5) / HEIGHT as f64);
        }
    }
    started.elapsed().as_secs_f64()
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    values[values.len() / 2]
}
