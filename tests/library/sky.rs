//! The sky as background and as light: against closed forms, furnaces and dense quadrature, and pictures
//! from slices against rays.

use crate::common::{EXACT, INSTANT, add_fog, add_layer, add_light, camera_at, place};
use glam::{DAffine3, DVec3};
use std::f64::consts::{FRAC_1_PI, PI, TAU};
use sunfleck::color::Rgb;
use sunfleck::film::Frame;
use sunfleck::fog::henyey_greenstein;
use sunfleck::math::{Ray, Sampler, gauss_legendre};
use sunfleck::passes::Pass;
use sunfleck::render::{Job, Method, Watch, render};
use sunfleck::scene::{
    Coat, Instance, Lens, LightKind, Material, Mesh, PixelFilter, Sampling, Scene, Size, Sky, SkyLight,
    SkyPicture, Texture, Triangle, Window, Wrap,
};
use sunfleck::snapshot::{Exposure, MeshTrees, Snapshot};
use sunfleck::transport::{Sample, Scratch, radiance};

const GREY: Rgb = Rgb::splat(2.0);
const GRADIENT: SkyPicture = SkyPicture::Gradient {
    zenith: Rgb::new(1.0, 2.0, 4.0),
    horizon: Rgb::new(3.0, 2.5, 2.0),
    ground: Rgb::new(0.3, 0.2, 0.1),
};

fn with_sky(mut scene: Scene, picture: SkyPicture) -> Scene {
    scene.sky = Sky::new(picture);
    scene
}

/// A square of `half` metres each way about a point, facing a unit vector, one edge as near
/// to x as that allows.
fn add_square(scene: &mut Scene, middle: DVec3, normal: DVec3, half: f64, material: Material) {
    let right = DVec3::X.reject_from_normalized(normal);
    let right = right.try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
    let up = normal.cross(right);
    let corner = |x: f64, y: f64| (middle + half * (x * right + y * up)).as_vec3();
    let node = place(scene, DAffine3::IDENTITY);
    scene.materials.push(material);
    let material = scene.materials.len() - 1;
    scene.meshes.push(Mesh {
        positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        triangles: [[0, 1, 2], [0, 2, 3]].map(|vertices| Triangle { vertices, material }).to_vec(),
        ..Mesh::default()
    });
    let (mesh, leaf_id) = (scene.meshes.len() - 1, scene.instances.len() as u32 + 1);
    scene.instances.push(Instance { node, mesh, material: None, leaf_id, deformation: None });
}

fn matte(albedo: f64) -> Material {
    Material { base_color: Rgb::splat(albedo), ..Material::default() }
}

/// The mean of so many samples of one camera ray.
fn seen(scene: &Scene, direction: DVec3, samples: u32) -> Sample {
    let snapshot = Snapshot::new(scene, &MeshTrees::new(scene), 0, 1.0, INSTANT);
    let ray = Ray { origin: DVec3::ZERO, direction: direction.normalize() };
    let mut mean = Sample::default();
    for sample in 0..samples {
        let mut sampler = Sampler::new(5, 0, 0, sample);
        let found = radiance(&snapshot, &EXACT, &ray, &mut sampler, &mut Scratch::default());
        mean.radiance += found.radiance / f64::from(samples);
        mean.shafts += found.shafts / f64::from(samples);
        mean.transmittance = found.transmittance;
        mean.alpha = found.alpha;
    }
    mean
}

fn assert_close(found: Rgb, expected: Rgb, tolerance: f64) {
    let error = ((found - expected) / expected).abs().max_element();
    assert!(error <= tolerance, "{found} {expected}: {error:.1e}");
}

/// Irradiance of a plane that faces up under the gradient: pi (horizon + 2 zenith) / 3.
fn irradiance_from_above() -> Rgb {
    let SkyPicture::Gradient { zenith, horizon, .. } = GRADIENT else { panic!("a gradient") };
    PI / 3.0 * (horizon + 2.0 * zenith)
}

#[test]
fn it_is_seen_behind_the_scene_through_the_fog() {
    let mut scene = with_sky(camera_at(DVec3::ZERO), GRADIENT);
    scene.sky.as_mut().expect("a sky").lights = SkyLight::Nothing;
    add_fog(&mut scene, DVec3::splat(-2.0), DVec3::splat(2.0), Rgb::new(0.1, 0.2, 0.3), Rgb::ONE, 0.0);
    let up = seen(&scene, DVec3::Y, 1);
    assert_close(up.radiance, Rgb::new(1.0, 2.0, 4.0) * (-2.0 * Rgb::new(0.1, 0.2, 0.3)).exp(), 1e-14);
    assert_eq!((up.alpha, up.shafts), (1.0, Rgb::ZERO));
    let mirror = Material { base_color: Rgb::ZERO, mirror: Rgb::splat(0.5), ..Material::default() };
    add_square(&mut scene, DVec3::NEG_Y, DVec3::Y, 50.0, mirror);
    scene.fogs.clear();
    let mirrored = seen(&scene, DVec3::new(0.0, -1.0, -1.0), 1).radiance;
    let SkyPicture::Gradient { zenith, horizon, .. } = GRADIENT else { panic!("a gradient") };
    assert_close(mirrored, 0.5 * horizon.lerp(zenith, 0.5_f64.sqrt()), 1e-12);
}

/// A sky that is the same everywhere lights an open Lambert plane exactly, by every single sample; a
/// gradient on average.
#[test]
fn an_open_plane_is_lit_by_its_half_of_the_sky() {
    let mut scene = with_sky(camera_at(DVec3::ZERO), SkyPicture::Even(GREY));
    add_square(&mut scene, DVec3::NEG_Y, DVec3::Y, 1e3, matte(0.4));
    let down = DVec3::new(0.1, -1.0, -0.3);
    assert_close(seen(&scene, down, 1).radiance, 0.4 * GREY, 1e-9);
    let scene = with_sky(scene, GRADIENT);
    assert_close(seen(&scene, down, 1 << 13).radiance, 0.4 * FRAC_1_PI * irradiance_from_above(), 2e-3);
}

/// Under a square at the height h with half sides a, whose form factor is known (Howell, configuration C-11,
/// times four): F = 4 / pi * X / sqrt(1 + X^2) atan(X / sqrt(1 + X^2)), X = a / h.
#[test]
fn a_roof_takes_its_form_factor_away() {
    let mut scene = with_sky(camera_at(DVec3::new(0.0, 1.0, 0.0)), SkyPicture::Even(GREY));
    add_square(&mut scene, DVec3::ZERO, DVec3::Y, 1e3, matte(0.4));
    // The eye stands below the roof.
    add_square(&mut scene, DVec3::new(0.0, 2.0, 0.0), DVec3::Y, 3.0, matte(0.0));
    let x = 1.5_f64;
    let root = (1.0 + x * x).sqrt();
    let factor = 4.0 / PI * x / root * (x / root).atan();
    let found = seen(&scene, DVec3::NEG_Y, 1 << 13).radiance;
    assert_close(found, 0.4 * GREY * (1.0 - factor), 3e-3);
}

/// A leaf that takes nothing away, and a white surface under a coat, cannot be told from the sky around them.
#[test]
fn white_furnace() {
    let coat = |f0: f64, roughness: f64| {
        let f0 = Rgb::splat(f0);
        Some(Coat { metallic: 0.0, roughness, texture: None, f0, f0_texture: None, f90: 1.0 })
    };
    let leaf = |share: f64, coat| Material {
        base_color: Rgb::splat(share),
        transmission: Rgb::splat(1.0 - share),
        coat,
        ..Material::default()
    };
    for (material, tolerance) in [
        (leaf(1.0, None), 1e-9),
        (leaf(0.0, None), 1e-9),
        (leaf(0.35, None), 1e-9),
        // As much as the table of albedos errs, and what so many directions do.
        (leaf(1.0, coat(0.04, 0.4)), 1e-3),
        (leaf(0.3, coat(0.04, 0.7)), 1e-3),
        (leaf(1.0, coat(0.3, 0.2)), 1e-3),
    ] {
        let mut scene = with_sky(camera_at(DVec3::ZERO), SkyPicture::Even(GREY));
        add_square(&mut scene, 3.0 * DVec3::NEG_Z, DVec3::Z, 9.0, material);
        assert_close(seen(&scene, DVec3::new(0.4, 0.3, -1.0), 1 << 12).radiance, GREY, tolerance);
    }
}

/// A leaf overhead: the ground's light on the near side, the gradient's through it, each in its colour.
#[test]
fn leaves_are_lit_from_both_sides() {
    let (albedo, transmission) = (Rgb::new(0.3, 0.2, 0.1), Rgb::new(0.5, 0.7, 0.2));
    let mut scene = with_sky(camera_at(DVec3::ZERO), GRADIENT);
    let material = Material { base_color: albedo, transmission, ..Material::default() };
    add_square(&mut scene, DVec3::Y, DVec3::Y, 1e3, material);
    let SkyPicture::Gradient { ground, .. } = GRADIENT else { panic!("a gradient") };
    let expected = albedo * ground + FRAC_1_PI * transmission * irradiance_from_above();
    assert_close(seen(&scene, DVec3::new(0.2, 1.0, 0.1), 1 << 14).radiance, expected, 2e-3);
}

/// Fog so thin that nothing is lost on the way scatters, per metre, sigma_s times the sky as the
/// phase function sees it.
#[test]
fn thin_fog_shows_the_mean_of_the_sky() {
    let sigma = 1e-7;
    let (albedo, length) = (Rgb::new(1.0, 0.5, 0.25), 3.0);
    let fog = |scene: &mut Scene, g: f64| {
        let (low, high) = (DVec3::new(-2.0, -2.0, -length), DVec3::new(2.0, 2.0, 0.0));
        add_fog(scene, low, high, Rgb::splat(sigma), albedo, g);
    };
    for g in [0.0, 0.7, -0.4] {
        let mut scene = with_sky(camera_at(DVec3::ZERO), SkyPicture::Even(GREY));
        fog(&mut scene, g);
        assert_close(seen(&scene, DVec3::NEG_Z, 1).shafts, sigma * length * albedo * GREY, 1e-6);
    }
    // Isotropic fog sees the mean over the sphere: half of it the ground, half (horizon + zenith) / 2.
    let mut scene = with_sky(camera_at(DVec3::ZERO), GRADIENT);
    fog(&mut scene, 0.0);
    let SkyPicture::Gradient { zenith, horizon, ground } = GRADIENT else { panic!("a gradient") };
    let mean = 0.5 * ground + 0.25 * (horizon + zenith);
    assert_close(seen(&scene, DVec3::NEG_Z, 1 << 13).shafts, sigma * length * albedo * mean, 2e-3);
}

/// Directions of the sphere on a Fibonacci lattice.
fn lattice(count: usize) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |number| {
        let y = 1.0 - (2.0 * number as f64 + 1.0) / count as f64;
        let (sin, cos) = (number as f64 * TAU * 0.618_033_988_749_895).sin_cos();
        DVec3::new(cos, 0.0, sin) * (1.0 - y * y).sqrt() + y * DVec3::Y
    })
}

/// Single scattering along a ray by quadrature over the ray and all directions, with the fog's depths as
/// `scene` has them and light wherever `lit` says so.
fn dense(scene: &Scene, direction: DVec3, g: f64, lit: impl Fn(DVec3) -> bool) -> Rgb {
    let snapshot = Snapshot::new(scene, &MeshTrees::new(scene), 0, 1.0, INSTANT);
    let (medium, sky) = (&snapshot.medium, snapshot.sky.expect("a sky"));
    let ray = Ray { origin: DVec3::ZERO, direction };
    let (start, end) = medium.range(&ray, f64::INFINITY).expect("fog");
    let (pieces, count) = (60, 3000);
    let half = 0.5 * (end - start) / f64::from(pieces);
    let mut sum = Rgb::ZERO;
    for piece in 0..pieces {
        for (node, weight) in gauss_legendre(3) {
            let t = start + half * (2.0 * f64::from(piece) + 1.0 + node);
            let point = ray.at(t);
            let mut arriving = Rgb::ZERO;
            for to_sky in lattice(count).filter(|&to_sky| lit(to_sky)) {
                let fog = medium.transmittance(point, to_sky, f64::INFINITY);
                arriving += sky.along(to_sky) * fog * henyey_greenstein(to_sky.dot(direction), g);
            }
            let arriving = arriving * 4.0 * PI / count as f64;
            let scattering = medium.scattering_at(point, 0.0) / henyey_greenstein(0.0, g);
            let seen = medium.transmittance(DVec3::ZERO, direction, t);
            sum += half * weight * scattering * arriving * seen;
        }
    }
    sum
}

/// Thick fog in a box, and fog that thins out with height, and a wall that keeps half of the sky away.
#[test]
fn fog_equals_dense_quadrature() {
    let (sigma_t, albedo, g) = (Rgb::new(0.3, 0.4, 0.5), Rgb::splat(0.8), 0.5);
    let direction = DVec3::new(0.3, 0.1, -1.0).normalize();
    let mut boxed = with_sky(camera_at(DVec3::ZERO), GRADIENT);
    add_fog(&mut boxed, DVec3::new(-3.0, -1.0, -6.0), DVec3::new(3.0, 4.0, -1.0), sigma_t, albedo, g);
    let expected = dense(&boxed, direction, g, |_| true);
    assert_close(seen(&boxed, direction, 1 << 14).shafts, expected, 3e-3);

    let mut layered = with_sky(camera_at(DVec3::new(0.0, 1.0, 0.0)), GRADIENT);
    add_layer(&mut layered, 0.5, 1.5, sigma_t, albedo, g);
    // The rule is too coarse for rays that leave the fog less steeply.
    let up = DVec3::new(0.3, 1.2, -1.0).normalize();
    let expected = dense(&layered, up, g, |_| true);
    assert_close(seen(&layered, up, 1 << 14).shafts, expected, 4e-3);

    // A wall at x = 0 beside the ray, so large that it takes away all directions to its far side.
    add_square(&mut boxed, DVec3::new(-0.1, 0.0, 0.0), DVec3::X, 1e4, matte(0.0));
    let expected = dense(&boxed, direction, g, |to_sky| to_sky.x > 0.0);
    assert_close(seen(&boxed, direction, 1 << 14).shafts, expected, 4e-3);
}

#[test]
fn the_switch_says_what_is_lit() {
    let mut scene = with_sky(camera_at(DVec3::ZERO), SkyPicture::Even(GREY));
    add_fog(&mut scene, DVec3::splat(-2.0), DVec3::splat(2.0), Rgb::splat(0.1), Rgb::ONE, 0.0);
    add_square(&mut scene, DVec3::NEG_Z, DVec3::Z, 9.0, matte(0.5));
    let mut lit = |lights| {
        scene.sky.as_mut().expect("a sky").lights = lights;
        let sample = seen(&scene, DVec3::NEG_Z, 16);
        (sample.radiance - sample.shafts != Rgb::ZERO, sample.shafts != Rgb::ZERO)
    };
    assert_eq!(lit(SkyLight::Nothing), (false, false));
    assert_eq!(lit(SkyLight::Surfaces), (true, false));
    assert_eq!(lit(SkyLight::SurfacesAndFog), (true, true));
}

const SIZE: Size = Size { width: 32, height: 18 };

fn picture(scene: &Scene, samples: u32, method: Method) -> Frame {
    let trees = MeshTrees::new(scene);
    let exposure = Exposure::new(scene, &trees, 0, 16.0 / 9.0, INSTANT);
    let (window, sampling) = (Window::whole(SIZE), Sampling::Exactly(samples));
    let passes = vec![Pass::Shafts, Pass::Transmittance];
    let job = Job {
        size: SIZE,
        window,
        passes,
        sampling,
        filter: PixelFilter::Box,
        seed: 3,
        mirror_depth: EXACT.mirror_depth,
        bounces: sunfleck::scene::Bounces::NONE,
        method,
    };
    render(&exposure, &job, &Watch::NOBODY).frame
}

/// From slices the sky is a picture of its own, added to those of the lights.
#[test]
fn slices_and_rays_see_the_same_picture() {
    let mut scene = with_sky(camera_at(DVec3::new(0.0, 1.0, 0.0)), GRADIENT);
    add_square(&mut scene, DVec3::ZERO, DVec3::Y, 20.0, matte(0.5));
    let leaf = Material { transmission: Rgb::new(0.3, 0.4, 0.1), ..matte(0.3) };
    add_square(&mut scene, DVec3::new(0.5, 1.6, -4.0), DVec3::new(0.3, 0.8, 0.5).normalize(), 1.0, leaf);
    add_fog(
        &mut scene,
        DVec3::new(-9.0, 0.0, -9.0),
        DVec3::new(9.0, 4.0, 9.0),
        Rgb::splat(0.1),
        Rgb::ONE,
        0.6,
    );
    let sun = DVec3::new(-0.3, -1.0, 0.4);
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, sun, Rgb::splat(6.0));
    add_light(&mut scene, LightKind::Point, DVec3::new(-1.0, 2.0, -3.0), sun, Rgb::splat(5.0));
    let [slices, rays] = [Method::Slices, Method::Segments].map(|method| picture(&scene, 256, method));
    for name in ["R", "G", "B", "A", "shafts.G", "transmittance.G"] {
        let [slices, rays] = [&slices, &rays].map(|frame| &frame.channel(name).expect("a channel").pixels);
        let sum = |pixels: &[f32]| pixels.iter().map(|&value| f64::from(value)).sum::<f64>();
        let ratio = sum(slices) / sum(rays);
        assert!((ratio - 1.0).abs() < 3e-3, "{name}: {ratio}");
        let square = |(a, b): (&f32, &f32)| f64::from(a - b).powi(2);
        let rmse = (slices.iter().zip(rays).map(square).sum::<f64>() / slices.len() as f64).sqrt();
        assert!(rmse < 0.03 * sum(rays) / rays.len() as f64, "{name}: {rmse}");
    }
}

/// Turned anticlockwise as seen from above: what was ahead (-Z) is at the left (-X).
#[test]
fn rotation_turns_the_picture_and_its_light() {
    let pixel = |index: usize| if index % 64 == 31 || index % 64 == 32 { [100.0; 4] } else { [0.0; 4] };
    let texture = Texture {
        name: String::new(),
        width: 64,
        height: 32,
        texels: (0..64 * 32).map(pixel).collect(),
        wrap: Default::default(),
    };
    let mut scene = with_sky(camera_at(DVec3::ZERO), SkyPicture::Image(texture));
    assert!(seen(&scene, DVec3::NEG_Z, 1).radiance.x > 50.0);
    scene.sky.as_mut().expect("a sky").rotation = (0.5 * PI).into();
    assert!(seen(&scene, DVec3::NEG_X, 1).radiance.x > 50.0);
    assert_eq!(seen(&scene, DVec3::NEG_Z, 1).radiance, Rgb::ZERO);
    // Squares that face the four ways: only the one that faces -X is lit by much.
    let lit = [DVec3::NEG_X, DVec3::X].map(|normal| {
        let mut scene = scene.clone();
        add_square(&mut scene, -normal, normal, 0.5, matte(0.5));
        seen(&scene, -normal, 256).radiance.x
    });
    assert!(lit[0] > 1.0 && lit[1] == 0.0, "{lit:?}");
}

#[test]
fn a_sky_costs_nothing_where_there_is_none() {
    let mut scene = camera_at(DVec3::ZERO);
    let snapshot =
        |scene: &Scene| Exposure::new(scene, &MeshTrees::new(scene), 0, 1.0, INSTANT).has_sky_light();
    assert!(!snapshot(&scene));
    scene = with_sky(scene, SkyPicture::Even(GREY));
    assert!(snapshot(&scene));
    scene.sky.as_mut().expect("a sky").strength = Rgb::ZERO.into();
    assert!(!snapshot(&scene));
}

/// The image of `tests/data/sky/make.py`: a slope, and a soft sun.
fn sloping_sky() -> SkyPicture {
    let (width, height) = (512, 256);
    let texel = |index: usize| {
        let (sin, cos) = (PI * (((index / width) as f64 + 0.5) / height as f64)).sin_cos();
        let across = TAU * (((index % width) as f64 + 0.5) / width as f64 - 0.5);
        let (x, y, z) = (sin * across.sin(), cos, -sin * across.cos());
        let sun = (80.0 * (0.48 * x + 0.6 * y - 0.64 * z - 1.0)).exp();
        let sky = [0.5 + 0.2 * x + 20.0 * sun, 0.6 + 0.2 * y + 16.0 * sun, 0.9 + 0.3 * z + 12.0 * sun, 1.0];
        sky.map(|value| value as f32)
    };
    let texels = (0..width * height).map(texel).collect();
    SkyPicture::Image(Texture {
        name: String::new(),
        width,
        height,
        texels,
        wrap: [Wrap::Repeat, Wrap::Clamp],
    })
}

/// Means over pixels and their standard errors, as Mitsuba 3 finds them (`tests/data/sky/make.py`).
#[test]
fn pixels_equal_those_of_mitsuba() {
    let found: serde_json::Value =
        serde_json::from_str(include_str!("../data/sky/mitsuba.json")).expect("JSON");
    let numbers = |scene: &str, key: &str| -> Vec<f64> {
        let pixels = found["scenes"][scene][key].as_array().expect("pixels").iter();
        pixels.flat_map(|pixel| pixel.as_array().expect("colours")).filter_map(|n| n.as_f64()).collect()
    };
    let size = Size { width: 6, height: 4 };
    for (name, picture, with_fog) in [
        ("constant", SkyPicture::Even(Rgb::new(0.8, 1.0, 1.4)), false),
        ("constant_fog", SkyPicture::Even(Rgb::new(0.8, 1.0, 1.4)), true),
        ("image", sloping_sky(), false),
        ("image_fog", sloping_sky(), true),
    ] {
        let mut scene = with_sky(camera_at(DVec3::new(0.0, 1.2, 4.0)), picture);
        scene.cameras[0].lens = Lens::Perspective { fov_y: (PI / 3.0).into() };
        let colored = |r, g, b| Material { base_color: Rgb::new(r, g, b), ..Material::default() };
        add_square(&mut scene, DVec3::ZERO, DVec3::Y, 20.0, colored(0.5, 0.4, 0.3));
        let tilted = DVec3::new(0.0, (PI / 3.0).sin(), 0.5);
        add_square(&mut scene, DVec3::new(0.7, 2.0, 0.0), tilted, 1.0, colored(0.2, 0.6, 0.3));
        if with_fog {
            let (low, high) = (DVec3::new(-6.0, -0.5, -6.0), DVec3::new(6.0, 4.5, 6.0));
            let (sigma_t, albedo) = (Rgb::new(0.1, 0.12, 0.15), Rgb::new(0.9, 0.8, 0.7));
            add_fog(&mut scene, low, high, sigma_t, albedo, 0.5);
        }
        let trees = MeshTrees::new(&scene);
        let exposure = Exposure::new(&scene, &trees, 0, 1.5, INSTANT);
        let pictures = [1, 2, 3, 4, 5, 6, 7, 8].map(|seed| {
            let job = Job {
                size,
                window: Window::whole(size),
                passes: vec![],
                sampling: Sampling::Exactly(1024),
                filter: PixelFilter::Box,
                seed,
                mirror_depth: EXACT.mirror_depth,
                bounces: sunfleck::scene::Bounces::NONE,
                method: Method::Segments,
            };
            render(&exposure, &job, &Watch::NOBODY).frame
        });
        let (means, errors) = (numbers(name, "mean"), numbers(name, "standard_error"));
        let (mut ours, mut theirs, mut squares) = (0.0, 0.0, 0.0);
        for (index, (mean, error)) in means.iter().zip(&errors).enumerate() {
            let values = pictures.each_ref().map(|picture| {
                let channel = picture.channel(["R", "G", "B"][index % 3]).expect("a colour");
                f64::from(channel.pixels[index / 3])
            });
            let value = values.iter().sum::<f64>() / 8.0;
            let own = values.iter().map(|v| (v - value).powi(2)).sum::<f64>() / (7.0 * 8.0);
            // What has no variance is off by no more than single precision.
            let variance = error * error + own + (1e-4 * mean).powi(2);
            let off = (value - mean).abs();
            assert!(off <= 6.0 * variance.sqrt(), "{name} {index}: {value} {mean} +- {error}");
            (ours, theirs, squares) = (ours + value, theirs + mean, squares + off * off / variance);
        }
        let (ratio, z) = (ours / theirs, (squares / means.len() as f64).sqrt());
        println!("{name}: mean ratio {ratio:.5}, root mean square of z {z:.2}");
        assert!((ratio - 1.0).abs() < 3e-3 && z < 1.5, "{name}: {ratio} {z}");
    }
}
