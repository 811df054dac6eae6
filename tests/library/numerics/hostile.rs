//! Scenes that nobody would build: a few triangles on a coarse grid, at any scale, in any fog. Vertices,
//! edges, planes, the light and the fog's faces coincide in them.

use crate::common::{EXACT, INSTANT};
use crate::numerics::compare::{SlicePlan, by_slices, per_ray};
use crate::numerics::scenes::{Frame, Lamp, add_triangles, empty, fog, light, spread};
use glam::{DVec3, Vec3};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use sunfleck::passes::Pass;
use sunfleck::render::{Job, Method, Watch, render};
use sunfleck::scene::{PixelFilter, Sampling, Scene, Size, Window};
use sunfleck::snapshot::{Exposure, MeshTrees};

/// A place of the grid in front of the camera; some of its planes go through the camera.
fn place() -> impl Strategy<Value = Vec3> {
    let side = || prop::sample::select(vec![-1.0_f32, -0.5, 0.0, 0.5, 1.0]);
    (side(), side(), prop::sample::select(vec![-0.5_f32, -1.0, -1.5, -3.0]))
        .prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

fn lamp() -> impl Strategy<Value = Lamp> {
    let side = || prop::sample::select(vec![-1.0, -0.5, 0.0, 0.5, 1.0]);
    // Off the grid, but in many of its planes.
    let off_grid = DVec3::new(0.25, 0.25, 0.2);
    let near = place().prop_map(move |place| Lamp::Point { position: place.as_dvec3() + off_grid });
    let far = (side(), side(), side())
        .prop_map(|(x, y, z)| DVec3::new(x, y, z))
        .prop_filter("a direction", |to_sun| *to_sun != DVec3::ZERO)
        .prop_map(|to_sun| Lamp::Sun { to_sun });
    prop_oneof![near, far]
}

fn scene() -> impl Strategy<Value = Scene> {
    let triangles = prop::collection::vec([place(), place(), place()], 0..7);
    let bank = (
        place(),
        place(),
        -6.0..3.5_f64,
        prop::sample::select(vec![-0.999, -0.99, -0.9, 0.0, 0.5, 0.9, 0.99, 0.999]),
    );
    let banks = prop::collection::vec(bank, 0..3);
    let parts = (triangles, banks, lamp(), -4.0..4.0_f64);
    // Whose shadow falls which way is then a matter of rounding (docs/builders/numerics.md).
    let parts = parts.prop_filter("a lamp on no triangle", |(triangles, _, lamp, _)| {
        triangles.iter().all(|triangle| !lies_on(lamp, triangle))
    });
    parts.prop_map(|(triangles, banks, lamp, log_scale)| {
        let frame = Frame { scale: 10_f64.powf(log_scale), offset: DVec3::ZERO };
        let mut scene = empty(&frame);
        add_triangles(&mut scene, &frame, &triangles);
        for (a, b, log_density, g) in banks {
            let (a, b) = (a.as_dvec3(), b.as_dvec3());
            fog(&mut scene, &frame, a.min(b), a.max(b), 10_f64.powf(log_density), g);
        }
        light(&mut scene, &frame, lamp);
        scene
    })
}

/// Whether a lamp is part of a triangle, to rounding: the three about it are then as large as it is together.
fn lies_on(lamp: &Lamp, triangle: &[Vec3; 3]) -> bool {
    let Lamp::Point { position } = *lamp else { return false };
    let [a, b, c] = triangle.map(|corner| corner.as_dvec3());
    let area = |a: DVec3, b: DVec3, c: DVec3| (b - a).cross(c - a).length();
    let about = area(position, a, b) + area(position, b, c) + area(position, c, a);
    about <= area(a, b, c) + 1e-9
}

/// Behind fog of a thousand depths, or with every ray in shadow but one, relative errors mean nothing.
const DIM: f64 = 1e-4;

/// The same scenes every time; more and others by the environment.
fn config() -> ProptestConfig {
    fn number<T: std::str::FromStr>(name: &str, otherwise: T) -> T {
        std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
    }
    ProptestConfig {
        cases: number("HOSTILE_CASES", 600),
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(number("HOSTILE_SEED", 5)),
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn rays_and_slices_are_true(scene in scene()) {
        let by_rays = per_ray(&scene, 1.0, spread(20));
        prop_assert_eq!(by_rays.verdict_above(DIM, 1e-3), Ok(()), "per ray");
        let slices = by_slices(&scene, &SlicePlan::even(Size { width: 8, height: 8 }, 5, 5));
        prop_assert_eq!(slices.verdict_above(DIM, 1e-3), Ok(()), "slices");
    }

    #[test]
    fn pictures_are_sane(
        scene in scene(),
        (width, height) in (1..9_usize, 1..9_usize),
        method in prop::sample::select(vec![Method::Slices, Method::Segments]),
        samples in prop::sample::select(vec![1_u32, 3, 16]),
    ) {
        let size = Size { width, height };
        let job = Job {
            size,
            window: Window::whole(size),
            passes: vec![Pass::Transmittance, Pass::Shafts],
            sampling: Sampling::Exactly(samples),
            filter: PixelFilter::Box,
            seed: 3,
            mirror_depth: EXACT.mirror_depth, bounces: sunfleck::scene::Bounces::NONE,
            method,
        };
        let trees = MeshTrees::new(&scene);
        let exposure = Exposure::new(&scene, &trees, 0, width as f64 / height as f64, INSTANT);
        let picture = render(&exposure, &job, &Watch::NOBODY).frame;
        for channel in &picture.channels {
            let most = if channel.name.starts_with("transmittance") || channel.name == "A" { 1.0 } else { f32::INFINITY };
            for value in &channel.pixels {
                prop_assert!(value.is_finite() && (0.0..=most).contains(value), "{}: {value}", channel.name);
            }
        }
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        let again = alone.install(|| render(&exposure, &job, &Watch::NOBODY).frame);
        prop_assert!(again == picture, "other threads, another picture");
    }
}
