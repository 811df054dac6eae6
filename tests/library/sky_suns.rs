//! Suns in pictures of the sky: apart from it they give the light that they gave in it, and that of a `Sun`.

use crate::common::{EXACT, INSTANT, add_fog, add_layer, add_light, camera_at, coat, place};
use glam::{DAffine3, DVec3};
use std::f64::consts::{PI, TAU};
use sunfleck::color::Rgb;
use sunfleck::film::Frame;
use sunfleck::math::{Ray, Sampler};
use sunfleck::render::{Job, Method, Watch, render};
use sunfleck::scene::{
    Bounces, Instance, LightKind, Material, Mesh, PixelFilter, Sampling, Scene, Size, Sky, SkyPicture,
    SunDisc, Texture, Track, Triangle, Window, Wrap,
};
use sunfleck::snapshot::{Exposure, MeshTrees, Snapshot};
use sunfleck::transport::{Scratch, radiance};

const SIZE: Size = Size { width: 32, height: 18 };
const AROUND: Rgb = Rgb::new(0.3, 0.4, 0.6);

fn to_sun() -> DVec3 {
    DVec3::new(0.5, 0.6, 0.4).normalize()
}

/// An even sky with a disc of 3 degrees in it.
fn sky() -> Sky {
    let (width, height) = (256, 128);
    let texel = |index: usize| {
        let (across, down) = ((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
        let ((sin_x, cos_x), (sin_y, cos_y)) =
            ((TAU * (across / width as f64 - 0.5)).sin_cos(), (PI * down / height as f64).sin_cos());
        let direction = DVec3::new(sin_y * sin_x, cos_y, -sin_y * cos_x);
        let is_sun = direction.angle_between(to_sun()) < 1.5_f64.to_radians();
        let [r, g, b] = if is_sun { [2400.0, 2000.0, 1400.0] } else { AROUND.as_vec3().to_array() };
        [r, g, b, 1.0]
    };
    let texels = (0..width * height).map(texel).collect::<Vec<_>>().into();
    let wrap = [Wrap::Repeat, Wrap::Clamp];
    Sky::new(SkyPicture::Image(Texture { name: String::new(), width, height, texels, wrap })).expect("a sky")
}

fn add_square(scene: &mut Scene, world_from_square: DAffine3, material: Material) {
    let node = place(scene, world_from_square);
    scene.materials.push(material);
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let material = scene.materials.len() - 1;
    scene.meshes.push(Mesh {
        positions: corners.map(|(x, z)| DVec3::new(x, 0.0, z).as_vec3()).to_vec(),
        triangles: [[0, 2, 1], [0, 3, 2]].map(|vertices| Triangle { vertices, material }).to_vec(),
        ..Mesh::default()
    });
    let (mesh, leaf_id) = (scene.meshes.len() - 1, scene.instances.len() as u32 + 1);
    scene.instances.push(Instance { node, mesh, material: None, leaf_id, deformation: None });
}

fn scaled(place: DVec3, size: f64) -> DAffine3 {
    DAffine3::from_translation(place) * DAffine3::from_scale(DVec3::splat(size))
}

/// A leaf over the ground in a mist, seen from where the sun is behind the eye.
fn glade(sky: Sky) -> Scene {
    let mut scene = camera_at(DVec3::new(0.0, 1.0, 0.0));
    let matte = |share: f64| Material {
        base_color: Rgb::new(share, 0.8 * share, 0.5 * share),
        ..Material::default()
    };
    add_square(&mut scene, scaled(DVec3::ZERO, 8.0), matte(0.4));
    let leaf = Material { transmission: Rgb::new(0.3, 0.35, 0.05), ..matte(0.3) };
    let turn = DAffine3::from_rotation_z(0.5) * DAffine3::from_rotation_x(0.4);
    add_square(&mut scene, DAffine3::from_translation(DVec3::new(0.3, 1.2, -3.0)) * turn, leaf);
    let half = DVec3::new(4.0, 2.0, 4.0);
    add_fog(&mut scene, DVec3::Y * 2.0 - half, DVec3::Y * 2.0 + half, Rgb::splat(0.1), Rgb::splat(0.95), 0.4);
    scene.sky = Some(sky);
    scene
}

/// The same in mist without bounds.
fn misty_glade(sky: Sky) -> Scene {
    let mut scene = glade(sky);
    scene.fogs.clear();
    add_layer(&mut scene, 0.0, 1.5, Rgb::splat(0.15), Rgb::splat(0.95), 0.4);
    scene
}

fn picture(scene: &Scene, samples: u32, method: Method) -> Frame {
    let trees = MeshTrees::new(scene);
    let exposure = Exposure::new(scene, &trees, 0, 16.0 / 9.0, INSTANT);
    let job = Job {
        size: SIZE,
        window: Window::whole(SIZE),
        passes: Vec::new(),
        sampling: Sampling::Exactly(samples),
        filter: PixelFilter::Box,
        seed: 3,
        mirror_depth: EXACT.mirror_depth,
        bounces: Bounces::All,
        method,
    };
    render(&exposure, &job, &Watch::NOBODY).frame
}

fn channel_of(frame: &Frame, name: &str) -> Vec<f64> {
    frame.channel(name).expect("a channel").pixels.iter().map(|value| f64::from(*value)).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Random walks are unbiased with the sun in the picture and beside it.
#[test]
fn walks_see_the_same_light_with_suns_in_the_sky_and_apart() {
    let [within, apart] =
        [sky(), sky().with_suns_apart()].map(|sky| picture(&glade(sky), 512, Method::Paths));
    for name in ["R", "G", "B"] {
        let ratio = mean(&channel_of(&apart, name)) / mean(&channel_of(&within, name));
        assert!((ratio - 1.0).abs() < 0.01, "{name}: {ratio}");
    }
}

/// An even sky and a `Sun` are what a picture of both becomes, pixel by pixel.
#[test]
fn a_sun_apart_is_a_sun() {
    for glade in [glade, misty_glade] {
        let apart = sky().with_suns_apart();
        let sun = apart.suns_at(0.0).next().expect("a sun");
        let mut beside = glade(Sky::new(SkyPicture::Even(AROUND)).expect("a sky"));
        let disc = SunDisc::even(Track::from(sun.angular_diameter));
        add_light(&mut beside, LightKind::SunDisc(disc), DVec3::ZERO, -sun.to_sun, sun.irradiance);
        let [apart, beside] = [glade(apart), beside].map(|scene| picture(&scene, 64, Method::Slices));
        for name in ["R", "G", "B"] {
            let [apart, beside] = [&apart, &beside].map(|frame| channel_of(frame, name));
            let ratio = mean(&apart) / mean(&beside);
            assert!((ratio - 1.0).abs() < 1e-3, "{name}: {ratio}");
            let square = |(a, b): (&f64, &f64)| (a - b).powi(2);
            let squares: Vec<f64> = apart.iter().zip(&beside).map(square).collect();
            // Points of the discs are not the same.
            assert!(mean(&squares).sqrt() < 0.01 * mean(&beside), "{name}: {}", mean(&squares).sqrt());
        }
    }
}

/// The camera and mirrors see the picture as it was, and what shines sees its sun once.
#[test]
fn what_is_seen_of_a_sky_stays_and_counts_once() {
    let seen = |sky: Sky, material: Option<Material>, to_eye: DVec3, samples: u32| {
        let mut scene = camera_at(DVec3::ZERO);
        if let Some(material) = material {
            add_square(&mut scene, scaled(-to_eye, 0.5), material);
        }
        scene.sky = Some(sky);
        let snapshot = Snapshot::new(&scene, &MeshTrees::new(&scene), 0, 1.0, INSTANT);
        let ray = Ray { origin: DVec3::ZERO, direction: -to_eye };
        let sample = |sample| {
            let mut sampler = Sampler::new(5, 0, 0, sample);
            radiance(&snapshot, &EXACT, &ray, &mut sampler, &mut Scratch::default()).radiance
        };
        (0..samples).map(sample).sum::<Rgb>() / f64::from(samples)
    };
    let mirrored = DVec3::new(-to_sun().x, to_sun().y, -to_sun().z);
    let mirror = Material { base_color: Rgb::ZERO, mirror: Rgb::splat(0.5), ..Material::default() };
    for (material, to_eye) in [(None, -to_sun()), (None, DVec3::Z), (Some(mirror), mirrored)] {
        let [within, apart] =
            [sky(), sky().with_suns_apart()].map(|sky| seen(sky, material.clone(), to_eye, 1));
        assert_eq!(within, apart, "{to_eye}");
        assert!(within.x > 0.0);
    }
    let shining = Material { base_color: Rgb::splat(0.2), coat: Some(coat(0.4)), ..Material::default() };
    let [within, apart] =
        [sky(), sky().with_suns_apart()].map(|sky| seen(sky, Some(shining.clone()), mirrored, 1 << 14));
    assert!(((apart / within) - 1.0).abs().max_element() < 0.01, "{within} {apart}");
}
