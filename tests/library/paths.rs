//! Random walks of all orders: closed forms, the same light on a grid, and what Mitsuba makes of it. What is
//! random is judged by its own spread: `seeds` estimates of the same, each from other random numbers, tell
//! their mean's standard error.

use crate::common::{INSTANT, add_fog, add_layer, add_light, camera_at, coat};
use crate::indirect::{
    EVEN_SKY, add_box, add_instance, add_leaf, add_leaves, dark_room, leaves500, picture, truth,
};
use glam::{DVec2, DVec3, Vec3};
use std::f64::consts::PI;
use std::sync::Arc;
use sunfleck::color::Rgb;
use sunfleck::indirect::{Indirect, KeptLight};
use sunfleck::math::Sampler;
use sunfleck::passes::Pass;
use sunfleck::render::{Job, Method, Watch, render};
use sunfleck::scene::{
    AlphaMode, AreaShape, Bounces, Clearcoat, Coat, LightKind, Material, Mesh, PixelFilter, Sampling, Scene,
    Sheen, Size, Sky, SkyPicture, Track, Triangle, Window,
};
use sunfleck::snapshot::{Exposure, MeshTrees, Snapshot};
use sunfleck::transport::{
    Branches, Component, Learned, Roots, Sample, Scratch, Transport, VolumeMethod, radiance, shared_light,
};

/// Along each side of the picture.
const RAYS: u32 = 6;
const SEEDS: u32 = 16;
/// How far a right estimate is off by chance, in standard errors: once in 16,000 times.
const SIGMAS: f64 = 4.0;

/// Calls `add` with all samples of all rays, seed by seed.
fn for_each_sample(
    scene: &Scene,
    transport: &Transport,
    (seeds, samples): (u32, u32),
    mut add: impl FnMut(u32, &Sample),
) {
    let snapshot = Snapshot::new(scene, &MeshTrees::new(scene), 0, 1.0, INSTANT);
    let mut scratch = Scratch::default();
    for seed in 0..seeds {
        for number in 0..RAYS * RAYS * samples {
            let (x, y, sample) = (number % RAYS, number / RAYS % RAYS, number / (RAYS * RAYS));
            let place = (DVec2::new(x.into(), y.into()) + 0.5) / f64::from(RAYS);
            let mut sampler = Sampler::new(seed, x, y, sample);
            let ray = snapshot.view.ray(place.x, place.y);
            add(seed, &radiance(&snapshot, transport, &ray, &mut sampler, &mut scratch));
        }
    }
}

fn by_paths(bounces: Bounces) -> Transport<'static> {
    Transport { volume: VolumeMethod::Paths(bounces), mirror_depth: 12, indirect: None, features: false }
}

/// The mean radiance of the picture, and its standard error.
fn estimate(scene: &Scene, transport: &Transport, samples: u32) -> (Rgb, Rgb) {
    mean_and_error(&means_by_seed(scene, transport, samples))
}

fn means_by_seed(scene: &Scene, transport: &Transport, samples: u32) -> [Rgb; SEEDS as usize] {
    let mut means = [Rgb::ZERO; SEEDS as usize];
    for_each_sample(scene, transport, (SEEDS, samples), |seed, sample| {
        means[seed as usize] += sample.radiance / f64::from(RAYS * RAYS * samples);
    });
    means
}

fn mean_and_error(means: &[Rgb]) -> (Rgb, Rgb) {
    let count = f64::from(SEEDS);
    let mean = means.iter().sum::<Rgb>() / count;
    let square = means.iter().map(|of_seed| (*of_seed - mean) * (*of_seed - mean)).sum::<Rgb>();
    (mean, (square / (count * (count - 1.0))).map(f64::sqrt))
}

/// All three channels are what is expected, to `slack` and to chance, which is little.
fn assert_is(name: &str, scene: &Scene, bounces: Bounces, samples: u32, expected: f64, slack: f64) {
    let (mean, error) = estimate(scene, &by_paths(bounces), samples);
    println!("{name}: {mean:.4} +- {error:.4}, expected {expected:.4}");
    assert!(error.max_element() < 0.02 * expected, "{name}: {error} tells little");
    let off = (mean - expected).abs() - SIGMAS * error;
    assert!(off.max_element() <= slack + 1e-9, "{name}: {mean} +- {error}, expected {expected}");
}

fn matte(reflected: f64, transmitted: f64) -> Material {
    Material {
        base_color: Rgb::splat(reflected),
        transmission: Rgb::splat(transmitted),
        ..Material::default()
    }
}

/// Nothing in it absorbs.
fn white_surfaces() -> Vec<(&'static str, Material)> {
    let coat = Coat {
        metallic: 0.0,
        roughness: 0.4,
        texture: None,
        f0: Rgb::splat(0.04),
        f0_texture: None,
        f90: 1.0,
    };
    vec![
        ("reflecting", matte(1.0, 0.0)),
        ("transmitting", matte(0.3, 0.7)),
        ("coated", Material { coat: Some(coat), ..matte(1.0, 0.0) }),
        ("half a mirror", Material { mirror: Rgb::splat(0.4), ..matte(0.6, 0.0) }),
        ("blended", Material { alpha_mode: AlphaMode::Blend, opacity: 0.6, ..matte(0.5, 0.5) }),
    ]
}

/// What absorbs nothing, in even light from all sides, cannot be seen.
#[test]
fn white_leaves_in_a_furnace_are_not_seen() {
    for (name, material) in white_surfaces() {
        for sky in [EVEN_SKY, SkyPicture::Even(Rgb::ONE)] {
            let mut scene = camera_at(DVec3::ZERO);
            add_leaves(&mut scene, 300, material.clone());
            scene.sky = Sky::new(sky);
            // Coats give back what they receive within 6e-4 at each scattering.
            assert_is(name, &scene, Bounces::All, 8, 1.0, 2e-3);
        }
    }
}

#[test]
fn white_fog_in_a_furnace_is_not_seen() {
    let grey = Rgb::splat(0.8);
    for (name, densities, g) in [
        ("thin", vec![Rgb::splat(0.1)], 0.0),
        ("thick", vec![Rgb::splat(1.5)], 0.6),
        ("coloured", vec![Rgb::new(0.1, 0.6, 2.0)], -0.4),
        ("two fogs", vec![Rgb::new(0.2, 0.1, 0.9), grey], 0.3),
    ] {
        let mut scene = camera_at(DVec3::ZERO);
        let middle = -5.0 * DVec3::Z;
        for (number, density) in densities.into_iter().enumerate() {
            let half = 2.0 / (1.0 + number as f64);
            add_fog(&mut scene, middle - half, middle + half, density, Rgb::ONE, g - 0.8 * number as f64);
        }
        scene.sky = Sky::new(EVEN_SKY);
        assert_is(name, &scene, Bounces::All, 16, 1.0, 0.0);
    }
}

/// A room whose walls all emit `1 - a` and reflect `a` has radiance 1 everywhere, and
/// `(1 - a) (1 + a + ... + a^(N + 1))` after N bounces, and nothing but the walls' own after none: Kirchhoff.
#[test]
fn walls_that_glow_add_up_order_by_order() {
    let room = |reflectance: f64| {
        let mut scene = camera_at(DVec3::ZERO);
        let wall = Material { emission: Rgb::splat(1.0 - reflectance), ..matte(reflectance, 0.0) };
        add_box(&mut scene, DVec3::splat(-8.0), DVec3::splat(8.0), wall);
        scene
    };
    let walls = room(0.6);
    for (bounces, expected) in [(0, 0.4), (1, 0.784), (2, 0.8704), (5, 0.972_006_4)] {
        assert_is("walls", &walls, Bounces::UpTo(bounces), 4, expected, 1e-9);
    }
    assert_is("walls", &walls, Bounces::All, 4, 1.0, 0.0);
    let mut full = room(0.6);
    add_leaves(&mut full, 200, matte(0.4, 0.6));
    add_fog(&mut full, DVec3::splat(-7.0), DVec3::splat(7.0), Rgb::new(0.05, 0.1, 0.2), Rgb::ONE, 0.5);
    assert_is("walls, leaves and fog", &full, Bounces::All, 16, 1.0, 0.0);
}

/// Of two facing planes one glows: `B1 = M / (1 - a1 a2)`, `B2 = a2 B1`. They are 2000 times as
/// wide as they are apart.
#[test]
fn facing_planes_have_the_light_of_the_closed_form() {
    let mut scene = camera_at(DVec3::ZERO);
    let wide = DVec3::new(2000.0, 2000.0, 0.0);
    let shining = Material { emission: Rgb::ONE, ..matte(0.7, 0.0) };
    add_box(&mut scene, DVec3::new(0.0, 0.0, 1.0) - wide, DVec3::new(0.0, 0.0, 1.1) + wide, shining);
    add_box(
        &mut scene,
        DVec3::new(0.0, 0.0, -1.1) - wide,
        DVec3::new(0.0, 0.0, -1.0) + wide,
        matte(0.5, 0.0),
    );
    assert_is("second plane", &scene, Bounces::All, 16, 0.5 / (1.0 - 0.35), 1e-5);
    assert_is("second plane, once", &scene, Bounces::UpTo(1), 1, 0.5, 1e-5);
}

/// A square of 2 cm that glows lights a wall as a point by Lambert's cosines: `a E A cos^2 / (pi r^2)`. A
/// walk meets it once in 30,000 times.
#[test]
fn what_glows_and_is_small_lights_a_wall() {
    const HALF_M: f64 = 0.01;
    let middle = DVec3::new(0.0, 2.0, -2.0);
    let mut scene = camera_at(DVec3::ZERO);
    add_box(&mut scene, DVec3::new(-8.0, -8.0, -4.1), DVec3::new(8.0, 8.0, -4.0), matte(0.5, 0.0));
    add_glowing_square(&mut scene, middle, HALF_M);
    let area = (2.0 * HALF_M).powi(2);
    let of = |cos: f64, distance: f64| 0.5 / PI * 1e3 * area * cos * cos / (distance * distance);
    let expected = mean_on_wall(&scene, of, middle);
    assert_is("a small glow", &scene, Bounces::UpTo(1), 1, expected, 1e-4 * expected);
}

/// A square across z that shines a thousand to both sides.
fn add_glowing_square(scene: &mut Scene, middle: DVec3, half_m: f64) {
    scene.materials.push(Material { emission: Rgb::splat(1e3), ..matte(0.0, 0.0) });
    let material = scene.materials.len() - 1;
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let positions = corners.map(|(x, y)| (middle + half_m * DVec3::new(x, y, 0.0)).as_vec3()).to_vec();
    let triangles = [[0, 1, 2], [0, 2, 3]].map(|vertices| Triangle { vertices, material }).to_vec();
    scene.meshes.push(Mesh { positions, triangles, ..Mesh::default() });
    add_instance(scene);
}

/// A square of 2 cm that glows in thin fog: `sigma / (4 pi) E A cos / r^2`, summed along each ray. Hardly any
/// walk collides near it, where all of the light is.
#[test]
fn what_glows_and_is_small_lights_fog() {
    const HALF_M: f64 = 0.01;
    const SIGMA_PER_M: f64 = 1e-3;
    const STEP_M: f64 = 1e-3;
    let middle = DVec3::new(0.1, 0.35, -3.0);
    let mut scene = camera_at(DVec3::ZERO);
    add_fog(&mut scene, DVec3::splat(-8.0), DVec3::splat(8.0), Rgb::splat(SIGMA_PER_M), Rgb::ONE, 0.0);
    add_glowing_square(&mut scene, middle, HALF_M);
    let snapshot = Snapshot::new(&scene, &MeshTrees::new(&scene), 0, 1.0, INSTANT);
    let along = |number: u32| -> f64 {
        let place = (DVec2::new((number % RAYS).into(), (number / RAYS).into()) + 0.5) / f64::from(RAYS);
        let ray = snapshot.view.ray(place.x, place.y);
        let steps = (8.0 / -ray.direction.z / STEP_M) as u32;
        let lit = |step: u32| {
            let t = STEP_M * (f64::from(step) + 0.5);
            let way = ray.at(t) - middle;
            let distance = way.length();
            way.z.abs() / distance.powi(3) * (-SIGMA_PER_M * (t + distance)).exp()
        };
        (0..steps).map(lit).sum()
    };
    let sum: f64 = (0..RAYS * RAYS).map(along).sum();
    let scattered = 1e3 * (2.0 * HALF_M).powi(2) * SIGMA_PER_M / (4.0 * PI);
    let expected = scattered * STEP_M * sum / f64::from(RAYS * RAYS);
    let (mean, error) = estimate(&scene, &by_paths(Bounces::UpTo(1)), 4);
    println!("a small glow in fog: {:.5e} +- {:.1e} of {expected:.5e}", mean.x, error.x);
    assert!(error.x < 0.01 * expected, "{} of {expected}", error.x);
    // Twice scattered light is a thousandth of it.
    assert!((mean.x - expected).abs() < SIGMAS * error.x + 2e-3 * expected, "{} of {expected}", mean.x);
}

/// A lamp 1 mm before a board lights a spot that sends half of its light on: `2 a I cos` to where another
/// wall sees it under that angle. A walk meets the spot once in a million times.
#[test]
fn a_lamp_next_to_a_board_lights_a_wall_by_its_spot() {
    let middle = DVec3::new(0.0, 3.0, -2.0);
    let mut scene = camera_at(DVec3::ZERO);
    add_box(&mut scene, DVec3::new(-8.0, -8.0, -4.1), DVec3::new(8.0, 8.0, -4.0), matte(0.5, 0.0));
    let half = DVec3::new(0.5, 0.5, 0.05);
    let board = middle + 0.05 * DVec3::Z;
    add_box(&mut scene, board - half, board + half, matte(0.8, 0.0));
    add_light(&mut scene, LightKind::Point, middle - 1e-3 * DVec3::Z, DVec3::Z, Rgb::splat(3.0));
    let expected = mean_on_wall(
        &scene,
        |cos, distance| 0.5 / PI * 3.0 * cos / (distance * distance) * (1.0 + 2.0 * 0.8 * cos),
        middle,
    );
    assert_is("a spot by a lamp", &scene, Bounces::UpTo(1), 16, expected, 2e-3 * expected);
}

/// Fog about a lamp lights a wall: a point of the fog sends `a / pi sigma / (4 pi) I cos / (r d)^2` to a
/// point of the wall. Most of that light is close to the lamp, and hardly any leg passes there.
#[test]
fn fog_about_a_lamp_lights_a_wall() {
    const SIGMA_PER_M: f64 = 1e-3;
    // The camera does not see it.
    const HALF_M: f64 = 0.5;
    const DIRECTIONS: u32 = 256;
    const STEPS: u32 = 8;
    let middle = DVec3::new(0.0, 3.0, -2.0);
    let mut scene = camera_at(DVec3::ZERO);
    add_box(&mut scene, DVec3::new(-8.0, -8.0, -4.1), DVec3::new(8.0, 8.0, -4.0), matte(0.5, 0.0));
    add_light(&mut scene, LightKind::Point, middle, DVec3::Z, Rgb::splat(3.0));
    add_fog(&mut scene, middle - HALF_M, middle + HALF_M, Rgb::splat(SIGMA_PER_M), Rgb::ONE, 0.0);
    let along = |number: u32| -> f64 {
        let z = 1.0 - 2.0 * (f64::from(number) + 0.5) / f64::from(DIRECTIONS);
        let (sin, cos) = (2.0 * PI * (0.618_034 * f64::from(number)).fract()).sin_cos();
        let across = (1.0 - z * z).sqrt();
        let direction = DVec3::new(across * cos, across * sin, z);
        let step_m = HALF_M / direction.abs().max_element() / f64::from(STEPS);
        let lit = |step: u32| {
            let place = middle + (f64::from(step) + 0.5) * step_m * direction;
            step_m * mean_on_wall(&scene, |cos, distance| cos / (distance * distance), place)
        };
        (0..STEPS).map(lit).sum()
    };
    let mean_way: f64 = (0..DIRECTIONS).map(along).sum::<f64>() / f64::from(DIRECTIONS);
    let expected = 0.5 / PI * SIGMA_PER_M * 3.0 * mean_way;
    // Of the same places in pixels, so that the lamp's own light on the wall cancels.
    let [straight, all] =
        [Bounces::NONE, Bounces::UpTo(1)].map(|bounces| means_by_seed(&scene, &by_paths(bounces), 64));
    let differences: Vec<Rgb> = all.iter().zip(straight).map(|(all, straight)| *all - straight).collect();
    let (found, error) = mean_and_error(&differences);
    let found = found.x;
    println!("fog about a lamp: {found:.5e} +- {:.1e} of {expected:.5e}", error.x);
    assert!(error.x < 0.02 * expected, "{} of {expected}", error.x);
    // Light is dimmed by two thousandths on its way.
    assert!((found - expected).abs() < SIGMAS * error.x + 5e-3 * expected, "{found} of {expected}");
}

/// The mean over the picture of what a wall 4 m before the camera has of a place, by the cosine at the wall
/// and the distance.
fn mean_on_wall(scene: &Scene, of: impl Fn(f64, f64) -> f64, place: DVec3) -> f64 {
    let snapshot = Snapshot::new(scene, &MeshTrees::new(scene), 0, 1.0, INSTANT);
    let lit = |number: u32| {
        let film = (DVec2::new((number % RAYS).into(), (number / RAYS).into()) + 0.5) / f64::from(RAYS);
        let ray = snapshot.view.ray(film.x, film.y);
        let way = ray.at(-4.0 / ray.direction.z) - place;
        of(way.z.abs() / way.length(), way.length())
    };
    (0..RAYS * RAYS).map(lit).sum::<f64>() / f64::from(RAYS * RAYS)
}

/// Leaves in fog, as yet in the dark.
fn dark_leaves() -> Scene {
    let mut scene = camera_at(DVec3::ZERO);
    add_leaves(&mut scene, 300, matte(0.4, 0.3));
    let middle = -5.0 * DVec3::Z;
    add_fog(&mut scene, middle - 2.5, middle + 2.5, Rgb::new(0.1, 0.15, 0.3), Rgb::splat(0.9), 0.5);
    scene
}

const SUNBEAM: DVec3 = DVec3::new(0.3, -1.0, -0.4);
const SUNLIGHT: Rgb = Rgb::new(3.0, 2.0, 1.0);

fn sunny_leaves() -> Scene {
    let mut scene = dark_leaves();
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, SUNBEAM, SUNLIGHT);
    scene
}

/// A wall that a sky lights through a crown behind the camera: leaves of 4 cm, each mass of them a mesh of 20
/// cm. Cells of the grid are about as wide as a mass.
fn masses() -> Scene {
    const MASSES: usize = 1500;
    const LEAVES: usize = 40;
    let mut scene = camera_at(DVec3::ZERO);
    add_box(&mut scene, DVec3::new(-3.0, -3.0, -1.2), DVec3::new(3.0, 3.0, -1.0), matte(0.6, 0.0));
    scene.materials.push(matte(0.45, 0.35));
    let material = scene.materials.len() - 1;
    let mut sampler = Sampler::new(11, 0, 0, 0);
    let mut next = || DVec3::from(sampler.next_3d()) - 0.5;
    for _ in 0..MASSES {
        let middle = DVec3::new(6.0, 6.0, 3.0) * next() + 1.8 * DVec3::Z;
        let mut mesh = Mesh::default();
        for leaf in 0..LEAVES as u32 {
            let (place, normal) = (middle + 0.2 * next(), next().normalize());
            let (right, up) = normal.any_orthonormal_pair();
            let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
            mesh.positions.extend(corners.map(|(x, y)| (place + 0.02 * (x * right + y * up)).as_vec3()));
            let faces = [[0, 1, 2], [0, 2, 3]].map(|face| face.map(|corner| 4 * leaf + corner));
            mesh.triangles.extend(faces.map(|vertices| Triangle { vertices, material }));
        }
        scene.meshes.push(mesh);
        add_instance(&mut scene);
    }
    // A leaf that is not there at all, by itself.
    scene.materials.push(Material { alpha_mode: AlphaMode::Blend, opacity: 0.0, ..matte(0.5, 0.0) });
    let material = scene.materials.len() - 1;
    let corners = [Vec3::ZERO, 0.04 * Vec3::X, 0.04 * Vec3::Y];
    scene.meshes.push(Mesh {
        positions: corners.map(|corner| corner + Vec3::new(2.9, 2.9, 5.0)).to_vec(),
        triangles: vec![Triangle { vertices: [0, 1, 2], material }],
        ..Mesh::default()
    });
    add_instance(&mut scene);
    scene.sky = Sky::new(EVEN_SKY);
    scene
}

/// Suns are looked for where fog scatters, lamps all along a walk's legs: of a lamp so far
/// away both find the same.
#[test]
fn a_lamp_far_away_is_a_sun() {
    const FAR_M: f64 = 1e4;
    let mut scene = dark_leaves();
    let position = -FAR_M * SUNBEAM.normalize() - 5.0 * DVec3::Z;
    add_light(&mut scene, LightKind::Point, position, SUNBEAM, FAR_M * FAR_M * SUNLIGHT);
    let [(sun, error_of_sun), (lamp, error_of_lamp)] =
        [sunny_leaves(), scene].map(|scene| estimate(&scene, &by_paths(Bounces::All), 32));
    let error = (error_of_sun * error_of_sun + error_of_lamp * error_of_lamp).map(f64::sqrt);
    println!("lamp - sun: {:.4} +- {:.4} of the light", (lamp - sun) / sun, error / sun);
    assert!((error / sun).max_element() < 0.015, "{error} tells little");
    assert!(((lamp - sun).abs() - SIGMAS * error).max_element() < 0.0, "{lamp} {sun} +- {error}");
}

/// Walks look for a lamp's light all along their legs, and on rays of all lamps alike: the more dark ones,
/// the less often on its own. What they find is the same.
#[test]
fn dark_lamps_change_no_light() {
    let with_dark = |count: usize| {
        let mut scene = dark_leaves();
        for number in 0..=count {
            let power = Rgb::splat(if number == 0 { 20.0 } else { 1e-9 });
            let place = DVec3::new(0.3 - 0.2 * number as f64, 1.0, -4.0);
            let kind = LightKind::Spot { outer_angle: 0.9.into(), blend: 0.2.into(), radius: 0.0.into() };
            add_light(&mut scene, kind, place, DVec3::NEG_Z, power);
        }
        estimate(&scene, &by_paths(Bounces::All), 64)
    };
    let [(alone, error), (among_dark, other)] = [0, 3].map(with_dark);
    println!("alone {alone:.4} +- {error:.4}, among dark ones {among_dark:.4} +- {other:.4}");
    assert!(error.max_element() < 0.03 * alone.max_element(), "{error} tells little");
    let off = (alone - among_dark).abs() - SIGMAS * (error * error + other * other).map(f64::sqrt);
    assert!(off.max_element() <= 0.0, "{alone} alone, {among_dark} among dark ones");
}

/// Fog over a floor, in a sun that stands before the camera.
fn haze(g: f64) -> Scene {
    let mut scene = camera_at(DVec3::ZERO);
    let (low, high) = (DVec3::new(-5.0, -1.3, -10.0), DVec3::new(5.0, 3.0, 1.0));
    add_box(&mut scene, low - 0.5 * DVec3::Y, DVec3::new(high.x, low.y, high.z), matte(0.3, 0.0));
    add_fog(&mut scene, low, high, Rgb::splat(0.25), Rgb::splat(0.9), g);
    let (sunbeam, sunlight) = (DVec3::new(-0.35, -0.75, 0.56), Rgb::splat(3.0));
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, sunbeam, sunlight);
    scene
}

/// What faces the camera shines. A wall behind the camera glows.
fn shine(shining: Material) -> Scene {
    let mut scene = camera_at(DVec3::ZERO);
    add_box(&mut scene, DVec3::new(-8.0, -8.0, -4.1), DVec3::new(8.0, 8.0, -4.0), shining);
    let glowing = Material { base_color: Rgb::ZERO, emission: Rgb::ONE, ..Material::default() };
    add_box(&mut scene, DVec3::new(-2.0, -3.0, 3.0), DVec3::new(4.0, 3.0, 3.1), glowing);
    scene
}

/// A wall that stands on a sunlit floor fills the picture; `sunbeam` goes past it, or meets it too.
fn wall_on(floor: Material, sunbeam: DVec3) -> Scene {
    let mut scene = camera_at(DVec3::new(0.3, 1.9, -1.2));
    add_box(&mut scene, DVec3::new(-4.0, -0.1, -4.0), DVec3::new(4.0, 0.0, 4.0), floor);
    add_box(&mut scene, DVec3::new(-3.0, 0.0, -3.1), DVec3::new(3.0, 4.0, -3.0), matte(0.8, 0.0));
    // Something small, so that the wall is not in the innermost grid.
    add_box(&mut scene, DVec3::new(0.1, 0.8, 1.0), DVec3::new(0.5, 0.85, 1.4), matte(0.5, 0.0));
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, sunbeam, Rgb::splat(5.0));
    scene
}

/// A room of boards, seen from within. The sun shines on the wall to the left, and through the window that
/// its boards leave open.
fn boards() -> Scene {
    let mut scene = camera_at(DVec3::new(-0.5, 1.5, 2.5));
    for (low, high) in [
        ([-3.1, -0.1, -3.1], [3.1, 0.0, 3.1]),
        ([-3.1, 3.0, -3.1], [3.1, 3.1, 3.1]),
        ([-3.1, 0.0, -3.1], [3.1, 3.0, -3.0]),
        ([-3.1, 0.0, 3.0], [3.1, 3.0, 3.1]),
        ([3.0, 0.0, -3.0], [3.1, 3.0, 3.0]),
        ([-3.1, 0.0, -3.0], [-3.0, 1.0, 3.0]),
        ([-3.1, 2.2, -3.0], [-3.0, 3.0, 3.0]),
        ([-3.1, 1.0, -3.0], [-3.0, 2.2, -1.0]),
        ([-3.1, 1.0, 1.0], [-3.0, 2.2, 3.0]),
    ] {
        add_box(&mut scene, low.into(), high.into(), matte(0.6, 0.0));
    }
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::new(1.0, -0.5, -0.2), Rgb::splat(10.0));
    scene
}

/// A room with fog that two panels light, which glow to both sides, narrower than cells of the grid.
fn panels() -> Scene {
    let mut room = camera_at(DVec3::new(0.0, 0.0, 3.5));
    add_box(&mut room, DVec3::splat(-4.0), DVec3::splat(4.0), matte(0.5, 0.0));
    add_fog(&mut room, DVec3::splat(-4.0), DVec3::splat(4.0), Rgb::splat(0.05), Rgb::splat(0.9), 0.3);
    for (place, radiance) in [(DVec3::new(-1.5, 2.5, -2.0), 8.0), (DVec3::new(2.0, 0.0, -1.0), 20.0)] {
        room.materials.push(Material { emission: Rgb::splat(radiance), ..matte(0.0, 0.0) });
        let material = room.materials.len() - 1;
        let corners = [(-0.4, -0.2), (0.4, -0.2), (0.4, 0.2), (-0.4, 0.2)];
        let positions = corners.map(|(x, z)| (place + DVec3::new(x, 0.3 * x, z)).as_vec3()).to_vec();
        let triangles = [[0, 1, 2], [0, 2, 3]].map(|vertices| Triangle { vertices, material }).to_vec();
        room.meshes.push(Mesh { positions, triangles, ..Mesh::default() });
        add_instance(&mut room);
    }
    room
}

/// A hill in a mist that goes on beneath it, on all sides.
fn hill_in_mist() -> Scene {
    let mut scene = camera_at(DVec3::new(0.0, 1.5, 7.0));
    add_box(&mut scene, DVec3::new(-6.0, -2.0, -6.0), DVec3::new(6.0, 0.0, 6.0), matte(0.3, 0.0));
    add_layer(&mut scene, 0.0, 2.5, Rgb::splat(0.08), Rgb::splat(0.9), 0.3);
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::new(0.6, -0.6, 0.2), Rgb::splat(5.0));
    scene
}

/// Mist over a black plain that goes on beyond it, so that its light comes from a larger grid, under a sky
/// that ends at the horizon.
fn mist_on_a_plain() -> Scene {
    let mut scene = camera_at(DVec3::new(0.0, 1.5, 9.0));
    add_box(&mut scene, DVec3::new(-60.0, -0.1, -60.0), DVec3::new(60.0, 0.0, 60.0), matte(0.0, 0.0));
    add_fog(&mut scene, DVec3::new(-10.0, 0.0, -10.0), DVec3::splat(10.0), Rgb::splat(0.2), Rgb::ONE, 0.6);
    scene.sky = Sky::new(SkyPicture::Gradient { zenith: Rgb::ONE, horizon: Rgb::ONE, ground: Rgb::ZERO });
    scene
}

/// Leaves in mist that is thinner than a cell of their grid is high, over ground that goes on far beyond it.
fn morning_mist() -> Scene {
    let mut scene = camera_at(DVec3::new(0.0, 1.4, 9.0));
    add_box(&mut scene, DVec3::new(-90.0, -0.5, -90.0), DVec3::new(90.0, 0.0, 90.0), matte(0.3, 0.0));
    scene.materials.push(matte(0.3, 0.2));
    let material = scene.materials.len() - 1;
    let mut sampler = Sampler::new(5, 0, 0, 0);
    for _ in 0..300 {
        let middle =
            DVec3::new(24.0, 8.0, 24.0) * (DVec3::from(sampler.next_3d()) - DVec3::new(0.5, 0.0, 0.8));
        add_leaf(&mut scene, middle, (DVec3::from(sampler.next_3d()) - 0.5).normalize(), material);
    }
    add_layer(&mut scene, 0.0, 0.5, Rgb::splat(0.24), Rgb::splat(0.96), 0.5);
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::new(-0.4, -0.45, 0.8).normalize(), SUNLIGHT);
    scene.sky = Sky::new(SkyPicture::Gradient {
        zenith: Rgb::new(0.25, 0.45, 1.0),
        horizon: Rgb::new(0.8, 0.85, 0.9),
        ground: Rgb::new(0.1, 0.08, 0.05),
    });
    scene
}

/// Mist in a court whose walls shade a plain that is in the sun elsewhere.
fn court_in_mist() -> Scene {
    let mut scene = camera_at(DVec3::new(0.0, 1.0, 4.0));
    for (low, high) in [
        ([-90.0, -0.5, -90.0], [90.0, 0.0, 90.0]),
        ([-5.0, 0.0, -9.0], [-2.0, 9.0, 9.0]),
        ([2.0, 0.0, -9.0], [5.0, 9.0, 9.0]),
        ([-5.0, 0.0, -9.0], [5.0, 9.0, -6.0]),
        ([-5.0, 0.0, 6.0], [5.0, 9.0, 9.0]),
    ] {
        add_box(&mut scene, low.into(), high.into(), matte(0.5, 0.0));
    }
    add_layer(&mut scene, 0.0, 3.0, Rgb::splat(0.05), Rgb::splat(0.9), 0.3);
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::new(-0.6, -0.7, 0.2).normalize(), SUNLIGHT);
    scene.sky = Sky::new(EVEN_SKY);
    scene
}

/// A wall whose shadow falls beside it, into mist that is in the sun elsewhere.
fn wall_in_mist() -> Scene {
    let mut scene = camera_at(DVec3::new(0.0, 1.5, 4.0));
    for (low, high) in [([-90.0, -0.5, -90.0], [90.0, 0.0, 90.0]), ([-3.2, 0.0, -7.0], [-2.8, 4.0, 3.0])] {
        add_box(&mut scene, low.into(), high.into(), matte(0.3, 0.0));
    }
    add_layer(&mut scene, 0.0, 3.0, Rgb::splat(0.15), Rgb::splat(0.96), 0.3);
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::new(1.0, -1.0, 0.0).normalize(), SUNLIGHT);
    scene
}

/// Leaves in fog that is thin, but wide: grids about the leaves have to reach as far.
fn leaves_in_wide_fog() -> Scene {
    let mut scene = camera_at(DVec3::ZERO);
    add_leaves(&mut scene, 60, matte(0.4, 0.2));
    let half_m = DVec3::new(2500.0, 250.0, 2500.0);
    add_fog(&mut scene, -half_m, half_m, Rgb::splat(0.001), Rgb::splat(0.96), 0.5);
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::new(-0.4, -0.45, 0.8).normalize(), SUNLIGHT);
    scene.sky = Sky::new(EVEN_SKY);
    scene
}

/// Fog in a box that ends within cells, each of a third of an optical depth, under a sun alone.
fn deep_fog() -> Scene {
    let mut scene = camera_at(DVec3::ZERO);
    let (low, high) = (DVec3::new(-3.0, -2.0, -8.0), DVec3::new(3.0, 1.5, -2.0));
    add_fog(&mut scene, low, high, Rgb::splat(2.0), Rgb::splat(0.96), 0.5);
    let sunbeam = DVec3::new(-0.4, -0.8, 0.45).normalize();
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, sunbeam, Rgb::splat(3.0));
    scene
}

/// Even fog over ground that ends with it, wide and low, under a low sun.
fn slab() -> Scene {
    let mut scene = camera_at(DVec3::new(0.0, 1.5, 4.0));
    let low = DVec3::new(-15.0, -0.5, -15.0);
    add_box(&mut scene, low, DVec3::new(15.0, 0.0, 15.0), matte(0.3, 0.0));
    add_fog(&mut scene, low, DVec3::new(15.0, 0.8, 15.0), Rgb::splat(1.0), Rgb::splat(0.96), 0.5);
    let sunbeam = DVec3::new(0.8, -0.5, -0.3).normalize();
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, sunbeam, SUNLIGHT);
    scene
}

fn metal() -> Material {
    Material { base_color: Rgb::splat(0.9), ..with_coat(Coat { metallic: 1.0, ..coat(0.6) }) }
}

fn with_coat(coat: Coat) -> Material {
    Material { coat: Some(coat), ..Material::default() }
}

/// Two ways to one answer.
#[test]
fn the_grid_has_the_same_light() {
    let mut room = camera_at(DVec3::new(0.0, 0.0, 3.5));
    add_box(&mut room, DVec3::splat(-4.0), DVec3::splat(4.0), matte(0.6, 0.0));
    add_fog(&mut room, DVec3::splat(-4.0), DVec3::splat(4.0), Rgb::splat(0.05), Rgb::splat(0.9), 0.3);
    for (kind, beam, power) in [
        (LightKind::Sphere { radius: Track::from(0.3) }, DVec3::NEG_Y, 20.0),
        (
            LightKind::Area {
                shape: AreaShape::Rectangle,
                width: 1.0.into(),
                height: 0.5.into(),
                spread: PI.into(),
            },
            DVec3::new(0.2, -1.0, -0.3),
            60.0,
        ),
    ] {
        add_light(&mut room, kind, DVec3::new(0.5, 2.0, 0.0), beam, Rgb::splat(power));
    }
    let scenes = [
        ("leaves", sunny_leaves(), 8, 0.02),
        ("masses", masses(), 32, 0.06),
        ("room", room, 8, 0.03),
        // Walks find what glows by chance alone.
        ("shine", shine(Material { base_color: Rgb::ZERO, ..with_coat(coat(0.6)) }), 128, 0.06),
        ("shine of metal", shine(metal()), 128, 0.01),
        ("wall on a floor", wall_on(matte(0.6, 0.0), DVec3::new(-0.3, -1.0, 0.2)), 32, 0.03),
        ("wall on metal", wall_on(metal(), DVec3::new(-0.3, -1.0, -0.3)), 32, 0.03),
        ("boards", boards(), 128, 0.05),
        ("panels", panels(), 64, 0.05),
        ("hill in mist", hill_in_mist(), 16, 0.05),
        ("mist on a plain", mist_on_a_plain(), 32, 0.03),
        ("morning mist", morning_mist(), 16, 0.02),
        ("court in mist", court_in_mist(), 16, 0.04),
        ("wall in mist", wall_in_mist(), 16, 0.04),
        ("leaves in wide fog", leaves_in_wide_fog(), 16, 0.03),
        ("deep fog", deep_fog(), 16, 0.015),
        ("slab", slab(), 16, 0.03),
        ("even haze", haze(0.0), 8, 0.01),
        ("haze", haze(0.5), 8, 0.01),
        ("haze ahead", haze(0.8), 8, 0.02),
    ];
    for (name, scene, samples, tolerance) in scenes {
        for bounces in [Bounces::UpTo(1), Bounces::All] {
            let trees = MeshTrees::new(&scene);
            let exposure = Exposure::new(&scene, &trees, 0, 1.0, INSTANT);
            let grid = Indirect::new(&exposure, bounces, 1.0, &KeptLight::default(), &|| false);
            let on_grid =
                Transport { volume: VolumeMethod::Segments, indirect: grid.as_ref(), ..by_paths(bounces) };
            let (paths, error) = estimate(&scene, &by_paths(bounces), samples);
            let ratio = estimate(&scene, &on_grid, samples.min(64)).0 / paths;
            println!("{name}, {bounces}: grid / paths {ratio:.4} +- {:.4}", error / paths);
            let off = (ratio - 1.0).abs() - SIGMAS * error / paths;
            assert!(off.max_element() < tolerance, "{name}, {bounces}: {ratio}");
        }
    }
}

/// Indirect light from a grid over that of walks, where both have direct light too.
fn grid_by_paths(scene: &Scene, bounces: Bounces, direct: Rgb) -> Rgb {
    let trees = MeshTrees::new(scene);
    let exposure = Exposure::new(scene, &trees, 0, 1.0, INSTANT);
    let grid = Indirect::new(&exposure, bounces, 1.0, &KeptLight::default(), &|| false);
    let on_grid = Transport { volume: VolumeMethod::Segments, indirect: grid.as_ref(), ..by_paths(bounces) };
    let (paths, error) = estimate(scene, &by_paths(bounces), 256);
    let ratio = (estimate(scene, &on_grid, 16).0 - direct) / (paths - direct);
    println!("{bounces}: grid / paths {ratio:.4} +- {:.4}", error / (paths - direct));
    ratio
}

/// Ground reaches beyond the grid about the fog that it lights: what comes in from there was scattered as
/// often as it was, however many times are asked for.
#[test]
fn ground_lights_fog_from_beyond_its_grid() {
    let mut scene = camera_at(DVec3::ZERO);
    let middle = DVec3::new(0.0, 0.5, -5.0);
    add_fog(&mut scene, middle - 1.5, middle + 1.5, Rgb::splat(0.2), Rgb::ONE, 0.3);
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::new(0.3, -1.0, 0.4), Rgb::splat(5.0));
    add_box(&mut scene, DVec3::new(-12.0, -1.5, -17.0), DVec3::new(12.0, -1.0, 7.0), matte(0.9, 0.0));
    // What fog scatters of the sun is known.
    let of_sun = estimate(&scene, &by_paths(Bounces::NONE), 16).0;
    for bounces in [Bounces::UpTo(1), Bounces::UpTo(2), Bounces::UpTo(4), Bounces::All] {
        let ratio = grid_by_paths(&scene, bounces, of_sun);
        assert!((ratio - 1.0).abs().max_element() < 0.02, "{bounces}: {ratio}");
    }
}

/// Walks that branch off one camera ray are as bright as one, and their mean has less noise.
#[test]
fn branches_are_as_bright_as_one_walk() {
    let scene = leaves500();
    let snapshot = Snapshot::new(&scene, &MeshTrees::new(&scene), 0, 1.0, INSTANT);
    let mut scratch = Scratch::default();
    let mut means = |branches: Branches| -> Vec<[f64; 2]> {
        let of_seed = |seed| {
            let mut sum = [0.0; 2];
            for number in 0..1024 {
                let (x, y) = Sampler::new(seed, 0, 0, number).next_2d();
                let ray = snapshot.view.ray(x, y);
                let (mut sampler, light) = (Sampler::new(seed, 1, 0, number), Component::Indirect(branches));
                let transport = by_paths(Bounces::All);
                let sample = transport.radiance_of(light, &snapshot, &ray, &mut sampler, &mut scratch);
                sum[0] += sample.indirect.element_sum() / 1024.0;
                sum[1] += sample.indirect_shafts.element_sum() / 1024.0;
            }
            sum
        };
        (0..SEEDS).map(of_seed).collect()
    };
    let one = means(Branches::ONE);
    let many = means(Branches { at_surfaces: 4, in_fog: 8 });
    for (pass, most) in [(0, 0.7), (1, 0.5)] {
        let [(one, error), (many, less)] = [&one, &many].map(|means| {
            let count = f64::from(SEEDS);
            let mean = means.iter().map(|of_seed| of_seed[pass]).sum::<f64>() / count;
            let square: f64 = means.iter().map(|of_seed| (of_seed[pass] - mean).powi(2)).sum();
            (mean, (square / (count * (count - 1.0))).sqrt())
        });
        println!("pass {pass}: {one:.4} +- {error:.4}, branches {many:.4} +- {less:.4}");
        assert!((one - many).abs() < SIGMAS * error.hypot(less));
        assert!(less < most * error, "{less} is no less noise than {error}");
    }
}

/// A room that the sun enters through a hole.
fn sunlit_room() -> Scene {
    let mut scene = camera_at(DVec3::ZERO);
    let grey = || Material { base_color: Rgb::splat(0.7), ..Material::default() };
    for side in [-1.1, 1.0] {
        add_box(&mut scene, DVec3::new(side, -1.0, -1.0), DVec3::new(side + 0.1, 1.0, 1.0), grey());
        add_box(&mut scene, DVec3::new(-1.1, -1.0, side), DVec3::new(1.1, 1.0, side + 0.1), grey());
    }
    add_box(&mut scene, DVec3::new(-1.1, -1.1, -1.1), DVec3::new(1.1, -1.0, 1.1), grey());
    for [low, high] in [[-1.1, -0.1], [0.1, 1.1]] {
        add_box(&mut scene, DVec3::new(-1.1, 1.0, low), DVec3::new(1.1, 1.1, high), grey());
        add_box(&mut scene, DVec3::new(low, 1.0, -0.1), DVec3::new(high, 1.1, 0.1), grey());
    }
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::new(0.3, -1.0, 0.5), Rgb::splat(10.0));
    scene
}

/// Means and errors of a scene's indirect light by walks alone, and by walks that look for the sun by its
/// rays.
fn with_and_without_beams(scene: &Scene) -> [(Rgb, Rgb); 2] {
    let snapshot = Snapshot::new(scene, &MeshTrees::new(scene), 0, 1.0, INSTANT);
    let (transport, light) = (by_paths(Bounces::All), Component::Indirect(Branches::ONE));
    let of_seed = |seed, scratch: &mut Scratch| {
        let of_ray = |number| {
            let (x, y) = Sampler::new(seed, 0, 0, number).next_2d();
            let (ray, mut sampler) = (snapshot.view.ray(x, y), Sampler::new(seed, 1, 0, number));
            let sample = transport.radiance_of(light, &snapshot, &ray, &mut sampler, scratch);
            sample.indirect + sample.indirect_shafts
        };
        (0..1024).map(of_ray).sum::<Rgb>() / 1024.0
    };
    let means = |scratch: &mut Scratch| {
        mean_and_error(&(0..SEEDS).map(|seed| of_seed(seed, scratch)).collect::<Vec<_>>())
    };
    let mut first = Scratch::default();
    let by_walks = means(&mut first);
    let learned = Learned::of(&first.take_noted(), &snapshot);
    let by_beams = means(&mut Scratch::with_learned(Some(Arc::new(learned))));
    [by_walks, by_beams]
}

/// Walks that look for where the sun falls are as bright, with less noise.
#[test]
fn walks_that_look_for_the_sun_are_as_bright() {
    let [(expected, error), (found, less)] = with_and_without_beams(&sunlit_room());
    println!("by the sun's rays {found:.4} +- {less:.4}, by walks alone {expected:.4} +- {error:.4}");
    assert!((found - expected)[0].abs() < SIGMAS * error[0].hypot(less[0]), "{found} for {expected}");
    assert!(less[0] < 0.7 * error[0], "{less} is no less noise than {error}");
}

/// So are those that look for the shaft of the sun through fog.
#[test]
fn walks_that_look_for_shafts_are_as_bright() {
    let mut scene = sunlit_room();
    // What the sun falls on sends no light on.
    for lit in [3, 4] {
        scene.materials[lit].base_color = Rgb::ZERO;
    }
    let (low, high) = (DVec3::splat(-1.0), DVec3::splat(1.0));
    add_fog(&mut scene, low, high, Rgb::new(0.8, 0.4, 0.2), Rgb::splat(0.9), 0.4);
    let [(expected, error), (found, less)] = with_and_without_beams(&scene);
    println!("by shafts {found:.5} +- {less:.5}, by walks alone {expected:.5} +- {error:.5}");
    assert!((found - expected)[0].abs() < SIGMAS * error[0].hypot(less[0]), "{found} for {expected}");
    assert!(less[0] < 0.6 * error[0], "{less} for {error}");
}

/// Walks that eight rays share are as bright as walks of their own, in a room with thin fog.
#[test]
fn walks_that_rays_share_are_as_bright() {
    let mut scene = sunlit_room();
    let (low, high) = (DVec3::splat(-1.0), DVec3::splat(1.0));
    add_fog(&mut scene, low, high, Rgb::new(0.4, 0.2, 0.1), Rgb::splat(0.9), 0.4);
    let snapshot = Snapshot::new(&scene, &MeshTrees::new(&scene), 0, 1.0, INSTANT);
    let transport = by_paths(Bounces::All);
    let light = Component::Indirect(Branches { at_surfaces: 2, in_fog: 2 });
    let of_seed = |seed, shares: bool, scratch: &mut Scratch| {
        let mut sum = Rgb::ZERO;
        for group in 0..32 {
            let (mut through, mut roots): (Vec<Rgb>, Vec<Roots>) = (Vec::new(), Vec::new());
            for number in 8 * group..8 * (group + 1) {
                let (x, y) = Sampler::new(seed, 0, 0, number).next_2d();
                let (ray, mut sampler) = (snapshot.view.ray(x, y), Sampler::new(seed, 1, 0, number));
                scratch.share_walks(shares);
                let sample = transport.radiance_of(light, &snapshot, &ray, &mut sampler, scratch);
                sum += sample.indirect + sample.indirect_shafts;
                through.push(sample.transmittance);
                roots.push(scratch.take_roots());
            }
            for (through, [on_surface, in_fog]) in through.into_iter().zip(shared_light(&snapshot, &roots)) {
                sum += through * on_surface + in_fog;
            }
        }
        sum / 256.0
    };
    let mut first = Scratch::default();
    of_seed(SEEDS, false, &mut first);
    let learned = Arc::new(Learned::of(&first.take_noted(), &snapshot));
    let [(expected, error), (found, other)] = [false, true].map(|shares| {
        let mut scratch = Scratch::with_learned(Some(learned.clone()));
        mean_and_error(&(0..SEEDS).map(|seed| of_seed(seed, shares, &mut scratch)).collect::<Vec<_>>())
    });
    println!("shared {found:.4} +- {other:.4}, of their own {expected:.4} +- {error:.4}");
    assert!(found != expected, "nothing was shared");
    for channel in 0..3 {
        let off = (found - expected)[channel].abs();
        assert!(off < SIGMAS * error[channel].hypot(other[channel]), "{found} for {expected}");
    }
}

/// Nothing but plain ground and fog without bounds: the layers of these know nothing of a lamp.
#[test]
fn a_lamp_lights_fog_without_bounds() {
    let mut scene = camera_at(DVec3::new(0.0, 1.2, 5.0));
    add_box(&mut scene, DVec3::new(-90.0, -0.5, -90.0), DVec3::new(90.0, 0.0, 90.0), matte(0.3, 0.0));
    add_layer(&mut scene, 0.0, 1.0, Rgb::splat(0.3), Rgb::splat(0.9), 0.3);
    add_light(&mut scene, LightKind::Point, DVec3::new(0.5, 1.0, 0.0), DVec3::X, Rgb::splat(1.0));
    let of_lamp = estimate(&scene, &by_paths(Bounces::NONE), 16).0;
    for bounces in [Bounces::UpTo(1), Bounces::All] {
        let ratio = grid_by_paths(&scene, bounces, of_lamp);
        assert!((ratio - 1.0).abs().max_element() < 0.04, "{bounces}: {ratio}");
    }
}

/// In even light all that reflects everything is as bright as that, also a mirror that is seen in a metal.
#[test]
fn a_metal_shows_the_sky_in_a_mirror() {
    let mut scene = camera_at(DVec3::ZERO);
    let white = Material { base_color: Rgb::ONE, ..metal() };
    add_box(&mut scene, DVec3::new(-2.0, -2.0, -4.1), DVec3::new(2.0, 2.0, -4.0), white);
    let mirror = Material { base_color: Rgb::ZERO, mirror: Rgb::ONE, ..Material::default() };
    add_box(&mut scene, DVec3::new(-4.0, -4.0, 3.0), DVec3::new(4.0, 4.0, 3.1), mirror);
    scene.sky = Sky::new(EVEN_SKY);
    let trees = MeshTrees::new(&scene);
    let exposure = Exposure::new(&scene, &trees, 0, 1.0, INSTANT);
    let grid = Indirect::new(&exposure, Bounces::All, 1.0, &KeptLight::default(), &|| false);
    let on_grid =
        Transport { volume: VolumeMethod::Segments, indirect: grid.as_ref(), ..by_paths(Bounces::All) };
    let (mean, error) = estimate(&scene, &on_grid, 16);
    println!("a metal before a mirror: {mean:.4} +- {error:.4}");
    assert!(((mean - 1.0).abs() - SIGMAS * error).max_element() < 0.02, "{mean} +- {error}");
}

/// Blocks of 10x10 pixels differ from Mitsuba's by both renderers' noise alone, so that their
/// mean difference is none.
#[test]
fn leaves500_is_what_mitsuba_makes_of_it() {
    let scene = leaves500();
    for (name, bounces, first) in [("depth 3", Bounces::UpTo(1), 0), ("depth 16", Bounces::All, 6)] {
        let (mean, error) = truth(first).difference(&picture(&scene, bounces, Method::Paths));
        println!("{name}: {:.4} +- {:.4} of the mean", mean, error);
        assert!(error < 0.005, "{name}: {error} tells little");
        assert!(mean.abs() < SIGMAS * error, "{name}: {mean} +- {error}");
    }
}

#[test]
fn no_light_gets_through_the_walls_of_a_closed_room() {
    let (mean, _) = estimate(&dark_room(2.3), &by_paths(Bounces::All), 2);
    assert_eq!(mean, Rgb::ZERO);
}

/// There is more and more light, without end: it is cut off, and none of it is without a value.
#[test]
fn a_closed_room_that_absorbs_nothing_ends() {
    let mut scene = camera_at(DVec3::ZERO);
    add_box(&mut scene, DVec3::splat(-4.0), DVec3::splat(4.0), matte(1.0, 0.0));
    add_fog(&mut scene, DVec3::splat(-4.0), DVec3::splat(4.0), Rgb::splat(0.2), Rgb::ONE, 0.9);
    let once = (1, 1);
    for_each_sample(&scene, &by_paths(Bounces::All), once, |_, sample| {
        assert_eq!(sample.radiance, Rgb::ZERO, "there is no light");
    });
    add_light(&mut scene, LightKind::Point, DVec3::new(0.5, 2.0, 0.0), DVec3::NEG_Y, Rgb::ONE);
    let mut sum = Rgb::ZERO;
    for_each_sample(&scene, &by_paths(Bounces::All), once, |_, sample| sum += sample.radiance);
    let mean = sum / f64::from(RAYS * RAYS);
    assert!(mean.is_finite() && mean.min_element() > 1.0, "{mean}");
}

/// Indirect light and what is left without it: `--bounces 0`, to the bit where no random number decides; and
/// what fog scatters is among the shafts.
#[test]
fn passes_tell_the_shares() {
    let scene = sunny_leaves();
    let mut direct = Vec::new();
    for_each_sample(&scene, &by_paths(Bounces::NONE), (1, 4), |_, sample| direct.push(*sample));
    let mut number = 0;
    for_each_sample(&scene, &by_paths(Bounces::All), (1, 4), |_, sample| {
        let without = &direct[number];
        let rest = sample.radiance - sample.indirect - sample.indirect_shafts;
        assert!((rest - without.radiance).abs().max_element() < 1e-12, "{rest} {}", without.radiance);
        let shafts = sample.shafts - sample.indirect_shafts;
        assert!((shafts - without.shafts).abs().max_element() < 1e-12);
        assert!(sample.indirect.min_element() >= 0.0 && sample.indirect_shafts.min_element() >= 0.0);
        number += 1;
    });
    assert!(direct.iter().all(|sample| sample.indirect + sample.indirect_shafts == Rgb::ZERO));
}

/// A scene with a bit of everything.
fn everything() -> Scene {
    let mut scene = sunny_leaves();
    let clearcoat =
        Clearcoat { share: 1.0, texture: None, roughness: 0.3, roughness_texture: None, normal_map: None };
    let sheen =
        Sheen { color: Rgb::splat(0.5), color_texture: None, roughness: 0.5, roughness_texture: None };
    add_leaves(
        &mut scene,
        20,
        Material { clearcoat: Some(clearcoat), sheen: Some(sheen), ..matte(0.5, 0.0) },
    );
    for (_, material) in white_surfaces() {
        add_leaves(&mut scene, 20, Material { filter_color: Rgb::new(0.9, 0.5, 0.2), ..material });
    }
    scene.sky = Sky::new(SkyPicture::Gradient { zenith: Rgb::ONE, horizon: Rgb::X, ground: Rgb::splat(0.1) });
    add_light(
        &mut scene,
        LightKind::Sphere { radius: Track::from(0.2) },
        DVec3::new(0.5, 1.0, -5.0),
        DVec3::NEG_Y,
        Rgb::splat(5.0),
    );
    scene
}

fn small_job(method: Method, bounces: Bounces) -> Job {
    let size = Size { width: 32, height: 18 };
    Job {
        size,
        window: Window::whole(size),
        passes: vec![Pass::Indirect, Pass::IndirectShafts, Pass::Shafts, Pass::Transmittance],
        sampling: Sampling::Exactly(3),
        filter: PixelFilter::Box,
        seed: 5,
        mirror_depth: 3,
        bounces,
        method,
    }
}

fn small_frame(scene: &Scene, job: &Job) -> sunfleck::film::Frame {
    let trees = MeshTrees::new(scene);
    let exposure = Exposure::new(scene, &trees, 0, 32.0 / 18.0, INSTANT);
    render(&exposure, job, &Watch::NOBODY).frame
}

#[test]
fn without_bounces_it_is_the_picture_by_segments() {
    let scene = everything();
    let [segments, paths] = [Method::Segments, Method::Paths]
        .map(|method| small_frame(&scene, &small_job(method, Bounces::NONE)));
    assert_eq!(segments, paths);
    assert_ne!(segments, small_frame(&scene, &small_job(Method::Paths, Bounces::UpTo(1))));
}

#[test]
fn threads_do_not_reach_it() {
    let scene = everything();
    let by = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| small_frame(&scene, &small_job(Method::Paths, Bounces::All)))
    };
    let one = by(1);
    assert_eq!(one, by(2));
    assert_eq!(one, by(16));
    let is_finite = |frame: &sunfleck::film::Frame| {
        frame.channels.iter().all(|channel| channel.pixels.iter().all(|value| value.is_finite()))
    };
    assert!(is_finite(&one));
}
