//! Growth of a picture's cost. In go a scene and a quantity, out come times of pictures in which that
//! quantity alone was changed, and the exponent that fits them. Invariant: points take turns; of each the
//! least time counts.

use super::method::timed;
use super::{Effort, Method, PowerLaw, RelativeErrors, Stage};
use crate::math::Sampler;
use crate::scene::{Instance, Motion, Node, Scene, Size, Track};
use crate::snapshot::{Exposure, MeshTrees, Shutter};
use glam::{DAffine3, DQuat, DVec3};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::time::Instant;

/// The golden angle: lights turned by it never stand behind one another.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

/// Maximum time of a point with all that comes before it, in times of the longest picture.
const PATIENCE: f64 = 20.0;

/// Plan of the measurement, and how long it may take.
pub struct ScalingPlan<'a> {
    /// The scene to start from.
    pub scene: &'a Scene,
    /// Index of its camera.
    pub camera: usize,
    /// Shutter.
    pub shutter: Shutter,
    /// Picture size, but where that is what grows.
    pub size: Size,
    /// Maximum number of reflections of a ray.
    pub mirror_depth: u32,
    /// Samples a pixel, but where the error is what shrinks.
    pub samples: u32,
    /// Number of measurements of each point, at least one.
    pub rounds: usize,
    /// A ladder ends before a point that would take longer, seconds.
    pub longest_s: f64,
}

/// Quantity that grows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Quantity {
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
pub struct Growth {
    /// Quantity that grew.
    pub quantity: Quantity,
    /// Values of the quantity and seconds, in order.
    pub points: Vec<(f64, f64)>,
    /// The line through them in logarithms.
    pub law: Option<PowerLaw>,
}

impl Quantity {
    /// All, in the order of tables.
    pub const ALL: [Self; 6] =
        [Self::Leaves, Self::Pixels, Self::Lights, Self::Accuracy, Self::Fog, Self::Threads];

    /// Name for tables and files.
    pub fn name(self) -> &'static str {
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
    pub fn label(self) -> &'static str {
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
pub fn measure(plan: &ScalingPlan, quantity: Quantity) -> Growth {
    let one = match rayon::ThreadPoolBuilder::new().num_threads(1).build() {
        Ok(one) => one,
        // Without threads there is nothing to time.
        Err(_) => return Growth::new(quantity, Vec::new()),
    };
    let alone = |scene: &Scene, size: Size| one.install(|| picture_s(plan, scene, size));
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
            let patient = ScalingPlan { longest_s: f64::INFINITY, ..*plan };
            ladder_of(&patient, &ladder, |count| wall_s(plan, count as usize))
        }
    };
    Growth::new(quantity, points)
}

/// Times of each rung in turn, as long as the next one is expected in time.
fn ladder_of(plan: &ScalingPlan, ladder: &[f64], mut time_s: impl FnMut(f64) -> f64) -> Vec<(f64, f64)> {
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
fn picture_s(plan: &ScalingPlan, scene: &Scene, size: Size) -> f64 {
    let trees = MeshTrees::new(scene);
    let exposure = exposure(plan, scene, &trees, size);
    let stage = stage(plan, &exposure, size);
    timed(|| Method::Slices.picture(&stage, Effort::of_samples(plan.samples), 0)).1
}

/// Wall time of the same with several threads.
fn wall_s(plan: &ScalingPlan, threads: usize) -> f64 {
    let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(threads).build() else { return f64::NAN };
    let trees = MeshTrees::new(plan.scene);
    let exposure = exposure(plan, plan.scene, &trees, plan.size);
    let stage = stage(plan, &exposure, plan.size);
    let started = Instant::now();
    pool.install(|| Method::Slices.picture(&stage, Effort::of_samples(plan.samples), 0));
    started.elapsed().as_secs_f64()
}

/// Time over one / error: pictures with more and more samples against one with four times
/// as many as the last.
fn accuracy(plan: &ScalingPlan) -> Vec<(f64, f64)> {
    let trees = MeshTrees::new(plan.scene);
    let exposure = exposure(plan, plan.scene, &trees, plan.size);
    let stage = stage(plan, &exposure, plan.size);
    let picture = |samples: f64, seed: u32| {
        timed(|| Method::Slices.picture(&stage, Effort::of_samples(samples as u32), seed))
    };
    // The reference counts too: the ladder ends early enough for it.
    let shorter = ScalingPlan { longest_s: plan.longest_s / 4.0, rounds: 1, ..*plan };
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

fn exposure<'a>(plan: &ScalingPlan, scene: &'a Scene, trees: &'a MeshTrees, size: Size) -> Exposure<'a> {
    Exposure::new(scene, trees, plan.camera, size.width as f64 / size.height as f64, plan.shutter)
}

fn stage<'a>(plan: &ScalingPlan, exposure: &'a Exposure<'a>, size: Size) -> Stage<'a> {
    Stage { exposure, size, mirror_depth: plan.mirror_depth, planes: (1.0, 1.0) }
}

/// The scene with `count` instances of the mesh that is placed most often, anywhere among those that there
/// were and turned any way, each so small that their whole area stays.
fn with_leaves(plan: &ScalingPlan, count: u32) -> Scene {
    let mut scene = plan.scene.clone();
    let placements = scene.placements(plan.shutter.middle_s());
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
fn with_lights(plan: &ScalingPlan, count: u32) -> Scene {
    let mut scene = plan.scene.clone();
    let time_s = plan.shutter.middle_s();
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
        scene.lights.push(crate::scene::Light { node, power, ..first.clone() });
    }
    scene
}

fn with_fog(plan: &ScalingPlan, factor: f64) -> Scene {
    let mut scene = plan.scene.clone();
    for fog in &mut scene.fogs {
        fog.density_per_m = Track::from(fog.density_per_m.at(plan.shutter.middle_s()) * factor);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{checkout, description, scene};

    fn leaf_scene() -> Scene {
        let path = checkout::file("tests/data/leaves500/leaves500.glb");
        scene::resolve(description::load(&path).expect("a good file"), None).expect("a good scene").0
    }

    fn plan(scene: &Scene) -> ScalingPlan<'_> {
        let shutter = Shutter { open_s: 0.0, close_s: 0.0 };
        let size = Size { width: 8, height: 6 };
        ScalingPlan {
            scene,
            camera: 0,
            shutter,
            size,
            mirror_depth: 0,
            samples: 1,
            rounds: 1,
            longest_s: 1.0,
        }
    }

    /// Sum of the squares of the scales of the mesh that is placed most often.
    fn area(scene: &Scene) -> (usize, f64) {
        let placements = scene.placements(0.0);
        let mesh = scene.instances[1].mesh;
        let leaves = scene.instances.iter().filter(|instance| instance.mesh == mesh);
        leaves.fold((0, 0.0), |(count, sum), leaf| {
            let scale = placements[leaf.node].world_from_node.matrix3.determinant().cbrt();
            (count + 1, sum + scale * scale)
        })
    }

    #[test]
    fn more_leaves_have_the_same_area_and_leave_the_rest_alone() {
        let scene = leaf_scene();
        let (few, before) = area(&scene);
        let grown = with_leaves(&plan(&scene), 3000);
        let instances = grown.instances.len();
        let (_, after) =
            area(&Scene { instances: grown.instances[instances - 3000..].to_vec(), ..grown.clone() });
        assert_eq!(instances, scene.instances.len() - few + 3000);
        assert!((after / before - 1.0).abs() < 1e-9, "{before} {after}");
    }

    #[test]
    fn lights_share_the_power_of_one() {
        let scene = leaf_scene();
        let many = with_lights(&plan(&scene), 5);
        let power = |scene: &Scene| scene.lights.iter().map(|light| light.power.at(0.0).x).sum::<f64>();
        assert_eq!(many.lights.len(), 5);
        assert!((power(&many) / power(&scene) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn ladders_end_in_time() {
        let scene = leaf_scene();
        let mut asked = Vec::new();
        let plan = ScalingPlan { longest_s: 5.0, rounds: 2, ..plan(&scene) };
        let points = ladder_of(&plan, &[1.0, 2.0, 4.0, 8.0], |value| {
            asked.push(value);
            value + if asked.len() < 4 { 1.0 } else { 0.0 }
        });
        // 4 would take 3 * 4 / 2 = 6 seconds.
        assert_eq!(asked, [1.0, 2.0, 1.0, 2.0]);
        assert_eq!(points, [(1.0, 2.0), (2.0, 2.0)]);
    }
}
