//! Processor time of a ray, by kind, and of a shadow query, in one thread.

use crate::ray_scenes::{self, RayScene};
use glam::DVec3;
use std::hint::black_box;
use std::time::Instant;
use sunfleck::accel::{LightPlane, PrimitiveId};
use sunfleck::math::{IntervalSet, Ray, Sampler};

/// Film size: one ray a pixel.
const WIDTH: u32 = 480;
const HEIGHT: u32 = 270;

/// A row of the table: what is asked, how many times, and how.
type Row<'a> = (&'static str, usize, Box<dyn FnMut() + 'a>);

/// Seconds this thread has had a processor, or by the clock where the system does not say.
fn cpu_time_s(start: Instant) -> f64 {
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let on_cpu_ns = stat.and_then(|stat| stat.split(' ').next()?.parse::<f64>().ok());
    on_cpu_ns.map_or_else(|| start.elapsed().as_secs_f64(), |ns| ns / 1e9)
}

/// Prints rows for each scene: the shortest of `rounds` alternated runs.
pub fn run(rounds: usize) {
    for scene in ray_scenes::both() {
        println!("{:<10} {:<8} {:>9} {:>9} {:>9}", scene.name, "query", "ns", "M/s", "/primary");
        table(&scene, rounds);
    }
}

fn table(scene: &RayScene, rounds: usize) {
    let tree = &scene.tree;
    let pixels = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y)));
    let primary: Vec<Ray> = pixels
        .map(|(x, y)| {
            let film = |pixel: u32, size: u32| (f64::from(pixel) + 0.5) / f64::from(size);
            scene.camera_ray(film(x, WIDTH), film(y, HEIGHT))
        })
        .collect();
    let hits: Vec<_> = primary.iter().map(|ray| tree.nearest_hit(ray, f64::INFINITY, None)).collect();
    let mut shadow: Vec<(Ray, Option<PrimitiveId>)> = Vec::new();
    let mut cosine = shadow.clone();
    let mut air = shadow.clone();
    for (pixel, (ray, hit)) in primary.iter().zip(&hits).enumerate() {
        let mut random = Sampler::new(3, pixel as u32, 0, 0);
        let ((u, v), w) = (random.next_2d(), random.next_1d());
        air.push((Ray { origin: scene.in_air(u, v, w), direction: scene.to_sun }, None));
        let Some(hit) = hit else { continue };
        let origin = ray.at(hit.t);
        shadow.push((Ray { origin, direction: scene.to_sun }, Some(hit.primitive)));
        // About the direction back, as no normal is at hand.
        let angle = std::f64::consts::TAU * u;
        let on_sphere = DVec3::new(
            2.0 * (v * (1.0 - v)).sqrt() * angle.cos(),
            2.0 * (v * (1.0 - v)).sqrt() * angle.sin(),
            1.0 - 2.0 * v,
        );
        let direction = (on_sphere - 1.000001 * ray.direction).normalize();
        cosine.push((Ray { origin, direction }, Some(hit.primitive)));
    }
    let ranges: Vec<(Ray, (f64, f64))> = primary
        .iter()
        .zip(&hits)
        .map(|(ray, hit)| (*ray, (0.0, hit.as_ref().map_or(20.0, |hit| hit.t))))
        .collect();
    let (mut strip_shadows, mut fan_shadows) = (IntervalSet::default(), IntervalSet::default());
    let mut rows: Vec<Row> = vec![
        (
            "primary",
            primary.len(),
            Box::new(|| {
                for ray in &primary {
                    black_box(tree.nearest_hit(ray, f64::INFINITY, None));
                }
            }),
        ),
        (
            "shadow",
            shadow.len(),
            Box::new(|| {
                for (ray, skip) in &shadow {
                    black_box(tree.any_hit(ray, f64::INFINITY, *skip));
                }
            }),
        ),
        (
            "cosine",
            cosine.len(),
            Box::new(|| {
                for (ray, skip) in &cosine {
                    black_box(tree.nearest_hit(ray, f64::INFINITY, *skip));
                }
            }),
        ),
        (
            "air",
            air.len(),
            Box::new(|| {
                for (ray, skip) in &air {
                    black_box(tree.any_hit(ray, f64::INFINITY, *skip));
                }
            }),
        ),
        (
            "strip",
            ranges.len(),
            Box::new(|| {
                for (ray, range) in &ranges {
                    strip_shadows.clear();
                    if let Some(plane) = LightPlane::towards_direction(ray, scene.to_sun, *range) {
                        tree.add_shadows(&plane, &mut strip_shadows);
                    }
                    black_box(strip_shadows.as_slice().len());
                }
            }),
        ),
        (
            "fan",
            ranges.len(),
            Box::new(|| {
                for (ray, range) in &ranges {
                    fan_shadows.clear();
                    if let Some(plane) = LightPlane::towards_point(ray, scene.lamp, *range) {
                        tree.add_shadows(&plane, &mut fan_shadows);
                    }
                    black_box(fan_shadows.as_slice().len());
                }
            }),
        ),
    ];
    let epoch = Instant::now();
    let mut shortest_ns = vec![f64::INFINITY; rows.len()];
    for _ in 0..rounds {
        for ((_, count, query), shortest) in rows.iter_mut().zip(&mut shortest_ns) {
            let begin = cpu_time_s(epoch);
            query();
            *shortest = shortest.min((cpu_time_s(epoch) - begin) * 1e9 / *count as f64);
        }
    }
    for ((name, ..), ns) in rows.iter().zip(&shortest_ns) {
        println!("{:<10} {name:<8} {ns:>9.0} {:>9.2} {:>9.1}", "", 1e3 / ns, ns / shortest_ns[0]);
    }
}
