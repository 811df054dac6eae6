//! Pictures that average over more than a pixel: a lens, a shutter, a light with an extent. Two ways
//! to them: each ray with draws of its own, and each slice.

use crate::checkout;
use crate::common::camera_at;
use crate::indirect::{EVEN_SKY, add_box};
use glam::{DAffine3, DQuat, DVec3};
use sunfleck::color::Rgb;
use sunfleck::film::Frame;
use sunfleck::render::{Job, Method, Watch, render};
use sunfleck::scene::{
    Aperture, Bounces, Extend, Key, LightKind, Material, Motion, PixelFilter, Rotation, Sampling, Scene,
    Segment, Size, Sky, SunDisc, Track, Window,
};
use sunfleck::snapshot::{Exposure, MeshTrees, Shutter};
use sunfleck::{description, scene};

const SIZE: Size = Size { width: 64, height: 36 };

fn leaves500() -> Scene {
    let path = checkout::file("tests/data/leaves500/leaves500.glb");
    scene::resolve(description::load(&path).expect("a good file"), None).expect("a good scene").0
}

fn with_a_lens(mut scene: Scene) -> Scene {
    scene.cameras[0].aperture = Some(Aperture {
        f_stop: Track::from(0.5),
        sensor_width_m: 0.036,
        focus_distance_m: Track::from(6.0),
        blades: 5,
    });
    scene
}

/// The camera travels by 30 cm a second, and turns a little towards where it is going.
fn with_a_travelling_camera(mut scene: Scene) -> Scene {
    let key = |time_s: f64, x: f64| Key { time_s, value: DVec3::new(x, 1.7, 9.0), to_next: Segment::Linear };
    let position = Track::new(vec![key(-1.0, -0.3), key(1.0, 0.3)], Extend::Hold).expect("good keys");
    let node = scene.cameras[0].node;
    scene.nodes[node].motion =
        Motion::Aimed { position, target: DVec3::new(0.0, 2.6, 0.0).into(), up: DVec3::Y.into() };
    scene
}

/// Every leaf flies by 80 cm a second, the camera keeps still.
fn with_flying_leaves(mut scene: Scene) -> Scene {
    let nodes: Vec<usize> = scene.instances.iter().map(|leaf| leaf.node).collect();
    for node in nodes {
        let Motion::Still(place) = scene.nodes[node].motion else { continue };
        let (scale, rotation, middle) = place.to_scale_rotation_translation();
        let way = DVec3::new(0.4, 0.1, 0.0);
        let key = |time_s: f64| Key { time_s, value: middle + 2.0 * time_s * way, to_next: Segment::Linear };
        let translation = Track::new(vec![key(-1.0), key(1.0)], Extend::Hold).expect("good keys");
        scene.nodes[node].motion = Motion::Keyed {
            translation,
            rotation: Rotation::Quaternion(rotation.into()),
            scale: scale.into(),
        };
    }
    scene
}

/// A shutter has 33 moments for 250,000 leaves, seven for a million, which is said; and one if nothing moves.
#[test]
fn many_leaves_have_fewer_moments() {
    let mut scene = with_flying_leaves(leaves500());
    assert!(Exposure::remark(&scene, 0.5).is_none());
    let leaf = scene.instances[0].clone();
    scene.instances.resize(250_000, leaf.clone());
    assert!(Exposure::remark(&scene, 0.5).is_none());
    scene.instances.resize(1_000_000, leaf);
    assert!(Exposure::remark(&scene, 0.0).is_none());
    let said = Exposure::remark(&scene, 0.5).expect("something to say").to_string();
    assert!(said.contains("from 7 moments of the shutter in place of 33"), "{said}");
    let mut still = leaves500();
    let leaf = still.instances[0].clone();
    still.instances.resize(1_000_000, leaf);
    assert!(Exposure::remark(&still, 0.5).is_none());
}

fn picture(scene: &Scene, shutter: Shutter, samples: u32, seed: u32, method: Method) -> Frame {
    rendered(scene, shutter, &job(samples, seed, method))
}

fn rendered(scene: &Scene, shutter: Shutter, job: &Job) -> Frame {
    let trees = MeshTrees::new(scene);
    let exposure = Exposure::new(scene, &trees, 0, 16.0 / 9.0, shutter);
    render(&exposure, job, &Watch::NOBODY).frame
}

fn job(samples: u32, seed: u32, method: Method) -> Job {
    Job {
        size: SIZE,
        window: Window::whole(SIZE),
        passes: vec![],
        sampling: Sampling::Exactly(samples),
        filter: PixelFilter::Box,
        seed,
        mirror_depth: crate::common::EXACT.mirror_depth,
        bounces: Bounces::NONE,
        method,
    }
}

fn colours(frame: &Frame) -> Vec<f64> {
    let channels = ["R", "G", "B"].map(|name| frame.channel(name).expect("a colour").pixels.clone());
    channels.concat().into_iter().map(f64::from).collect()
}

fn mean_square(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64
}

/// Both ways see the same picture, with less error the more samples there are.
fn assert_same_picture(scene: &Scene, shutter: Shutter) {
    // Two halves of the truth tell its own noise, which is taken off.
    let halves = [1, 2].map(|seed| colours(&picture(scene, shutter, 40, seed, Method::Segments)));
    let truth: Vec<f64> = halves[0].iter().zip(&halves[1]).map(|(a, b)| 0.5 * (a + b)).collect();
    let noise = 0.25 * mean_square(&halves[0], &halves[1]);
    let errors = [4, 16, 64].map(|samples| {
        let slices = colours(&picture(scene, shutter, samples, 0, Method::Slices));
        let error = (mean_square(&slices, &truth) - noise).max(0.0).sqrt();
        let ratio = slices.iter().sum::<f64>() / truth.iter().sum::<f64>();
        // The mean of so small a picture is noisy too.
        assert!((ratio - 1.0).abs() < 0.02 / f64::from(samples).sqrt(), "{samples} samples: {ratio}");
        error
    });
    assert!(errors[1] < 0.6 * errors[0] && errors[2] < 0.6 * errors[1], "{errors:?} {noise:e}");
    assert!(errors[2] < 0.015, "{errors:?} {noise:e}");
}

const INSTANT: Shutter = crate::common::INSTANT;
const HALF_A_SECOND: Shutter = Shutter { open_s: -0.25, close_s: 0.25 };

#[test]
fn a_lens_blurs_alike() {
    assert_same_picture(&with_a_lens(leaves500()), INSTANT);
}

#[test]
fn a_shutter_blurs_alike() {
    assert_same_picture(&with_a_travelling_camera(leaves500()), HALF_A_SECOND);
}

/// Slices all lie in the same planes at all moments, and yet few of them are not enough.
#[test]
fn leaves_that_fly_past_blur_as_well_as_by_rays() {
    let scene = with_flying_leaves(leaves500());
    assert_same_picture(&scene, HALF_A_SECOND);
    let [truth, slices, rays] =
        [(128, 1, Method::Segments), (16, 0, Method::Slices), (16, 0, Method::Segments)]
            .map(|(samples, seed, method)| colours(&picture(&scene, HALF_A_SECOND, samples, seed, method)));
    let (slices, rays) = (mean_square(&slices, &truth), mean_square(&rays, &truth));
    assert!(slices < 1.5 * rays, "{slices:e} {rays:e}");
}

/// A white box in a furnace is not seen, also while it comes nearer: its light is of where it is in the
/// middle, and half of the time its front is within the box of that moment.
#[test]
fn what_moves_is_lit_from_outside() {
    let mut scene = camera_at(DVec3::ZERO);
    let white = Material { base_color: Rgb::ONE, ..Material::default() };
    add_box(&mut scene, DVec3::new(-1.0, -1.0, -7.0), DVec3::new(1.0, 1.0, -5.0), white);
    scene.sky = Sky::new(EVEN_SKY);
    let key = |time_s: f64| Key { time_s, value: time_s * DVec3::Z, to_next: Segment::Linear };
    let node = scene.instances[0].node;
    scene.nodes[node].motion = Motion::Keyed {
        translation: Track::new(vec![key(-1.0), key(1.0)], Extend::Hold).expect("good keys"),
        rotation: Rotation::Quaternion(DQuat::IDENTITY.into()),
        scale: DVec3::ONE.into(),
    };
    let job = Job { bounces: Bounces::All, ..job(16, 0, Method::Segments) };
    let seen = colours(&rendered(&scene, HALF_A_SECOND, &job));
    let mean = seen.iter().sum::<f64>() / seen.len() as f64;
    println!("a white box that comes nearer: {mean:.4}");
    assert!((mean - 1.0).abs() < 0.01, "{mean}");
}

#[test]
fn a_lens_and_a_shutter_blur_alike() {
    assert_same_picture(&with_a_lens(with_a_travelling_camera(leaves500())), HALF_A_SECOND);
}

#[test]
fn a_sun_with_a_disc_shades_alike() {
    let mut scene = leaves500();
    scene.lights[0].kind = LightKind::SunDisc(SunDisc::even(Track::from(0.06)));
    assert_same_picture(&scene, INSTANT);
}

/// Above the picture's edge, and so large that the fans of its slices wander over a good part of it.
#[test]
fn a_glowing_ball_beside_the_picture_shades_alike() {
    let mut scene = leaves500();
    let node = scene.lights[0].node;
    scene.nodes[node].motion = Motion::Still(DAffine3::from_translation(DVec3::new(1.5, 7.0, 3.0)));
    scene.lights[0].kind = LightKind::Sphere { radius: Track::from(0.4) };
    scene.lights[0].power = Track::from(Rgb::splat(50.0));
    assert_same_picture(&scene, INSTANT);
}
