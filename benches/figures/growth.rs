//! Growth of a picture's cost. In go a scene and a quantity, out come times of pictures in which that
//! quantity alone was changed, and the exponent that fits them. Invariants: points take turns, and of each
//! the least time counts; an exponent never stands without its standard error.

use crate::{checkout, inputs};
use glam::{DAffine3, DQuat, DVec3};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::time::Instant;
use sunfleck::bench::{Effort, Method, Plot, PowerLaw, RelativeErrors, Series, Stage, Style, seconds, timed};
use sunfleck::math::Sampler;
use sunfleck::scene::{self, Bounces, Instance, Motion, Node, Scene, Size, Track};
use sunfleck::snapshot::{Exposure, MeshTrees, Shutter};

/// Growth with each quantity of `leaves500`, or with one of them: a table, and plots into docs/images/growth.
pub fn run(asked: Option<&String>) {
    let scene = inputs::load("leaves500/leaves500.glb");
    let mut growths = Vec::new();
    for quantity in Quantity::ALL {
        if asked.is_some_and(|asked| asked != quantity.name()) {
            continue;
        }
        eprintln!("{}", quantity.name());
        let plan = Plan { scene: &scene, size: Size { width: 480, height: 270 }, rounds: 2, longest_s: 30.0 };
        let plan = match quantity {
            Quantity::Accuracy => {
                Plan { size: Size { width: 240, height: 135 }, rounds: 1, longest_s: 60.0, ..plan }
            }
            _ => plan,
        };
        let growth = measure(&plan, quantity);
        let Size { width, height } = plan.size;
        let title = format!("leaves500, {width} x {height} pixels, slices, {} samples", SAMPLES);
        let path = checkout::file("docs/images/growth").join(format!("{}.svg", quantity.name()));
        std::fs::write(path, growth_plot(&growth, &title).to_svg()).unwrap();
        growths.push(growth);
    }
    println!("{}", growth_table(&growths));
}

/// The golden angle: lights turned by it never stand behind one another.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

/// Maximum time of a point with all that comes before it, in times of the longest picture.
const PATIENCE: f64 = 20.0;

/// Frame that is rendered, and how.
const SHUTTER: Shutter = Shutter { open_s: 0.0, close_s: 0.0 };
const CAMERA: usize = 0;
const MIRROR_DEPTH: u32 = 4;
/// Samples a pixel, but where the error is what shrinks.
const SAMPLES: u32 = 4;

/// What is measured, and how long it may take.
pub(crate) struct Plan<'a> {
    /// The scene to start from.
    pub(crate) scene: &'a Scene,
    /// Picture size, but where that is what grows.
    pub(crate) size: Size,
    /// Number of measurements of each point, at least one.
    pub(crate) rounds: usize,
    /// A ladder ends before a point that would take longer, seconds.
    pub(crate) longest_s: f64,
}

/// Quantity that grows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Quantity {
    /// Instances of the mesh that is placed most often, their whole area kept.
    Leaves,
    /// Pixels of the picture.
    Pixels,
    /// Lights, the light of all together kept.
    Lights,
    /// Accuracy: one over the error.
    Accuracy,
    /// Density of the fog, as a multiple of the scene's.
    Fog,
    /// Threads.
    Threads,
}

/// Times over a quantity.
#[derive(Clone, Debug)]
struct Growth {
    /// Quantity that grew.
    quantity: Quantity,
    /// Values of the quantity and seconds, in order.
    points: Vec<(f64, f64)>,
    /// The line through them in logarithms.
    law: Option<PowerLaw>,
}

impl Quantity {
    /// All, in the order of tables.
    const ALL: [Self; 6] =
        [Self::Leaves, Self::Pixels, Self::Lights, Self::Accuracy, Self::Fog, Self::Threads];

    /// Name for tables and files.
    fn name(self) -> &'static str {
        match self {
            Self::Leaves => "leaves",
            Self::Pixels => "pixels",
            Self::Lights => "lights",
            Self::Accuracy => "accuracy",
            Self::Fog => "fog",
            Self::Threads => "threads",
        }
    }

    /// Label of the axis.
    fn label(self) -> &'static str {
        match self {
            Self::Leaves => "instances of the leaf, their whole area kept",
            Self::Pixels => "pixels",
            Self::Lights => "lights",
            Self::Accuracy => "1 / relative RMSE",
            Self::Fog => "density of the fog, times the scene's",
            Self::Threads => "threads",
        }
    }
}

impl Growth {
    fn new(quantity: Quantity, points: Vec<(f64, f64)>) -> Self {
        let law = if points.len() > 1 { PowerLaw::fit(&points) } else { None };
        Self { quantity, points, law }
    }
}

/// Measures one quantity. Pictures have one thread, but where threads are what grows.
fn measure(plan: &Plan, quantity: Quantity) -> Growth {
    let one = match rayon::ThreadPoolBuilder::new().num_threads(1).build() {
        Ok(one) => one,
        // Without threads there is nothing to time.
        Err(_) => return Growth::new(quantity, Vec::new()),
    };
    let alone = |scene: &Scene, size: Size| one.install(|| picture_s(scene, size));
    // The first picture of all takes up to twice its time: it finds neither memory nor caches ready.
    alone(plan.scene, plan.size);
    let points = match quantity {
        Quantity::Leaves => {
            let ladder = [500.0, 2e3, 8e3, 32e3, 125e3, 500e3, 1e6];
            ladder_of(plan, &ladder, |count| alone(&with_leaves(plan, count as u32), plan.size))
        }
        Quantity::Pixels => {
            let aspect = plan.size.width as f64 / plan.size.height as f64;
            let size =
                |height: f64| Size { width: (height * aspect).round() as usize, height: height as usize };
            let heights = [240.0, 480.0, 720.0, 1080.0, 2160.0];
            let pixels = |height: f64| (size(height).width * size(height).height) as f64;
            let ladder = heights.map(pixels);
            let height =
                |count: f64| heights.into_iter().find(|&height| pixels(height) == count).unwrap_or(1.0);
            ladder_of(plan, &ladder, |count| alone(plan.scene, size(height(count))))
        }
        Quantity::Lights => {
            let ladder = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];
            ladder_of(plan, &ladder, |count| alone(&with_lights(plan, count as u32), plan.size))
        }
        Quantity::Accuracy => one.install(|| accuracy(plan)),
        Quantity::Fog => {
            let ladder = [1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0];
            ladder_of(plan, &ladder, |factor| alone(&with_fog(plan, factor), plan.size))
        }
        Quantity::Threads => {
            let most = std::thread::available_parallelism().map_or(1, usize::from);
            let mut ladder: Vec<f64> =
                (0..).map(|n| 1_usize << n).take_while(|&n| n < most).map(|n| n as f64).collect();
            ladder.push(most as f64);
            // More threads take no longer than the first, which is waited for anyway.
            let patient = Plan { longest_s: f64::INFINITY, ..*plan };
            ladder_of(&patient, &ladder, |count| wall_s(plan, count as usize))
        }
    };
    Growth::new(quantity, points)
}

/// Times of each rung in turn, as long as the next one is expected in time.
pub(crate) fn ladder_of(plan: &Plan, ladder: &[f64], mut time_s: impl FnMut(f64) -> f64) -> Vec<(f64, f64)> {
    let mut points: Vec<(f64, f64)> = Vec::new();
    let mut whole_s = 0.0;
    for &value in ladder {
        let ratio = points.last().map_or(1.0, |&(before, _)| (value / before).max(1.0));
        let expected_s = points.last().map_or(0.0, |&(_, seconds)| seconds * ratio);
        // Making the scene may take longer than its picture.
        if expected_s > plan.longest_s || whole_s * ratio > PATIENCE * plan.longest_s {
            break;
        }
        let started = Instant::now();
        points.push((value, time_s(value)));
        whole_s = started.elapsed().as_secs_f64();
    }
    for _ in 1..plan.rounds {
        for (value, least_s) in &mut points {
            *least_s = least_s.min(time_s(*value));
        }
    }
    points
}

/// Processor time of a picture by slices, without what comes before.
fn picture_s(scene: &Scene, size: Size) -> f64 {
    let trees = MeshTrees::new(scene);
    let exposure = exposure(scene, &trees, size);
    let stage = stage(&exposure, size);
    timed(|| Method::Slices.picture(&stage, Effort::of_samples(SAMPLES), 0)).1
}

/// Wall time of the same with several threads.
fn wall_s(plan: &Plan, threads: usize) -> f64 {
    let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(threads).build() else { return f64::NAN };
    let trees = MeshTrees::new(plan.scene);
    let exposure = exposure(plan.scene, &trees, plan.size);
    let stage = stage(&exposure, plan.size);
    let started = Instant::now();
    pool.install(|| Method::Slices.picture(&stage, Effort::of_samples(SAMPLES), 0));
    started.elapsed().as_secs_f64()
}

/// Time over one / error: pictures with more and more samples against one with four times
/// as many as the last.
fn accuracy(plan: &Plan) -> Vec<(f64, f64)> {
    let trees = MeshTrees::new(plan.scene);
    let exposure = exposure(plan.scene, &trees, plan.size);
    let stage = stage(&exposure, plan.size);
    let picture = |samples: f64, seed: u32| {
        timed(|| Method::Slices.picture(&stage, Effort::of_samples(samples as u32), seed))
    };
    // The reference counts too: the ladder ends early enough for it.
    let shorter = Plan { longest_s: plan.longest_s / 4.0, rounds: 1, ..*plan };
    let mut pictures = Vec::new();
    let ladder = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0, 256.0, 512.0, 1024.0];
    let mut times = ladder_of(&shorter, &ladder, |samples| {
        let (frame, seconds) = picture(samples, 0);
        pictures.push(frame);
        seconds
    });
    for _ in 1..plan.rounds {
        for (samples, least_s) in &mut times {
            *least_s = least_s.min(picture(*samples, 0).1);
        }
    }
    let most = times.last().map_or(1.0, |last| last.0);
    let (reference, _) = picture(4.0 * most, 1);
    let errors = pictures.iter().map(|frame| RelativeErrors::new(frame, &reference).rmse);
    errors.zip(&times).map(|(error, &(_, seconds))| (1.0 / error, seconds)).collect()
}

fn exposure<'a>(scene: &'a Scene, trees: &'a MeshTrees, size: Size) -> Exposure<'a> {
    let exposure = Exposure::new(scene, trees, CAMERA, size.width as f64 / size.height as f64, SHUTTER);
    // Frozen before anything is timed.
    exposure.moments();
    exposure
}

fn stage<'a>(exposure: &'a Exposure<'a>, size: Size) -> Stage<'a> {
    Stage { exposure, size, mirror_depth: MIRROR_DEPTH, bounces: Bounces::NONE, planes: (1.0, 1.0) }
}

/// The scene with `count` instances of the mesh that is placed most often, anywhere among those that there
/// were and turned any way, each so small that their whole area stays.
pub(crate) fn with_leaves(plan: &Plan, count: u32) -> Scene {
    let mut scene = plan.scene.clone();
    let placements = scene.placements(SHUTTER.middle_s());
    let mut uses: BTreeMap<usize, usize> = BTreeMap::new();
    for instance in scene.instances.iter().filter(|instance| placements[instance.node].visible) {
        *uses.entry(instance.mesh).or_default() += 1;
    }
    let Some((&leaf, _)) = uses.iter().max_by_key(|(_, uses)| **uses) else { return scene };
    let old: Vec<Instance> =
        scene.instances.iter().filter(|instance| instance.mesh == leaf).cloned().collect();
    scene.instances.retain(|instance| instance.mesh != leaf);
    let places: Vec<DAffine3> =
        old.iter().map(|instance| placements[instance.node].world_from_node).collect();
    let (low, high) = places.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), place| {
        (low.min(place.translation), high.max(place.translation))
    });
    // Area goes with the square of the scale.
    let squares = places.iter().map(|place| place.matrix3.determinant().abs().powf(2.0 / 3.0)).sum::<f64>();
    let scale = (squares / f64::from(count)).sqrt();
    for index in 0..count {
        let mut random = Sampler::new(20, index, 0, 0);
        let ((x, z), y) = (random.next_2d(), random.next_1d());
        // Shoemake 1992, "Uniform random rotations".
        let ((u, v), w) = (random.next_2d(), random.next_1d());
        let (s, t) = (TAU * v, TAU * w);
        let (a, b) = ((1.0 - u).sqrt(), u.sqrt());
        let rotation = DQuat::from_xyzw(a * s.sin(), a * s.cos(), b * t.sin(), b * t.cos());
        let at = low + DVec3::new(x, y, z) * (high - low);
        let place = DAffine3::from_scale_rotation_translation(DVec3::splat(scale), rotation, at);
        let node = add_node(&mut scene, place);
        let like = &old[index as usize % old.len()];
        scene.instances.push(Instance { node, leaf_id: index + 1, ..like.clone() });
    }
    scene
}

/// The scene with its first light `count` times, each turned about the vertical in front of the camera.
pub(crate) fn with_lights(plan: &Plan, count: u32) -> Scene {
    let mut scene = plan.scene.clone();
    let time_s = SHUTTER.middle_s();
    let placements = scene.placements(time_s);
    let Some(first) = scene.lights.iter().find(|light| placements[light.node].visible).cloned() else {
        return scene;
    };
    let mean = |sum: DVec3, of: usize| sum / of.max(1) as f64;
    let places = scene.instances.iter().map(|instance| placements[instance.node].world_from_node.translation);
    let centre = mean(places.sum(), scene.instances.len());
    scene.lights.clear();
    for index in 0..count {
        let turn = DAffine3::from_rotation_y(GOLDEN_ANGLE * f64::from(index));
        let about = DAffine3::from_translation(centre) * turn * DAffine3::from_translation(-centre);
        let node = add_node(&mut scene, about * placements[first.node].world_from_node);
        let power = Track::from(first.power.at(time_s) / f64::from(count));
        scene.lights.push(scene::Light { node, power, ..first.clone() });
    }
    scene
}

fn with_fog(plan: &Plan, factor: f64) -> Scene {
    let mut scene = plan.scene.clone();
    for fog in &mut scene.fogs {
        fog.density_per_m = Track::from(fog.density_per_m.at(SHUTTER.middle_s()) * factor);
    }
    scene
}

fn add_node(scene: &mut Scene, world_from_node: DAffine3) -> usize {
    scene.nodes.push(Node {
        name: String::new(),
        parent: None,
        motion: Motion::Still(world_from_node),
        visible: Track::from(true),
    });
    scene.nodes.len() - 1
}

/// Exponents, then the points that they were fitted to.
fn growth_table(growths: &[Growth]) -> String {
    let mut text =
        format!("{:<10} {:>20}   {:<17} {}\n", "quantity", "from, to", "time grows with", "seconds");
    for growth in growths {
        let (Some(first), Some(last)) = (growth.points.first(), growth.points.last()) else { continue };
        let range = format!("{}, {}", seconds(first.0), seconds(last.0));
        let times: Vec<String> = growth.points.iter().map(|point| seconds(point.1)).collect();
        let name = growth.quantity.name();
        let _ = writeln!(text, "{name:<10} {range:>20}   {:<17} {}", exponent(growth.law), times.join("  "));
    }
    text
}

/// Such as `^0.52 +- 0.03`.
fn exponent(law: Option<PowerLaw>) -> String {
    match law {
        Some(law) if law.standard_error.is_finite() => {
            format!("^{:.2} +- {:.2}", law.exponent, law.standard_error)
        }
        Some(law) => format!("^{:.2} (2 points)", law.exponent),
        None => String::from("-"),
    }
}

/// The points and the line that fits them.
fn growth_plot(growth: &Growth, title: &str) -> Plot {
    let wall = growth.quantity == Quantity::Threads;
    let mut series = Vec::new();
    if let (Some(law), Some(first), Some(last)) = (growth.law, growth.points.first(), growth.points.last()) {
        let line = [first.0, last.0].map(|value| (value, law.at(value))).to_vec();
        series.push(Series {
            name: exponent(growth.law),
            style: Style::Fit,
            points: line,
            aside: Vec::new(),
        });
    }
    let measured = Series {
        name: String::new(),
        style: Style::Line(0),
        points: growth.points.clone(),
        aside: Vec::new(),
    };
    series.push(measured);
    Plot {
        title: title.to_owned(),
        subtitle: format!("time over {}, {}", growth.quantity.name(), exponent(growth.law)),
        x_label: growth.quantity.label().to_owned(),
        y_label: String::from(if wall {
            "seconds by the clock"
        } else {
            "processor time of the picture, seconds"
        }),
        series,
    }
}
