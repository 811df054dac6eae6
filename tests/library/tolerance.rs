//! Rendering until an error is small enough. What is estimated is held against the truth. What pictures
//! promise holds whatever is estimated.

use crate::checkout;
use crate::common::{INSTANT, add_fog, add_light, camera_at};
use crate::indirect::add_box;
use glam::DVec3;
use std::sync::Arc;
use sunfleck::color::{Rgb, luminance};
use sunfleck::film::{Blocks, Frame};
use sunfleck::passes::Pass;
use sunfleck::render::{Job, Method, Rendered, Watch, render};
use sunfleck::scene::{
    LightKind, Material, PixelFilter, Sampling, Scene, Size, SunDisc, SunPicture, SunShows, Texture, Window,
    Wrap,
};
use sunfleck::snapshot::{Exposure, MeshTrees};
use sunfleck::{description, scene};

const SIZE: Size = Size { width: 128, height: 72 };
/// No whole blocks: its rim lies within some.
const PART: Window = Window { x: 45, y: 20, width: 37, height: 26 };

fn load(path: &str) -> Scene {
    let path = checkout::file("tests/data").join(path);
    scene::resolve(description::load(&path).expect("a good file"), None).expect("a good scene").0
}

fn leaves500() -> Scene {
    load("leaves500/leaves500.glb")
}

fn until(tolerance: f64) -> Job {
    Job {
        size: SIZE,
        window: Window::whole(SIZE),
        passes: vec![Pass::Error],
        sampling: Sampling::Until { tolerance, most: 1024 },
        filter: PixelFilter::Box,
        seed: 0,
        mirror_depth: 0,
        bounces: sunfleck::scene::Bounces::NONE,
        method: Method::Slices,
    }
}

fn picture(scene: &Scene, job: &Job) -> Rendered {
    let trees = MeshTrees::new(scene);
    render(&Exposure::new(scene, &trees, 0, 16.0 / 9.0, INSTANT), job, &Watch::NOBODY)
}

fn colors(frame: &Frame) -> Vec<Rgb> {
    let [red, green, blue] = ["R", "G", "B"].map(|name| &frame.channel(name).expect("is there").pixels);
    let pixels = red.iter().zip(green).zip(blue);
    pixels.map(|((&red, &green), &blue)| Rgb::new(red.into(), green.into(), blue.into())).collect()
}

fn luminances(frame: &Frame) -> Vec<f64> {
    colors(frame).into_iter().map(luminance).collect()
}

/// Sunlight through a slit, a tenth of a pixel wide on the wall and along the slices: most first samples miss
/// it, and pixels that they leave black are black for good if they end with them. A tenth is lost still.
#[test]
fn light_through_a_slit_is_nearly_as_bright_as_with_all_samples() {
    let mut scene = camera_at(DVec3::ZERO);
    let white = || Material { base_color: Rgb::ONE, ..Material::default() };
    add_box(&mut scene, DVec3::new(-20.0, -20.0, -5.1), DVec3::new(20.0, 20.0, -5.0), white());
    add_box(&mut scene, DVec3::new(-20.0, -20.0, 1.0), DVec3::new(-0.115, 20.0, 1.05), white());
    add_box(&mut scene, DVec3::new(-0.095, -20.0, 1.0), DVec3::new(20.0, 20.0, 1.05), white());
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::new(0.1, -0.3, -1.0), Rgb::ONE);
    let mean = |job: &Job| luminances(&picture(&scene, job).frame).iter().sum::<f64>();
    let expected = mean(&Job { sampling: Sampling::Exactly(256), ..until(0.1) });
    let ratio = mean(&until(0.1)) / expected;
    println!("through a slit: {ratio:.4}");
    assert!((ratio - 1.0).abs() < 0.15, "{ratio}");
}

/// A lamp in fog, just between two blocks of the picture: of a slice between them no more than the very
/// beginning may lie in one of them.
#[test]
fn a_lamp_between_blocks_shines_on_neither_more() {
    let mut scene = camera_at(DVec3::ZERO);
    add_light(&mut scene, LightKind::Point, DVec3::new(0.0, 0.2, -4.5), DVec3::NEG_Z, Rgb::splat(6.0));
    let (low, high) = (DVec3::new(-2.5, -1.5, -7.0), DVec3::new(2.5, 1.5, -2.0));
    add_fog(&mut scene, low, high, Rgb::splat(0.3), Rgb::ONE, 0.0);
    let [slices, rays] = [Method::Slices, Method::Segments]
        .map(|method| luminances(&picture(&scene, &Job { method, ..until(0.02) }).frame).iter().sum::<f64>());
    assert!((slices / rays - 1.0).abs() < 0.02, "{slices} by slices, {rays} by rays");
}

/// The square by which a colour is off, its channels weighed as luminance weighs them.
fn square(color: Rgb, truth: Rgb) -> f64 {
    luminance((color - truth) * (color - truth))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// How far blocks are from the truth: true errors by the blocks' brightness, and by what was estimated.
struct Judged {
    errors: Vec<f64>,
    by_estimate: Vec<f64>,
    /// Of the picture, by its mean.
    rmse: f64,
}

fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[(share * (sorted.len() - 1) as f64) as usize]
}

/// Pictures of several seeds against one of many samples.
fn judge(scene: &Scene, job: &Job, truth_samples: u32, seeds: u32) -> Judged {
    judge_by(&truth(scene, job, truth_samples), scene, job, seeds)
}

/// Colours of many samples.
fn truth(scene: &Scene, job: &Job, samples: u32) -> Vec<Rgb> {
    colors(&picture(scene, &Job { sampling: Sampling::Exactly(samples), seed: 99, ..job.clone() }).frame)
}

fn judge_by(truth: &[Rgb], scene: &Scene, job: &Job, seeds: u32) -> Judged {
    let mean_truth = mean(&truth.iter().copied().map(luminance).collect::<Vec<_>>());
    let blocks = Blocks::covering(job.window, job.size);
    let mut judged = Judged { errors: Vec::new(), by_estimate: Vec::new(), rmse: 0.0 };
    for seed in 0..seeds {
        let frame = picture(scene, &Job { seed, ..job.clone() }).frame;
        let values = colors(&frame);
        let estimates = &frame.channel("error.Y").expect("asked for").pixels;
        for block in 0..blocks.count() {
            let pixels: Vec<usize> =
                blocks.pixels(block).pixels().filter_map(|(x, y)| job.window.index(x, y)).collect();
            // Blocks cut by the window are judged by pixels that it does not hold.
            if pixels.len() < 64 {
                continue;
            }
            let squares: Vec<f64> = pixels.iter().map(|&at| square(values[at], truth[at])).collect();
            let brightness = mean(&pixels.iter().map(|&at| luminance(truth[at])).collect::<Vec<_>>());
            let error = mean(&squares).sqrt() / brightness.max(0.1 * mean_truth);
            let estimate = f64::from(estimates[pixels[0]]);
            judged.errors.push(error);
            if estimate > 0.0 {
                judged.by_estimate.push(error / estimate);
            }
        }
        let squares = values.iter().zip(truth).map(|(value, truth)| square(*value, *truth));
        judged.rmse += (mean(&squares.collect::<Vec<_>>()).sqrt() / mean_truth) / f64::from(seeds);
    }
    judged
}

/// The estimate is about the truth: a little above it for most blocks, and rarely far below.
fn assert_honest(judged: &Judged, tolerance: f64) {
    let Judged { errors, by_estimate, rmse } = judged;
    let over = errors.iter().filter(|error| **error > tolerance).count() as f64 / errors.len() as f64;
    let report = format!(
        "true by estimated: 5 % {:.2}, median {:.2}, 95 % {:.2}; error: 95 % {:.4}, 99 % {:.4}; over {over:.3}; rmse {rmse:.4}",
        quantile(by_estimate, 0.05),
        quantile(by_estimate, 0.5),
        quantile(by_estimate, 0.95),
        quantile(errors, 0.95),
        quantile(errors, 0.99),
    );
    assert!((0.65..1.1).contains(&quantile(by_estimate, 0.5)), "{report}");
    assert!(quantile(by_estimate, 0.95) < 2.0, "{report}");
    assert!(over < 0.1, "{report}");
    assert!(quantile(errors, 0.95) < 1.3 * tolerance, "{report}");
    assert!(*rmse < tolerance, "{report}");
}

#[test]
fn leaves_have_the_error_that_is_estimated() {
    assert_honest(&judge(&leaves500(), &until(0.05), 512, 4), 0.05);
}

/// Leaves under a sun as wide as four: slices are out of order, and shafts are smoothed.
fn leaves_under_a_wide_sun() -> Scene {
    let mut scene = leaves500();
    scene.lights[0].kind = LightKind::SunDisc(SunDisc::even(2_f64.to_radians().into()));
    scene
}

#[test]
fn half_shadows_have_the_error_that_is_estimated() {
    let judged = judge(&leaves_under_a_wide_sun(), &until(0.05), 1024, 2);
    assert_honest(&judged, 0.05);
}

/// By rays, which smooth nothing, the picture has the same light in each part of it.
#[test]
fn smoothed_shafts_have_the_light_that_rays_find() {
    let scene = leaves_under_a_wide_sun();
    let window = Window { x: 40, y: 16, width: 48, height: 40 };
    let rays = Job { method: Method::Segments, sampling: Sampling::Exactly(256), window, ..until(0.05) };
    let truth = luminances(&picture(&scene, &rays).frame);
    let smoothed: Vec<Vec<f64>> =
        (0..8).map(|seed| luminances(&picture(&scene, &Job { seed, window, ..until(0.05) }).frame)).collect();
    let all = mean(&truth);
    for (x, y) in (0..6).flat_map(|x| (0..5).map(move |y| (8 * x, 8 * y))) {
        let part = Window { x, y, width: 8, height: 8 };
        let of = |values: &[f64]| {
            mean(&part.pixels().map(|(x, y)| values[y * window.width + x]).collect::<Vec<_>>())
        };
        let found = mean(&smoothed.iter().map(|values| of(values)).collect::<Vec<_>>());
        assert!((found - of(&truth)).abs() < 0.02 * all, "({x}, {y}): {found} for {}", of(&truth));
    }
}

#[test]
fn rays_have_the_error_that_is_estimated() {
    let window = Window { x: 40, y: 16, width: 48, height: 32 };
    let job = Job { method: Method::Segments, window, ..until(0.05) };
    assert_honest(&judge(&leaves500(), &job, 256, 3), 0.05);
}

#[test]
fn a_canopy_has_the_error_that_is_estimated() {
    let window = Window { x: 40, y: 0, width: 48, height: 40 };
    assert_honest(&judge(&load("canopy20k/scene.ron"), &Job { window, ..until(0.1) }, 512, 2), 0.1);
}

/// A leaf before a wide sun, with halves as bright as each other.
fn leaf_before_two_hues() -> Scene {
    let [red, cyan] = [Rgb::new(0.9, 0.09, 0.09), Rgb::new(0.04, 0.32, 0.4)];
    let [red, cyan] = [red, cyan].map(|color| 0.2 / luminance(color) * color);
    let size = 32;
    let half = |texel: usize| if texel % size < size / 2 { red } else { cyan };
    let image = Texture {
        name: String::new(),
        width: size,
        height: size,
        texels: (0..size * size).map(|texel| half(texel).as_vec3().extend(1.0).to_array()).collect(),
        wrap: [Wrap::Clamp; 2],
    };
    let mut scene = load("leaf_before_sun.ron");
    let LightKind::SunDisc(disc) = &mut scene.lights[0].kind else { panic!("a disc") };
    disc.picture = SunPicture::new(SunShows::Image(Arc::new(image)), 0.0);
    scene
}

const TWO_HUES: Size = Size { width: 96, height: 54 };

/// A slice sees one point of this sun, in one half of it: what is left of errors is that of shadows.
#[test]
fn suns_of_two_hues_have_the_error_that_is_estimated() {
    let window = Window::whole(TWO_HUES);
    let job = Job { size: TWO_HUES, window, sampling: Sampling::Exactly(16), ..until(0.05) };
    let by_estimate = judge(&leaf_before_two_hues(), &job, 512, 2).by_estimate;
    let median = quantile(&by_estimate, 0.5);
    assert!((0.65..1.3).contains(&median), "true by estimated: {median:.2} of {} blocks", by_estimate.len());
}

/// Each sample is lit in one hue, and pictures of few samples have that of all the sun: as rays do that see
/// many points each, in the leaf's half shadow too.
#[test]
fn few_samples_have_the_hue_of_the_whole_sun() {
    let scene = leaf_before_two_hues();
    // Right of the sun, which is a thousand times as bright as what it lights.
    let window = Window { x: 56, y: 0, width: 40, height: 54 };
    let job = Job { size: TWO_HUES, window, passes: vec![Pass::Shafts], ..until(0.05) };
    let rays = Job { method: Method::Segments, sampling: Sampling::Exactly(2048), ..job.clone() };
    let truth = picture(&scene, &rays).frame;
    let few = |seed: u32| picture(&scene, &Job { sampling: Sampling::Exactly(8), seed, ..job.clone() }).frame;
    let pictures: Vec<Frame> = (0..32).map(few).collect();
    for names in [["R", "G", "B"], ["shafts.R", "shafts.G", "shafts.B"]] {
        for name in names {
            let pixels = |frame: &Frame| frame.channel(name).expect("is there").pixels.clone();
            let truth = pixels(&truth);
            let off = |found: &[f32]| -> Vec<f64> {
                found.iter().zip(&truth).map(|(found, truth)| f64::from(found / truth - 1.0)).collect()
            };
            let single: Vec<f64> = off(&pixels(&pictures[0])).into_iter().map(f64::abs).collect();
            // By the hues of eight points, or fewer, it would be a sixth and more.
            let median = quantile(&single, 0.5);
            assert!(median < 0.02, "{name}: {median:.4}");
            let mut means = vec![0.0; truth.len()];
            for frame in &pictures {
                for (mean, value) in means.iter_mut().zip(pixels(frame)) {
                    *mean += value / pictures.len() as f32;
                }
            }
            let off = off(&means);
            let (bias, worst) =
                (mean(&off), quantile(&off.iter().map(|off| off.abs()).collect::<Vec<_>>(), 0.95));
            assert!(bias.abs() < 2e-3 && worst < 0.03, "{name}: {bias:.5}, {worst:.4}");
        }
    }
}

/// What is dark beside the sun is judged by what the sun lights, whether one sees the sun itself or not.
#[test]
fn a_sun_that_is_seen_does_not_make_the_rest_dark() {
    let window = Window { x: 56, y: 0, width: 40, height: 54 };
    let job = Job { size: TWO_HUES, window, sampling: Sampling::Exactly(8), ..until(0.05) };
    let errors = [true, false].map(|is_seen| {
        let mut scene = leaf_before_two_hues();
        let LightKind::SunDisc(disc) = &mut scene.lights[0].kind else { panic!("a disc") };
        disc.visible_to_camera = is_seen;
        let frame = picture(&scene, &job).frame;
        mean(
            &frame.channel("error.Y").expect("is there").pixels.iter().map(|&x| x.into()).collect::<Vec<_>>(),
        )
    });
    assert!((errors[0] / errors[1] - 1.0).abs() < 1e-3, "{errors:?}");
}

/// Passes of 8, 8 and 16 samples share one lattice and one sequence of draws; if each had its own, they would
/// err by half as much again.
#[test]
fn passes_err_no_more_than_all_their_samples_at_once() {
    let (sharp, mut soft) = (leaves500(), leaves500());
    soft.lights[0].kind = LightKind::SunDisc(SunDisc::even(0.53_f64.to_radians().into()));
    for (scene, name) in [(sharp, "a direction"), (soft, "a disc"), (load("canopy20k/scene.ron"), "a canopy")]
    {
        let window = Window { x: 32, y: 8, width: 64, height: 48 };
        let job = Job { window, ..until(1e-9) };
        let truth = truth(&scene, &job, 384);
        let [passes, once] = [Sampling::Until { tolerance: 1e-9, most: 32 }, Sampling::Exactly(32)]
            .map(|sampling| judge_by(&truth, &scene, &Job { sampling, ..job.clone() }, 2).rmse);
        assert!(passes < 1.25 * once, "{name}: {passes:.5} in passes, {once:.5} at once");
    }
}

/// Stopping when samples happen to agree could favour the dark or the bright.
#[test]
fn the_mean_of_many_pictures_is_the_mean_of_one_of_many_samples() {
    let scene = leaves500();
    let truth = picture(&scene, &Job { sampling: Sampling::Exactly(512), ..until(0.05) });
    let truth = mean(&luminances(&truth.frame));
    let ratios: Vec<f64> = (0..32)
        .map(|seed| mean(&luminances(&picture(&scene, &Job { seed, ..until(0.1) }).frame)) / truth)
        .collect();
    let average = mean(&ratios);
    assert!((average - 1.0).abs() < 5e-4, "{average}");
}

#[test]
fn a_picture_without_noise_takes_one_pass() {
    let mut scene = camera_at(DVec3::ZERO);
    scene.background = Rgb::new(0.5, 0.6, 0.7);
    for lights in 0..2 {
        let Rendered { frame, statistics } = picture(&scene, &until(0.001));
        assert_eq!((statistics.rounds, statistics.unconverged_blocks), (1, 0), "{lights} lights");
        assert!(statistics.error.is_some_and(|error| error < 1e-12), "{lights} lights: {statistics:?}");
        let per_pixel = statistics.samples as f64 / luminances(&frame).len() as f64;
        assert!((7.9..8.1).contains(&per_pixel), "{per_pixel}");
        add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::new(0.2, -1.0, -0.3), Rgb::ONE);
    }
}

/// A few points of a large sun throw a few sharp shadows, between which nothing tells that they are wrong: no
/// block ends with so few.
#[test]
fn half_shadows_are_not_judged_by_a_few_points_of_the_sun() {
    let scene = leaf_before_two_hues();
    for (tolerance, fewest) in [(0.2, 16.0), (0.3, 3.0)] {
        let Rendered { frame, statistics } = picture(&scene, &until(tolerance));
        let a_pixel = statistics.samples as f64 / luminances(&frame).len() as f64;
        assert!((0.99 * fewest..2.0 * fewest).contains(&a_pixel), "{a_pixel} to {tolerance}");
    }
}

#[test]
fn black_is_not_refined_forever() {
    let statistics = picture(&camera_at(DVec3::ZERO), &until(1e-6)).statistics;
    assert_eq!((statistics.rounds, statistics.error), (1, Some(0.0)));
}

#[test]
fn fewer_and_fewer_blocks_go_on() {
    let scene = leaves500();
    let samples: Vec<f64> = [0.1, 0.05, 0.025]
        .map(|tolerance| {
            let statistics = picture(&scene, &until(tolerance)).statistics;
            assert!(statistics.error.expect("judged") <= tolerance);
            let a_pixel = statistics.samples as f64 / (SIZE.width * SIZE.height) as f64;
            // Had all blocks gone on, each pass would have doubled the eight samples of the first.
            let all = f64::from(8 << (statistics.rounds - 1));
            assert!(statistics.rounds == 1 || a_pixel < 0.7 * all, "{a_pixel} of {all} at {tolerance}");
            a_pixel
        })
        .into();
    assert!(samples[0] < samples[1] && samples[1] < samples[2], "{samples:?}");
}

#[test]
fn no_pixel_has_more_samples_than_it_may() {
    let mut job = until(1e-6);
    for (most, taken) in [(2, 2), (7, 7), (8, 8), (21, 20), (48, 48)] {
        job.sampling = Sampling::Until { tolerance: 1e-6, most };
        let statistics = picture(&leaves500(), &job).statistics;
        let a_pixel = statistics.samples as f64 / (SIZE.width * SIZE.height) as f64;
        // A block without any error ends before.
        let taken = f64::from(taken);
        assert!((0.99 * taken - 0.1..taken + 0.1).contains(&a_pixel), "{a_pixel} of {taken}");
        assert!(statistics.unconverged_blocks > statistics.blocks / 4, "{statistics:?}");
    }
}

/// Of one light or several, each judged by those before.
#[test]
fn a_part_has_the_pixels_of_the_whole() {
    parts_have_the_pixels_of_the_whole(leaves500());
}

#[test]
fn a_part_has_the_smoothed_shafts_of_the_whole() {
    parts_have_the_pixels_of_the_whole(leaves_under_a_wide_sun());
}

fn parts_have_the_pixels_of_the_whole(mut scene: Scene) {
    for lights in [1, 2] {
        for method in [Method::Slices, Method::Segments] {
            let job = Job { method, ..until(0.03) };
            let whole = picture(&scene, &job).frame;
            for (x, y) in [(13, 31), (21, 9), (45, 42), (69, 31)] {
                let window = Window { x, y, width: 19, height: 14 };
                let part = picture(&scene, &Job { window, ..job.clone() }).frame;
                assert!(part == whole.part(window), "{method:?}, {lights} lights, from ({x}, {y})");
            }
        }
        add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::new(0.3, -1.0, 0.4), Rgb::splat(10.0));
    }
}

#[test]
fn threads_do_not_show() {
    let scene = leaves500();
    let rendered = [1, 2, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| picture(&scene, &until(0.1)))
    });
    assert!(rendered[0] == rendered[1] && rendered[0] == rendered[2]);
}

/// A faint light's picture need not be as good by itself as the sum.
#[test]
fn lights_are_judged_together() {
    let mut scene = leaves500();
    let sun_alone = picture(&scene, &until(0.1)).statistics.samples;
    add_light(&mut scene, LightKind::Point, DVec3::new(1.5, 4.0, 1.0), DVec3::NEG_Y, Rgb::splat(0.01));
    let both = picture(&scene, &until(0.1)).statistics;
    let of_lamp = (both.samples - sun_alone) as f64 / sun_alone as f64;
    // The sun's part has to be better by the square root of two, so that there is room for the lamp's.
    assert!(of_lamp < 1.6, "{of_lamp}");
    scene.lights[1].power = Rgb::splat(20.0).into();
    let judged = judge(&scene, &Job { window: PART, ..until(0.1) }, 256, 2);
    assert_honest(&judged, 0.1);
}
