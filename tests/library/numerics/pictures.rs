//! Pictures of one pixel, one row and one column, through a pinhole and nearly all around. Whole pictures
//! with a lamp exactly at the camera.

use crate::common::EXACT;
use crate::common::INSTANT;
use crate::numerics::compare::{SlicePlan, by_slices, per_ray};
use crate::numerics::scenes::{Frame, HIGH_SUN, LAMP, Lamp, fog, grove, spread};
use glam::DVec3;
use sunfleck::film::Frame as Picture;
use sunfleck::render::{Choice, Job, Method, Reason, Watch, choose, render};
use sunfleck::scene::{Lens, PixelFilter, Sampling, Scene, Size, Track, Window};
use sunfleck::snapshot::{Exposure, MeshTrees};

/// In front of the camera, so that the light's image is in the picture however narrow.
const AHEAD: Lamp = Lamp::Sun { to_sun: DVec3::new(1e-4, 2e-4, -1.0) };

fn with_view(lamp: Lamp, fov_y_deg: f64) -> Scene {
    let mut scene = grove(&Frame::HERE, lamp);
    scene.cameras[0].lens = Lens::Perspective { fov_y: Track::from(fov_y_deg.to_radians()) };
    scene
}

/// A whole picture; all of it must be a number and not negative.
pub(crate) fn picture(scene: &Scene, size: Size, samples: u32, method: Method) -> (Picture, Choice) {
    let job = Job {
        size,
        window: Window::whole(size),
        passes: Vec::new(),
        sampling: Sampling::Exactly(samples),
        filter: PixelFilter::Box,
        seed: 1,
        mirror_depth: EXACT.mirror_depth,
        bounces: sunfleck::scene::Bounces::NONE,
        method,
    };
    let aspect = size.width as f64 / size.height as f64;
    let trees = MeshTrees::new(scene);
    let exposure = Exposure::new(scene, &trees, 0, aspect, INSTANT);
    let frame = render(&exposure, &job, &Watch::NOBODY).frame;
    for name in ["R", "G", "B", "A"] {
        let channel = frame.channel(name).expect("a colour");
        let is_sane = channel.pixels.iter().all(|value| value.is_finite() && *value >= 0.0);
        assert!(is_sane, "{name} of {size:?} by {method:?}");
    }
    (frame, choose(&exposure))
}

pub(crate) fn mean(frame: &Picture) -> f64 {
    let pixels = &frame.channel("R").expect("red").pixels;
    pixels.iter().map(|value| f64::from(*value)).sum::<f64>() / pixels.len() as f64
}

#[test]
fn fields_of_view() {
    for lamp in [HIGH_SUN, LAMP, AHEAD] {
        for fov_y_deg in [1e-4, 1e-2, 179.0, 179.9] {
            let scene = with_view(lamp, fov_y_deg);
            let name = format!("field of view of {fov_y_deg} degrees, {lamp:?}");
            per_ray(&scene, 1.0, spread(100)).hold(&format!("{name}, per ray"), 1e-6);
            let plan = SlicePlan::even(Size { width: 64, height: 64 }, 13, 13);
            by_slices(&scene, &plan).hold(&format!("{name}, slices"), 1e-6);
        }
    }
}

#[test]
fn rows_and_columns() {
    for lamp in [HIGH_SUN, LAMP, AHEAD] {
        for (width, height) in [(1, 1), (1, 10_000), (10_000, 1)] {
            let size = Size { width, height };
            let scene = with_view(lamp, if width > height { 0.02 } else { 60.0 });
            let name = format!("{width} x {height} pixels, {lamp:?}");
            by_slices(&scene, &SlicePlan::even(size, 13, 13)).hold(&format!("{name}, slices"), 1e-6);
            // The same light in whole pictures, whatever way they are made.
            let samples = if width * height == 1 { 1024 } else { 16 };
            let [slices, rays] = [Method::Slices, Method::Segments]
                .map(|method| mean(&picture(&scene, size, samples, method).0));
            println!("{name}: means differ by {:.1e}", (slices / rays - 1.0).abs());
            // Around a lamp in the picture light grows without bound, and means converge slowly.
            let bound = if matches!(lamp, Lamp::Point { .. }) { 0.1 } else { 0.02 };
            assert!((slices / rays - 1.0).abs() < bound, "{name}: {slices} {rays}");
        }
    }
}

/// A lamp that the camera holds has no slices: rays take over, without a seam to one beside it.
#[test]
fn lamp_at_the_camera() {
    let size = Size { width: 24, height: 16 };
    let lit_from = |distance: f64, fog_from: f64| {
        let position = distance * DVec3::new(0.6, 0.8, 0.0);
        let mut scene = grove(&Frame::HERE, Lamp::Point { position });
        scene.fogs.clear();
        let (low, high) = (DVec3::new(-6.0, -1.5, -10.0), DVec3::new(6.0, 4.0, fog_from));
        fog(&mut scene, &Frame::HERE, low, high, 0.15, 0.6);
        scene
    };
    // Outside the fog.
    let there = lit_from(0.0, -0.5);
    let (at_camera, choice) = picture(&there, size, 64, Method::Auto);
    assert_eq!((choice.method, choice.reason), (Method::Segments, Reason::LightAtCamera));
    assert_eq!(at_camera, picture(&there, size, 64, Method::Slices).0, "slices step aside");
    per_ray(&there, 1.0, spread(100)).hold("lamp at the camera, fog ahead", 1e-6);
    let (beside, choice) = picture(&lit_from(1e-9, -0.5), size, 64, Method::Auto);
    assert_eq!(choice.method, Method::Slices);
    let change = (mean(&at_camera) / mean(&beside) - 1.0).abs();
    println!("lamp at the camera and a nanometre beside: means differ by {change:.1e}");
    assert!(change < 0.01, "{change}");
    // In the fog what is scattered just before the camera has no bound: a large number, but a number.
    picture(&lit_from(0.0, 1.0), size, 4, Method::Auto);
}
