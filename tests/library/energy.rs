//! Nothing is gained and nothing lost: suns of every look against the parallel one, and leaves in light from
//! everywhere. Prints what it finds, with `--nocapture`.

use crate::common::{EXACT, INSTANT, add_light, sheet};
use glam::{DAffine3, DVec2, DVec3};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use sunfleck::color::Rgb;
use sunfleck::math::{Ray, Sampler};
use sunfleck::scene::{
    Coat, Julia, Light, LightKind, Material, SunDisc, SunPicture, SunShows, Texture, Track, Wrap,
};
use sunfleck::snapshot::{Luminaire, MeshTrees, Snapshot};
use sunfleck::transport::{Scratch, radiance};

/// c = -0.012375 + 0.56805i, the Julia set on the sun.
const C: (f64, f64) = (-0.012375, 0.56805);

fn suns() -> Vec<(&'static str, Option<SunPicture>)> {
    let julia = || SunShows::Julia(Julia { real: C.0.into(), imaginary: C.1.into(), iterations: 100 });
    let size = 100;
    let checks = |texel: usize| {
        if (texel % size / 10).is_multiple_of(2) { [1.0, 0.8, 0.5, 1.0] } else { [0.1, 0.1, 0.1, 1.0] }
    };
    let image = Texture {
        name: String::new(),
        width: size,
        height: size,
        texels: (0..size * size).map(checks).collect(),
        wrap: [Wrap::Clamp; 2],
    };
    vec![
        ("even", None),
        ("limb darkening 0.6", SunPicture::new(SunShows::Even, 0.6)),
        ("Julia set of -0.012375 + 0.56805i", SunPicture::new(julia(), 0.0)),
        ("Julia set, limb darkening 0.6", SunPicture::new(julia(), 0.6)),
        ("an image", SunPicture::new(SunShows::Image(Arc::new(image)), 0.0)),
    ]
}

/// A perpendicular plane gets from the disc, by its points and by what is seen of it, what it gets
/// from parallel light.
#[test]
fn a_disc_is_as_bright_as_parallel_light() {
    let power = Rgb::new(20.0, 18.0, 14.0);
    for (name, picture) in suns() {
        for diameter_deg in [0.53, 5.0_f64] {
            let disc = SunDisc {
                angular_diameter: diameter_deg.to_radians().into(),
                picture: picture.clone(),
                picture_rotation: 0.7.into(),
                visible_to_camera: true,
            };
            let kind = LightKind::SunDisc(disc);
            let light = Light { name: String::new(), node: 0, power: Track::from(power), kind };
            let sun = Luminaire::new(&light, DAffine3::IDENTITY, 0.0);
            // It shines along -Z.
            let count = 1 << 18;
            let (mut by_points, mut by_sight) = (Rgb::ZERO, Rgb::ZERO);
            let radius = (0.5 * diameter_deg.to_radians()).sin();
            for index in 0..count {
                // A pixel's points repeat after so many.
                let mut sampler = Sampler::new(1, index / Sampler::MAX_SAMPLES, 0, index);
                let (to_light, _, irradiance) = sun.point(sampler.next_3d()).arriving_at(DVec3::ZERO);
                by_points += irradiance * to_light.z / f64::from(count);
                // Uniform over the square around the disc's projection, where cos dw = dx dy.
                let (u, v) = sampler.next_2d();
                let place = radius * (2.0 * DVec2::new(u, v) - 1.0);
                let direction = place.extend((1.0 - place.length_squared()).sqrt());
                by_sight += sun.seen_along(direction) * 4.0 * radius * radius / f64::from(count);
            }
            let off = |found: Rgb| (found / power - 1.0).abs().max_element();
            let (points, sight) = (off(by_points), off(by_sight));
            println!("{name}, {diameter_deg} degrees: off by {points:.1e} by points, {sight:.1e} by sight");
            assert!(points < 1e-3 && sight < 1e-3, "{name}, {diameter_deg}: {points:.1e} {sight:.1e}");
        }
    }
}

/// What the eye sees in a direction from it, of suns with these irradiances.
fn seen(material: &Material, from_eye: DVec3, suns: &[(DVec3, f64)]) -> Rgb {
    let mut scene = sheet(material.clone());
    for &(to_sun, irradiance) in suns {
        add_light(&mut scene, LightKind::Sun, DVec3::ZERO, -to_sun, Rgb::splat(irradiance));
    }
    let snapshot = Snapshot::new(&scene, &MeshTrees::new(&scene), 0, 1.0, INSTANT);
    let ray = Ray { origin: DVec3::ZERO, direction: from_eye };
    radiance(&snapshot, &EXACT, &ray, &mut Sampler::new(0, 0, 0, 0), &mut Scratch::default()).radiance
}

fn leaf(albedo: f64, transmission: f64, roughness: Option<f64>) -> Material {
    let coat = |roughness| Coat {
        metallic: 0.0,
        roughness,
        texture: None,
        f0: Rgb::splat(0.04),
        f0_texture: None,
        f90: 1.0,
    };
    Material {
        base_color: Rgb::splat(albedo),
        transmission: Rgb::splat(transmission),
        coat: roughness.map(coat),
        ..Material::default()
    }
}

/// Where the eye and the sun change places, from the same side and through the leaf: the same share.
#[test]
fn light_goes_both_ways() {
    let ways = |cos: f64, angle: f64| (DVec2::from_angle(angle) * (1.0 - cos * cos).sqrt()).extend(cos);
    let mut largest = 0.0_f64;
    for (name, material) in [
        ("matte, 0.6 + 0.4", leaf(0.6, 0.4, None)),
        ("matte, 0.3 + 0.5", leaf(0.3, 0.5, None)),
        ("glossy, 0.6 + 0.4", leaf(0.6, 0.4, Some(0.5))),
        ("glossy, 0.3 + 0.5", leaf(0.3, 0.5, Some(0.35))),
    ] {
        for (a, b) in [
            (ways(0.9, 0.2), ways(0.3, 1.9)),
            (ways(0.5, 3.0), ways(-0.7, 1.0)),
            (ways(0.2, 5.0), ways(-1.0, 0.0)),
        ] {
            // The sheet looks the same from behind, so that an eye there is one here that
            // sees it turned about.
            let scattered = |to_eye: DVec3, to_sun: DVec3| {
                let flip = if to_eye.z < 0.0 { DVec3::new(1.0, 1.0, -1.0) } else { DVec3::ONE };
                seen(&material, -to_eye * flip, &[(to_sun * flip, 1.0)]).x / to_sun.z.abs()
            };
            let (there, back) = (scattered(a, b), scattered(b, a));
            largest = largest.max((there / back - 1.0).abs());
            assert!(there > 0.0 && (there / back - 1.0).abs() < 1e-12, "{name}: {there} {back}");
        }
    }
    println!("reciprocity of leaves: off by {largest:.1e} at most");
}

/// Suns all around with what each gives of a light that comes evenly from everywhere, dense where a coat
/// across z shines for this eye: on the eye's side by the microfacets that mirror them, which crowd about the
/// normal; behind on rings. All is the same on both sides of the plane through the eye and the normal.
fn suns_all_around(to_eye: DVec3) -> Vec<(DVec3, f64)> {
    let (across, up) = ((to_eye - to_eye.z * DVec3::Z).try_normalize().unwrap_or(DVec3::X), DVec3::Z);
    let side = up.cross(across);
    let (rings, steps) = (400, 40);
    let mut suns = Vec::new();
    for (ring, step) in (0..rings).flat_map(|ring| (0..steps).map(move |step| (ring, step))) {
        let root = (f64::from(ring) + 0.5) / f64::from(rings);
        let (sin, cos) = (PI * (f64::from(step) + 0.5) / f64::from(steps)).sin_cos();
        let towards = across * cos + side * sin;
        let theta = 0.5 * PI * root.powi(3);
        let half = towards * theta.sin() + up * theta.cos();
        let to_sun = 2.0 * to_eye.dot(half) * half - to_eye;
        if to_eye.dot(half) > 0.0 && to_sun.z > 0.0 {
            let of_halves = theta.sin() * 1.5 * PI * root * root / f64::from(rings) * TAU / f64::from(steps);
            suns.push((to_sun, 4.0 * to_eye.dot(half) * of_halves));
        }
        if ring % 10 == 0 {
            let height = (f64::from(ring) + 5.0) / f64::from(rings);
            let to_sun = towards * (1.0 - height * height).sqrt() - up * height;
            suns.push((to_sun, TAU * 10.0 / f64::from(rings * steps)));
        }
    }
    suns
}

/// Light from everywhere: what comes back to the eye is what falls on both sides, if the leaf takes nothing
/// away, however rough it is and however it is seen; else it is less.
#[test]
fn leaves_give_back_what_they_receive() {
    for cos in [1.0, 0.7, 0.3, 0.1, 0.04_f64] {
        let to_eye = DVec3::new(0.0, (1.0 - cos * cos).sqrt(), cos);
        let suns = suns_all_around(to_eye);
        for roughness in
            [None, Some(0.0), Some(0.08), Some(0.2), Some(0.35), Some(0.5), Some(0.75), Some(1.0)]
        {
            let given = |albedo, transmission| seen(&leaf(albedo, transmission, roughness), -to_eye, &suns).x;
            let (white, green) = (given(0.6, 0.4), given(0.3, 0.5));
            println!(
                "roughness {roughness:?}, seen at {cos}: {white:.5} of 0.6 + 0.4, {green:.5} of 0.3 + 0.5"
            );
            assert!((white - 1.0).abs() < 1e-3, "{roughness:?} {cos}: {white}");
            // A coat adds its own reflection to what is beneath.
            let added = if roughness.is_none() { 1e-3 } else { 0.2 };
            assert!(green > 0.799 && green < 0.8 + added, "{roughness:?} {cos}: {green}");
        }
    }
}
